"""`fault_effect`, the truth for oracles and plots, against hand calculation and against the compiled plant."""

import dataclasses

import numpy as np
import pytest

from ftac_gym import scenarios
from ftac_gym.dynamics import Simulator
from ftac_gym.faults import (
    AttitudeSpike,
    Bias,
    CommandDelay,
    DriftingEffectiveness,
    FaultSchedule,
    FrictionRise,
    GyroBiasStep,
    HardOver,
    IntermittentShutdown,
    LockInPlace,
    LossOfEffectiveness,
    Outage,
    Seizure,
    StarTrackerOutage,
    fault_effect,
)
from ftac_gym.faults.table import healthy
from ftac_gym.spacecraft.friction import Friction
from ftac_gym.spacecraft.spacecraft import Spacecraft
from ftac_gym.spacecraft.wheel_array import WheelArray
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.scenario import Scenario

STEP = 0.02  # s
ONE_WHEEL = WheelArray(np.eye(3)[:, :1], 0.2)


def whole_effect_of(*faults, times, last=0.0, momentum=0.0, array=ONE_WHEEL):
    """Effect at several times on a craft with one wheel."""
    schedule, wheels = FaultSchedule(faults), array.count
    drawn = schedule.draw(np.zeros((1, schedule.uniform_count(wheels))), np.zeros((1, 0)), array.torque_limits)
    times = np.atleast_1d(np.asarray(times, dtype=float))
    drawn = drawn.take(np.zeros(len(times), dtype=int))
    spinning, applied = np.full((len(times), wheels), momentum), np.full((len(times), wheels), last)
    return fault_effect(drawn, times, array, spinning, applied)


def effect_of(*faults, times, last=0.0):
    """Effectiveness and bias of wheel 0 at several times."""
    effect = whole_effect_of(*faults, times=times, last=last)
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


def test_a_fault_grows_from_its_onset():
    times = [1.0, 2.0, 2.5, 4.0, 6.0, 50.0]
    grown = np.array([0.0, 0.0, 0.125, 0.5, 1.0, 1.0])
    fault = LossOfEffectiveness(wheel=0, onset=2.0, rise=4.0, effectiveness=0.2)
    np.testing.assert_allclose(effect_of(fault, times=times)[0], 1.0 - 0.8 * grown)
    drift = DriftingEffectiveness(wheel=0, onset=2.0, rise=4.0, effectiveness=0.2)
    np.testing.assert_allclose(effect_of(drift, times=times)[0], 1.0 - 0.8 * grown)
    bias = Bias(wheel=0, onset=2.0, rise=4.0, constant=0.1, slope=0.01)
    expected = grown * (0.1 + 0.01 * np.maximum(np.array(times) - 2.0, 0.0))
    np.testing.assert_allclose(effect_of(bias, times=times)[1], expected)


def test_a_fault_shrinks_before_its_end():
    times = [2.0, 4.0, 5.0, 7.0, 7.9, 8.0, 9.0]
    left = np.array([1.0, 1.0, 0.75, 0.25, 0.025, 0.0, 0.0])
    for end in ({"recovery": 8.0}, {"duration": 6.0}):
        fault = Outage(wheel=0, onset=2.0, fall=4.0, **end)
        np.testing.assert_allclose(effect_of(fault, times=times)[0], 1.0 - left, atol=1e-12)


def test_a_fault_may_end_before_it_is_all_there():
    times = [2.0, 4.0, 4.99, 5.0, 6.0]
    abrupt = Bias(wheel=0, onset=2.0, rise=10.0, recovery=5.0, constant=1.0)
    np.testing.assert_allclose(effect_of(abrupt, times=times)[1], [0.0, 0.2, 0.299, 0.0, 0.0])
    # Where growing and shrinking overlap, the smaller part counts.
    both = Bias(wheel=0, onset=2.0, rise=10.0, recovery=5.0, fall=2.0, constant=1.0)
    np.testing.assert_allclose(effect_of(both, times=times)[1], [0.0, 0.2, 0.005, 0.0, 0.0], atol=1e-12)
    longer = Bias(wheel=0, onset=2.0, recovery=5.0, fall=6.0, constant=1.0)
    np.testing.assert_allclose(effect_of(longer, times=times)[1], [0.5, 1.0 / 6.0, 0.01 / 6.0, 0.0, 0.0], atol=1e-12)


def test_an_intermittent_fault_goes_on_growing_while_it_rests():
    fault = Bias(wheel=0, onset=1.0, rise=4.0, period=2.0, on_time=0.5, constant=1.0)
    times = [1.0, 1.2, 1.6, 3.0, 3.4, 3.5, 5.0, 7.2, 7.5]
    np.testing.assert_allclose(effect_of(fault, times=times)[1], [0.0, 0.05, 0.0, 0.5, 0.6, 0.0, 1.0, 1.0, 0.0])


