"""Prescribed bounds: solutions of their differential equations, margins, mirrors and JSON."""

import hashlib
import json

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from ftac_gym import scenarios
from ftac_gym.scenarios.flagship import DEGREE
from ftac_gym.task import PrescribedBound, Scenario, SensorErrors

FLAGSHIP = scenarios.get("flagship")
SENSORS_THEN = SensorErrors(
    attitude_noise=0.005 * DEGREE,
    rate_noise=5e-4 * DEGREE,
    gyro_bias=(-DEGREE / 3600.0, DEGREE / 3600.0),
    gyro_bias_walk=1e-8,
)
PROPERTY = settings(max_examples=60, deadline=None)
LOWER, UPPER = (0.8, 1.0, 0.2), (0.2, 0.2, 0.8)
PAPER = PrescribedBound(0.5, 0.001, 0.1, LOWER, UPPER, 2.0, 5.0)
FACTORS = st.tuples(*[st.floats(0.05, 2.0)] * 3)


@st.composite
def bounds(draw):
    initial, lower, upper = draw(st.floats(0.05, 3.0)), draw(FACTORS), draw(FACTORS)
    return PrescribedBound(
        initial, initial * draw(st.floats(1e-3, 1.0)), draw(st.floats(0.0, 1.0)), lower, upper,
        draw(st.none() | st.floats(max(*lower, *upper), 20.0)), draw(st.floats(0.0, 6.0)),
    )  # fmt: skip


# ------------------------------------------------------------------------------------------------------ closed forms


