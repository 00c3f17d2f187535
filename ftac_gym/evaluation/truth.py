"""Effect of the faults along a rollout: the truth that estimates are compared with."""

from __future__ import annotations

import numpy as np

from ftac_gym.evaluation.metrics import Rollout
from ftac_gym.faults import FaultEffect, fault_effect
from ftac_gym.utils.parameters import FloatArray


def true_effect(history: Rollout, spacecraft: int = 0) -> FaultEffect:
    """Return the effect of the faults of one spacecraft of a rollout at each of its T + 1 times."""
    wheels = history.scenario.spacecraft.wheels
    # A locked wheel repeats the torque that it applied last.
    torques = np.vstack([np.zeros((1, wheels.count)), history.applied_torque[:, spacecraft]])
    drawn = history.episodes.drawn_faults.take(np.full(len(history.time), spacecraft))
    return fault_effect(drawn, history.time, wheels, history.wheel_momentum[:, spacecraft], torques)


def command_in_effect(history: Rollout) -> FloatArray:
    """Return the mean command in effect over the control period before each time, (T + 1, N, m) [N m].

    It is that of on-board software, by the nominal loop delay; zero at the start.
    """
    scenario = history.scenario
    periods, late = divmod(scenario.delay_steps, scenario.substeps)
    given = np.concatenate([np.zeros((1 + periods + (late > 0), *history.command.shape[1:])), history.command])
    steps = len(history.command) + 1
    if not late:
        return given[:steps]
    held = given[1 : steps + 1]
    mean: FloatArray = held + (late / scenario.substeps) * (given[:steps] - held)
    return mean


def uncommanded_torque(history: Rollout) -> FloatArray:
    """Return the torque of each wheel beyond the command in effect, (T + 1, N, m) [N m].

    At each time it is the mean over the control period before; zero at the start.
    """
    applied = np.concatenate([np.zeros_like(history.applied_torque[:1]), history.applied_torque])
    torque: FloatArray = applied - command_in_effect(history)
    return torque


def unexplained_torque(history: Rollout, spacecraft: int = 0) -> FloatArray:
    """Return the torque on the body of one spacecraft, along the nominal wheel axes, that commands do not explain.

    Returns
    -------
    Array (T + 1, 3) [N m], body axes: at each time that of the control period before it, without the external
    disturbance and the vibration.
    """
    axes = history.scenario.spacecraft.wheels.axis_matrix
    torque: FloatArray = uncommanded_torque(history)[:, spacecraft] @ axes.T
    return torque
