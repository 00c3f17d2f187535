"""Pages of the baselines: a flight with its figures, the claims of the reports, and the gains."""

from __future__ import annotations

import io
import re
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import joblib
import numpy as np
import yaml
from environment_pages import ids
from page_parts import section, show, table, write_pages

import ftac_gym
from ftac_gym import baselines, plots, scenarios
from ftac_gym.baselines import observers, tuned
from ftac_gym.baselines.memory import Memory
from ftac_gym.evaluation import Rollout, rollout
from ftac_gym.evaluation.metrics import UNITS
from ftac_gym.task.prescribed_bound import PrescribedBound
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import require

SEED = 3
"""Seed of the flights: on the flagship a bias occurs after a good baseline has settled."""


@dataclass(frozen=True)
class Variant:
    """Facts of a baseline that follow from no code: an entry of ``docs/baselines/variants.yml``."""

    summary: str
    scenario: str
    duration: float | None = None
    hold: float | None = None
    also: tuple[str, ...] = ()
    faults: str = "none: healthy wheels are assumed"
    report: str | None = None
    flights: str = ""
    claims: str | None = None

    def task(self, name: str) -> Scenario:
        """Return the scenario of a flight, shortened where it is the one that the baseline is made for."""
        scenario = scenarios.get(name)
        if name != self.scenario:
            return scenario
        success = replace(scenario.success, hold=self.hold or scenario.success.hold)
        return scenario.replace(duration=self.duration or scenario.duration, success=success)


def variants(source: Path) -> dict[str, Variant]:
    """Return the facts of all baselines by name."""
    groups = yaml.safe_load((source / "baselines" / "variants.yml").read_text(encoding="utf-8"))
    entries = [(name, group, entry) for group in groups for name, entry in group.pop("baselines").items()]
    return {name: Variant(**group | entry) for name, group, entry in entries}


def families(source: Path) -> dict[str, str]:
    """Return the page with the equations of each baseline: the one with the baseline in its list of variants."""
    texts = {path.stem: path.read_text(encoding="utf-8") for path in (source / "baselines").glob("*.md")}
    found = [(name, page) for page, text in texts.items() for name in re.findall(r"^generated/(\w+)$", text, re.M)]
    rule = "must be in the list of exactly one page of docs/baselines"
    require(sorted(name for name, _ in found) == baselines.names(), "every baseline", rule, sorted(found))
    return dict(found)


def fly(name: str, variant: Variant, digest: str) -> tuple[str, str, dict[str, bytes]]:
    """Return text for the page of a baseline, the end of its last flight, and PNG files by name.

    Default gains fly the scenario of the variant, tuned gains that of their tuning. The digest is a key of the cache.
    """
    groups = {variant.scenario: ["default"]}
    if name in tuned.names():
        groups.setdefault(tuned.record(name)["provenance"]["scenario"], ["default"]).append("tuned")
    blocks, files = [], {}
    for scenario, gains in groups.items():
        task = variant.task(scenario)
        policies = {kind: name if kind == "default" else f"{name} tuned" for kind in gains}
        histories = {kind: rollout(task, policy, seed=SEED) for kind, policy in policies.items()}
        figures = {f"{name}-{scenario}.png": plots.episode(histories)}
        estimates = {}
        if "observer" in variant.faults or baselines.defaults(name).get("faults") in observers.names():
            estimates = {kind: plots.estimates_along(histories[kind], name, kind) for kind in gains}
        parts = {part for item in estimates.values() for part, value in vars(item).items() if value is not None}
        if parts & {"effectiveness", "bias"}:
            figures[f"{name}-{scenario}-faults.png"] = plots.fault_estimates(estimates)
        if "disturbance" in parts:
            figures[f"{name}-{scenario}-torques.png"] = plots.torque_estimates(estimates)
        blocks += [flight(task, scenario, histories, list(figures))]
        for file, figure in figures.items():
            buffer = io.BytesIO()
            figure.savefig(buffer, dpi=100, metadata={"Software": None})
            files[file] = buffer.getvalue()
    last = histories[gains[-1]].metrics()
    end = f"{'success' if last['success'][0] else 'no success'}, {last['final_error'][0]:.2g} deg"
    return "\n\n".join(blocks), end, files


