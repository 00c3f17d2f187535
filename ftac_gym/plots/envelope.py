"""The torque envelope of the wheels, before and after a fault, in three dimensions."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection

from ftac_gym.plots import style
from ftac_gym.plots.polytope import TorquePolytope
from ftac_gym.utils.parameters import require

ACROSS = 4
"""Most panels in a row."""


def wheel_envelope(polytopes: Mapping[str, TorquePolytope]) -> Figure:
    """Draw the torques that the wheels can put on the body: one panel per polytope, the first as a frame in all others.

    An arrow points in the direction of least torque, whose magnitude stands above.

    Parameters
    ----------
    polytopes
        Results of :func:`~ftac_gym.plots.torque_polytope` or :func:`~ftac_gym.plots.polytopes_along`, by name; healthy
        wheels first.

    Raises
    ------
    ValueError
        If there are none.
    """
    require(len(polytopes) > 0, "polytopes", "must hold at least one", dict(polytopes))
    shown = list(polytopes.values())
    size = 1.05 * max(float(np.abs(item.vertices).max()) for item in shown) or 1.0
    titles = [f"{style.wrapped(name, 44, ', ')}\n{guarantee(item)}" for name, item in polytopes.items()]
    rows = -(-len(shown) // ACROSS)
    columns = -(-len(shown) // rows)
    cell = 3.6 + 0.19 * max(title.count("\n") + 1 for title in titles)
    height = cell * rows + 0.4
    figure = style.figure(4.0 * columns, height)
    # Layout engines ignore the extent of the labels of three-dimensional axes.
    figure.set_layout_engine("none")
    for number, (title, item) in enumerate(zip(titles, shown, strict=True)):
        row, column = divmod(number, columns)
        corner = (column / columns, (0.4 + cell * (rows - 1 - row)) / height)
        panel: Any = figure.add_axes((*corner, 0.92 / columns, 3.5 / height), projection="3d")
        _prepare(panel, size)
        if number:
            edges = [np.concatenate([face, face[:1]]) for face in shown[0].faces]
            panel.add_collection3d(Line3DCollection(edges, colors=style.FAINT, linewidths=0.9, zorder=1), autolim=False)
        _draw_solid(panel, item, style.COLORS[min(number, 1)])
        panel.plot([0.0], [0.0], [0.0], "o", color=style.INK, markersize=3.5, zorder=3)
        if item.guaranteed > 0.0:
            tip = item.guaranteed * item.worst_direction
            panel.quiver(0.0, 0.0, 0.0, *tip, color=style.INK, linewidth=1.8, arrow_length_ratio=0.2, zorder=4)
        panel.set_title(title, fontsize=9.5, color=style.INK, parse_math=False, y=1.0, va="bottom")
    name, color = next(iter(polytopes)), style.COLORS[min(len(shown) - 1, 1)]
    label = name if len(shown) == 1 else "available torque of the wheels"
    handles: list[Any] = [Patch(facecolor=color, edgecolor=color, alpha=0.4, label=label)]
    if len(shown) > 1:
        handles.append(style.entry(name, color=style.FAINT, linewidth=1.2))
    handles.append(style.entry("worst direction", color=style.INK, linewidth=1.8))
    style.legend(figure, handles, "lower center", columns=3)
    return figure


def guarantee(polytope: TorquePolytope) -> str:
    """Return a description of the torque that a polytope has in every direction."""
    if polytope.guaranteed > 0.0:
        x, y, z = np.round(polytope.worst_direction, 2) + 0.0
        return f"at least {polytope.guaranteed:.3g} N m in any direction,\nleast along ({x:.2f}, {y:.2f}, {z:.2f})"
    return "no torque in some directions" if polytope.holds_zero else "cannot even give zero torque"


def _draw_solid(panel: Any, polytope: TorquePolytope, color: str) -> None:
    """Draw the faces, or the polygon, segment or point of a flat polytope."""
    faces = [face for face in polytope.faces if len(face) > 2]
    if faces:
        look = {"facecolors": color, "edgecolors": color, "linewidths": 0.9, "alpha": 0.28, "zorder": 2}
        panel.add_collection3d(Poly3DCollection(faces, **look), autolim=False)
    else:
        panel.plot(*polytope.vertices.T, "o-", color=color, linewidth=2.5, markersize=4.0, zorder=2)


def _prepare(panel: Any, size: float) -> None:
    panel.computed_zorder = False
    panel.set(xlim=(-size, size), ylim=(-size, size), zlim=(-size, size))
    panel.set_box_aspect((1.0, 1.0, 1.0), zoom=0.92)
    panel.set_proj_type("ortho")
    panel.view_init(elev=22.0, azim=-52.0)
    for axis, label in ((panel.xaxis, "x"), (panel.yaxis, "y"), (panel.zaxis, "z")):
        axis.set_label_text(f"torque {label} [N m]", fontsize=8.5, color=style.INK)
        axis.set_pane_color((1.0, 1.0, 1.0, 0.0))
        axis.line.set_color(style.FAINT)
        axis._axinfo["grid"]["color"] = style.GRID
    panel.locator_params(nbins=5)
    panel.tick_params(labelsize=7.5, colors=style.MUTED, pad=0.0)
