"""The page: sections of text, figures and tables, put into the template."""

from __future__ import annotations

import inspect
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from importlib import resources
from typing import TYPE_CHECKING, Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from ftac_gym import __version__, baselines
from ftac_gym.report import summary, tables
from ftac_gym.report.cells import Table, seeds
from ftac_gym.report.pictures import Picture
from ftac_gym.report.results import COMPARED, Results
from ftac_gym.report.vector import inline
from ftac_gym.report.worst import law_of, worst_episodes

if TYPE_CHECKING:
    from ftac_gym.evaluation.benchmark import Entry

_PACKAGE = "ftac_gym.report"

GROUPS = {"attitude": "Attitude tier", "telemetry": "Telemetry tier", "oracle": "Oracle tier", "bounds": "Bounds"}
"""Tables of entries, in this order, and their headings."""

_EXPLAINED = {
    "attitude": "These know attitude, rate and their last command.",
    "telemetry": "These know the momentum of the wheels besides.",
    "oracle": "These know the true faults.",
    "bounds": "These know the true faults: they show what is left to gain, and do not compete.",
}


@dataclass(frozen=True)
class _Drawn:
    svg: Markup
    caption: str


@dataclass(frozen=True)
class Block:
    """A part of a section, folded if ``details`` says of what; shown in the order of the fields."""

    heading: str = ""
    details: str = ""
    opened: bool = False
    printed: bool = True
    text: Sequence[str] = ()
    listed: Sequence[str] = ()
    facts: Sequence[tuple[str, str]] = ()
    picture: _Drawn | None = None
    table: Table | None = None
    code: str = ""
    parts: Sequence[Block] = ()


@dataclass(frozen=True)
class Section:
    """A section of the page."""

    anchor: str
    title: str
    blocks: Sequence[Block] = field(default_factory=list)


def render(results: Results, pictures: Mapping[str, Picture]) -> str:
    """Return the page."""
    drawn = {
        name: _Drawn(Markup(inline(item.document, name.replace("_", "-"), item.caption)), item.caption)
        for name, item in pictures.items()
    }
    environment = Environment(
        loader=PackageLoader(_PACKAGE, ""), autoescape=True, undefined=StrictUndefined, trim_blocks=True
    )
    sections = [
        _summary(results),
        _main(results, drawn),
        _by_split(results, drawn),
        _by_fault(results, drawn),
        _improvement(results, drawn),
        Section("profiles", "Performance profiles", _figure(drawn, "profiles", "No episode is feasible.")),
        _worst(results),
        Section("training", "Training curves", _figure(drawn, "training", "No agent with training curves was flown.")),
        _costs(results),
        _cards(results),
    ]
    return environment.get_template("page.html.jinja").render(
        title="Fault-tolerant attitude control: benchmark",
        lead=_lead(results),
        sections=sections,
        style=_asset("style.css"),
        script=_asset("script.js"),
        footer=f"Written by ftac_gym {__version__}. The same numbers lie beside this file as CSV, its figures as SVG.",
    )


def _asset(name: str) -> Markup:
    """Return a style sheet or script of this package: the page must hold it as it is."""
    return Markup(resources.files(_PACKAGE).joinpath(name).read_text(encoding="utf-8"))


def _lead(results: Results) -> str:
    count = len(results.order)
    splits = ", ".join(results.rows)
    return f"{count} {'policy' if count == 1 else 'policies'} on identical episodes of {splits}."


def _summary(results: Results) -> Section:
    words = Block(listed=summary.sentences(results))
    method = Block(details="How the numbers are made", text=[summary.METHOD])
    lists = Block(heading="Episodes", table=summary.splits_table(results))
    return Section("summary", "Summary", [Block(facts=summary.facts(results)), words, lists, method])


def _main(results: Results, drawn: Mapping[str, _Drawn]) -> Section:
    blocks = [Block(picture=drawn["main"])] if "main" in drawn else []
    for split in results.rows:
        if split == results.main:
            blocks += _tiers(results, split)
        elif results.benchmark.episodes[split].feasible.any():
            blocks.append(Block(details=f"The same tables for {split}", parts=_tiers(results, split)))
    return Section("metrics", "Metrics by tier", blocks)


def _tiers(results: Results, split: str) -> list[Block]:
    """Return the tables of a split: of each tier, metrics and differences to the reference."""
    blocks, reference = [], results.benchmark.reference
    for name, title in GROUPS.items():
        if entries := results.entries(name):
            table = tables.estimates_table(results, split, entries)
            blocks.append(Block(heading=f"{title} on {split}", text=[_EXPLAINED[name]], table=table))
        if any(entry.name != reference for entry in entries):
            table = tables.differences_table(results, split, entries)
            blocks.append(Block(heading=f"{title} on {split}, difference to {reference}", table=table))
    return blocks


