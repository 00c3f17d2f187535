"""Labels against the verdicts of an optimal-control solver, from ``benchmarks/feasible.py``.

``feasibility_verdicts.json`` has a scenario for each case. Beside it are the numbers of its episodes that the solver
passes, of those that it finds impossible, and of those that it gave up. A digest is of the first two. Of the splits it
has every infeasible one of the first 300 episodes.
"""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ftac_gym.task import Scenario

SEED, DRAWN = 777, 300
SPLITS = ("", "_severe", "_double", "_unseen", "_hardware", "_tracking")
CASES = json.loads((Path(__file__).parent / "feasibility_verdicts.json").read_text())


def drawn(case):
    numbers = np.array(case["passes"] + case["impossible"])
    return Scenario.from_dict(case["scenario"]).draw_episodes([SEED] * len(numbers), numbers)


@pytest.mark.parametrize("name", CASES)
def test_the_episodes_are_those_of_the_solver(name):
    episodes = drawn(CASES[name])
    unlabelled = replace(episodes, feasible=np.zeros(len(episodes), dtype=bool))
    assert unlabelled.digest() == CASES[name]["digest"], "the drawing has changed: run benchmarks/feasible.py again"


@pytest.mark.parametrize("name", CASES)
def test_no_impossible_episode_is_feasible(name):
    impossible = drawn(CASES[name]).feasible[len(CASES[name]["passes"]) :]
    assert not impossible.any()


@pytest.mark.parametrize("name", [f"flagship{part}" for part in SPLITS])
def test_of_drawn_episodes_two_percent_at_most_are_infeasible_and_pass(name):
    case = CASES[name]
    labels = Scenario.from_dict(case["scenario"]).draw(SEED, DRAWN).feasible
    infeasible = set(np.flatnonzero(~labels).tolist())
    solved = [number for verdict in ("passes", "impossible", "undecided") for number in case[verdict]]
    assert infeasible <= set(solved)
    assert len(infeasible.intersection(case["passes"])) <= 0.02 * DRAWN
