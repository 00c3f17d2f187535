"""The report of a benchmark: its numbers, its files, and what it makes of unusual benchmarks."""

import csv
import importlib.util
import re
import shlex
import sys
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
import tyro
from scipy import stats

from ftac_gym import scenarios
from ftac_gym.evaluation import Evaluation
from ftac_gym.evaluation.benchmark import Benchmark, Entry
from ftac_gym.evaluation.metrics import UNITS
from ftac_gym.policies import DeferredBaseline
from ftac_gym.report import write_report
from ftac_gym.report.figures import spread
from ftac_gym.report.pictures import training_curve
from ftac_gym.report.results import gather
from ftac_gym.scenarios import frozen

SPLITS = ("flagship", "flagship_double")
EPISODES = {split: frozen.load(split, 25) for split in SPLITS}
DURATION = scenarios.get("flagship").duration
HOSTILE = """<script>alert("1")</script><img src=http://evil.example/x onerror='x'> & $a_b$ </style>"""
SHARES = ("success", "bound_kept")


class Page(HTMLParser):
    """What tests want to know of a page: elements with attributes, and tables as rows of cells."""

    def __init__(self, text):
        super().__init__()
        self.elements, self.tables, self.heading, self._open = [], {}, "", []
        self.rows, self.cell, self.texts = None, None, []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        self.elements.append((tag, attributes))
        if tag in ("h2", "h3", "summary"):
            self.heading = ""
            self._open.append(tag)
        elif tag == "table":
            self.rows = self.tables.setdefault(self.heading, [])
        elif tag == "tr":
            self.rows.append([])
        elif tag in ("th", "td"):
            self.cell = {
                "text": "",
                "note": "",
                "class": attributes.get("class", ""),
                "key": attributes.get("data-key"),
            }
            self.rows[-1].append(self.cell)
        elif tag == "small" and self.cell is not None:
            self._open.append(tag)

    def handle_startendtag(self, tag, attributes):
        self.elements.append((tag, dict(attributes)))

    def handle_endtag(self, tag):
        if self._open and self._open[-1] == tag:
            self._open.pop()
        if tag in ("th", "td"):
            self.cell = None

    def handle_data(self, data):
        self.texts.append(data)
        if self.cell is not None:
            self.cell["note" if self._open and self._open[-1] == "small" else "text"] += data
        elif self._open:
            self.heading += data

    def table(self, heading):
        """Return a table as cells by row heading and column heading."""
        columns, *rows = self.tables[heading]
        names = [cell["text"].strip() for cell in columns]
        return {
            row[0]["text"].strip(): dict(zip(names[1:], row[1:], strict=True)) for row in rows
        }  # fmt: skip


def evaluation(name, episodes, random, pace):
    """An evaluation as a flight gives it, in which some metrics are unknown in some episodes."""
    count = len(episodes)
    settling = np.minimum(random.gamma(9.0, pace / 9.0, count), DURATION)
    metrics = {metric: random.gamma(4.0, 0.25 * pace, count) for metric in UNITS}
    metrics |= {"settling_time": settling, "success": (random.random(count) > 0.01 * pace).astype(float)}
    metrics["recovery_time"] = np.where(random.random(count) < 0.6, np.nan, metrics["recovery_time"])
    metrics["jitter"] = np.full(count, np.nan)
    return Evaluation(name, metrics, np.zeros((1, count), dtype=np.float32))


def agent(name, seeds=3, tier="attitude", **changes):
    card = {"command": "python train/train.py", "steps": 1_000_000, "training_seconds": 60.0}
    cards = {"cards": [{**card, "seed": k} for k in range(seeds)]}
    curves = tuple(
        tuple({"steps": 1e5 * (row + 1), "success": 0.1 * row + 0.01 * k, "mean_return": 5.0 * row} for row in range(4))
        for k in range(seeds)
    )
    policies = tuple("nowhere/agent" for _ in range(seeds))
    return replace(Entry(name, policies, "contestant", tier, "agent", "", cards, curves), **changes)


