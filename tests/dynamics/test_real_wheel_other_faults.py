"""Locks, delays and shutdowns of real wheels."""

import numpy as np
import pytest
from helpers.wheels import FRICTION, PERIOD, REAL, SPIN, run, start

from ftac_gym.faults import (
    CommandDelay,
    FrictionRise,
    IntermittentShutdown,
    LockInPlace,
    LossOfEffectiveness,
    Outage,
    Seizure,
)
from ftac_gym.spacecraft.friction import Friction

# ----------------------------------------------------------------------------------------------------- other faults


def test_a_locked_real_wheel_keeps_its_whole_torque_through_rest():
    fault = LockInPlace(wheel=0, onset=1.04, recovery=9.0)
    simulator = start(fault, momentum=0.2, **REAL)
    torque, momentum = run(simulator, np.full((40, 1), 0.1))
    held = torque[10, 0]
    motor = 0.1 * (1.0 - np.exp(-1.04 / 0.05))
    struck = momentum[10, 0] + 0.06 * held  # N m s at the onset, within the period
    assert held == pytest.approx(motor + FRICTION.torque(struck / SPIN), rel=1e-12)
    assert momentum[10, 0] > 0.0 > momentum[39, 0]
    np.testing.assert_array_equal(torque[10:40, 0], held)
    np.testing.assert_allclose(np.diff(momentum[10:40, 0]), -PERIOD * held, rtol=1e-9)
    # Whatever it is told meanwhile; afterwards the motor goes on from where it was held.
    torque, _ = run(simulator, np.full((50, 1), -0.2))
    np.testing.assert_array_equal(torque[:, 0], held)
    torque, momentum = run(simulator, np.full((1, 1), -0.2))
    drag = FRICTION.torque(momentum[0, 0] / SPIN)
    assert torque[0, 0] - drag == pytest.approx(-0.2 + (motor + 0.2) * np.exp(-2.0), abs=1e-12)


def test_a_lock_at_the_momentum_limit_holds_nothing():
    simulator = start(LockInPlace(wheel=0, onset=3.0), momentum=0.9, momentum_limit=1.0, **REAL)
    torque, momentum = run(simulator, [-0.2] * 30 + [0.2] * 20)
    assert np.all(torque[29:, 0] == 0.0) and np.all(momentum[29:, 0] == 1.0)


def test_a_late_command_is_answered_late_and_otherwise_alike():
    commands = np.random.default_rng(0).uniform(-0.2, 0.2, (40, 4))
    for periods in (1, 5):
        faults = [CommandDelay(wheel=wheel, periods=periods) for wheel in range(3)]
        late = run(start(*faults, **REAL), commands)
        prompt = run(start(**REAL), commands)
        for delayed, usual in zip(late, prompt, strict=True):
            assert np.all(delayed[:periods, :3] == 0.0)
            np.testing.assert_array_equal(delayed[periods:, :3], usual[:-periods, :3])
            np.testing.assert_array_equal(delayed[:, 3], usual[:, 3])


def test_a_delay_that_begins_repeats_commands():
    commands = np.random.default_rng(0).uniform(-0.2, 0.2, (20, 4))
    fault = CommandDelay(wheel=2, onset=1.0, recovery=1.5, periods=3)
    torque, momentum = run(start(fault, spin_inertia=SPIN), commands)
    obeyed = np.r_[0:10, 7:12, 15:20]
    np.testing.assert_array_equal(torque[:, 2], commands[obeyed, 2])
    np.testing.assert_allclose(momentum[-1, 2], -PERIOD * commands[obeyed, 2].sum(), atol=1e-14)


def test_a_wheel_that_shuts_down_runs_out_and_is_started_again():
    friction = Friction(coulomb=4e-3)
    fault = IntermittentShutdown(wheel=1, onset=2.0, mean_acting=4.0, mean_resting=4.0)
    simulator = start(fault, momentum=2.0, duration=60.0, spin_inertia=SPIN, friction=friction)
    flips = simulator.faults.switches[0, 0]
    torque, momentum = run(simulator, np.full((600, 1), 0.02))
    steps = np.arange(3000) * 0.02
    shut = (steps >= 2.0 - 1e-9) & (np.searchsorted(flips, steps + 1e-9) % 2 == 0)
    assert 0.2 < shut.mean() < 0.8
    push = np.where(shut, 0.0, 0.02) + 4e-3
    expected = 2.0 - 0.02 * np.cumsum(push)[4::5]
    moving = expected > 0.1
    assert moving.sum() > 300
    np.testing.assert_allclose(momentum[moving, 1], expected[moving], rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(torque[moving, 1], push[4::5][moving], rtol=1e-12)


@pytest.mark.parametrize(("onset", "first_step"), [(0.0, 0), (0.02, 1), (0.061, 4), (0.1, 5)])
def test_faults_of_real_wheels_begin_at_the_next_physics_step(onset, first_step):
    faults = (
        Outage(wheel=0, onset=onset),
        Seizure(wheel=1, onset=onset, brake=2.0),
        LossOfEffectiveness(wheel=2, onset=onset, effectiveness=0.5),
        FrictionRise(wheel=3, onset=onset, factor=3.0, rise=0.0),
    )
    simulator = start(*faults, momentum=1.0, spin_inertia=SPIN, friction=Friction(coulomb=0.01))
    _, momentum = run(simulator, np.full((2, 1), 0.1))
    after = (10 - first_step) * 0.02
    expected = 1.0 - 0.2 * (0.1 + 0.01) - after * np.array([-0.1, 0.4, -0.05, 0.02])
    np.testing.assert_allclose(momentum[-1], expected, rtol=0.0, atol=1e-13)
