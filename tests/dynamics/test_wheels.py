"""Wheels in the plant: torque and momentum limits, saturation, and what each fault does at its moment."""

import numpy as np
import pytest
from helpers.wheels import run

from ftac_gym import attitude as att
from ftac_gym import scenarios
from ftac_gym.dynamics import Simulator
from ftac_gym.faults import Bias, FaultKind, FaultSchedule, HardOver, LockInPlace, LossOfEffectiveness, Outage
from ftac_gym.spacecraft.spacecraft import Spacecraft
from ftac_gym.spacecraft.wheel_array import WheelArray
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.scenario import Scenario

INERTIA = np.array([[10.0, 1.2, 0.5], [1.2, 19.0, 1.5], [0.5, 1.5, 25.0]])  # kg m^2
PYRAMID = WheelArray.sign_pyramid(0.2, None).axis_matrix
PERIOD, STEP = 0.1, 0.02  # s


def start(*faults, limit=None, momentum=0.0, torque_limit=0.2, coupling=True, count=1, seed=0):
    scenario = Scenario(
        name="wheels",
        spacecraft=Spacecraft(INERTIA, WheelArray(PYRAMID, torque_limit, limit, coupling)),
        initial_state=InitialState.fixed(rate=(0.02, -0.01, 0.03), wheel_momentum=momentum),
        faults=FaultSchedule(faults),
        control_period=PERIOD,
        physics_step=STEP,
    )
    simulator = Simulator(scenario, count)
    simulator.reset(scenario.draw(seed, count))
    return simulator


def total_momentum(state):
    body = state.rate @ INERTIA + state.wheel_momentum @ PYRAMID.T
    return att.rotate_to_reference(state.attitude, body)


def wheel(index, value):
    return value * np.eye(4)[index]


# ----------------------------------------------------------------------------------------------------------- limits


def test_torque_is_limited_wheel_by_wheel():
    limits = np.array([0.1, 0.2, 0.3, 0.4])
    simulator = start(torque_limit=tuple(limits))
    for command in np.random.default_rng(0).uniform(-1.0, 1.0, (50, 4)):
        before = simulator.state.wheel_momentum[0].copy()
        torque, momentum = run(simulator, [command])
        np.testing.assert_array_equal(torque[0], np.clip(command, -limits, limits))
        np.testing.assert_allclose(momentum[0], before - PERIOD * torque[0], atol=1e-14)
        np.testing.assert_array_equal(simulator.measurement().last_command[0], torque[0])


def test_wheels_without_limits_give_what_is_asked():
    torque, momentum = run(start(torque_limit=None), [np.full(4, 50.0)] * 10)
    assert np.all(torque == 50.0)
    np.testing.assert_allclose(momentum[-1], -50.0)


@pytest.mark.parametrize("coupling", [True, False])
def test_momentum_never_passes_its_limit(coupling):
    limits = np.array([0.5, 1.0, 1.5, 2.0])
    faults = (
        Bias(wheel=0, amplitude=0.2, frequency=5.0),
        HardOver(wheel=1, onset=20.0, recovery=40.0),
        LockInPlace(wheel=2, onset=30.0),
        Bias(wheel=3, onset=3.0, slope=0.01, period=1.0, on_time=0.5),
    )
    simulator = start(*faults, limit=tuple(limits), coupling=coupling, count=8)
    rng = np.random.default_rng(0)
    swing = rng.uniform(0.0, 6.0, (8, 4))
    saturated = np.zeros(4, dtype=int)
    for step in range(800):
        simulator.step(0.2 * np.sin(0.05 * step + swing) + rng.uniform(-0.1, 0.1, (8, 4)))
        size = np.abs(simulator.state.wheel_momentum)
        assert np.all(size <= limits + 1e-12)
        saturated += (size >= limits - 1e-12).sum(axis=0)
    assert np.all(saturated > 20)


def test_total_momentum_is_conserved_through_saturation():
    faults = (
        HardOver(wheel=1, onset=2.0),
        LockInPlace(wheel=2, onset=3.0),
        Bias(wheel=3, onset=1.0, amplitude=0.2, frequency=4.0),
    )
    simulator = start(*faults, limit=0.5, momentum=(0.3, -0.2, 0.1, 0.4))
    before = total_momentum(simulator.state)
    _, momentum = run(simulator, np.random.default_rng(1).choice([-0.2, 0.2], (600, 1)).cumsum(axis=0).clip(-0.2, 0.2))
    assert np.abs(momentum).max() == pytest.approx(0.5, abs=1e-12)
    assert np.linalg.norm(total_momentum(simulator.state) - before) < 1e-10 * np.linalg.norm(before)


