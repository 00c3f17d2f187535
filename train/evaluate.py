"""The command ``ftac-evaluate``, for a checkout: see :mod:`ftac_gym.cli.evaluate`."""

from ftac_gym.cli.commands import evaluate

if __name__ == "__main__":
    evaluate()
