"""Attitude errors against the bounds that a scenario prescribes."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ftac_gym.evaluation.metrics import Rollout
from ftac_gym.plots.style import INK, check_same_flight, dress, key, sheet, stroke
from ftac_gym.utils.parameters import require


def prescribed_bound(histories: Mapping[str, Rollout]) -> Figure:
    """Draw the attitude error of rollouts axis by axis, with the bounds that their scenario prescribes.

    Parameters
    ----------
    histories
        Rollouts of the same single episode, by policy.

    Raises
    ------
    ValueError
        If there are no rollouts, they do not fit each other, or the scenario prescribes no bound.
    """
    first = check_same_flight(histories)
    bound = first.scenario.prescribed_bound
    require(bound is not None, "prescribed_bound", "must be given by the scenario", first.scenario.name)
    assert bound is not None
    low, high = bound.bound(first.time)
    figure = sheet(11.0, 6.0)
    panels = figure.subplots(2, 3, sharex="row")
    late = first.time >= 0.5 * first.time[-1]
    for axis in range(3):
        for row, shown in enumerate((np.ones_like(late), late)):
            panel: Axes = panels[row, axis]
            for number, (name, history) in enumerate(histories.items()):
                panel.plot(history.time[shown], history.error_mrp[shown, 0, axis], label=name, **stroke(number).of_line)
            for edge in (low, high):
                panel.plot(
                    first.time[shown], edge[shown, axis], color=INK, linestyle=":", linewidth=1.2, label="_prescribed"
                )
            dress(panel, xlabel="time [s]" if row else "")
            if row:
                # The bounds are what is looked at here: a policy far outside is cut off.
                span = float(high[late, axis][0] - low[late, axis][0])
                panel.set_ylim(low[late, axis][0] - 0.5 * span, high[late, axis][0] + 0.5 * span)
            panel.set_xlim(first.time[shown][0], first.time[-1])
        panels[0, axis].set_title(rf"$\sigma_{axis + 1}$", fontsize=11.0, loc="left")
    dress(panels[0, 0], ylabel="attitude error, MRP [-]")
    dress(panels[1, 0], ylabel="attitude error, MRP [-]\nthe second half, enlarged")
    lines = panels[0, 0].get_lines()
    lines[-1].set_label("prescribed bounds")
    key(figure, lines, columns=6)
    return figure
