"""The PD controllers: they settle, follow, respect limits, and the observer takes away what PD cannot."""

import numpy as np
import pytest
from helpers.units import in_units

from ftac_gym import baselines, scenarios
from ftac_gym.attitude import angle_between
from ftac_gym.dynamics import Simulator
from ftac_gym.faults import Bias, FaultSchedule
from ftac_gym.spacecraft.spacecraft import Spacecraft
from ftac_gym.spacecraft.wheel_array import WheelArray
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.references import RateProfile

NAMES = ("pd", "pd_dob")
FLAGSHIP = scenarios.get("flagship")
TRACKING = scenarios.get("flagship_tracking")
QUIET = {"faults": None, "sensors": None, "disturbance": None, "inertia_uncertainty": None}
BIASED = FLAGSHIP.replace(**{**QUIET, "faults": FaultSchedule((Bias(wheel=1, constant=0.04),))})


def fly(scenario, name, count=8, seed=0, duration=120.0, **gains):
    """Return the true errors [deg], rates [rad/s] and commands [N m] of N spacecraft, (steps, N, ...)."""
    simulator, baseline = Simulator(scenario, count), baselines.make(name, scenario, count, **gains)
    simulator.reset(scenario.draw(seed, count))
    errors, rates, commands = [], [], []
    for _ in range(round(duration / scenario.control_period)):
        command = baseline.act(simulator.measurement())
        simulator.step(command)
        errors.append(np.degrees(angle_between(simulator.state.attitude, simulator.reference_attitude)))
        rates.append(simulator.state.rate.copy())
        commands.append(command)
    return np.array(errors), np.array(rates), np.array(commands)


@pytest.mark.parametrize("allocation", ["minimax", "pseudo_inverse"])
@pytest.mark.parametrize("telemetry", [False, True])
@pytest.mark.parametrize("name", NAMES)
def test_settles_a_healthy_spacecraft(name, telemetry, allocation):
    errors, rates, _ = fly(FLAGSHIP.replace(**QUIET), name, telemetry=telemetry, allocation=allocation)
    assert (errors[0] > 1.0).all()
    assert errors[-1].max() < 0.01
    assert np.abs(rates[-1]).max() < 1e-4


@pytest.mark.parametrize("name", NAMES)
def test_points_within_the_noise(name):
    errors, _, _ = fly(FLAGSHIP.replace(faults=None), name, count=16)
    assert np.median(errors[-100:]) < np.degrees(FLAGSHIP.success.angle)


@pytest.mark.parametrize("name", NAMES)
def test_follows_a_moving_reference(name):
    scenario = TRACKING.replace(**QUIET)
    errors, rates, _ = fly(scenario, name)
    assert np.abs(rates[-300:]).max() > 1e-3  # it moves indeed
    assert errors[-300:].max() < 0.1


def test_follows_a_rate_profile():
    profile = RateProfile((0.01, 0.02, 0.01), (0.05, 0.03, 0.04), constant=(0.0, 0.005, 0.0))
    errors, _, _ = fly(FLAGSHIP.replace(**QUIET, reference=profile), "pd", telemetry=True)
    assert errors[-300:].max() < 0.1


def test_feed_forward_makes_the_difference():
    """The same controller, told that the reference stands still, lags behind."""
    scenario = TRACKING.replace(**QUIET)
    simulator, baseline = Simulator(scenario, 4), baselines.make("pd", FLAGSHIP.replace(**QUIET), 4)
    simulator.reset(scenario.draw(0, 4))
    for _ in range(1200):
        simulator.step(baseline.act(simulator.measurement()))
    lagging = np.degrees(angle_between(simulator.state.attitude, simulator.reference_attitude)).max()
    errors, _, _ = fly(scenario, "pd", count=4)
    assert errors[-1].max() < 0.05 * lagging


@pytest.mark.parametrize("gains", [{}, {"position_gain": 0.06, "rate_gain": 0.24}], ids=["default gains", "soft"])
def test_observer_removes_a_constant_bias(gains):
    without, with_observer = (fly(BIASED, name, isolation="none", **gains)[0][-1] for name in ("pd", "pd_dob"))
    assert (with_observer < 0.01 * without).all()


def test_a_constant_bias_leaves_the_error_that_the_stiffness_says():
    stiff, damping = 0.3, 1.2  # 1/s
    gains = in_units("pd", BIASED, position_gain=stiff, rate_gain=damping)
    errors, _, _ = fly(BIASED, "pd", count=2, isolation="none", calm_share=0.0, **gains)
    torque = 0.04 * BIASED.spacecraft.wheels.axis_matrix[:, 1]
    offset = np.linalg.solve(BIASED.spacecraft.inertia_matrix, torque) / (stiff * (damping - stiff))
    np.testing.assert_allclose(errors[-1], np.degrees(np.linalg.norm(offset)), rtol=0.02)


