"""The error transformation: its derivative, its tangents beyond a bound, and spacecraft that start or get outside."""

import numpy as np
import pytest
from helpers.prescribed_laws import Bounds, transformed
from hypothesis import given, settings
from hypothesis import strategies as st

from ftac_gym import baselines, scenarios
from ftac_gym.baselines.components.error_transformation import ErrorTransformation
from ftac_gym.task.prescribed_bound import PrescribedBound

CHEN = scenarios.get("chen_2018")
PROPERTY = settings(max_examples=80, deadline=None)
FACTORS = st.tuples(*[st.floats(0.05, 2.0)] * 3)
MARGINS = st.sampled_from([1e-4, 1e-2, 0.05, 0.3, 0.49])
PLACES = st.tuples(*[st.floats(-2.0, 3.0)] * 3)
"""Position of sigma between its bounds: below 0 or above 1 it is outside."""


@st.composite
def pairs(draw):
    """The same bounds twice: the package's and those of the independent formula."""
    initial, low, high = draw(st.floats(0.05, 3.0)), draw(FACTORS), draw(FACTORS)
    final, decay = initial * draw(st.floats(1e-3, 1.0)), draw(st.floats(0.0, 1.0))
    start, rate = draw(st.none() | st.floats(max(*low, *high), 10.0)), draw(st.floats(0.1, 6.0))
    return (
        PrescribedBound(initial, final, decay, low, high, start, rate),
        Bounds(initial, final, decay, low, high, start, rate),
    )


def at(bound, time, places):
    """The MRP (1, 3) that is at these places between the bounds."""
    low, high = bound.bound(time)
    return (low + np.array(places) * (high - low))[None]


# ----------------------------------------------------------------------------------------------------------- formula


