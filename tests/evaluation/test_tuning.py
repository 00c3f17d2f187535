"""Tuning: a budget that holds, a study that survives a kill, gains that are data."""

import json
import math
import subprocess
import sys
import time
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest

from ftac_gym import baselines, scenarios
from ftac_gym.baselines import Range, registry, tuned
from ftac_gym.baselines.controllers.pd import PD, PDDisturbanceObserver
from ftac_gym.evaluation import BaselineContestant, rollout, tuning
from ftac_gym.evaluation import tuning_objective as search
from ftac_gym.evaluation.tuning import open_study, store, tune
from ftac_gym.evaluation.tuning_objective import FAILED, Search, fly, mean_return
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.objective import SuccessCriterion

# Small turns, which fit into four seconds.
TINY = scenarios.get("flagship").replace(
    duration=4.0, success=SuccessCriterion(hold=1.0), initial_state=InitialState(angle=(0.0, 0.05))
)
SEARCH = Search("pd", TINY, episodes=5)
SIZE = SEARCH.population


class Picky(PD):
    """A law that refuses half of its search space, and blows up in some of the rest."""

    search_space: ClassVar = {"rate_gain": Range(4.0, 8.0), "braking_share": Range(0.2, 1.8)}
    gains_at = classmethod(lambda cls, point: dict(point))

    def __init__(self, scenario, num_spacecraft=1, **gains):
        super().__init__(scenario, num_spacecraft, **gains)
        self.wild = gains.get("rate_gain", 4.0) > 7.0

    def act(self, measurement):
        return super().act(measurement) * (np.nan if self.wild else 1.0)


class Straight(PD):
    """A law whose gains are searched as they are."""

    search_space: ClassVar = {"braking_share": Range(0.2, 1.0), "rate_limit": Range(0.05, 0.3, log=True)}
    gains_at = classmethod(lambda cls, point: dict(point))


@pytest.fixture
def entries(monkeypatch):
    """Laws that the registry knows for the time of a test."""
    for name, law in (("picky", Picky), ("straight", Straight)):
        monkeypatch.setitem(registry.ENTRIES, name, registry.Entry(law))


def judge(task, gains):
    """Return a mean return that is known to be largest, zero, at a rate gain of 6 and a braking share of 0.4."""
    return -((gains["rate_gain"] - 6.0) ** 2) - 10.0 * (gains["braking_share"] - 0.4) ** 2


@pytest.fixture
def flown(monkeypatch):
    """Judge gains instead of flying them; keeps what was judged."""
    calls = []
    monkeypatch.setattr(tuning, "mean_return", lambda task, gains: calls.append(gains) or judge(task, gains))
    return calls


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """What a study of two generations finds if it is left alone, and its trials."""
    folder = tmp_path_factory.mktemp("undisturbed")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(tuning, "mean_return", judge)
        return tune(SEARCH, folder, 1 + 2 * SIZE), trials_of(SEARCH, folder)


def trials_of(task, folder):
    """Return what a study did: number, state, point and value of each trial."""
    return [(item.number, item.state.name, item.params, item.values) for item in open_study(task, folder).get_trials()]


# -------------------------------------------------------------------------------------------------------- the objective


def test_the_objective_is_the_mean_return_of_feasible_episodes():
    task = Search("pd", TINY, episodes=9, seed=0)
    history = rollout(TINY, BaselineContestant("pd", rate_gain=6.0), seed=task.seed, count=9)
    feasible = history.episodes.feasible
    assert feasible.any() and not feasible.all()
    assert mean_return(task, {"rate_gain": 6.0}) == pytest.approx(history.metrics()["return"][feasible].mean())
    assert len(fly(task, {}, seed=3)["return"]) == TINY.draw(3, 9).feasible.sum()


def test_gains_that_cannot_be_flown_are_the_worst(entries):
    task = Search("picky", TINY, episodes=2)
    assert mean_return(task, {"braking_share": 1.2}) == FAILED
    assert mean_return(task, {"rate_gain": 7.5}) == FAILED
    assert math.isfinite(mean_return(task, {"rate_gain": 6.0}))