def test_estimate_is_the_bias():
    baseline, simulator = baselines.make("pd_dob", BIASED, 2, isolation="none"), Simulator(BIASED, 2)
    simulator.reset(BIASED.draw(0, 2))
    for _ in range(1200):
        simulator.step(baseline.act(simulator.measurement()))
    torque = 0.04 * BIASED.spacecraft.wheels.axis_matrix[:, 1]
    np.testing.assert_allclose(baseline.estimate.disturbance, np.tile(torque, (2, 1)), rtol=0.02, atol=1e-4)
    assert baseline.estimate.bias is None and baseline.estimate.effectiveness is None
    assert baselines.make("pd", BIASED, isolation="none").estimate is None


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("scenario", [FLAGSHIP, TRACKING], ids=lambda scenario: scenario.name)
def test_commands_never_exceed_the_limits(name, scenario):
    wheels = WheelArray(scenario.spacecraft.wheels.axes, (0.05, 0.1, 0.2, 0.3), 12.0)
    scenario = scenario.replace(
        spacecraft=Spacecraft(scenario.spacecraft.inertia, wheels), initial_state=InitialState(max_rate=0.2)
    )
    _, _, commands = fly(scenario, name, count=16, duration=40.0)
    share = np.abs(commands) / wheels.torque_limits
    assert share.max() == pytest.approx(1.0)  # and they are used
    assert share.max() <= 1.0 + 1e-12


@pytest.mark.parametrize("name", NAMES)
def test_turns_the_short_way_from_rest(name):
    angles = np.radians([170.0, 60.0, 3.0])
    for sign in (1.0, -1.0):
        quaternion = sign * np.column_stack([np.cos(angles / 2), np.sin(angles / 2), 0 * angles, 0 * angles])
        zero = np.zeros((3, 3))
        measurement = Measurement(
            np.zeros(3),
            quaternion,
            zero,
            np.zeros((3, 4)),
            np.zeros((3, 4)),
            np.ones(3, dtype=bool),
            np.tile([1.0, 0, 0, 0], (3, 1)),
            zero,
            zero,
        )
        command = baselines.make(name, FLAGSHIP, 3).act(measurement)
        torque = command @ FLAGSHIP.spacecraft.wheels.axis_matrix.T
        assert (torque[:, 0] < 0.0).all()


def test_at_rest_on_target_nothing_is_commanded():
    start = FLAGSHIP.replace(**QUIET, initial_state=InitialState.fixed())
    _, rates, commands = fly(start, "pd_dob", count=1, duration=5.0)
    np.testing.assert_allclose(commands, 0.0, atol=1e-12)
    np.testing.assert_allclose(rates, 0.0, atol=1e-12)


def test_rate_limit_is_kept():
    scenario = FLAGSHIP.replace(**QUIET, initial_state=InitialState(angle=(2.5, 3.0)))
    _, slow, _ = fly(scenario, "pd", **in_units("pd", scenario, rate_limit=0.03), duration=60.0)
    _, fast, _ = fly(scenario, "pd", **in_units("pd", scenario, rate_limit=10.0), duration=60.0)
    assert np.linalg.norm(slow, axis=2).max() < 0.033
    assert np.linalg.norm(fast, axis=2).max(axis=0).min() > 0.045