def baseline(law, gains="default", **changes):
    name = f"{law} tuned" if gains == "tuned" else law
    role, tier = ("bound", "oracle") if "oracle" in law else ("contestant", "attitude")
    command = f"python train/tune.py --baseline {law} --store"
    provenance = {"trials": 250, "episodes": 200, "command": command} if gains == "tuned" else {}
    return replace(Entry(name, (DeferredBaseline(law, gains),), role, tier, "baseline", gains, provenance), **changes)


PACES = {"swift": 22.0, "pd_dob tuned": 30.0, "pd": 60.0, "nftsm_oracle": 30.0}


def benchmark(entries, episodes=None, reference=None):
    episodes = EPISODES if episodes is None else episodes
    random = np.random.default_rng(0)
    evaluations = {
        split: {
            entry.name: tuple(
                evaluation(entry.name, drawn, random, PACES.get(entry.name, 40.0)) for _ in entry.policies
            )
            for entry in entries
        }
        for split, drawn in episodes.items()
    }
    costs = {entry.name: 12.5 for entry in entries}
    return Benchmark(tuple(entries), episodes, evaluations, reference or entries[0].name, costs, 1000, 10.0)


ENTRIES = (
    baseline("pd_dob", "tuned"),
    baseline("pd"),
    agent("swift"),
    agent("other", tier="telemetry"),
    baseline("nftsm_oracle"),
)


@pytest.fixture(scope="module")
def flown():
    return benchmark(ENTRIES)


@pytest.fixture(scope="module")
def folder(flown, tmp_path_factory):
    target = tmp_path_factory.mktemp("report")
    assert write_report(flown, target) == target / "report.html"
    return target


@pytest.fixture(scope="module")
def page(folder):
    return Page((folder / "report.html").read_text())


def page_of(flown, folder):
    return Page(write_report(flown, folder).read_text())


def read(path):
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def data(flown, split, name, metric):
    """(seeds, N) over feasible episodes."""
    chosen = flown.episodes[split].feasible
    return np.array([item.metrics[metric][chosen] for item in flown.evaluations[split][name]])


def point(values, metric):
    known = values[~np.isnan(values)]
    return known.mean() if metric in SHARES else stats.trim_mean(known, 0.25)


def shown(cell):
    return float(cell["text"].split()[0].replace("\N{MINUS SIGN}", "-"))


def test_tables_hold_the_statistics_of_the_evaluations(flown, page):
    for heading, names in {
        "Attitude tier on flagship": {"pd_dob tuned", "pd", "swift"},
        "Telemetry tier on flagship": {"other"},
        "Bounds on flagship": {"nftsm_oracle"},
        "Attitude tier on flagship_double": {"pd_dob tuned", "pd", "swift"},
    }.items():
        table, split = page.table(heading), heading.rpartition(" ")[2]
        assert set(table) == names
        for name, row in table.items():
            for metric in ("success", "settling_time", "integrated_error", "recovery_time", "energy", "chatter"):
                cell = row[metric.replace("_", " ")]
                expected = point(data(flown, split, name, metric), metric)
                assert shown(cell) == pytest.approx(expected, rel=6e-3), (name, metric)
                assert float(cell["key"]) == pytest.approx(expected)
                low, high = (float(end) for end in cell["note"].strip(" []").split(","))
                assert low <= shown(cell) <= high


