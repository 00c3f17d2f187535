"""The command ``ftac-tune``, for a checkout: see :mod:`ftac_gym.cli.tune`."""

from ftac_gym.cli.commands import tune

if __name__ == "__main__":
    tune()