def test_gains_are_rounded_before_they_fly():
    point = {"rate_gain": 6.123456, "position_share": 0.5, "braking_share": 0.98765432, "rate_limit": 0.1,
             "attitude_filter_time": 1.0}  # fmt: skip
    gains = SEARCH.gains_at(point)
    assert gains == {"rate_gain": 6.123, "position_gain": 3.062, "braking_share": 0.9877, "rate_limit": 0.1,
                     "attitude_filter_time": 1.0}  # fmt: skip
    assert search._rounded({"part": {"gain": (1.23456, 2)}, "kind": "a"}) == {"part": {"gain": [1.235, 2]}, "kind": "a"}


def test_the_start(entries, monkeypatch):
    defaults = baselines.defaults("straight")
    assert Search("straight", TINY, episodes=2).start() == {
        name: defaults[name] for name in ("braking_share", "rate_limit")
    }
    # A share of another gain is no gain of the law, but follows from two of them.
    own = baselines.defaults(SEARCH.baseline)
    assert SEARCH.start()["position_share"] == pytest.approx(own["position_gain"] / own["rate_gain"])
    monkeypatch.setattr(Straight, "search_space", {**Straight.search_space, "rate_limit": Range(0.2, 0.8, log=True)})
    # A default outside its range: from the middle.
    assert Search("straight", TINY, episodes=2).start()["rate_limit"] == pytest.approx(0.4)


# ------------------------------------------------------------------------------------------------------------ the study


def test_it_finds_the_maximum(flown, tmp_path):
    result = tune(SEARCH, tmp_path, 10 * SIZE)
    assert result.gains["rate_gain"] == pytest.approx(6.0, abs=0.5)
    assert result.gains["braking_share"] == pytest.approx(0.4, abs=0.1)
    assert result.mean_return == max(judge(SEARCH, gains) for gains in flown) > -0.3


@pytest.mark.parametrize("trials", [1, 2, SIZE, SIZE + 1, SIZE + 2])
def test_the_budget_holds(trials, flown, tmp_path):
    seen = []
    result = tune(SEARCH, tmp_path, trials, progress=lambda done, best: seen.append((done, best)))
    assert len(flown) == result.trials == trials and result.failed == 0
    assert [done for done, _ in seen] == list(range(trials + 1))
    best = [value for _, value in seen]
    assert best[0] == FAILED and best == sorted(best) and best[-1] == result.mean_return
    own = baselines.defaults(SEARCH.baseline)
    assert {name: flown[0][name] for name in ("rate_gain", "rate_limit")} == {
        name: pytest.approx(own[name], rel=1e-3) for name in ("rate_gain", "rate_limit")
    }