def test_differences_are_means_over_pairs_and_marked_where_their_interval_excludes_zero(flown, folder, page):
    table = page.table("Attitude tier on flagship, difference to pd_dob tuned")
    assert set(table) == {"swift", "pd"}
    lines = read(folder / "differences.csv")
    ends = {(row["entry"], row["metric"]): row for row in lines if row["split"] == "flagship"}
    marks = set()
    for name, row in table.items():
        for metric in ("success", "settling_time", "recovery_time", "chatter"):
            pairs = data(flown, "flagship", name, metric) - data(flown, "flagship", "pd_dob tuned", metric)
            cell, line = row[metric.replace("_", " ")], ends[name, metric]
            assert float(cell["key"]) == pytest.approx(np.nanmean(pairs)) == float(line["value"])
            low, high = float(line["low"]), float(line["high"])
            good = low > 0.0 if metric == "success" else high < 0.0
            bad = high < 0.0 if metric == "success" else low > 0.0
            assert cell["class"] == ("better" if good else "worse" if bad else "")
            assert ("better" in cell["text"], "worse" in cell["text"]) == (good, bad)
            marks.add(cell["class"])
    assert {"better", "worse"} <= marks
    relative = point(data(flown, "flagship", "swift", "settling_time"), "settling_time")
    relative = relative / point(data(flown, "flagship", "pd_dob tuned", "settling_time"), "settling_time") - 1.0
    assert float(table["swift"]["settling time, relative"]["key"]) == pytest.approx(100.0 * relative)
    assert float(ends["swift", "settling_time_relative"]["value"]) == pytest.approx(relative)


def test_csv_files_hold_the_same_numbers(flown, folder, page):
    summary = read(folder / "summary.csv")
    assert len(summary) == len(SPLITS) * len(ENTRIES) * 6
    for line in summary:
        values = data(flown, line["split"], line["entry"], line["metric"])
        assert float(line["value"]) == pytest.approx(point(values, line["metric"]))
        assert float(line["low"]) <= float(line["value"]) <= float(line["high"])
        assert int(line["episodes"]) == (~np.isnan(values)).any(axis=0).sum() and int(line["seeds"]) == len(values)
    table = page.table("Success by split, in numbers with intervals")
    for line in summary:
        if line["metric"] == "success" and line["split"] == "flagship_double":
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
    cell = page.table("flagship_double: mean success, median settling time")["swift"]["infeasible"]
    assert shown(cell) == pytest.approx(success.mean(), abs=0.005)
    assert float(cell["note"].removesuffix(" s")) == pytest.approx(np.median(settling), abs=0.05)
    counted = sum(int(row["episodes"]) for key, row in lines.items() if key[0] == "flagship" and key[2] == "pd")
    assert counted == len(EPISODES["flagship"])


@pytest.mark.parametrize(
    ("metric", "title"), [("settling_time", "Better settling time"), ("success", "Better success")]
)
def test_improvement_is_the_share_of_pairs_that_are_won(flown, folder, page, metric, title):
    lines = {(row["first"], row["second"]): row for row in read(folder / "improvement.csv") if row["metric"] == metric}
    names = {"pd_dob tuned", "pd", "swift", "other"}  # a bound does not compete
    assert set(lines) == {(first, second) for first in names for second in names if first != second}
    for (first, second), line in lines.items():
        one, other = data(flown, "flagship", first, metric), data(flown, "flagship", second, metric)
        better = np.sign(one[:, None] - other[None]) * (1.0 if metric == "success" else -1.0)
        assert float(line["value"]) == pytest.approx((0.5 + 0.5 * better).mean())
        assert float(line["low"]) <= float(line["value"]) <= float(line["high"])
    tables = page.tables[f"{title}, in numbers with intervals"]
    flat = [cell["key"] for row in tables for cell in row]
    assert str(float(lines["swift", "pd"]["value"])) in flat


def test_the_page_needs_nothing_else(folder, page):
    text = (folder / "report.html").read_text()
    for tag, attributes in page.elements:
        assert tag not in ("link", "iframe", "object", "embed", "img", "base"), tag
        for name in ("src", "href", "xlink:href", "srcset", "data", "action", "poster"):
            assert attributes.get(name, "#").startswith(("#", "data:")), (tag, attributes)
    assert not re.search(r"@import|@font-face|url\((?!#)|fetch\(|XMLHttpRequest|import\(", text)
    assert set(re.findall(r"https?://[^\s\"'<>]+", text)) == {
        "http://www.w3.org/2000/svg",
        "http://www.w3.org/1999/xlink",
    }
    identifiers = [attributes["id"] for _, attributes in page.elements if "id" in attributes]
    assert len(identifiers) == len(set(identifiers))
    pointed = {attributes["href"][1:] for tag, attributes in page.elements if tag == "a"}
    assert pointed and pointed <= set(identifiers)
    used = set(re.findall(r"url\(#([^)]+)\)", text)) | set(re.findall(r'xlink:href="#([^"]+)"', text))
    assert used and used <= set(identifiers)


