"""Tests of `ftac_gym.spacecraft.appendages`: rules, matrices, the modes of a free body, and JSON."""

import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import eigh

from ftac_gym import scenarios
from ftac_gym.spacecraft import FlexibleAppendages, Spacecraft, WheelArray, three_orthogonal
from ftac_gym.task import AppendageUncertainty, InitialState, Scenario

INERTIA = np.array([[10.0, 1.2, 0.5], [1.2, 19.0, 1.5], [0.5, 1.5, 25.0]])  # kg m^2
WHEELS = WheelArray(three_orthogonal(), torque_limit=1.0)
TWO = {"frequencies": (1.0, 2.0), "damping_ratios": (0.01, 0.02), "coupling": ((1.0, 0.0, 0.5), (0.0, -1.0, 0.0))}
PROPERTY = settings(max_examples=100, deadline=None, derandomize=True)


@st.composite
def appendages_and_inertia(draw):
    """Modes of a body of which they hold up to 98 % in one direction."""
    modes = draw(st.integers(1, 8))
    rng = np.random.default_rng(draw(st.integers(0, 100_000)))
    body = rng.normal(size=(3, 3))
    inertia = body @ body.T * 10.0 ** draw(st.floats(-2.0, 4.0)) + 1e-3 * np.eye(3)
    coupling = rng.normal(size=(modes, 3)) * (rng.random((modes, 1)) < 0.8)
    root = np.linalg.inv(np.linalg.cholesky(inertia))
    most = max(np.linalg.eigvalsh(root @ coupling.T @ coupling @ root.T)[-1], 1e-12)
    coupling = coupling * np.sqrt(draw(st.floats(0.0, 0.98)) / most)
    frequencies = 10.0 ** rng.uniform(-1.0, 2.0, modes)
    return FlexibleAppendages(tuple(frequencies), 0.01, coupling), inertia


# -------------------------------------------------------------------------------------------------------------- rules


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"frequencies": ()}, r"frequencies must have one number per mode, got \(\)"),
        ({"frequencies": 1.0}, "frequencies must have one number per mode, got 1.0"),
        ({"frequencies": ((1.0, 2.0),)}, "frequencies must have one number per mode"),
        ({"frequencies": (1.0, 0.0)}, r"frequencies\[1\] must be positive, got 0.0"),
        ({"frequencies": (-1.0, 2.0)}, r"frequencies\[0\] must be positive, got -1.0"),
        ({"frequencies": (1.0, float("nan"))}, "frequencies must be finite"),
        ({"frequencies": (1.0, float("inf"))}, "frequencies must be finite"),
        ({"frequencies": ("a", "b")}, "frequencies must have 2 numbers"),
        ({"frequencies": None}, "frequencies must have one number per mode, got None"),
        ({"damping_ratios": (0.01, -0.02)}, r"damping_ratios\[1\] must not be negative, got -0.02"),
        ({"damping_ratios": -1e-9}, r"damping_ratios\[0\] must not be negative"),
        ({"damping_ratios": (0.01,)}, "damping_ratios must have 2 numbers"),
        ({"damping_ratios": (0.01, 0.01, 0.01)}, "damping_ratios must have 2 numbers"),
        ({"damping_ratios": float("nan")}, "damping_ratios must be finite"),
        ({"damping_ratios": None}, "damping_ratios must have 2 numbers, got None"),
        ({"coupling": np.ones((3, 2))}, "coupling must be 2 x 3"),
        ({"coupling": np.ones((3, 3))}, "coupling must be 2 x 3"),
        ({"coupling": (1.0, 2.0, 3.0)}, "coupling must be 2 x 3"),
        ({"coupling": ((1.0, 2.0, 3.0), (1.0, 2.0))}, "coupling must be 2 x 3"),
        ({"coupling": np.full((2, 3), np.inf)}, "coupling must be finite"),
    ],
)
def test_rules(changes, message):
    with pytest.raises(ValueError, match=message):
        FlexibleAppendages(**{**TWO, **changes})


@pytest.mark.parametrize(
    ("scale", "fits"), [(0.0, True), (1.0, True), (3.16, True), (3.163, False), (10.0, False)]
)  # sqrt(10) = 3.1623
def test_the_modes_must_leave_a_body(scale, fits):
    appendages = FlexibleAppendages((1.0,), 0.01, ((scale, 0.0, 0.0),))
    inertia = np.diag([10.0, 19.0, 25.0])
    if fits:
        spacecraft = Spacecraft(inertia, WHEELS, appendages=appendages)
        np.testing.assert_allclose(spacecraft.quick_inertia, np.diag([10.0 - scale**2, 19.0, 25.0]), atol=1e-12)
        appendages.free_frequencies(inertia)
        return
    message = r"coupling must leave J - delta' delta positive definite; its smallest eigenvalue \[kg m\^2\], got -"
    with pytest.raises(ValueError, match=message):
        Spacecraft(inertia, WHEELS, appendages=appendages)
    with pytest.raises(ValueError, match=message):
        appendages.free_frequencies(inertia)


