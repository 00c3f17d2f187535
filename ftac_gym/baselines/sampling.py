"""Check that the gains of a baseline suit its control period, by its linear loop and by a short flight."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING

import numpy as np

from ftac_gym.attitude import angle_between, quaternion_from_rotation_vector, quaternion_product
from ftac_gym.baselines.components.relative_motion import relative_motion
from ftac_gym.baselines.linear_loop import NoLinearLoopError, loop_margins
from ftac_gym.baselines.once import judged_once
from ftac_gym.utils.parameters import FloatArray

if TYPE_CHECKING:
    from ftac_gym.baselines.baseline import Baseline

PERIODS, LAST = 60, 20
"""Control periods of the flight, and those at its end that are judged."""
SHARE = 0.5
"""Error at the start over the half-angle of the success cone."""
REVERSALS = 0.3
"""Mean change of a wheel command from one control period to the next, over its limit, that no settled loop needs."""

_NOMINAL = ("faults", "disturbance", "sensors", "inertia_uncertainty", "appendage_uncertainty", "misalignment")


class SampledInstability(UserWarning):
    """Warning of a control period that is too long for the gains of a baseline."""


def warn_of_long_period(baseline: Baseline) -> None:
    """Warn if a baseline does not keep its nominal spacecraft on target because it is called too seldom.

    The loop near the target is judged first (:mod:`~ftac_gym.baselines.linear_loop`): where none of its motions grows,
    there is no warning. Where one does, or a law has no linear loop, a flight decides: chatter inside a thin layer may
    keep the target all the same. A baseline with the same arguments is judged once in a process.

    In the flight, three spacecraft start at rest relative to the reference, each half the success cone off about one
    body axis. There are no faults, no disturbance, no sensor errors and no differences from the nominal parameters.
    The loop has its nominal delay. It confirms with both, at the end: a spacecraft off target, and wheel commands that
    reverse from call to call. A slow or loose controller is off target without reversals, and a chattering one
    reverses on target.

    Parameters
    ----------
    baseline
        The baseline, which is left as it is: another one is built for the check.
    """
    try:
        warning = judged_once(baseline, _judgement)
    except Exception:
        return  # What fails here fails in the flight itself, which says why.
    if warning:
        # With this module as the place of all, Python shows each once.
        warnings.warn(warning, SampledInstability, stacklevel=1)


def _judgement(baseline: Baseline) -> str:
    """Return the warning, empty for none."""
    try:
        margins = loop_margins(baseline)
    except NoLinearLoopError:
        linear = ""
    else:
        if not margins.unstable:
            return ""
        linear = f"its linear loop has spectral radius {margins.spectral_radius:.3g}; "
    with np.errstate(all="ignore"):
        angles, rates, commands = _flight(baseline.again(3))
    given = baseline.scenario
    off_target = bool(((angles > given.success.angle) | (rates > given.success.rate)).any())
    change = float(np.abs(np.diff(commands, axis=0)).mean(axis=0).max())
    if not off_target or change <= REVERSALS:
        return ""
    delay = f" with a loop delay of {given.loop_delay:g} s" if given.loop_delay else ""
    return (
        f"{type(baseline).__name__}: the control period of {given.control_period:g} s{delay} is too long for its "
        f"gains: {linear}without faults and noise, from {SHARE:g} of the success cone, its commands reverse "
        "from call to call and the spacecraft is not on target; take a shorter period or lower gains"
    )


def _flight(baseline: Baseline) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return angles and rates of the error [rad, rad/s] and commands over their limits at the end of a flight."""
    from ftac_gym.dynamics import Simulator  # Compiled: baselines alone do not need Numba.
    from ftac_gym.task.initial_state import InitialState

    given = baseline.scenario
    nominal = dict.fromkeys(_NOMINAL)
    scenario = given.replace(initial_state=InitialState.fixed(), extra_delay=0, **nominal)
    simulator, episodes = Simulator(scenario, 3), scenario.draw(0, 3)
    simulator.reset(episodes)
    offset = quaternion_from_rotation_vector(SHARE * given.success.angle * np.eye(3))
    episodes.initial["attitude"] = quaternion_product(simulator.reference_attitude, offset)
    episodes.initial["rate"] = simulator.reference_rate
    simulator.reset(episodes)
    truth, moving = baseline.information == "oracle", scenario.reference.moving
    angles, rates, commands = [], [], []
    for _ in range(PERIODS):
        simulator.step(baseline.act(simulator.measurement(truth)))
        seen = simulator.measurement()
        angles.append(np.atleast_1d(angle_between(seen.attitude, seen.reference_attitude)))
        rates.append(np.linalg.norm(relative_motion(seen.attitude, seen, moving).rate_error, axis=1))
        commands.append(simulator.last_command / given.spacecraft.wheels.torque_limits)
    last = slice(PERIODS - LAST, None)
    return np.array(angles)[last], np.array(rates)[last], np.array(commands)[last]
