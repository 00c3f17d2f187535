"""The command ``ftac-synthesize``, for a checkout: see :mod:`ftac_gym.cli.synthesize`."""

from ftac_gym.cli.commands import synthesize

if __name__ == "__main__":
    synthesize()
