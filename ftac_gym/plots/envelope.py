"""The torque envelope of the wheels, before and after a fault, in three dimensions."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection

from ftac_gym.plots.polytope import TorquePolytope
from ftac_gym.plots.style import COLORS, FAINT, GRID, INK, MUTED, folded, key, sheet
from ftac_gym.utils.parameters import require

ACROSS = 4
"""Most panels in a row."""


def wheel_envelope(polytopes: Mapping[str, TorquePolytope]) -> Figure:
    """Draw what torque the wheels can put on the body: one panel for each polytope, the first as a frame in all others.

    An arrow points where they can do least, and how much that is stands above.

    Parameters
    ----------
    polytopes
        What :func:`torque_polytope` or :func:`polytopes_along` return, by name; healthy wheels first.

    Raises
    ------
    ValueError
        If there are none.
    """
    require(len(polytopes) > 0, "polytopes", "must hold at least one", dict(polytopes))
    names, shown = list(polytopes), list(polytopes.values())
    size = 1.05 * max(float(np.abs(item.vertices).max()) for item in shown) or 1.0
    titles = [f"{folded(name, 44, ', ')}\n{in_words(item)}" for name, item in polytopes.items()]
    rows = -(-len(shown) // ACROSS)
    columns = -(-len(shown) // rows)
    cell = 3.6 + 0.19 * max(title.count("\n") + 1 for title in titles)
    figure = sheet(4.0 * columns, cell * rows + 0.4)
    # Layout engines do not see how far the labels of three-dimensional axes reach.
    figure.set_layout_engine("none")
    height = figure.get_figheight()
    for number, (title, item) in enumerate(zip(titles, shown, strict=True)):
        row, column = divmod(number, columns)
        corner = (column / columns, (0.4 + cell * (rows - 1 - row)) / height)
        panel: Any = figure.add_axes((*corner, 0.92 / columns, 3.5 / height), projection="3d")
        _space(panel, size)
        panel.computed_zorder = False
        if number:
            edges = [np.concatenate([face, face[:1]]) for face in shown[0].faces]
            panel.add_collection3d(Line3DCollection(edges, colors=FAINT, linewidths=0.9, zorder=1), autolim=False)
        _solid(panel, item, COLORS[0] if number == 0 else COLORS[1])
        panel.plot([0.0], [0.0], [0.0], "o", color=INK, markersize=3.5, zorder=3)
        if item.guaranteed > 0.0:
            tip = item.guaranteed * item.worst_direction
            panel.quiver(0.0, 0.0, 0.0, *tip, color=INK, linewidth=1.8, arrow_length_ratio=0.2, zorder=4)
        panel.set_title(title, fontsize=9.5, color=INK, parse_math=False, y=1.0, va="bottom")
    handles = [_patch(COLORS[0], names[0])]
    if len(shown) > 1:
        handles = [_patch(COLORS[1], "torque that the wheels can give"), _line(FAINT, names[0], 1.2)]
    key(figure, [*handles, _line(INK, "worst direction", 1.8)], "lower center", columns=3)
    return figure


def in_words(polytope: TorquePolytope) -> str:
    """Return what a polytope guarantees."""
    if polytope.guaranteed > 0.0:
        x, y, z = np.round(polytope.worst_direction, 2) + 0.0
        return f"at least {polytope.guaranteed:.3g} N m in any direction,\nleast along ({x:.2f}, {y:.2f}, {z:.2f})"
    return "no torque in some directions" if polytope.holds_zero else "cannot even give zero torque"


def _solid(panel: Any, polytope: TorquePolytope, color: str) -> None:
    """Draw the faces; of what is flat the polygon, the segment or the point that is left."""
    faces = [face for face in polytope.faces if len(face) > 2]
    if faces:
        panel.add_collection3d(
            Poly3DCollection(faces, facecolors=color, edgecolors=color, linewidths=0.9, alpha=0.28, zorder=2),
            autolim=False,
        )
        return
    x, y, z = polytope.vertices.T
    panel.plot(x, y, z, "o-", color=color, linewidth=2.5, markersize=4.0, zorder=2)


def _space(panel: Any, size: float) -> None:
    panel.set(xlim=(-size, size), ylim=(-size, size), zlim=(-size, size))
    panel.set_box_aspect((1.0, 1.0, 1.0), zoom=0.92)
    panel.set_proj_type("ortho")
    panel.view_init(elev=22.0, azim=-52.0)
    for axis, label in ((panel.xaxis, "x"), (panel.yaxis, "y"), (panel.zaxis, "z")):
        axis.set_label_text(f"torque {label} [N m]", fontsize=8.5, color=INK)
        axis.set_pane_color((1.0, 1.0, 1.0, 0.0))
        axis.line.set_color(FAINT)
        axis._axinfo["grid"]["color"] = GRID
    panel.locator_params(nbins=5)
    panel.tick_params(labelsize=7.5, colors=MUTED, pad=0.0)


def _patch(color: str, label: str) -> Any:
    return Patch(facecolor=color, edgecolor=color, alpha=0.4, label=label)


def _line(color: str, label: str, width: float) -> Any:
    return Line2D([], [], color=color, linewidth=width, label=label)
