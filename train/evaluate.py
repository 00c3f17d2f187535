"""Compare policies on identical episodes: table, CSV files, plots and a report.

Finished batches are kept in the output folder, so that a killed evaluation goes on where it stopped.

Examples
--------
    python train/evaluate.py
    python train/evaluate.py --policies agent pd_dob --episodes 200
    python train/evaluate.py --policies runs/my_run/agent agent pd_dob --reference agent
"""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
import numpy.typing as npt
import tyro
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from ftac_gym import baselines, scenarios
from ftac_gym.episodes import Episodes
from ftac_gym.evaluation import Estimate, Evaluation, Row, compare, evaluate, fault_classes, rollout
from ftac_gym.evaluation.agent import SHIPPED
from ftac_gym.evaluation.compare import TABLE_METRICS
from ftac_gym.evaluation.metrics import HIGHER_IS_BETTER, UNITS
from ftac_gym.evaluation.plots import episode as draw_episode
from ftac_gym.evaluation.plots import error_bands
from ftac_gym.scenario import Scenario


@dataclass(frozen=True)
class Config:
    """A comparison."""

    policies: tuple[str, ...] = ("agent", "pd_dob", "pd")
    """What to compare: "agent" (the shipped one), a baseline's name, an agent's folder or a Stable-Baselines3 zip."""
    reference: str = "pd_dob"
    """The policy that the others are compared with, episode by episode."""
    scenario: str = "flagship"
    """Scenario."""
    episodes: int = 500
    """Number of feasible episodes; the infeasible ones drawn on the way are flown too and counted apart."""
    seed: int = 10_000
    """Seed of the test split: neither training nor tuning uses it."""
    detail: int | None = None
    """Episode to draw in detail; by default the first feasible one in which a bias strikes a settled craft."""
    output: Path = Path("results")
    """Folder for the results; a folder for the scenario is made in it."""


def paths(policies: Sequence[str]) -> dict[str, str]:
    """Return what to load for each policy, by its name in the tables; refuse unknown ones before any work is done."""
    found: dict[str, str] = {}
    for policy in policies:
        if policy == "agent":
            found[policy] = str(SHIPPED / "flagship_residual")
        elif policy in baselines.names() or Path(policy).exists():
            found[policy] = policy
        else:
            raise SystemExit(f"--policies: {policy!r} is no baseline ({', '.join(baselines.names())}), agent or file")
    return found


def draw(scenario: Scenario, seed: int, feasible: int) -> Episodes:
    """Draw episodes until so many of them are feasible."""
    count = feasible
    while True:
        episodes = scenario.draw(seed, count)
        missing = feasible - int(episodes.feasible.sum())
        if missing <= 0:
            return episodes
        if count > 20 * feasible:
            raise SystemExit(f"--scenario: too few episodes of {scenario.name} are feasible to draw {feasible}")
        count += missing


def run(config: Config, scenario: Scenario, episodes: Episodes, folder: Path, console: Console) -> list[Evaluation]:
    """Run all policies, with progress."""
    columns = (TextColumn("{task.description:>12}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    evaluations = []
    with Progress(*columns, console=console) as progress:
        for name, policy in paths(config.policies).items():
            task = progress.add_task(name, total=len(episodes))
            evaluations.append(
                evaluate(
                    scenario,
                    policy,
                    episodes,
                    name=name,
                    folder=folder / "batches",
                    progress=partial(progress.advance, task),
                )
            )
    return evaluations


def number(value: Estimate) -> str:
    """Format an estimate with its interval."""
    if not value.count:
        return "-"
    point, low, high = (
        f"{item:.0f}" if abs(item) >= 1000.0 else f"{item:.3g}" for item in (value.value, value.low, value.high)
    )
    return f"{point} [{low}, {high}]"


def verdict(metric: str, difference: Estimate) -> str:
    """Format a difference; a star marks an interval without zero, with the better sign named."""
    if not difference.excludes_zero or not difference.count:
        return number(difference)
    better = (difference.value > 0.0) == (metric in HIGHER_IS_BETTER)
    return f"{number(difference)} {'better' if better else 'worse'}"


def tables(rows: list[Row], reference: str) -> tuple[list[list[str]], list[list[str]]]:
    """Return the cells of the table of estimates and of the table of paired differences, headings first."""
    heading = [f"{metric.replace('_', ' ')} [{UNITS[metric]}]" for metric in TABLE_METRICS]
    estimates = [["policy", *heading]]
    differences = [[f"minus {reference}", *heading]]
    for row in rows:
        estimates.append([row.policy, *(number(row.estimates[metric]) for metric in TABLE_METRICS)])
        if row.differences:
            differences.append([row.policy, *(verdict(metric, row.differences[metric]) for metric in TABLE_METRICS)])
    return estimates, differences


def class_table(evaluations: list[Evaluation], episodes: Episodes) -> list[list[str]]:
    """Return success and settling time by what is wrong, infeasible episodes apart."""
    classes = np.where(episodes.feasible, fault_classes(episodes), "infeasible")
    order = sorted(set(classes.tolist()), key=lambda name: (name == "infeasible", name != "healthy", name))
    cells = [["faults", "episodes", *(item.policy for item in evaluations)]]
    for name in order:
        chosen = classes == name
        row = [name, str(int(chosen.sum()))]
        for item in evaluations:
            success, settling = item.metrics["success"][chosen].mean(), item.metrics["settling_time"][chosen]
            row.append(f"{success:.2f}, {np.median(settling):.1f} s")
        cells.append(row)
    return cells


def show(console: Console, cells: list[list[str]], title: str) -> None:
    """Print a table with policies as columns: narrow enough for a terminal."""
    table = Table(title=title)
    for index, column in enumerate(zip(*([escape(cell) for cell in row] for row in cells), strict=True)):
        if index == 0:
            for heading in column:
                table.add_column(heading, no_wrap=True)
        else:
            table.add_row(*column)
    console.print(table)


def markdown(cells: list[list[str]]) -> str:
    """Format cells as a Markdown table with policies as columns."""
    columns = [list(column) for column in zip(*cells, strict=True)]
    lines = ["| " + " | ".join(columns[0]) + " |", "|" + "---|" * len(columns[0])]
    lines += ["| " + " | ".join(column) + " |" for column in columns[1:]]
    return "\n".join(lines)


def write_episodes(path: Path, evaluations: list[Evaluation], episodes: Episodes) -> None:
    """Write one line per policy and episode."""
    names = fault_classes(episodes)
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["policy", "episode", "faults", "feasible", *UNITS])
        for item in evaluations:
            for index in range(len(episodes)):
                values = [f"{item.metrics[metric][index]:.6g}" for metric in UNITS]
                writer.writerow([item.policy, index, names[index], bool(episodes.feasible[index]), *values])


def write_summary(path: Path, rows: list[Row]) -> None:
    """Write one line per policy, metric and kind of estimate."""
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["policy", "metric", "kind", "value", "low", "high", "episodes"])
        for row in rows:
            for kind, values in (("estimate", row.estimates), ("difference", row.differences)):
                for metric, item in values.items():
                    writer.writerow([row.policy, metric, kind, item.value, item.low, item.high, item.count])


