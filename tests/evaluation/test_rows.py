"""Rows of tables: estimates, differences to a reference, and fault classes."""

import numpy as np
import pytest
from helpers.evaluations import evaluation

from ftac_gym import scenarios
from ftac_gym.evaluation import fault_classes, tabulate
from ftac_gym.evaluation.metrics import UNITS
from ftac_gym.evaluation.rows import ERROR_AND_VIBRATION, HEADLINES, RECOVERED, TABLE_METRICS
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

SHORT = scenarios.get("flagship").replace(duration=5.0)
EPISODES = SHORT.draw(3, 7)


def test_bounds_stand_in_the_table_only_where_the_scenario_has_them():
    all_of_them = np.ones(60, dtype=bool)
    free = [synthetic("new", 0.5), synthetic("old", 0.0)]
    for item in free:
        for metric in ("bound_kept", "bound_margin"):
            item.metrics[metric] = np.full(60, np.nan)
    (row, _) = tabulate(free, "old", all_of_them)
    assert not {"bound_kept", "bound_margin"} & set(row.estimates)
    kept = np.arange(60) < 45
    bound = [synthetic("new", 0.5), synthetic("old", 0.0)]
    bound[0].metrics["bound_kept"] = kept.astype(float)
    assert tabulate(bound, "old", all_of_them)[0].estimates["bound_kept"].value == 0.75  # a share: the mean


def synthetic(name, shift, count=60):
    """Return an evaluation whose metrics share their luck with all others."""
    luck = np.random.default_rng(0).exponential(5.0, count)
    metrics = dict.fromkeys(UNITS, luck + shift)
    metrics["availability"], metrics["bound_kept"] = np.exp(-luck / 50.0), (luck < 9.0).astype(float)
    metrics["success"] = (luck < 5.0 + shift).astype(float)
    times = np.where(np.arange(count) % 2 == 0, luck + shift, np.nan)
    return evaluation(name, metrics, np.zeros((3, count)), times)


def test_estimates_and_differences():
    all_of_them = np.ones(60, dtype=bool)
    rows = tabulate([synthetic("new", 0.5), synthetic("old", 0.0)], "old", all_of_them)
    assert [row.policy for row in rows] == ["new", "old"]
    new, old = rows
    assert set(new.estimates) == set(old.estimates) == {*TABLE_METRICS, ERROR_AND_VIBRATION}
    assert set(new.differences) == {*TABLE_METRICS, ERROR_AND_VIBRATION} and not old.differences
    assert new.differences["energy"].value == pytest.approx(0.5) and new.differences["energy"].excludes_zero
    assert new.differences[RECOVERED].count == 30
    share = synthetic("old", 0.0).metrics["success"].mean()
    assert old.estimates["success"].value == pytest.approx(share)
    assert old.estimates["energy"].value < synthetic("old", 0.0).metrics["energy"].mean()  # robust against the tail


def test_the_table_counts_only_the_chosen():
    chosen = np.arange(60) < 20
    item = synthetic("only", 0.0)
    (row,) = tabulate([item], "only", chosen)
    assert row.estimates["success"].value == pytest.approx(item.metrics["success"][:20].mean())
    assert row.estimates["energy"].count == 20 and row.estimates[RECOVERED].count == 10
    assert row.drawn["success"].value == pytest.approx(item.metrics["success"].mean())
    assert set(row.drawn) == set(HEADLINES) and row.drawn["availability"].count == 60
    quick = item.recoveries.time[:20:2] <= 10.0
    assert row.estimates[RECOVERED].value == pytest.approx(quick.mean())


def test_the_table_refuses_an_unknown_reference():
    with pytest.raises(ValueError, match=r"reference must be one of \['new', 'old'\], got 'none'"):
        tabulate([synthetic("new", 0.5), synthetic("old", 0.0)], "none", np.ones(60, dtype=bool))


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
    better, reference = tabulate([new, old], "old", all_of_them)
    assert reference.estimates[ERROR_AND_VIBRATION].value == pytest.approx(2.0)
    assert better.estimates[ERROR_AND_VIBRATION].value == pytest.approx(1.6)
    change = better.differences[ERROR_AND_VIBRATION]
    assert change.value == pytest.approx(-0.4) and change.high < 0.0