@pytest.mark.parametrize("folder", ["study", "nested/study"])
def test_the_lock_of_a_killed_search_is_taken_away(folder, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(tuning, "STALE", 3)
    study = tuning.open_study(SEARCH, Path(folder))
    study._storage._backend._lock.acquire()  # a process that is killed never releases what it has acquired
    assert (Path(folder) / f"{tuning.JOURNAL}.lock").exists(), "the lock leads nowhere: it is waited for for ever"
    began = time.monotonic()
    again = tuning.open_study(SEARCH, Path(folder))
    again.set_user_attr("written", True)
    assert time.monotonic() - began < 20.0
    assert not (Path(folder) / f"{tuning.JOURNAL}.lock").is_symlink()


def test_a_resumed_study_flies_the_rest_only(flown, tmp_path):
    whole = tune(SEARCH, tmp_path / "whole", 3 * SIZE)
    wanted = flown.copy()
    flown.clear()
    for trials in (1, 3, SIZE + 1, SIZE + 2, 3 * SIZE):
        result = tune(SEARCH, tmp_path / "parts", trials)
        assert len(flown) == trials
    assert flown == wanted and result == whole
    assert trials_of(SEARCH, tmp_path / "parts") == trials_of(SEARCH, tmp_path / "whole")
    # A smaller budget than what is there flies nothing, and keeps the best of all.
    assert tune(SEARCH, tmp_path / "parts", 2) == whole and len(flown) == 3 * SIZE


@pytest.mark.parametrize(
    ("where", "after"),
    [("suggest_float", count) for count in (1, 3, 6, 24, 46, 48, 83)] + [("tell", count) for count in (1, 2, 6, 17)],
)
def test_a_kill_anywhere_changes_nothing(where, after, flown, undisturbed, tmp_path, monkeypatch):
    """Killed while it asks for points, some of them half drawn, and while it takes down what they are worth."""

    class KilledError(Exception):
        pass

    owner = tuning.Trial if where == "suggest_float" else tuning.optuna.Study
    real, calls = getattr(owner, where), []

    def deadly(*arguments, **options):
        calls.append(arguments)
        if len(calls) == after:
            raise KilledError
        return real(*arguments, **options)

    monkeypatch.setattr(owner, where, deadly)
    with pytest.raises(KilledError):
        tune(SEARCH, tmp_path, 1 + 2 * SIZE)
    monkeypatch.setattr(owner, where, real)
    whole, trials = undisturbed
    assert tune(SEARCH, tmp_path, 1 + 2 * SIZE) == whole
    assert trials_of(SEARCH, tmp_path) == trials


def test_workers_change_nothing(tmp_path):
    results = [tune(SEARCH, tmp_path / str(workers), SIZE + 4, workers=workers) for workers in (1, 2)]
    assert results[0] == results[1] and math.isfinite(results[0].mean_return)
    assert trials_of(SEARCH, tmp_path / "1") == trials_of(SEARCH, tmp_path / "2")
    assert results[0].mean_return == mean_return(SEARCH, results[0].gains)


def test_another_seed_of_the_sampler_is_another_search(flown, tmp_path):
    tune(SEARCH, tmp_path / "0", 3)
    tune(Search("pd", TINY, episodes=5, sampler_seed=1), tmp_path / "1", 3)
    assert flown[0] == flown[3] and flown[1] != flown[4]


def test_gains_that_fail_do_not_stop_it(entries, tmp_path):
    task = Search("picky", TINY, episodes=2)
    result = tune(task, tmp_path, 3 * task.population)
    assert 0 < result.failed < result.trials == 3 * task.population
    assert result.gains["braking_share"] <= 1.0 and result.gains["rate_gain"] <= 7.0
    # They are ranked last, so that fewer and fewer of them are tried.
    values = [values[0] for _, state, _, values in trials_of(task, tmp_path) if state == "COMPLETE"]
    assert values.count(FAILED) == result.failed


def test_nothing_that_flies(monkeypatch, tmp_path):
    monkeypatch.setattr(tuning, "mean_return", lambda task, gains: FAILED)
    with pytest.raises(ValueError, match="trials must have one whose gains can be flown, got 4"):
        tune(SEARCH, tmp_path, 4)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"episodes": 6}, r"differs in episodes \(5, now 6\), got"),
        ({"seed": 7, "sampler_seed": 2}, r"differs in seed \(800000, now 7\), sampler_seed \(0, now 2\), got"),
        ({"scenario": TINY.replace(duration=4.5)}, r"differs in scenario, got"),
        ({"baseline": "pd_dob"}, r"differs in baseline \('pd', now 'pd_dob'\), .*space, got"),
    ],
)
def test_a_study_of_another_setting_is_refused(changes, message, flown, tmp_path):
    tune(SEARCH, tmp_path, 2)
    before = (tmp_path / tuning.JOURNAL).read_bytes()
    arguments = {"baseline": "pd", "scenario": TINY, "episodes": 5, **changes}
    with pytest.raises(ValueError, match=rf"folder must hold a study of the same setting; this one {message}"):
        tune(Search(**arguments), tmp_path, 3)
    assert len(flown) == 2 and (tmp_path / tuning.JOURNAL).read_bytes() == before


def test_a_study_of_another_space_is_refused(entries, flown, tmp_path, monkeypatch):
    task = Search("pd_dob", TINY, episodes=5)
    tune(task, tmp_path, 1)
    wider = {**PDDisturbanceObserver.search_space, "bandwidth": Range(0.2, 9.0)}
    monkeypatch.setattr(PDDisturbanceObserver, "search_space", wider)
    with pytest.raises(ValueError, match="this one differs in space, got"):
        tune(task, tmp_path, 2)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"baseline": "nobody"}, "baseline must be one of .*'nobody'"),
        ({"episodes": 0}, "episodes must be positive, got 0"),
        ({"seed": 10_000}, "seed and the next must not be of the frozen test episodes.*got 10000"),
        ({"seed": 11_999}, "seed and the next must not be of the frozen test episodes.*got 11999"),
        ({"scenario": TINY.replace(duration=1.0)}, "episodes must have a feasible one among them, got 5"),
    ],
)
def test_a_search_is_checked(arguments, message):
    with pytest.raises(ValueError, match=message):
        Search(**{"baseline": "pd", "scenario": TINY, "episodes": 5, **arguments})


