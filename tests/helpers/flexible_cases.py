"""Scenarios and measurements for the controllers of flexible spacecraft."""

import numpy as np

from ftac_gym import scenarios
from ftac_gym.spacecraft.spacecraft import Spacecraft
from ftac_gym.spacecraft.wheel_array import WheelArray
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.references import RateProfile

LI, FLEXIBLE = (scenarios.get(name) for name in ("li_2023", "flexible"))
MOVING = RateProfile(amplitude=(0.05, 0.05, 0.05), frequency=(0.5, 0.8, 1.1))


def free(reference=MOVING, limit=1e6):
    """The paper's spacecraft with wheels that are never at their limit."""
    spacecraft = LI.spacecraft
    wheels = WheelArray(spacecraft.wheels.axes, limit, momentum_coupling=False)
    return LI.replace(
        spacecraft=Spacecraft(spacecraft.inertia, wheels, appendages=spacecraft.appendages), reference=reference
    )


def unit(rng, count):
    q = rng.normal(size=(count, 4))
    return q / np.linalg.norm(q, axis=1, keepdims=True)


def drawn(scenario, seed, count=6, rate=0.3, turn=None):
    """A measurement of spacecraft anywhere, with a reference anywhere; one at rest has no rate."""
    rng, wheels = np.random.default_rng(seed), scenario.spacecraft.wheels.count
    moves = float(scenario.reference.moving)
    target, attitude = unit(rng, count), unit(rng, count)
    if turn is not None:
        attitude = target + turn * attitude
        attitude /= np.linalg.norm(attitude, axis=1, keepdims=True)
    return Measurement(
        np.zeros(count), attitude, rate * rng.uniform(-1.0, 1.0, (count, 3)), np.zeros((count, wheels)),
        rng.normal(size=(count, wheels)), np.ones(count, bool), target,
        moves * 0.1 * rng.normal(size=(count, 3)), moves * 0.1 * rng.normal(size=(count, 3)),
    )  # fmt: skip


def each(measurement):
    """(q, w, (q_d, w_d, w_d')) of each spacecraft."""
    given = measurement
    return [
        (q, w, reference)
        for q, w, *reference in zip(
            given.attitude, given.rate, given.reference_attitude, given.reference_rate, given.reference_acceleration,
            strict=True,
        )
    ]  # fmt: skip
