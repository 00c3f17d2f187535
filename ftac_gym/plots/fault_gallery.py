"""One episode of each fault kind under one policy, beside the same episode without the fault."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ftac_gym import attitude as attitudes
from ftac_gym.evaluation import Rollout, rollout
from ftac_gym.faults import KINDS, Fault, FaultSchedule, SensorFault, WheelFault
from ftac_gym.faults.specification import example
from ftac_gym.faults.table import Kind
from ftac_gym.plots.recording import flown_again
from ftac_gym.plots.style import COLORS, FLOOR, MUTED, dress, sheet, stroke
from ftac_gym.spacecraft.friction import Friction
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray

ONSET, WHEEL = 8.0, 1
"""When the fault strikes [s], in the middle of the slew, and which wheel."""

_DEGREE = np.pi / 180.0


def examples() -> dict[Kind, Fault]:
    """Return a fault of each kind, strong enough to be seen."""
    return {
        kind.kind: example(kind, onset=ONSET, **({"wheel": WHEEL} if issubclass(kind, WheelFault) else {}))
        for kind in KINDS
    }


def with_fault(scenario: Scenario, fault: Fault | None) -> Scenario:
    """Return a scenario with a fixed slew of 100 deg, spinning wheels that rub, and one fault or none."""
    axis = np.array([0.6, -0.48, 0.64])
    start = attitudes.quaternion_from_rotation_vector(100.0 * _DEGREE * axis)
    wheels = scenario.spacecraft.wheels
    momentum = 0.25 * np.minimum(wheels.momentum_limits, 4.0) * np.resize([1.0, -1.0], wheels.count)
    rubbing = replace(wheels, spin_inertia=wheels.spin_inertia or 0.02, friction=wheels.friction or Friction(5e-4))
    return scenario.replace(
        spacecraft=replace(scenario.spacecraft, wheels=rubbing),
        initial_state=InitialState.fixed(attitude=start.tolist(), wheel_momentum=momentum.tolist()),
        faults=None if fault is None else FaultSchedule((fault,)),
    )


def sensor_error(history: Rollout) -> tuple[FloatArray, FloatArray]:
    """Return the errors of the measured attitude [deg] and of the measured rate [deg/s] of a rollout's first craft."""
    attitude, rate = np.empty(len(history.time)), np.empty(len(history.time))
    for step, simulator in enumerate(flown_again(history)):
        measured, state = simulator.measurement(), simulator.state
        attitude[step] = attitudes.angle_between(measured.attitude, state.attitude)[0]
        rate[step] = np.linalg.norm(measured.rate[0] - state.rate[0])
    return np.degrees(attitude), np.degrees(rate)


def fault_gallery(scenario: Scenario, policy: Any, seed: int = 0) -> Figure:
    """Draw an episode of each fault kind.

    Each kind has two panels: the pointing error with the fault and without it, and what is wrong: command and applied
    torque of the struck wheel, or the error of the sensors.

    Parameters
    ----------
    scenario
        Whose spacecraft, sensors and timing are flown.
    policy
        See :func:`~ftac_gym.policies.resolve`.
    seed
        Seed of what is random besides: noise, inertia, disturbance.
    """
    healthy = rollout(with_fault(scenario, None), policy, seed=seed)
    faults = examples()
    columns = 3
    rows = -(-len(faults) // columns)
    figure = sheet(4.6 * columns, 3.5 * rows)
    grids: Any = np.ravel(np.asarray(figure.subfigures(rows, columns)))
    for index, (part, (kind, fault)) in enumerate(zip(grids, faults.items(), strict=False)):
        history = rollout(with_fault(scenario, fault), policy, seed=seed)
        upper, lower = part.subplots(2, 1, sharex=True)
        upper.set_title(kind.label, fontsize=10)
        _draw_error(upper, {"without": healthy, "with the fault": history})
        if isinstance(fault, SensorFault):
            attitude, rate = (np.maximum(error, FLOOR) for error in sensor_error(history))
            time, drawn = history.time, {"attitude [deg]": attitude, "rate [deg/s]": rate}
            lower.set_yscale("log")
            label = "sensor error\n[deg], [deg/s]"
        else:
            torques = {"commanded": history.command, "on the body": history.applied_torque}
            time, drawn = history.time[1:], {name: torque[:, 0, WHEEL] for name, torque in torques.items()}
            label = "torque [N m]"
        for number, (name, values) in enumerate(drawn.items()):
            lower.plot(time, values, label=name, linewidth=0.9, **stroke(number).of_line)
        lower.legend(loc="lower right", fontsize=7)
        dress(lower, xlabel="time [s]", ylabel=label)
        if index == 0:
            upper.legend(loc="upper right", fontsize=7)
        for panel in (upper, lower):
            panel.axvline(ONSET, color=MUTED, linestyle=":", linewidth=1.0)
            panel.set_xlim(0.0, history.time[-1])
    return figure


def _draw_error(panel: Axes, histories: Mapping[str, Rollout]) -> None:
    for (name, history), color in zip(histories.items(), ("0.6", COLORS[1]), strict=True):
        error = np.maximum(np.degrees(history.attitude_error[:, 0]), FLOOR)
        panel.plot(history.time, error, color=color, label=name, linewidth=1.0)
    panel.set(yscale="log", ylim=(FLOOR, 200.0))
    dress(panel, ylabel="error [deg]")
