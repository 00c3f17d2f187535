"""What an agent sees, made from the measurement that the baselines get too.

A tier adds to the one before it: ``attitude`` (attitude, rate, own commands), ``telemetry`` (wheel momentum, sensor
status and vibration modes too) and ``oracle`` (the true faults; an upper bound, never a contestant).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from numba import njit

from ftac_gym.dynamics import Simulator
from ftac_gym.faults import FaultEffect, fault_effect
from ftac_gym.faults.table import LONGEST_DELAY
from ftac_gym.spacecraft.spacecraft import Spacecraft
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, require

TIERS = ("attitude", "telemetry", "oracle")

RATE_SCALE = 0.1
"""Rates are given in units of this [rad/s], accelerations in units of a tenth of it [rad/s^2]."""

FILTER_TIME = 1.0
"""Time constant of the low-passed residuals [s]."""

BOUND = 10.0
"""Scaled entries are clipped to this magnitude."""


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

    With e the vector part of the measured error quaternion (short way), w_e the measured rate error in body axes, and
    m wheels:

    ============================ ==== ==================================================================================
    ``attitude_error``           3    e
    ``attitude_error_fine``      3    tanh(20 e)
    ``attitude_error_finest``    3    tanh(400 e)
    ``rate_error``               3    w_e / 0.1 rad/s
    ``rate_error_fine``          3    tanh(200 w_e s/rad)
    ``last_command``             m    wheel command over torque limit
    ``model_residual``           3    low-passed J dw/dt + w x J w - D u over the mean torque limit, nominal J, D (with
                                      the stored wheel momentum in w x J w from the telemetry tier on)
    ``reference_rate``           3    moving references only: in body axes, / 0.1 rad/s
    ``reference_acceleration``   3    moving references only: in body axes, / 0.01 rad/s^2
    ``wheel_momentum``           m    telemetry: over its limit (over 1 N m s if unlimited)
    ``wheel_torque_residual``    m    telemetry: low-passed -dh/dt - u over the torque limit
    ``star_tracker_valid``       1    telemetry: 1, or 0 while the attitude is carried forward with the gyros
    ``modal_displacement``       k    telemetry, flexible craft only: vibration modes' displacements, over what the full
                                      torque of one wheel holds, nominally
    ``modal_rate``               k    likewise: their rates, over that times the nominal frequency
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
    """Return name, length and bound of each part that tells what the faults do to a craft with so many wheels."""
    return [
        ("fault_effectiveness", wheels, 1.0),
        ("fault_bias", wheels, BOUND),
        ("fault_delay", wheels, 1.0),
        ("sensor_rate_fault", 3, BOUND),
        ("sensor_attitude_fault", 3, math.pi),
    ]


def fault_entries(effect: FaultEffect, torque_limits: FloatArray) -> list[FloatArray]:
    """Return these parts for what the faults do to N craft, each (N, length); limits (wheels,) [N m]."""
    return [
        effect.effectiveness,
        np.clip(effect.bias / torque_limits, -BOUND, BOUND),
        effect.delay / LONGEST_DELAY,
        np.clip(effect.rate_bias / RATE_SCALE, -BOUND, BOUND),
        np.clip(effect.attitude_turn, -math.pi, math.pi),
    ]


class Observer:
    """Makes observations of N craft; its state is the filters behind the residuals.

    Parameters
    ----------
    simulator
        Where the measurements come from.
    tier
        Information tier.
    """

    def __init__(self, simulator: Simulator, tier: str) -> None:
        scenario = simulator.scenario
        self.layout = observation_layout(scenario, tier)
        self._simulator = simulator
        self._tier = TIERS.index(tier)
        wheels = scenario.spacecraft.wheels
        self._inertia = scenario.spacecraft.inertia_matrix
        self._axes = wheels.axis_matrix
        self._torque_limits = wheels.torque_limits
        self._momentum_scale = np.where(np.isfinite(wheels.momentum_limits), wheels.momentum_limits, 1.0)
        self._coupled = wheels.momentum_coupling
        self._moving = scenario.reference.moving
        self._period = scenario.control_period
        self._last_rate = np.zeros((simulator.num_spacecraft, 3))
        self._last_momentum = np.zeros((simulator.num_spacecraft, wheels.count))
        self._residual = np.zeros((simulator.num_spacecraft, 3))
        self._wheel_residual = np.zeros((simulator.num_spacecraft, wheels.count))
        self._wheels = wheels
        self._modal_scales = _modal_scales(scenario.spacecraft) if scenario.spacecraft.modes else None

    def observe(self, craft: npt.NDArray[np.int64], out: npt.NDArray[np.float32]) -> None:
        """Write the rows of the listed craft into ``out`` (N, size), once after each control period or reset."""
        simulator = self._simulator
        _observe(
            craft, simulator.ticks,
            simulator.measured_attitude, simulator.measured_rate, simulator.state.wheel_momentum,
            simulator.last_command, simulator.reference_attitude, simulator.reference_rate,
            simulator.reference_acceleration, self._inertia, self._axes, self._torque_limits, self._momentum_scale,
            self._coupled, self._moving, self._tier, self._period, self._last_rate, self._last_momentum, self._residual,
            self._wheel_residual, simulator.star_tracker_valid, out,
        )  # fmt: skip
        if self._modal_scales is not None and self._tier > 0:
            state = simulator.state
            for name, scale in zip(("modal_displacement", "modal_rate"), self._modal_scales, strict=True):
                values = getattr(state, name)[craft] / scale
                out[craft, self.layout.slices[name]] = np.clip(values, -BOUND, BOUND)
        if TIERS[self._tier] == "oracle":
            self._add_oracle(craft, out)

    def _add_oracle(self, craft: npt.NDArray[np.int64], out: npt.NDArray[np.float32]) -> None:
        simulator, state = self._simulator, self._simulator.state
        drawn, momentum = simulator.faults.take(craft), state.wheel_momentum[craft]
        effect = fault_effect(drawn, simulator.time[craft], self._wheels, momentum, state.wheel_torque[craft])
        parts = fault_parts(self._wheels.count)
        for (name, _, _), values in zip(parts, fault_entries(effect, self._torque_limits), strict=True):
            out[craft, self.layout.slices[name]] = values


def _modal_scales(spacecraft: Spacecraft) -> tuple[FloatArray, FloatArray]:
    """Return displacement and rate (k,) of each mode that count as one: what one wheel's full torque holds."""
    appendages, wheels = spacecraft.appendages, spacecraft.wheels
    assert appendages is not None
    limits = np.where(np.isfinite(wheels.torque_limits), wheels.torque_limits, 1.0)
    acceleration = np.linalg.norm(np.linalg.solve(spacecraft.inertia_matrix, wheels.axis_matrix * limits), axis=0).max()
    reach = np.maximum(np.linalg.norm(appendages.coupling_matrix, axis=1), 1e-3) * acceleration
    return reach / appendages.stiffness, reach / np.sqrt(appendages.stiffness)


