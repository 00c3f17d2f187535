"""Tests of `ftac_gym.task.references`: the attitude commands against finite differences and an integrator."""

import math

import numpy as np
import pytest
from scipy import stats
from scipy.integrate import solve_ivp

from ftac_gym import attitude as att
from ftac_gym.dynamics import Simulator
from ftac_gym.spacecraft import Spacecraft, WheelArray
from ftac_gym.task import MRPSinusoid, RateProfile, Scenario, SetPoints, fixed_attitude

HALF_TURN = (0.0, 1.0, 0.0, 0.0)
QUARTER_TURN = (math.sqrt(0.5), 0.0, math.sqrt(0.5), 0.0)
TURN = (0.0, 2.0 * math.pi)


def follow(reference, steps, period=0.1, count=1, seed=0, physics_step=None):
    """Return time (T,), and attitude, rate, acceleration (T, N, .) of the reference at every control period."""
    scenario = Scenario(
        name="reference",
        spacecraft=Spacecraft(np.diag([10.0, 12.0, 14.0]), WheelArray(np.eye(3), 0.2)),
        reference=reference,
        control_period=period,
        physics_step=physics_step or period,
        duration=1000.0 * period,
    )
    simulator = Simulator(scenario, count)
    simulator.reset(scenario.draw(seed, count))
    history = []
    for step in range(steps + 1):
        if step:
            simulator.step(np.zeros((count, 3)))
        measured = simulator.measurement()
        history.append((measured.reference_attitude, measured.reference_rate, measured.reference_acceleration))
    return np.arange(steps + 1) * period, *(np.array(part) for part in zip(*history, strict=True))


def differences(values, period):
    """Fourth-order central differences along the first axis, at the points 2 .. T - 3."""
    return (8.0 * (values[3:-1] - values[1:-3]) - (values[4:] - values[:-4])) / (12.0 * period)


def continuous(attitude):
    """Choose the signs of a quaternion history so that it does not jump."""
    flips = np.sign(np.sum(attitude[1:] * attitude[:-1], axis=-1, keepdims=True))
    return np.concatenate([attitude[:1], attitude[1:] * np.cumprod(flips, axis=0)])


# ------------------------------------------------------------------------------------------------------- set-points


def test_default_reference_is_the_inertial_frame():
    _, attitude, rate, acceleration = follow(SetPoints(), 3)
    assert np.all(attitude == [1.0, 0.0, 0.0, 0.0]) and np.all(rate == 0.0) and np.all(acceleration == 0.0)


def test_fixed_attitude_is_held():
    _, attitude, rate, _ = follow(fixed_attitude(QUARTER_TURN), 3)
    np.testing.assert_allclose(attitude[:, 0], np.tile(QUARTER_TURN, (4, 1)), atol=1e-15)
    assert np.all(rate == 0.0)


@pytest.mark.parametrize(("time", "first_tick"), [(0.3, 3), (0.7, 7), (0.35, 4), (0.01, 1)])
def test_set_point_switches_at_the_first_tick_that_is_not_before_its_time(time, first_tick):
    _, attitude, _, _ = follow(SetPoints(((1.0, 0.0, 0.0, 0.0), HALF_TURN), (0.0, time)), 10)
    expected = np.where(np.arange(11)[:, None] >= first_tick, HALF_TURN, (1.0, 0.0, 0.0, 0.0))
    np.testing.assert_array_equal(attitude[:, 0], expected)


def test_every_set_point_has_its_turn():
    points = (QUARTER_TURN, HALF_TURN, (1.0, 0.0, 0.0, 0.0))
    _, attitude, _, _ = follow(SetPoints(points, (0.0, 0.2, 0.5)), 8)
    np.testing.assert_allclose(attitude[:, 0], np.array(points)[[0, 0, 1, 1, 1, 2, 2, 2, 2]], atol=1e-15)


# ---------------------------------------------------------------------------------------------------- MRP sinusoids


