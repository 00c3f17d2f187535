"""The command ``ftac-reproduce``, for a checkout: see :mod:`ftac_gym.cli.reproduce`."""

from ftac_gym.cli.commands import reproduce

if __name__ == "__main__":
    reproduce()
