"""The command ``ftac-play``, for a checkout: see :mod:`ftac_gym.cli.play`."""

from ftac_gym.cli.commands import play

if __name__ == "__main__":
    play()
