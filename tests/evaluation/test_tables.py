"""Tables as text: content and format."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.evaluations import evaluation, recoveries

from ftac_gym import scenarios
from ftac_gym.evaluation import tabulate
from ftac_gym.evaluation.metrics import UNITS, described
from ftac_gym.evaluation.rows import TABLE_METRICS
from ftac_gym.evaluation.statistics import Estimate
from ftac_gym.evaluation.tables import (
    budget_table,
    kind_table,
    markdown,
    metric_tables,
    number,
    recovery_table,
    split_table,
    verdict,
)

COUNT = 40
EPISODES = {name: scenarios.get(name).draw(0, COUNT) for name in ("flagship", "flagship_double")}


def flown(policy, success, times=None):
    metrics = {metric: np.linspace(1.0, 2.0, COUNT) for metric in UNITS}
    shares = {
        "success": np.full(COUNT, success),
        "availability": np.full(COUNT, 0.5 * success),
        "bound_kept": np.ones(COUNT),
    }
    return evaluation(policy, {**metrics, **shares}, np.full((2, COUNT), 0.5), times)


EVALUATIONS = {name: [flown("good", 1.0), flown("bad", 0.0)] for name in EPISODES}
ROWS = {name: tabulate(items, "bad", EPISODES[name].feasible) for name, items in EVALUATIONS.items()}


def test_numbers():
    assert number(Estimate(0.12345, 0.1, 0.2, 9)) == "0.123 [0.1, 0.2]"
    assert number(Estimate(1548.3, 999.6, 1600.0, 9)) == "1548 [1e+03, 1600]"
    assert number(Estimate(float("nan"), 0.0, 0.0, 0)) == "-"
    assert number(Estimate(0.12345, 0.1, 0.2, 9, 9, 9)) == "0.123 [0.1, 0.2]"
    assert number(Estimate(0.12345, 0.1, 0.2, 9, 9, 10)) == "0.123 [0.1, 0.2] (9 of 10)"
    assert verdict("energy", Estimate(0.1, 0.1, 0.2, 9, 9, 10)) == "0.1 [0.1, 0.2] (9 of 10) worse"


def test_metrics_that_are_not_defined_for_all_have_their_number_beside_them():
    """Policies are on target at the onset of a fault in different numbers of episodes."""
    good, bad = (flown(name, 1.0) for name in ("good", "bad"))
    for item, missing in ((good, [3, 4, 5]), (bad, [4, 9])):
        item.metrics["ape_95"][missing] = item.metrics["peak_after_fault"][missing] = np.nan
    rows = tabulate([good, bad], "bad", np.ones(COUNT, dtype=bool))
    estimates, differences = metric_tables(rows, "bad")
    for heading, *cells in estimates[2:]:
        partly = heading.startswith("ape")
        assert [cell.partition("] ")[2] for cell in cells] == (["(37 of 40)", "(38 of 40)"] if partly else ["", ""])
    for heading, cell in differences[1:]:
        assert cell.endswith("] (36 of 40)") == heading.startswith("ape")
    line = described(good.metrics)
    assert "peak_after_fault 1.538 (37 of 40), " in line and "settling_time 1.5, " in line


@pytest.mark.parametrize(
    ("metric", "low", "high", "word"),
    [
        ("success", 0.1, 0.3, "better"),
        ("success", -0.3, -0.1, "worse"),
        ("energy", 0.1, 0.3, "worse"),
        ("energy", -0.3, -0.1, "better"),
    ],
)
def test_a_difference_that_excludes_zero_is_judged(metric, low, high, word):
    assert verdict(metric, Estimate(0.5 * (low + high), low, high, 9)).endswith(word)
    assert verdict(metric, Estimate(0.0, -1.0, 1.0, 9)).endswith("]")


def test_metrics_stand_in_rows_and_policies_in_columns():
    estimates, differences = metric_tables(ROWS["flagship"], "bad")
    feasible = int(EPISODES["flagship"].feasible.sum())
    assert estimates[0] == ["policy", "good", "bad"] and len(estimates) == 3 + len(TABLE_METRICS) + 2 * (
        feasible < COUNT
    )
    assert estimates[-1][:2] == ["error and vibration [-]", "2 [1.88, 2.12]"]
    assert estimates[1] == ["episodes", *[f"{feasible} of {COUNT}" if feasible < COUNT else f"{COUNT}"] * 2]
    assert [row[0] for row in estimates[2:4]] == ["availability [share]", "success [share]"]
    assert estimates[3][1].startswith("1 [0.")  # 40 of 40 are not certain
    assert differences[0] == ["minus bad", "good"]
    assert differences[2][1].startswith("1 [0.8") and differences[2][1].endswith(", 1] better")


def test_all_drawn_episodes_stand_beside_those_that_count():
    items = [flown("good", 1.0), flown("bad", 0.0)]
    items[1].metrics["success"][:10] = 1.0
    rows = tabulate(items, "bad", np.arange(COUNT) < 20)
    estimates = {heading: cells for heading, *cells in metric_tables(rows, "bad")[0]}
    assert estimates["episodes"] == ["20 of 40"] * 2
    assert estimates["success [share]"][1].startswith("0.5 [")
    assert estimates["success, all drawn [share]"][1].startswith("0.25 [")
    everything = tabulate(items, "bad", np.ones(COUNT, dtype=bool))
    assert "success, all drawn [share]" not in [row[0] for row in metric_tables(everything, "bad")[0]]


def test_recovery_by_kind_of_fault_with_the_faults_behind_it():
    episodes = replace(EPISODES["flagship"], feasible=np.ones(COUNT, dtype=bool))
    times = np.where(np.arange(COUNT) % 2 == 0, 2.0, 30.0)  # biases and outages in turn
    times[-2:] = np.nan
    seen = np.arange(COUNT) != 1
    slow = replace(flown("slow", 1.0), recoveries=recoveries(times, seen))
    cells = recovery_table([flown("quick", 1.0), slow], episodes)
    assert cells[0] == ["fault", "quick", "slow"]
    assert cells[1][0] == "all" and cells[1][1].endswith("], 0 s (40)")
    assert cells[1][2].startswith("0.5 [") and cells[1][2].endswith("], 2 s (38, 1 censored)")
    assert cells[2:] == [["bias", "1, 0 s (20)", "1, 2 s (19)"], ["outage", "1, 0 s (20)", "0, 30 s (19, 1 censored)"]]
    healthy = replace(slow, recoveries=recoveries(np.full(COUNT, np.nan)))
    assert len(recovery_table([healthy], episodes)) == 1


def test_pointing_budgets_pool_the_chosen_episodes():
    item = flown("good", 1.0)
    item.attitude_error[:, 20:] = 9.0
    item.relative_error[:] = 0.25
    cells = budget_table([item], np.arange(COUNT) < 20)
    assert cells[0] == ["budget [deg]", "good"]
    assert cells[1:3] == [["APE 95 %", "0.5"], ["APE 99.7 %", "0.5"]]
    assert cells[5:] == [["RPE 95 %", "0.25"], ["RPE 99.7 %", "0.25"]]


def test_kinds_add_up_and_infeasible_episodes_stand_apart():
    cells = kind_table(EVALUATIONS, EPISODES)
    assert cells[0] == ["scenario", "faults", "episodes", "good", "bad"]
    for name, episodes in EPISODES.items():
        rows = [row for row in cells[1:] if row[0] == name]
        assert sum(int(row[2]) for row in rows) == COUNT
        apart = [row for row in rows if row[1] == "infeasible"]
        assert sum(int(row[2]) for row in apart) == int((~episodes.feasible).sum())
        assert not apart or rows[-1][1] == "infeasible"
        assert all(row[3].startswith("0.500, 1.00, ") and row[4].startswith("0.000, 0.00, ") for row in rows)


def test_splits_have_their_feasible_and_all_drawn_episodes():
    cells = split_table(ROWS, EPISODES)
    assert cells[0] == ["scenario", "episodes", "good", "bad"]
    for first, second, (name, episodes) in zip(cells[1::2], cells[2::2], EPISODES.items(), strict=True):
        feasible = int(episodes.feasible.sum())
        assert first[:2] == [name, f"{feasible} feasible"] and second[:2] == [name, f"{COUNT} drawn"]
        assert first[2].startswith("0.5 [") and ", 1 [0." in first[2] and first[2].endswith(" deg s")
        assert second[2].startswith("0.5 [") and second[2].endswith(", 1]")


def test_markdown():
    assert markdown([["a", "b"], ["1", "2"]]) == "| a | b |\n|---|---|\n| 1 | 2 |"
    assert markdown([["a"], ["|x| < 1"]]) == "| a |\n|---|\n| \\|x\\| < 1 |"