def _by_split(results: Results, drawn: Mapping[str, _Drawn]) -> Section:
    blocks = []
    for metric in ("success", "settling_time"):
        title = f"{metric.replace('_', ' ').capitalize()} by split"
        blocks.append(Block(heading=title, picture=drawn.get(f"{metric}_by_split")))
        table = tables.split_table(results, metric)
        blocks.append(Block(details=f"{title}, in numbers with intervals", table=table))
    reference = results.benchmark.reference
    note = f"In the tables, blue is better than {reference} and orange worse, with an interval that excludes zero."
    return Section("splits", "By split", [Block(text=[note]), *blocks])


def _by_fault(results: Results, drawn: Mapping[str, _Drawn]) -> Section:
    blocks = [Block(picture=drawn["success_by_fault"])]
    for split in results.rows:
        table = tables.fault_table(results, split)
        blocks.append(Block(details=f"{split}: mean success, median settling time", table=table))
    return Section("faults", "By kind of fault", blocks)


def _improvement(results: Results, drawn: Mapping[str, _Drawn]) -> Section:
    blocks = []
    for metric in COMPARED:
        name = f"improvement_{metric}"
        if name in drawn:
            title = f"Better {metric.replace('_', ' ')}"
            blocks.append(Block(heading=title, picture=drawn[name]))
            table = tables.improvement_table(results, metric)
            blocks.append(Block(details=f"{title}, in numbers with intervals", table=table))
    blocks = blocks or [Block(text=["There are no two contestants to compare."])]
    return Section("improvement", "Probability of improvement", blocks)


def _figure(drawn: Mapping[str, _Drawn], name: str, otherwise: str) -> list[Block]:
    return [Block(picture=drawn[name]) if name in drawn else Block(text=[otherwise])]


def _worst(results: Results) -> Section:
    worst = worst_episodes(results)
    reference = results.benchmark.reference
    whose = sorted({item.entry for item in worst})
    note = (
        f"Feasible episodes in which {reference} takes longest to settle."
        if whose in ([], [reference])
        else f"Feasible episodes in which {' and '.join(whose)} lose{'s' if len(whose) == 1 else ''} most time against "
        f"{reference}. The metrics are those of the seed that does worst there."
    )
    hint = "Each command flies the episode of its last number again and draws errors, wheels and the true fault."
    blocks = [Block(text=[note, hint])]
    for number, split in enumerate(results.rows):
        if any(item.split == split for item in worst):
            table = tables.worst_table(results, split, worst)
            commands = dict.fromkeys(item.command for item in worst if item.split == split and item.command)
            blocks.append(Block(details=split, opened=number == 0, table=table, code="\n".join(commands)))
    return Section("worst", "Worst episodes", blocks)


def _costs(results: Results) -> Section:
    note = "A control step is all that a controller computes for one craft, its base and observers included."
    return Section("costs", "Costs", [Block(text=[note], table=tables.costs_table(results))])


def _cards(results: Results) -> Section:
    blocks = []
    for entry in results.entries():
        what = f"agent, {seeds(len(entry.policies))}" if entry.kind == "agent" else "gains"
        parts: dict[str, Any] = {"tier": entry.tier, "role": entry.role}
        if entry.kind != "agent":
            parts["gains"] = gains_of(entry)
        if entry.provenance:
            parts["cards" if entry.kind == "agent" else "provenance"] = dict(entry.provenance)
        code = json.dumps(parts, indent=2, default=str, ensure_ascii=False)
        blocks.append(Block(details=f"{entry.name}: {what}", printed=False, code=code))
    return Section("cards", "Cards of agents and gains of baselines", blocks)


def gains_of(entry: Entry) -> dict[str, Any]:
    """Return the gains that a baseline of this package flies with, the law's defaults among them; none of others."""
    name = law_of(entry)
    if name is None:
        return {}
    fingerprint = getattr(entry.policies[0], "fingerprint", None)
    changes = json.loads(fingerprint)[1] if fingerprint else baselines.chosen(name, entry.gains or "default", {})
    signature = inspect.signature(baselines.baseline_class(name)).parameters.values()
    defaults = {
        item.name: item.default
        for item in signature
        if item.default is not item.empty and item.name not in ("scenario", "num_spacecraft")
    }
    return {**defaults, **changes}
