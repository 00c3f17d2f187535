"""Success against the nominal delay margin, for a loop that is later than controllers are told: table, CSV and figure.

    python benchmarks/delay_margin.py                               # docs/delay_margin.csv and docs/delay_margin.png

All fly the same validation episodes of the flagship, of which the feasible ones count. The delay is zero to four
control periods beyond the stated one. The margin is that of the linear loop of the nominal spacecraft
(:func:`ftac_gym.baselines.loop_margins`). Without isolation a controller has nothing else. With isolation the delay of
the loop is found from the first motion. Controllers without a linear loop have no margin and are left out.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from delay_sweep import shipped, untold, usual_delay
from matplotlib.figure import Figure
from tqdm import tqdm

from ftac_gym import baselines, scenarios
from ftac_gym.baselines.linear_loop import NoLinearLoopError, loop_margins
from ftac_gym.evaluation import estimate, rollout
from ftac_gym.evaluation.episodes import judging_episodes
from ftac_gym.evaluation.files import write_figure, write_rows
from ftac_gym.evaluation.rows import statistic_of
from ftac_gym.evaluation.statistics import Estimate
from ftac_gym.plots import style
from ftac_gym.policies import DeferredBaseline
from ftac_gym.policies.policy import named_gains
from ftac_gym.task import Episodes, Scenario
from ftac_gym.utils.console import run_program

FURTHER = (0, 1, 2, 3, 4)
"""Delays beyond the stated one [control periods]."""

ROBUST: Mapping[str, Mapping[str, float]] = {
    "pd_dob, margin over 1": {"rate_gain": 0.8, "position_gain": 0.25, "bandwidth": 0.05},
    "pd_dob, margin over 2": {"rate_gain": 0.6, "position_gain": 0.2, "bandwidth": 0.05},
    "pd_dob, margin over 3": {"rate_gain": 0.5, "position_gain": 0.15, "bandwidth": 0.04},
}
"""Gains of ``pd_dob`` whose delay margin exceeds one, two and three control periods of the flagship."""

KEPT = 0.9
"""Share of the success that a baseline chosen for robustness keeps within its margin."""


@dataclass(frozen=True)
class Config:
    """Policies and episodes."""

    policies: tuple[str, ...] = field(
        default_factory=lambda: tuple(map(shipped, ("pd_dob", "pd", "lqr", "indi", "nftsm", "predefined_time")))
    )
    """Baselines; "NAME tuned" has tuned gains. Three ``pd_dob`` of low gains are added."""
    episodes: int = 100
    """Feasible validation episodes."""
    output: Path = Path(__file__).parents[1] / "docs"
    """Folder of the CSV file and of the figure."""


@dataclass(frozen=True)
class Point:
    """Success of a baseline at a further delay.

    Attributes
    ----------
    policy
        Name.
    isolation
        Whether faulty wheels, and with them the delay of the loop, are found.
    margin
        Nominal delay margin of the loop without isolation [control periods]; NaN for a loop that is unstable.
    further
        Delay beyond the stated one [control periods].
    success
        Share with Wilson's interval.
    """

    policy: str
    isolation: bool
    margin: float
    further: int
    success: Estimate


def policies_of(names: Sequence[str]) -> dict[str, tuple[str, str, Mapping[str, Any]]]:
    """Return baseline, set of gains and changed gains by the name of the policy, those of low gains at the end."""
    found: dict[str, tuple[str, str, Mapping[str, Any]]] = {}
    for text in names:
        name, gains = named_gains(text)
        found[text] = (name, gains or "default", {})
    return {**found, **{name: ("pd_dob", "default", gains) for name, gains in ROBUST.items()}}


def margin_of(task: Scenario, name: str, gains: str, changes: Mapping[str, Any]) -> float | None:
    """Return the nominal delay margin [control periods]; None for a baseline without a linear loop."""
    try:
        found = loop_margins(baselines.build(name, task, 1, gains, **{**changes, "isolation": "none"}))
    except NoLinearLoopError:
        return None
    return found.delay_margin / task.control_period


def measure(task: Scenario, names: Sequence[str], episodes: Episodes) -> list[Point]:
    """Return the points of all policies that have a margin."""
    late_task, late = untold(task, episodes, [usual_delay(task) + further for further in FURTHER])
    points = []
    for policy, (name, gains, changes) in tqdm(policies_of(names).items(), unit="policy"):
        margin = margin_of(task, name, gains, changes)
        if margin is None:
            continue
        for isolation in ("none", "rate"):
            law = DeferredBaseline(name, gains, **{**changes, "isolation": isolation})
            with np.errstate(all="ignore"):  # Loops beyond their margins are unstable.
                success = rollout(late_task, law, late).feasible_metrics()["success"]
            points += [
                Point(policy, isolation == "rate", margin, further, estimate(part, statistic_of("success")))
                for further, part in zip(FURTHER, np.split(success, len(FURTHER)), strict=True)
            ]
    return points


def _series(policy: str) -> str:
    """Return the name of a policy in the legend."""
    return "pd_dob of low gains" if policy in ROBUST else policy


def drawn(points: Sequence[Point]) -> Figure:
    """Draw the success against the margin for one further period, and against what is left of it for all."""
    chart = style.figure(9.5, 4.4)
    one, rest = chart.subplots(1, 2, sharey=True)
    policies = list(dict.fromkeys(_series(point.policy) for point in points))
    one.axvline(1.0, **{**style.LIMIT, "color": style.FAINT})
    rest.axvline(0.0, **{**style.LIMIT, "color": style.FAINT})
    for point in points:
        if not np.isfinite(point.margin):
            continue
        look = style.stroke(policies.index(_series(point.policy)))
        mark: dict[str, Any] = {
            "color": look.color, "marker": look.marker, "markersize": 6.0, "linestyle": "none", "clip_on": False,
            "markerfacecolor": "white" if point.isolation else look.color,
        }  # fmt: skip
        if point.further == 1:
            one.plot(point.margin, point.success.value, **mark)
        if point.further > 0:
            rest.plot(point.margin - point.further, point.success.value, **mark)
    label = "success, mean over feasible episodes"
    style.apply(one, "one further period, untold", "nominal delay margin [control periods]", label)
    style.apply(rest, "one to four further periods, untold", "margin minus further delay [control periods]")
    one.set_ylim(-0.02, 1.02)
    one.set_xlim(0.0, None)
    handles = []
    for number, policy in enumerate(policies):
        look = style.stroke(number)
        handles.append(style.entry(policy, color=look.color, marker=look.marker, markersize=6.0, linestyle="none"))
    for text, face in (("without isolation", style.MUTED), ("with isolation", "white")):
        handles.append(
            style.entry(
                text, color=style.MUTED, marker="o", markersize=6.0, markerfacecolor=face, linestyle="none"
            )
        )  # fmt: skip
    style.legend(chart, handles)
    return chart


def table(points: Sequence[Point]) -> list[list[str]]:
    """Return the points as rows with a header."""
    rows = [["policy", "isolation", "margin", "further", "episodes", "success", "success_low", "success_high"]]
    for point in points:
        found = point.success
        first = [point.policy, "yes" if point.isolation else "no", f"{point.margin:.2f}", str(point.further)]
        rows.append([*first, str(found.count), *(f"{value:.3f}" for value in (found.value, found.low, found.high))])
    return rows


def checks(points: Sequence[Point]) -> list[str]:
    """Return a line for each policy of low gains: what it keeps of its success within its margin, untold."""
    lines = []
    for number, policy in enumerate(ROBUST, start=1):
        own = {point.further: point for point in points if point.policy == policy and not point.isolation}
        before, after = own[0].success.value, own[number].success.value
        verdict = "kept" if after >= KEPT * before and own[number].margin > number else "NOT kept"
        lines.append(
            f"{policy} (margin {own[number].margin:.2f}): success {before:.2f}, "
            f"{after:.2f} with {number} untold: {KEPT:g} of it {verdict}"
        )
    return lines


def main(config: Config) -> None:
    """Fly, print and draw."""
    task = scenarios.get("flagship")
    points = measure(task, config.policies, judging_episodes(task, config.episodes, "validation"))
    rows = table(points)
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    for row in rows:
        print("  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip())
    print("\n".join(checks(points)))
    write_rows(config.output / "delay_margin.csv", rows)
    write_figure(config.output / "delay_margin.png", drawn(points), 110)


if __name__ == "__main__":
    run_program(main, Config, __doc__)
