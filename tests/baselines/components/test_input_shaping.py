"""Input shapers leave no vibration, and the turns that they shape are exact."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from ftac_gym.baselines.components.input_shaping import InputShaper, convolved, rest_to_rest, shaper_of, zero_vibration
from ftac_gym.spacecraft.appendages import FlexibleAppendages

FREQUENCIES = st.floats(0.1, 20.0)
RATIOS = st.floats(0.0, 0.5)
ORDERS = st.integers(1, 4)


def left_by_impulses(shaper, frequency, ratio):
    """Return the amplitude after the impulses, by the state of an oscillator, over that of one impulse at their end."""
    system = np.array([[0.0, 1.0], [-(frequency**2), -2.0 * ratio * frequency]])
    state = sum(
        amplitude * expm(system * (shaper.delay - time))[:, 1]
        for time, amplitude in zip(shaper.times, shaper.amplitudes, strict=True)
    )
    root = np.sqrt(1.0 - ratio**2)
    return np.hypot(frequency * root * state[0], state[1] + ratio * frequency * state[0])


def energy_after(shaper, turn, frequency, ratio):
    """Return the energy of a mode of unit coupling after a shaped turn, by integrating its equation."""
    end = turn.duration[0] + shaper.delay

    def slope(time, state):
        rate = turn.motion(np.array([time]), shaper)[1][0]
        displacement_rate = state[1] - rate  # state[1] = eta' + w needs no acceleration
        return displacement_rate, -2.0 * ratio * frequency * displacement_rate - frequency**2 * state[0]

    displacement, rate = solve_ivp(slope, (0.0, end), (0.0, 0.0), rtol=1e-9, atol=1e-12, max_step=0.1).y[:, -1]
    return 0.5 * (rate**2 + (frequency * displacement) ** 2)


# ------------------------------------------------------------------------------------------------------------- shapers


@given(FREQUENCIES, RATIOS, ORDERS)
def test_nothing_is_left_of_the_mode_that_it_is_for(frequency, ratio, order):
    shaper = zero_vibration(frequency, ratio, order)
    assert shaper.residual(frequency, ratio) < 1e-12
    assert shaper.delay == pytest.approx(order * np.pi / (frequency * np.sqrt(1.0 - ratio**2)))
    assert sum(shaper.amplitudes) == pytest.approx(1.0) and min(shaper.amplitudes) > 0.0


@given(FREQUENCIES, RATIOS, FREQUENCIES, RATIOS, ORDERS)
def test_what_is_left_is_what_an_oscillator_keeps(frequency, ratio, other, other_ratio, order):
    shaper = zero_vibration(frequency, ratio, order)
    expected = left_by_impulses(shaper, other, other_ratio)
    assert shaper.residual(other, other_ratio) == pytest.approx(expected, rel=1e-6, abs=1e-9)


@given(FREQUENCIES, st.floats(0.7, 1.3), ORDERS)
def test_an_order_more_multiplies_what_is_left(frequency, factor, order):
    """For a mode that is off by a tenth, ZV leaves a sixth and ZVD a fortieth."""
    once = zero_vibration(frequency).residual(factor * frequency)
    assert once == pytest.approx(abs(np.cos(0.5 * np.pi * factor)), abs=1e-12)
    several = zero_vibration(frequency, order=order).residual(factor * frequency)
    assert several == pytest.approx(once**order, abs=1e-12)


@given(st.lists(st.tuples(FREQUENCIES, RATIOS, st.integers(1, 2)), max_size=4), FREQUENCIES, RATIOS)
def test_convolution_leaves_the_product(modes, frequency, ratio):
    shapers = [zero_vibration(*mode) for mode in modes]
    together = convolved(*shapers)
    assert list(together.times) == sorted(together.times)
    assert together.delay == pytest.approx(sum(shaper.delay for shaper in shapers))
    assert together.mean_delay == pytest.approx(sum(shaper.mean_delay for shaper in shapers))
    product = np.prod([shaper.residual(frequency, ratio) for shaper in shapers])
    assert together.residual(frequency, ratio) == pytest.approx(product, abs=1e-10)
    for mode in modes:
        assert together.residual(*mode[:2]) < 1e-10


@given(st.lists(FREQUENCIES, max_size=3), st.lists(st.floats(-5.0, 200.0), min_size=1, max_size=5))
def test_ramp_and_parabola_are_sums_of_delayed_ones(frequencies, moments):
    shaper, time = convolved(*(zero_vibration(frequency, 0.1, 2) for frequency in frequencies)), np.array(moments)
    late = np.maximum(time[:, None] - np.array(shaper.times), 0.0)
    ramp, parabola = shaper.ramp_and_parabola(time)
    np.testing.assert_allclose(ramp, late @ shaper.amplitudes, rtol=1e-12, atol=1e-11)
    np.testing.assert_allclose(parabola, 0.5 * late**2 @ shaper.amplitudes, rtol=1e-12, atol=1e-9)
    np.testing.assert_array_equal(shaper.ramp(time), ramp)


def test_the_shaper_of_a_spacecraft():
    bends = FlexibleAppendages((3.0, 1.0, 2.0, 1.0), (0.01, 0.02, 0.0, 0.02), np.full((4, 3), 0.1).tolist())
    expected = convolved(zero_vibration(1.0, 0.02, 2), zero_vibration(2.0, 0.0, 2))
    assert shaper_of(bends, 2, 3) == expected  # of two that are alike, one
    everything = shaper_of(bends, 1)
    assert len(everything.times) == 8
    for frequency, ratio in zip(bends.frequencies, bends.damping_ratios, strict=True):
        assert everything.residual(frequency, ratio) < 1e-12
    assert shaper_of(None) == shaper_of(bends, modes=0) == InputShaper() == convolved()
    assert InputShaper().residual(1.0, 0.1) == 1.0


@pytest.mark.parametrize(
    ("times", "amplitudes", "message"),
    [
        ((), (), "times must have one number per impulse"),
        ((-1.0, 0.0), (0.5, 0.5), "times must not be negative"),
        ((1.0, 0.0), (0.5, 0.5), "times must be in rising order"),
        ((0.0, 1.0), (1.0,), "amplitudes must have 2 numbers"),
        ((0.0, 1.0), (0.5, 0.6), "amplitudes must sum to 1"),
    ],
)
def test_bad_shapers(times, amplitudes, message):
    with pytest.raises(ValueError, match=message):
        InputShaper(times, amplitudes)


def test_bad_modes():
    with pytest.raises(ValueError, match=r"frequency must be positive, got 0\.0"):
        zero_vibration(0.0)
    for call in (zero_vibration, InputShaper().residual):
        with pytest.raises(ValueError, match=r"damping_ratio must be below 1, got 1\.0"):
            call(1.0, 1.0)
    with pytest.raises(ValueError, match="order must be a whole number, 1 or more, got 0"):
        zero_vibration(1.0, 0.0, 0)


# --------------------------------------------------------------------------------------------------------------- turns


@given(
    st.lists(st.floats(0.0, 3.2), min_size=1, max_size=4),
    st.floats(1e-3, 1.0),
    st.floats(1e-3, 1.0),
    st.lists(FREQUENCIES, max_size=2),
)
def test_turns_are_exact_and_within_the_limits(angles, acceleration, rate_limit, frequencies):
    angles = np.array(angles)
    turn = rest_to_rest(angles, np.full_like(angles, acceleration), rate_limit)
    shaper = convolved(*(zero_vibration(frequency, 0.01) for frequency in frequencies))
    nothing, still = turn.motion(np.zeros_like(angles), shaper)
    np.testing.assert_array_equal(nothing, 0.0)
    np.testing.assert_array_equal(still, 0.0)
    end = turn.duration + shaper.delay
    for later in (0.0, 1.0, 100.0):
        reached, rate = turn.motion(end + later, shaper)
        np.testing.assert_allclose(reached, angles, atol=1e-8)
        np.testing.assert_allclose(rate, 0.0, atol=1e-9)
    time = np.linspace(0.0, 1.0, 200)[:, None] * end
    motion = np.array([turn.motion(moment, shaper) for moment in time])
    angle, rate = motion[:, 0], motion[:, 1]
    assert (rate >= -1e-9).all() and (rate <= rate_limit + 1e-9).all()
    steps = np.diff(time, axis=0)
    assert (np.abs(np.diff(rate, axis=0)) <= acceleration * steps + 1e-9).all()
    # The mean rate of an interval lies between its ends, up to the effect of the acceleration within.
    mean = 0.5 * (rate[1:] + rate[:-1])
    assert (np.abs(np.diff(angle, axis=0) - mean * steps) <= 0.25 * acceleration * steps**2 + 1e-9).all()


def test_turns_are_as_quick_as_can_be():
    turn = rest_to_rest(np.array([0.0, 0.04, 1.0]), np.full(3, 0.01), 0.05)
    np.testing.assert_allclose(turn.duration, [0.0, 2.0 * np.sqrt(4.0), 1.0 / 0.05 + 0.05 / 0.01])
    halfway, fastest = turn.motion(0.5 * turn.duration)
    np.testing.assert_allclose(halfway, [0.0, 0.02, 0.5])
    np.testing.assert_allclose(fastest, [0.0, 0.02, 0.05])
    with pytest.raises(ValueError, match=r"rate_limit must be positive, got 0\.0"):
        rest_to_rest(np.ones(1), np.ones(1), 0.0)


@pytest.mark.parametrize("angle", [0.02, 0.7, 3.0])
def test_a_shaped_turn_leaves_modes_at_rest(angle):
    modes = ((1.2, 0.005), (2.1, 0.02))
    turn = rest_to_rest(np.array([angle]), np.array([0.01]), 0.08)
    shaper = convolved(*(zero_vibration(*mode) for mode in modes))
    for mode in modes:
        plain = energy_after(InputShaper(), turn, *mode)
        assert plain > 1e-7
        assert energy_after(shaper, turn, *mode) < 1e-6 * plain


def test_order_two_bears_a_wrong_frequency():
    turn = rest_to_rest(np.array([0.6]), np.array([0.01]), 0.08)
    plain, first, second = (
        energy_after(shaper, turn, 1.1 * 1.2, 0.005)
        for shaper in (InputShaper(), zero_vibration(1.2, 0.005), zero_vibration(1.2, 0.005, 2))
    )
    # Energies go with the squares of what is left.
    assert first < 0.05 * plain
    assert second < 0.002 * plain