def test_figures_lie_beside_the_page(folder, page):
    names = {path.stem for path in (folder / "figures").glob("*.svg")}
    assert names == {
        "main", "success_by_split", "settling_time_by_split", "success_by_fault", "improvement_settling_time",
        "improvement_success", "profiles", "training",
    }  # fmt: skip
    assert sum(tag == "figure" for tag, _ in page.elements) == len(names)
    for path in (folder / "figures").glob("*.svg"):
        assert "var(--" not in path.read_text()


def test_the_same_benchmark_gives_the_same_files(flown, folder, tmp_path):
    (tmp_path / "figures").mkdir()
    (tmp_path / "figures" / "old.svg").write_text("of an earlier report")
    write_report(flown, tmp_path)
    files = sorted(path.relative_to(tmp_path) for path in tmp_path.rglob("*.*"))
    assert files == sorted(path.relative_to(folder) for path in folder.rglob("*.*"))
    for file in files:
        assert (tmp_path / file).read_bytes() == (folder / file).read_bytes(), file


def test_the_summary_is_true(flown, page):
    text = "".join(page.texts)
    best = max(
        ("pd_dob tuned", "pd", "swift", "other"), key=lambda name: data(flown, "flagship", name, "success").mean()
    )
    assert f"no contestant has a higher success than {best}" in text
    assert "of 3 contestants" in text
    sooner = re.search(r"of 3 contestants (\d) settle sooner(: [^;]*)?; (\d) settle later(: [^;]*)?;", text)
    assert sooner[1] == "1" and "swift" in sooner[2] and sooner[3] == "2" and "pd" in sooner[4]
    assert "100 episodes/s" in text and EPISODES["flagship"].digest()[:16] in text


def test_worst_episodes_come_first_and_can_be_flown_again(tmp_path):
    flown = benchmark(
        [baseline("pd_dob", "tuned"), agent("swift", policies=("runs/a", "runs/b"))],
        {"flagship": EPISODES["flagship"]},
    )
    worst = int(np.flatnonzero(EPISODES["flagship"].feasible)[11])
    ours, base = flown.evaluations["flagship"]["swift"], flown.evaluations["flagship"]["pd_dob tuned"][0]
    for item, time in zip((*ours, base), (DURATION - 1.0, DURATION, 1.0), strict=True):
        item.metrics["settling_time"][worst] = time
    page = page_of(flown, tmp_path)
    rows = page.tables["flagship"][1:]
    assert len(rows) == 5
    first = dict(zip([cell["text"].strip() for cell in page.tables["flagship"][0]], rows[0], strict=True))
    assert first["episode"]["text"] == str(worst) and first["entry"]["note"].strip() == "seed 1"
    assert shown(first["settling time"]) == DURATION and "reference 1" in first["settling time"]["note"]
    commands = next(text for text in page.texts if text.startswith("python train/evaluate.py")).splitlines()
    assert len(commands) == 5
    program, script, *arguments = shlex.split(commands[0])
    assert (program, script) == ("python", "train/evaluate.py")
    evaluate = script_of("evaluate")
    config = tyro.cli(evaluate.Config, args=arguments)
    assert config.policies == ("runs/b", "pd_dob tuned") and config.reference == "pd_dob tuned"
    assert config.scenario == "flagship" and config.splits == () and config.detail == worst
    drawn = evaluate.draw(config, "flagship")
    assert drawn[config.detail].digest() == EPISODES["flagship"][worst].digest()


