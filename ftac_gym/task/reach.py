"""Bound on the rates that a scenario can reach: for a while every torque pushes one way.

In a scenario alone these are the torques that nothing commands. In an environment the wheels push with all their torque
too, or until they have given all their momentum. The bound is an estimate, not a proof:
:class:`~ftac_gym.dynamics.divergence.DivergenceError` covers what it leaves out.
"""

from __future__ import annotations

import math
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from ftac_gym.faults.wheel_faults import Bias, FrictionRise, HardOver, Seizure
from ftac_gym.task.inertia import InertiaUncertainty
from ftac_gym.task.vibration import AppendageUncertainty
from ftac_gym.utils.parameters import FloatArray, largest, require

if TYPE_CHECKING:
    from ftac_gym.task.scenario import Scenario

LARGEST_TURN = 1.0
"""Limit of the turn in a physics step [rad]: there RK4 is wrong by 5e-4 rad a step, and diverges from 2.8 on."""

PUSH_PERIODS = 50
"""Control periods of the push. Whole episodes of it would refuse published scenarios, which no policy flies so."""

_ENUMERATED = 10
"""Number of wheels up to which the corners of the momentum envelope are enumerated."""


def check_reach(scenario: Scenario, commanded: bool = False) -> None:
    """Check that the physics step integrates every rate that can be reached.

    Parameters
    ----------
    scenario
        The scenario.
    commanded
        Whether the wheels push too, with commands at their torque limits.

    Raises
    ------
    ValueError
        If the start is too fast, or the rate can become too high for the step.
    """
    step, initial = scenario.physics_step, scenario.initial_state
    ratio = gyroscopic_ratio(scenario)
    fastest = fastest_rate(scenario)
    name = "max_rate" if initial.rate is None else "rate"
    nutation = f", and the body nutates {ratio:.4g} times as fast" if ratio > 1.001 else ""
    rule = f"must be at most {fastest:.4g} rad/s, {LARGEST_TURN:g} rad in a physics_step of {step:g} s{nutation}"
    require(initial.largest_rate <= fastest, f"initial_state.{name}", rule, initial.largest_rate)
    shares = _shares(scenario, commanded)
    rate = sum(shares.values())
    parts = ", ".join(f"{name} {share:.3g}" for name, share in shares.items() if share > 0.0)
    rule = "must not make the rate diverge (a torque that grows with the rate)"
    torque = scenario.external_torque
    path = next((path for path, _ in torque.paths), "disturbance")
    require(rate < math.inf, f"{path}.rate_offset", rule, torque.rate_offset)
    longest = LARGEST_TURN / ratio / rate if rate > 0.0 else math.inf
    rule = f"must be at most {longest:.3g} s, or tumble_rate or momentum limits be lower: the rate could reach"
    require(rate <= fastest, "physics_step", f"{rule} {rate:.4g} rad/s ({parts}){nutation}", step)


def push_time(scenario: Scenario) -> float:
    """Return the duration of the push [s]."""
    return min(scenario.duration, PUSH_PERIODS * scenario.control_period)


def fastest_rate(scenario: Scenario) -> float:
    """Return the largest rate of the body that the physics step integrates [rad/s]."""
    return LARGEST_TURN / scenario.physics_step / gyroscopic_ratio(scenario)


def gyroscopic_ratio(scenario: Scenario) -> float:
    """Return the fastest gyroscopic motion of the body over its rate; 1 unless no mass has such an inertia.

    A random inertia counts with its mean.
    """
    uncertainty = scenario.inertia_uncertainty or InertiaUncertainty()
    mean = scenario.spacecraft.inertia_matrix
    if uncertainty.offset is not None:
        mean = mean + np.array(uncertainty.offset)
    swings = np.array(list(product((-1.0, 0.0, 1.0), repeat=3))) * uncertainty.amplitude
    return max(1.0, float(moment_ratios(mean + swings[:, :, None] * np.eye(3)).max()))


def moment_ratios(inertia: FloatArray) -> FloatArray:
    """Return the largest ``|Ja - Jb| / Jc`` of principal moments (N,); at most 1 by the triangle inequality.

    By Euler's equations no gyroscopic motion of a body is faster than this ratio times its rate.
    """
    moments = np.linalg.eigvalsh(inertia)
    ratios: FloatArray = (moments[:, 2] - moments[:, 1]) / moments[:, 0]
    return ratios


def _shares(scenario: Scenario, commanded: bool) -> dict[str, float]:
    """Return what each part can add to the rate [rad/s]."""
    initial, wheels, disturbance = scenario.initial_state, scenario.spacecraft.wheels, scenario.external_torque
    least, most = extreme_moments(scenario)
    start = initial.largest_rate * math.sqrt(most / least) + _modal_momentum(scenario) / least
    at_start = np.minimum(initial.largest_momentum(wheels.count), wheels.momentum_limits)
    torque = _uncommanded(scenario) + (wheels.torque_limits if commanded else 0.0)
    axes = wheels.axis_matrix + (0.0 if scenario.misalignment is None else np.array(scenario.misalignment))

    def given(time: float) -> float:
        impulse = torque * time
        if wheels.momentum_coupling:  # Torque without it gives momentum to a turning body without end.
            impulse = np.minimum(impulse, at_start + wheels.momentum_limits)
        # The stages of a step see the torque, however soon the momentum ends it.
        return _span(axes, np.maximum(impulse, torque * scenario.physics_step)) / least

    time = push_time(scenario)
    external, offset = disturbance.largest_torque(most) / least, disturbance.rate_offset
    steady = external if offset is None else external * offset
    shares = {"start": start, "wheels": given(time), "external torque": steady * time}
    if scenario.tumble_rate is not None:
        # An episode that passes this rate ends with the control period.
        name, rate = max(("start", start), ("tumble_rate", scenario.tumble_rate), key=lambda share: share[1])
        period = scenario.control_period
        shares = min(shares, {name: rate, "wheels": given(period), "external torque": steady * period}, key=_total)
    if offset is not None:
        grown = _grown(start, given(time) / time + steady, disturbance.swing(time) / least / time, time)
        shares = max(shares, {"growing torque": grown}, key=_total)
    # Stored momentum makes the body nutate, and brakes give it to the body.
    brakes = wheels.friction is not None or any(isinstance(fault, Seizure) for fault in scenario.known_faults)
    stored = _span(axes, at_start) / least if wheels.momentum_coupling or brakes else 0.0
    return {**shares, "stored momentum": stored, "friction": _span(axes, _drag(scenario, at_start, torque)) / least}