RANDOM_SINUSOID = MRPSinusoid(
    amplitude=((0.1, 0.6),) * 3, frequency=((0.3, 1.2),) * 3, constant=((-0.3, 0.3),) * 3, phase=(TURN,) * 3
)


def test_mrp_sinusoid_is_the_documented_function_of_time():
    reference = MRPSinusoid((0.2, -0.3, 0.4), (0.5, 0.6, 0.7), constant=(0.1, 0.0, -0.1), phase=(0.0, 1.0, 2.0))
    time, attitude, rate, acceleration = (part for part in follow(reference, 60))
    angle = np.array([0.5, 0.6, 0.7]) * time[:, None] + np.array([0.0, 1.0, 2.0])
    swing, frequency = np.array([0.2, -0.3, 0.4]), np.array([0.5, 0.6, 0.7])
    mrp = np.array([0.1, 0.0, -0.1]) + swing * np.sin(angle)
    mrp_rate, mrp_acceleration = swing * frequency * np.cos(angle), -swing * frequency**2 * np.sin(angle)
    assert np.all(att.angle_between(attitude[:, 0], att.quaternion_from_mrp(mrp)) < 1e-14)
    np.testing.assert_allclose(rate[:, 0], att.angular_velocity_from_mrp(mrp, mrp_rate), atol=1e-14)
    expected = att.angular_acceleration_from_mrp(mrp, mrp_rate, mrp_acceleration)
    np.testing.assert_allclose(acceleration[:, 0], expected, atol=1e-14)


def test_mrp_sinusoid_agrees_with_finite_differences():
    period = 0.005
    _, attitude, rate, acceleration = follow(RANDOM_SINUSOID, 200, period, count=20)
    np.testing.assert_allclose(np.linalg.norm(attitude, axis=-1), 1.0, atol=1e-14)
    slope = differences(continuous(attitude), period)
    np.testing.assert_allclose(
        slope, att.quaternion_derivative(continuous(attitude)[2:-2], rate[2:-2]), rtol=0.0, atol=1e-9
    )
    np.testing.assert_allclose(differences(rate, period), acceleration[2:-2], rtol=0.0, atol=1e-8)


def test_mrp_beyond_a_half_turn_is_followed_too():
    time, attitude, rate, _ = follow(MRPSinusoid((2.0, 0.0, 0.0), (0.5, 0.0, 0.0)), 30)
    mrp = 2.0 * np.sin(0.5 * time)
    expected = np.stack([np.cos(2.0 * np.arctan(mrp)), np.sin(2.0 * np.arctan(mrp))], axis=1)
    assert np.all(np.abs(np.sum(attitude[:, 0, :2] * expected, axis=1)) > 1.0 - 1e-14)
    np.testing.assert_allclose(rate[:, 0, 0], 4.0 / (1.0 + mrp**2) * np.cos(0.5 * time), atol=1e-13)


def test_random_sinusoids_differ_between_episodes_and_fill_their_intervals():
    numbers = RANDOM_SINUSOID.draw(np.random.default_rng(0).random((2000, RANDOM_SINUSOID.uniform_count)))[0]
    for name, low, width in (("amplitude", 0.1, 0.5), ("frequency", 0.3, 0.9), ("constant", -0.3, 0.6)):
        for column in numbers[name].T:
            assert stats.kstest(column, "uniform", (low, width)).pvalue > 1e-3
    columns = np.concatenate([numbers[name] for name in ("amplitude", "frequency", "constant", "phase")], axis=1)
    assert np.abs(np.corrcoef(columns.T) - np.eye(12)).max() < 0.1


# ---------------------------------------------------------------------------------------------------- rate profiles


