"""`fault_effect`, the truth for oracles and plots, against flights of the compiled plant."""

import dataclasses

import numpy as np

from ftac_gym import faults, scenarios
from ftac_gym.dynamics import Simulator
from ftac_gym.spacecraft import Friction, Spacecraft, WheelArray
from ftac_gym.task import InitialState, Scenario

STEP = 0.02  # s


def assert_plant_agrees(scenario, episodes, commands):
    """Compare the predicted torque at the end of each physics step with what the plant applied."""
    simulator = Simulator(scenario, len(episodes))
    simulator.reset(episodes)
    limits = scenario.spacecraft.wheels.torque_limits
    for step, command in enumerate(commands):
        last = simulator.state.wheel_torque.copy()
        # Which faults act is decided at the start of a step, so look just before its end.
        moment = np.full(len(episodes), (step + 1) * STEP - 1e-8)
        effect = faults.fault_effect(
            simulator.faults, moment, scenario.spacecraft.wheels, simulator.state.wheel_momentum, last
        )
        simulator.step(command)
        # A late command is the one of ``delay`` periods ago; before the first there was none.
        sent = np.take_along_axis(commands, np.maximum(step - effect.delay, 0)[None], axis=0)[0]
        sent = np.where(effect.delay > step, 0.0, sent)
        expected = effect.effectiveness * np.clip(sent, -limits, limits) + effect.bias
        np.testing.assert_allclose(simulator.state.wheel_torque, expected, rtol=0.0, atol=2e-8)


def faulty_scenario(*listed, **wheels):
    array = WheelArray(WheelArray.sign_pyramid(0.2, None).axes, 0.2, **wheels)
    return Scenario(
        name="faults",
        spacecraft=Spacecraft(np.diag([10.0, 12.0, 14.0]), array),
        initial_state=InitialState.fixed(wheel_momentum=(3.0, -3.0, 3.0, -3.0)),
        faults=faults.FaultSchedule(listed),
        control_period=STEP,
        physics_step=STEP,
        duration=20.0,
    )


def on_the_grid(episodes):
    """Move all times onto the grid of the physics steps."""
    listed, switches = episodes.faults.copy(), np.round(episodes.switches / STEP) * STEP
    for name in ("onset", "recovery", "period", "on_time", "rise", "fall"):
        listed[name] = np.round(listed[name] / STEP) * STEP
    return dataclasses.replace(episodes, faults=listed, switches=switches)


def test_effect_is_what_the_plant_does_while_faults_grow_and_shrink():
    scenario = faulty_scenario(
        faults.LossOfEffectiveness(wheel=0, onset=(0.2, 0.6), rise=(0.5, 1.5), effectiveness=0.1),
        faults.LossOfEffectiveness(
            wheel=0, rise=1.0, duration=2.5, fall=1.0, effectiveness=0.5, amplitude=0.4, frequency=3.0
        ),
        faults.Outage(
            wheel=1, onset=0.4, duration=(0.5, 2.0), rise=(0.5, 2.0), fall=(0.5, 2.0)
        ),  # it may end too early
        faults.Bias(wheel=1, onset=0.3, rise=1.0, constant=0.05, slope=0.02, recovery=2.6, fall=0.6),
        faults.DriftingEffectiveness(wheel=2, onset=(0.1, 1.0), rise=(0.5, 2.0), effectiveness=(0.0, 0.5)),
        faults.Bias(wheel=2, rise=2.0, amplitude=0.1, frequency=3.0, exponent=0.5, period=0.5, on_time=0.3),
        faults.HardOver(wheel=3, onset=0.3, rise=1.2, fraction=(-1.0, 1.0), recovery=2.0, fall=0.4),
    )
    commands = np.random.default_rng(0).uniform(-0.3, 0.3, (150, 20, 4))
    assert_plant_agrees(scenario, on_the_grid(scenario.draw(3, 20)), commands)


def test_effect_is_what_the_plant_does_while_faults_come_and_go_at_random():
    chain = {"mean_acting": 1.0, "mean_resting": 0.5}
    scenario = faulty_scenario(
        faults.IntermittentShutdown(wheel=0, onset=(0.2, 0.6), **chain),
        faults.Bias(wheel=0, onset=0.5, constant=0.05, **chain),
        faults.Bias(wheel=1, slope=0.02, rise=2.0, duration=3.5, fall=1.0, **chain),
        faults.LossOfEffectiveness(wheel=1, effectiveness=0.5, onset=0.7),
        faults.LockInPlace(wheel=2, onset=0.3, **chain),
        faults.Outage(wheel=2, onset=2.0, duration=1.0),
        faults.CommandDelay(wheel=3, onset=(0.2, 0.9), periods=(1, 5), **chain),
        faults.HardOver(wheel=3, onset=1.0, fraction=0.4, **chain),
    )
    commands = np.random.default_rng(0).uniform(-0.3, 0.3, (200, 30, 4))
    assert_plant_agrees(scenario, on_the_grid(scenario.draw(3, 30)), commands)


