"""The compiled plant against an independent implementation integrated by SciPy, with everything switched on."""

from itertools import pairwise

import numpy as np
import pytest
from helpers.free_flexible_body import DISTURBANCE, VARYING
from scipy.integrate import solve_ivp

from ftac_gym.dynamics import Simulator
from ftac_gym.faults import Bias, FaultSchedule, HardOver, LockInPlace, LossOfEffectiveness, Outage
from ftac_gym.spacecraft.spacecraft import Spacecraft
from ftac_gym.spacecraft.wheel_array import WheelArray
from ftac_gym.task.inertia import InertiaUncertainty
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.scenario import Scenario

INERTIA = np.array([[10.0, 1.2, 0.5], [1.2, 19.0, 1.5], [0.5, 1.5, 25.0]])  # kg m^2
AXES = np.array([[1, -1, -1, 1, 2, 0, 0], [1, 1, -1, -1, 0, 2, 1], [1, 1, 1, 1, 1, -1, 2]], dtype=float)
AXES /= np.linalg.norm(AXES, axis=0)
LIMIT = 0.2  # N m
START = {
    "attitude": (0.5, -0.5, 0.5, 0.5),
    "rate": (0.03, -0.05, 0.04),
    "wheel_momentum": (0.5, -0.3, 0.2, 0.1, -0.4, 0.3, -0.1),
}
PERIOD, STEP, DURATION = 0.1, 0.01, 12.0  # s

FAULTS = (
    LossOfEffectiveness(wheel=0, onset=1.0, effectiveness=0.6),
    LossOfEffectiveness(wheel=0, onset=2.0, recovery=9.0, effectiveness=0.5, amplitude=0.4, frequency=0.9, phase=0.3),
    Bias(wheel=0, onset=1.53, constant=0.03, period=0.8, on_time=0.27),
    Bias(wheel=1, onset=0.5, recovery=8.0, constant=0.02, slope=-0.005),
    Bias(wheel=1, onset=3.0, amplitude=0.04, frequency=0.8, phase=0.5),
    Bias(wheel=2, onset=2.37, amplitude=0.002, exponent=3.5, frequency=0.2),
    HardOver(wheel=3, onset=4.0, recovery=7.0, fraction=-0.7, random_sign=False),
    Outage(wheel=3, onset=8.0),
    LockInPlace(wheel=4, onset=3.05, recovery=6.0),
    LockInPlace(wheel=4, onset=8.0),
    Outage(wheel=5, onset=1.0, period=0.5, on_time=0.2, recovery=10.0),
)


def acts(onset, recovery, time, period=None, on_time=None):
    """True if a fault acts at a time that is no event."""
    if not onset <= time < recovery:
        return False
    return period is None or (time - onset) % period < on_time