def test_a_wheel_that_reaches_its_limit_within_a_step_gives_exactly_what_is_left():
    simulator = start(limit=1.0, momentum=-0.985)
    before = total_momentum(simulator.state)
    torque, momentum = run(simulator, [np.full(4, 0.2)])  # 0.015 N m s left, 0.02 asked for
    np.testing.assert_allclose(momentum[0], -1.0, atol=1e-15)
    assert np.all(torque[0] == 0.0)
    np.testing.assert_allclose(total_momentum(simulator.state), before, atol=1e-12)


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_leaving_saturation(sign):
    simulator = start(limit=0.5)
    torque, momentum = run(simulator, [np.full(4, sign * 0.2)] * 40)
    assert np.all(torque[-1] == 0.0) and np.all(momentum[-1] == -sign * 0.5)
    torque, momentum = run(simulator, [np.full(4, -sign * 0.1)] * 5)
    np.testing.assert_array_equal(torque, np.full((5, 4), -sign * 0.1))
    np.testing.assert_allclose(momentum[-1], -sign * 0.45, atol=1e-14)


@pytest.mark.parametrize("kind", [HardOver, LockInPlace])
def test_a_stuck_wheel_runs_to_its_limit_and_then_gives_no_torque(kind):
    fault = kind(wheel=0, onset=1.0) if kind is LockInPlace else kind(wheel=0, onset=1.0, random_sign=False)
    simulator = start(fault, limit=0.5)
    torque, momentum = run(simulator, [wheel(0, 0.2)] * 10 + [wheel(0, -0.2)] * 40)
    np.testing.assert_allclose(torque[10:24, 0], 0.2)
    np.testing.assert_allclose(momentum[:25, 0], -0.02 * np.arange(1, 26), atol=1e-14)
    np.testing.assert_allclose(momentum[25:, 0], -0.5, rtol=0.0, atol=1e-12)
    assert np.all(torque[25:, 0] == 0.0)


def test_a_stuck_wheel_obeys_again_after_recovery():
    fault = HardOver(wheel=0, onset=0.0, recovery=4.0, random_sign=False)
    torque, momentum = run(start(fault, limit=0.5), [wheel(0, -0.1)] * 50)
    assert momentum[39, 0] == -0.5
    np.testing.assert_array_equal(torque[40:, 0], -0.1)
    np.testing.assert_allclose(momentum[-1, 0], -0.4, atol=1e-14)


# ----------------------------------------------------------------------------------------------------------- faults


def test_a_locked_wheel_keeps_the_torque_it_applied_just_before_the_onset():
    commands = np.random.default_rng(0).uniform(-0.2, 0.2, (30, 4))
    simulator = start(LockInPlace(wheel=1, onset=1.0, recovery=2.0), LockInPlace(wheel=2, onset=1.04))
    torque, momentum = run(simulator, commands)
    np.testing.assert_array_equal(torque[10:20, 1], commands[9, 1])  # onset between two commands: the old one
    np.testing.assert_array_equal(torque[10:, 2], commands[10, 2])  # onset within a period: that period's command
    np.testing.assert_array_equal(torque[20:, 1], commands[20:, 1])
    np.testing.assert_array_equal(torque[:, [0, 3]], commands[:, [0, 3]])
    np.testing.assert_allclose(np.diff(momentum, axis=0)[9:19, 1], -PERIOD * commands[9, 1])


def test_a_locked_wheel_keeps_the_faulty_torque_that_it_applied():
    faults = (
        LossOfEffectiveness(wheel=0, effectiveness=0.5),
        Bias(wheel=0, constant=0.03),
        LockInPlace(wheel=0, onset=1.0),
    )
    torque, _ = run(start(*faults), [wheel(0, 0.1)] * 10 + [wheel(0, -0.2)] * 10)
    np.testing.assert_allclose(torque[:, 0], 0.08, atol=1e-15)


def test_a_lock_outlasts_the_faults_that_come_after_it():
    faults = (LockInPlace(wheel=0, onset=1.0), Bias(wheel=0, onset=1.0, amplitude=0.1, frequency=3.0))
    for order in (faults, faults[::-1]):
        torque, _ = run(start(*order), [wheel(0, 0.1)] * 10 + [wheel(0, -0.2)] * 20)
        assert np.all(torque[:, 0] == 0.1)


