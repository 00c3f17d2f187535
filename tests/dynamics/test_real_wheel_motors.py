"""Motors of real wheels in the plant: lag, dead-band, power limit, speed limit, and wheels that differ."""

import numpy as np
import pytest
from helpers.wheels import LIMIT, SPIN, run
from helpers.wheels import one_axis as start
from scipy.integrate import solve_ivp

from ftac_gym.faults import DriftingEffectiveness, FrictionRise, HardOver, LossOfEffectiveness
from ftac_gym.spacecraft.friction import Friction

# -------------------------------------------------------------------------------------------------------------- lag


@pytest.mark.parametrize(("step", "period"), [(0.02, 0.1), (0.1, 0.1), (0.001, 0.1), (0.5, 0.5)])
@pytest.mark.parametrize("lag", [0.05, 0.7, 1e-3])
def test_a_lag_answers_exponentially_whatever_the_step(lag, step, period):
    simulator = start(1, step=step, period=period, lag=lag)
    motor, stored = 0.0, 0.0
    for command in np.random.default_rng(0).uniform(-0.3, 0.3, 30):
        torque, momentum = run(simulator, [command])
        limited = np.clip(command, -LIMIT, LIMIT)
        left = np.exp(-period / lag)
        stored -= limited * period - (limited - motor) * lag * (1.0 - left)
        motor = limited - (limited - motor) * left
        assert torque[0, 0] == pytest.approx(motor, abs=1e-14)
        assert simulator.state.motor_torque[0, 0] == pytest.approx(motor, abs=1e-14)
        assert momentum[0, 0] == pytest.approx(stored, abs=1e-13)


@pytest.mark.parametrize("lag", [1e-4, 1e-6, 1e-12])
def test_a_lag_far_below_the_step_is_next_to_none(lag):
    commands = np.random.default_rng(0).uniform(-0.2, 0.2, 30)
    torque, momentum = run(start(1, lag=lag), commands)
    np.testing.assert_allclose(torque[:, 0], commands, rtol=1e-12)
    assert np.abs(momentum[:, 0] + 0.1 * np.cumsum(commands)).max() <= 0.2 * lag + 1e-15


def test_a_lag_has_unit_gain_in_the_end():
    torque, _ = run(start(2, lag=(0.05, 0.3)), np.tile([0.123, -0.05], (200, 1)))
    np.testing.assert_allclose(torque[-1], [0.123, -0.05], rtol=1e-15)


@pytest.mark.parametrize("viscous", [0.0, 4e-3])
def test_a_lag_under_varying_effectiveness(viscous):
    faults = (
        LossOfEffectiveness(wheel=0, effectiveness=0.5, amplitude=0.4, frequency=3.0, phase=0.3),
        DriftingEffectiveness(wheel=1, onset=1.0, effectiveness=0.2, rise=3.0),
    )
    lag, command = np.array([0.3, 0.5]), 0.15
    friction = Friction(viscous=viscous) if viscous else None
    simulator = start(2, *faults, momentum=1.0, step=0.01, lag=lag, spin_inertia=SPIN, friction=friction)
    torque, momentum = run(simulator, np.full((50, 1), command))

    def derivative(time, state):
        motor, stored = state[:2], state[2:]
        share = np.array([0.5 + 0.4 * np.sin(3.0 * time + 0.3), 1.0 - 0.8 * np.clip((time - 1.0) / 3.0, 0.0, 1.0)])
        return np.concatenate([(command - motor) / lag, -share * motor - viscous / SPIN * stored])

    solution = solve_ivp(
        derivative, (0.0, 5.0), [0.0, 0.0, 1.0, 1.0], "DOP853", 0.1 * np.arange(1, 51), rtol=1e-12, atol=1e-13,
        max_step=0.05,
    )  # fmt: skip
    np.testing.assert_allclose(momentum, solution.y[2:].T, rtol=0.0, atol=1e-9)
    share = np.array([0.5 + 0.4 * np.sin(15.3), 0.2])
    expected = share * solution.y[:2, -1] + viscous / SPIN * solution.y[2:, -1]
    np.testing.assert_allclose(torque[-1], expected, rtol=0.0, atol=1e-9)


