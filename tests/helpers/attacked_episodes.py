"""Episodes with absurd numbers in one place after the other, and their flight."""

import dataclasses
import sys

import numpy as np

from ftac_gym import DivergenceError, Simulator, scenarios
from ftac_gym.faults import AttitudeSpike, CommandDelay, FaultDistribution, IntermittentShutdown

ABSURD = (10**8, -(10**8), -1, 0, 3, float("nan"), float("inf"), float("-inf"))
COUNT = 3
KINDS = (IntermittentShutdown(onset=0.0), AttitudeSpike(onset=0.0, duration=90.0), CommandDelay(onset=0.0))
TASK = scenarios.get("flexible").replace(faults=FaultDistribution(KINDS, fault_counts=(0.0, 0.0, 0.0, 1.0)))
"""Faults of wheels and sensors, random chains, delays and appendages, all from the start."""

DANGEROUS = ("chain", "delay", "kind")
"""Fields that the compiled plant takes as indices."""


def attacks(episodes):
    """Yield array, field, number and episodes that have the number there; field "" for arrays without fields.

    Of vectors and matrices it is the first component.
    """
    for name, array in episodes.arrays().items():
        for field in array.dtype.names or ("",):
            for number in ABSURD:
                table = array.copy()
                part = table[field] if field else table
                whole = part.dtype.kind in "iub"
                if whole and (not np.isfinite(number) or (number < 0 and part.dtype.kind != "i")):
                    continue
                part[(..., *(0,) * (part.ndim - array.ndim))] = number
                yield name, field, number, dataclasses.replace(episodes, **{name: table})


def fly(episodes, scenario=TASK):
    """Return "flown", "diverged" or the message of an error; anything else is an exception."""
    simulator = Simulator(scenario, len(episodes))
    try:
        simulator.reset(episodes)
    except ValueError as error:
        return str(error)
    try:
        for command in np.random.default_rng(0).uniform(-0.2, 0.2, (8, len(episodes), 4)):
            simulator.step(command)
    except DivergenceError:
        return "diverged"
    assert all(np.isfinite(array).all() for array in vars(simulator.state).values())
    assert all(np.isfinite(part).all() for part in simulator.truth())
    return "flown"


if __name__ == "__main__":  # In a process of its own, which a wrong index can kill.
    for name, field, number, attacked in attacks(TASK.draw(7, COUNT)):
        if field in DANGEROUS:
            sys.stdout.write(f"{name}|{field}|{number}|{fly(attacked)}\n")
    sys.exit(0)
