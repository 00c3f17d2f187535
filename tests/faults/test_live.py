"""Faults that come and go while an episode runs."""

from dataclasses import replace

import numpy as np
import pytest

from ftac_gym import Simulator, baselines, scenarios
from ftac_gym.faults import (
    KINDS,
    AttitudeSpike,
    Bias,
    CommandDelay,
    FaultSchedule,
    IntermittentShutdown,
    Outage,
    Seizure,
    SensorFault,
)
from ftac_gym.faults.description import acting_faults
from ftac_gym.faults.live import add_fault, clear_faults, widened
from ftac_gym.faults.specification import example
from ftac_gym.spacecraft import Friction

HEALTHY = scenarios.get("flagship").replace(faults=None)
LIMITS = HEALTHY.spacecraft.wheels.torque_limits


def rubbing(scenario):
    """Return the scenario with wheels that have friction, which some faults need."""
    wheels = replace(scenario.spacecraft.wheels, spin_inertia=0.02, friction=Friction(5e-4))
    return scenario.replace(spacecraft=replace(scenario.spacecraft, wheels=wheels))


def fly(simulator, law, steps, disturb=lambda step: None):
    """Let a law fly, with something done before each step; return the states on the way."""
    states = []
    for step in range(steps):
        disturb(step)
        simulator.step(law.act(simulator.measurement()))
        state = simulator.state
        states.append(np.concatenate([state.attitude, state.rate, state.wheel_momentum], axis=1))
    return np.array(states)


def pair(scenario, count=2):
    """Return a simulator at the start of an episode and a law for it."""
    simulator = Simulator(scenario, count)
    simulator.reset(scenario.draw(3, count))
    return simulator, baselines.make("pd_dob", scenario, count)


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_a_flight_with_live_faults_is_the_one_of_its_episode(kind):
    scenario = rubbing(HEALTHY)
    fault = example(kind) if issubclass(kind, SensorFault) else example(kind, wheel=1)
    simulator, law = pair(scenario)
    random = np.random.default_rng(5)

    def live(step):
        if step == 50:
            simulator.set_faults(add_fault(simulator.faults, 0, fault, simulator.time[0], LIMITS, random))
        if step == 150:
            wheel = None if issubclass(kind, SensorFault) else 1
            simulator.set_faults(clear_faults(simulator.faults, 0, wheel, simulator.time[0]))

    flown = fly(simulator, law, 250, live)
    again = Simulator(scenario, 2)
    again.reset(simulator.episodes)
    replayed = fly(again, baselines.make("pd_dob", scenario, 2), 250)
    np.testing.assert_array_equal(flown, replayed)
    quiet, same = pair(scenario)
    healthy = fly(quiet, same, 250)
    np.testing.assert_array_equal(flown[:50], healthy[:50])
    assert np.abs(flown[150, 0] - healthy[150, 0]).max() > 1e-7, "the fault must change the flight"
    np.testing.assert_array_equal(flown[:, 1], healthy[:, 1])


def test_a_live_command_delay_makes_commands_late():
    simulator, _ = pair(HEALTHY.replace(loop_delay=0.0))
    simulator.step(np.full((2, 4), 0.05))
    delay = CommandDelay(wheel=2, periods=2.0)
    simulator.set_faults(add_fault(simulator.faults, 0, delay, simulator.time[0], LIMITS, np.random.default_rng(0)))
    torques = []
    for command in (0.1, 0.15, 0.2, 0.0):
        simulator.step(np.full((2, 4), command))
        torques.append(simulator.state.wheel_torque[:, 2].copy())
    np.testing.assert_allclose(torques, [[0.0, 0.1], [0.05, 0.15], [0.1, 0.2], [0.15, 0.0]])


def test_a_live_command_delay_does_not_depend_on_other_spacecraft():
    fault, late = CommandDelay(wheel=2, periods=4.0), CommandDelay(wheel=0, periods=5.0)
    commands = np.random.default_rng(1).uniform(-0.2, 0.2, (30, 4))
    momenta = []
    for others, extra in ((0, 0), (1, 0), (1, 7)):
        simulator = Simulator(HEALTHY, 1 + others)
        episodes = HEALTHY.draw(0, 1 + others)
        episodes.extra_delay[1:] = extra
        simulator.reset(episodes)
        drawn = simulator.faults
        for other in range(1, 1 + others):
            drawn = add_fault(drawn, other, late, 0.0, LIMITS, np.random.default_rng(0))
        for step, command in enumerate(commands):
            if step == 10:
                drawn = add_fault(drawn, 0, fault, simulator.time[0], LIMITS, np.random.default_rng(0))
                simulator.set_faults(drawn)
            simulator.step(np.tile(command, (1 + others, 1)))
        momenta.append(simulator.state.wheel_momentum[0].copy())
    np.testing.assert_array_equal(momenta[1:], momenta[:1] * 2)


