"""The numbers of the report: tables and CSV files against direct evaluation."""

import numpy as np
import pytest
from helpers.benchmarks import ENTRIES, EPISODES, SPLITS, feasible, read
from helpers.pages import shown
from scipy import stats

SHARES = ("availability", "success", "bound_kept")


def point(values, metric):
    known = values[~np.isnan(values)]
    return known.mean() if metric in SHARES else stats.trim_mean(known, 0.25)


def test_tables_hold_the_statistics_of_the_evaluations(flown, page):
    for heading, names in {
        "Attitude tier on flagship": {"pd_dob tuned", "pd", "swift"},
        "Telemetry tier on flagship": {"other"},
        "Oracles on flagship": {"nftsm_oracle"},
        "Attitude tier on flagship_double": {"pd_dob tuned", "pd", "swift"},
    }.items():
        table, split = page.table(heading), heading.rpartition(" ")[2]
        assert set(table) == names
        for name, row in table.items():
            assert "recovered within 10 s" in row
            for metric in (
                "availability",
                "success",
                "settling_time",
                "ape_95",
                "integrated_error",
                "energy",
                "chatter",
            ):
                cell = row[metric.replace("_", " ")]
                expected = point(feasible(flown, split, name, metric), metric)
                assert shown(cell) == pytest.approx(expected, rel=6e-3), (name, metric)
                assert float(cell["key"]) == pytest.approx(expected)
                values = feasible(flown, split, name, metric)
                interval, _, count = cell["note"].strip().partition("]")
                low, high = (float(end) for end in interval.strip("[").split(","))
                assert low <= shown(cell) <= high
                known = np.count_nonzero(~np.isnan(values))
                assert count == ("" if known == values.size else f" ({known} of {values.size})")


def test_differences_are_means_over_pairs_and_marked_where_their_interval_excludes_zero(flown, folder, page):
    table = page.table("Attitude tier on flagship, difference to pd_dob tuned")
    assert set(table) == {"swift", "pd"}
    lines = read(folder / "differences.csv")
    ends = {(row["entry"], row["metric"]): row for row in lines if row["split"] == "flagship"}
    marks = set()
    for name, row in table.items():
        for metric in ("availability", "success", "settling_time", "ape_95", "chatter"):
            pairs = feasible(flown, "flagship", name, metric) - feasible(flown, "flagship", "pd_dob tuned", metric)
            cell, line = row[metric.replace("_", " ")], ends[name, metric]
            assert float(cell["key"]) == pytest.approx(np.nanmean(pairs)) == float(line["value"])
            low, high = float(line["low"]), float(line["high"])
            higher = metric in ("availability", "success")
            good, bad = (low > 0.0, high < 0.0) if higher else (high < 0.0, low > 0.0)
            assert cell["class"] == ("better" if good else "worse" if bad else "")
            assert ("better" in cell["text"], "worse" in cell["text"]) == (good, bad)
            marks.add(cell["class"])
    assert {"better", "worse"} <= marks
    relative = point(feasible(flown, "flagship", "swift", "settling_time"), "settling_time")
    relative = relative / point(feasible(flown, "flagship", "pd_dob tuned", "settling_time"), "settling_time") - 1.0
    assert float(table["swift"]["settling time, relative"]["key"]) == pytest.approx(100.0 * relative)
    assert float(ends["swift", "settling_time_relative"]["value"]) == pytest.approx(relative)


def test_csv_files_hold_the_same_numbers(flown, folder, page):
    summary = read(folder / "summary.csv")
    assert len(summary) == len(SPLITS) * len(ENTRIES) * (8 + 2)
    assert sum(line["over"] == "drawn" for line in summary) == len(SPLITS) * len(ENTRIES) * 2
    for line in summary:
        if line["metric"] == "recovered_within_10_s":
            runs = [item.recoveries for item in flown.evaluations[line["split"]][line["entry"]]]
            chosen = flown.episodes[line["split"]].feasible
            times = np.concatenate([item.time[chosen] for item in runs])
            assert float(line["value"]) == pytest.approx((times[~np.isnan(times)] <= 10.0).mean())
            assert int(line["total"]) == np.count_nonzero(~np.isnan(times))
            continue
        values = feasible(flown, line["split"], line["entry"], line["metric"])
        if line["over"] == "drawn":
            values = np.array(
                [item.metrics[line["metric"]] for item in flown.evaluations[line["split"]][line["entry"]]]
            )
        assert float(line["value"]) == pytest.approx(point(values, line["metric"]))
        assert float(line["low"]) <= float(line["value"]) <= float(line["high"])
        assert int(line["episodes"]) == (~np.isnan(values)).any(axis=0).sum() and int(line["seeds"]) == len(values)
        assert (int(line["defined"]), int(line["total"])) == ((~np.isnan(values)).sum(), values.size)
    table = page.table("Success by split, in numbers with intervals")
    for line in summary:
        if (line["metric"], line["split"], line["over"]) == ("success", "flagship_double", "feasible"):
            assert float(table[line["entry"]]["flagship_double"]["key"]) == float(line["value"])


