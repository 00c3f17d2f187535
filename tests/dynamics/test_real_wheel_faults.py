"""Faults of real wheels: what is conserved through all of them, seizure, locks, delays and shut-downs."""

import itertools

import numpy as np
import pytest
from helpers.wheels import FRICTION, LIMIT, PERIOD, PYRAMID, REAL, SPIN, body_momentum, run, start, total_momentum

from ftac_gym import faults as fault_kinds
from ftac_gym.dynamics import Simulator
from ftac_gym.spacecraft.friction import Friction
from ftac_gym.spacecraft.spacecraft import Spacecraft

# -------------------------------------------------------------------------------------------------------- conserved

STORM = {
    "friction": {},
    "zero crossings of stiff friction": {"friction": Friction(5e-2, 8e-2, 1e-3)},
    "seizures": {
        "faults": (
            fault_kinds.Seizure(wheel=0, onset=20.0, brake=1.5),
            fault_kinds.Seizure(wheel=2, onset=70.03, brake=4.0, recovery=150.0),
        )
    },
    "saturation": {"momentum_limit": 0.6, "faults": (fault_kinds.HardOver(wheel=1, onset=50.0),)},
    "power": {"power_limit": 1.0, "dead_band": 0.01},
    "everything": {
        "momentum_limit": 0.6,
        "speed_limit": 29.0,
        "power_limit": (1.0, 2.0, 3.0, 4.0),
        "dead_band": 0.01,
        "faults": (
            fault_kinds.Seizure(wheel=0, onset=150.05, brake=2.0),
            fault_kinds.FrictionRise(wheel=0, onset=10.0, factor=10.0, rise=50.0),
            fault_kinds.FrictionRise(wheel=1, onset=10.0, factor=10.0, direction="forward", period=20.0, on_time=7.0),
            fault_kinds.HardOver(wheel=1, onset=30.0, recovery=120.0, rise=5.0, fall=5.0),
            fault_kinds.CommandDelay(wheel=2, onset=40.0, periods=3),
            fault_kinds.IntermittentShutdown(wheel=2, mean_acting=5.0, mean_resting=15.0),
            fault_kinds.LockInPlace(wheel=3, onset=60.02, recovery=90.0),
            fault_kinds.Bias(wheel=3, onset=0.0, amplitude=0.05, frequency=3.0),
        ),
    },
}


# What is left is the error of RK4 in turning the body, which falls with the fourth power of the step.
@pytest.mark.parametrize(("step", "tolerance"), [(0.02, 1e-10), (0.1, 3e-8)])
@pytest.mark.parametrize("name", STORM)
def test_total_momentum_is_conserved(name, step, tolerance):
    parts = {**REAL, **STORM[name]}
    faults = parts.pop("faults", ())
    simulator = start(*faults, momentum=(0.5, -0.4, 0.3, 0.4), rate=(0.01, 0.02, -0.01), step=step, **parts)
    before = total_momentum(simulator.state)
    wave = 0.15 * np.sin(0.013 * np.arange(3000)[:, None] + np.arange(4)) * np.array([1.0, -1.0, 1.0, -1.0])
    wave += 0.05 * np.random.default_rng(0).uniform(-1.0, 1.0, (3000, 4))
    _, momentum = run(simulator, wave)
    assert np.all(np.isfinite(momentum)) and np.abs(momentum).max() > 0.5
    turns = (np.diff(np.sign(momentum), axis=0) != 0).sum(axis=0)
    assert turns.max() > 10
    assert np.linalg.norm(total_momentum(simulator.state) - before) < tolerance * np.linalg.norm(before)


def test_without_coupling_the_body_feels_torques_but_no_stored_momentum():
    # No rate about other axes: then the two models agree, friction and seizure included.
    axis = np.array([[0.0], [0.0], [1.0]])
    fault = fault_kinds.Seizure(wheel=0, onset=3.0)
    ends = []
    for coupling in (True, False):
        scenario = start(fault, momentum=1.0, axes=axis, momentum_coupling=coupling, **REAL).scenario
        principal = Spacecraft(np.diag([10.0, 19.0, 25.0]), scenario.spacecraft.wheels)
        simulator = Simulator(scenario.replace(spacecraft=principal), 1)
        simulator.reset(simulator.scenario.draw(0, 1))
        _, momentum = run(simulator, np.full((100, 1), 0.05))
        assert momentum[-1, 0] == 0.0
        assert simulator.state.rate[0, 2] == pytest.approx(1.0 / 25.0, rel=1e-12)
        ends.append(simulator.state.rate[0].copy())
    np.testing.assert_array_equal(ends[0], ends[1])


