"""Evaluations in batches that survive a kill, comparisons, and fault classes."""

from importlib import import_module

import numpy as np
import pytest

from ftac_gym import scenarios
from ftac_gym.evaluation import Evaluation, compare, evaluate, fault_classes, rollout
from ftac_gym.evaluation.compare import ERROR_AND_VIBRATION, TABLE_METRICS
from ftac_gym.evaluation.metrics import UNITS
from ftac_gym.faults import (
    Bias,
    FaultDistribution,
    FaultSchedule,
    GyroBiasStep,
    HardOver,
    LockInPlace,
    LossOfEffectiveness,
    Outage,
    StarTrackerOutage,
)
from ftac_gym.policies import DeferredBaseline

SHORT = scenarios.get("flagship").replace(duration=5.0)
EPISODES = SHORT.draw(3, 7)


@pytest.fixture
def small_batches(monkeypatch):
    """Three episodes to a batch, so that seven episodes make three batches; counts the rollouts."""
    module = import_module("ftac_gym.evaluation.batches")
    calls = []

    def counted(scenario, policy, episodes):
        calls.append(len(episodes))
        return rollout(scenario, policy, episodes)

    monkeypatch.setattr(module, "BATCH", 3)
    monkeypatch.setattr(module, "rollout", counted)
    return calls


def assert_same(first, second, exact=True):
    assert first.policy == second.policy and list(first.metrics) == list(second.metrics)
    tolerance = {"rtol": 0.0, "atol": 0.0} if exact else {"rtol": 1e-7, "atol": 1e-9}
    for name, values in first.metrics.items():
        np.testing.assert_allclose(second.metrics[name], values, **tolerance, err_msg=name)
    np.testing.assert_allclose(second.attitude_error, first.attitude_error, rtol=0.0 if exact else 1e-5, atol=1e-7)


def test_an_evaluation_is_a_rollout(small_batches):
    finished = []
    evaluation = evaluate(SHORT, "pd", EPISODES, progress=finished.append)
    history = rollout(SHORT, "pd", EPISODES)
    assert_same(evaluation, Evaluation("pd", history.metrics(), np.degrees(history.attitude_error)), exact=False)
    assert evaluation.attitude_error.dtype == np.float32 and evaluation.attitude_error.shape == (51, 7)
    assert small_batches == finished == [3, 3, 1]


def test_finished_batches_are_not_run_again(small_batches, tmp_path):
    folder = tmp_path / "deep" / "batches"
    first = evaluate(SHORT, "pd", EPISODES, folder=folder)
    assert small_batches == [3, 3, 1]
    assert_same(evaluate(SHORT, "pd", EPISODES, folder=folder), first)
    assert_same(evaluate(SHORT, DeferredBaseline("pd"), EPISODES, name="pd", folder=folder), first)
    assert small_batches == [3, 3, 1]
    assert_same(evaluate(SHORT, "pd", EPISODES), first)


def test_a_kill_loses_only_the_batch_in_hand(small_batches, tmp_path):
    class KilledError(Exception):
        pass

    def kill(count):
        if len(small_batches) == 2:
            raise KilledError

    with pytest.raises(KilledError):
        evaluate(SHORT, "pd", EPISODES, folder=tmp_path, progress=kill)
    (tmp_path / "half_written.partial").write_bytes(b"PK")
    resumed = evaluate(SHORT, "pd", EPISODES, folder=tmp_path)
    assert small_batches == [3, 3, 1]
    assert_same(resumed, evaluate(SHORT, "pd", EPISODES))


def test_a_kill_while_writing_leaves_no_broken_batch(small_batches, tmp_path, monkeypatch):
    class KilledError(Exception):
        pass

    def half(file, **arrays):
        file.write(b"PK\x03\x04 half a file")
        raise KilledError

    with monkeypatch.context() as patch:
        patch.setattr(np, "savez_compressed", half)
        with pytest.raises(KilledError):
            evaluate(SHORT, "pd", EPISODES, folder=tmp_path)
    assert_same(evaluate(SHORT, "pd", EPISODES, folder=tmp_path), evaluate(SHORT, "pd", EPISODES))


@pytest.mark.parametrize(
    ("scenario", "policy", "episodes"),
    [
        (SHORT, "pd_dob", EPISODES),
        (SHORT, DeferredBaseline("pd", braking_share=0.33), EPISODES),
        (SHORT, "pd", SHORT.draw(4, 7)),
        (SHORT.replace(faults=None), "pd", SHORT.replace(faults=None).draw(3, 7)),
    ],
    ids=["policy", "gains", "seed", "scenario"],
)
def test_something_else_is_run(small_batches, tmp_path, scenario, policy, episodes):
    evaluate(SHORT, "pd", EPISODES, folder=tmp_path)
    evaluation = evaluate(scenario, policy, episodes, name="other", folder=tmp_path)
    assert small_batches == [3, 3, 1] * 2
    np.testing.assert_array_equal(evaluation.metrics["return"], evaluate(scenario, policy, episodes).metrics["return"])


def test_the_task_is_part_of_what_a_batch_was_made_by(small_batches, tmp_path):
    """The same episodes flown under another criterion, or for longer, are something else."""
    evaluate(SHORT, "pd", EPISODES, folder=tmp_path)
    longer = SHORT.replace(duration=6.0)
    evaluation = evaluate(longer, "pd", EPISODES, folder=tmp_path)
    assert evaluation.attitude_error.shape == (61, 7)
    assert_same(evaluation, evaluate(longer, "pd", EPISODES))


