"""The page of the report: self-contained, equal for equal benchmarks, and true."""

import base64
import json
import re
import shlex

import numpy as np
import tyro
from helpers.benchmarks import DURATION, EPISODES, agent, baseline, benchmark, feasible, read
from helpers.pages import page_of, shown
from helpers.scripts import module_of

from ftac_gym import baselines
from ftac_gym.report import write_report
from ftac_gym.report.worst import replay_command
from ftac_gym.scenarios import frozen

HOSTILE = """<script>alert("1")</script><img src=http://evil.example/x onerror='x'> & $a_b$ </style>"""


def images(page):
    """Return the images of a page as SVG documents, by their texts."""
    found = [attributes for tag, attributes in page.elements if tag == "img"]
    start = "data:image/svg+xml;base64,"
    assert all(item["src"].startswith(start) for item in found)
    return {item["alt"]: base64.b64decode(item["src"].removeprefix(start)).decode() for item in found}


def test_the_page_needs_nothing_else(folder, page):
    text = (folder / "report.html").read_text()
    for tag, attributes in page.elements:
        assert tag not in ("link", "iframe", "object", "embed", "base"), tag
        for name in ("src", "href", "xlink:href", "srcset", "data", "action", "poster"):
            assert attributes.get(name, "#").startswith(("#", "data:")), (tag, attributes)
    foreign = r"@import|@font-face|url\((?!#)|fetch\(|XMLHttpRequest|import\("
    assert not re.search(foreign, text) and not re.search(r"https?://", text)
    identifiers = [attributes["id"] for _, attributes in page.elements if "id" in attributes]
    assert len(identifiers) == len(set(identifiers))
    pointed = {attributes["href"][1:] for tag, attributes in page.elements if tag == "a"}
    assert pointed and pointed <= set(identifiers)
    for document in images(page).values():
        assert not re.search(foreign, document)
        assert {address.split("/")[2] for address in re.findall(r"https?://[^\s\"'<>]+", document)} == {"www.w3.org"}
        inside = set(re.findall(r' id="([^"]+)"', document))
        used = set(re.findall(r"url\(#([^)]+)\)", document)) | set(re.findall(r'xlink:href="#([^"]+)"', document))
        assert used and used <= inside


def test_figures_lie_beside_the_page(folder, page):
    names = {path.stem for path in (folder / "figures").glob("*.svg")}
    assert names == {
        "main", "availability_by_split", "success_by_split", "settling_time_by_split", "success_by_fault", "profiles",
        "improvement_settling_time", "improvement_success", "training",
    }  # fmt: skip
    assert sum(tag == "figure" for tag, _ in page.elements) == len(names)
    files = {path.read_text() for path in (folder / "figures").glob("*.svg")}
    assert not any("var(--" in text for text in files)
    # In the page they also have dark colours, and the same content.
    shown = {re.sub(r"<style>.*?</style>", "", text, count=1) for text in images(page).values()}
    assert {re.sub(r"var\(--c\d+, (#\w+)\)", r"\1", text) for text in shown} == files
    assert all("prefers-color-scheme: dark" in text for text in images(page).values())


def test_images_have_texts(page):
    texts = list(images(page))
    assert len(texts) == len(set(texts)) == 9 and all(len(text.split()) > 8 for text in texts)


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
        ("pd_dob tuned", "pd", "swift", "other"), key=lambda name: feasible(flown, "flagship", name, "success").mean()
    )
    entries = page.table("Best entries")
    assert next(name for name in entries if name != "nftsm_oracle") == best
    for name, row in entries.items():
        assert float(row["success"]["key"]) == feasible(flown, "flagship", name, "success").mean()
    counts = page.table("Differences to pd_dob tuned on flagship")
    settling = {mark: cell["text"] for mark, cell in counts["settling time, relative"].items()}
    assert settling == {"better": "1", "worse": "2", "not told apart": "0"}
    assert sum(int(cell["text"]) for cell in counts["success"].values()) == 3
    marks = {name: row["settling time, relative"]["class"] for name, row in entries.items()}
    assert marks["swift"] == "better" and marks["pd"] == "worse"
    assert entries["swift"]["settling time by split"]["text"].endswith("better, 0 worse")
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
    commands = next(text for text in page.texts if text.startswith("ftac-evaluate")).splitlines()
    assert len(commands) == 5
    program, *arguments = shlex.split(commands[0])
    assert program == "ftac-evaluate"
    evaluate = module_of("evaluate")
    config = tyro.cli(evaluate.Config, args=arguments)
    assert config.policies == ("runs/b", "pd_dob tuned") and config.reference == "pd_dob tuned"
    assert config.scenario == "flagship" and config.splits == () and config.detail == worst
    drawn = evaluate.draw(config, "flagship")
    assert drawn[config.detail].digest() == EPISODES["flagship"][worst].digest()


def test_validation_episodes_are_flown_again_as_such():
    names = ["pd", "pd_dob"]
    commands = {
        kind: replay_command("flagship", frozen.load("flagship", 3, kind), 2, names) for kind in ("validation", "test")
    }
    assert commands["validation"].replace(" --episodes-of validation", "") == commands["test"] != commands["validation"]


def test_names_are_text(tmp_path):
    entries = [agent(HOSTILE, seeds=1), baseline("pd", name="日本 & <b>")]
    page = page_of(benchmark(entries, {"flagship": EPISODES["flagship"]}), tmp_path)
    tags = [tag for tag, _ in page.elements]
    assert tags.count("script") == 1 and tags.count("style") == 1 and "b" not in tags
    assert tags.count("img") == len(images(page)) == tags.count("figure")
    assert not any(name.startswith("on") for _, attributes in page.elements for name in attributes)
    assert HOSTILE in page.table("Attitude tier on flagship")
    assert any(attributes.get("data-name") == HOSTILE for _, attributes in page.elements)
    assert {row["entry"] for row in read(tmp_path / "summary.csv")} == {HOSTILE, "日本 & <b>"}
    figure = (tmp_path / "figures" / "main.svg").read_text()
    assert "&lt;script&gt;" in figure and "<script" not in figure


def test_cards_hold_all_gains(page):
    texts = [text for text in page.texts if text.startswith('{\n  "tier"')]
    assert len(texts) == 5
    tuned = next(json.loads(text) for text in texts if '"trials": 250' in text)
    assert tuned["gains"] == {**baselines.defaults("pd_dob"), **baselines.chosen("pd_dob", "tuned", {})}
    assert tuned["tier"] == "attitude" and tuned["role"] == "policy"
    agents = [json.loads(text) for text in texts if '"cards"' in text]
    assert [len(card["cards"]) for card in agents] == [3, 3]
