"""Attitude errors against the bounds that a scenario prescribes."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from ftac_gym.evaluation.metrics import Rollout
from ftac_gym.plots import style
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
    first = style.first_of(histories)
    bound = first.scenario.prescribed_bound
    require(bound is not None, "prescribed_bound", "must be given by the scenario", first.scenario.name)
    assert bound is not None
    edges = bound.bound(first.time)
    figure = style.figure(11.0, 6.0)
    panels = figure.subplots(2, 3, sharex="row")
    half = int(np.argmax(first.time >= 0.5 * first.time[-1]))
    labels = ("attitude error, MRP [-]", "attitude error, MRP [-]\nthe second half, enlarged")
    for (row, axis), panel in np.ndenumerate(panels):
        shown = slice(half if row else 0, None)
        for number, history in enumerate(histories.values()):
            panel.plot(history.time[shown], history.error_mrp[shown, 0, axis], **style.stroke(number).of_line)
        for edge in edges:
            panel.plot(first.time[shown], edge[shown, axis], **style.LIMIT)
        style.apply(panel, xlabel="time [s]" if row else "", ylabel=labels[row] if axis == 0 else "")
        panel.set_xlim(first.time[shown][0], first.time[-1])
        if row:
            # The bounds set the scale: a policy far outside is cut off.
            low, high = (float(edge[half, axis]) for edge in edges)
            panel.set_ylim(low - 0.5 * (high - low), high + 0.5 * (high - low))
        else:
            panel.set_title(rf"$\sigma_{axis + 1}$", fontsize=11.0, loc="left")
    style.legend(figure, [*style.entries(histories), style.entry("prescribed bounds", **style.LIMIT)], columns=6)
    return figure
