"""The command ``ftac-convert``, for a checkout: see :mod:`ftac_gym.cli.convert`."""

from ftac_gym.cli.commands import convert

if __name__ == "__main__":
    convert()
