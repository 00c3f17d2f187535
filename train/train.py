"""The command ``ftac-train``, for a checkout: see :mod:`ftac_gym.cli.train`."""

from ftac_gym.cli.commands import train

if __name__ == "__main__":
    train()