def script_of(name):
    """Import a script without running it."""
    path = Path(__file__).parents[2] / "train" / f"{name}.py"
    spec = importlib.util.spec_from_file_location(f"script_{name}", path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


def test_names_are_text(tmp_path):
    entries = [agent(HOSTILE, seeds=1), baseline("pd", name="日本 & <b>")]
    page = page_of(benchmark(entries, {"flagship": EPISODES["flagship"]}), tmp_path)
    tags = [tag for tag, _ in page.elements]
    assert tags.count("script") == 1 and tags.count("style") == 1 and "img" not in tags and "b" not in tags
    assert not any(name.startswith("on") for _, attributes in page.elements for name in attributes)
    assert HOSTILE in page.table("Attitude tier on flagship")
    assert any(attributes.get("data-name") == HOSTILE for _, attributes in page.elements)
    assert {row["entry"] for row in read(tmp_path / "summary.csv")} == {HOSTILE, "日本 & <b>"}
    figure = (tmp_path / "figures" / "main.svg").read_text()
    assert "&lt;script&gt;" in figure and "<script" not in figure


def test_a_single_entry_has_a_report(tmp_path):
    page = page_of(benchmark([baseline("pd")]), tmp_path)
    assert list(page.table("Attitude tier on flagship")) == ["pd"]
    text = "".join(page.texts)
    assert "There are no two contestants to compare." in text and "No agent with training curves" in text
    assert "in which pd takes longest to settle" in text
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
        if line["metric"] != "recovery_time":
            assert np.isnan(float(line["value"])) == (line["split"] in empty)
            assert (int(line["episodes"]) == 0) == (line["split"] in empty)
    assert {row["faults"] for row in read(tmp_path / "by_fault.csv") if row["split"] == empty[0]} == {"infeasible"}


def test_a_metric_that_no_episode_has(tmp_path):
    flown = benchmark([baseline("pd"), baseline("pd_dob")], {"flagship": EPISODES["flagship"]})
    for items in flown.evaluations["flagship"].values():
        items[0].metrics["recovery_time"][:] = np.nan
    page = page_of(flown, tmp_path)
    for heading in ("Attitude tier on flagship", "Attitude tier on flagship, difference to pd"):
        cell = page.table(heading)["pd_dob"]["recovery time"]
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
    with pytest.raises(ValueError, match=r"reference must be one of \['pd'\], got 'nobody'"):
        write_report(replace(flown, reference="nobody"), tmp_path)
    with pytest.raises(ValueError, match="entries must have names that differ"):
        write_report(replace(flown, entries=flown.entries * 2), tmp_path)
    assert not list(tmp_path.iterdir())


def test_training_curves_are_the_mean_and_the_range_of_seeds():
    rows = [{"steps": 100.0 * k, "success": 0.1 * k} for k in range(1, 5)]
    later = [{"steps": 100.0 * k + 50.0, "success": 0.1 * k + 0.25} for k in range(1, 4)]
    entry = agent("a", curves=(tuple(rows), tuple(later)))
    curve = training_curve(entry, "success")
    np.testing.assert_allclose(curve.x, [200.0, 300.0])
    np.testing.assert_allclose(curve.low, [0.2, 0.3])
    np.testing.assert_allclose(curve.high, [0.4, 0.5])
    np.testing.assert_allclose(curve.y, [0.3, 0.4])
    assert training_curve(entry, "mean_return") is None


def test_labels_are_spread_no_further_than_needed():
    np.testing.assert_allclose(spread(np.array([0.1, 0.5, 0.9]), 0.1), [0.1, 0.5, 0.9])
    np.testing.assert_allclose(spread(np.array([0.2, 0.5, 0.5, 0.5]), 0.1), [0.2, 0.4, 0.5, 0.6])
    np.testing.assert_allclose(spread(np.array([0.99, 1.0]), 0.1), [0.9, 1.0])
    placed = spread(np.sort(np.random.default_rng(0).random(30)), 0.05)
    assert (np.diff(placed) >= 0.05 - 1e-12).all()
    assert spread(np.zeros(0), 0.1).size == 0
