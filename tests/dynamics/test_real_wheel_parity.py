"""Real wheels against an independent implementation integrated by SciPy, and the order of the integrator on them."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ftac_gym import faults as fault_kinds
from ftac_gym.dynamics import Simulator
from ftac_gym.dynamics.simulator import THREAD_BATCH
from ftac_gym.spacecraft.friction import Friction
from ftac_gym.spacecraft.spacecraft import Spacecraft
from ftac_gym.spacecraft.wheel_array import WheelArray
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.scenario import Scenario

INERTIA = np.array([[10.0, 1.2, 0.5], [1.2, 19.0, 1.5], [0.5, 1.5, 25.0]])  # kg m^2
AXES = np.array([[1, -1, -1, 1, 2, 0], [1, 1, -1, -1, 0, 2], [1, 1, 1, 1, 1, -1]], dtype=float)
AXES /= np.linalg.norm(AXES, axis=0)
LIMIT = 0.2  # N m
SPIN = 0.02  # kg m^2
LAG = np.array([0.05, 0.0, 0.2, 0.0, 0.08, 0.03])  # s; a wheel without lag must be told apart
WEAK = Friction(coulomb=5e-4, breakaway=8e-4, breakaway_speed=0.1, viscous=1e-4)
STRONG = Friction(coulomb=2e-3, breakaway=8e-3, breakaway_speed=0.3, viscous=2e-4)
FRICTION = (WEAK, STRONG, STRONG, None, WEAK, STRONG)
START = {"attitude": (0.5, -0.5, 0.5, 0.5), "rate": (0.03, -0.05, 0.04)}
AWAY = (0.9, -1.0, 1.2, 0.6, -1.2, 2.0)  # N m s: friction is Coulomb and viscous throughout
FAULTS = (
    fault_kinds.LossOfEffectiveness(wheel=0, onset=1.03, effectiveness=0.5, amplitude=0.4, frequency=1.3, phase=0.3),
    fault_kinds.FrictionRise(wheel=1, onset=2.0, factor=4.0, rise=5.0),
    fault_kinds.Bias(wheel=1, onset=0.5, amplitude=0.04, frequency=0.8, phase=0.5),
    fault_kinds.FrictionRise(wheel=2, onset=1.0, factor=3.0, rise=5.0, direction="forward"),
    fault_kinds.FrictionRise(wheel=2, onset=1.0, factor=5.0, rise=5.0, direction="backward"),
    fault_kinds.DriftingEffectiveness(wheel=3, onset=0.5, effectiveness=0.3, rise=6.0),
    fault_kinds.DriftingEffectiveness(wheel=4, onset=1.5, effectiveness=0.1, rise=4.0),
    fault_kinds.Bias(wheel=4, onset=3.0, slope=0.004),
    fault_kinds.LockInPlace(wheel=5, onset=4.02, recovery=7.0),
)


def ramp(time, onset, rise):
    return min(max((time - onset) / rise, 0.0), 1.0)


COULOMB, BREAKAWAY, BREAKAWAY_SPEED, VISCOUS = np.array(
    [[f.coulomb, f.breakaway, f.breakaway_speed, f.viscous] for f in (g or Friction() for g in FRICTION)]
).T


def drag(speed, factor):
    """The formula of the friction block, written out again for all wheels at once."""
    ratio = speed / (np.sqrt(2.0) * BREAKAWAY_SPEED)
    dry = np.sqrt(2.0 * np.e) * (BREAKAWAY - COULOMB) * np.exp(-(ratio**2)) * ratio
    dry += COULOMB * np.tanh(10.0 * speed / BREAKAWAY_SPEED)
    return factor * dry + VISCOUS * speed


def cross_matrix(w):
    return np.array([[0.0, -w[2], w[1]], [w[2], 0.0, -w[0]], [-w[1], w[0], 0.0]])


class IndependentCraft:
    """Body, motors and wheels with the faults above, for one spacecraft."""

    def __init__(self, coupling, faulty):
        self.coupling, self.faulty = coupling, faulty
        self.locked = None

    def wheel_torque(self, time, command, motor, momentum, probe):
        """Torque of each wheel on the body; ``probe`` lies inside the segment and decides which faults act."""
        speed = momentum / SPIN
        drive = np.where(LAG > 0.0, motor, command)
        factor = np.ones(6)
        if self.faulty:
            if probe > 1.03:
                drive[0] *= 0.5 + 0.4 * np.sin(1.3 * time + 0.3)
            factor[1] = 1.0 + 3.0 * ramp(time, 2.0, 5.0)
            if probe > 0.5:
                drive[1] += 0.04 * np.sin(0.8 * (time - 0.5) + 0.5)
            factor[2] = 1.0 + (2.0 if momentum[2] > 0.0 else 4.0) * ramp(time, 1.0, 5.0)
            drive[3] *= 1.0 - 0.7 * ramp(time, 0.5, 6.0)
            drive[4] *= 1.0 - 0.9 * ramp(time, 1.5, 4.0)
            if probe > 3.0:
                drive[4] += 0.004 * (time - 3.0)
        drive += drag(speed, factor)
        if self.holds(probe):
            drive[5] = self.locked
        return drive

    def holds(self, probe):
        return self.faulty and 4.02 < probe < 7.0

    def derivative(self, time, state, command, probe):
        w, h, motor = state[4:7], state[7:13], state[13:]
        tau = self.wheel_torque(time, command, motor, h, probe)
        momentum = INERTIA @ w + (AXES @ h if self.coupling else 0.0)
        across = cross_matrix(w)
        turn = 0.5 * np.concatenate([[-state[1:4] @ w], state[0] * w - across @ state[1:4]])
        spin = np.linalg.solve(INERTIA, AXES @ tau - across @ momentum)
        answer = np.where(LAG > 0.0, command - motor, 0.0) / np.where(LAG > 0.0, LAG, 1.0)
        if self.holds(probe):
            answer[5] = 0.0
        return np.concatenate([turn, spin, -tau, answer])

    def history(self, commands, momentum, period, events):
        """State (10 + m,) at the end of each control period, integrated piecewise between the events."""
        ends = period * np.arange(len(commands) + 1)
        times = np.unique(np.round([*ends, *(event for event in events if event < ends[-1])], 12))
        state = np.concatenate([START["attitude"], START["rate"], momentum, np.zeros(6)])
        states = []
        for begin, end in pairwise(times):
            probe = 0.5 * (begin + end)
            command = np.clip(commands[int(probe / period)], -LIMIT, LIMIT)
            solution = solve_ivp(
                self.derivative, (begin, end), state, "DOP853", rtol=1e-11, atol=1e-12, args=(command, probe)
            )  # fmt: skip
            state = solution.y[:, -1]
            if not self.holds(probe):
                self.locked = self.wheel_torque(end, command, state[13:], state[7:13], probe)[5]
            if np.abs(ends - end).min() < 1e-9:
                states.append(state[:13])
        return np.array(states)


def simulate(commands, momentum, period, step, coupling=True, faults=(), **wheels):
    parts = {
        "spin_inertia": SPIN,
        "friction": FRICTION,
        "lag": tuple(np.maximum(LAG, 1e-9)),  # one nanosecond: none
    } | wheels
    scenario = Scenario(
        name="real",
        spacecraft=Spacecraft(INERTIA, WheelArray(AXES, LIMIT, None, coupling, **parts)),
        initial_state=InitialState.fixed(**START, wheel_momentum=momentum),
        faults=fault_kinds.FaultSchedule(faults) if faults else None,
        control_period=period,
        physics_step=step,
        duration=period * len(commands),
    )
    simulator = Simulator(scenario, 1)
    simulator.reset(scenario.draw(0, 1))
    states = []
    for command in commands:
        simulator.step(command[None])
        state = simulator.state
        states.append(np.concatenate([state.attitude[0], state.rate[0], state.wheel_momentum[0]]))
    return np.array(states)


@pytest.mark.parametrize("coupling", [True, False])
def test_plant_agrees_with_scipy_away_from_rest(coupling):
    commands = np.random.default_rng(0).uniform(-0.3, 0.3, (80, 6))
    events = (0.5, 1.0, 1.03, 1.5, 2.0, 3.0, 4.0, 4.02, 5.5, 6.0, 6.5, 7.0)
    expected = IndependentCraft(coupling, faulty=True).history(commands, AWAY, 0.1, events)
    assert np.abs(expected[:, 7:]).min() > 0.1  # N m s
    states = simulate(commands, AWAY, 0.1, 0.005, coupling, FAULTS)
    np.testing.assert_allclose(states, expected, rtol=0.0, atol=1e-9)


def test_plant_agrees_with_scipy_through_zero_crossings():
    commands = 0.1 * np.sin(0.36 * np.arange(40)[:, None] + np.arange(6))
    start = (0.02, -0.01, 0.015, 0.01, -0.02, 0.01)
    expected = IndependentCraft(coupling=True, faulty=False).history(commands, start, 0.1, ())
    turns = (np.diff(np.sign(expected[:, 7:]), axis=0) != 0).sum(axis=0)
    assert np.all(turns[[0, 1, 2, 4, 5]] >= 4)
    states = simulate(commands, start, 0.1, 0.000625)
    np.testing.assert_allclose(states, expected, rtol=0.0, atol=1e-9)
    # Even a step ten times as long as a wheel takes through its transition at rest costs little.
    states = simulate(commands, start, 0.1, 0.02)
    np.testing.assert_allclose(states, expected, rtol=0.0, atol=1e-4)


def test_order_four_away_from_rest():
    commands = np.random.default_rng(0).uniform(-0.3, 0.3, (10, 6))
    faults = (
        fault_kinds.LossOfEffectiveness(wheel=0, onset=1.6, effectiveness=0.5, amplitude=0.4, frequency=1.5, phase=0.2),
        fault_kinds.Bias(wheel=1, onset=2.4, recovery=6.4, amplitude=0.1, frequency=1.2, slope=0.01),
        fault_kinds.DriftingEffectiveness(wheel=4, onset=0.8, effectiveness=0.1, rise=4.0),
    )
    start = tuple(5.0 * momentum for momentum in AWAY)

    def end(step):
        return simulate(commands, start, 0.8, step, faults=faults, lag=(0.5, 0.3, 0.4, 0.6, 0.8, 0.3))[-1]

    truth = end(0.8 / 256)
    errors = np.array([np.abs(end(step) - truth) for step in (0.1, 0.05, 0.025)])
    for part in (slice(0, 4), slice(4, 7), slice(7, 13)):
        sizes = np.linalg.norm(errors[:, part], axis=1)
        assert sizes[0] > 1e-10
        for coarse, fine in pairwise(sizes):
            assert 13.0 < coarse / fine < 20.0


@pytest.mark.parametrize("breakaway_speed", [1.0, 10.0])
def test_order_three_through_zero_crossings(breakaway_speed):
    friction = Friction(0.02, 0.05, breakaway_speed, 1e-3)
    commands = 0.15 * np.sin(0.36 * np.arange(40)[:, None] + np.arange(6))
    start = (0.0, 0.05, -0.05, 0.03, -0.02, 0.04)

    def history(step):
        return simulate(commands, start, 0.4, step, friction=friction, lag=None)

    truth = history(0.4 / 1024)
    assert np.all((np.diff(np.sign(truth[:, 7:]), axis=0) != 0).sum(axis=0) >= 4)
    errors = [np.linalg.norm(history(step)[-1] - truth[-1]) for step in (0.01, 0.005, 0.0025)]
    for coarse, fine in pairwise(errors):
        assert 7.0 < coarse / fine < 12.0


# ------------------------------------------------------------------------------------------------------- many at once

EVERYTHING = (
    *FAULTS,
    fault_kinds.Bias(wheel=0, onset=2.0, constant=0.03, period=0.7, on_time=0.33),
    fault_kinds.Seizure(wheel=3, onset=5.0),
    fault_kinds.CommandDelay(wheel=1, onset=1.0, periods=(1.0, 5.0)),
    fault_kinds.IntermittentShutdown(wheel=4, mean_acting=2.0, mean_resting=3.0),
    fault_kinds.HardOver(wheel=2, onset=(3.0, 7.0), recovery=7.5),
)
HOSTILE = {"momentum_limit": 1.3, "dead_band": 1e-3, "power_limit": 5.0, "lag": (0.05, 0.01, 0.2, 0.02, 0.08, 0.03)}


def everything(count, threads=1):
    wheels = WheelArray(AXES, LIMIT, spin_inertia=SPIN, friction=FRICTION, **HOSTILE)
    scenario = Scenario(
        name="everything",
        spacecraft=Spacecraft(INERTIA, wheels),
        initial_state=InitialState(max_rate=0.05, wheel_momentum=(-1.2, 1.2)),
        faults=fault_kinds.FaultSchedule(EVERYTHING),
        duration=20.0,
    )
    return Simulator(scenario, count, threads)


def parts(state):
    names = ("attitude", "rate", "wheel_momentum", "wheel_torque", "motor_torque")
    return {name: getattr(state, name).copy() for name in names}


def test_many_craft_equal_single_craft_bit_for_bit():
    count = 12
    together = everything(count)
    episodes = together.scenario.draw(3, count)
    together.reset(episodes)
    alone = [everything(1) for _ in range(count)]
    for craft, simulator in enumerate(alone):
        simulator.reset(episodes[craft])
    for command in np.random.default_rng(0).uniform(-0.3, 0.3, (100, count, 6)):
        together.step(command)
        for craft, simulator in enumerate(alone):
            simulator.step(command[craft : craft + 1])
    for name, array in parts(together.state).items():
        assert np.all(np.isfinite(array))
        np.testing.assert_array_equal(array, np.concatenate([getattr(one.state, name) for one in alone]), name)


def test_threads_change_nothing():
    count = 3 * THREAD_BATCH
    simulators = [everything(count, threads) for threads in (1, 3)]
    episodes = simulators[0].scenario.draw(3, count)
    for simulator in simulators:
        simulator.reset(episodes)
    for command in np.random.default_rng(0).uniform(-0.3, 0.3, (60, count, 6)):
        for simulator in simulators:
            simulator.step(command)
    first, second = (parts(simulator.state) for simulator in simulators)
    for name, array in first.items():
        np.testing.assert_array_equal(array, second[name], name)


def test_episodes_of_real_wheels_are_replayed_after_others():
    simulator = everything(4)
    episodes = simulator.scenario.draw(5, 8)
    commands = np.random.default_rng(0).uniform(-0.3, 0.3, (80, 4, 6))
    ends = []
    for chosen in (slice(0, 4), slice(4, 8), slice(0, 4)):
        simulator.reset(episodes[chosen])
        for command in commands:
            simulator.step(command)
        ends.append(parts(simulator.state))
    assert any(np.any(ends[0][name] != ends[1][name]) for name in ends[0])
    for name, array in ends[0].items():
        np.testing.assert_array_equal(array, ends[2][name], name)
