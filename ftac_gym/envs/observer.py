"""Compiled observations of N spacecraft, with the filters behind their residuals."""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from ftac_gym.dynamics import Simulator
from ftac_gym.envs import observation
from ftac_gym.envs.observation import BOUND, RATE_SCALE, TIERS, fault_entries, fault_parts, observation_layout
from ftac_gym.faults import fault_effect
from ftac_gym.spacecraft.spacecraft import Spacecraft
from ftac_gym.utils import algebra
from ftac_gym.utils.algebra import add3, relative_quaternion, rotation_change, row3, scale3
from ftac_gym.utils.compiling import entry_point, inlined
from ftac_gym.utils.parameters import FloatArray

FILTER_TIME = 1.0
"""Time constant of the low-passed residuals [s]."""


class Observer:
    """Observations of N spacecraft; the state is that of the filters.

    Parameters
    ----------
    simulator
        Source of the measurements.
    tier
        Information tier.
    """

    def __init__(self, simulator: Simulator, tier: str) -> None:
        scenario, count = simulator.scenario, simulator.num_spacecraft
        wheels = scenario.spacecraft.wheels
        self.layout = observation_layout(scenario, tier)
        self._simulator, self._wheels, self._tier = simulator, wheels, TIERS.index(tier)
        self._constants = (
            scenario.spacecraft.inertia_matrix,
            wheels.axis_matrix,
            wheels.torque_limits,
            np.where(np.isfinite(wheels.momentum_limits), wheels.momentum_limits, 1.0),
            wheels.momentum_coupling,
            scenario.reference.moving,
            self._tier,
            scenario.control_period,
        )
        # The last rate and wheel momentum, and both residuals.
        self._filters = tuple(np.zeros((count, width)) for width in (3, wheels.count, 3, wheels.count))
        self._modal_scales = _modal_scales(scenario.spacecraft) if scenario.spacecraft.modes else None

    def observe(self, rows: npt.NDArray[np.int64], out: npt.NDArray[np.float32]) -> None:
        """Write the listed rows of ``out`` (N, size), once after each control period or reset."""
        simulator, state = self._simulator, self._simulator.state
        _observe(
            rows, simulator.ticks, simulator.measured_attitude, simulator.measured_rate,
            simulator.measured_wheel_momentum, simulator.last_command, simulator.command_in_effect,
            simulator.reference_attitude, simulator.reference_rate, simulator.reference_acceleration,
            simulator.star_tracker_valid, *self._constants, *self._filters, out,
        )  # fmt: skip
        if self._modal_scales is not None and self._tier > 0:
            for name, scale in zip(("modal_displacement", "modal_rate"), self._modal_scales, strict=True):
                values = getattr(simulator, f"measured_{name}")[rows] / scale
                out[rows, self.layout.slices[name]] = np.clip(values, -BOUND, BOUND)
        if TIERS[self._tier] == "oracle":
            faults, momentum = simulator.faults.take(rows), state.wheel_momentum[rows]
            effect = fault_effect(faults, simulator.time[rows], self._wheels, momentum, state.wheel_torque[rows])
            entries = fault_entries(effect, self._wheels.torque_limits)
            for (name, _, _), values in zip(fault_parts(self._wheels.count), entries, strict=True):
                out[rows, self.layout.slices[name]] = values


def _modal_scales(spacecraft: Spacecraft) -> tuple[FloatArray, FloatArray]:
    """Return displacement and rate (k,) of each mode that count as one: those that one wheel's full torque holds."""
    appendages, wheels = spacecraft.appendages, spacecraft.wheels
    assert appendages is not None
    limits = np.where(np.isfinite(wheels.torque_limits), wheels.torque_limits, 1.0)
    acceleration = np.linalg.norm(np.linalg.solve(spacecraft.inertia_matrix, wheels.axis_matrix * limits), axis=0).max()
    reach = np.maximum(np.linalg.norm(appendages.coupling_matrix, axis=1), 1e-3) * acceleration
    return reach / appendages.stiffness, reach / np.sqrt(appendages.stiffness)


@inlined
def _clip(value: float) -> float:
    return min(max(value, -BOUND), BOUND)


@inlined
def _tanh(value: float) -> float:
    """Return the hyperbolic tangent by one exponential: half the library's time, exact to single precision."""
    if abs(value) > 20.0:
        return 1.0 if value > 0.0 else -1.0
    power = math.exp(2.0 * value)
    return (power - 1.0) / (power + 1.0)


