"""Sliding surfaces: odd, growing, continuous, with the slope that finite differences see."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ftac_gym.baselines.components.surfaces import FastTerminalSurface, NonsingularTerminalSurface, signed_power

KINDS = {"fast terminal": FastTerminalSurface, "non-singular": NonsingularTerminalSurface}
GAIN, EXPONENT, BOUND = st.floats(0.0, 3.0), st.floats(0.1, 0.95), st.floats(1e-3, 0.5)
CASES = {"kind": st.sampled_from(sorted(KINDS)), "linear": GAIN, "terminal": GAIN, "exponent": EXPONENT, "bound": BOUND}


def errors(count=60):
    """Errors (count, 3) of both signs and of sizes from 1e-4 to 1."""
    random = np.random.default_rng(0)
    return random.choice([-1.0, 1.0], (count, 3)) * 10.0 ** random.uniform(-4.0, 0.0, (count, 3))


def central(function, x):
    """Derivative by differences of fourth order."""
    step = 1e-3 * np.abs(x)
    near, far = (function(x + k * step) - function(x - k * step) for k in (1.0, 2.0))
    return (8.0 * near - far) / (12.0 * step)


@settings(max_examples=60, deadline=None)
@given(**CASES)
def test_the_slope_is_that_of_the_term(kind, linear, terminal, exponent, bound):
    surface, x = KINDS[kind](linear, terminal, exponent, bound), errors()
    slope = surface(x)[1]
    size = np.abs(x)
    # Differences must not straddle the bound, where the second derivative jumps; within a guard the slope is held.
    compared = (size > 1.01 * bound) | ((size < 0.99 * bound) & (kind == "non-singular"))
    expected = central(lambda value: surface(value)[0], x)
    np.testing.assert_allclose(slope[compared], expected[compared], rtol=1e-7, atol=1e-7)


@settings(max_examples=60, deadline=None)
@given(**CASES)
def test_odd_growing_and_zero_only_at_zero(kind, linear, terminal, exponent, bound):
    surface, x = KINDS[kind](linear, terminal, exponent, bound), errors()
    (term, slope), (opposite, same) = surface(x), surface(-x)
    np.testing.assert_array_equal(term, -opposite)
    np.testing.assert_array_equal(slope, same)
    assert (term * x >= 0.0).all() and (slope >= 0.0).all()
    assert ((term * x > 0.0).all() and (slope > 0.0).all()) or linear + terminal < 1e-9
    at_zero, slope = surface(np.zeros((1, 3)))
    np.testing.assert_array_equal(at_zero, 0.0)
    assert np.isfinite(slope).all()


@settings(max_examples=60, deadline=None)
@given(linear=GAIN, terminal=GAIN, exponent=EXPONENT, bound=BOUND)
def test_value_and_slope_are_continuous_at_the_bound(linear, terminal, exponent, bound):
    surface = NonsingularTerminalSurface(linear, terminal, exponent, bound)
    beside = np.array([[bound * (1.0 - 1e-12), bound, bound * (1.0 + 1e-12)]])
    for side in (beside, -beside):
        term, slope = surface(side)
        np.testing.assert_allclose(term, term[0, 1], rtol=1e-9)
        np.testing.assert_allclose(slope, slope[0, 1], rtol=1e-9)
    np.testing.assert_allclose(abs(term[0, 1]), linear * bound + terminal * bound**exponent, rtol=1e-12, atol=1e-15)
    steepest = surface(np.zeros((1, 3)))[1]
    np.testing.assert_allclose(
        steepest, linear + terminal * (2.0 - exponent) * bound ** (exponent - 1.0), rtol=1e-12, atol=1e-15
    )


@settings(max_examples=40, deadline=None)
@given(linear=GAIN, terminal=GAIN, exponent=EXPONENT, bound=BOUND)
def test_within_the_guard_the_slope_stays_what_it_is_there(linear, terminal, exponent, bound):
    surface = FastTerminalSurface(linear, terminal, exponent, bound)
    x = np.array([[0.0, 0.5 * bound, bound], [-0.1 * bound, -0.9 * bound, -bound]])
    np.testing.assert_allclose(surface(x)[1], linear + terminal * exponent * bound ** (exponent - 1.0), rtol=1e-12)
    np.testing.assert_allclose(surface(x)[0], linear * x + terminal * np.sign(x) * np.abs(x) ** exponent, atol=1e-15)


@settings(max_examples=40, deadline=None)
@given(exponent=EXPONENT, bound=BOUND)
def test_terminal_part_is_the_surface_without_the_rest(exponent, bound):
    surface, size = NonsingularTerminalSurface(0.0, 1.0, exponent, bound), np.abs(errors())
    ratio, slope = surface.terminal_part(size)
    term, expected = surface(size)
    np.testing.assert_allclose(ratio * size, term, rtol=1e-12)
    np.testing.assert_allclose(slope, expected, rtol=1e-12)
    assert np.isfinite(surface.terminal_part(np.zeros(4))[0]).all()


@given(x=st.floats(-10.0, 10.0), exponent=st.floats(0.05, 3.0))
def test_signed_power(x, exponent):
    power = signed_power(np.array([x]), exponent)[0]
    assert np.sign(power) == np.sign(x) or abs(x) ** exponent == 0.0
    assert abs(power) == pytest.approx(abs(x) ** exponent)


@pytest.mark.parametrize(
    ("kind", "changes", "message"),
    [
        ("fast terminal", {"linear": -0.1}, r"linear must not be negative, got -0\.1"),
        ("fast terminal", {"terminal": np.nan}, "terminal must be finite"),
        ("fast terminal", {"exponent": 1.0}, r"exponent must lie within \(0, 1\), got 1\.0"),
        ("fast terminal", {"exponent": 0.0}, r"exponent must lie within \(0, 1\), got 0\.0"),
        ("fast terminal", {"guard": 0.0}, r"guard must be positive, got 0\.0"),
        ("non-singular", {"linear": -0.1}, r"linear must not be negative, got -0\.1"),
        ("non-singular", {"terminal": -1.0}, r"terminal must not be negative, got -1\.0"),
        ("non-singular", {"exponent": np.nan}, "exponent must be finite, got nan"),
        ("non-singular", {"bound": -1e-3}, r"bound must be positive, got -0\.001"),
    ],
)
def test_bad_parameters(kind, changes, message):
    last = "guard" if kind == "fast terminal" else "bound"
    with pytest.raises(ValueError, match=message):
        KINDS[kind](**{"linear": 0.5, "terminal": 0.5, "exponent": 0.7, last: 0.01, **changes})
