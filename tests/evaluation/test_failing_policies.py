"""Policies that fail in flight: named with their episode, in an evaluation and in a benchmark, and left out."""

from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest
from helpers.short_benchmarks import EPISODES, FLAGSHIP, entry_of

from ftac_gym import baselines
from ftac_gym.dynamics.divergence import DivergenceError
from ftac_gym.evaluation import evaluate
from ftac_gym.evaluation.batches import FlightError
from ftac_gym.evaluation.benchmark import entries_of, fly
from ftac_gym.policies import PolicyRunner, resolve
from ftac_gym.report import write_report


class Failing:
    """A policy that turns bad after a second, on spacecraft whose first observation is large."""

    tier = "attitude"

    def __init__(self, limit, answer):
        self.limit, self.answer = limit, answer

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        if episode_start.any():
            self.steps, self.bad = 0, size(observation) > self.limit
        self.steps += 1
        action = np.zeros((len(observation), 4))
        return (self.answer(action, self.bad) if self.steps > 10 and self.bad.any() else action), state


def size(observation):
    return np.abs(observation).sum(axis=1)


def raised(action, bad):
    raise ZeroDivisionError("no torque")


@pytest.mark.parametrize(
    ("answer", "reason"),
    [
        (lambda action, bad: np.where(bad[:, None], np.nan, action), "action must be finite, got"),
        (lambda action, bad: action[:, :3], r"action.* must have shape \(1, 4\), got \(1, 3\)"),
        (lambda action, bad: None, "action must "),
        (raised, "ZeroDivisionError: no torque"),
    ],
    ids=["NaN", "shape", "nothing", "error"],
)
def test_the_episode_is_named(answer, reason, tmp_path, monkeypatch):
    monkeypatch.setattr(import_module("ftac_gym.evaluation.batches"), "BATCH", 8)
    episodes = FLAGSHIP.draw(3, 20)
    sizes = size(PolicyRunner(FLAGSHIP, resolve("pd"), 20).env.reset(options={"episodes": episodes})[0])
    limit = 1e-3 + max(sizes[:8].max(), np.sort(sizes[8:])[-3])
    first = np.flatnonzero(sizes > limit)[0]
    flown = []
    with pytest.raises(FlightError, match=rf"^bad in flagship: episode {first}: {reason}") as caught:
        evaluate(FLAGSHIP, Failing(limit, answer), episodes, "bad", progress=flown.append)
    assert flown == [8] * (first // 8)
    assert "\n" not in str(caught.value) and len(str(caught.value)) < 500


def test_an_error_that_comes_with_several_episodes_alone_names_them():
    class Crowded:
        tier = "attitude"

        def predict(self, observation, state=None, episode_start=None, deterministic=True):
            if len(observation) == 4:
                raise MemoryError
            return np.zeros((len(observation), 4)), state

    with pytest.raises(FlightError, match=r"^crowded in flagship: episodes 0 to 3 together: MemoryError: MemoryError$"):
        evaluate(FLAGSHIP, Crowded(), FLAGSHIP.draw(3, 4), "crowded")


def test_a_spacecraft_that_diverges_is_named():
    def diverging(row):
        raise DivergenceError("spacecraft 0 at 1.5 s: rate must stay finite, got nan")

    with pytest.raises(
        FlightError, match=r"^wild in flagship: episode 0: spacecraft 0 at 1\.5 s: rate must stay finite"
    ):
        evaluate(FLAGSHIP, diverging, FLAGSHIP.draw(3, 2), "wild")


def test_a_policy_that_does_not_fit_is_no_failure_in_flight():
    with pytest.raises(ValueError, match=r"^agent must have been trained on") as caught:
        evaluate(FLAGSHIP, "flexible_residual", FLAGSHIP.draw(0, 1))
    assert not isinstance(caught.value, FlightError)


class Broken(baselines.Baseline):
    """Custom baseline that fails in flight."""

    def act(self, measurement):
        return np.where(measurement.time[:, None] > 1.0, np.nan, np.zeros((len(measurement), 4)))


@pytest.fixture
def pair():
    return (*entries_of(["pd"], FLAGSHIP), entry_of(Broken))


def test_the_others_of_a_benchmark_go_on_and_its_report_says_so(pair, tmp_path):
    alone = fly(pair[:1], EPISODES, "pd", workers=1, measure=False)
    result = fly(pair, EPISODES, "pd", workers=1)
    assert result.entries == alone.entries and set(result.step_cost) == {"pd"}
    for split, found in result.evaluations.items():
        assert set(found) == {"pd"}
        np.testing.assert_equal(found["pd"][0].metrics, alone.evaluations[split]["pd"][0].metrics)
    message = "broken in flagship: episode 0: action must be finite"
    assert set(result.failures) == {"broken"} and result.failures["broken"].startswith(message)
    report = write_report(replace(result, step_cost={}), tmp_path)
    assert message in report.read_text() and "Left out of all tables" in report.read_text()
    assert "broken" not in (tmp_path / "summary.csv").read_text()


def test_a_reference_that_fails_ends_a_benchmark_after_the_others(pair, tmp_path):
    with pytest.raises(FlightError, match=r"^broken in flagship: episode 0: .*finite.*; broken is the reference$"):
        fly(pair, {"flagship": EPISODES["flagship"]}, "broken", tmp_path, workers=1)
    assert fly(pair[:1], {"flagship": EPISODES["flagship"]}, "pd", tmp_path, measure=False).episodes_flown == 0


def test_a_failure_while_the_cost_is_measured_is_a_warning(pair, monkeypatch):
    module = import_module("ftac_gym.evaluation.benchmark")

    def failing(entry, scenario):
        raise ValueError("action must be finite")

    monkeypatch.setattr(module, "step_cost", failing)
    with pytest.warns(UserWarning, match="control step of pd cannot be measured: action must be finite"):
        result = fly(pair[:1], {"flagship": EPISODES["flagship"]}, "pd", workers=1)
    assert result.step_cost == {} and set(result.evaluations["flagship"]) == {"pd"}
