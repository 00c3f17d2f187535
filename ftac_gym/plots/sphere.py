"""The path of a boresight on the sphere."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ftac_gym.attitude import cross, quaternion_error, rotate_to_reference
from ftac_gym.evaluation.metrics import Rollout
from ftac_gym.plots import style
from ftac_gym.utils.directions import across, circle, graticule
from ftac_gym.utils.parameters import FloatArray, require, vector

FAR = 0.3
"""Opacity of paths on the far side of the sphere."""

_START: dict[str, Any] = {"marker": "o", "color": "white", "mec": style.INK, "ms": 7.0, "ls": "none"}
_GOAL: dict[str, Any] = {"marker": "x", "color": style.INK, "ms": 9.0, "mew": 2.0, "ls": "none"}


def boresight_paths(histories: Mapping[str, Rollout], boresight: Sequence[float] = (0.0, 0.0, 1.0)) -> Figure:
    """Draw the path of a boresight on the sphere of inertial directions and, enlarged, as seen from the target.

    Paths on the far side of the sphere are pale. In the enlargement the target stands still at the origin, even if the
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
    first = style.first_of(histories)
    given = np.array(vector(boresight, 3, "boresight"))
    length = float(np.linalg.norm(given))
    require(length > 1e-12, "boresight", "must not be zero", tuple(boresight))
    axis: FloatArray = given / length
    paths = [directions(history.attitude[:, 0], axis) for history in histories.values()]
    target = directions(first.reference_attitude[:, 0], axis)
    figure = style.figure(10.5, 5.6)
    _draw_globe(figure.add_subplot(1, 2, 1, projection="3d"), paths, target)
    _draw_enlargement(figure.add_subplot(1, 2, 2), histories, axis)
    style.describe_episode(figure, (), first)
    lines = style.entries(histories, linewidth=1.8, markersize=5.5)
    for number, line in enumerate(lines):
        line.set_marker(style.stroke(number).marker)
    style.legend(figure, [*lines, style.entry("start", **_START), style.entry("target at the end", **_GOAL)], columns=5)
    return figure


def directions(attitude: FloatArray, axis: FloatArray) -> FloatArray:
    """Return the directions (T, 3) of a body axis (3,) at attitudes (T, 4): unit vectors in inertial axes."""
    return rotate_to_reference(attitude, np.broadcast_to(axis, (len(attitude), 3)))


def offsets(history: Rollout, axis: FloatArray) -> FloatArray:
    """Return the offset of the first spacecraft's boresight from its target, (T + 1, 2) [deg], in directions across it.

    The length of a row is the angle between the two, so that the far end of the sphere is a circle of 180 deg.
    """
    error = directions(quaternion_error(history.attitude[:, 0], history.reference_attitude[:, 0]), axis)
    second = across(axis)
    projected = np.stack([error @ cross(second, axis), error @ second], axis=1)
    sine = np.linalg.norm(projected, axis=1)
    angle = np.degrees(np.arctan2(sine, error @ axis))
    scaled: FloatArray = projected * (angle / np.maximum(sine, 1e-15))[:, None]
    return scaled


def _draw_enlargement(panel: Axes, histories: Mapping[str, Rollout], axis: FloatArray) -> None:
    success = float(np.degrees(next(iter(histories.values())).scenario.success.angle))
    ends = []
    for number, history in enumerate(histories.values()):
        offset = offsets(history, axis)
        panel.plot(*offset.T, linewidth=1.3, **style.stroke(number).of_line)
        panel.plot(*offset[-1], **_end(number))
        ends.append(float(np.linalg.norm(offset[-len(offset) // 3 :], axis=1).max()))
    turn = np.linspace(0.0, 2.0 * np.pi, 181)
    panel.plot(success * np.cos(turn), success * np.sin(turn), **style.LIMIT)
    panel.plot(0.0, 0.0, **_GOAL)
    # The best half of the policies sets the scale: a lost one would shrink them to a dot.
    size = min(max(4.0 * success, 1.3 * float(np.median(ends))), 180.0)
    panel.set(xlim=(-size, size), ylim=(-size, size), aspect="equal")
    title = f"around the target; dotted: success cone, {success:.3g} deg"
    style.apply(panel, title, "off the target [deg]", "off the target, across [deg]")


def _end(number: int) -> dict[str, Any]:
    """Return the look of the end of a path."""
    look = style.stroke(number)
    return {"marker": look.marker, "color": look.color, "ms": 5.5, "ls": "none"}


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


def _draw_globe(panel: Any, paths: Sequence[FloatArray], target: FloatArray) -> None:
    """Draw paths (T, 3) on the sphere, with its rim and every thirtieth circle of latitude and longitude."""
    camera = _camera(paths, target[-1])
    panel.set_proj_type("ortho")
    azimuth, elevation = np.degrees([np.arctan2(camera[1], camera[0]), np.arcsin(np.clip(camera[2], -1.0, 1.0))])
    panel.view_init(elev=elevation, azim=azimuth)
    for line in graticule(121):
        _plot(panel, line, camera, color="0.82", linewidth=0.7, zorder=0.5)
    panel.plot(*circle(camera, 121).T, color=style.FAINT, linewidth=1.2, zorder=0.6)
    for axis, label in zip(np.eye(3), "xyz", strict=True):
        facing = float(axis @ camera)
        if facing < -0.5:
            continue  # Its end is behind the sphere.
        strength = 1.0 if facing >= 0.0 else FAR
        panel.plot(*np.outer(axis, [1.0, 1.18]), color=style.MUTED, linewidth=1.2, alpha=strength)
        # An axis that points to the camera is a dot: its name stands beside it.
        place = 1.28 * axis + (0.15 * across(camera) if facing > 0.97 else 0.0)
        panel.text(*place, label, color=style.INK, fontsize=9.0, ha="center", va="center", alpha=max(strength, 0.5))
    for number, path in enumerate(paths):
        _plot(panel, path, camera, FAR, linewidth=1.8, **style.stroke(number).of_line)
        panel.plot(*path[-1], **_end(number))
    panel.plot(*paths[0][0], **_START)
    if np.ptp(target, axis=0).max() > 1e-6:
        _plot(panel, target, camera, FAR, **style.LIMIT)
    panel.plot(*target[-1], **_GOAL)
    panel.set(xlim=(-1, 1), ylim=(-1, 1), zlim=(-1, 1))
    panel.set_box_aspect((1.0, 1.0, 1.0), zoom=1.3)
    # The box of axes would hide the sphere; the ends of the axes are drawn instead.
    panel.set_axis_off()
    panel.set_title("unit sphere of inertial directions [-]", fontsize=10.0, color=style.INK)


def _plot(panel: Any, path: FloatArray, camera: FloatArray, far: float = 0.0, **look: Any) -> None:
    """Draw a path (T, 3) on the near side of the sphere, and on the far side with some opacity."""
    near = path @ camera >= 0.0
    if far > 0.0:
        panel.plot(*path.T, alpha=far, **look)
    if near.any():
        panel.plot(*np.where(near[:, None], path, np.nan).T, **look)
