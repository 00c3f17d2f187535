"""Labels against the verdicts of an optimal-control solver, from ``benchmarks/feasible.py``.

``feasibility_verdicts.json`` has a scenario for each case. Beside it are the numbers of its episodes that the solver
passes, of those that it finds impossible, and a digest of both.
"""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ftac_gym.task import Scenario

SEED = 777
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


def test_few_episodes_that_the_solver_passes_are_infeasible():
    missed = [~drawn(case).feasible[: len(case["passes"])] for case in CASES.values()]
    assert np.concatenate(missed).mean() < 0.1
