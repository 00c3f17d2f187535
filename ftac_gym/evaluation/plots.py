"""Figures of evaluations and of single episodes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import cycle

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ftac_gym.episodes import Episodes
from ftac_gym.evaluation.compare import Evaluation
from ftac_gym.evaluation.rollout import Rollout
from ftac_gym.faults import fault_effect
from ftac_gym.faults.words import drawn_faults
from ftac_gym.parameters import require

# Okabe and Ito's colours, which the colour-blind can tell apart.
COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
FLOOR = 1e-4
"""Smallest pointing error drawn [deg]."""


def error_bands(
    evaluations: Sequence[Evaluation], control_period: float, cone: float, chosen: npt.NDArray[np.bool_]
) -> Figure:
    """Draw the pointing error of policies against time: median, middle half, and 5th to 95th percentile.

    Parameters
    ----------
    evaluations
        One panel each.
    control_period
        [s].
    cone
        Success cone [deg], drawn as a line.
    chosen
        (N,) which episodes count.
    """
    figure = Figure(figsize=(4.0 * len(evaluations), 3.6), layout="constrained")
    panels = figure.subplots(1, len(evaluations), sharex=True, sharey=True, squeeze=False)[0]
    for panel, evaluation, color in zip(panels, evaluations, cycle(COLORS), strict=False):
        error = np.maximum(evaluation.attitude_error[:, chosen], FLOOR)
        low, quarter, middle, three, high = np.percentile(error, [5.0, 25.0, 50.0, 75.0, 95.0], axis=1)
        time = np.arange(len(error)) * control_period
        panel.fill_between(time, low, high, color=color, alpha=0.15, linewidth=0.0, label="5 to 95 %")
        panel.fill_between(time, quarter, three, color=color, alpha=0.35, linewidth=0.0, label="25 to 75 %")
        panel.plot(time, middle, color=color, label="median")
        panel.axhline(cone, color="black", linestyle=":", linewidth=1.0)
        panel.set(yscale="log", title=evaluation.policy, xlabel="time [s]", ylim=(FLOOR, 200.0), xlim=(0.0, time[-1]))
        panel.grid(alpha=0.3)
        panel.legend(loc="upper right", fontsize=8)
    panels[0].set_ylabel("pointing error [deg]")
    return figure


def episode(histories: Mapping[str, Rollout]) -> Figure:
    """Draw one episode in detail: errors of all policies, wheels of each, and the true fault.

    Parameters
    ----------
    histories
        Rollouts of the same single episode, by policy.
    """
    figure = Figure(figsize=(max(9.0, 4.2 * len(histories)), 10.0), layout="constrained")
    grid = figure.add_gridspec(5, len(histories))
    error, rate = figure.add_subplot(grid[0, :]), figure.add_subplot(grid[1, :])
    for (name, history), color in zip(histories.items(), cycle(COLORS), strict=False):
        pointing = np.maximum(np.degrees(history.attitude_error[:, 0]), FLOOR)
        error.plot(history.time, pointing, color=color, label=name)
        rate.plot(history.time, np.maximum(np.degrees(history.rate_error[:, 0]), FLOOR), color=color)
    error.set(yscale="log", ylabel="pointing\nerror [deg]")
    rate.set(yscale="log", ylabel="rate error\n[deg/s]")
    error.legend(loc="upper right", fontsize=8, ncols=len(histories))
    first = next(iter(histories.values()))
    success = first.scenario.success
    error.axhline(np.degrees(success.angle), color="black", linestyle=":", linewidth=1.0)
    rate.axhline(np.degrees(success.rate), color="black", linestyle=":", linewidth=1.0)
    error.set_title(describe_faults(first))
    panels: list[Axes] = [error, rate]
    for column, (name, history) in enumerate(histories.items()):
        torque, momentum = figure.add_subplot(grid[2, column]), figure.add_subplot(grid[3, column])
        fault = figure.add_subplot(grid[4, column])
        wheels, array = history.command.shape[2], history.scenario.spacecraft.wheels
        count = len(history.time) - 1
        torques = np.vstack([np.zeros((1, wheels)), history.applied_torque[:, 0]])
        drawn = history.episodes.drawn_faults.take(np.zeros(count + 1, dtype=np.int64))
        effect = fault_effect(drawn, history.time, array, history.wheel_momentum[:, 0], torques)
        for wheel in range(wheels):
            color = COLORS[wheel % len(COLORS)]
            torque.plot(history.time[1:], history.applied_torque[:, 0, wheel], color=color, linewidth=0.8)
            momentum.plot(history.time, history.wheel_momentum[:, 0, wheel], color=color, label=f"wheel {wheel}")
            fault.plot(history.time, effect.effectiveness[:, wheel], color=color, linewidth=1.2)
            fault.plot(history.time, effect.bias[:, wheel] / 0.1, color=color, linestyle="--", linewidth=1.0)
        torque.set_title(name, fontsize=10)
        panels += [torque, momentum, fault]
        if column == 0:
            torque.set_ylabel("wheel torque\n[N m]")
            momentum.set_ylabel("wheel momentum\n[N m s]")
            fault.set_ylabel("effectiveness (solid)\nbias / 0.1 N m (dashed)")
            momentum.legend(fontsize=7, ncols=2)
        fault.set_xlabel("time [s]")
    for panel in panels:
        panel.grid(alpha=0.3)
        panel.set_xlim(0.0, first.time[-1])
    return figure


def prescribed_bound(histories: Mapping[str, Rollout]) -> Figure:
    """Draw the attitude error of rollouts axis by axis, with the bounds that their scenario prescribes.

    Parameters
    ----------
    histories
        Rollouts of the same single episode, by policy.

    Raises
    ------
    ValueError
        If the scenario prescribes no bound.
    """
    first = next(iter(histories.values()))
    bound = first.scenario.prescribed_bound
    require(bound is not None, "prescribed_bound", "must be given by the scenario", first.scenario.name)
    assert bound is not None
    low, high = bound.bound(first.time)
    figure = Figure(figsize=(12.0, 6.0), layout="constrained")
    panels = figure.subplots(2, 3, sharex=True)
    late = first.time >= 0.5 * first.time[-1]
    for axis in range(3):
        for row, shown in enumerate((np.ones_like(late), late)):
            panel: Axes = panels[row, axis]
            for (name, history), color in zip(histories.items(), cycle(COLORS), strict=False):
                panel.plot(history.time[shown], history.error_mrp[shown, 0, axis], color=color, label=name)
            for edge in (low, high):
                panel.plot(first.time[shown], edge[shown, axis], color="black", linestyle=":", linewidth=1.0)
            panel.grid(alpha=0.3)
            if row:
                panel.set_xlabel("time [s]")
                # The bounds are what is looked at here: a policy far outside is cut off.
                span = float(high[late, axis][0] - low[late, axis][0])
                panel.set_ylim(low[late, axis][0] - 0.5 * span, high[late, axis][0] + 0.5 * span)
        panels[0, axis].set_title(rf"$\sigma_{axis + 1}$")
    panels[0, 0].set_ylabel("attitude error, MRP [-]")
    panels[1, 0].set_ylabel("the second half, enlarged")
    panels[0, 0].legend(fontsize=8)
    return figure


def describe_faults(history: Rollout) -> str:
    """Return the faults of a rollout's first episode in words."""
    return faults_in_words(history.episodes, 0)


def faults_in_words(episodes: Episodes, index: int) -> str:
    """Return what is wrong in an episode, and from when on, in words."""
    words = drawn_faults(episodes.drawn_faults, index)
    return "; ".join(words) if words else "healthy"
