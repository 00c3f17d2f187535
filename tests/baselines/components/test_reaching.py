"""Reaching laws: always towards zero, with the limits that the paper promises, and the time that follows."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from ftac_gym.baselines.components.reaching import ExponentialReaching, PowerReaching, switching

VARIABLE = np.concatenate([-np.logspace(1, -6, 15), np.logspace(-6, 1, 15)]).reshape(-1, 3)
GAIN, SHARE = st.floats(1e-3, 10.0), st.floats(0.05, 0.95)


@settings(max_examples=60, deadline=None)
@given(linear=GAIN, gain=GAIN, floor=SHARE, steepness=st.floats(0.0, 20.0), power=st.integers(1, 4),
       layer=st.sampled_from([0.0, 1e-3, 0.3]))  # fmt: skip
def test_exponential_reaching_goes_to_zero_within_its_bounds(linear, gain, floor, steepness, power, layer):
    law = ExponentialReaching(linear, gain, floor, steepness, power, layer)
    rate, opposite = law(VARIABLE), law(-VARIABLE)
    np.testing.assert_array_equal(rate, -opposite)
    assert (rate * VARIABLE < 0.0).all()
    part = np.abs(rate + linear * VARIABLE)
    smooth = 1.0 if layer == 0.0 else np.tanh(np.abs(VARIABLE) / layer)
    assert (part >= gain * smooth * (1.0 - 1e-9) - 1e-12).all()
    assert (part <= gain / floor * smooth * (1.0 + 1e-9) + 1e-12).all()
    np.testing.assert_array_equal(law(np.zeros((2, 3))), 0.0)


@settings(max_examples=30, deadline=None)
@given(gain=GAIN, floor=SHARE, power=st.integers(1, 4))
def test_switching_gain_near_and_far(gain, floor, power):
    """From e2 near the surface to e2 / d0 far from it, and e2 / N in between."""
    law = ExponentialReaching(0.0, gain, floor, 5.0, power)
    near, between, far = law(np.array([[1e-12, 0.4, 1e3]]))[0]
    assert near == pytest.approx(-gain, rel=1e-9)
    assert far == pytest.approx(-gain / floor, rel=1e-9)
    assert between == pytest.approx(-gain / (floor + (1.0 - floor) * np.exp(-5.0 * 0.4**power)), rel=1e-12)


@given(value=st.floats(-5.0, 5.0), layer=st.floats(1e-6, 1.0))
def test_the_layer_smooths_the_sign(value, layer):
    x = np.array([value])
    smooth = switching(x, layer)
    assert abs(smooth[0]) <= 1.0 and smooth[0] * value >= 0.0
    np.testing.assert_array_equal(switching(x, 0.0), np.sign(x))
    if abs(value) > 20.0 * layer:
        np.testing.assert_allclose(smooth, np.sign(x), atol=1e-12)
    if abs(value) < 1e-3 * layer:
        np.testing.assert_allclose(smooth, x / layer, rtol=1e-6, atol=1e-300)


@settings(max_examples=40, deadline=None)
@given(linear=st.floats(0.0, 5.0), gain=GAIN, exponent=SHARE)
def test_power_reaching_goes_to_zero(linear, gain, exponent):
    law = PowerReaching(linear, gain, exponent)
    rate = law(VARIABLE)
    np.testing.assert_array_equal(rate, -law(-VARIABLE))
    expected = -(linear * np.abs(VARIABLE) + gain * np.abs(VARIABLE) ** exponent) * np.sign(VARIABLE)
    np.testing.assert_allclose(rate, expected, rtol=1e-12)
    np.testing.assert_array_equal(law(np.zeros((1, 3))), 0.0)


@pytest.mark.parametrize("start", [0.05, 0.5, 2.0])
def test_power_reaching_takes_the_finite_time_of_lemma_1(start):
    """Eq. (12) of Zhang and Zhou with its parenthesis: t = ln[(k |s|^(1-a) + l) / l] / (k (1 - a))."""
    linear, gain, exponent = 1.0, 0.2, 0.5
    law = PowerReaching(linear, gain, exponent)

    def low(_, s):
        return s[0] - 1e-12

    low.terminal = True
    arguments = {"events": low, "rtol": 1e-10, "atol": 1e-15}
    flown = solve_ivp(lambda _, s: law(s[None, :])[0], (0.0, 20.0), [start], **arguments)
    expected = np.log((linear * start ** (1.0 - exponent) + gain) / gain) / (linear * (1.0 - exponent))
    assert flown.t_events[0][0] == pytest.approx(expected, abs=2e-5)


@pytest.mark.parametrize(
    ("kind", "changes", "message"),
    [
        (ExponentialReaching, {"linear": -1.0}, "linear must not be negative, got -1.0"),
        (ExponentialReaching, {"switching": -1.0}, "switching must not be negative, got -1.0"),
        (ExponentialReaching, {"floor": 1.0}, r"floor must lie within \(0, 1\), got 1.0"),
        (ExponentialReaching, {"floor": 0.0}, r"floor must lie within \(0, 1\), got 0.0"),
        (ExponentialReaching, {"steepness": -0.1}, "steepness must not be negative, got -0.1"),
        (ExponentialReaching, {"power": 0}, "power must be a positive integer, got 0"),
        (ExponentialReaching, {"power": 1.5}, "power must be a positive integer, got 1.5"),
        (ExponentialReaching, {"layer": -0.1}, "layer must not be negative, got -0.1"),
        (PowerReaching, {"linear": -1.0}, "linear must not be negative, got -1.0"),
        (PowerReaching, {"power_gain": -0.1}, "power_gain must not be negative, got -0.1"),
        (PowerReaching, {"exponent": 1.0}, r"exponent must lie within \(0, 1\), got 1.0"),
    ],
)
def test_bad_parameters(kind, changes, message):
    good = {"linear": 1.0, "switching": 1.0} if kind is ExponentialReaching else {
        "linear": 1.0, "power_gain": 0.2, "exponent": 0.5,
    }  # fmt: skip
    with pytest.raises(ValueError, match=message):
        kind(**{**good, **changes})