def test_effect_is_what_the_plant_does_with_late_commands():
    scenario = faulty_scenario(
        faults.CommandDelay(wheel=0, periods=(1, 5)),  # from the start: at first there are no commands
        faults.CommandDelay(wheel=1, onset=(0.1, 1.0), periods=(1, 3), recovery=2.0),
        faults.CommandDelay(wheel=1, onset=(0.1, 1.5), periods=(2, 5), period=0.4, on_time=0.2),
        faults.CommandDelay(wheel=2, onset=0.5, periods=4),
        faults.LossOfEffectiveness(wheel=2, onset=0.2, rise=1.0, effectiveness=0.3),
        faults.CommandDelay(wheel=3, onset=0.5, periods=5),
        faults.LockInPlace(wheel=3, onset=1.0, duration=0.5),
    )
    commands = np.random.default_rng(0).uniform(-0.3, 0.3, (120, 20, 4))
    assert_plant_agrees(scenario, on_the_grid(scenario.draw(3, 20)), commands)


def test_effect_is_what_the_plant_does_while_friction_grows():
    friction = Friction(0.01, 0.012, viscous=1e-4)
    scenario = faulty_scenario(
        faults.FrictionRise(wheel=0, onset=0.4, rise=1.0, factor=(2.0, 9.0)),
        faults.FrictionRise(wheel=0, onset=0.7, rise=0.5, factor=3.0, duration=1.0),
        faults.FrictionRise(wheel=1, onset=0.2, rise=0.0, factor=5.0, direction="either"),
        faults.FrictionRise(wheel=2, onset=0.2, rise=1.0, factor=5.0, recovery=1.6, fall=1.0),
        faults.LossOfEffectiveness(wheel=3, onset=0.3, effectiveness=0.5),
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
        effect = faults.fault_effect(simulator.faults, np.full(10, (step + 0.5) * STEP), wheels, momentum, none)
        expected = effect.effectiveness * command + effect.bias + friction.torque(momentum / 0.02)
        np.testing.assert_allclose(simulator.state.wheel_torque, expected, rtol=0.0, atol=1e-12)


def test_effect_is_what_the_plant_does_for_every_kind():
    listed = (
        faults.LossOfEffectiveness(wheel=0, onset=0.4, effectiveness=0.3),
        faults.LossOfEffectiveness(wheel=0, onset=1.0, effectiveness=0.6, amplitude=0.4, frequency=2.0, phase=0.3),
        faults.Bias(wheel=0, onset=0.8, constant=0.02, period=0.3, on_time=0.1),
        faults.Bias(wheel=1, onset=0.5, recovery=1.5, constant=0.05, slope=0.02),
        faults.Bias(wheel=1, onset=1.0, amplitude=0.1, frequency=3.0, phase=0.4, exponent=0.5),
        faults.LockInPlace(wheel=2, onset=0.7, period=0.6, on_time=0.3),
        faults.Outage(wheel=2, onset=2.4, recovery=2.6),
        faults.HardOver(wheel=3, onset=0.3, fraction=(-1.0, 1.0), recovery=0.9),
        faults.Outage(wheel=3, onset=1.1),
    )
    scenario = Scenario(
        name="faults",
        spacecraft=Spacecraft(np.diag([10.0, 12.0, 14.0]), WheelArray.sign_pyramid(0.2, None)),
        initial_state=InitialState.fixed(),
        faults=faults.FaultSchedule(listed),
        control_period=STEP,
        physics_step=STEP,
    )
    commands = np.random.default_rng(0).uniform(-0.3, 0.3, (150, 5, 4))
    assert_plant_agrees(scenario, scenario.draw(3, 5), commands)


def test_effect_is_what_the_plant_does_on_the_flagship():
    scenario = scenarios.get("flagship").replace(control_period=STEP, physics_step=STEP, loop_delay=0.0)
    episodes = scenario.draw(0, 200)
    listed = episodes.faults.copy()
    for name in ("onset", "recovery", "period", "on_time", "rise", "fall"):  # Earlier, so that they all act.
        listed[name] *= 0.2
    commands = np.random.default_rng(1).uniform(-0.2, 0.2, (1000, 200, 4))
    assert_plant_agrees(scenario, on_the_grid(dataclasses.replace(episodes, faults=listed)), commands)
