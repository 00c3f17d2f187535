"""The ablation of the estimators: its variants differ by one component, and its tables hold what was flown."""

import csv
from dataclasses import replace

import ablation as script
import numpy as np
import pytest

from ftac_gym import baselines, scenarios
from ftac_gym.evaluation import rollout
from ftac_gym.policies import DeferredBaseline

TASK = scenarios.get("flagship").replace(duration=3.0)


@pytest.fixture(scope="module")
def episodes():
    return replace(TASK.draw(0, 3), feasible=np.array([True, False, True]))


@pytest.fixture
def short(monkeypatch, episodes):
    monkeypatch.setattr(script, "task_of", lambda split: TASK)
    monkeypatch.setattr(script, "judging_episodes", lambda task, count, kind: episodes)


@pytest.mark.parametrize("law", script.BEFORE)
def test_a_variant_differs_from_its_reference_by_one_component(law):
    found = {item.name: item for item in script.variants(law)}
    estimators = ("filter", "gate", "prediction", "isolation", "plant_braking")
    usual = {name: value for name, value in baselines.registry.defaults(law).items() if name in estimators}
    for item in found.values():
        assert item.reference in found or not item.reference
        if item.name in ("fixed-gain filter", script.TUNED_STEP):
            continue
        own, other = ({**usual, **found[name].changes} for name in (item.name, item.reference))
        changed = {name for name in usual if own[name] != other[name]}
        # Isolation comes with the nominal plant's braking; the gate of no filter has no effect.
        assert len(changed - {"plant_braking", "gate"}) <= 1 and changed, item.name
        assert {name for name in own if name not in usual and own[name] != other.get(name)} == set()
    assert next(iter(found)) == "fixed-gain filter" and script.TUNED_STEP in found


@pytest.mark.parametrize("law", script.BEFORE)
def test_the_first_step_has_no_estimator_and_the_tuned_one_all(law):
    found = {item.name: item for item in script.variants(law)}
    parts = []
    for name in ("fixed-gain filter", script.TUNED_STEP):
        navigator = baselines.build(law, TASK, 1, found[name].gains, **found[name].changes)._navigator
        parts.append([] if navigator is None else [navigator.filter, navigator.estimator, navigator.prediction])
    assert all(part is None for part in parts[0]) and len(parts[1]) == 3
    assert all(part is not None for part in parts[1])


def test_only_a_law_along_the_profile_has_braking_to_leave_out():
    names = {law: [item.name for item in script.variants(law)] for law in script.BEFORE}
    assert "+ braking" in names["pd_dob"] and "- braking" in names["pd_dob"]
    assert not any("braking" in name for name in names["nftsm_isolation"])


def test_stored_momentum_is_the_flagship_with_other_wheels():
    task, flagship = script.task_of("stored_momentum"), scenarios.get("flagship")
    assert task.initial_state.wheel_momentum == (4.0, 6.0)
    assert task.replace(name="flagship", initial_state=flagship.initial_state).to_json() == flagship.to_json()
    assert script.task_of("flagship_noise").to_json() == scenarios.get("flagship_noise").to_json()


def test_results_are_those_of_the_variants(short, episodes):
    results = {item.variant.name: item for item in script.ablate("pd_dob", "flagship", 2)}
    assert list(results) == [item.name for item in script.variants("pd_dob")]
    last = results["- prediction"]
    policy = DeferredBaseline("pd_dob", "tuned", **last.variant.changes)
    own = rollout(TASK, policy, episodes).metrics()["availability"][[0, 2]]
    assert last.estimates["availability"].value == pytest.approx(own.mean())
    assert last.estimates["success"].count == 2 and last.split == "flagship"
    other = results[script.TUNED_STEP].estimates["availability"].value
    assert last.differences["availability"].value == pytest.approx(own.mean() - other)
    assert not results["fixed-gain filter"].differences


def test_the_program_writes_both_files(short, tmp_path, capsys):
    script.main(script.Config(laws=("pd_dob",), episodes=2, splits=("flagship", "flagship_delay"), output=tmp_path))
    text = (tmp_path / "ablation.inc").read_text()
    assert text.strip() == capsys.readouterr().out.strip()
    assert text.count("### `pd_dob`: ") == 4 and "|  | flagship | delay |" in text
    with (tmp_path / "ablation.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 2 * len(script.variants("pd_dob")) and {row["episodes"] for row in rows} == {"2"}
    assert [row["success_change"] == "" for row in rows] == [row["reference"] == "" for row in rows]


def test_laws_without_known_gains_are_refused():
    with pytest.raises(ValueError, match=r"laws must be among \['nftsm_isolation', 'pd_dob'\], got 'chen_m1'"):
        script.variants("chen_m1")
