"""Tables as text: content and format."""

import numpy as np
import pytest

from ftac_gym import scenarios
from ftac_gym.evaluation import tabulate
from ftac_gym.evaluation.batches import Evaluation
from ftac_gym.evaluation.metrics import described
from ftac_gym.evaluation.rows import TABLE_METRICS
from ftac_gym.evaluation.statistics import Estimate
from ftac_gym.evaluation.tables import kind_table, markdown, metric_tables, number, split_table, verdict

COUNT = 40
EPISODES = {name: scenarios.get(name).draw(0, COUNT) for name in ("flagship", "flagship_double")}


def flown(policy, success):
    metrics = {metric: np.linspace(1.0, 2.0, COUNT) for metric in TABLE_METRICS}
    return Evaluation(policy, {**metrics, "success": np.full(COUNT, success)}, np.zeros((2, COUNT), dtype=np.float32))


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
        for metric in ("recovery_time", "peak_after_fault"):
            item.metrics[metric][missing] = np.nan
    rows = tabulate([good, bad], "bad", np.ones(COUNT, dtype=bool))
    estimates, differences = metric_tables(rows, "bad")
    for heading, *cells in estimates[1:]:
        partly = heading.startswith(("recovery", "peak"))
        assert [cell.partition("] ")[2] for cell in cells] == (["(37 of 40)", "(38 of 40)"] if partly else ["", ""])
    for heading, cell in differences[1:]:
        assert cell.endswith("] (36 of 40)") == heading.startswith(("recovery", "peak"))
    line = described(good.metrics)
    assert "recovery_time 1.538 (37 of 40), " in line and "settling_time 1.5, " in line


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
    assert estimates[0] == ["policy", "good", "bad"] and len(estimates) == 2 + len(TABLE_METRICS)
    assert estimates[-1][:2] == ["error and vibration [-]", "2 [1.88, 2.12]"]
    assert [row[0] for row in estimates[1:3]] == ["availability [share]", "success [share]"]
    assert estimates[2][1].startswith("1 [1, 1]")
    assert differences[0] == ["minus bad", "good"] and differences[2][1] == "1 [1, 1] better"


def test_kinds_add_up_and_infeasible_episodes_stand_apart():
    cells = kind_table(EVALUATIONS, EPISODES)
    assert cells[0] == ["scenario", "faults", "episodes", "good", "bad"]
    for name, episodes in EPISODES.items():
        rows = [row for row in cells[1:] if row[0] == name]
        assert sum(int(row[2]) for row in rows) == COUNT
        apart = [row for row in rows if row[1] == "infeasible"]
        assert sum(int(row[2]) for row in apart) == int((~episodes.feasible).sum())
        assert not apart or rows[-1][1] == "infeasible"
        assert all(row[3].startswith("1.00, ") and row[4].startswith("0.00, ") for row in rows)


def test_splits_count_their_feasible_episodes():
    cells = split_table(ROWS, EPISODES)
    assert cells[0] == ["scenario", "feasible", "infeasible", "good", "bad"]
    for row, (name, episodes) in zip(cells[1:], EPISODES.items(), strict=True):
        feasible = int(episodes.feasible.sum())
        assert row[:3] == [name, str(feasible), str(COUNT - feasible)]
        assert row[3].startswith("1 [1, 1], ") and row[3].endswith(" deg s")


def test_markdown():
    assert markdown([["a", "b"], ["1", "2"]]) == "| a | b |\n|---|---|\n| 1 | 2 |"
    assert markdown([["a"], ["|x| < 1"]]) == "| a |\n|---|\n| \\|x\\| < 1 |"