def test_episodes_are_listed_one_by_one(flown, folder):
    lines = read(folder / "episodes.csv")
    runs = sum(len(entry.policies) for entry in ENTRIES)
    assert len(lines) == runs * sum(len(item) for item in EPISODES.values())
    assert "chatter" in lines[0] and "jitter" not in lines[0]  # nothing is known of that one
    line = next(item for item in lines if (item["entry"], item["seed"], item["episode"]) == ("swift", "2", "7"))
    metrics = flown.evaluations["flagship"]["swift"][2].metrics
    assert float(line["energy"]) == pytest.approx(metrics["energy"][7], rel=1e-5)
    assert line["feasible"] == str(EPISODES["flagship"].feasible[7])


def test_kinds_of_faults_are_apart_from_infeasible_episodes(flown, folder, page):
    lines = {(row["split"], row["faults"], row["entry"]): row for row in read(folder / "by_fault.csv")}
    infeasible = ~EPISODES["flagship_double"].feasible
    assert infeasible.any()
    line = lines["flagship_double", "infeasible", "swift"]
    success, settling = (
        np.array([item.metrics[metric][infeasible] for item in flown.evaluations["flagship_double"]["swift"]])
        for metric in ("success", "settling_time")
    )
    assert int(line["episodes"]) == infeasible.sum()
    assert float(line["mean_success"]) == pytest.approx(success.mean())
    assert float(line["median_settling_time"]) == pytest.approx(np.median(settling))
    cell = page.table("flagship_double: mean success, mean availability, median settling time")["swift"]["infeasible"]
    assert shown(cell) == pytest.approx(success.mean(), abs=0.005)
    assert float(cell["note"].partition(",")[2].removesuffix(" s")) == pytest.approx(np.median(settling), abs=0.05)
    counted = sum(int(row["episodes"]) for key, row in lines.items() if key[0] == "flagship" and key[2] == "pd")
    assert counted == len(EPISODES["flagship"])


@pytest.mark.parametrize(
    ("metric", "title"), [("settling_time", "Better settling time"), ("success", "Better success")]
)
def test_improvement_is_the_share_of_pairs_that_are_won(flown, folder, page, metric, title):
    lines = {(row["first"], row["second"]): row for row in read(folder / "improvement.csv") if row["metric"] == metric}
    names = {"pd_dob tuned", "pd", "swift", "other"}  # an oracle does not compete
    assert set(lines) == {(first, second) for first in names for second in names if first != second}
    for (first, second), line in lines.items():
        one, other = feasible(flown, "flagship", first, metric), feasible(flown, "flagship", second, metric)
        better = np.sign(one[:, None] - other[None]) * (1.0 if metric == "success" else -1.0)
        assert float(line["value"]) == pytest.approx((0.5 + 0.5 * better).mean())
        assert float(line["low"]) <= float(line["value"]) <= float(line["high"])
    tables = page.tables[f"{title}, in numbers with intervals"]
    flat = [cell["key"] for row in tables for cell in row]
    assert str(float(lines["swift", "pd"]["value"])) in flat


def test_recoveries_are_listed_fault_by_fault(flown, folder):
    lines = read(folder / "recoveries.csv")
    runs = [item for split in flown.evaluations.values() for seeds in split.values() for item in seeds]
    assert len(lines) == sum(item.recoveries.counted.sum() for item in runs)
    first = flown.evaluations["flagship"]["swift"][1].recoveries
    mine = [row for row in lines if (row["split"], row["entry"], row["seed"]) == ("flagship", "swift", "1")]
    np.testing.assert_allclose([float(row["time"]) for row in mine], first.time[first.counted], rtol=1e-5)
    assert {row["fault"] for row in mine} == {"bias", "outage"} and {row["recovered"] for row in mine} == {"True"}
