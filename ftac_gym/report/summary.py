"""What the report says in words: every sentence is made from the numbers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from ftac_gym.evaluation import tables
from ftac_gym.evaluation.statistics import Estimate
from ftac_gym.report.cells import MINUS, Cell, Line, Table, difference
from ftac_gym.report.results import RELATIVE, Results

if TYPE_CHECKING:
    from ftac_gym.evaluation.benchmark import Entry

NAMED = 6
"""How many names a sentence lists."""


def facts(results: Results) -> list[tuple[str, str]]:
    """Return what was flown, by heading."""
    benchmark = results.benchmark
    contestants = [entry for entry in benchmark.entries if entry.role != "bound"]
    agents = [entry for entry in contestants if entry.kind == "agent"]
    feasible = sum(int(item.feasible.sum()) for item in benchmark.episodes.values())
    listed = sum(map(len, benchmark.episodes.values()))
    found = [
        ("reference", benchmark.reference),
        ("contestants", f"{len(contestants)}, {len(agents)} of them agents"),
        ("bounds, which know the faults", str(len(benchmark.entries) - len(contestants))),
        ("splits", str(len(benchmark.episodes))),
        ("episodes per policy", f"{feasible:,} feasible, {listed - feasible:,} not"),
        ("flights", f"{sum(len(entry.policies) for entry in benchmark.entries) * listed:,}"),
    ]
    if benchmark.episodes_flown and benchmark.seconds > 0.0:
        speed = f"{benchmark.episodes_flown / benchmark.seconds:.3g} episodes/s"
        found.append((f"throughput, {benchmark.episodes_flown:,} flown in this call", speed))
    return found


def splits_table(results: Results) -> Table:
    """Return the lists of episodes with their digests."""
    lines = []
    for split, episodes in results.benchmark.episodes.items():
        count = int(episodes.feasible.sum())
        numbers = [Cell(str(item), key=item) for item in (len(episodes), count, len(episodes) - count)]
        lines.append(Line([Cell(split), *numbers, Cell(episodes.digest()[:16], code=True)]))
    return Table([Cell(text) for text in ("split", "episodes", "feasible", "infeasible", "digest")], lines)


def sentences(results: Results) -> list[str]:
    """Return who wins what, in the main split and over all of them."""
    reference, rows = results.benchmark.reference, results.rows[results.main]
    contestants = [entry for entry in results.entries() if entry.role != "bound"]
    rivals = [entry for entry in contestants if entry.name != reference]
    if not results.benchmark.episodes[results.main].feasible.any():
        return ["No episode of any split is feasible: there is nothing to compare."]
    found = []
    if contestants:
        first = contestants[0]
        own = tables.number(rows[first.name].estimates["success"])
        rest = (
            ""
            if first.name == reference
            else f"; {reference} has {tables.number(rows[reference].estimates['success'])}"
        )
        found.append(f"On {results.main}, no contestant has a higher success than {first.name}: {own}{rest}.")
    if rivals:
        found.append(_told_apart(results, rivals, "success", "succeed more often", "succeed less often", _plain))
        found.append(_told_apart(results, rivals, RELATIVE, "settle sooner", "settle later", _percent))
        found += _over_splits(results, rivals)
    bounds = [entry for entry in results.entries() if entry.role == "bound"]
    if bounds:
        reached = tables.number(rows[bounds[0].name].estimates["success"])
        found.append(f"The best bound, {bounds[0].name}, which knows the faults, has a success of {reached}.")
    return found


def _told_apart(
    results: Results, rivals: Sequence[Entry], metric: str, better: str, worse: str, said: Callable[[Estimate], str]
) -> str:
    """Say who differs from the reference in the main split by more than chance."""
    found: dict[str, list[tuple[str, Estimate]]] = {"better": [], "worse": [], "": []}
    for entry in rivals:
        item = results.rows[results.main][entry.name].differences[metric]
        found[difference(metric, item).mark].append((entry.name, item))
    parts = []
    for mark, words in (("better", better), ("worse", worse)):
        items = sorted(found[mark], key=lambda pair: -abs(pair[1].value))
        names = ", ".join(f"{name} ({said(item)})" for name, item in items[:NAMED])
        more = f" and {len(items) - NAMED} more" if len(items) > NAMED else ""
        parts.append(f"{len(items)} {words}" + (f": {names}{more}" if items else ""))
    return (
        f"Against {results.benchmark.reference} on {results.main}, with intervals that exclude zero, of {len(rivals)} "
        f"contestants {parts[0]}; {parts[1]}; {len(found[''])} cannot be told apart from it."
    )


def _over_splits(results: Results, rivals: Sequence[Entry]) -> list[str]:
    """Say of the best rivals, and of the best agent of each tier, in how many splits they differ from the reference."""
    if len(results.rows) < 2:
        return []
    agents: dict[str, Entry] = {}
    for entry in rivals:
        if entry.kind == "agent":
            agents.setdefault(entry.tier, entry)
    chosen = {entry.name for entry in [*rivals[:3], *agents.values()]}
    said = []
    for name in (entry.name for entry in rivals if entry.name in chosen):
        counts = []
        for metric in ("success", RELATIVE):
            marks = [difference(metric, rows[name].differences[metric]).mark for rows in results.rows.values()]
            counts.append(f"better in {marks.count('better')} and worse in {marks.count('worse')}")
        said.append(
            f"By the same measure, of the {len(results.rows)} splits, {name} has a success that is {counts[0]}, and a "
            f"settling time that is {counts[1]}."
        )
    return said


def _plain(item: Estimate) -> str:
    return f"{item.value:+.3g} [{item.low:.3g}, {item.high:.3g}]".replace("-", MINUS)


def _percent(item: Estimate) -> str:
    return f"{100.0 * item.value:+.3g} % [{100.0 * item.low:.3g}, {100.0 * item.high:.3g}]".replace("-", MINUS)


METHOD = (
    "All policies fly the same episodes. Success is a mean, every other metric an interquartile mean over feasible "
    "episodes and all training seeds. Intervals hold 95 %: a bootstrap that draws episodes and, for agents, training "
    "seeds anew. Differences to the reference are means over pairs in the same episode; better and worse are said "
    "where the interval excludes zero, without correction for the number of comparisons. Infeasible episodes, in which "
    "the wheels that are left cannot do the task, count nowhere but in the tables by kind of fault, apart."
)
"""How the numbers are made."""