def test_a_wheel_locked_from_the_start_gives_nothing():
    torque, _ = run(start(LockInPlace(wheel=0)), np.full((5, 4), 0.1))
    np.testing.assert_array_equal(torque, np.tile([0.0, 0.1, 0.1, 0.1], (5, 1)))


def test_a_dead_wheel_floats():
    torque, momentum = run(start(Outage(wheel=3, onset=0.5), momentum=0.7), np.full((20, 4), 0.1))
    np.testing.assert_array_equal(torque[:, 3], np.repeat([0.1, 0.0], [5, 15]))
    np.testing.assert_allclose(momentum[4:, 3], 0.65, atol=1e-15)


def test_a_bias_can_exceed_the_command_limit():
    torque, _ = run(start(Bias(wheel=0, constant=0.05)), [wheel(0, 0.5)])
    assert torque[0, 0] == pytest.approx(0.25)


@pytest.mark.parametrize(
    ("onset", "first_step"), [(0.0, 0), (0.02, 1), (0.06, 3), (0.061, 4), (0.0799, 4), (0.09, 5), (0.1, 5)]
)
def test_a_fault_takes_effect_at_the_first_physics_step_that_begins_then_or_later(onset, first_step):
    _, momentum = run(start(Bias(wheel=0, onset=onset, constant=0.1)), np.zeros((2, 4)))
    np.testing.assert_allclose(momentum[-1, 0], -0.1 * (10 - first_step) * STEP, atol=1e-15)


@pytest.mark.parametrize(("recovery", "steps"), [(0.02, 1), (0.061, 4), (0.1, 5), (0.15, 8)])
def test_a_fault_ends_at_its_recovery(recovery, steps):
    _, momentum = run(start(Bias(wheel=0, recovery=recovery, constant=0.1)), np.zeros((2, 4)))
    np.testing.assert_allclose(momentum[-1, 0], -0.1 * steps * STEP, atol=1e-15)


@pytest.mark.parametrize("event", ["onset", "recovery"])
def test_rounding_of_the_time_does_not_shift_an_event(event):
    steps = np.arange(1, 501)
    simulator = start(Bias(wheel=0, constant=0.1), count=500)
    episodes = simulator.episodes
    episodes.faults[event][:, 0, 0] = steps / 50  # decimals: sums of periods and steps miss them by an ulp or so
    simulator.reset(episodes)
    run(simulator, np.zeros((100, 4)))
    acting = 500 - steps if event == "onset" else steps
    np.testing.assert_allclose(simulator.state.wheel_momentum[:, 0], -0.1 * STEP * acting, atol=1e-12)


def test_intermittent_windows_on_the_grid_have_their_exact_length():
    fault = Bias(wheel=0, onset=0.14, period=0.3, on_time=0.08, constant=0.1, recovery=19.9)
    _, momentum = run(start(fault), np.zeros((300, 4)))
    windows = np.arange(0.14, 19.9, 0.3)
    np.testing.assert_allclose(momentum[-1, 0], -0.1 * 0.08 * len(windows), atol=1e-13)


@pytest.mark.parametrize("name", scenarios.names())
def test_drawn_faults_change_the_trajectory(name):
    scenario = scenarios.get(name)
    healthy = scenario.replace(faults=None)
    # Long enough for the first faults of every scenario.
    shape = (max(900, round(12.0 / scenario.control_period)), 60, scenario.spacecraft.wheels.count)
    ends, felt = [], None
    for variant in (scenario, healthy):
        simulator = Simulator(variant, 60)
        simulator.reset(variant.draw(0, 60))
        faults = simulator.faults.wheels
        # Friction that grows in one sense of rotation is felt once the wheel spins that way.
        struck = (faults["kind"] > 0) & (faults["kind"] != FaultKind.FRICTION_RISE)
        for command in np.random.default_rng(0).uniform(-0.2, 0.2, shape):
            simulator.step(command)
            forward = simulator.state.wheel_momentum[:, :, None] > 0.0
            rubbing = np.where(forward, faults["friction_forward"], faults["friction_backward"]) > 1.0
            struck |= rubbing & (faults["onset"] < simulator.time[:, None, None])
        ends.append(simulator.state.rate.copy())
        felt = struck.any(axis=(1, 2)) if variant is scenario else felt
    np.testing.assert_array_equal(np.any(ends[0] != ends[1], axis=1), felt)