def flight(task: Scenario, scenario: str, histories: Mapping[str, Rollout], files: list[str]) -> str:
    """Return the section of a page about the flights of a scenario."""
    metrics = {gains: history.metrics() for gains, history in histories.items()}
    values = {name: [float(item[name][0]) for item in metrics.values()] for name in UNITS}
    rows = [(name, UNITS[name], *map(show, row)) for name, row in values.items() if not np.isnan(row).all()]
    whole, (cone, slow) = scenarios.get(scenario).duration, np.degrees((task.success.angle, task.success.rate))
    length = f"{whole:g} s" if task.duration >= whole else f"The first {task.duration:g} of {whole:g} s"
    faults = plots.fault_description(next(iter(histories.values())).episodes)
    text = (
        f"{length} of {scenario_link(scenario)}, seed {SEED}. Faults: {faults}. Success is to be within {cone:.3g} deg"
        f" and {slow:.3g} deg/s for the last {task.success.hold:g} s. A settling time of {task.duration:g} s"
        " means never. Dotted lines mark these limits, those of the torque, and the onsets of faults."
    )
    images = [f"```{{image}} {file}\n:alt: {file.removesuffix('.png')}\n```" for file in files]
    return "\n\n".join([f"### On `{scenario}`", text, *images, table(("metric", "unit", *histories), rows)])


def scenario_link(scenario: str) -> str:
    """Return a scenario by name, with a link to the page of its environment if it has one."""
    pages = {name: f"../../environments/generated/{environment_id}.md" for environment_id, name in ids().items()}
    return f"[`{scenario}`]({pages[scenario]})" if scenario in pages else f"`{scenario}`"


def report_tables(text: str) -> dict[str, list[list[str]]]:
    """Return the rows of the tables in a report by the title of their section, header first."""
    found = {}
    for title, body in re.findall(r"^## (.*?)\n(.*?)(?=^## |\Z)", text, flags=re.M | re.S):
        lines = [line for line in body.splitlines() if line.startswith("|") and not line.startswith("|--")]
        cells = [re.split(r"(?<!\\)\|", line)[1:-1] for line in lines]
        found[title] = [[cell.strip().replace(r"\|", "|") for cell in row] for row in cells]
    return {title: rows for title, rows in found.items() if rows}


def reproduction(variant: Variant, source: Path) -> str:
    """Return the claims and flights of a report that are about a baseline, as Markdown."""
    if variant.report is None:
        return "No report is about this variant."
    path, blocks = f"reproduction/{variant.report}/report.md", []
    tables = report_tables((source / path).read_text(encoding="utf-8"))
    claims = tables["Claims"][1:]
    about = [row for row in claims if variant.claims and re.search(variant.claims, "\n".join((*row[1:3], row[4])))]
    if about:
        counts = ", ".join(f"{count} {verdict}" for verdict, count in Counter(row[3] for row in about).items())
        blocks += [f"Of the {len(claims)} claims of the paper, {len(about)} are about it or judged by it: {counts}."]
        rows = [(row[0], row[1], row[3], row[4]) for row in about]
        blocks += [table(("section", "claim", "verdict", "assumption or reason"), rows, literal=True)]
    schemes = next(rows for title, rows in tables.items() if title.startswith("All schemes"))
    if flown := [row for row in schemes if re.fullmatch(variant.flights, row[0])]:
        blocks += ["Its flights in the example of the paper:", table(schemes[0], flown, literal=True)]
    return "\n\n".join([*blocks, f"All numbers are in the [report](../../{path})."])


def gain_table(name: str, task: Scenario) -> str:
    """Return the gains of a baseline and of its observer as a table: default, tuned and meaning."""
    baseline, kind = baselines.baseline_class(name), baselines.defaults(name).get("faults")
    default, found = flat(baselines.defaults(name)), flat(tuned.gains(name)) if name in tuned.names() else {}
    parts: dict[str, type] = {"": baseline, "bound.": PrescribedBound}
    if kind in observers.names():
        observer = observers.make(kind, task, Memory(1))
        parts["observer."] = type(observer)
        default |= {f"observer.{gain}": value for gain, value in vars(observer.gains).items()} | default
    meanings = {part + gain: text for part, cls in parts.items() for gain, text in section(cls, "Parameters").items()}
    rows = []
    for gain in dict.fromkeys([*default, *found]):
        values = [show(values[gain]) if values.get(gain) is not None else "" for values in (default, found)]
        rows.append((f"`{gain}`", *values[: 1 + bool(found)], meanings.get(gain, "")))
    return table(("gain", "default", *(["tuned"] if found else []), "meaning"), rows)


