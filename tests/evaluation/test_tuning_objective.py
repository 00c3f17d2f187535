"""Objectives of the tuner: means of a metric, rounding, and checks of a search."""

import math
import subprocess
import sys

import numpy as np
import pytest
from helpers.tuning_cases import SEARCH, TINY, DirectPD, SelectivePD, register

from ftac_gym import baselines
from ftac_gym.baselines import Range
from ftac_gym.evaluation import rollout
from ftac_gym.evaluation import tuning_objective as objective
from ftac_gym.evaluation.tuning_objective import FAILED, OBJECTIVES, Search, fly, value_of
from ftac_gym.policies import DeferredBaseline


@pytest.fixture
def entries(monkeypatch):
    """Register the small baselines."""
    register(monkeypatch)


@pytest.mark.parametrize("name", OBJECTIVES)
def test_the_objective_is_the_mean_of_its_metric_over_all_episodes(name):
    task = Search("pd", TINY, episodes=9, seed=0, objective=name)
    history = rollout(TINY, DeferredBaseline("pd", rate_gain=1.2), seed=task.seed, count=9)
    assert value_of(task, {"rate_gain": 1.2}) == pytest.approx(history.metrics()[name].mean())
    assert len(fly(task, {}, TINY.draw(3, 9))["return"]) == 9


@pytest.mark.usefixtures("entries")
def test_gains_that_cannot_be_flown_are_the_worst():
    task = Search("selective", TINY, episodes=2)
    assert value_of(task, {"braking_share": 1.2}) == FAILED
    assert value_of(task, {"rate_gain": 1.5}) == FAILED
    assert math.isfinite(value_of(task, {"rate_gain": 1.2}))


def test_gains_are_rounded_before_they_fly():
    point = {"rate_gain": 1.234567, "position_share": 0.5, "braking_share": 0.98765432, "rate_limit": 0.1,
             "attitude_filter_time": 1.0}  # fmt: skip
    gains = SEARCH.gains_at(point)
    assert gains == {"rate_gain": 1.235, "position_gain": 0.6173, "braking_share": 0.9877, "rate_limit": 0.1,
                     "attitude_filter_time": 1.0}  # fmt: skip
    rounded = objective._rounded({"part": {"gain": (1.23456, 2)}, "kind": "a"})
    assert rounded == {"part": {"gain": [1.235, 2]}, "kind": "a"}


@pytest.mark.usefixtures("entries")
def test_points_lie_at_shares_of_the_ranges():
    search = Search("direct", TINY, episodes=2)
    for share, expected in ((0.0, (0.2, 0.4)), (0.5, (0.6, math.sqrt(0.4 * 2.5))), (1.0, (1.0, 2.5))):
        assert tuple(search.point_at(np.full(2, share)).values()) == pytest.approx(expected)


def test_the_start(entries, monkeypatch):
    defaults = baselines.defaults("direct")
    assert Search("direct", TINY, episodes=2).start() == {
        name: defaults[name] for name in ("braking_share", "rate_limit")
    }
    # A share of another gain is no gain of the baseline, but follows from two of them.
    gains = baselines.defaults(SEARCH.baseline)
    assert SEARCH.start()["position_share"] == pytest.approx(gains["position_gain"] / gains["rate_gain"])
    monkeypatch.setattr(DirectPD, "search_space", {**DirectPD.search_space, "rate_limit": Range(2.0, 8.0, log=True)})
    # A default outside its range: from the middle.
    assert Search("direct", TINY, episodes=2).start()["rate_limit"] == pytest.approx(4.0)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"baseline": "unknown"}, "baseline must be one of .*'unknown'"),
        ({"objective": "energy"}, r"objective must be one of \['availability', 'success', 'return'\], got 'energy'"),
        ({"episodes": 0}, "episodes must be a whole number, 1 or more, got 0"),
        ({"episodes": "a"}, "episodes must be a whole number, 1 or more, got 'a'"),
        ({"seed": "a"}, "seed must be a whole number, 0 or more, got 'a'"),
        ({"seed": 10_000}, r"seed must not be within \[10000, 29999\], the seeds of frozen .*, got 10000"),
        ({"seed": 21_000}, "seed must not be within .*, got 21000"),
    ],
)
def test_a_search_is_checked(arguments, message):
    with pytest.raises(ValueError, match=message):
        Search(**{"baseline": "pd", "scenario": TINY, "episodes": 5, **arguments})


def test_one_gain_is_not_enough(entries, monkeypatch):
    monkeypatch.setattr(SelectivePD, "search_space", {"rate_gain": Range(0.8, 1.6)})
    with pytest.raises(ValueError, match="baseline must have at least two gains to search, got 'selective'"):
        Search("selective", TINY)


def test_the_package_does_not_need_cmaes():
    code = "import sys, ftac_gym.evaluation, ftac_gym.evaluation.tuning_objective; sys.exit('cmaes' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0
