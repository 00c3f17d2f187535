"""Rollouts made by hand, with 100 control periods of 0.1 s; success asks for the last two seconds within 1 deg."""

import numpy as np

from ftac_gym import scenarios
from ftac_gym.evaluation import Rollout, episode_metrics
from ftac_gym.faults import Bias, FaultSchedule
from ftac_gym.task.scenario import SuccessCriterion

DEGREE = np.pi / 180.0
STEPS, PERIOD, LIMIT, WHEELS = 100, 0.1, 0.2, 4
FLAGSHIP = scenarios.get("flagship").replace(
    duration=STEPS * PERIOD, success=SuccessCriterion(angle=1.0 * DEGREE, rate=0.01, hold=2.0)
)
LAST = 20
"""Samples in the last two seconds."""


def history(
    error=None, rate_error=None, command=None, torque=None, reward=None, onset=None, count=1, faults=None, momentum=None
):
    """Return a rollout without other errors; errors in degrees, a column per spacecraft or one for all."""

    def table(values, shape, scale=1.0):
        filled = np.zeros(shape)
        filled[:] = 0.0 if values is None else np.asarray(values, dtype=float) * scale
        return filled

    if onset is not None:
        faults = tuple(Bias(wheel=0, onset=time) for time in onset)
    scenario = FLAGSHIP.replace(faults=None if faults is None else FaultSchedule(tuple(faults)))
    return Rollout(
        scenario=scenario,
        episodes=scenario.draw(0, count),
        time=np.arange(STEPS + 1) * PERIOD,
        attitude_error=table(error, (STEPS + 1, count), DEGREE),
        rate_error=table(rate_error, (STEPS + 1, count)),
        attitude=np.tile([1.0, 0.0, 0.0, 0.0], (STEPS + 1, count, 1)),
        reference_attitude=np.tile([1.0, 0.0, 0.0, 0.0], (STEPS + 1, count, 1)),
        rate=np.zeros((STEPS + 1, count, 3)),
        wheel_momentum=table(momentum, (STEPS + 1, count, WHEELS)),
        command=table(command, (STEPS, count, WHEELS)),
        applied_torque=table(torque, (STEPS, count, WHEELS)),
        reward=table(reward, (STEPS, count)),
        modal_displacement=np.zeros((STEPS + 1, count, 0)),
        modal_rate=np.zeros((STEPS + 1, count, 0)),
    )


def errors(pieces):
    """Return a column (STEPS + 1, 1) of errors [deg] from pairs (first sample, value)."""
    column = np.zeros((STEPS + 1, 1))
    for start, value in pieces:
        column[start:] = value
    return column


def one(name, **arguments):
    """Return a metric of the only spacecraft."""
    return episode_metrics(history(**arguments))[name][0]
