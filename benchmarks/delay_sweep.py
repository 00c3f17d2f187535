"""Success and availability of controllers against the delay of the loop: a table, a CSV file and a figure.

    python benchmarks/delay_sweep.py                                # docs/delay_sweep.csv and docs/delay_sweep.png
    python benchmarks/delay_sweep.py --policies pd_dob "pd_dob tuned" --episodes 200 --output results

All fly the same validation episodes of the flagship, of which the feasible ones count. The delay is the true one, in
control periods from a measurement until its command takes effect. It is told where the scenario states it
(``loop_delay``): observers then compare the motion with the command that was in effect. It is untold where the scenario
states its usual delay, and the rest is the episodes' ``extra_delay``. A delay below the usual one is always told.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from tqdm import tqdm

from ftac_gym import scenarios
from ftac_gym.baselines import tuned
from ftac_gym.evaluation import estimate, rollout
from ftac_gym.evaluation.episodes import judging_episodes
from ftac_gym.evaluation.files import write_figure, write_rows
from ftac_gym.evaluation.rows import statistic_of
from ftac_gym.evaluation.statistics import Estimate
from ftac_gym.plots import style
from ftac_gym.policies.policy import TUNED
from ftac_gym.task import Episodes, Scenario
from ftac_gym.utils.console import run_program
from ftac_gym.utils.parameters import require

METRICS = ("availability", "success")
"""Metrics of the sweep, panel by panel."""

MOST = 0.05
"""Success that one told period more may cost."""

TOLD, UNTOLD = {"linestyle": "-"}, {"linestyle": (0, (1.6, 1.4)), "zorder": 1.8}
"""Look of the lines of told and untold delays."""


@dataclass(frozen=True)
class Config:
    """Policies, delays and episodes."""

    policies: tuple[str, ...] = field(
        default_factory=lambda: tuple(
            map(shipped, ("pd_dob", "lqr", "indi", "nftsm_isolation", "predefined_time_isolation", "nftsm_observer"))
        )
    )
    """Policies; "NAME tuned" has tuned gains, "NAME FILE.json" those of ftac-tune."""
    delays: tuple[int, ...] = (0, 1, 2, 3, 4, 5)
    """Delays of the loop [control periods]."""
    episodes: int = 100
    """Feasible validation episodes."""
    scenario: str = "flagship"
    """Scenario whose delay is swept."""
    output: Path = Path(__file__).parents[1] / "docs"
    """Folder of the CSV file and of the figure."""


@dataclass(frozen=True)
class Point:
    """Estimates of a policy at a delay.

    Attributes
    ----------
    policy
        Name.
    delay
        True delay of the loop [control periods].
    told
        Whether the scenario states it.
    episodes
        Number of feasible episodes behind the estimates.
    estimates
        Mean with its bootstrap interval, by metric.
    """

    policy: str
    delay: int
    told: bool
    episodes: int
    estimates: dict[str, Estimate]


def shipped(name: str) -> str:
    """Return a baseline with its tuned gains, if it has any."""
    return name + TUNED if name in tuned.names() else name


def usual_delay(task: Scenario) -> int:
    """Return the delay of the loop that a scenario states [control periods].

    Raises
    ------
    ValueError
        If it is no whole number.
    """
    usual = round(task.loop_delay / task.control_period)
    whole = abs(usual * task.control_period - task.loop_delay) < 1e-9
    require(whole, "loop_delay", "must be a multiple of the control period", task.loop_delay)
    return usual


def told(task: Scenario, delay: int) -> Scenario:
    """Return a scenario with a stated delay of the loop [control periods]."""
    # A multiple of the physics step to the last bit.
    return task.replace(loop_delay=delay * task.substeps * task.physics_step)


def untold(task: Scenario, episodes: Episodes, delays: Sequence[int]) -> tuple[Scenario, Episodes]:
    """Return a scenario and all episodes once for each true delay of the loop, which the scenario does not state.

    Parameters
    ----------
    task, episodes
        The scenario with its usual ``loop_delay``, and its episodes.
    delays
        True delays [control periods]; what exceeds the usual one is extra.

    Raises
    ------
    ValueError
        If a delay is below the usual one.
    """
    extra = np.array(delays) - usual_delay(task)
    require(bool((extra >= 0).all()), "delays", "must be at least the usual one if they are untold", delays)
    side_by_side = episodes[np.tile(np.arange(len(episodes)), len(delays))]
    each = np.repeat(extra, len(episodes))
    return task.replace(extra_delay=(int(extra.min()), int(extra.max()))), replace(side_by_side, extra_delay=each)


def sweep(task: Scenario, policies: Sequence[str], delays: Sequence[int], episodes: Episodes) -> list[Point]:
    """Return the points of all policies: at every delay told, and untold where the delay exceeds the usual one."""
    longer = [delay for delay in delays if delay > usual_delay(task)]
    points = []
    for policy in tqdm(policies, unit="policy"):
        for delay in delays:
            points += _points(policy, [delay], True, told(task, delay), episodes)
        if longer:
            points += _points(policy, longer, False, *untold(task, episodes, longer))
    return points


def _points(policy: str, delays: Sequence[int], is_told: bool, task: Scenario, episodes: Episodes) -> list[Point]:
    """Fly a policy, and return its points at delays whose episodes are side by side."""
    with np.errstate(all="ignore"):  # Some gains are unstable at long delays.
        metrics = rollout(task, policy, episodes).feasible_metrics()
    parts = {name: np.split(metrics[name], len(delays)) for name in METRICS}
    return [
        Point(
            policy,
            delay,
            is_told,
            parts[METRICS[0]][k].size,
            {name: estimate(parts[name][k], statistic_of(name)) for name in METRICS},
        )
        for k, delay in enumerate(delays)
    ]


def untold_differs(points: Sequence[Point], policy: str) -> bool:
    """Tell whether it makes a difference for a policy that a delay is told."""
    known = {point.delay: point.estimates for point in points if point.policy == policy and point.told}
    return any(known.get(p.delay) != p.estimates for p in points if p.policy == policy and not p.told)


def told_cost(points: Sequence[Point], policy: str, usual: int) -> float | None:
    """Return the success that one told period beyond the usual delay costs; None if it was not flown."""
    known = {point.delay: point.estimates["success"].value for point in points if point.policy == policy and point.told}
    return known[usual] - known[usual + 1] if {usual, usual + 1} <= known.keys() else None


def drawn(points: Sequence[Point], usual: int) -> Figure:
    """Draw both metrics against the delay, policy by policy.

    Parameters
    ----------
    points
        Points of the sweep.
    usual
        Usual delay of the loop [control periods], at which a line is drawn.
    """
    policies = list(dict.fromkeys(point.policy for point in points))
    chart = style.figure(9.5, 4.2)
    panels = chart.subplots(1, len(METRICS), sharex=True)
    delays = sorted({point.delay for point in points})
    for panel, metric in zip(panels, METRICS, strict=True):
        panel.axvline(usual, **{**style.LIMIT, "color": style.FAINT})
        for number, policy in enumerate(policies):
            look = style.stroke(number)
            for is_told, line in ((True, TOLD), (False, UNTOLD)):
                if is_told or untold_differs(points, policy):
                    # The usual delay is where both lines begin.
                    chosen = [p for p in points if p.policy == policy and (p.told is is_told or p.delay == usual)]
                    chosen.sort(key=lambda point: point.delay)
                    values = [point.estimates[metric].value for point in chosen]
                    panel.plot(
                        [p.delay for p in chosen], values, color=look.color, marker=look.marker, markersize=5.0,
                        markerfacecolor=look.color if is_told else "white", **line,
                    )  # fmt: skip
        style.apply(panel, metric, "true delay of the loop [control periods]", "mean over feasible episodes")
        panel.set_ylim(-0.02, 1.02 if metric == "success" else None)
        panel.set_xticks(delays)
    handles = [
        style.entry(policy, color=style.stroke(number).color, marker=style.stroke(number).marker, markersize=5.0)
        for number, policy in enumerate(policies)
    ]
    handles += [style.entry("told", color=style.MUTED, **TOLD), style.entry("untold", color=style.MUTED, **UNTOLD)]
    style.legend(chart, handles)
    return chart


def table(points: Sequence[Point]) -> list[list[str]]:
    """Return the points as rows with a header."""
    bounds = [f"{metric}{part}" for metric in METRICS for part in ("", "_low", "_high")]
    rows = [["policy", "delay", "told", "episodes", *bounds]]
    for point in points:
        found = (point.estimates[name] for name in METRICS)
        values = [value for item in found for value in (item.value, item.low, item.high)]
        first = [point.policy, str(point.delay), "yes" if point.told else "no", str(point.episodes)]
        rows.append([*first, *(f"{value:.3f}" for value in values)])
    return rows


def main(config: Config) -> None:
    """Fly, print and draw."""
    task = scenarios.get(config.scenario)
    episodes = judging_episodes(task, config.episodes, "validation")
    points = sweep(task, config.policies, config.delays, episodes)
    rows = table(points)
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    for row in rows:
        print("  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip())
    for policy in config.policies:
        cost = told_cost(points, policy, usual_delay(task))
        if cost is not None:
            verdict = "at most" if cost <= MOST + 1e-9 else "MORE than"
            print(f"{policy}: one told period more costs {cost:+.3f} of the success, {verdict} {MOST:g}")
    write_rows(config.output / "delay_sweep.csv", rows)
    write_figure(config.output / "delay_sweep.png", drawn(points, usual_delay(task)), 110)


if __name__ == "__main__":
    run_program(main, Config, __doc__)
