"""`fault_effect`, the truth for oracles and plots, against hand calculation and against the compiled plant."""

import dataclasses

import numpy as np
import pytest

from ftac_gym import scenarios
from ftac_gym.dynamics import Simulator
from ftac_gym.faults import (
    Bias,
    FaultSchedule,
    HardOver,
    LockInPlace,
    LossOfEffectiveness,
    Outage,
    fault_effect,
)
from ftac_gym.faults.table import healthy
from ftac_gym.initial_state import InitialState
from ftac_gym.scenario import Scenario
from ftac_gym.spacecraft import Spacecraft
from ftac_gym.wheels import WheelArray

STEP = 0.02  # s


def effect_of(*faults, times, last=0.0, wheels=1):
    """Effectiveness and bias of wheel 0 at several times."""
    schedule = FaultSchedule(faults)
    drawn = schedule.draw(np.zeros((1, schedule.uniform_count(wheels))), np.zeros((1, 0)), np.full(wheels, 0.2))
    times = np.atleast_1d(np.asarray(times, dtype=float))
    drawn = drawn.take(np.zeros(len(times), dtype=int))
    still, applied = np.zeros((len(times), wheels)), np.full((len(times), wheels), last)
    effect = fault_effect(drawn, times, WheelArray(np.eye(3)[:, :wheels], 0.2), still, applied)
    return effect.effectiveness[:, 0], effect.bias[:, 0]


def test_healthy_wheels_obey():
    wheels, times = WheelArray.sign_pyramid(0.2, None), np.array([0.0, 1.0, 1e6])
    effect = fault_effect(healthy(3, 4), times, wheels, np.ones((3, 4)), np.ones((3, 4)))
    assert np.all(effect.effectiveness == 1.0) and np.all(effect.bias == 0.0) and np.all(effect.delay == 0)
    assert np.all(effect.rate_bias == 0.0) and np.all(effect.attitude_turn == 0.0)
    assert not effect.star_tracker_out.any()


def test_a_fault_acts_from_onset_to_recovery():
    times = [0.0, 1.98, 2.0, 2.5, 2.98, 3.0, 9.0]
    effectiveness, bias = effect_of(Bias(wheel=0, onset=2.0, recovery=3.0, constant=0.1), times=times)
    np.testing.assert_allclose(bias, [0.0, 0.0, 0.1, 0.1, 0.1, 0.0, 0.0])
    assert np.all(effectiveness == 1.0)


def test_an_intermittent_fault_acts_at_the_start_of_each_period():
    fault = Outage(wheel=0, onset=1.0, period=0.5, on_time=0.2, recovery=2.1)
    times = [0.9, 1.0, 1.1, 1.2, 1.4, 1.5, 1.68, 1.7, 2.0, 2.1]
    np.testing.assert_allclose(effect_of(fault, times=times)[0], [1, 0, 0, 1, 1, 0, 0, 1, 0, 1])


def test_rounding_of_the_time_does_not_shift_an_event():
    fault = Outage(wheel=0, onset=0.3, period=0.1, on_time=0.05)
    times = np.arange(31, 60) * 0.1  # 0.30000000000000004 and the like
    assert np.all(effect_of(fault, times=times)[0] == 0.0)


def test_effectiveness_swings_with_the_time_of_the_episode():
    fault = LossOfEffectiveness(wheel=0, onset=2.0, effectiveness=0.6, amplitude=0.3, frequency=0.7, phase=0.4)
    times = np.array([1.0, 2.0, 5.5])
    expected = np.where(times < 2.0, 1.0, 0.6 + 0.3 * np.sin(0.7 * times + 0.4))
    np.testing.assert_allclose(effect_of(fault, times=times)[0], expected)


def test_bias_grows_and_swings_with_the_time_since_onset():
    fault = Bias(wheel=0, onset=2.0, constant=0.01, slope=0.002, amplitude=0.3, exponent=1.5, frequency=0.7, phase=0.4)
    times = np.array([1.0, 2.0, 5.5])
    since = np.maximum(times - 2.0, 0.0)
    expected = np.where(times < 2.0, 0.0, 0.01 + 0.002 * since + 0.3 * since**1.5 * np.sin(0.7 * since + 0.4))
    np.testing.assert_allclose(effect_of(fault, times=times)[1], expected)