class IndependentCraft:
    """The equations of motion and the faults above, written out by hand for one spacecraft."""

    def __init__(self, coupling, rate_torque):
        self.coupling, self.rate_torque = coupling, rate_torque
        self.locked = None

    def wheel_torque(self, time, command, probe):
        """Torque of each wheel; ``probe`` is any time inside the segment and decides which faults act."""
        tau = np.clip(command, -LIMIT, LIMIT)
        never = np.inf
        if acts(1.0, never, probe):
            tau[0] *= 0.6
        if acts(2.0, 9.0, probe):
            tau[0] *= 0.5 + 0.4 * np.sin(0.9 * time + 0.3)
        if acts(1.53, never, probe, 0.8, 0.27):
            tau[0] += 0.03
        if acts(0.5, 8.0, probe):
            tau[1] += 0.02 - 0.005 * (time - 0.5)
        if acts(3.0, never, probe):
            tau[1] += 0.04 * np.sin(0.8 * (time - 3.0) + 0.5)
        if acts(2.37, never, probe):
            since = max(time - 2.37, 0.0)
            tau[2] += 0.002 * since**3.5 * np.sin(0.2 * since)
        if acts(4.0, 7.0, probe):
            tau[3] = -0.7 * LIMIT
        if acts(8.0, never, probe):
            tau[3] = 0.0
        if acts(1.0, 10.0, probe, 0.5, 0.2):
            tau[5] = 0.0
        if acts(3.05, 6.0, probe) or acts(8.0, never, probe):
            tau[4] = self.locked
        return tau

    def derivative(self, time, state, command, probe):
        w, h = state[4:7], state[7:]
        angle = np.array(VARYING["frequency"]) * time + np.array(VARYING["phase"])
        inertia = INERTIA + np.diag(VARYING["amplitude"] * np.sin(angle))
        inertia_rate = np.diag(np.array(VARYING["amplitude"]) * np.array(VARYING["frequency"]) * np.cos(angle))
        external = np.array([0.02, -0.03, 0.01])
        external += np.array([0.05, 0.04, -0.03]) * np.sin(0.6 * time + np.array([0.0, 1.0, 2.0]))
        external += np.array([0.01, 0.02, 0.03]) * np.sin(1.7 * time + np.array([0.5, 0.0, -1.0]))
        external *= w @ w + 0.3
        tau = self.wheel_torque(time, command, probe)
        momentum = inertia @ w + (AXES @ h if self.coupling else 0.0)
        torque = -np.cross(w, momentum) + AXES @ tau + external
        if self.rate_torque:
            torque -= inertia_rate @ w
        q0, qv = state[0], state[1:4]
        turn = 0.5 * np.concatenate([[-qv @ w], q0 * w + np.cross(qv, w)])
        return np.concatenate([turn, np.linalg.solve(inertia, torque), -tau])

    def history(self, commands):
        """State (10 + m,) at the end of each control period, integrated piecewise between the events."""
        ticks = set(range(0, round(DURATION / STEP) + 1, round(PERIOD / STEP)))
        for event in (*np.arange(1.53, 12.0, 0.8), *np.arange(1.8, 12.0, 0.8), 2.37, 3.05):
            ticks.add(round(event / STEP))
        ticks = sorted(ticks)
        state = np.concatenate([START["attitude"], START["rate"], START["wheel_momentum"]])
        states = []
        for begin, end in pairwise(ticks):
            command = commands[begin * len(commands) // ticks[-1]]
            probe = 0.5 * STEP * (begin + end)
            solution = solve_ivp(
                self.derivative,
                (begin * STEP, end * STEP),
                state,
                "DOP853",
                rtol=1e-12,
                atol=1e-13,
                args=(command, probe),
            )
            state = solution.y[:, -1]
            if not acts(3.05, 6.0, probe) and not acts(8.0, np.inf, probe):
                self.locked = self.wheel_torque(end * STEP, command, probe)[4]  # what a lock at ``end`` would hold
            if end % round(PERIOD / STEP) == 0:
                states.append(state)
        return np.array(states)


@pytest.mark.parametrize(("coupling", "rate_torque"), [(True, True), (True, False), (False, True)])
def test_plant_agrees_with_scipy_with_everything_on(coupling, rate_torque):
    scenario = Scenario(
        name="everything",
        spacecraft=Spacecraft(INERTIA, WheelArray(AXES, LIMIT, 50.0, coupling)),
        initial_state=InitialState.fixed(**START),
        faults=FaultSchedule(FAULTS),
        disturbance=DISTURBANCE,
        inertia_uncertainty=InertiaUncertainty(**VARYING, rate_torque=rate_torque),
        control_period=PERIOD,
        physics_step=STEP,
        duration=DURATION,
    )
    commands = np.random.default_rng(0).uniform(-0.3, 0.3, (scenario.horizon, AXES.shape[1]))
    expected = IndependentCraft(coupling, rate_torque).history(commands)
    simulator = Simulator(scenario, 1)
    simulator.reset(scenario.draw(0, 1))
    state = simulator.state
    for command, row in zip(commands, expected, strict=True):
        simulator.step(command[None])
        np.testing.assert_allclose(state.attitude[0], row[:4], rtol=0.0, atol=1e-9)
        np.testing.assert_allclose(state.rate[0], row[4:7], rtol=0.0, atol=1e-9)
        np.testing.assert_allclose(state.wheel_momentum[0], row[7:], rtol=0.0, atol=1e-9)
