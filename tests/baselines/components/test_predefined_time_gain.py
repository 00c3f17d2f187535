"""The predefined-time gain: its slope, the time it takes, and what regularisation makes of it."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from ftac_gym.baselines.components.predefined_time_gain import PredefinedTime

ENERGY = np.logspace(-8.0, 0.5, 30)
EXPONENT, TIME = st.floats(0.05, 0.9), st.floats(0.1, 100.0)


@settings(max_examples=60, deadline=None)
@given(exponent=EXPONENT, time=TIME, regularisation=st.one_of(st.just(0.0), st.floats(1e-12, 1e-1)))
def test_gain_and_slope(exponent, time, regularisation):
    law = PredefinedTime(exponent, time, regularisation)
    gain, slope = law.gain_and_slope(ENERGY)
    expected = np.exp(ENERGY**exponent) * (ENERGY + regularisation) ** -exponent / (2.0 * exponent * time)
    np.testing.assert_allclose(gain, expected, rtol=1e-12)
    np.testing.assert_allclose(law.gain(ENERGY), gain, rtol=1e-12)
    step = 1e-3 * ENERGY
    near, far = (law.gain(ENERGY + k * step) - law.gain(ENERGY - k * step) for k in (1.0, 2.0))
    difference = (8.0 * near - far) / (12.0 * step)
    np.testing.assert_allclose(slope, difference, rtol=1e-7, atol=1e-9 * np.max(gain / ENERGY))


def reached(derivative, start, low):
    """When the solution of x' = derivative(x) from ``start`` first falls to ``low`` in length."""

    def event(_, x):
        return np.linalg.norm(x) - low

    event.terminal = True
    flown = solve_ivp(
        lambda _, x: derivative(x), (0.0, 1e3), start, method="DOP853", rtol=1e-11, atol=1e-15, events=event
    )
    return flown.t_events[0][0]


@pytest.mark.parametrize("energy", [1e-3, 0.08, 1.0])
@pytest.mark.parametrize(("exponent", "time"), [(0.3, 10.0), (0.5, 4.0), (0.8, 2.0)])
def test_energy_vanishes_at_the_closed_form(exponent, time, energy):
    """Integrated down to V = low, whose own reaching time is what is left."""
    law, low = PredefinedTime(exponent, time), 1e-7
    left = law.reaching_time(np.array(low))
    flown = reached(lambda v: -np.exp(v**exponent) * v ** (1.0 - exponent) / (exponent * time), [energy], low)
    assert flown + left == pytest.approx(law.reaching_time(np.array(energy)), abs=1e-6)
    assert flown + left < time


@pytest.mark.parametrize("start", [(0.3, -0.2, 0.2), (0.01, 0.02, 0.0), (0.9, 0.1, -0.2)])
def test_the_error_vanishes_at_the_closed_form(start):
    law, low = PredefinedTime(0.25, 10.0), 1e-3
    start = np.array(start)
    flown = reached(lambda x: -law.gain(np.array(0.5 * x @ x)) * x, start, low)
    expected = law.reaching_time(0.5 * start @ start) - law.reaching_time(np.array(0.5 * low**2))
    assert flown == pytest.approx(expected, abs=1e-6)


@settings(max_examples=40, deadline=None)
@given(exponent=EXPONENT, time=TIME, energy=st.floats(0.0, 10.0), more=st.floats(0.01, 10.0))
def test_the_time_depends_on_the_start_and_never_exceeds_the_bound(exponent, time, energy, more):
    law = PredefinedTime(exponent, time)
    short, long = law.reaching_time(np.array([energy, energy + more]))
    assert 0.0 <= short < long < time or long == pytest.approx(time)
    assert law.reaching_time(np.zeros(1))[0] == 0.0


@settings(max_examples=40, deadline=None)
@given(exponent=st.floats(0.2, 0.9), time=TIME, gain=st.floats(0.05, 20.0))
def test_with_gain_is_that_gain_at_zero(exponent, time, gain):
    law = PredefinedTime.with_gain(exponent, time, gain)
    for energy in (np.zeros(2), np.zeros((3, 1))):
        np.testing.assert_allclose(law.gain(energy), gain, rtol=1e-4)
        np.testing.assert_allclose(law.gain_and_slope(energy)[0], gain, rtol=1e-4)


@pytest.mark.parametrize("exponent", [0.05, 0.1])
def test_with_gain_for_small_exponents(exponent):
    np.testing.assert_allclose(PredefinedTime.with_gain(exponent, 30.0, 1.0).gain(np.zeros(1)), 1.0, rtol=1e-3)


@settings(max_examples=40, deadline=None)
@given(exponent=EXPONENT, time=TIME, regularisation=st.sampled_from([0.0, 1e-6]))
def test_finite_for_every_energy(exponent, time, regularisation):
    law = PredefinedTime(exponent, time, regularisation)
    for energy in (0.0, 1e-300, 1e-24, 1e-12, 10.0):
        gain, slope = law.gain_and_slope(np.array([energy]))
        assert np.isfinite(gain).all() and np.isfinite(slope).all() and (gain > 0.0).all()
        assert np.isfinite(law.gain(np.array([energy]))).all()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"exponent": 0.0}, r"exponent must lie within \(0, 1\), got 0.0"),
        ({"exponent": 1.0}, r"exponent must lie within \(0, 1\), got 1.0"),
        ({"time": 0.0}, "time must be positive, got 0.0"),
        ({"time": np.inf}, "time must be finite, got inf"),
        ({"regularisation": -1e-9}, "regularisation must not be negative, got -1e-09"),
    ],
)
def test_bad_parameters(changes, message):
    with pytest.raises(ValueError, match=message):
        PredefinedTime(**{"exponent": 0.3, "time": 10.0, **changes})
    with pytest.raises(ValueError, match=r"gain must be positive, got 0\.0"):
        PredefinedTime.with_gain(0.3, 10.0, 0.0)