def test_faults_pile_up_on_a_wheel_and_clearing_ends_them_all():
    drawn = HEALTHY.draw(0, 2).drawn_faults
    random = np.random.default_rng(1)
    for time in (1.0, 2.0, 3.0):
        drawn = add_fault(drawn, 1, Bias(wheel=0, constant=0.01 * time), time, LIMITS, random)
    assert drawn.wheels.shape == (2, 4, 3)
    now = np.full(2, 3.0)
    assert acting_faults(drawn, now)[1].descriptions == tuple(
        f"wheel 0: bias at {time:.1f} s" for time in (1.0, 2.0, 3.0)
    )
    assert acting_faults(drawn, now)[0].descriptions == ()
    cleared = clear_faults(drawn, 1, 0, 5.0)
    assert len(acting_faults(cleared, np.full(2, 4.9))[1].descriptions) == 3
    assert acting_faults(cleared, np.full(2, 5.0))[1].descriptions == ()


def test_clearing_also_removes_future_faults():
    scenario = HEALTHY.replace(faults=FaultSchedule((Outage(wheel=3, onset=40.0), AttitudeSpike(onset=50.0))))
    drawn = scenario.draw(0, 1).drawn_faults
    for wheel in (3, None):
        drawn = clear_faults(drawn, 0, wheel, 10.0)
    assert not drawn.wheels["kind"].any() and not drawn.sensors["kind"].any()
    assert acting_faults(drawn, np.array([60.0]))[0].descriptions == ()


def test_tables_given_are_left_as_they_are():
    drawn = HEALTHY.draw(0, 1).drawn_faults
    before = [table.copy() for table in drawn]
    add_fault(drawn, 0, Seizure(wheel=1), 3.0, LIMITS, np.random.default_rng(0))
    clear_faults(drawn, 0, 1, 3.0)
    for table, kept in zip(drawn, before, strict=True):
        np.testing.assert_array_equal(table, kept)


def test_wider_tables_say_the_same():
    drawn = scenarios.get("flagship_double").draw(2, 20).drawn_faults
    wide = widened(drawn, 3, 2, 4)
    assert (wide.wheels.shape[2], wide.sensors.shape[1], wide.switches.shape[1]) == (3, 2, 4)
    now = np.full(20, 60.0)
    for narrow, other in zip(acting_faults(drawn, now), acting_faults(wide, now), strict=True):
        assert narrow.descriptions == other.descriptions


def test_spacecraft_with_and_without_layers_share_a_simulator():
    layered = HEALTHY.replace(faults=FaultSchedule((Outage(wheel=0), Outage(wheel=0, onset=5.0))))
    simulator, law = pair(HEALTHY)
    alone = Simulator(layered, 1)
    alone.reset(layered.draw(7, 1))
    simulator.reset(layered.draw(7, 1), np.array([False, True]))
    flown = fly(simulator, law, 80)
    other = fly(alone, baselines.make("pd_dob", layered, 1), 80)
    np.testing.assert_allclose(flown[:, 1], other[:, 0], rtol=0.0, atol=1e-12)
    simulator.reset(HEALTHY.draw(9, 1), np.array([False, True]))
    assert simulator.episodes.faults.shape == (2, 4, 2)


def test_a_simulator_keeps_faults_of_its_own():
    simulator, _ = pair(HEALTHY)
    given = scenarios.get("flagship_double").draw(4, 2).drawn_faults
    before = given.copy()
    simulator.set_faults(given)
    simulator.reset(HEALTHY.draw(9, 2))
    for table, kept in zip(given, before, strict=True):
        np.testing.assert_array_equal(table, kept)


@pytest.mark.parametrize("wheel", [None, 4])
def test_a_fault_must_name_a_wheel_that_there_is(wheel):
    with pytest.raises(ValueError, match=r"wheel must be one of \[0, 1, 2, 3\], got"):
        add_fault(HEALTHY.draw(0, 1).drawn_faults, 0, Outage(wheel=wheel), 0.0, LIMITS, np.random.default_rng(0))


def test_faults_of_another_number_of_spacecraft_are_refused():
    simulator, _ = pair(HEALTHY)
    with pytest.raises(ValueError, match=r"faults must be for 2 spacecraft of 4 wheels; .*, got"):
        simulator.set_faults(HEALTHY.draw(0, 1).drawn_faults)


def test_a_random_chain_starts_now():
    drawn = HEALTHY.draw(0, 1).drawn_faults
    drawn = add_fault(drawn, 0, IntermittentShutdown(wheel=0), 30.0, LIMITS, np.random.default_rng(2))
    assert acting_faults(drawn, np.array([29.9]))[0].descriptions == ()
    assert acting_faults(drawn, np.array([30.0]))[0].descriptions == ("wheel 0: intermittent shutdown at 30.0 s",)
    assert drawn.switches[0, 0, 0] > 30.0