def test_the_longest_delay_of_a_wheel_counts():
    delays = (CommandDelay(wheel=0, periods=3, onset=1.0, recovery=3.0), CommandDelay(wheel=0, periods=2, onset=2.0))
    for order in (delays, delays[::-1]):
        effect = whole_effect_of(*order, times=[0.5, 1.0, 2.5, 3.0])
        np.testing.assert_array_equal(effect.delay[:, 0], [0, 3, 3, 2])
        assert np.all(effect.effectiveness == 1.0) and np.all(effect.bias == 0.0)


def test_excess_friction_is_bias():
    array = WheelArray(np.eye(3)[:, :1], 0.2, spin_inertia=0.02, friction=Friction(0.01, 0.013, viscous=1e-4))
    for momentum, factor in ((2.0, 5.0), (-2.0, 3.0)):
        dry = array.frictions[0].dry(momentum / 0.02)
        forward = FrictionRise(wheel=0, onset=1.0, rise=4.0, factor=5.0, direction="forward")
        backward = FrictionRise(wheel=0, onset=1.0, rise=4.0, factor=3.0, direction="backward")
        both = FrictionRise(wheel=0, onset=1.0, rise=0.0, factor=2.0)
        effect = whole_effect_of(forward, backward, times=[0.5, 3.0, 9.0], momentum=momentum, array=array)
        np.testing.assert_allclose(effect.bias[:, 0], [0.0, 0.5 * (factor - 1.0) * dry, (factor - 1.0) * dry])
        layered = whole_effect_of(forward, backward, both, times=9.0, momentum=momentum, array=array)
        np.testing.assert_allclose(layered.bias[0, 0], (2.0 * factor - 1.0) * dry)
        assert np.sign(effect.bias[-1, 0]) == np.sign(momentum)  # drag slows the wheel and pushes the body along


def test_a_seized_wheel_cannot_change_its_torque():
    effectiveness, bias = effect_of(Seizure(wheel=0, onset=1.0), times=[0.5, 1.0, 9.0], last=-0.07)
    np.testing.assert_array_equal(effectiveness, [1.0, 0.0, 0.0])
    np.testing.assert_array_equal(bias, [0.0, -0.07, -0.07])


def test_faults_of_the_sensors_add_up():
    gyro = GyroBiasStep(onset=1.0, rise=2.0, size=0.01), GyroBiasStep(onset=2.0, recovery=4.0, size=0.03)
    spike = AttitudeSpike(onset=1.0, period=1.0, on_time=0.5, angle=0.4)
    out = StarTrackerOutage(onset=2.0, duration=1.5)
    effect = whole_effect_of(*gyro, spike, out, times=[0.5, 2.0, 2.75, 3.0, 4.5])
    # All directions are the same here: uniform deviates of zero.
    np.testing.assert_allclose(np.linalg.norm(effect.rate_bias, axis=1), [0.0, 0.035, 0.03875, 0.04, 0.01])
    np.testing.assert_allclose(np.linalg.norm(effect.attitude_turn, axis=1), [0.0, 0.4, 0.0, 0.4, 0.0])
    np.testing.assert_array_equal(effect.star_tracker_out, [False, True, True, True, False])
    assert np.all(effect.effectiveness == 1.0) and np.all(effect.bias == 0.0)


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
        # A late command is the one of ``delay`` periods ago; before the first there was none.
        sent = np.take_along_axis(commands, np.maximum(step - effect.delay, 0)[None], axis=0)[0]
        sent = np.where(effect.delay > step, 0.0, sent)
        expected = effect.effectiveness * np.clip(sent, -limits, limits) + effect.bias
        np.testing.assert_allclose(simulator.state.wheel_torque, expected, rtol=0.0, atol=2e-8)


def craft(*faults, **wheels):
    array = WheelArray(WheelArray.sign_pyramid(0.2, None).axes, 0.2, **wheels)
    return Scenario(
        name="faults",
        spacecraft=Spacecraft(np.diag([10.0, 12.0, 14.0]), array),
        initial_state=InitialState.fixed(wheel_momentum=(3.0, -3.0, 3.0, -3.0)),
        faults=FaultSchedule(faults),
        control_period=STEP,
        physics_step=STEP,
        duration=20.0,
    )


def on_the_grid(episodes):
    """Move all times onto the grid of the physics steps."""
    faults, switches = episodes.faults.copy(), np.round(episodes.switches / STEP) * STEP
    for name in ("onset", "recovery", "period", "on_time", "rise", "fall"):
        faults[name] = np.round(faults[name] / STEP) * STEP
    return dataclasses.replace(episodes, faults=faults, switches=switches)


