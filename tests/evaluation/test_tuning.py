"""Studies of tuning: a budget that holds, and the same result after an interruption."""

import errno
import json
import math
import os

import numpy as np
import pytest
from helpers.tuning_cases import SEARCH, TINY, judge, register

from ftac_gym import baselines, scenarios
from ftac_gym.baselines import Range
from ftac_gym.baselines.controllers.pd import PDDisturbanceObserver
from ftac_gym.evaluation import tuning
from ftac_gym.evaluation.tuning import JOURNAL, Study, tune
from ftac_gym.evaluation.tuning_objective import FAILED, Search, value_of
from ftac_gym.utils.files import locked

SIZE = SEARCH.population
WHOLE = 1 + 2 * SIZE


@pytest.fixture
def entries(monkeypatch):
    """Register the small baselines."""
    register(monkeypatch)


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """Return the result of a study of two generations without interruption, and its journal."""
    folder = tmp_path_factory.mktemp("undisturbed")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(tuning, "value_of", judge)
        return tune(SEARCH, folder, WHOLE), (folder / JOURNAL).read_bytes()


def test_it_finds_the_maximum(flown, tmp_path):
    result = tune(SEARCH, tmp_path, 10 * SIZE)
    assert result.gains["rate_gain"] == pytest.approx(1.2, abs=0.1)
    assert result.gains["braking_share"] == pytest.approx(0.4, abs=0.1)
    assert result.value == max(judge(SEARCH, gains) for gains in flown) > -0.3


@pytest.mark.parametrize("trials", [1, 2, SIZE, SIZE + 1, SIZE + 2])
def test_the_budget_holds(trials, flown, tmp_path):
    seen = []
    result = tune(SEARCH, tmp_path, trials, progress=lambda done, best: seen.append((done, best)))
    assert len(flown) == result.trials == trials and result.failed == 0
    assert [done for done, _ in seen] == list(range(trials + 1))
    best = [value for _, value in seen]
    assert best[0] == FAILED and best == sorted(best) and best[-1] == result.value
    defaults = baselines.defaults(SEARCH.baseline)
    assert {name: flown[0][name] for name in ("rate_gain", "rate_limit")} == {
        name: pytest.approx(defaults[name], rel=1e-3) for name in ("rate_gain", "rate_limit")
    }


def test_the_journal_has_a_line_for_the_setting_and_one_for_each_trial(flown, tmp_path):
    tune(SEARCH, tmp_path, 3)
    setting, *trials = (json.loads(line) for line in (tmp_path / JOURNAL).read_text().splitlines())
    assert setting["baseline"] == "pd" and setting["episodes"] == 5 and setting["objective"] == "availability"
    assert trials == [{"gains": gains, "value": judge(SEARCH, gains)} for gains in flown]


def test_a_resumed_study_flies_the_rest_only(flown, tmp_path):
    whole = tune(SEARCH, tmp_path / "whole", 3 * SIZE)
    expected = flown.copy()
    flown.clear()
    for trials in (1, 3, SIZE + 1, SIZE + 2, 3 * SIZE):
        result = tune(SEARCH, tmp_path / "parts", trials)
        assert len(flown) == trials
    assert flown == expected and result == whole
    assert (tmp_path / "parts" / JOURNAL).read_bytes() == (tmp_path / "whole" / JOURNAL).read_bytes()
    # A smaller budget than that of the journal flies nothing, and keeps the best of all.
    assert tune(SEARCH, tmp_path / "parts", 2) == whole and len(flown) == 3 * SIZE


@pytest.mark.parametrize("after", range(WHOLE))
def test_a_kill_between_any_two_trials_changes_nothing(after, flown, undisturbed, tmp_path, monkeypatch):
    class KilledError(Exception):
        pass

    def killed(task, gains):
        if len(flown) == after:
            raise KilledError
        flown.append(gains)
        return judge(task, gains)

    monkeypatch.setattr(tuning, "value_of", killed)
    with pytest.raises(KilledError):
        tune(SEARCH, tmp_path, WHOLE)
    assert len(Study(SEARCH, tmp_path).trials) == after
    monkeypatch.setattr(tuning, "value_of", judge)
    assert (tune(SEARCH, tmp_path, WHOLE), (tmp_path / JOURNAL).read_bytes()) == undisturbed


def test_one_process_at_a_time_tunes_in_a_folder(flown, tmp_path):
    with locked(tmp_path), pytest.raises(ValueError, match=r"folder must be used by one process at a time; process \d"):
        tune(SEARCH, tmp_path, 2)
    assert not flown
    assert tune(SEARCH, tmp_path, 2).trials == 2