@PROPERTY
@given(pairs(), MARGINS, PLACES, st.floats(0.0, 30.0), st.tuples(*[st.booleans()] * 3))
def test_value_and_derivatives_are_those_of_an_independent_formula(both, margin, places, time, flip):
    """r = d epsilon / d sigma and theta = d epsilon / dt at constant sigma by complex steps, inside and outside."""
    bound, other = both
    sigma = at(bound.mirrored(np.array(flip)), time, places)
    value, slope, drift = ErrorTransformation(bound, margin)(sigma, np.array([time]), np.array([flip]))
    expected = transformed(other.flipped(flip), sigma[0], time, margin)
    np.testing.assert_allclose(value[0], expected[0], rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(slope[0], expected[1], rtol=1e-9)
    np.testing.assert_allclose(drift[0], expected[2], rtol=1e-8, atol=1e-9 * np.abs(expected[1]).max())


@PROPERTY
@given(
    pairs(),
    st.sampled_from([0.05, 0.2]),
    st.sampled_from([(-1.5, -0.5), (0.1, 0.9), (1.3, 2.4), (-0.5, -0.1)]),
    st.floats(0.0, 20.0),
    st.tuples(*[st.booleans()] * 3),
    st.integers(0, 10_000),
)
def test_along_any_smooth_motion_epsilon_changes_by_r_sigma_rate_plus_theta(both, margin, region, time, flip, seed):
    """Differences of fourth order of the package's own epsilon, with sigma(t) = the place between moving bounds."""
    bound, random = both[0], np.random.default_rng(seed)
    transformation, mirrored = ErrorTransformation(bound, margin), np.array([flip])
    middle, swing, phase = np.mean(region), 0.5 * (region[1] - region[0]), random.uniform(0.0, 6.28, 3)
    frequency, now = random.uniform(0.1, 2.0, 3), time + 0.1
    start = at(bound.mirrored(mirrored[0]), now, middle + swing * np.sin(phase))
    speed = 0.1 * random.normal(size=(1, 3)) * np.ptp(bound.bound(now), axis=0)
    bend = frequency * speed

    def sigma(t):
        return start + speed * np.sin(frequency * (t - now)) / frequency + bend * (1.0 - np.cos(t - now))

    value, slope, drift = transformation(sigma(now), np.array([now]), mirrored)
    step = 1e-3
    near, far = (
        transformation(sigma(now + k * step), np.array([now + k * step]), mirrored).error
        - transformation(sigma(now - k * step), np.array([now - k * step]), mirrored).error
        for k in (1.0, 2.0)
    )
    change = (8.0 * near - far) / (12.0 * step)
    size = np.abs(slope * speed) + np.abs(drift) + np.abs(value)
    # Not where the differences straddle the edge of a tangent, at which the second derivative jumps.
    place = [bound.mirrored(mirrored[0]).margin(sigma(now + k * step), now + k * step) - margin for k in (-2.0, 2.0)]
    smooth = place[0] * place[1] > 0.0
    np.testing.assert_array_less((np.abs(change - slope * speed - drift) / size)[smooth], 1e-7)


@PROPERTY
@given(pairs(), st.tuples(*[st.floats(1e-3, 1.0 - 1e-3)] * 3), st.floats(0.0, 30.0))
def test_inside_it_is_the_formula_of_the_paper(both, places, time):
    """Eqs. (24), (26), and (27) with its parentheses."""
    bound, _ = both
    sigma = at(bound, time, places)
    l, u, l_rate, u_rate = bound.factors(time)  # noqa: E741
    rho, rho_rate = bound.rho(time), bound.rho(time) * bound.relative_rate(time)
    value, slope, drift = ErrorTransformation(bound, 1e-4)(sigma, np.array([time]))
    x = sigma / rho
    r = (1.0 / (x + l) - 1.0 / (x - u)) / (2.0 * rho)
    np.testing.assert_allclose(value, 0.5 * np.log((l + x) / (u - x)), rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(slope, r, rtol=1e-9)
    theta = 0.5 * ((l_rate - rho_rate * x / rho) / (l + x) - (u_rate + rho_rate * x / rho) / (u - x))
    np.testing.assert_allclose(drift, theta, rtol=1e-8, atol=1e-9 * r.max())


def test_the_literal_reading_of_27_is_wrong():
    """At the paper's start by 4.3, 9.7 and 1.8 1/s, where the right values are -0.44, -0.52 and 0.02 1/s."""
    bound = CHEN.prescribed_bound
    sigma = np.array([[-0.3, -0.4, 0.2]])
    for time, wrong in ((0.0, (4.336, 9.698, 1.812)), (1.0, (0.573, 0.655, 1.232))):
        l, u, l_rate, u_rate = bound.factors(time)  # noqa: E741
        rho, rho_rate = bound.rho(time), bound.rho(time) * bound.relative_rate(time)
        shrinking = rho_rate * sigma / rho**2
        literal = (l_rate - shrinking) / (2 * sigma / rho + l) + (u_rate + shrinking) / (2 * sigma / rho - u)
        drift = ErrorTransformation(bound, 1e-4)(sigma, np.array([time])).drift
        np.testing.assert_allclose(np.abs(literal - drift), [wrong], atol=5e-4)


# ---------------------------------------------------------------------------------------------------------- tangents


@PROPERTY
@given(pairs(), MARGINS, st.floats(0.0, 30.0), st.sampled_from([0, 1]))
def test_value_and_slopes_are_continuous_where_the_tangent_begins(both, margin, time, side):
    bound, _ = both
    transformation, moment = ErrorTransformation(bound, margin), np.array([time])
    edge = abs(side - margin)
    beside = [transformation(at(bound, time, [edge + away] * 3), moment) for away in (-1e-11, 1e-11)]
    for before, after in zip(*beside, strict=True):
        np.testing.assert_allclose(before, after, rtol=1e-6, atol=1e-6 * np.abs(beside[0].slope).max())
    assert np.abs(beside[0].error).min() == pytest.approx(0.5 * np.log((1.0 - margin) / margin), rel=1e-6, abs=1e-9)


@PROPERTY
@given(pairs(), MARGINS, st.floats(0.0, 30.0), st.lists(st.floats(-5.0, 6.0), min_size=2, max_size=20, unique=True))
def test_epsilon_grows_with_sigma_everywhere(both, margin, time, places):
    bound, _ = both
    transformation, ordered = ErrorTransformation(bound, margin), np.array(sorted(places))
    ordered = ordered[np.append(True, np.diff(ordered) > 1e-9)]
    sigma = np.concatenate([at(bound, time, [place] * 3) for place in ordered])
    value, slope, _ = transformation(sigma, np.full(len(ordered), time))
    assert np.isfinite(value).all() and (slope > 0.0).all()
    assert (np.diff(value, axis=0) > 0.0).all()


@PROPERTY
@given(pairs(), MARGINS, st.floats(0.0, 30.0), PLACES)
def test_epsilon_is_zero_in_the_middle_only(both, margin, time, places):
    """The middle is sigma = rho (u - l) / 2; on either side of it epsilon has the sign of the side."""
    bound, _ = both
    low, high = bound.bound(time)
    transformation, moment = ErrorTransformation(bound, margin), np.array([time])
    middle = transformation(0.5 * (low + high)[None], moment).error
    np.testing.assert_allclose(middle, 0.0, atol=1e-12)
    off = np.abs(np.array(places) - 0.5) > 1e-9
    value = transformation(at(bound, time, places), moment).error[0]
    np.testing.assert_array_equal(np.sign(value[off]), np.sign(np.array(places)[off] - 0.5))


@pytest.mark.parametrize(
    ("margin", "message"),
    [
        (0.0, r"^margin must lie within \(0, 0\.5\), got 0\.0"),
        (0.5, r"^margin must lie within \(0, 0\.5\), got 0\.5"),
        (np.nan, "^margin must be finite, got nan"),
    ],
)
def test_bad_margin(margin, message):
    with pytest.raises(ValueError, match=message):
        ErrorTransformation(PrescribedBound(), margin)
    with pytest.raises(ValueError, match="^chen_m1: " + message[1:]):
        baselines.make("chen_m1", CHEN, margin=margin)
