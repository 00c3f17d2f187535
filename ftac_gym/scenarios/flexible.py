"""The flexible spacecraft: the flagship's task for a body with two long panels that bend.

The hub and its wheels are the flagship's. The panels lie along the first axis: their bending couples with turns about
the other two, their torsion with turns about the first. They hold an eighth to a sixth of the inertia. Their damping is
low: the vibration after a slew outlasts the episode unless it is controlled. Frequencies, damping and
coupling of each spacecraft differ from the nominal ones. The numbers are ours; shares and damping are like those of
Li et al. 2023.
"""

from dataclasses import replace

from ftac_gym.scenarios.flagship import flagship
from ftac_gym.spacecraft import FlexibleAppendages
from ftac_gym.task import AppendageUncertainty, RewardWeights, Scenario


def appendages() -> FlexibleAppendages:
    """Return the nominal panels: bending out of their plane and in it, torsion, and the second bending."""
    return FlexibleAppendages(
        frequencies=(1.2, 2.1, 3.4, 5.2),  # rad/s
        damping_ratios=0.005,
        coupling=((0.15, 1.70, 0.10), (-0.10, 0.12, 1.90), (0.95, -0.08, 0.05), (0.05, 0.70, -0.12)),  # kg^1/2 m
    )


def flexible() -> Scenario:
    """Return the scenario of ``SpacecraftFTCFlexible-v0``."""
    base = flagship()
    return base.replace(
        name="flexible",
        spacecraft=replace(base.spacecraft, appendages=appendages()),
        appendage_uncertainty=AppendageUncertainty(frequency=(0.8, 1.2), damping=(0.5, 2.0), coupling=(0.8, 1.2)),
        reward=RewardWeights(vibration=0.2),
    )