def stability(name: str, variant: Variant) -> str:
    """Return lines about the linear loop of a baseline with default gains and, on their own task, with tuned ones."""
    tasks = {"default": variant.scenario}
    if name in tuned.names():
        tasks["tuned"] = tuned.record(name)["provenance"]["scenario"]
    lines = []
    for gains, scenario in tasks.items():
        task = scenarios.get(scenario)
        loop = f"every {task.control_period:g} s, {task.loop_delay:g} s of loop delay"
        text = baselines.stability(baselines.build(name, task, gains=gains))
        lines += [f"- {gains} gains on {scenario_link(scenario)} ({loop}): {text}"]
    return "\n".join(lines)


def flat(gains: Mapping[str, Any]) -> dict[str, Any]:
    """Return gains by name, with those of a part as ``part.gain``."""
    found: dict[str, Any] = {}
    for name, value in gains.items():
        part = value if isinstance(value, Mapping) else {"": value}
        found |= {f"{name}.{gain}".removesuffix("."): item for gain, item in part.items()}
    return found


def page(name: str, variant: Variant, family: str, flights: str, source: Path) -> str:
    """Return the page of a baseline."""
    baseline, task = baselines.baseline_class(name), variant.task(variant.scenario)
    kind = baselines.defaults(name).get("faults")
    faults = {"oracle": "the truth"} | {observer: f"[`{observer}`](../observers.md)" for observer in observers.names()}
    glance = [
        ("equations and corrections", f"[{family}](../{family}.md)"),
        ("class", f"{{py:class}}`~{baseline.__module__}.{baseline.__name__}`"),
        ("information", f"tier `{baselines.build(name, task).information}`"),
        ("faults from", faults.get(kind, variant.faults)),
        ("made for", ", ".join(scenario_link(scenario) for scenario in (variant.scenario, *variant.also))),
    ]
    code = f'from ftac_gym.evaluation import rollout\n\nhistory = rollout("{variant.scenario}", "{name}", seed={SEED})'
    blocks = [f"# {name}", f"{variant.summary.removesuffix('.')}.", table(("", ""), glance), "## Flight"]
    blocks += [f'```python\n{code}\nprint(history.metrics()["final_error"])\n```', flights]
    blocks += ["## Reproduction", reproduction(variant, source), "## Gains", gain_table(name, task)]
    blocks += ["Stability of the linear loop near rest on target:", stability(name, variant)]
    if name in tuned.names():
        origin = flat(tuned.record(name)["provenance"]).items()
        blocks += ["Origin of the tuned gains:", table(("", ""), [(key, f"`{value}`") for key, value in origin])]
    return "\n\n".join(blocks) + "\n"


def write(source: Path) -> None:
    """Write the pages and figures of all baselines, and the table of them that ``baselines/README.md`` includes."""
    facts, folder, rows = variants(source), source / "baselines" / "generated", []
    files = sorted(path for path in Path(ftac_gym.__file__).parent.rglob("*.*") if path.suffix in (".py", ".json"))
    digest = joblib.hash([path.read_bytes() for path in files])
    # Nothing is flown twice while the code stays as it is.
    cached = joblib.Memory(source / "_build" / "flights", verbose=0).cache(fly)
    pages: dict[str, str | bytes] = {}
    for name, family in sorted(families(source).items(), key=lambda item: (item[1], item[0])):
        variant = facts[name]
        flights, end, figures = cached(name, variant, digest)
        pages |= {f"{name}.md": page(name, variant, family, flights, source), **figures}
        made_for = ", ".join(f"`{scenario}`" for scenario in (variant.scenario, *variant.also))
        rows += [(f"[`{name}`](generated/{name}.md)", variant.summary, made_for, end)]
    pages["table.inc"] = table(("name", "description", "made for", "end of its flight"), rows)
    write_pages(folder, pages)
