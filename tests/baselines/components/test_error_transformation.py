"""The error transformation: its derivative, its tangents beyond a bound, and craft that start or get outside."""

import numpy as np
import pytest
from helpers.prescribed_laws import Bounds, transformed
from hypothesis import given, settings
from hypothesis import strategies as st

from ftac_gym import baselines, scenarios
from ftac_gym.attitude import (
    mrp_from_quaternion,
    quaternion_error,
    quaternion_from_mrp,
    quaternion_from_rotation_vector,
    quaternion_product,
)
from ftac_gym.baselines.components.error_transformation import ErrorTransformation
from ftac_gym.dynamics import Simulator
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.prescribed_bound import PrescribedBound

CHEN = scenarios.get("chen_2018")
PROPERTY = settings(max_examples=80, deadline=None)
FACTORS = st.tuples(*[st.floats(0.05, 2.0)] * 3)
MARGINS = st.sampled_from([1e-4, 1e-2, 0.05, 0.3, 0.49])
PLACES = st.tuples(*[st.floats(-2.0, 3.0)] * 3)
"""Where sigma is between its bounds: below 0 or above 1 it is outside."""


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


# ---------------------------------------------------------------------------------------- flights beyond their bounds


def flown(name, scenario, steps, disturb, **gains):
    """Return margins (steps, N) and commands (steps, N, wheels); ``disturb(step, simulator)`` may change the craft."""
    simulator, law = Simulator(scenario, 3), baselines.make(name, scenario, 3, **gains)
    simulator.reset(scenario.draw(4, 3))
    margins, commands = [], []
    for step in range(steps):
        disturb(step, simulator)
        seen = simulator.measurement()
        error = mrp_from_quaternion(quaternion_error(seen.attitude, seen.reference_attitude))
        margins.append(law.bound.margin(error, seen.time).min(axis=1))
        commands.append(law.act(seen))
        simulator.step(commands[-1])
    return np.array(margins), np.array(commands)


def turned(at_step, rotations):
    """Replace the attitudes at a step by these."""

    def disturb(step, simulator):
        if step == at_step:
            simulator.state.attitude[:] = quaternion_from_rotation_vector(np.array(rotations))
            simulator.measured_attitude[:] = simulator.state.attitude

    return disturb


def pushed(begin, end, change):
    """Add to the rates at some steps [rad/s], as a strong torque would."""

    def disturb(step, simulator):
        if begin <= step < end:
            simulator.state.rate[:] += np.array(change)
            simulator.measured_rate[:] = simulator.state.rate

    return disturb