def test_a_policy_without_fingerprint_is_always_run(small_batches, tmp_path):
    class Idle:
        tier = "attitude"

        def attach(self, env):
            return env

        def predict(self, observation, state, episode_start, deterministic):
            return np.zeros((len(observation), 4)), None

    for _ in range(2):
        assert evaluate(SHORT, Idle(), EPISODES, name="idle", folder=tmp_path).policy == "idle"
    assert small_batches == [3, 3, 1] * 2 and list(tmp_path.iterdir()) == []


def test_bounds_stand_in_the_table_only_where_the_scenario_has_them():
    all_of_them = np.ones(60, dtype=bool)
    free = [synthetic("new", 0.5), synthetic("old", 0.0)]
    for item in free:
        for metric in ("bound_kept", "bound_margin"):
            item.metrics[metric] = np.full(60, np.nan)
    (row, _) = compare(free, "old", all_of_them)
    assert not {"bound_kept", "bound_margin"} & set(row.estimates)
    kept = np.arange(60) < 45
    bound = [synthetic("new", 0.5), synthetic("old", 0.0)]
    bound[0].metrics["bound_kept"] = kept.astype(float)
    assert compare(bound, "old", all_of_them)[0].estimates["bound_kept"].value == 0.75  # a share: the mean


def synthetic(name, shift, count=60):
    """Return an evaluation whose metrics share their luck with all others."""
    luck = np.random.default_rng(0).exponential(5.0, count)
    metrics = dict.fromkeys(UNITS, luck + shift)
    metrics["success"] = (luck < 5.0 + shift).astype(float)
    metrics["recovery_time"] = np.where(np.arange(count) % 2 == 0, metrics["recovery_time"], np.nan)
    return Evaluation(name, metrics, np.zeros((3, count), dtype=np.float32))


def test_compare():
    all_of_them = np.ones(60, dtype=bool)
    rows = compare([synthetic("new", 0.5), synthetic("old", 0.0)], "old", all_of_them)
    assert [row.policy for row in rows] == ["new", "old"]
    new, old = rows
    assert set(new.estimates) == set(old.estimates) == {*TABLE_METRICS, ERROR_AND_VIBRATION}
    assert set(new.differences) == {*TABLE_METRICS, ERROR_AND_VIBRATION} and not old.differences
    assert new.differences["energy"].value == pytest.approx(0.5) and new.differences["energy"].excludes_zero
    assert new.differences["recovery_time"].count == 30
    share = synthetic("old", 0.0).metrics["success"].mean()
    assert old.estimates["success"].value == pytest.approx(share)
    assert old.estimates["energy"].value < synthetic("old", 0.0).metrics["energy"].mean()  # robust against the tail


def test_compare_counts_only_the_chosen():
    chosen = np.arange(60) < 20
    evaluation = synthetic("only", 0.0)
    (row,) = compare([evaluation], "only", chosen)
    assert row.estimates["success"].value == pytest.approx(evaluation.metrics["success"][:20].mean())
    assert row.estimates["energy"].count == 20 and row.estimates["recovery_time"].count == 10


def test_compare_refuses_an_unknown_reference():
    with pytest.raises(ValueError, match=r"reference must be one of \['new', 'old'\], got 'none'"):
        compare([synthetic("new", 0.5), synthetic("old", 0.0)], "none", np.ones(60, dtype=bool))


def test_fault_classes():
    timing = {"wheel": 1, "onset": 1.0}
    kinds = {
        "bias": Bias(**timing, constant=0.1),
        "outage": Outage(**timing),
        "lock in place": LockInPlace(**timing),
        "hard over": HardOver(**timing),
        "loss of effectiveness": LossOfEffectiveness(**timing, effectiveness=0.5),
    }
    for label, fault in kinds.items():
        assert fault_classes(SHORT.replace(faults=FaultSchedule((fault,))).draw(0, 2)).tolist() == [label] * 2
    assert fault_classes(SHORT.replace(faults=None).draw(0, 2)).tolist() == ["healthy"] * 2
    two = FaultSchedule((Bias(wheel=0, constant=0.1), Outage(wheel=2)))
    assert fault_classes(SHORT.replace(faults=two).draw(0, 1)).tolist() == ["2 faults"]
    sensors = FaultSchedule((GyroBiasStep(onset=1.0),))
    assert fault_classes(SHORT.replace(faults=sensors).draw(0, 1)).tolist() == ["gyro bias step"]
    mixed = FaultSchedule((Bias(wheel=0, constant=0.1), GyroBiasStep(), StarTrackerOutage(onset=2.0)))
    assert fault_classes(SHORT.replace(faults=mixed).draw(0, 1)).tolist() == ["3 faults"]
    several = SHORT.replace(faults=FaultDistribution((Outage(),), fault_counts=(0.0, 0.5, 0.5))).draw(0, 40)
    counts = (several.faults["kind"] > 0).any(axis=2).sum(axis=1)
    np.testing.assert_array_equal(fault_classes(several) == "2 faults", counts == 2)
    np.testing.assert_array_equal(fault_classes(several) == "outage", counts == 1)


def test_error_and_vibration_are_each_measured_by_the_reference():
    all_of_them = np.ones(60, dtype=bool)
    new, old = synthetic("new", 0.0), synthetic("old", 0.0)
    new.metrics["integrated_error"] = 1.1 * old.metrics["integrated_error"]
    new.metrics["modal_energy"] = 0.5 * old.metrics["modal_energy"]
    better, reference = compare([new, old], "old", all_of_them)
    assert reference.estimates[ERROR_AND_VIBRATION].value == pytest.approx(2.0)
    assert better.estimates[ERROR_AND_VIBRATION].value == pytest.approx(1.6)
    change = better.differences[ERROR_AND_VIBRATION]
    assert change.value == pytest.approx(-0.4) and change.high < 0.0