def test_modes_that_only_together_take_too_much_are_refused():
    each = ((2.5, 0.0, 0.0),)
    FlexibleAppendages((1.0,), 0.0, each).check(np.diag([10.0, 19.0, 25.0]))
    with pytest.raises(ValueError, match="coupling must leave"):
        FlexibleAppendages((1.0, 2.0), 0.0, each * 2).check(np.diag([10.0, 19.0, 25.0]))


def test_a_spacecraft_takes_appendages_or_none():
    with pytest.raises(ValueError, match="appendages must be FlexibleAppendages or None"):
        Spacecraft(INERTIA, WHEELS, appendages=TWO)
    rigid = Spacecraft(INERTIA, WHEELS)
    assert rigid.modes == 0 and rigid.appendages is None
    np.testing.assert_array_equal(rigid.quick_inertia, INERTIA)
    assert Spacecraft(INERTIA, WHEELS, appendages=FlexibleAppendages(**TWO)).modes == 2


def test_uncertainty_needs_appendages():
    with pytest.raises(ValueError, match="appendage_uncertainty needs a spacecraft with appendages"):
        scenarios.get("flagship").replace(appendage_uncertainty=AppendageUncertainty())


@pytest.mark.parametrize("shape", [(3, 3), (4, 3), (3, 5)])
def test_misalignment_has_one_column_per_wheel(shape):
    with pytest.raises(ValueError, match="misalignment must be 3 x 4"):
        scenarios.get("flagship").replace(misalignment=np.zeros(shape))


@pytest.mark.parametrize("name", ["modal_displacement", "modal_rate"])
def test_starts_have_one_entry_per_mode(name):
    flexible, start = scenarios.get("flexible"), scenarios.get("flexible").initial_state
    for count in (1, 3, 5):
        with pytest.raises(ValueError, match=f"{name} must have 4 entries, one per mode, got {count}"):
            flexible.replace(initial_state=replace(start, **{name: (0.1,) * count})).draw(0, 1)
    with pytest.raises(ValueError, match=f"{name} must have one entry per mode"):
        InitialState(**{name: 0.1})
    with pytest.raises(ValueError, match=rf"{name}\[1\] must have low <= high"):
        InitialState(**{name: (0.1, (0.2, 0.1))})
    with pytest.raises(ValueError, match=f"{name} must have 0 entries"):
        scenarios.get("flagship").replace(initial_state=InitialState(**{name: (0.1,)})).draw(0, 1)


def test_starts_of_the_modes_are_drawn_within_their_intervals_and_change_nothing_else():
    flexible = scenarios.get("flexible")
    start = replace(flexible.initial_state, modal_displacement=(0.2, (-0.1, 0.3), 0.0, (0.5, 0.5)))
    start = replace(start, modal_rate=((-1.0, 1.0),) * 4)
    still = flexible.draw(3, 400).initial
    moving = flexible.replace(initial_state=start).draw(3, 400).initial
    assert not still["modal_displacement"].any() and not still["modal_rate"].any()
    for name in ("attitude", "rate", "wheel_momentum"):
        np.testing.assert_array_equal(moving[name], still[name])
        np.testing.assert_array_equal(moving[name], scenarios.get("flagship").draw(3, 400).initial[name])
    eta, swing = moving["modal_displacement"], moving["modal_rate"]
    np.testing.assert_array_equal(eta[:, [0, 2, 3]], np.tile([0.2, 0.0, 0.5], (400, 1)))
    assert -0.1 <= eta[:, 1].min() < -0.09 and 0.29 < eta[:, 1].max() <= 0.3
    assert np.abs(np.corrcoef(np.column_stack([eta[:, 1], swing]).T) - np.eye(5)).max() < 0.2
    assert np.abs(swing).max() <= 1.0 and np.all(swing.std(axis=0) > 0.5)


# ----------------------------------------------------------------------------------------------------------- matrices


def test_matrices():
    modes = FlexibleAppendages(**TWO)
    assert modes.count == 2
    np.testing.assert_allclose(modes.stiffness, [1.0, 4.0], rtol=1e-15)
    np.testing.assert_allclose(modes.damping, [0.02, 0.08], rtol=1e-15)
    np.testing.assert_array_equal(modes.coupling_matrix, TWO["coupling"])
    expected = np.outer(TWO["coupling"][0], TWO["coupling"][0]) + np.outer(TWO["coupling"][1], TWO["coupling"][1])
    np.testing.assert_allclose(modes.carried_inertia, expected, atol=1e-15)


@pytest.mark.parametrize("ratio", [0, 0.0, 0.03, np.float64(0.03), 1])
def test_one_damping_ratio_stands_for_all_modes(ratio):
    modes = FlexibleAppendages(**{**TWO, "damping_ratios": ratio})
    assert modes.damping_ratios == (float(ratio),) * 2
    assert modes == FlexibleAppendages(**{**TWO, "damping_ratios": (ratio, ratio)})
    assert hash(modes) == hash(FlexibleAppendages(**{**TWO, "damping_ratios": [ratio, ratio]}))


