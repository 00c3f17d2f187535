"""The command ``ftac-study``, for a checkout: see :mod:`ftac_gym.cli.study`."""

from ftac_gym.cli.commands import study

if __name__ == "__main__":
    study()