@settings(max_examples=25, deadline=None)
@given(bounds())
def test_width_and_factors_solve_their_differential_equations(bound):
    """rho' = -kappa (rho - rho_inf) for (21), and (23) with p = a = factor_decay and q/p, b/a the final factors."""
    final = np.array([*bound.lower, *bound.upper])
    start = final if bound.initial_factor is None else np.full(6, bound.initial_factor)

    def derivative(_, state):
        rate = bound.factor_decay
        return np.append(-bound.decay * (state[0] - bound.final), -rate * state[1:] + rate * final)

    times = np.linspace(0.0, 8.0, 9)
    options = {"method": "DOP853", "t_eval": times, "rtol": 1e-11, "atol": 1e-13, "max_step": 0.5}
    solution = solve_ivp(derivative, (0.0, 8.0), np.append(bound.initial, start), **options).y.T
    factors, rho = bound.factors(times), bound.rho(times)
    np.testing.assert_allclose(rho, solution[:, 0], rtol=1e-7)
    np.testing.assert_allclose(factors.lower, solution[:, 1:4], rtol=1e-7)
    np.testing.assert_allclose(factors.upper, solution[:, 4:], rtol=1e-7)
    changes = np.array([derivative(0.0, state) for state in solution])
    np.testing.assert_allclose(bound.relative_rate(times), changes[:, 0] / solution[:, 0], rtol=1e-6, atol=1e-7)
    np.testing.assert_allclose(factors.lower_rate, changes[:, 1:4], rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(factors.upper_rate, changes[:, 4:], rtol=1e-6, atol=1e-6)
    low, high = bound.bound(times)
    np.testing.assert_allclose(low, -solution[:, 1:4] * solution[:, :1], rtol=1e-7)
    np.testing.assert_allclose(high, solution[:, 4:] * solution[:, :1], rtol=1e-7)


def test_limits():
    """From delta(0) rho_0 to Table 1's q/p and b/a times rho_inf."""
    low, high = PAPER.bound([0.0, 1e4])
    np.testing.assert_allclose(low, [[-1.0] * 3, [-0.0008, -0.001, -0.0002]], rtol=1e-12)
    np.testing.assert_allclose(high, [[1.0] * 3, [0.0002, 0.0002, 0.0008]], rtol=1e-12)


def test_default_bounds_hold_every_attitude_at_the_start():
    low, high = PrescribedBound().bound(0.0)
    assert (low < -1.0).all() and (high > 1.0).all()


# ----------------------------------------------------------------------------------------------------------- margins


@PROPERTY
@given(bounds(), st.floats(0.0, 60.0), st.tuples(*[st.floats(-0.5, 1.5)] * 3))
def test_the_margin_says_inside_or_outside(bound, time, places):
    """And how far: 0 on a bound, 1/2 in the middle, -1/2 where it is outside by half the distance of the bounds."""
    assume(all(abs(place - edge) > 1e-9 for place in places for edge in (0.0, 1.0)))
    low, high = bound.bound(time)
    error = low + np.array(places) * (high - low)
    margin = bound.margin(error, time)
    np.testing.assert_array_equal(margin > 0.0, (low < error) & (error < high))
    expected = [place if place < 0.5 else 1.0 - place for place in places]
    np.testing.assert_allclose(margin, expected, atol=1e-12)
    np.testing.assert_allclose(bound.margin(low, time), 0.0, atol=1e-15)
    np.testing.assert_allclose(bound.margin(high, time), 0.0, atol=1e-15)


@PROPERTY
@given(bounds(), st.tuples(*[st.booleans()] * 3), st.floats(0.0, 60.0), st.tuples(*[st.floats(-1.0, 1.0)] * 3))
def test_mirrored_bounds_are_those_of_the_mirrored_error(bound, axes, time, error):
    mask = np.array(axes)
    mirrored, error = bound.mirrored(mask), np.array(error)
    np.testing.assert_allclose(
        mirrored.margin(np.where(mask, -error, error), time), bound.margin(error, time), atol=1e-12
    )  # fmt: skip
    assert mirrored.mirrored(mask) == bound
    assert (mirrored == bound) == all(bound.lower[i] == bound.upper[i] for i in range(3) if axes[i])
    assert bound.mirrored([False] * 3) == bound


def test_shapes():
    """Times ()  and (T,), and (T, 1) with the errors of N spacecraft; each entry is that of a call of its own."""
    times, errors = np.linspace(0.0, 20.0, 5), np.random.default_rng(0).uniform(-0.4, 0.4, (5, 7, 3))
    assert PAPER.rho(2.0).shape == () and PAPER.relative_rate(2.0).shape == ()
    assert PAPER.rho(times).shape == (5,) and PAPER.rho(times[:, None]).shape == (5, 1)
    assert all(part.shape == (3,) for part in (*PAPER.factors(2.0), *PAPER.bound(2.0)))
    for bound in (PAPER, PrescribedBound()):
        assert all(part.shape == (5, 3) for part in (*bound.factors(times), *bound.bound(times)))
        assert bound.margin(errors[0, 0], 1.0).shape == (3,)
        assert bound.margin(errors[0], 1.0).shape == (7, 3)
        together = bound.margin(errors, times[:, None])
        assert together.shape == (5, 7, 3)
        for row, time in enumerate(times):
            np.testing.assert_array_equal(together[row], bound.margin(errors[row], time))
            np.testing.assert_array_equal(bound.bound(times)[0][row], bound.bound(time)[0])


# -------------------------------------------------------------------------------------------------------------- JSON


@PROPERTY
@given(bounds())
def test_survives_json_within_a_scenario(bound):
    scenario = FLAGSHIP.replace(prescribed_bound=bound)
    again = Scenario.from_json(scenario.to_json())
    assert again.prescribed_bound == bound and again == scenario and again.to_json() == scenario.to_json()
    assert FLAGSHIP.replace(prescribed_bound=scenario.to_dict()["prescribed_bound"]) == scenario
    assert scenario.replace(prescribed_bound=None) == FLAGSHIP


@pytest.mark.parametrize(
    ("name", "digest"),
    [
        ("flagship", "436c72449371bd6158e9253355ba5d296f5fdca4d53da6837095270e35d9f53c"),
        ("flagship_tracking", "2e4819b535de2bc97edf222f7967affa9af0041757b5c64d4c0b46cf82a55f44"),
        ("cao_2022", "d084e5a2a2271491789903b1bcfc763d609e00b8b0ee08c755dbf4744ffa73a6"),
        ("shen_2019", "aa1c3081dbb1c1bbd54e1de9f65a99445937dec4a37ce4f4ed493762926f3a36"),
    ],
)
def test_without_a_bound_the_text_is_what_it_was_before_there_were_any(name, digest):
    """The digests are those of the package before it had bounds (commit bc49d9e), without the reward.

    The flagship had simple sensors and no delay then.
    """
    scenario = scenarios.get(name)
    if name.startswith("flagship"):
        scenario = scenario.replace(loop_delay=0.0, sensors=SENSORS_THEN)
    text = scenario.to_json()
    assert "prescribed_bound" not in text
    others = {part: value for part, value in json.loads(text).items() if part != "reward"}
    assert hashlib.sha256(json.dumps(others).encode()).hexdigest() == digest
    assert Scenario.from_json(text).prescribed_bound is None


# --------------------------------------------------------------------------------------------------------- bad input


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"initial": 0.0}, r"^initial must be positive, got 0\.0"),
        ({"initial": "wide"}, "^initial must be a number, got 'wide'"),
        ({"final": 0.0}, r"^final must be positive, got 0\.0"),
        ({"final": np.inf}, "^final must be finite, got inf"),
        ({"initial": 0.5, "final": 0.6}, r"^final must not exceed initial = 0\.5, got 0\.6"),
        ({"decay": -0.1}, r"^decay must not be negative, got -0\.1"),
        ({"factor_decay": np.nan}, "^factor_decay must be finite, got nan"),
        ({"lower": (1.0, 1.0)}, r"^lower must have 3 numbers, got \(1\.0, 1\.0\)"),
        ({"lower": 1.0}, r"^lower must have 3 numbers, got 1\.0"),
        ({"upper": (1.0, 0.0, 1.0)}, r"^upper must be positive, got \(1\.0, 0\.0, 1\.0\)"),
        ({"upper": (1.0, np.inf, 1.0)}, "^upper must be finite"),
        ({"initial_factor": 0.0}, r"^initial_factor must be positive, got 0\.0"),
        ({"initial_factor": np.inf}, "^initial_factor must be finite, got inf"),
        (
            {"initial_factor": 0.5, "upper": (0.2, 0.8, 0.3)},
            r"^initial_factor must not be below the final factors, of which the largest is 1\.0, got 0\.5",
        ),
    ],
)
def test_rules(fields, message):
    with pytest.raises(ValueError, match=message):
        PrescribedBound(**fields)


@pytest.mark.parametrize("axes", [(1, 0, 0), (True, False), [[True] * 3], True])
def test_mirrored_needs_a_mask(axes):
    with pytest.raises(ValueError, match=r"^axes must be a boolean array of shape \(3,\), got"):
        PAPER.mirrored(axes)


def test_a_scenario_takes_a_bound_only():
    with pytest.raises(ValueError, match=r"^prescribed_bound must be a PrescribedBound or None, got 0\.5"):
        FLAGSHIP.replace(prescribed_bound=0.5)
    with pytest.raises(ValueError, match="PrescribedBound has no field 'width'"):
        FLAGSHIP.replace(prescribed_bound={"type": "PrescribedBound", "width": 1.0})
