"""Layout of the observation of an agent, which is made from the measurement that the baselines get too.

A tier adds to the one before it: ``attitude`` (attitude, rate, own commands), ``telemetry`` (wheel momentum, sensor
status and vibration modes too) and ``oracle`` (the true faults: a reference, never a policy to compare).
"""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ftac_gym.faults import FaultEffect
from ftac_gym.faults.table import LONGEST_DELAY
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, require

TIERS = ("attitude", "telemetry", "oracle")

RATE_SCALE = 0.1
"""Unit of the rates [rad/s]; accelerations have a tenth of it [rad/s^2]."""

BOUND = 10.0
"""Magnitude to which scaled entries are clipped."""


@dataclass(frozen=True)
class ObservationLayout:
    """Named slices of the observation.

    Attributes
    ----------
    slices
        Name to slice, in order.
    low, high
        Bounds (size,), float32.
    """

    slices: dict[str, slice]
    low: npt.NDArray[np.float32]
    high: npt.NDArray[np.float32]

    @property
    def size(self) -> int:
        """Number of entries."""
        return len(self.low)


def observation_layout(scenario: Scenario, tier: str) -> ObservationLayout:
    """Lay out the observation of a scenario and an information tier.

    Here e is the vector part of the measured error quaternion (short way), w_e the measured rate error in body axes.
    There are m wheels, and u is their command in effect over the last period, by the nominal loop delay.

    ============================ ==== ==================================================================================
    ``attitude_error``           3    e
    ``attitude_error_fine``      3    tanh(20 e)
    ``attitude_error_finest``    3    tanh(400 e)
    ``rate_error``               3    w_e / 0.1 rad/s
    ``rate_error_fine``          3    tanh(200 w_e s/rad)
    ``last_command``             m    wheel command given last, over torque limit
    ``model_residual``           3    low-passed J dw/dt + w x J w - D u over the mean torque limit, nominal J, D (with
                                      the stored wheel momentum in w x J w from the telemetry tier on)
    ``reference_rate``           3    moving references only: in body axes, / 0.1 rad/s
    ``reference_acceleration``   3    moving references only: in body axes, / 0.01 rad/s^2
    ``wheel_momentum``           m    telemetry: as measured, over its limit (over 1 N m s if unlimited)
    ``wheel_torque_residual``    m    telemetry: low-passed -dh/dt - u over the torque limit
    ``star_tracker_valid``       1    telemetry: 1, or 0 while the star tracker is out
    ``modal_displacement``       k    telemetry, flexible spacecraft only: vibration modes' displacements, over those
                                      that the full torque of one wheel holds, nominally
    ``modal_rate``               k    telemetry, flexible spacecraft only: their rates, over that displacement times
                                      the nominal frequency
    ``fault_effectiveness``      m    oracle: true effectiveness, 0 if locked or seized
    ``fault_bias``               m    oracle: true uncommanded torque over the torque limit, excess friction included
    ``fault_delay``              m    oracle: true delay of the commands over the longest one
    ``sensor_rate_fault``        3    oracle: rate that a sensor fault adds, / 0.1 rad/s
    ``sensor_attitude_fault``    3    oracle: rotation vector that a sensor fault adds [rad]
    ============================ ==== ==================================================================================

    Raises
    ------
    ValueError
        If the tier is unknown.
    """
    require(tier in TIERS, "observation", f"must be one of {list(TIERS)}", tier)
    wheels = scenario.spacecraft.wheels.count
    parts = [
        ("attitude_error", 3, 1.0),
        ("attitude_error_fine", 3, 1.0),
        ("attitude_error_finest", 3, 1.0),
        ("rate_error", 3, BOUND),
        ("rate_error_fine", 3, 1.0),
        ("last_command", wheels, 1.0),
        ("model_residual", 3, BOUND),
    ]
    if scenario.reference.moving:
        parts += [("reference_rate", 3, BOUND), ("reference_acceleration", 3, BOUND)]
    if tier != "attitude":
        parts += [("wheel_momentum", wheels, BOUND), ("wheel_torque_residual", wheels, BOUND)]
        parts += [("star_tracker_valid", 1, 1.0)]
        if modes := scenario.spacecraft.modes:
            parts += [("modal_displacement", modes, BOUND), ("modal_rate", modes, BOUND)]
    if tier == "oracle":
        parts += fault_parts(wheels)
    slices, start = {}, 0
    for name, length, _ in parts:
        slices[name] = slice(start, start + length)
        start += length
    high = np.concatenate([np.full(length, bound, dtype=np.float32) for _, length, bound in parts])
    return ObservationLayout(slices, -high, high)


def fault_parts(wheels: int) -> list[tuple[str, int, float]]:
    """Return name, length and bound of each part that describes the true effect of the faults."""
    return [
        ("fault_effectiveness", wheels, 1.0),
        ("fault_bias", wheels, BOUND),
        ("fault_delay", wheels, 1.0),
        ("sensor_rate_fault", 3, BOUND),
        ("sensor_attitude_fault", 3, math.pi),
    ]


def fault_entries(effect: FaultEffect, torque_limits: FloatArray) -> list[FloatArray]:
    """Return these parts for the effect of the faults on N spacecraft, each (N, length); limits (wheels,) [N m]."""
    return [
        effect.effectiveness,
        np.clip(effect.bias / torque_limits, -BOUND, BOUND),
        effect.delay / LONGEST_DELAY,
        np.clip(effect.rate_bias / RATE_SCALE, -BOUND, BOUND),
        np.clip(effect.attitude_turn, -math.pi, math.pi),
    ]