def test_one_gain_is_not_enough(entries, monkeypatch):
    monkeypatch.setattr(Picky, "search_space", {"rate_gain": Range(4.0, 8.0)})
    with pytest.raises(ValueError, match="baseline must have at least two gains to search, got 'picky'"):
        Search("picky", TINY)


@pytest.mark.parametrize("name", ["trials", "workers"])
def test_numbers_are_checked(name, tmp_path):
    with pytest.raises(ValueError, match=f"{name} must be positive, got 0"):
        tune(SEARCH, tmp_path / "new", **{"trials": 3, name: 0})
    assert not (tmp_path / "new").exists()


# -------------------------------------------------------------------------------------------------------- tuned gains


def test_stored_gains_are_data_with_their_provenance(flown, tmp_path, monkeypatch):
    monkeypatch.setattr(tuned, "FOLDER", tmp_path / "tuned_gains")
    result = tune(SEARCH, tmp_path / "study", 4)
    path = store(result, "python train/tune.py", "abc", {"tuned": 1.5, "default": 1.0})
    assert path == tmp_path / "tuned_gains" / "pd.json" and [path] == list(path.parent.iterdir())
    assert tuned.names() == ["pd"] and tuned.gains("pd") == result.gains
    provenance = tuned.record("pd")["provenance"]
    assert provenance.items() >= {
        "command": "python train/tune.py", "commit": "abc", "baseline": "pd", "scenario": "flagship", "seed": 800_000,
        "episodes": 5, "trials": 4, "mean_return": result.mean_return, "fresh_seed": 800_001,
        "fresh_mean_return": {"tuned": 1.5, "default": 1.0},
    }.items()  # fmt: skip
    assert "optuna" in provenance["sampler"] and str(tmp_path) not in path.read_text()
    baseline = baselines.make("pd", TINY, gains="tuned")
    assert baseline._rate_gain == result.gains["rate_gain"]
    explicit = rollout(TINY, BaselineContestant("pd", **result.gains), seed=1, count=2)
    named = rollout(TINY, BaselineContestant("pd", gains="tuned"), seed=1, count=2)
    np.testing.assert_array_equal(named.command, explicit.command)
    assert (named.command != rollout(TINY, "pd", seed=1, count=2).command).any()


def test_the_fingerprint_of_tuned_gains_is_what_they_are(tmp_path, monkeypatch):
    monkeypatch.setattr(tuned, "FOLDER", tmp_path)

    def fingerprint(gains, **changes):
        (tmp_path / "pd.json").write_text(json.dumps({"gains": gains, "provenance": {}}))
        return BaselineContestant("pd", "tuned", **changes).fingerprint

    first, second = fingerprint({"rate_gain": 6.0}), fingerprint({"rate_gain": 6.5})
    assert len({first, second, BaselineContestant("pd").fingerprint}) == 3
    assert first == BaselineContestant("pd", rate_gain=6.0).fingerprint
    assert fingerprint({"rate_gain": 6.0}, rate_gain=6.5) == second
    # The gains that it flies are those of its fingerprint, even if they are tuned anew in between.
    contestant = BaselineContestant("pd", "tuned")
    expected = rollout(TINY, contestant, seed=0, count=1).command
    fingerprint({"rate_gain": 2.0})
    np.testing.assert_array_equal(rollout(TINY, contestant, seed=0, count=1).command, expected)


def test_gains_that_are_not_there(tmp_path, monkeypatch):
    monkeypatch.setattr(tuned, "FOLDER", tmp_path)
    with pytest.raises(ValueError, match=r"gains must be tuned first: .*--baseline pd --store.*got 'pd'"):
        BaselineContestant("pd", gains="tuned")
    with pytest.raises(ValueError, match=r"gains must be one of \['default', 'tuned'\], got 'best'"):
        BaselineContestant("pd", gains="best")
    with pytest.raises(ValueError, match=r"gains must be .default. for a baseline not of this package.*tuned"):
        BaselineContestant(PD, gains="tuned")


def test_the_package_does_not_need_optuna():
    code = "import sys, ftac_gym.evaluation, ftac_gym.evaluation.tuning_objective; sys.exit('optuna' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0