def test_arrays_lists_and_tuples_are_the_same():
    as_arrays = FlexibleAppendages(*(np.array(value) for value in TWO.values()))
    assert as_arrays == FlexibleAppendages(**TWO) and as_arrays.frequencies == (1.0, 2.0)
    assert all(type(value) is float for row in as_arrays.coupling for value in row)


# ---------------------------------------------------------------------------------------------- modes of a free body


@PROPERTY
@given(appendages_and_inertia())
def test_free_frequencies_are_those_of_the_whole_eigenproblem(case):
    """[[J, delta'], [delta, I]] x'' + diag(0, K) x = 0 has three frequencies of zero and these."""
    appendages, inertia = case
    delta, count = np.array(appendages.coupling), appendages.count
    # In units in which the inertia is one, so that both methods are as exact as they can be.
    root = np.linalg.inv(np.linalg.cholesky(inertia))
    mass = np.block([[np.eye(3), root @ delta.T], [delta @ root.T, np.eye(count)]])
    stiffness = np.diag([0.0, 0.0, 0.0, *np.array(appendages.frequencies) ** 2])
    squares = eigh(stiffness, mass, eigvals_only=True)
    free, most = appendages.free_frequencies(inertia), max(appendages.frequencies)
    np.testing.assert_allclose(squares[:3], 0.0, atol=1e-10 * most**2)
    np.testing.assert_allclose(free**2, squares[3:], rtol=1e-9, atol=1e-10 * most**2)
    assert free.shape == (count,) and np.all(np.diff(free) >= 0.0)
    # Each is above the clamped one of the same rank (Rayleigh); strictly so if something is coupled.
    assert np.all(free >= np.sort(appendages.frequencies) * (1.0 - 1e-7))


def test_one_free_mode_by_hand():
    """(1 - delta J^-1 delta') W^2 = f^2."""
    modes = FlexibleAppendages((2.0,), 0.3, ((0.0, 3.0, 0.0),))
    free = modes.free_frequencies(np.diag([10.0, 19.0, 25.0]))
    assert free[0] == pytest.approx(2.0 / np.sqrt(1.0 - 9.0 / 19.0), rel=1e-14)


def test_free_frequencies_of_li_2023_are_above_the_clamped_ones():
    spacecraft = scenarios.get("li_2023").spacecraft
    free = spacecraft.appendages.free_frequencies(spacecraft.inertia_matrix)
    assert np.all(free > np.sort(spacecraft.appendages.frequencies))
    np.testing.assert_allclose(free, [1.66103, 2.23730, 3.78182, 3.84364], atol=1e-5)


def test_modes_that_are_not_coupled_keep_their_frequencies():
    modes = FlexibleAppendages((3.0, 1.0, 2.0), 0.01, np.zeros((3, 3)))
    np.testing.assert_allclose(modes.free_frequencies(INERTIA), [1.0, 2.0, 3.0], rtol=1e-14)


# --------------------------------------------------------------------------------------------------------------- JSON


def flexible_in_every_way():
    flexible = scenarios.get("flexible")
    return flexible.replace(
        initial_state=replace(
            flexible.initial_state, modal_displacement=(0.1, (-0.2, 0.2), 0.0, 1e-3), modal_rate=((0.0, 0.1),) * 4
        ),
        misalignment=0.01 * np.arange(12.0).reshape(3, 4),
    )


@pytest.mark.parametrize(
    "scenario",
    [flexible_in_every_way(), *map(scenarios.get, ("flexible", "li_2023", "li_2023_weak", "li_2023_printed_start"))],
    ids=lambda scenario: scenario.name,
)
def test_json_round_trip(scenario):
    again = Scenario.from_json(scenario.to_json())
    assert again == scenario and hash(again.spacecraft) == hash(scenario.spacecraft)
    assert again.to_json() == scenario.to_json()
    assert again.spacecraft.appendages == scenario.spacecraft.appendages
    assert again.draw(4, 5).digest() == scenario.draw(4, 5).digest()
    data = json.loads(scenario.to_json())
    assert data["spacecraft"]["appendages"]["type"] == "FlexibleAppendages"
    assert len(data["spacecraft"]["appendages"]["damping_ratios"]) == 4


@pytest.mark.parametrize("name", scenarios.names())
def test_the_json_of_a_rigid_spacecraft_says_nothing_of_modes(name):
    scenario = scenarios.get(name)
    words = ("ppendage", "vibration", "modal", "Flexible")
    if scenario.spacecraft.appendages is None:
        assert not any(word in scenario.to_json() for word in words)
        assert "misalignment" not in scenario.to_dict()  # Gyros have one of their own.
    else:
        assert all(word in scenario.to_json() for word in ("appendages", "FlexibleAppendages"))


def test_episodes_of_a_flexible_spacecraft_survive_a_file(tmp_path):
    episodes = flexible_in_every_way().draw(2, 6)
    episodes.save(tmp_path / "episodes.npz")
    again = type(episodes).load(tmp_path / "episodes.npz")
    assert again.digest() == episodes.digest()
    np.testing.assert_array_equal(again.modes, episodes.modes)
    np.testing.assert_array_equal(again[2:4].modes, episodes.modes[2:4])
    np.testing.assert_array_equal(again.initial["modal_rate"], episodes.initial["modal_rate"])
