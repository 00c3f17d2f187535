"""Tuned gains as data with their provenance."""

import json

import numpy as np
import pytest
from helpers.tuning_cases import SEARCH, TINY

from ftac_gym import baselines, scenarios
from ftac_gym.baselines import tuned
from ftac_gym.baselines.controllers.pd import PD
from ftac_gym.evaluation import rollout, tuning
from ftac_gym.evaluation.entries import entries_of
from ftac_gym.evaluation.tuning import store, tune
from ftac_gym.policies import DeferredBaseline, policy_label, resolve
from ftac_gym.report.provenance import policy_name


def test_stored_gains_are_data_with_their_provenance(tmp_path, monkeypatch):
    monkeypatch.setattr(tuning, "value_of", lambda task, gains: -abs(gains["rate_gain"] - 3.0))
    monkeypatch.setattr(tuned, "FOLDER", tmp_path / "tuned_gains")
    result = tune(SEARCH, tmp_path / "study", 4)
    path = store(result, "python train/tune.py", "abc", {"tuned": 1.5, "default": 1.0})
    assert path == tmp_path / "tuned_gains" / "pd.json" and [path] == list(path.parent.iterdir())
    assert tuned.names() == ["pd"] and tuned.gains("pd") == result.gains
    provenance = tuned.record("pd")["provenance"]
    assert provenance.items() >= {
        "command": "python train/tune.py", "commit": "abc", "baseline": "pd", "scenario": "flagship", "seed": 800_000,
        "episodes": 5, "trials": 4, "objective": "availability", "value": result.value,
        "validation_digest": SEARCH.validation().digest(), "validation_values": {"tuned": 1.5, "default": 1.0},
    }.items()  # fmt: skip
    assert "cmaes" in provenance["sampler"] and str(tmp_path) not in path.read_text()
    baseline = baselines.make("pd", TINY, gains="tuned")
    assert baseline.gains.rate_gain == result.gains["rate_gain"]
    explicit = rollout(TINY, DeferredBaseline("pd", **result.gains), seed=1, count=2)
    named = rollout(TINY, DeferredBaseline("pd", gains="tuned"), seed=1, count=2)
    np.testing.assert_array_equal(named.command, explicit.command)
    assert (named.command != rollout(TINY, "pd", seed=1, count=2).command).any()


@pytest.mark.parametrize("name", tuned.names())
def test_the_stored_gains_of_any_version_load(name):
    record = tuned.record(name)
    provenance = record["provenance"]
    # Files of 0.1 have the mean return, which was the only objective.
    value = provenance["value"] if "objective" in provenance else provenance["mean_return"]
    assert np.isfinite(value) and provenance["baseline"] == name
    scenario = scenarios.get(provenance["scenario"])
    assert baselines.make(name, scenario, gains="tuned").gains is not None


def test_the_fingerprint_of_tuned_gains_is_what_they_are(tmp_path, monkeypatch):
    monkeypatch.setattr(tuned, "FOLDER", tmp_path)

    def fingerprint(gains, **changes):
        (tmp_path / "pd.json").write_text(
            json.dumps({"gains": gains, "provenance": {"scenario": "flagship", "trials": 1}})
        )
        return DeferredBaseline("pd", "tuned", **changes).fingerprint

    first, second = fingerprint({"rate_gain": 6.0}), fingerprint({"rate_gain": 6.5})
    assert len({first, second, DeferredBaseline("pd").fingerprint}) == 3
    assert first == DeferredBaseline("pd", rate_gain=6.0).fingerprint
    assert fingerprint({"rate_gain": 6.0}, rate_gain=6.5) == second
    # A policy flies the gains of its fingerprint, even if they are tuned again in between.
    policy = DeferredBaseline("pd", "tuned")
    expected = rollout(TINY, policy, seed=0, count=1).command
    fingerprint({"rate_gain": 2.0})
    np.testing.assert_array_equal(rollout(TINY, policy, seed=0, count=1).command, expected)


def test_gains_that_are_not_there(tmp_path, monkeypatch):
    monkeypatch.setattr(tuned, "FOLDER", tmp_path)
    with pytest.raises(ValueError, match=r"gains must be tuned first: .*--baseline pd --store.*got 'pd'"):
        DeferredBaseline("pd", gains="tuned")
    with pytest.raises(
        ValueError, match=r"gains must be one of \['default', 'tuned'\], or a file FILE\.json of ftac-tune, got 'best'"
    ):
        DeferredBaseline("pd", gains="best")
    with pytest.raises(ValueError, match=r"gains must be .default. for a baseline not of this package.*tuned"):
        DeferredBaseline(PD, gains="tuned")


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ('{"gains": {"rate_gain": 6.0}, "prov', ".*"),
        ('{"gains": {"rate_gain": NaN}, "provenance": {}}', "JSON.* must be finite, got nan"),
        ('{"gains": {"rate_gain": 6.0, "rate_gain": 7.0}, "provenance": {}}', "JSON.* must have every key once"),
        ('{"gains": [6.0], "provenance": {}}', r"gains must be an object, got \[6.0\]"),
        ('{"gains": {}, "provenance": {"scenario": "flagship", "trials": "7"}}', "trials of the provenance must be"),
    ],
)
def test_damaged_gains_are_named_with_the_remedy(text, reason, tmp_path, monkeypatch):
    monkeypatch.setattr(tuned, "FOLDER", tmp_path)
    (tmp_path / "pd.json").write_text(text)
    message = rf"pd\.json cannot be read: {reason}.*; tune it again: .*--baseline pd --store$"
    with pytest.raises(ValueError, match=message):
        DeferredBaseline("pd", "tuned")


def test_gains_of_a_file_are_of_its_baseline(tmp_path):
    path = tmp_path / "gains.json"
    provenance = {"baseline": "pd", "scenario": "mine", "trials": 1}
    path.write_text(json.dumps({"gains": {"rate_gain": 6.0}, "provenance": provenance}))
    same = DeferredBaseline("pd", rate_gain=6.0).fingerprint
    assert DeferredBaseline("pd", str(path)).fingerprint == same == resolve(f"pd {path}").fingerprint
    assert policy_label(resolve(f"pd {path}")) == f"pd {path}"
    assert resolve("pd", gains=str(path)).fingerprint == same
    assert baselines.make("pd", TINY, gains=str(path)).gains.rate_gain == 6.0
    entry = entries_of([f"pd {path}"], TINY)[0]
    assert (entry.name, entry.gains, entry.provenance) == (f"pd {path}", "tuned", provenance)
    assert policy_name(entry, 0) == f"pd {path}"
    with pytest.raises(
        ValueError, match=r"gains\.json cannot be read: .*must be 'pd_dob', got 'pd'; tune again: ftac-tune"
    ):
        DeferredBaseline("pd_dob", str(path))
    with pytest.raises(ValueError, match=r"absent\.json cannot be read"):
        resolve(f"pd {tmp_path / 'absent.json'}")