# ----------------------------------------------------------------------------------------------------------- energy


@pytest.mark.parametrize("lag", [1e-9, 0.1])
def test_friction_takes_energy_and_never_gives_any(lag):
    # Small steps, each of them recorded: the motor's work by the trapezoidal rule.
    step = 0.002
    simulator = start(momentum=(0.1, -0.1, 0.0, 0.02), step=step, period=step, **{**REAL, "lag": lag})
    commands = np.repeat(np.random.default_rng(0).uniform(-0.15, 0.15, (60, 4)), 50, axis=0)
    motor, momentum = [np.zeros(4)], [simulator.state.wheel_momentum[0].copy()]
    for command in commands:
        simulator.step(command[None])
        motor.append(simulator.state.motor_torque[0].copy())
        momentum.append(simulator.state.wheel_momentum[0].copy())
    motor, speed = np.array(motor), np.array(momentum) / SPIN
    if lag < step:
        motor[:-1] = motor[1:]  # without a lag the torque of a period is there from its start
        motor[-1] = 0.0
        push = motor[:-1]
        work = -push * 0.5 * step * (speed[:-1] + speed[1:])
    else:
        work = -0.5 * step * (motor[:-1] * speed[:-1] + motor[1:] * speed[1:])
    stored = 0.5 * SPIN * np.diff(speed**2, axis=0)
    loss = work - stored
    assert loss.min() > -2e-7  # J, of some 1e-3 J that go in and out in a step
    drag = FRICTION.torque(speed) * speed
    expected = 0.5 * step * (drag[:-1] + drag[1:])
    np.testing.assert_allclose(loss.sum(axis=0), expected.sum(axis=0), rtol=2e-3)


# ---------------------------------------------------------------------------------------------------------- seizure


@pytest.mark.parametrize("parts", [{}, {"spin_inertia": SPIN}], ids=["ideal", "real"])
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_the_momentum_of_a_seized_wheel_goes_into_the_body(parts, sign):
    stored, brake = sign * 1.5, 2.5
    simulator = start(fault_kinds.Seizure(wheel=1, onset=1.0, brake=brake), momentum=(0.0, stored, 0.0, 0.0), **parts)
    torque, momentum = run(simulator, np.zeros((100, 1)))
    time = PERIOD * np.arange(1, 101)
    expected = sign * np.maximum(abs(stored) - brake * LIMIT * np.maximum(time - 1.0, 0.0), 0.0)
    np.testing.assert_allclose(momentum[:, 1], expected, rtol=0.0, atol=1e-13)
    np.testing.assert_allclose(torque[10:39, 1], sign * brake * LIMIT, rtol=1e-14)
    assert np.all(torque[40:, 1] == 0.0) and np.all(momentum[40:, 1] == 0.0)  # 3 s to stop
    np.testing.assert_allclose(body_momentum(simulator.state), PYRAMID[:, 1] * stored, rtol=0.0, atol=1e-9)
    # Whatever is commanded, it does not move any more.
    torque, momentum = run(simulator, np.random.default_rng(0).choice([-5.0, 0.2, 5.0], (100, 4)))
    assert np.all(torque[:, 1] == 0.0) and np.all(momentum[:, 1] == 0.0)


@pytest.mark.parametrize("step", [0.02, 0.1])
@pytest.mark.parametrize("command", [-0.15, 0.15])
def test_the_motor_hastens_or_delays_the_stop(command, step):
    fault = fault_kinds.Seizure(wheel=0, brake=2.0)
    torque, momentum = run(start(fault, momentum=1.0, step=step), np.full((60, 1), command))
    time = PERIOD * np.arange(1, 61)
    expected = np.maximum(1.0 - (0.4 + command) * time, 0.0)
    np.testing.assert_allclose(momentum[:, 0], expected, rtol=0.0, atol=1e-13)
    spins = expected > 1e-9
    np.testing.assert_allclose(torque[spins, 0], 0.4 + command, rtol=0.0, atol=1e-13)
    assert np.all(momentum[expected == 0.0, 0][1:] == 0.0) and np.all(torque[expected == 0.0, 0][1:] == 0.0)


