"""Which baselines a test can fly."""

from ftac_gym import baselines


def fitting(scenario, oracles=True):
    """Names of the baselines that a scenario suits: some laws are for resting references or for three wheels."""
    names = []
    for name in baselines.names():
        try:
            information = baselines.make(name, scenario).information
        except ValueError:
            continue
        if oracles or information != "oracle":
            names.append(name)
    return names


def is_oracle(name, scenario):
    """Tell whether a baseline needs the truth."""
    return baselines.make(name, scenario).information == "oracle"
