"""Check that the gains of a baseline suit its control period, by its linear loop and by a short flight."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING
from weakref import WeakSet

import numpy as np

from ftac_gym.baselines.linear_loop import LoopMargins, NoLinearLoopError, linear_loop
from ftac_gym.baselines.linear_loop.controller import measured
from ftac_gym.baselines.linear_loop.spacecraft import spacecraft_model
from ftac_gym.baselines.linear_loop.system import held_parts
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

_judged: WeakSet[Baseline] = WeakSet()
"""Baselines that have been judged: one that is built by name is not warned of again where it meets an environment."""


class SampledInstability(UserWarning):
    """Warning of a control period that is too long for the gains of a baseline."""


def warn_of_long_period(baseline: Baseline) -> None:
    """Warn if a baseline does not keep its nominal spacecraft on target because it is called too seldom.

    The loop near the target is judged first (:mod:`~ftac_gym.baselines.linear_loop`): where none of its motions grows,
    there is no warning. Where one does, or a law has no linear loop, a short flight decides: chatter inside a thin
    layer may keep the target all the same. The warning needs both, at its end: a spacecraft off target, and wheel
    commands that reverse from call to call. A baseline with the same arguments is judged once in a process, and an
    object warns once.

    In the flight, three linear spacecraft start at rest, each half the success cone off about one body axis. There are
    no faults, no disturbance, no sensor errors and no differences from the nominal parameters. The reference rests, and
    the loop has its nominal delay.

    Parameters
    ----------
    baseline
        The baseline, which is left as it is: another one is built for the check.
    """
    try:
        if baseline in _judged:
            return
        warning = judged_once(baseline, _judgement)
        _judged.add(baseline)
    except Exception:
        return  # What fails here fails in the flight itself, which says why.
    if warning:
        # With this module as the place of all, Python shows each once.
        warnings.warn(warning, SampledInstability, stacklevel=1)


def _judgement(baseline: Baseline) -> str:
    """Return the warning, empty for none."""
    try:
        margins = LoopMargins(linear_loop(baseline).radius())
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
    scenario = baseline.scenario
    plant, names = spacecraft_model(scenario)
    periods, steps = divmod(scenario.delay_steps, scenario.substeps)
    transition, first, rest = held_parts(plant, scenario.control_period, steps * scenario.physics_step)
    limits = scenario.spacecraft.wheels.torque_limits
    state = np.zeros((baseline.num_spacecraft, len(transition)))
    state[:, names["attitude"]] = SHARE * scenario.success.angle * np.eye(3)
    # The latest command, then those before it.
    commands = [np.zeros((len(state), len(limits)))] * (periods + 2)
    angles, rates, given = [], [], []
    for tick in range(PERIODS):
        seen = state @ plant.c.T
        parts = {name: seen[:, columns] for name, columns in names.items()}
        before = commands[periods]
        mean = before + steps / scenario.substeps * (commands[periods + 1] - before)
        parts |= {"last_command": commands[0], "command_in_effect": mean}
        command = np.clip(baseline.act(measured(baseline, tick, parts)), -limits, limits)
        commands = [command, *commands[: periods + 1]]
        state = state @ transition.T + commands[periods] @ rest.T + commands[periods + 1] @ first.T
        angles.append(np.linalg.norm(state[:, names["attitude"]], axis=1))
        rates.append(np.linalg.norm(state[:, names["rate"]], axis=1))
        given.append(command / limits)
    last = slice(PERIODS - LAST, None)
    return np.array(angles)[last], np.array(rates)[last], np.array(given)[last]