def test_friction_and_lag_do_not_keep_a_wheel_from_seizing():
    fault = fault_kinds.Seizure(wheel=0, onset=1.04, brake=1.2)
    simulator = start(fault, momentum=1.0, **{**REAL, "lag": 0.5})
    torque, momentum = run(simulator, np.full((400, 1), -0.2))  # the motor accelerates it against the brake
    # Once the motor is up, the net torque is brake and friction minus motor: 0.04 N m and friction.
    moving = np.flatnonzero(momentum[50:, 0] > 0.1) + 50
    drag = FRICTION.torque(momentum[moving, 0] / SPIN)
    np.testing.assert_allclose(torque[moving, 0] - drag, 0.04 + 0.2 * np.exp(-0.2 * (moving + 1)), rtol=1e-9)
    assert 200 < np.flatnonzero(momentum[:, 0] == 0.0)[0] < 350
    assert np.all(np.diff(momentum[11:, 0]) <= 0.0)
    torque, momentum = run(simulator, np.random.default_rng(0).uniform(-0.2, 0.2, (50, 4)))
    assert np.all(torque[:, 0] == 0.0) and np.all(momentum[:, 0] == 0.0)


@pytest.mark.parametrize("step", [0.02, 0.1])
def test_a_brake_stops_a_wheel_without_turning_it_round(step):
    # Wherever within a step it stops; extrapolation from inside the step would spin it backwards.
    initial = np.linspace(0.0, 0.09, 451)[1:]
    axes = np.tile([[0.0], [0.0], [1.0]], (1, 6))
    for momenta in initial.reshape(-1, 6):
        faults = [fault_kinds.Seizure(wheel=wheel, brake=1.5) for wheel in range(6)]
        signs = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
        simulator = start(*faults, momentum=signs * momenta, axes=axes, step=step, period=step, duration=30.0)
        _, momentum = run(simulator, np.zeros((round(0.4 / step), 1)))
        time = step * np.arange(1, len(momentum) + 1)
        expected = np.maximum(momenta - 0.3 * time[:, None], 0.0)
        np.testing.assert_allclose(signs * momentum, expected, rtol=0.0, atol=1e-14)


def test_a_seizure_is_stronger_than_any_other_fault_of_the_wheel():
    seizure = fault_kinds.Seizure(wheel=0, onset=2.0, brake=1.5)
    for other in (
        fault_kinds.HardOver(wheel=0, onset=1.0, random_sign=False, fraction=-1.0),
        fault_kinds.LockInPlace(wheel=0, onset=1.0),
        fault_kinds.LockInPlace(wheel=0, onset=4.0),
        fault_kinds.Bias(wheel=0, onset=1.0, constant=0.09),
        fault_kinds.Outage(wheel=0, onset=1.0),
        fault_kinds.CommandDelay(wheel=0, onset=1.0),
    ):
        for faults in itertools.permutations((seizure, other)):
            simulator = start(*faults, momentum=0.5)
            torque, momentum = run(simulator, np.full((20, 1), -0.1))
            run(simulator, np.full((180, 1), 0.1))
            torque, momentum = run(simulator, np.random.default_rng(0).uniform(-0.2, 0.2, (50, 4)))
            assert np.all(torque[:, 0] == 0.0) and np.all(momentum[:, 0] == 0.0)


def test_a_wheel_that_lets_go_again_obeys_again():
    torque, momentum = run(start(fault_kinds.Seizure(wheel=0, recovery=5.0), momentum=0.3), np.full((60, 1), -0.1))
    assert np.all(momentum[20:50, 0] == 0.0)
    np.testing.assert_array_equal(torque[50:, 0], -0.1)
    np.testing.assert_allclose(momentum[50:, 0], 0.01 * np.arange(1, 11), rtol=1e-12)
