"""One episode of each fault kind under one policy, beside the same episode without the fault."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ftac_gym import attitude as attitudes
from ftac_gym.evaluation import Rollout, rollout
from ftac_gym.faults import KINDS, Bias, Fault, FaultSchedule, SensorFault, WheelFault
from ftac_gym.faults.specification import example
from ftac_gym.faults.table import Kind
from ftac_gym.plots import style
from ftac_gym.plots.recording import replay
from ftac_gym.spacecraft.friction import Friction
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, bounds

ONSET, WHEEL = 8.0, 1
"""Onset of the fault [s], in the middle of the slew, and the affected wheel."""

LARGEST_BIAS = 0.4
"""Limit of a bias, as a share of the smallest torque limit: more would hide that it is a torque of the wheel."""

ACROSS = 3
"""Fault kinds in a row."""


def examples() -> dict[Kind, Fault]:
    """Return a fault of each kind with a clearly visible size."""
    return {
        kind.kind: example(kind, onset=ONSET, **({"wheel": WHEEL} if issubclass(kind, WheelFault) else {}))
        for kind in KINDS
    }


def with_fault(scenario: Scenario, fault: Fault | None) -> Scenario:
    """Return a scenario with a fixed slew of 100 deg, spinning wheels with friction, and one fault or none.

    The examples of faults are for wheels like the flagship's. A bias is made smaller for smaller wheels.
    """
    start = attitudes.quaternion_from_rotation_vector(np.radians(100.0) * np.array([0.6, -0.48, 0.64]))
    wheels = scenario.spacecraft.wheels
    momentum = 0.25 * np.minimum(wheels.momentum_limits, 4.0) * np.resize([1.0, -1.0], wheels.count)
    if isinstance(fault, Bias):
        largest = LARGEST_BIAS * float(np.min(wheels.torque_limits))
        fault = replace(fault, amplitude=min(bounds(fault.amplitude)[1], largest))
    rubbing = replace(wheels, spin_inertia=wheels.spin_inertia or 0.02, friction=wheels.friction or Friction(5e-4))
    return scenario.replace(
        spacecraft=replace(scenario.spacecraft, wheels=rubbing),
        initial_state=InitialState.fixed(attitude=start.tolist(), wheel_momentum=momentum.tolist()),
        faults=None if fault is None else FaultSchedule((fault,)),
    )


def sensor_error(history: Rollout) -> tuple[FloatArray, FloatArray]:
    """Return the errors of measured attitude [deg] and rate [deg/s] of a rollout's first spacecraft."""
    errors = []
    for simulator in replay(history):
        measured, state = simulator.measurement(), simulator.state
        angle = attitudes.angle_between(measured.attitude, state.attitude)[0]
        errors.append((angle, np.linalg.norm(measured.rate[0] - state.rate[0])))
    attitude, rate = np.degrees(errors).T
    return attitude, rate


def fault_gallery(scenario: Scenario, policy: Any, seed: int = 0) -> Figure:
    """Draw an episode of each fault kind.

    Each kind has two panels. The upper one has the pointing error with the fault and without it. The lower one has
    command and applied torque of the affected wheel, or the error of the sensors.

    Parameters
    ----------
    scenario
        Source of spacecraft, sensors and timing.
    policy
        See :func:`~ftac_gym.policies.resolve`.
    seed
        Seed of all other random numbers: noise, inertia, disturbance.
    """
    healthy = rollout(with_fault(scenario, None), policy, seed=seed)
    faults = examples()
    rows = -(-len(faults) // ACROSS)
    figure = style.figure(4.6 * ACROSS, 3.5 * rows)
    parts: Any = np.ravel(np.asarray(figure.subfigures(rows, ACROSS)))
    for part, (kind, fault) in zip(parts, faults.items(), strict=False):
        history = rollout(with_fault(scenario, fault), policy, seed=seed)
        upper, lower = part.subplots(2, 1, sharex=True)
        upper.set_title(kind.label, fontsize=10)
        for name, color, flown in (("without", "0.6", healthy), ("with the fault", style.COLORS[1], history)):
            error = np.maximum(np.degrees(flown.attitude_error[:, 0]), style.FLOOR)
            upper.plot(flown.time, error, color=color, label=name, linewidth=1.0)
        upper.set(yscale="log", ylim=(style.FLOOR, 200.0))
        style.apply(upper, ylabel="error [deg]")
        _draw_fault(lower, fault, history)
        for panel in (upper, lower):
            panel.axvline(ONSET, color=style.MUTED, linestyle=":", linewidth=1.0)
            panel.set_xlim(0.0, history.time[-1])
    parts[0].axes[0].legend(loc="upper right", fontsize=7)
    return figure


def _draw_fault(panel: Axes, fault: Fault, history: Rollout) -> None:
    if isinstance(fault, SensorFault):
        time, label = history.time, "sensor error\n[deg], [deg/s]"
        errors = (np.maximum(error, style.FLOOR) for error in sensor_error(history))
        drawn = dict(zip(("attitude [deg]", "rate [deg/s]"), errors, strict=True))
        panel.set_yscale("log")
    else:
        time, label = history.time[1:], "torque [N m]"
        torques = {"commanded": history.command, "on the body": history.applied_torque}
        drawn = {name: torque[:, 0, WHEEL] for name, torque in torques.items()}
    for number, (name, values) in enumerate(drawn.items()):
        panel.plot(time, values, label=name, linewidth=0.9, **style.stroke(number).of_line)
    panel.legend(loc="lower right", fontsize=7)
    style.apply(panel, xlabel="time [s]", ylabel=label)
