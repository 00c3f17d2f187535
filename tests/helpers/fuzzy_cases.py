"""Fuzzy observers along given rates and commands."""

import numpy as np
from helpers.observed import seen

from ftac_gym import scenarios
from ftac_gym.baselines import observers, synthesis
from ftac_gym.baselines.memory import Memory

LI, FLEXIBLE = (scenarios.get(name) for name in ("li_2023", "flexible"))


def gains_of(design, spacecraft=LI.spacecraft):
    return synthesis.gains(spacecraft, design).observer


def make(scenario, count=1, **options):
    memory = Memory(count)
    return observers.make("fafeo", scenario, memory, **options), memory


def watched(scenario, rates, commands, **options):
    """f^ and the torque of vibration (T, N, 6) that the package's observer makes of rates and commands (T, N, .)."""
    observer, _ = make(scenario, rates.shape[1], **options)
    results = []
    for rate, command in zip(rates, commands, strict=True):
        estimate = observer.update(seen(rate, command), command, scenario.control_period)
        results.append(np.concatenate([estimate.disturbance, estimate.vibration], axis=1))
    return np.array(results)