def interesting(evaluations: list[Evaluation], episodes: Episodes) -> int:
    """Return the first feasible episode in which one wheel gets a bias while the craft is on target."""
    struck = ~np.isnan(evaluations[0].metrics["peak_after_fault"])
    candidates = np.flatnonzero(struck & episodes.feasible & (fault_classes(episodes) == "bias"))
    return int(candidates[0]) if candidates.size else 0


def main(config: Config) -> None:
    """Compare."""
    console = Console()
    if config.reference not in paths(config.policies):
        raise SystemExit(f"--reference: {config.reference!r} is not among the policies {list(config.policies)}")
    if config.scenario not in scenarios.names():
        raise SystemExit(f"--scenario: {config.scenario!r} is none of {scenarios.names()}")
    scenario = scenarios.get(config.scenario)
    episodes = draw(scenario, config.seed, config.episodes)
    if config.detail is not None and not 0 <= config.detail < len(episodes):
        raise SystemExit(f"--detail: {config.detail} is none of the {len(episodes)} episodes")
    feasible: npt.NDArray[np.bool_] = episodes.feasible
    folder = config.output / config.scenario
    folder.mkdir(parents=True, exist_ok=True)
    drawn = f"{len(episodes)} episodes of {config.scenario}, seed {config.seed}, {int(feasible.sum())} of them feasible"
    console.print(f"{drawn} (digest {episodes.digest()[:12]})")
    evaluations = run(config, scenario, episodes, folder, console)
    console.print("bootstrap intervals ...")
    rows = compare(evaluations, config.reference, feasible)
    estimates, differences = tables(rows, config.reference)
    by_class = class_table(evaluations, episodes)
    wide = Console(width=max(console.width, 120))
    show(wide, estimates, "feasible episodes: mean of success, interquartile mean of the rest, 95 % intervals")
    show(wide, differences, f"mean paired difference to {config.reference}, 95 % intervals")
    show(
        wide,
        [list(column) for column in zip(*by_class, strict=True)],
        "by what is wrong: mean success, median settling time",
    )
    write_episodes(folder / "episodes.csv", evaluations, episodes)
    write_summary(folder / "summary.csv", rows)

    cone = float(np.degrees(scenario.success.angle))
    error_bands(evaluations, scenario.control_period, cone, feasible).savefig(folder / "error_bands.png", dpi=120)
    detail = config.detail if config.detail is not None else interesting(evaluations, episodes)
    histories = {name: rollout(scenario, policy, episodes[detail]) for name, policy in paths(config.policies).items()}
    draw_episode(histories).savefig(folder / "episode.png", dpi=110)
    report = [
        f"# {config.scenario}: {', '.join(item.policy for item in evaluations)}",
        f"{drawn}. Same episodes for every policy; 95 % bootstrap intervals.",
        "## Feasible episodes: mean of success, interquartile mean of the rest",
        markdown(estimates),
        f"## Mean paired difference to {config.reference}",
        markdown(differences),
        "## By what is wrong: mean success, median settling time",
        markdown([list(column) for column in zip(*by_class, strict=True)]),
        "## Pointing error",
        "![error bands](error_bands.png)",
        f"## Episode {detail}",
        "![episode](episode.png)",
    ]
    (folder / "report.md").write_text("\n\n".join(report) + "\n")
    console.print(f"wrote {folder}/report.md, episodes.csv, summary.csv, error_bands.png, episode.png")


if __name__ == "__main__":
    main(tyro.cli(Config, description=__doc__))
