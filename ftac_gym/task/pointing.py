"""Pointings for which the torque of a low orbit holds: an inertial attitude, or one that turns with the orbit.

:class:`~ftac_gym.task.low_orbit.LowOrbitTorque` is the torque of one attitude. The reference must stay near it.
"""

from __future__ import annotations

import math
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from ftac_gym.task.low_orbit import LowOrbitTorque
from ftac_gym.task.orbit import orbital_rate
from ftac_gym.task.references import MRPSinusoid, RateProfile, SetPoints
from ftac_gym.task.sampled_reference import SampledReference
from ftac_gym.utils.parameters import FloatArray, bounds, largest, require

if TYPE_CHECKING:
    from ftac_gym.task.scenario import Scenario

LARGEST_TILT = math.radians(10.0)
"""Limit of the angle between the reference and the attitude of the torque [rad].

At an angle a, torques that are linear in a direction (dipole, drag, sunlight) are wrong by at most 2 sin(a/2) of their
largest: 17 % at the limit. The gravity gradient is quadratic in one and wrong by at most 2 sin(a) of its largest: 35 %.
The causes are known less well. The residual dipole is known to a factor of ten, and the density changes by one of 15
between a quiet and an active sun at 400 km.
"""


def check_pointing(scenario: Scenario) -> None:
    """Check that the reference fits every torque of a low orbit.

    Raises
    ------
    ValueError
        If the reference leaves the attitude of a torque by more than :data:`LARGEST_TILT`.
    """
    limit, reference = math.degrees(LARGEST_TILT), scenario.reference
    for path, torque in scenario.external_torque.paths:
        if not isinstance(torque, LowOrbitTorque):
            continue
        if torque.turning:
            fits = isinstance(reference, (RateProfile, SampledReference))
            rule = f"must be a RateProfile or SampledReference at the orbital rate, since {path}.nadir is given"
            require(fits, "reference", rule, type(reference).__name__)
            tilt = _from_orbit(scenario, torque)
            rule = f"must turn at the orbital rate about {path}.orbit_normal, to {limit:g} deg; in the end it is off by"
        else:
            tilt = _from_inertial(scenario)
            rule = (
                f"must stay within {limit:g} deg of one attitude for the LowOrbitTorque in {path}, which needs nadir "
                "and orbit_normal if the reference turns with the orbit; it turns by"
            )
        # To 0.01 deg, which the message shows.
        require(tilt <= LARGEST_TILT + 1e-4, "reference", rule, round(math.degrees(tilt), 2))


def _from_inertial(scenario: Scenario) -> float:
    """Return a bound on the angle of the reference from one inertial attitude [rad]; set points have no such angle."""
    reference = scenario.reference
    if isinstance(reference, SetPoints):
        return 0.0
    if isinstance(reference, SampledReference):
        attitudes = np.array(reference.attitudes)
        return float(2.0 * np.arccos(np.minimum(np.abs(attitudes @ attitudes[0]), 1.0)).max())
    turn = reference.largest_rate * scenario.duration
    if isinstance(reference, MRPSinusoid):
        # A change of the parameters turns by four times its size at most.
        turn = min(turn, 4.0 * math.hypot(*map(largest, reference.amplitude)))
    return turn


def _from_orbit(scenario: Scenario, torque: LowOrbitTorque) -> float:
    """Return a bound on the angle by which the reference leaves one that turns with the orbit [rad]."""
    rates, normal = _rates(scenario), np.array(torque.orbit_normal)
    apart = [np.linalg.norm(rates - orbital_rate(height) * normal, axis=1).max() for height in bounds(torque.altitude)]
    return float(max(apart)) * scenario.duration


def _rates(scenario: Scenario) -> FloatArray:
    """Return extreme rates of the reference in its own axes (K, 3) [rad/s]."""
    reference = scenario.reference
    if isinstance(reference, SampledReference):
        return reference.motion(np.linspace(0.0, scenario.duration, 1001))[1]
    assert isinstance(reference, RateProfile)
    ends = [
        (bounds(constant)[0] - largest(amplitude), bounds(constant)[1] + largest(amplitude))
        for constant, amplitude in zip(reference.constant, reference.amplitude, strict=True)
    ]
    return np.array(list(product(*ends)))
