"""The path of a boresight on the sphere."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ftac_gym.attitude import cross, quaternion_error, rotate_to_reference
from ftac_gym.evaluation.metrics import Rollout
from ftac_gym.plots.overview import fault_description
from ftac_gym.plots.style import FAINT, INK, MUTED, check_same_flight, dress, head, key, sheet, stroke
from ftac_gym.utils.directions import across, circle, graticule
from ftac_gym.utils.parameters import FloatArray, require, vector

FAR = 0.3
"""Opacity of what lies on the far side of the sphere."""


def boresight_paths(histories: Mapping[str, Rollout], boresight: Sequence[float] = (0.0, 0.0, 1.0)) -> Figure:
    """Draw where a boresight points, on the sphere of inertial directions and, enlarged, as seen from the target.

    What is on the far side of the sphere is pale. In the enlargement the target stands still at the origin, even if the
    reference moves, and the dotted circle is the success cone.

    Parameters
    ----------
    histories
        Rollouts of the same single episode, by policy; of several episodes the first is drawn.
    boresight
        (3,) its direction in body axes, of any length.

    Raises
    ------
    ValueError
        If there are no rollouts, they do not fit each other, or the boresight has no direction.
    """
    first = check_same_flight(histories)
    given = np.array(vector(boresight, 3, "boresight"))
    length = float(np.linalg.norm(given))
    require(length > 1e-12, "boresight", "must not be zero", tuple(boresight))
    axis: FloatArray = given / length
    paths = [directions(history.attitude[:, 0], axis) for history in histories.values()]
    target = directions(first.reference_attitude[:, 0], axis)
    figure = sheet(10.5, 5.6)
    globe: Any = figure.add_subplot(1, 2, 1, projection="3d")
    camera = _camera(paths, target[-1])
    _globe(globe, camera)
    for number, path in enumerate(paths):
        look = stroke(number)
        _on_sphere(globe, path, camera, linewidth=1.8, **look.of_line)
        globe.plot(*path[-1], marker=look.marker, color=look.color, markersize=5.5, linestyle="none")
    globe.plot(*paths[0][0], marker="o", color="white", markeredgecolor=INK, markersize=7.0, linestyle="none")
    moving = bool(np.ptp(target, axis=0).max() > 1e-6)
    if moving:
        _on_sphere(globe, target, camera, color=INK, linewidth=1.0, linestyle=":")
    globe.plot(*target[-1], marker="x", color=INK, markersize=9.0, markeredgewidth=2.0, linestyle="none")
    globe.set_title("unit sphere of inertial directions [-]", fontsize=10.0, color=INK)
    _enlarged(figure.add_subplot(1, 2, 2), histories, axis)
    head(figure, fault_description(first.episodes))
    lines = [
        Line2D(
            [], [], label=name, linewidth=1.8, marker=stroke(number).marker, markersize=5.5, **stroke(number).of_line
        )
        for number, name in enumerate(histories)
    ]
    start = {"marker": "o", "markerfacecolor": "white", "markeredgecolor": INK, "label": "start"}
    goal = {"marker": "x", "color": INK, "markersize": 8.0, "markeredgewidth": 2.0, "label": "target at the end"}
    key(figure, [*lines, *(Line2D([], [], linestyle="none", **item) for item in (start, goal))], columns=5)
    return figure


def directions(attitude: FloatArray, axis: FloatArray) -> FloatArray:
    """Return where a body axis (3,) points at attitudes (T, 4), (T, 3) unit vectors in inertial axes."""
    return rotate_to_reference(attitude, np.broadcast_to(axis, (len(attitude), 3)))


def offsets(history: Rollout, axis: FloatArray) -> FloatArray:
    """Return how far a boresight of the first craft is off its target in two directions across it, (T + 1, 2) [deg].

    The length of a row is the angle between the two, so that the far end of the sphere is a circle of 180 deg.
    """
    error = quaternion_error(history.attitude[:, 0], history.reference_attitude[:, 0])
    seen = directions(error, axis)
    first = np.eye(3)[int(np.argmin(np.abs(axis)))]
    first = first - (first @ axis) * axis
    first /= np.linalg.norm(first)
    across = np.stack([seen @ first, seen @ cross(axis, first)], axis=1)
    sine = np.linalg.norm(across, axis=1)
    angle = np.degrees(np.arctan2(sine, seen @ axis))
    scaled: FloatArray = across * (angle / np.maximum(sine, 1e-15))[:, None]
    return scaled


def _enlarged(panel: Axes, histories: Mapping[str, Rollout], axis: FloatArray) -> None:
    success = float(np.degrees(next(iter(histories.values())).scenario.success.angle))
    ends = []
    for number, history in enumerate(histories.values()):
        offset, look = offsets(history, axis), stroke(number)
        panel.plot(*offset.T, linewidth=1.3, **look.of_line)
        panel.plot(*offset[-1], marker=look.marker, color=look.color, markersize=5.5, linestyle="none")
        ends.append(float(np.linalg.norm(offset[-len(offset) // 3 :], axis=1).max()))
    circle = np.linspace(0.0, 2.0 * np.pi, 181)
    panel.plot(success * np.cos(circle), success * np.sin(circle), color=INK, linestyle=":", linewidth=1.2)
    panel.plot(0.0, 0.0, marker="x", color=INK, markersize=9.0, markeredgewidth=2.0)
    # The best half of the policies shall be seen: one that is lost would shrink them to a dot.
    size = min(max(4.0 * success, 1.3 * float(np.median(ends))), 180.0)
    panel.set(xlim=(-size, size), ylim=(-size, size), aspect="equal")
    title = f"around the target; dotted: success cone, {success:.3g} deg"
    dress(panel, title=title, xlabel="off the target [deg]", ylabel="off the target, across [deg]")


def _camera(paths: Sequence[FloatArray], target: FloatArray) -> FloatArray:
    """Return the direction from which most of some paths (T, 3) and their target (3,) are seen."""
    # Every stretch counts by its length, not by the time that is spent there.
    steps = np.concatenate([np.diff(path, axis=0) for path in paths])
    lengths = np.linalg.norm(steps, axis=1)
    points = np.concatenate([path[:-1] for path in paths]) + 0.5 * steps
    middle = lengths @ points / max(float(lengths.sum()), 1e-12) + 0.3 * target
    length = float(np.linalg.norm(middle))
    camera: FloatArray = middle / length if length > 1e-3 else target
    return camera


def _on_sphere(panel: Any, path: FloatArray, camera: FloatArray, **look: Any) -> None:
    near = path @ camera >= 0.0
    panel.plot(*path.T, **look, alpha=FAR)
    if near.any():
        panel.plot(*np.where(near[:, None], path, np.nan).T, **look)


def _globe(panel: Any, camera: FloatArray) -> None:
    """Draw the sphere as seen from a direction: its rim, and every thirtieth circle of latitude and longitude."""
    panel.set_proj_type("ortho")
    azimuth, elevation = np.degrees([np.arctan2(camera[1], camera[0]), np.arcsin(np.clip(camera[2], -1.0, 1.0))])
    panel.view_init(elev=elevation, azim=azimuth)
    for line in graticule(121):
        near = line @ camera >= 0.0
        if near.any():
            panel.plot(*np.where(near[:, None], line, np.nan).T, color="0.82", linewidth=0.7, zorder=0.5)
    rim, side = circle(camera, 121), across(camera)
    panel.plot(*rim.T, color=FAINT, linewidth=1.2, zorder=0.6)
    for axis, label in zip(np.eye(3), "xyz", strict=True):
        facing = float(axis @ camera)
        if facing < -0.5:
            continue  # Its end is behind the sphere.
        strength = 1.0 if facing >= 0.0 else FAR
        panel.plot(*np.outer(axis, [1.0, 1.18]), color=MUTED, linewidth=1.2, alpha=strength)
        # Seen from its end, an axis is a dot: its name stands beside it.
        place = 1.28 * axis + (0.15 * side if facing > 0.97 else 0.0)
        panel.text(*place, label, color=INK, fontsize=9.0, ha="center", va="center", alpha=max(strength, 0.5))
    panel.set(xlim=(-1, 1), ylim=(-1, 1), zlim=(-1, 1))
    panel.set_box_aspect((1.0, 1.0, 1.0), zoom=1.3)
    # The box of axes would hide the sphere; the ends of the axes are drawn instead.
    panel.set_axis_off()