def test_layers_multiply_their_effectiveness_and_add_their_bias():
    effectiveness, bias = effect_of(
        LossOfEffectiveness(wheel=0, effectiveness=0.5),
        LossOfEffectiveness(wheel=0, effectiveness=0.4),
        Bias(wheel=0, constant=0.1),
        Bias(wheel=0, constant=-0.03),
        times=1.0,
    )
    np.testing.assert_allclose([effectiveness[0], bias[0]], [0.2, 0.07])


def test_a_locked_wheel_repeats_its_torque_whatever_else_is_wrong():
    effectiveness, bias = effect_of(LockInPlace(wheel=0), Bias(wheel=0, constant=0.1), times=1.0, last=-0.07)
    assert effectiveness[0] == 0.0 and bias[0] == -0.07


def test_hard_over_ignores_the_command():
    effectiveness, bias = effect_of(HardOver(wheel=0, fraction=0.5, random_sign=False), times=1.0)
    assert effectiveness[0] == 0.0 and bias[0] == pytest.approx(0.1)


def assert_plant_agrees(scenario, episodes, commands):
    """Compare the predicted torque at the end of each physics step with what the plant applied."""
    simulator = Simulator(scenario, len(episodes))
    simulator.reset(episodes)
    limits = scenario.spacecraft.wheels.torque_limits
    for step, command in enumerate(commands):
        last = simulator.state.wheel_torque.copy()
        # Which faults act is decided at the start of a step, so look just before its end.
        moment = np.full(len(episodes), (step + 1) * STEP - 1e-8)
        effect = fault_effect(
            simulator.faults, moment, scenario.spacecraft.wheels, simulator.state.wheel_momentum, last
        )
        simulator.step(command)
        expected = effect.effectiveness * np.clip(command, -limits, limits) + effect.bias
        np.testing.assert_allclose(simulator.state.wheel_torque, expected, rtol=0.0, atol=2e-8)


def test_effect_is_what_the_plant_does_for_every_kind():
    faults = (
        LossOfEffectiveness(wheel=0, onset=0.4, effectiveness=0.3),
        LossOfEffectiveness(wheel=0, onset=1.0, effectiveness=0.6, amplitude=0.4, frequency=2.0, phase=0.3),
        Bias(wheel=0, onset=0.8, constant=0.02, period=0.3, on_time=0.1),
        Bias(wheel=1, onset=0.5, recovery=1.5, constant=0.05, slope=0.02),
        Bias(wheel=1, onset=1.0, amplitude=0.1, frequency=3.0, phase=0.4, exponent=0.5),
        LockInPlace(wheel=2, onset=0.7, period=0.6, on_time=0.3),
        Outage(wheel=2, onset=2.4, recovery=2.6),
        HardOver(wheel=3, onset=0.3, fraction=(-1.0, 1.0), recovery=0.9),
        Outage(wheel=3, onset=1.1),
    )
    scenario = Scenario(
        name="faults",
        spacecraft=Spacecraft(np.diag([10.0, 12.0, 14.0]), WheelArray.sign_pyramid(0.2, None)),
        initial_state=InitialState.fixed(),
        faults=FaultSchedule(faults),
        control_period=STEP,
        physics_step=STEP,
    )
    commands = np.random.default_rng(0).uniform(-0.3, 0.3, (150, 5, 4))
    assert_plant_agrees(scenario, scenario.draw(3, 5), commands)


def test_effect_is_what_the_plant_does_on_the_flagship():
    scenario = scenarios.get("flagship").replace(control_period=STEP, physics_step=STEP)
    episodes = scenario.draw(0, 200)
    faults = episodes.faults.copy()
    for name in ("onset", "period", "on_time"):  # Earlier, and onto the grid of the physics steps.
        faults[name] = np.round(0.2 * faults[name] / STEP) * STEP
    commands = np.random.default_rng(1).uniform(-0.2, 0.2, (1000, 200, 4))
    assert_plant_agrees(scenario, dataclasses.replace(episodes, faults=faults), commands)