def _total(shares: dict[str, float]) -> float:
    return sum(shares.values())


def extreme_moments(scenario: Scenario) -> tuple[float, float]:
    """Return bounds on the principal moments of the true inertia, without that of the modes [kg m^2]."""
    uncertainty = scenario.inertia_uncertainty or InertiaUncertainty()
    nominal = scenario.spacecraft.inertia_matrix
    low, high = uncertainty.extremes(nominal)
    if (appendages := scenario.spacecraft.appendages) is not None:
        coupling = (scenario.appendage_uncertainty or AppendageUncertainty()).extreme(appendages)["coupling"][0]
        low = low - coupling.T @ coupling
        nominal = nominal - appendages.carried_inertia
    # Draws near the bound are rare where it is poor, and those without inertia are refused when they are drawn.
    least = max(float(np.linalg.eigvalsh(low)[0]), 0.1 * float(np.linalg.eigvalsh(nominal)[0]))
    return least, float(np.linalg.eigvalsh(high)[-1])


def _modal_momentum(scenario: Scenario) -> float:
    """Return a bound on the momentum that the modes at the start can give the body [N m s]."""
    appendages, initial = scenario.spacecraft.appendages, scenario.initial_state
    if appendages is None:
        return 0.0
    modes = (scenario.appendage_uncertainty or AppendageUncertainty()).extreme(appendages)[0]
    still = (0.0,) * len(modes)
    stretch, speed = (
        np.array([largest(value) for value in values or still])
        for values in (initial.modal_displacement, initial.modal_rate)
    )
    return float(np.linalg.norm(modes["coupling"], axis=1) @ np.hypot(np.sqrt(modes["stiffness"]) * stretch, speed))


def _uncommanded(scenario: Scenario) -> FloatArray:
    """Return a bound on the torque of each wheel (m,) [N m] that faults give by themselves."""
    limits = scenario.spacecraft.wheels.torque_limits
    torque = np.zeros_like(limits)
    for fault in scenario.known_faults:
        if isinstance(fault, (Bias, HardOver)):
            added = fault.largest_torque(scenario.duration, limits)
            if fault.wheel is None:  # Of a distribution: one fault a wheel, on any of them.
                torque = np.maximum(torque, added)
            else:
                torque[fault.wheel] += added[fault.wheel]
    return np.where(np.isfinite(torque), torque, 0.0)


def _drag(scenario: Scenario, at_start: FloatArray, torque: FloatArray) -> FloatArray:
    """Return a bound on the impulse of friction on each wheel (m,) in a physics step, as the body's stages see it."""
    wheels = scenario.spacecraft.wheels
    factor, drag = np.ones(wheels.count), np.zeros(wheels.count)
    for fault in scenario.known_faults:
        if isinstance(fault, FrictionRise):
            if fault.wheel is None:
                factor = np.maximum(factor, largest(fault.factor))
            else:
                factor[fault.wheel] *= largest(fault.factor)
    for wheel, friction in enumerate(wheels.frictions):
        if friction is not None:
            # A wheel becomes so fast at most that viscous friction outweighs its motor.
            viscous = friction.viscous * at_start[wheel] / wheels.spin_inertias[wheel] + torque[wheel]
            fastest = wheels.momentum_limits[wheel] / wheels.spin_inertias[wheel]
            drag[wheel] = max(friction.coulomb, friction.breakaway or 0.0) * factor[wheel]
            drag[wheel] += min(viscous, friction.viscous * fastest) if friction.viscous > 0.0 else 0.0
    return drag * scenario.physics_step


def _span(axes: FloatArray, sizes: FloatArray) -> float:
    """Return the largest magnitude of sum_j s_j D[:, j] with ``|s_j|`` up to the sizes (m,)."""
    count = len(sizes)
    if count > _ENUMERATED:
        return float(np.linalg.norm(np.abs(axes) @ sizes))
    signs = np.array([(1.0, *rest) for rest in product((-1.0, 1.0), repeat=count - 1)])
    return float(np.linalg.norm((signs * sizes) @ axes.T, axis=1).max())


def _grown(start: float, push: float, growth: float, time: float) -> float:
    """Return y at a time for y' = push + growth y^2; infinite if it diverges before."""
    scale = math.sqrt(push * growth)
    if scale * time < 1e-6:
        left = 1.0 - start * growth * time
        return (start + push * time) / left if left > 0.0 else math.inf
    angle = scale * time + math.atan(start * growth / scale)
    return push / scale * math.tan(angle) if angle < 0.5 * math.pi else math.inf