def test_it_needs_no_links(flown, tmp_path, monkeypatch):
    """Windows and some mounts have none."""

    def refused(*_, **__):
        raise OSError(errno.EPERM, "Operation not permitted")

    for name in ("link", "symlink"):
        monkeypatch.setattr(os, name, refused)
    assert tune(SEARCH, tmp_path, 3).trials == len(flown) == 3


def test_workers_change_nothing(tmp_path):
    results = [tune(SEARCH, tmp_path / str(workers), SIZE + 4, workers=workers) for workers in (1, 2)]
    assert results[0] == results[1] and math.isfinite(results[0].value)
    assert (tmp_path / "1" / JOURNAL).read_bytes() == (tmp_path / "2" / JOURNAL).read_bytes()
    assert results[0].value == value_of(SEARCH, results[0].gains)


def test_another_seed_of_the_sampler_is_another_search(flown, tmp_path):
    tune(SEARCH, tmp_path / "0", 3)
    tune(Search("pd", TINY, episodes=5, sampler_seed=1), tmp_path / "1", 3)
    assert flown[0] == flown[3] and flown[1] != flown[4]


@pytest.mark.usefixtures("entries")
def test_gains_that_fail_do_not_stop_it(tmp_path):
    task = Search("selective", TINY, episodes=2)
    result = tune(task, tmp_path, 3 * task.population)
    assert 0 < result.failed < result.trials == 3 * task.population
    assert result.gains["braking_share"] <= 1.0 and result.gains["rate_gain"] <= 1.4
    values = [trial.value for trial in Study(task, tmp_path).trials]
    assert values.count(FAILED) == result.failed
    assert tune(task, tmp_path, 3 * task.population) == result


def test_nothing_that_flies(monkeypatch, tmp_path):
    monkeypatch.setattr(tuning, "value_of", lambda task, gains: FAILED)
    with pytest.raises(ValueError, match="trials must have one whose gains can be flown, got 4"):
        tune(SEARCH, tmp_path, 4)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"episodes": 6}, r"differs in episodes \(5, now 6\), got"),
        ({"objective": "return"}, r"differs in objective \('availability', now 'return'\), got"),
        ({"seed": 7, "sampler_seed": 2}, r"differs in seed \(800000, now 7\), sampler_seed \(0, now 2\), got"),
        ({"scenario": TINY.replace(duration=4.5)}, r"differs in scenario, got"),
        ({"baseline": "pd_dob"}, r"differs in baseline \('pd', now 'pd_dob'\), .*space, got"),
    ],
)
def test_a_study_of_another_setting_is_refused(changes, message, flown, tmp_path):
    tune(SEARCH, tmp_path, 2)
    before = (tmp_path / JOURNAL).read_bytes()
    arguments = {"baseline": "pd", "scenario": TINY, "episodes": 5, **changes}
    with pytest.raises(ValueError, match=rf"folder must hold a study of the same setting; this one {message}"):
        tune(Search(**arguments), tmp_path, 3)
    assert len(flown) == 2 and (tmp_path / JOURNAL).read_bytes() == before


def test_a_study_of_another_space_is_refused(entries, flown, tmp_path, monkeypatch):
    task = Search("pd_dob", TINY, episodes=5)
    tune(task, tmp_path, 1)
    wider = {**PDDisturbanceObserver.search_space, "bandwidth": Range(0.04, 2.0)}
    monkeypatch.setattr(PDDisturbanceObserver, "search_space", wider)
    with pytest.raises(ValueError, match="this one differs in space, got"):
        tune(task, tmp_path, 2)


@pytest.mark.parametrize("name", ["trials", "workers"])
@pytest.mark.parametrize("value", [0, 2.5, "2", None, True])
def test_numbers_are_checked(name, value, tmp_path):
    with pytest.raises(ValueError, match=f"{name} must be a whole number, 1 or more, got {value!r}"):
        tune(SEARCH, tmp_path / "new", **{"trials": 3, name: value})
    assert not (tmp_path / "new").exists()


def test_a_search_that_begins_at_the_tuned_gains_is_never_worse(tmp_path):
    search = Search("pd_dob", scenarios.get("flagship_pointing"), episodes=4, first="tuned")
    point = search.start()
    np.testing.assert_allclose(list(search.point_at(search.shares_at(point)).values()), list(point.values()))
    flown = tune(search, tmp_path, 3)
    assert flown.value >= value_of(search, baselines.chosen("pd_dob", "tuned", {}))
    with pytest.raises(ValueError, match=r"first must be one of \['default', 'tuned'\], got 'best'"):
        Search("pd_dob", scenarios.get("flagship"), first="best")