@inlined
def _times(matrix: Any, a: Any) -> Any:
    """Return the product of a matrix (3, 3) and a triple."""
    return (
        matrix[0, 0] * a[0] + matrix[0, 1] * a[1] + matrix[0, 2] * a[2],
        matrix[1, 0] * a[0] + matrix[1, 1] * a[1] + matrix[1, 2] * a[2],
        matrix[2, 0] * a[0] + matrix[2, 1] * a[1] + matrix[2, 2] * a[2],
    )


@entry_point(algebra, observation, contract=False)
def _observe(
    rows: Any,
    ticks: Any,
    attitude: Any,
    rate: Any,
    wheel_momentum: Any,
    command: Any,
    in_effect: Any,
    reference_attitude: Any,
    reference_rate: Any,
    reference_acceleration: Any,
    star_tracker_valid: Any,
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
    out: Any,
) -> None:
    """Write all entries but those of modes and faults; the columns are those of :func:`observation_layout`."""
    wheels = axes.shape[1]
    gain = 1.0 - math.exp(-period / FILTER_TIME)
    mean_limit = 0.0
    for j in range(wheels):
        mean_limit += torque_limits[j] / wheels
    for index in range(rows.shape[0]):
        i = rows[index]
        relative = relative_quaternion(reference_attitude, attitude, i)
        sign = 1.0 if relative[0] >= 0.0 else -1.0
        scalar, error = sign * relative[0], (sign * relative[1], sign * relative[2], sign * relative[3])
        now = row3(rate, i)
        rate_error = now
        if moving:
            desired = row3(reference_rate, i)
            desired = add3(desired, 1.0, rotation_change(scalar, error, desired))
            rate_error = add3(now, -1.0, desired)
            ahead = row3(reference_acceleration, i)
            ahead = add3(ahead, 1.0, rotation_change(scalar, error, ahead))
            for k in range(3):
                out[i, 18 + wheels + k] = _clip(desired[k] / RATE_SCALE)
                out[i, 21 + wheels + k] = _clip(ahead[k] / (0.1 * RATE_SCALE))
        for k in range(3):
            out[i, k] = min(max(error[k], -1.0), 1.0)
            out[i, 3 + k] = _tanh(20.0 * error[k])
            out[i, 6 + k] = _tanh(400.0 * error[k])
            out[i, 9 + k] = _clip(rate_error[k] / RATE_SCALE)
            out[i, 12 + k] = _tanh(200.0 * rate_error[k])

        torque, stored = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
        telemetry = 18 + wheels + (6 if moving else 0)
        for j in range(wheels):
            axis = (axes[0, j], axes[1, j], axes[2, j])
            out[i, 15 + j] = command[i, j] / torque_limits[j]
            torque = add3(torque, in_effect[i, j], axis)
            if tier > 0:
                momentum = wheel_momentum[i, j]
                if coupled:
                    stored = add3(stored, momentum, axis)
                if ticks[i] == 0:
                    wheel_residual[i, j] = 0.0
                else:
                    excess = (last_momentum[i, j] - momentum) / period - in_effect[i, j]
                    wheel_residual[i, j] += gain * (excess - wheel_residual[i, j])
                last_momentum[i, j] = momentum
                out[i, telemetry + j] = _clip(momentum / momentum_scale[j])
                out[i, telemetry + wheels + j] = _clip(wheel_residual[i, j] / torque_limits[j])
        if tier > 0:
            out[i, telemetry + 2 * wheels] = 1.0 if star_tracker_valid[i] else 0.0

        if ticks[i] == 0:
            residual[i, 0], residual[i, 1], residual[i, 2] = 0.0, 0.0, 0.0
        else:
            last = row3(last_rate, i)
            x, y, z = add3(now, -1.0, last)
            # The rate in the middle of the period that the command was held.
            middle = scale3(0.5, add3(now, 1.0, last))
            h = add3(stored, 1.0, _times(inertia, middle))
            needed = _times(inertia, (x / period, y / period, z / period))
            unmodelled = (
                needed[0] + middle[1] * h[2] - middle[2] * h[1] - torque[0],
                needed[1] + middle[2] * h[0] - middle[0] * h[2] - torque[1],
                needed[2] + middle[0] * h[1] - middle[1] * h[0] - torque[2],
            )
            for k in range(3):
                residual[i, k] += gain * (unmodelled[k] - residual[i, k])
        for k in range(3):
            last_rate[i, k] = now[k]
            out[i, 15 + wheels + k] = _clip(residual[i, k] / mean_limit)