def test_rate_profile_agrees_with_an_integrator():
    swing, frequency = np.array([0.05, -0.03, 0.04]), np.array([0.3, 0.5, 0.2])
    constant, phase = np.array([0.01, 0.02, -0.03]), np.array([0.0, 1.0, 2.0])
    reference = RateProfile(tuple(swing), tuple(frequency), tuple(constant), tuple(phase), attitude=QUARTER_TURN)
    time, attitude, rate, acceleration = follow(reference, 300, physics_step=0.02)

    def command(t):
        return constant + swing * np.sin(frequency * t + phase)

    truth = solve_ivp(
        lambda t, q: att.quaternion_derivative(q, command(t)),
        (0.0, time[-1]),
        np.array(QUARTER_TURN),
        "DOP853",
        time,
        rtol=1e-12,
        atol=1e-13,
    )
    assert np.all(att.angle_between(attitude[:, 0], truth.y.T) < 1e-10)
    np.testing.assert_allclose(np.linalg.norm(attitude, axis=-1), 1.0, atol=1e-14)
    np.testing.assert_allclose(rate[:, 0], np.array([command(t) for t in time]), atol=1e-15)
    slope = swing * frequency * np.cos(frequency * time[:, None] + phase)
    np.testing.assert_allclose(acceleration[:, 0], slope, atol=1e-15)


def test_rate_profile_restarts_with_the_episode():
    reference = RateProfile(((0.01, 0.1),) * 3, ((0.1, 0.5),) * 3)
    scenario = Scenario(
        name="restart",
        spacecraft=Spacecraft(np.eye(3), WheelArray(np.eye(3), 0.2)),
        reference=reference,
        physics_step=0.1,
    )
    episodes = scenario.draw(0, 2)
    simulator = Simulator(scenario, 2)
    histories = []
    simulator.reset(episodes)
    for _ in range(2):
        history = []
        for _ in range(20):
            simulator.step(np.zeros((2, 3)))
            history.append(simulator.measurement().reference_attitude[1])
        histories.append(history)
        simulator.reset(episodes[1], mask=np.array([False, True]))
    np.testing.assert_array_equal(*histories)


# ------------------------------------------------------------------------------------------------------------ rules


def test_only_set_points_stand_still():
    zero = (0.0, 0.0, 0.0)
    assert not SetPoints().moving and MRPSinusoid(zero, zero).moving and RateProfile(zero, zero).moving


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: SetPoints((HALF_TURN,), (1.0,)), "times must start at 0 and increase"),
        (lambda: SetPoints((HALF_TURN, QUARTER_TURN), (0.0, 0.0)), "times must start at 0 and increase"),
        (lambda: SetPoints((HALF_TURN, QUARTER_TURN), (0.0, math.nan)), "times must be finite"),
        (lambda: SetPoints((HALF_TURN,), (0.0, 1.0)), "times must match the 1 attitudes"),
        (lambda: SetPoints((), ()), "times must match the 0 attitudes"),
        (lambda: SetPoints((HALF_TURN, (1.0, 1.0, 0.0, 0.0)), (0.0, 1.0)), r"attitudes\[1\] must be a unit quaternion"),
        (lambda: SetPoints(((1.0, 0.0, 0.0),)), r"attitudes\[0\] must have 4 numbers"),
        (lambda: RateProfile((0.1,) * 3, (0.1,) * 3, attitude=(2.0, 0.0, 0.0, 0.0)), "attitude must be a unit"),
        (lambda: RateProfile((0.1,) * 2, (0.1,) * 3), "amplitude must have three entries"),
        (lambda: MRPSinusoid((0.1,) * 3, (0.1, (0.3, 0.2), 0.1)), r"frequency\[1\] must have low <= high"),
        (lambda: MRPSinusoid((0.1,) * 3, (0.1,) * 3, constant=(0.0, math.inf, 0.0)), r"constant\[1\] must be finite"),
        (lambda: MRPSinusoid((0.1,) * 3, (0.1,) * 3, phase=0.0), "phase must have three entries"),
    ],
)
def test_rules(build, message):
    with pytest.raises(ValueError, match=message):
        build()