# ----------------------------------------------------------------------------------------------------------- limits


def test_the_dead_band_swallows_small_commands_and_nothing_else():
    commands = np.array([0.0, 0.0099, 0.01, 0.0101, -0.0099, -0.01, -0.15, 0.5, -0.5])
    torque, _ = run(start(1, dead_band=0.01), commands)
    np.testing.assert_array_equal(torque[:, 0], [0.0, 0.0, 0.01, 0.0101, 0.0, -0.01, -0.15, 0.2, -0.2])


def test_the_torque_limit_comes_before_the_dead_band():
    torque, momentum = run(start(2, dead_band=(0.2, 0.201)), np.full((5, 1), 3.0))
    np.testing.assert_array_equal(torque, np.tile([0.2, 0.0], (5, 1)))
    np.testing.assert_array_equal(momentum[:, 1], 0.0)


def test_the_dead_band_comes_before_the_lag():
    torque, _ = run(start(1, dead_band=0.01, lag=0.2), [0.2] * 20 + [0.009] * 20)
    np.testing.assert_allclose(torque[20:, 0], torque[19, 0] * np.exp(-0.5 * np.arange(1, 21)), rtol=1e-12)


def test_the_dead_band_looks_at_the_command_not_at_the_fault():
    fault = LossOfEffectiveness(wheel=0, effectiveness=0.1)
    torque, _ = run(start(1, fault, dead_band=0.01), [0.02, 0.009])
    np.testing.assert_allclose(torque[:, 0], [0.002, 0.0])


@pytest.mark.parametrize("step", [0.1, 0.02, 0.005])
def test_constant_power(step):
    power = 1.0  # W: the limit takes over at 5 rad/s
    simulator = start(1, step=step, power_limit=power, spin_inertia=SPIN)
    torque, momentum = run(simulator, np.full((200, 1), -0.2))
    time = 0.1 * np.arange(1, 201)
    corner = power * SPIN / 0.2
    expected = np.sqrt(corner**2 + 2.0 * power * SPIN * np.maximum(time - corner / 0.2, 0.0))
    expected = np.where(0.2 * time < corner, 0.2 * time, expected)
    np.testing.assert_allclose(momentum[:, 0], expected, rtol=1e-4 * step / 0.02)
    np.testing.assert_allclose(torque[10:] * momentum[10:] / SPIN, -power, rtol=1e-12)
    # The way back is the same: the limit holds for braking too.
    torque, back = run(simulator, np.full((200, 1), 0.2))
    np.testing.assert_allclose(back[:-1, 0], momentum[-2::-1, 0], atol=2e-4 * step / 0.02)
    assert abs(back[-1, 0]) < 1e-3


def test_the_power_limit_is_never_exceeded():
    friction = Friction(coulomb=2e-3, breakaway=4e-3, viscous=1e-5)
    power = np.array([0.5, 1.0, 2.0, 5.0])
    simulator = start(
        4,
        HardOver(wheel=0, onset=2.0, recovery=20.0, random_sign=False),
        HardOver(wheel=1, onset=15.0, fraction=-0.9, random_sign=False),
        FrictionRise(wheel=2, factor=5.0, rise=10.0),
        power_limit=power,
        spin_inertia=SPIN,
        friction=friction,
        lag=0.05,
    )
    limited = np.zeros(4, dtype=int)
    for step in range(400):
        torque, momentum = run(simulator, 0.2 * np.sign(np.sin(0.02 * step + np.arange(4))))
        speed = momentum[0] / SPIN
        factor = np.array([1.0, 1.0, 1.0 + 4.0 * np.clip((0.1 * (step + 1) - 0.01) / 10.0, 0.0, 1.0), 1.0])
        drag = factor * friction.dry(speed) + 1e-5 * speed
        used = np.abs((torque[0] - drag) * speed)
        assert np.all(used <= power * (1.0 + 1e-9))
        limited += used > 0.999 * power
    assert np.all(limited > 50)