FAR = ((1.0, -0.9, 0.8), (-1.4, 0.1, 0.3), (0.2, 2.4, -0.5))  # rad
QUIET = scenarios.get("flagship").replace(faults=None, sensors=None, duration=300.0)
HEAVY = CHEN.replace(control_period=0.1, physics_step=0.02, duration=300.0)
BREACHES = {
    "sampled law, turned": ("prescribed_performance", QUIET, 1300, turned(600, FAR), 600, {"final": 0.02}),
    "sampled law, pushed": (
        "prescribed_performance", QUIET, 1300, pushed(600, 650, (0.003, -0.003, 0.003)), 600, {"final": 0.02},
    ),
    "paper's law, turned": ("chen_m1_sampled", HEAVY, 1500, turned(300, FAR), 300, {"final": 0.05}),
    "paper's law, pushed": (
        "chen_m1_sampled", HEAVY, 1700, pushed(300, 350, (0.0025, -0.0025, 0.0025)), 300, {"final": 0.05},
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", BREACHES)
def test_a_craft_comes_back_from_far_outside(case):
    """The rule for a breached bound: finite commands within the limits, and the way back inside.

    The paper's law, whose tangent is steep, comes to the bound as exp(-k1 t): it takes up to 120 s for that.
    """
    name, scenario, steps, disturb, begin, bound = BREACHES[case]
    margins, commands = flown(name, scenario, steps, disturb, bound=bound)
    limits = scenario.spacecraft.wheels.torque_limits
    assert np.isfinite(commands).all() and (np.abs(commands) <= limits * (1.0 + 1e-12)).all()
    assert (margins[:begin] > 0.0).all()
    assert (margins[begin:].min(axis=0) < -0.2).all()
    assert (margins[-100:] > 0.0).all()


# ----------------------------------------------------------------------------------------------------- starts outside


def measured(*errors, time=0.0):
    """The measurement of craft at rest whose attitudes are these MRPs away from the reference."""
    count = len(errors)
    attitude = quaternion_from_mrp(np.array(errors, dtype=float))
    identity, three = np.tile([1.0, 0.0, 0.0, 0.0], (count, 1)), np.zeros((count, 3))
    return Measurement(
        np.full(count, time), attitude, three, three, three, np.ones(count, bool), identity, three, three
    )  # fmt: skip


TIGHT = {"initial_factor": None}  # the bounds of Table 1 from the start: (-.4, -.5, -.1) to (.1, .1, .4)
PAPERS = (-0.3, -0.4, 0.2)


@pytest.mark.parametrize("name", ["chen_m1", "chen_m1_sampled", "prescribed_performance"])
@pytest.mark.parametrize("method", ["act", "sliding_variable"])
def test_a_start_outside_is_refused(name, method):
    law = baselines.make(name, CHEN, 2, bound=TIGHT)
    pattern = (
        r"attitude of spacecraft 1, which starts at 0 s, must be within its prescribed bound, "
        r"\(-0\.4, 0\.1\) for MRP axis 0, got 0\.3, outside by 0\.2; mirror=True, or "
        r"bound\.lower and bound\.upper exchanged on axes \[0, 2\], would hold this"
    )
    with pytest.raises(ValueError, match=pattern):
        getattr(law, method)(measured(PAPERS, (0.3, -0.4, -0.15)))
    getattr(baselines.make(name, CHEN, 2, bound=TIGHT), method)(measured(PAPERS, PAPERS))


def test_a_start_on_the_bound_is_outside():
    law = baselines.make("chen_m1", CHEN, bound={"lower": (1.0,) * 3, "upper": (1.0,) * 3, **TIGHT})
    with pytest.raises(ValueError, match=r"MRP axis 1, got 0\.5, outside by"):
        law.act(measured((0.1, 0.5000000001, 0.0)))
    law.act(measured((0.1, 0.4999999999, 0.0)))


@pytest.mark.parametrize("mirror", [False, True])
def test_what_no_mirror_would_hold_is_said(mirror):
    law = baselines.make("prescribed_performance", CHEN, bound=TIGHT, mirror=mirror)
    with pytest.raises(ValueError, match=r"axis 1, got 0\.6.* mirrored bounds would not hold it either: bound\.in"):
        law.act(measured((-0.3, 0.6, 0.2)))
    # One axis could be mirrored, the other not: mirroring is no remedy.
    law = baselines.make("prescribed_performance", CHEN, bound=TIGHT)
    with pytest.raises(ValueError, match="mirrored bounds would not hold it either"):
        law.act(measured((0.3, -0.6, 0.2)))


@pytest.mark.parametrize("factors", ["constant", "varying"])
@pytest.mark.parametrize("name", ["chen_m1", "chen_m1_sampled", "prescribed_performance"])
def test_each_craft_of_a_batch_has_its_own_mirrors(name, factors):
    """Chosen at its start and kept when the signs change: the same as craft of their own with exchanged bounds.

    Varying factors, which are those of the paper's example, are equal on both sides at the start.
    """
    changes = TIGHT if factors == "constant" else {}
    starts = [(-0.3, -0.4, 0.2), (0.3, 0.4, -0.2), (0.3, -0.4, 0.2), (-0.01, 0.4, 0.01)]
    later = [(-0.05, 0.06, 0.1), (-0.05, 0.05, 0.04), (-0.02, 0.03, -0.02), (0.05, -0.06, 0.07)]
    flips = [(0, 0, 0), (1, 1, 1), (1, 0, 0), (0, 1, 0)]
    together = baselines.make(name, CHEN, 4, bound=changes, mirror=True)
    moments = [measured(*starts), measured(*later, time=1.0), measured(*later[::-1], time=2.0)]
    commands = [together.act(moment) for moment in moments]
    sliding = together.sliding_variable(moments[1])
    lower, upper = np.array(CHEN.prescribed_bound.lower), np.array(CHEN.prescribed_bound.upper)
    for craft, flip in enumerate(flips):
        mask = np.array(flip) == 1
        exchanged = {"lower": np.where(mask, upper, lower), "upper": np.where(mask, lower, upper)}
        alone = baselines.make(name, CHEN, bound={**changes, **exchanged})
        for moment, expected in zip(moments, commands, strict=True):
            one = moment.take(np.array([craft]))
            np.testing.assert_allclose(alone.act(one), expected[[craft]], rtol=1e-12, atol=1e-12)
        one = moments[1].take(np.array([craft]))
        np.testing.assert_allclose(alone.sliding_variable(one)[0], sliding[craft], atol=1e-12)
    assert (np.abs(commands[2]).max(axis=1) > 0.01).all()  # N m: there is something to compare


@pytest.mark.parametrize("mirror", [False, True])
def test_only_fresh_craft_are_checked_and_a_reset_makes_them_fresh(mirror):
    outside = (0.1, 0.6, 0.1)
    law = baselines.make("chen_m1_sampled", CHEN, 3, bound=TIGHT, mirror=mirror)
    law.act(measured(PAPERS, PAPERS, PAPERS))
    assert np.isfinite(law.act(measured(PAPERS, outside, PAPERS, time=1.0))).all()
    law.reset(np.array([True, False, False]))
    assert np.isfinite(law.act(measured(PAPERS, outside, PAPERS))).all()
    law.reset(np.array([False, True, False]))
    with pytest.raises(ValueError, match=r"got 0\.6"):
        law.act(measured(PAPERS, outside, PAPERS))
    with pytest.raises(ValueError, match=r"got 0\.6"):  # still fresh
        law.act(measured(PAPERS, outside, PAPERS))
    law.act(measured(PAPERS, PAPERS, outside))


def test_a_reset_chooses_mirrors_anew_for_its_craft_only():
    """The other craft, whose signs have changed since its start, keeps its mirrors."""
    opposite, crossed = tuple(-value for value in PAPERS), (0.05, 0.04, -0.03)
    law, first, fresh = (baselines.make("chen_m1_sampled", CHEN, n, bound=TIGHT, mirror=True) for n in (2, 1, 1))
    law.act(measured(PAPERS, PAPERS))
    first.act(measured(PAPERS))
    law.reset(np.array([False, True]))
    law.act(measured(crossed, opposite))
    variable = law.sliding_variable(measured(crossed, opposite))
    first.act(measured(crossed)), fresh.act(measured(opposite))
    np.testing.assert_array_equal(variable[0], first.sliding_variable(measured(crossed))[0])
    np.testing.assert_array_equal(variable[1], fresh.sliding_variable(measured(opposite))[0])
    turned = baselines.make("chen_m1_sampled", CHEN, bound=TIGHT, mirror=True).sliding_variable(measured(crossed))
    assert np.abs(variable[0] - turned[0]).max() > 0.01  # rad/s: its mirrors matter


def test_the_start_is_relative_to_the_reference():
    """sigma of the error, whatever the attitude is, and on the short branch whatever the quaternion's sign."""
    seen = measured(PAPERS)
    reference = quaternion_from_rotation_vector(np.array([[1.0, 2.0, -0.5]]))
    moved = {**vars(seen), "reference_attitude": reference, "attitude": -quaternion_product(reference, seen.attitude)}
    commands = [
        baselines.make("chen_m1", CHEN, bound=TIGHT).act(measurement) for measurement in (seen, Measurement(**moved))
    ]
    np.testing.assert_allclose(commands[1], commands[0], atol=1e-9)


def test_a_mirrored_start_flies_and_stays_within_mirrored_bounds():
    """From -sigma(0), which the paper's bounds hold at the start, with delta(0) = 2, but not half a second later."""
    start = InitialState.fixed(quaternion_from_mrp(-np.array(PAPERS)).tolist())
    scenario = HEAVY.replace(initial_state=start, faults=None)
    exchanged = {"lower": CHEN.prescribed_bound.upper, "upper": CHEN.prescribed_bound.lower}
    errors = {}
    for case, gains in {
        "mirrored": {"mirror": True}, "exchanged": {"bound": exchanged}, "neither": {},
    }.items():  # fmt: skip
        simulator, law = Simulator(scenario, 1), baselines.make("chen_m1_sampled", scenario, **gains)
        simulator.reset(scenario.draw(0, 1))
        errors[case] = []
        for _ in range(200):
            seen = simulator.measurement()
            errors[case].append(mrp_from_quaternion(seen.attitude[0]))
            simulator.step(law.act(seen))
    times, bound = np.arange(200) * 0.1, CHEN.prescribed_bound
    assert bound.mirrored([True] * 3).margin(np.array(errors["exchanged"]), times).min() > 0.0
    assert bound.margin(np.array(errors["neither"]), times).min() < -0.2
    np.testing.assert_array_equal(errors["mirrored"], errors["exchanged"])