@njit(cache=True, inline="always", error_model="numpy")
def _clip(value: float) -> float:
    return min(max(value, -BOUND), BOUND)


@njit(cache=True, inline="always", error_model="numpy")
def _tanh(value: float) -> float:
    """Hyperbolic tangent by one exponential: half the time of the library's, and exact to single precision."""
    if abs(value) > 20.0:
        return 1.0 if value > 0.0 else -1.0
    power = math.exp(2.0 * value)
    return (power - 1.0) / (power + 1.0)


@njit(cache=True, nogil=True, error_model="numpy")
def _observe(
    craft: Any,
    ticks: Any,
    attitude: Any,
    rate: Any,
    wheel_momentum: Any,
    command: Any,
    reference_attitude: Any,
    reference_rate: Any,
    reference_acceleration: Any,
    inertia: Any,
    axes: Any,
    torque_limits: Any,
    momentum_scale: Any,
    coupled: bool,
    moving: bool,
    tier: int,
    period: float,
    last_rate: Any,
    last_momentum: Any,
    residual: Any,
    wheel_residual: Any,
    star_tracker_valid: Any,
    out: Any,
) -> None:
    wheels = axes.shape[1]
    gain = 1.0 - math.exp(-period / FILTER_TIME)
    mean_limit = 0.0
    for j in range(wheels):
        mean_limit += torque_limits[j] / wheels
    for index in range(craft.shape[0]):
        i = craft[index]
        a, b, c, d = (
            reference_attitude[i, 0],
            -reference_attitude[i, 1],
            -reference_attitude[i, 2],
            -reference_attitude[i, 3],
        )
        p, x, y, z = attitude[i, 0], attitude[i, 1], attitude[i, 2], attitude[i, 3]
        scalar = a * p - b * x - c * y - d * z
        sign = 1.0 if scalar >= 0.0 else -1.0
        scalar *= sign
        ex = sign * (a * x + b * p + c * z - d * y)
        ey = sign * (a * y + c * p + d * x - b * z)
        ez = sign * (a * z + d * p + b * y - c * x)
        wx, wy, wz = rate[i, 0], rate[i, 1], rate[i, 2]
        if moving:
            # C(q_e) v = v - 2 q0 (e x v) + 2 e x (e x v)
            for vectors, column, scale in (
                (reference_rate, 0, RATE_SCALE),
                (reference_acceleration, 3, 0.1 * RATE_SCALE),
            ):
                vx, vy, vz = vectors[i, 0], vectors[i, 1], vectors[i, 2]
                cx, cy, cz = ey * vz - ez * vy, ez * vx - ex * vz, ex * vy - ey * vx
                vx += 2.0 * (ey * cz - ez * cy - scalar * cx)
                vy += 2.0 * (ez * cx - ex * cz - scalar * cy)
                vz += 2.0 * (ex * cy - ey * cx - scalar * cz)
                if column == 0:
                    wx, wy, wz = wx - vx, wy - vy, wz - vz
                first = 18 + wheels + column
                out[i, first], out[i, first + 1], out[i, first + 2] = (
                    _clip(vx / scale),
                    _clip(vy / scale),
                    _clip(vz / scale),
                )
        for k, (error, slip) in enumerate(((ex, wx), (ey, wy), (ez, wz))):
            out[i, k] = min(max(error, -1.0), 1.0)
            out[i, 3 + k] = _tanh(20.0 * error)
            out[i, 6 + k] = _tanh(400.0 * error)
            out[i, 9 + k] = _clip(slip / RATE_SCALE)
            out[i, 12 + k] = _tanh(200.0 * slip)

        tx, ty, tz = 0.0, 0.0, 0.0
        hx, hy, hz = 0.0, 0.0, 0.0
        telemetry = 18 + wheels + (6 if moving else 0)
        for j in range(wheels):
            out[i, 15 + j] = command[i, j] / torque_limits[j]
            tx += axes[0, j] * command[i, j]
            ty += axes[1, j] * command[i, j]
            tz += axes[2, j] * command[i, j]
            if tier > 0:
                momentum = wheel_momentum[i, j]
                if coupled:
                    hx += axes[0, j] * momentum
                    hy += axes[1, j] * momentum
                    hz += axes[2, j] * momentum
                if ticks[i] == 0:
                    wheel_residual[i, j] = 0.0
                else:
                    excess = (last_momentum[i, j] - momentum) / period - command[i, j]
                    wheel_residual[i, j] += gain * (excess - wheel_residual[i, j])
                last_momentum[i, j] = momentum
                out[i, telemetry + j] = _clip(momentum / momentum_scale[j])
                out[i, telemetry + wheels + j] = _clip(wheel_residual[i, j] / torque_limits[j])
        if tier > 0:
            out[i, telemetry + 2 * wheels] = 1.0 if star_tracker_valid[i] else 0.0

        if ticks[i] == 0:
            residual[i, 0], residual[i, 1], residual[i, 2] = 0.0, 0.0, 0.0
        else:
            # The rate in the middle of the period that the command was held.
            mx, my, mz = (
                0.5 * (rate[i, 0] + last_rate[i, 0]),
                0.5 * (rate[i, 1] + last_rate[i, 1]),
                0.5 * (rate[i, 2] + last_rate[i, 2]),
            )
            hx += inertia[0, 0] * mx + inertia[0, 1] * my + inertia[0, 2] * mz
            hy += inertia[1, 0] * mx + inertia[1, 1] * my + inertia[1, 2] * mz
            hz += inertia[2, 0] * mx + inertia[2, 1] * my + inertia[2, 2] * mz
            dx, dy, dz = (
                (rate[i, 0] - last_rate[i, 0]) / period,
                (rate[i, 1] - last_rate[i, 1]) / period,
                (rate[i, 2] - last_rate[i, 2]) / period,
            )
            rx = inertia[0, 0] * dx + inertia[0, 1] * dy + inertia[0, 2] * dz + my * hz - mz * hy - tx
            ry = inertia[1, 0] * dx + inertia[1, 1] * dy + inertia[1, 2] * dz + mz * hx - mx * hz - ty
            rz = inertia[2, 0] * dx + inertia[2, 1] * dy + inertia[2, 2] * dz + mx * hy - my * hx - tz
            residual[i, 0] += gain * (rx - residual[i, 0])
            residual[i, 1] += gain * (ry - residual[i, 1])
            residual[i, 2] += gain * (rz - residual[i, 2])
        for k in range(3):
            last_rate[i, k] = rate[i, k]
            out[i, 15 + wheels + k] = _clip(residual[i, k] / mean_limit)