def test_effect_is_what_the_plant_does_while_faults_grow_and_shrink():
    scenario = craft(
        LossOfEffectiveness(wheel=0, onset=(0.2, 0.6), rise=(0.5, 1.5), effectiveness=0.1),
        LossOfEffectiveness(wheel=0, rise=1.0, duration=2.5, fall=1.0, effectiveness=0.5, amplitude=0.4, frequency=3.0),
        Outage(wheel=1, onset=0.4, duration=(0.5, 2.0), rise=(0.5, 2.0), fall=(0.5, 2.0)),  # it may end too early
        Bias(wheel=1, onset=0.3, rise=1.0, constant=0.05, slope=0.02, recovery=2.6, fall=0.6),
        DriftingEffectiveness(wheel=2, onset=(0.1, 1.0), rise=(0.5, 2.0), effectiveness=(0.0, 0.5)),
        Bias(wheel=2, rise=2.0, amplitude=0.1, frequency=3.0, exponent=0.5, period=0.5, on_time=0.3),
        HardOver(wheel=3, onset=0.3, rise=1.2, fraction=(-1.0, 1.0), recovery=2.0, fall=0.4),
    )
    commands = np.random.default_rng(0).uniform(-0.3, 0.3, (150, 20, 4))
    assert_plant_agrees(scenario, on_the_grid(scenario.draw(3, 20)), commands)


def test_effect_is_what_the_plant_does_while_faults_come_and_go_at_random():
    chain = {"mean_acting": 1.0, "mean_resting": 0.5}
    scenario = craft(
        IntermittentShutdown(wheel=0, onset=(0.2, 0.6), **chain),
        Bias(wheel=0, onset=0.5, constant=0.05, **chain),
        Bias(wheel=1, slope=0.02, rise=2.0, duration=3.5, fall=1.0, **chain),
        LossOfEffectiveness(wheel=1, effectiveness=0.5, onset=0.7),
        LockInPlace(wheel=2, onset=0.3, **chain),
        Outage(wheel=2, onset=2.0, duration=1.0),
        CommandDelay(wheel=3, onset=(0.2, 0.9), periods=(1, 5), **chain),
        HardOver(wheel=3, onset=1.0, fraction=0.4, **chain),
    )
    commands = np.random.default_rng(0).uniform(-0.3, 0.3, (200, 30, 4))
    assert_plant_agrees(scenario, on_the_grid(scenario.draw(3, 30)), commands)


def test_effect_is_what_the_plant_does_with_late_commands():
    scenario = craft(
        CommandDelay(wheel=0, periods=(1, 5)),  # from the start: at first there are no commands
        CommandDelay(wheel=1, onset=(0.1, 1.0), periods=(1, 3), recovery=2.0),
        CommandDelay(wheel=1, onset=(0.1, 1.5), periods=(2, 5), period=0.4, on_time=0.2),
        CommandDelay(wheel=2, onset=0.5, periods=4),
        LossOfEffectiveness(wheel=2, onset=0.2, rise=1.0, effectiveness=0.3),
        CommandDelay(wheel=3, onset=0.5, periods=5),
        LockInPlace(wheel=3, onset=1.0, duration=0.5),
    )
    commands = np.random.default_rng(0).uniform(-0.3, 0.3, (120, 20, 4))
    assert_plant_agrees(scenario, on_the_grid(scenario.draw(3, 20)), commands)


def test_effect_is_what_the_plant_does_while_friction_grows():
    friction = Friction(0.01, 0.012, viscous=1e-4)
    scenario = craft(
        FrictionRise(wheel=0, onset=0.4, rise=1.0, factor=(2.0, 9.0)),
        FrictionRise(wheel=0, onset=0.7, rise=0.5, factor=3.0, duration=1.0),
        FrictionRise(wheel=1, onset=0.2, rise=0.0, factor=5.0, direction="either"),
        FrictionRise(wheel=2, onset=0.2, rise=1.0, factor=5.0, recovery=1.6, fall=1.0),
        LossOfEffectiveness(wheel=3, onset=0.3, effectiveness=0.5),
        spin_inertia=0.02,
        friction=friction,
    )
    episodes, wheels = on_the_grid(scenario.draw(3, 10)), scenario.spacecraft.wheels
    simulator, none = Simulator(scenario, 10), np.zeros((10, 4))
    simulator.reset(episodes)
    for step, command in enumerate(np.random.default_rng(0).uniform(-0.2, 0.2, (120, 10, 4))):
        simulator.step(command)
        # The wheels spin fast enough that the dry part is constant; its factor is that of the middle of a step.
        momentum = simulator.state.wheel_momentum
        effect = fault_effect(simulator.faults, np.full(10, (step + 0.5) * STEP), wheels, momentum, none)
        expected = effect.effectiveness * command + effect.bias + friction.torque(momentum / 0.02)
        np.testing.assert_allclose(simulator.state.wheel_torque, expected, rtol=0.0, atol=1e-12)


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
    for name in ("onset", "recovery", "period", "on_time", "rise", "fall"):  # Earlier, so that they all act.
        faults[name] *= 0.2
    commands = np.random.default_rng(1).uniform(-0.2, 0.2, (1000, 200, 4))
    assert_plant_agrees(scenario, on_the_grid(dataclasses.replace(episodes, faults=faults)), commands)