def test_the_speed_limit_blocks_what_accelerates_and_nothing_else():
    friction = Friction(coulomb=2e-3)
    simulator = start(2, momentum=(0.9, -0.9), spin_inertia=SPIN, speed_limit=50.0, friction=friction, lag=0.05)
    torque, momentum = run(simulator, np.tile([-0.2, 0.2], (30, 1)))
    assert np.abs(momentum).max() <= 1.0  # N m s
    np.testing.assert_array_equal(momentum[-1], [1.0, -1.0])
    np.testing.assert_array_equal(torque[-1], 0.0)
    # With no command, friction slows it as soon as the motor has died down below it.
    torque, momentum = run(simulator, np.zeros((20, 1)))
    np.testing.assert_allclose(torque[-1], [2e-3, -2e-3], rtol=1e-9)
    assert np.all(np.abs(momentum[-1]) < 1.0)
    # It may be braked at once.
    simulator = start(2, momentum=(1.0, -1.0), spin_inertia=SPIN, speed_limit=50.0, friction=friction)
    torque, momentum = run(simulator, [[0.1, -0.1]])
    np.testing.assert_allclose(torque[0], [0.102, -0.102], rtol=1e-14)
    np.testing.assert_allclose(momentum[0], [0.9898, -0.9898], rtol=1e-14)


def test_speed_and_momentum_limit_hold_together():
    simulator = start(2, spin_inertia=(0.02, 0.01), speed_limit=(50.0, 30.0), momentum_limit=(0.8, 0.8))
    _, momentum = run(simulator, np.full((60, 1), 0.2))
    np.testing.assert_array_equal(momentum[-1], [-0.8, -0.3])


# --------------------------------------------------------------------------------------------------- wheel by wheel


def test_wheels_of_one_array_may_differ():
    friction = Friction(coulomb=2e-3, breakaway=4e-3, viscous=1e-4)
    common = {"lag": (1e-9, 1e-9, 0.3), "spin_inertia": (0.02, 0.03, 0.04), "dead_band": (1e-9, 1e-9, 0.05)}
    commands = np.random.default_rng(0).uniform(-0.2, 0.2, (60, 3))
    together = run(start(3, momentum=(0.1, 0.2, 0.3), friction=(None, friction, None), **common), commands)
    alone = (
        run(start(1, momentum=0.1), commands[:, :1]),
        run(start(1, momentum=0.2, friction=friction, spin_inertia=0.03), commands[:, 1:2]),
        run(start(1, momentum=0.3, lag=0.3, dead_band=0.05), commands[:, 2:]),
    )
    for wheel, single in enumerate(alone):
        for of_three, of_one in zip(together, single, strict=True):
            np.testing.assert_allclose(of_three[:, wheel], of_one[:, 0], rtol=0.0, atol=1e-14)


def test_without_effects_a_wheel_is_ideal_bit_for_bit():
    commands = np.random.default_rng(0).uniform(-0.3, 0.3, (60, 3))
    faults = (HardOver(wheel=0, onset=1.03, recovery=3.0), LossOfEffectiveness(wheel=1, onset=0.51, amplitude=0.3))
    ideal = run(start(3, *faults, momentum=0.1, momentum_limit=0.4), commands)
    bare = {"momentum_limit": 0.4, "spin_inertia": 0.02, "speed_limit": 30.0, "friction": (None, None, None)}
    for first, second in zip(ideal, run(start(3, *faults, momentum=0.1, **bare), commands), strict=True):
        np.testing.assert_array_equal(first, second)
    # Effects that are there but never bite are the same to rounding.
    mild = {**bare, "friction": Friction(), "lag": 1e-9, "dead_band": 1e-300, "power_limit": 1e9}
    for first, second in zip(ideal, run(start(3, *faults, momentum=0.1, **mild), commands), strict=True):
        np.testing.assert_allclose(first, second, rtol=0.0, atol=1e-14)