@pytest.mark.parametrize("name", NAMES)
def test_it_coasts_at_the_rate_limit_and_brakes_in_time(name):
    """No torque while coasting, at exactly the rate limit; then the share of the largest deceleration, in time.

    With a loop delay, the torque swings a little as the coasting starts.
    """
    limit, share, stiffness = 0.15, 0.6, 2.0  # rad/s, 1, 1/s
    spacecraft = Spacecraft(np.diag([10.0, 19.0, 25.0]).tolist(), FLAGSHIP.spacecraft.wheels)
    start = InitialState.fixed(attitude=[np.cos(1.4), np.sin(1.4), 0.0, 0.0])
    scenario = FLAGSHIP.replace(**QUIET, loop_delay=0.0, spacecraft=spacecraft, initial_state=start)
    known = {"rate_limit": limit, "braking_share": share, "position_gain": stiffness, "rate_gain": 6.162}
    gains = in_units(name, scenario, **known)
    errors, rates, commands = fly(scenario, name, count=1, **gains)
    torque = commands[:, 0] @ spacecraft.wheels.axis_matrix[0]
    largest = np.abs(torque[0])  # the wheels saturate at the start
    braking = share * largest / spacecraft.inertia_matrix[0, 0]
    angle = np.radians(errors[:, 0])
    before = limit**2 / (2.0 * braking) + braking / (2.0 * stiffness**2)  # speed of the braking curve: the limit
    margin = 3.0 * limit * scenario.control_period
    coasting = (angle > before + margin) & (np.arange(len(angle)) > 50)
    assert coasting.sum() > 100
    np.testing.assert_allclose(rates[coasting, 0, 0], -limit, rtol=1e-3)
    assert np.abs(torque[coasting]).max() < 1e-3 * largest
    curve = (angle < before - 3.0 * margin) & (angle > 2.0 * braking / stiffness**2)
    np.testing.assert_allclose(torque[curve], share * largest, rtol=0.1)
    assert curve.sum() > 3 and errors[-1] < 0.01


def test_braking_in_time_avoids_overshoot():
    scenario = FLAGSHIP.replace(**QUIET, initial_state=InitialState(angle=3.0))
    errors, _, _ = fly(scenario, "pd")
    settled = np.argmax(errors < 0.5, axis=0)
    for row, step in enumerate(settled):
        assert 0 < step < 1200
        assert errors[step:, row].max() < 2.0


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize(
    ("gains", "message"),
    [
        ({"position_gain": -1.0}, "position_gain must be positive, got -1.0"),
        ({"position_gain": np.nan}, "position_gain must be finite, got nan"),
        ({"position_gain": "big"}, "position_gain must be a number, got 'big'"),
        ({"position_gain": 2.0, "rate_gain": 1.0}, "position_gain must be below rate_gain = 1.0, got 2.0"),
        ({"rate_gain": 0.0}, "rate_gain must be positive, got 0.0"),
        ({"braking_share": 0.0}, "braking_share must be positive"),
        ({"rate_limit": -0.1}, "rate_limit must be positive"),
        ({"attitude_filter_time": -1.0}, "attitude_filter_time must not be negative"),
        ({"allocation": "guess"}, r"allocation must be one of \['minimax', 'pseudo_inverse'\], got 'guess'"),
    ],
)
def test_bad_gains(name, gains, message):
    with pytest.raises(ValueError, match=message):
        baselines.make(name, FLAGSHIP, **gains)


def test_bad_bandwidth():
    with pytest.raises(ValueError, match=r"bandwidth must be positive, got 0\.0"):
        baselines.make("pd_dob", FLAGSHIP, bandwidth=0.0)
    with pytest.raises(TypeError, match=r"'bandwidth'; gains of pd are \["):
        baselines.make("pd", FLAGSHIP, bandwidth=1.0)


def test_unknown_baseline_and_count():
    known = r"baseline must be one of ftac_gym.baselines.names\(\), such as .*, or .module:Class. for .*, got 'lqg'"
    with pytest.raises(ValueError, match=known):
        baselines.make("lqg", FLAGSHIP)
    with pytest.raises(ValueError, match="num_spacecraft must be a positive integer, got 0"):
        baselines.make("pd", FLAGSHIP, 0)


def test_wheels_need_limits():
    unlimited = FLAGSHIP.replace(
        faults=None, spacecraft=Spacecraft(FLAGSHIP.spacecraft.inertia, WheelArray(np.eye(3).tolist(), None))
    )
    with pytest.raises(ValueError, match="torque_limit must be finite for every wheel"):
        baselines.make("pd", unlimited)


@pytest.mark.parametrize("name", NAMES)
def test_information_is_a_known_tier(name):
    assert baselines.make(name, FLAGSHIP).information in ("attitude", "telemetry", "oracle")


@pytest.mark.parametrize("name", NAMES)
def test_without_telemetry_the_wheel_momentum_is_not_looked_at(name):
    random = np.random.default_rng(0)
    simulator = Simulator(FLAGSHIP, 4)
    simulator.reset(FLAGSHIP.draw(0, 4))
    blind, told = (baselines.make(name, FLAGSHIP, 4) for _ in range(2))
    for _ in range(5):
        measurement = simulator.measurement()
        other = Measurement(**{**vars(measurement), "wheel_momentum": random.normal(size=(4, 4))})
        command = blind.act(measurement)
        np.testing.assert_array_equal(command, told.act(other))
        simulator.step(command)
