"""The torque envelope: exact corners and faces, guaranteed torque, and drawing."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog
from scipy.spatial import ConvexHull

from ftac_gym import scenarios
from ftac_gym.evaluation import rollout
from ftac_gym.faults import FaultSchedule, HardOver, LockInPlace, Outage
from ftac_gym.plots import polytopes_along, torque_polytope, wheel_envelope
from ftac_gym.spacecraft.envelope import Envelope, Load
from ftac_gym.spacecraft.layouts import pyramid
from ftac_gym.spacecraft.wheel_array import WheelArray

PYRAMID = WheelArray.sign_pyramid(0.2, 12.0)


@st.composite
def arrays(draw):
    """Wheels in general and in special directions, some of them weak, dead or with a bias."""
    count = draw(st.integers(3, 8))
    special = st.sampled_from([(1, 0, 0), (0, 1, 0), (0, 0, 1), (0, 0, -1), (1, 1, 0), (1, 1, 1), (1, -1, 1)])
    # On a grid: axes a billionth apart span polytopes so thin that the references are lost in rounding.
    anywhere = st.tuples(*[st.integers(-9, 9)] * 3).filter(any)
    rows = np.array([draw(st.one_of(special, anywhere)) for _ in range(count)], dtype=float)
    axes = (rows / np.linalg.norm(rows, axis=1)[:, None]).T
    wheels = WheelArray(tuple(map(tuple, axes)), tuple(draw(st.floats(0.1, 3.0)) for _ in range(count)))
    shares = np.array([draw(st.sampled_from([0.0, 0.3, 1.0, 1.0])) for _ in range(count)])
    biases = np.array([draw(st.sampled_from([0.0, 0.0, 0.05, -0.4])) for _ in range(count)])
    return wheels, shares, biases


def corners_of(wheels, shares, biases):
    """All torques at which every wheel is at an end of its range, (2^m, 3)."""
    signs = np.array(list(product((-1.0, 1.0), repeat=wheels.count)))
    return (biases + signs * shares * wheels.torque_limits) @ wheels.axis_matrix.T


def farthest(wheels, shares, biases, direction):
    """The largest torque along a direction, by linear programming."""
    reach = shares * wheels.torque_limits
    bounds = list(zip(biases - reach, biases + reach, strict=True))
    return -linprog(-wheels.axis_matrix.T @ direction, bounds=bounds).fun


@settings(max_examples=60, deadline=None)
@given(arrays(), st.integers(0, 10_000))
def test_vertices_span_all_that_the_wheels_can_give(array, seed):
    found = torque_polytope(*array)
    brute = corners_of(*array)
    scale = np.abs(brute).max() + 1e-12
    # Every vertex is a corner, and in every direction the farthest vertex is as far as the wheels can go.
    gaps = np.linalg.norm(found.vertices[:, None] - brute[None], axis=2).min(axis=1)
    assert gaps.max() < 1e-8 * scale
    directions = np.random.default_rng(seed).normal(size=(200, 3))
    np.testing.assert_allclose(
        (found.vertices @ directions.T).max(axis=0), (brute @ directions.T).max(axis=0), atol=1e-8 * scale
    )


@settings(max_examples=40, deadline=None)
@given(arrays())
def test_faces_are_flat_convex_and_close_the_polytope(array):
    wheels, shares, biases = array
    found = torque_polytope(wheels, shares, biases)
    spanned = np.linalg.matrix_rank(wheels.axis_matrix * shares, tol=1e-6)
    if spanned < 3:
        assert len(found.faces) == 1
        return
    if np.linalg.svd(wheels.axis_matrix * shares)[1][-1] < 1e-3:
        return  # Too thin for the rounding of the reference.
    centre = wheels.axis_matrix @ biases
    volume = 0.0
    for face in found.faces:
        middle = face.mean(axis=0)
        fan = np.cross(face - middle, np.roll(face, -1, axis=0) - middle)
        # All triangles of a fan about the middle have one orientation: the corners go round once.
        normal = fan.sum(axis=0)
        assert np.all(fan @ normal > 0.0)
        volume += abs((middle - centre) @ normal) / 6.0
        assert np.all((found.vertices - middle) @ normal * np.sign((middle - centre) @ normal) < 1e-7)
    assert volume == pytest.approx(ConvexHull(corners_of(*array)).volume, rel=1e-6)


@settings(max_examples=40, deadline=None)
@given(arrays(), st.integers(0, 10_000))
def test_the_guaranteed_torque_is_that_of_the_worst_direction(array, seed):
    found = torque_polytope(*array)
    assert np.linalg.norm(found.worst_direction) == pytest.approx(1.0)
    assert farthest(*array, found.worst_direction) <= found.guaranteed + 1e-9
    if found.guaranteed > 0.0:
        directions = np.random.default_rng(seed).normal(size=(10, 3))
        directions /= np.linalg.norm(directions, axis=1)[:, None]
        assert all(farthest(*array, direction) >= found.guaranteed - 1e-9 for direction in directions)
        assert farthest(*array, found.worst_direction) == pytest.approx(found.guaranteed, abs=1e-9)
        assert found.holds_zero


@settings(max_examples=30, deadline=None)
@given(arrays())
def test_zero_is_held_exactly_if_a_linear_program_says_so(array):
    wheels, shares, biases = array
    reach = shares * wheels.torque_limits
    bounds = list(zip(biases - reach, biases + reach, strict=True))
    program = linprog(np.zeros(wheels.count), A_eq=wheels.axis_matrix, b_eq=np.zeros(3), bounds=bounds)
    assert torque_polytope(wheels, shares, biases).holds_zero == (program.status == 0)


@pytest.mark.parametrize("shares", [(1.0, 1.0, 1.0, 1.0), (1.0, 0.3, 1.0, 1.0), (0.0, 1.0, 1.0, 1.0)])
def test_the_guarantee_is_that_of_the_envelope(shares):
    found = torque_polytope(PYRAMID, shares)
    reach = np.array(shares)[None] * PYRAMID.torque_limits
    free, support = Envelope(PYRAMID.axis_matrix).room(Load(np.zeros((1, 3))), reach)
    assert found.guaranteed == pytest.approx(support.min()) == pytest.approx(free.min())
    points = np.array([[0.999], [1.001]]) * found.guaranteed * found.worst_direction
    inside = Envelope(PYRAMID.axis_matrix).contains(Load(points), reach.repeat(2, 0))
    assert inside.tolist() == [True, False]


@pytest.mark.parametrize("count", [3, 4, 5, 8])
def test_healthy_wheels_give_as_much_one_way_as_the_other(count):
    wheels = WheelArray(pyramid(0.6, count), 0.2)
    vertices = torque_polytope(wheels).vertices
    mirrored = np.linalg.norm(vertices[:, None] + vertices[None], axis=2).min(axis=1)
    assert mirrored.max() < 1e-12
    assert len(vertices) == count * (count - 1) + 2  # The corners of a zonotope in general position.


def test_known_envelopes():
    cube = torque_polytope(WheelArray(np.eye(3).tolist(), 2.0))
    assert len(cube.faces) == 6 and all(len(face) == 4 for face in cube.faces)
    assert sorted(map(tuple, cube.vertices)) == sorted(product((-2.0, 2.0), repeat=3))
    assert cube.guaranteed == 2.0
    dodecahedron = torque_polytope(PYRAMID)
    assert len(dodecahedron.faces) == 12 and len(dodecahedron.vertices) == 14
    # A wheel at its limit moves the envelope as far as it shrinks it: zero is a corner.
    stuck = torque_polytope(PYRAMID, (1.0, 1.0, 0.0, 1.0), (0.0, 0.0, 0.2, 0.0))
    assert stuck.guaranteed == 0.0 and stuck.holds_zero
    flat = torque_polytope(PYRAMID, (1.0, 0.0, 0.0, 1.0))
    assert len(flat.faces) == 1 and len(flat.vertices) == 4 and flat.guaranteed == 0.0 and flat.holds_zero
    pushed = torque_polytope(PYRAMID, (1.0, 0.0, 0.0, 1.0), (0.0, 0.0, 0.1, 0.0))
    assert pushed.guaranteed == 0.0 and not pushed.holds_zero
    single = torque_polytope(PYRAMID, (1.0, 0.0, 0.0, 0.0))
    assert len(single.vertices) == 2
    nothing = torque_polytope(PYRAMID, np.zeros(4))
    assert nothing.vertices.tolist() == [[0.0, 0.0, 0.0]] and nothing.guaranteed == 0.0 and nothing.holds_zero


def test_polytopes_along_a_flight():
    faults = FaultSchedule(
        (Outage(wheel=0, onset=1.0), HardOver(wheel=2, onset=2.0, fraction=0.5, random_sign=False),
         LockInPlace(wheel=3, onset=3.0))
    )  # fmt: skip
    history = rollout(scenarios.get("flagship").replace(duration=5.0, faults=faults), "pd", seed=1)
    found = polytopes_along(history, (0.0, 1.5, 2.5, 5.0))
    assert list(found) == [
        "0 s: healthy",
        "1.5 s: wheel 0: outage",
        "2.5 s: wheel 0: outage, wheel 2: hard over",
        "5 s: wheel 0: outage, wheel 2: hard over, wheel 3: lock in place",
    ]
    healthy, dead, hard, locked = found.values()
    wheels = history.scenario.spacecraft.wheels
    for item, shares, biases in (
        (healthy, np.ones(4), np.zeros(4)),
        (dead, np.array([0.0, 1.0, 1.0, 1.0]), np.zeros(4)),
        (hard, np.array([0.0, 1.0, 0.0, 1.0]), np.array([0.0, 0.0, 0.1, 0.0])),
        (locked, np.array([0.0, 1.0, 0.0, 0.0]), np.array([0.0, 0.0, 0.1, history.applied_torque[-1, 0, 3]])),
    ):
        np.testing.assert_allclose(item.vertices, torque_polytope(wheels, shares, biases).vertices, atol=1e-12)
    for time in (-1.0, 5.2):
        with pytest.raises(ValueError, match=r"times must lie within the rollout, \[0, 5\] s"):
            polytopes_along(history, (time,))


def test_the_figure_shows_every_polytope_with_its_guarantee(tmp_path):
    items = {
        "healthy": torque_polytope(PYRAMID),
        "outage": torque_polytope(PYRAMID, (1.0, 1.0, 0.0, 1.0)),
        "two out": torque_polytope(PYRAMID, (1.0, 0.0, 0.0, 1.0)),
        "three out": torque_polytope(PYRAMID, (1.0, 0.0, 0.0, 0.0)),
        "pushed": torque_polytope(PYRAMID, np.zeros(4), (0.1, 0.0, 0.0, 0.0)),
    }
    figure = wheel_envelope(items)
    assert len(figure.axes) == 5
    for panel, (name, item) in zip(figure.axes, items.items(), strict=True):
        title = panel.get_title()
        assert title.startswith(name)
        assert (f"at least {item.guaranteed:.3g} N m" in title) == (item.guaranteed > 0.0)
        assert [axis.get_label_text() for axis in (panel.xaxis, panel.yaxis, panel.zaxis)] == [
            f"torque {axis} [N m]" for axis in "xyz"
        ]
    assert "no torque in some directions" in figure.axes[2].get_title()
    assert "cannot even give zero torque" in figure.axes[4].get_title()
    frame, solid = figure.axes[1].collections[:2]
    np.testing.assert_allclose(np.array(frame._segments3d)[:, :-1], np.array(items["healthy"].faces))
    np.testing.assert_allclose(np.array(solid._faces), np.array(items["outage"].faces))
    figure.savefig(tmp_path / "envelope.png", dpi=30)


@pytest.mark.parametrize(
    ("wheels", "arguments", "message"),
    [
        (PYRAMID, {"effectiveness": (1.0, 1.0, 1.0)}, "effectiveness must have 4 numbers"),
        (PYRAMID, {"effectiveness": (1.0, 1.2, 1.0, 1.0)}, r"effectiveness must lie in \[0, 1\]"),
        (PYRAMID, {"bias": (0.0, np.nan, 0.0, 0.0)}, "bias must be finite"),
        (replace(PYRAMID, torque_limit=None), {}, "torque_limit must be given for every working wheel"),
    ],
)
def test_refused(wheels, arguments, message):
    with pytest.raises(ValueError, match=message):
        torque_polytope(wheels, **arguments)


def test_nothing_to_draw_is_refused():
    with pytest.raises(ValueError, match="polytopes must hold at least one"):
        wheel_envelope({})
