"""Tables and figures of a comparison of policies on the scenarios of ``ftac-evaluate``."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure

from ftac_gym.evaluation import Evaluation, Row, fault_classes, rollout
from ftac_gym.evaluation.files import (
    RECOVERY_COLUMNS,
    CsvRows,
    recovery_rows,
    write_episodes,
    write_figure,
    write_rows,
    write_summary,
)
from ftac_gym.evaluation.tables import (
    Cells,
    budget_table,
    kind_table,
    markdown,
    metric_tables,
    recovery_table,
    split_table,
)
from ftac_gym.plots import episode as draw_episode
from ftac_gym.plots import error_bands, prescribed_bound
from ftac_gym.plots.fault_gallery import fault_gallery
from ftac_gym.policies import Policy
from ftac_gym.task.episodes import Episodes
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.files import locked, reason_of, write_text

PATIENCE = 60.0
"""Time to wait for another process that writes a report in the same folder [s]."""


@dataclass(frozen=True, eq=False)
class Drawing:
    """A figure with its heading in the report and its resolution [dots/in]."""

    heading: str
    figure: Figure
    resolution: int


def tables(
    evaluations: Mapping[str, list[Evaluation]],
    rows: Mapping[str, list[Row]],
    episodes: Mapping[str, Episodes],
    reference: str,
    which: str,
) -> dict[str, Cells]:
    """Return the tables of a comparison by title.

    Parameters
    ----------
    evaluations
        One per policy, by scenario; metrics are shown of the first scenario.
    rows
        Their estimates and differences (:func:`~ftac_gym.evaluation.tabulate`).
    episodes
        The episodes of each scenario, feasible where they count.
    reference
        Name of the policy that the others are compared with.
    which
        The word for the episodes that count.
    """
    main = next(iter(rows))
    estimates, differences = metric_tables(rows[main], reference)
    splits = split_table(rows, episodes)
    found = {
        f"{main}, {which} episodes: mean of shares, interquartile mean of the rest, 95 % intervals": estimates,
        f"mean paired difference to {reference}, 95 % intervals": differences,
        f"by split, {which} and all drawn episodes: availability, success, settling time, integrated error": splits,
        "by what is wrong: mean availability and success, median settling time": kind_table(evaluations, episodes),
        f"{main}, pointing budgets over the last seconds, time and episodes together": budget_table(
            evaluations[main], episodes[main].feasible
        ),
        f"{main}, recovery: share within 10 s, median, number of faults": recovery_table(
            evaluations[main], episodes[main]
        ),
    }
    return {title: cells for title, cells in found.items() if len(cells) > 1}


def drawings(
    scenario: Scenario,
    policies: Mapping[str, Policy],
    reference: str,
    evaluations: list[Evaluation],
    episodes: Episodes,
    chosen: npt.NDArray[np.bool_],
    detail: int | None = None,
) -> dict[str, Drawing]:
    """Return the figures of a scenario by name; a warning says so if the reference fails in a kind of fault.

    Parameters
    ----------
    scenario
        The task.
    policies
        By name.
    reference
        Name of the policy that flies every kind of fault.
    evaluations
        One per policy.
    episodes
        The episodes.
    chosen
        (N,) which episodes count.
    detail
        Episode to draw in detail; None for the first feasible one with the onset of a bias on target.
    """
    cone = float(np.degrees(scenario.success.angle))
    bands = error_bands(evaluations, scenario.control_period, cone, chosen)
    shown = _onset_on_target(evaluations[0], episodes) if detail is None else detail
    histories = {name: rollout(scenario, policy, episodes[shown]) for name, policy in policies.items()}
    found = {
        "error_bands": Drawing("## Pointing error", bands, 120),
        "episode": Drawing(f"## Episode {shown}", draw_episode(histories), 110),
    }
    if scenario.prescribed_bound is not None:
        found["prescribed_bound"] = Drawing("", prescribed_bound(histories), 110)
    try:
        gallery = fault_gallery(scenario, policies[reference])
    except Exception as error:
        warnings.warn(f"fault kinds are not drawn, {reference} fails in them: {reason_of(error)}", stacklevel=2)
        return found
    return {**found, "fault_kinds": Drawing(f"## Every fault kind under {reference}", gallery, 80)}


def _onset_on_target(evaluation: Evaluation, episodes: Episodes) -> int:
    """Return the first feasible episode with the onset of a bias while the spacecraft is on target."""
    on_target = evaluation.recoveries.counted.any(axis=1)
    candidates = np.flatnonzero(on_target & episodes.feasible & (fault_classes(episodes) == "bias"))
    return int(candidates[0]) if candidates.size else 0


def write_comparison(
    folder: Path,
    evaluations: Mapping[str, list[Evaluation]],
    rows: Mapping[str, list[Row]],
    episodes: Mapping[str, Episodes],
    lines: Sequence[str],
    cells: Mapping[str, Cells],
    figures: Mapping[str, Drawing],
    files: Mapping[str, CsvRows] | None = None,
) -> Path:
    """Write CSV files into a folder for each scenario, figures and report into that of the first; return the last.

    Comparisons of several processes are not mixed.

    Parameters
    ----------
    folder
        The folder of all scenarios.
    evaluations, rows, episodes
        By scenario.
    lines
        Origin of the numbers, one item each.
    cells, figures
        As :func:`tables` and :func:`drawings` return them.
    files
        Rows of further CSV files of the first scenario, by name.

    Raises
    ------
    ValueError
        If another process keeps the folder for more than :data:`PATIENCE`.
    """
    main = next(iter(evaluations))
    text = [
        f"# {main}: {', '.join(item.policy for item in evaluations[main])}",
        "Same episodes for every policy; 95 % bootstrap intervals.",
        "\n".join(f"- {line}" for line in lines),
    ]
    for title, table in cells.items():
        text += [f"## {title}", markdown(table)]
    for name, drawing in figures.items():
        text += filter(None, [drawing.heading, f"![{name.replace('_', ' ')}]({name}.png)"])
    with locked(folder, PATIENCE):
        for scenario, items in evaluations.items():
            write_episodes(folder / scenario / "episodes.csv", items, episodes[scenario])
            recoveries = (row for item in items for row in recovery_rows(item, item.policy))
            write_rows(folder / scenario / "recoveries.csv", [("policy", *RECOVERY_COLUMNS), *recoveries])
            write_summary(folder / scenario / "summary.csv", rows[scenario])
        for name, lines_of_file in (files or {}).items():
            write_rows(folder / main / f"{name}.csv", lines_of_file)
        for name, drawing in figures.items():
            write_figure(folder / main / f"{name}.png", drawing.figure, drawing.resolution)
        report = folder / main / "report.md"
        write_text(report, "\n\n".join(text) + "\n")
    return report
