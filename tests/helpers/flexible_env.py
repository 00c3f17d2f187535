"""Environments with vibrating appendages."""

from dataclasses import replace

import ftac_gym  # noqa: F401  registers the environments
from ftac_gym import scenarios

IDS = {"SpacecraftFTCFlexible-v0": "flexible", "SpacecraftFTCLi2023-v0": "li_2023"}
TIERS = ("attitude", "telemetry", "oracle")
MODAL = ("modal_displacement", "modal_rate")
SHORT = scenarios.get("flexible").replace(duration=10.0)


def shaken(scenario, swing=0.05):
    """Return a scenario whose modes are stirred at the start."""
    start = replace(scenario.initial_state, modal_displacement=((-0.05, 0.05),) * 4, modal_rate=((-swing, swing),) * 4)
    return scenario.replace(initial_state=start)
