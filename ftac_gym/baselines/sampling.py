"""Check that the gains of a baseline suit its control period, by a short flight of the nominal spacecraft."""

from __future__ import annotations

import warnings
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from ftac_gym.attitude import angle_between, quaternion_from_rotation_vector, quaternion_product
from ftac_gym.baselines.components.relative_motion import relative_motion
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

    A baseline with the same arguments is judged once in a process.

    Three spacecraft start at rest relative to the reference, each half the success cone off about one body axis. There
    are no faults, no disturbance, no sensor errors and no differences from the nominal parameters. The loop has its
    nominal delay. The warning needs both, at the end of the flight: a spacecraft off target, and wheel commands that
    reverse from call to call. A slow or loose controller is off target without reversals, and a chattering one
    reverses on target.

    Parameters
    ----------
    baseline
        The baseline, which is left as it is: another one is built for the flight.
    """
    args, kwargs = baseline.arguments
    try:
        warning = _known_judgement(type(baseline), args, tuple(kwargs.items()))
    except TypeError:  # The arguments have no hash.
        warning = _judgement(type(baseline), args, kwargs)
    if warning:
        # With this module as the place of all, Python shows each once.
        warnings.warn(warning, SampledInstability, stacklevel=1)


@lru_cache
def _known_judgement(kind: type[Baseline], args: tuple[Any, ...], kwargs: tuple[tuple[str, Any], ...]) -> str:
    return _judgement(kind, args, dict(kwargs))


def _judgement(kind: type[Baseline], args: tuple[Any, ...], kwargs: dict[str, Any]) -> str:
    """Return the warning, empty for none."""
    try:
        with np.errstate(all="ignore"):
            baseline = kind(*args, **kwargs).again(3)
            angles, rates, commands = _flight(baseline)
    except Exception:
        return ""  # What fails here fails in the flight itself, which says why.
    success = baseline.scenario.success
    off_target = bool(((angles > success.angle) | (rates > success.rate)).any())
    change = float(np.abs(np.diff(commands, axis=0)).mean(axis=0).max())
    if not off_target or change <= REVERSALS:
        return ""
    given = baseline.scenario
    delay = f" with a loop delay of {given.loop_delay:g} s" if given.loop_delay else ""
    return (
        f"{type(baseline).__name__}: the control period of {given.control_period:g} s{delay} is too long for its "
        f"gains: without faults and noise, from {SHARE:g} of the success cone, its commands reverse "
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
