"""Reports of unusual benchmarks."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.benchmarks import EPISODES, SPLITS, agent, baseline, benchmark, read
from helpers.pages import page_of

from ftac_gym.report import write_report
from ftac_gym.report.results import gather


def test_a_single_entry_has_a_report(tmp_path):
    page = page_of(benchmark([baseline("pd")]), tmp_path)
    assert list(page.table("Attitude tier on flagship")) == ["pd"]
    text = "".join(page.texts)
    assert "There are no two entries to compare." in text and "No agent with training curves" in text
    assert {row[1]["text"].strip() for row in page.tables["flagship"][1:]} == {"pd"}
    assert not any("difference to" in heading for heading in page.tables)
    assert read(tmp_path / "improvement.csv") == read(tmp_path / "differences.csv") == []


@pytest.mark.parametrize("empty", [("flagship",), ("flagship_double",), SPLITS])
def test_splits_without_feasible_episodes(tmp_path, empty):
    episodes = {
        split: replace(item, feasible=item.feasible & (split not in empty))[:12] for split, item in EPISODES.items()
    }
    flown = benchmark([baseline("pd"), agent("swift", seeds=2)], episodes)
    page = page_of(flown, tmp_path)
    remaining = [split for split in SPLITS if split not in empty]
    if remaining:
        assert list(page.table(f"Attitude tier on {remaining[0]}")) == ["swift", "pd"]
    else:
        assert "there is nothing to compare" in "".join(page.texts)
    for line in read(tmp_path / "summary.csv"):
        if line["metric"] != "recovered_within_10_s" and line["over"] == "feasible":
            assert np.isnan(float(line["value"])) == (line["split"] in empty)
            assert (int(line["episodes"]) == 0) == (line["split"] in empty)
    assert {row["faults"] for row in read(tmp_path / "by_fault.csv") if row["split"] == empty[0]} == {"infeasible"}


def test_a_metric_that_no_episode_has(tmp_path):
    flown = benchmark([baseline("pd"), baseline("pd_dob")], {"flagship": EPISODES["flagship"]})
    for items in flown.evaluations["flagship"].values():
        items[0].recoveries.kind[:] = 0
    page = page_of(flown, tmp_path)
    for heading in ("Attitude tier on flagship", "Attitude tier on flagship, difference to pd"):
        cell = page.table(heading)["pd_dob"]["recovered within 10 s"]
        assert (
            cell["text"].strip() == "\N{EN DASH}" and cell["note"] == "" and cell["key"] == "nan" and not cell["class"]
        )


def test_crowded_figures_tell_apart_the_best_the_agents_and_the_reference():
    entries = [agent("weak", seeds=1), *(baseline("pd", name=f"pd {number}") for number in range(16))]
    flown = benchmark(entries, {"flagship": EPISODES["flagship"][:10]}, "pd 3")
    for name in ("weak", "pd 3"):
        flown.evaluations["flagship"][name][0].metrics["success"][:] = 0.0
    results = gather(flown)
    assert len(results.shown) == 12 and {"weak", "pd 3"} == set(results.order[-2:]) < set(results.shown)
    assert set(results.profiles["flagship"]) == set(results.order)


def test_what_is_no_benchmark_is_refused(tmp_path):
    flown = benchmark([baseline("pd")])
    with pytest.raises(ValueError, match=r"reference must be one of \['pd'\], got 'unknown'"):
        write_report(replace(flown, reference="unknown"), tmp_path)
    with pytest.raises(ValueError, match="entries must have names that differ"):
        write_report(replace(flown, entries=flown.entries * 2), tmp_path)
    assert not list(tmp_path.iterdir())
