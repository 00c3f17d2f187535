"""The available torque of a wheel array, an exact zonotope."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.optimize import lsq_linear

from ftac_gym.attitude import cross
from ftac_gym.evaluation.metrics import Rollout
from ftac_gym.evaluation.truth import true_effect
from ftac_gym.faults.description import acting_faults
from ftac_gym.spacecraft.envelope import Envelope, Load, envelope_normals
from ftac_gym.spacecraft.wheel_array import WheelArray
from ftac_gym.utils.directions import across
from ftac_gym.utils.parameters import FloatArray, require, vector

_PARALLEL = 1e-9


@dataclass(frozen=True, eq=False)
class TorquePolytope:
    """All torques that wheels can put on the body: sum_j [b_j - e_j L_j, b_j + e_j L_j] D[:, j].

    Attributes
    ----------
    vertices
        (V, 3) its corners [N m], body axes.
    faces
        Corners (K, 3) of each face, in order around it [N m]. A flat polytope has a single face, which may be a segment
        or a point.
    guaranteed
        Torque that it has in every direction [N m]: the radius of the largest ball about zero in it. It is zero for a
        flat polytope and for one without zero.
    worst_direction
        (3,) unit vector along which it has no more than that.
    holds_zero
        True if the wheels can leave the body without torque.
    """

    vertices: FloatArray
    faces: tuple[FloatArray, ...]
    guaranteed: float
    worst_direction: FloatArray
    holds_zero: bool


def torque_polytope(
    wheels: WheelArray,
    effectiveness: Sequence[float] | FloatArray | None = None,
    bias: Sequence[float] | FloatArray | None = None,
) -> TorquePolytope:
    """Return the available torques of a wheel array.

    Lag, friction, dead-bands, momentum and power are left out.

    Parameters
    ----------
    wheels
        The wheels, with a torque limit L each.
    effectiveness
        (m,) share e of its command that each gives, in [0, 1]; None for healthy wheels. A wheel that is out, stuck or
        hard-over has none.
    bias
        (m,) torque b of each without a command [N m]; None for none. It includes the torque of wheels that are
        hard-over or stuck.

    Raises
    ------
    ValueError
        If an effectiveness lies outside [0, 1], a number is missing, or a working wheel has no torque limit.
    """
    count, axes = wheels.count, wheels.axis_matrix
    shares = np.ones(count) if effectiveness is None else np.array(vector(list(effectiveness), count, "effectiveness"))
    offsets = np.zeros(count) if bias is None else np.array(vector(list(bias), count, "bias"))
    inside = bool(((shares >= 0.0) & (shares <= 1.0)).all())
    require(inside, "effectiveness", "must lie in [0, 1]", shares.tolist())
    limits = wheels.torque_limits
    limited = bool(np.isfinite(limits[shares > 0.0]).all())
    require(limited, "torque_limit", "must be given for every working wheel", limits.tolist())
    reach = np.where(shares > 0.0, shares * np.where(np.isfinite(limits), limits, 0.0), 0.0)
    centre = axes @ offsets
    faces = zonotope_faces(centre, axes.T * reach[:, None])
    free, _ = Envelope(axes).room(Load(centre[None]), reach[None])
    normals = envelope_normals(axes)
    spans = int(np.linalg.matrix_rank(axes[:, reach > 0.0])) == 3 if (reach > 0.0).any() else False
    worst = normals[int(np.argmin(free[0]))] if len(normals) else across(axes[:, 0])
    # Towards the side that the uncommanded torque leaves.
    worst = -worst if worst @ centre > 0.0 else worst
    points = np.concatenate(faces)
    # Corners that differ by more than rounding, in the order of their coordinates.
    scale = max(float(np.abs(points).max()), 1e-300)
    _, distinct = np.unique(np.round(points / scale, 9) + 0.0, axis=0, return_index=True)
    return TorquePolytope(
        vertices=points[distinct],
        faces=faces,
        guaranteed=max(float(free[0].min()), 0.0) if spans else 0.0,
        worst_direction=worst,
        holds_zero=_holds_zero(centre, axes * reach),
    )


def polytopes_along(history: Rollout, times: Sequence[float]) -> dict[str, TorquePolytope]:
    """Return the available torques of the wheels of a rollout's first spacecraft at some times.

    Parameters
    ----------
    history
        The rollout.
    times
        [s], within it; the nearest recorded ones count.

    Returns
    -------
    Polytopes, by the time and the acting faults of the wheels.

    Raises
    ------
    ValueError
        If a time lies outside the rollout, or a working wheel has no torque limit.
    """
    effect, wheels = true_effect(history), history.scenario.spacecraft.wheels
    found = {}
    for time in times:
        rule = f"must lie within the rollout, [0, {history.time[-1]:g}] s"
        require(0.0 <= time <= history.time[-1] + 1e-9, "times", rule, time)
        step = int(np.argmin(np.abs(history.time - time)))
        drawn = history.episodes.drawn_faults.take(np.zeros(1, dtype=np.int64))
        words = acting_faults(drawn, history.time[step : step + 1])[0].descriptions
        shown = [word.rpartition(" at ")[0] for word in words if word.startswith("wheel ")]
        label = f"{history.time[step]:g} s: {', '.join(shown) or 'healthy'}"
        found[label] = torque_polytope(wheels, np.clip(effect.effectiveness[step], 0.0, 1.0), effect.bias[step])
    return found


def zonotope_faces(centre: FloatArray, generators: FloatArray) -> tuple[FloatArray, ...]:
    """Return the faces of the zonotope centre + sum_j [-1, 1] g_j.

    Every face stands across the normal of two generators. The generators in its plane span a polygon, and all others
    are at the end that lies farther along the normal.

    Parameters
    ----------
    centre
        (3,).
    generators
        (m, 3).

    Returns
    -------
    Corners (K, 3) of each face, in order around it; a single polygon, segment or point if the generators are flat.
    """
    spanning = _merged(generators)
    if len(spanning) < 2:
        ends = spanning.sum(axis=0)
        return (np.array([centre - ends, centre + ends]) if len(spanning) else centre[None].copy(),)
    units = spanning / np.linalg.norm(spanning, axis=1)[:, None]
    normals = _merged(envelope_normals(units.T), unit=True)
    faces = []
    for normal in normals:
        heights = units @ normal
        flat = np.abs(heights) < _PARALLEL
        polygon = _polygon(spanning[flat], normal)
        if flat.all():
            return (centre + polygon,)
        shift = (np.sign(heights[~flat])[:, None] * spanning[~flat]).sum(axis=0)
        faces += [centre + shift + polygon, centre - shift + polygon]
    return tuple(faces)


def _merged(vectors: FloatArray, unit: bool = False) -> FloatArray:
    """Return vectors (K, 3) of which no two are parallel: parallel ones are added up, or the first kept if units."""
    found: list[npt.NDArray[np.float64]] = []
    for item in vectors:
        length = float(np.linalg.norm(item))
        if length < 1e-15:
            continue
        for index, other in enumerate(found):
            if np.linalg.norm(cross(item, other)) < _PARALLEL * length * np.linalg.norm(other):
                if not unit:
                    found[index] = other + np.copysign(1.0, item @ other) * item
                break
        else:
            found.append(np.array(item))
    return np.array(found).reshape(-1, 3)


def _polygon(generators: FloatArray, normal: FloatArray) -> FloatArray:
    """Return the corners (2 K, 3) of the flat zonotope of K generators across a normal, in order around it."""
    first = generators[0] / np.linalg.norm(generators[0])
    second = cross(normal, first)
    x, y = generators @ first, generators @ second
    upward = np.where((y > 0.0) | ((np.abs(y) <= _PARALLEL * np.abs(x)) & (x > 0.0)), 1.0, -1.0)
    turned = generators * upward[:, None]
    turned = turned[np.argsort(np.arctan2(np.maximum(upward * y, 0.0), upward * x))]
    edges = 2.0 * np.concatenate([turned, -turned])
    corners: FloatArray = -turned.sum(axis=0) + np.concatenate([np.zeros((1, 3)), np.cumsum(edges, axis=0)[:-1]])
    return corners


def _holds_zero(centre: FloatArray, generators: FloatArray) -> bool:
    """Return True if some x in [-1, 1]^m has centre + generators (3, m) x = 0."""
    if not generators.any():
        return not np.any(np.abs(centre) > 1e-12)
    scale = float(np.linalg.norm(generators, axis=0).max())
    found = lsq_linear(generators / scale, -centre / scale, (-1.0, 1.0), method="bvls")
    return bool(np.sqrt(2.0 * found.cost) < 1e-7)
