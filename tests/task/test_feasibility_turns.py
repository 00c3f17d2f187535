"""Labels of :mod:`ftac_gym.task.feasibility` for turns about any axis, between faults, and with wheels that rub."""

import math

import numpy as np
import pytest

from ftac_gym.faults import (
    AttitudeSpike,
    CommandDelay,
    DriftingEffectiveness,
    FaultSchedule,
    FrictionRise,
    GyroBiasStep,
    LossOfEffectiveness,
    StarTrackerOutage,
)
from ftac_gym.spacecraft import Friction, Spacecraft, WheelArray
from ftac_gym.task import Disturbance, InitialState, Scenario, SetPoints
from ftac_gym.task.feasibility import TORQUE_RESERVE

H = 12.0  # N m s: limit of a wheel
ORTHOGONAL = WheelArray(np.eye(3), 0.2, H)


def feasible(*faults, wheels, duration=100.0, attitude=(1.0, 0.0, 0.0, 0.0), rate=(0.0,) * 3, momentum=0.0, **parts):
    scenario = Scenario(
        name="label",
        spacecraft=Spacecraft(np.diag([10.0, 12.0, 14.0]), wheels),
        initial_state=InitialState.fixed(attitude, rate, momentum),
        faults=FaultSchedule(faults) if faults else None,
        duration=duration,
        **parts,
    )
    return bool(scenario.draw(0, 1).feasible[0])


# ---------------------------------------------------------------------------------------------------- time to turn

FREE = (1.0 - TORQUE_RESERVE) * 0.2  # N m
ANGLE = 0.5 * math.pi
ABOUT_X = (math.cos(0.5 * ANGLE), math.sin(0.5 * ANGLE), 0.0, 0.0)
HOLD = 20.0  # s at the end of an episode, on target
TURN = 2.0 * math.sqrt(ANGLE * 10.0 / FREE)  # s, from rest to rest


def just(time, expected):
    """A duration, a multiple of the control period, that leaves a little more or less than a time before the hold."""
    return round((math.ceil if expected else math.floor)(10.0 * (time + HOLD)) / 10.0, 6)


BOTH = pytest.mark.parametrize("expected", [True, False])


@BOTH
def test_time_for_a_turn_about_one_axis(expected):
    assert pytest.approx(19.8, abs=0.05) == TURN
    for sign in (-1.0, 1.0):
        turned = (ABOUT_X[0], sign * ABOUT_X[1], 0.0, 0.0)
        assert feasible(wheels=ORTHOGONAL, attitude=turned, duration=just(TURN, expected)) == expected
        # The same attitude with the other sign is no turn of 270 degrees.
        turned = tuple(-part for part in turned)
        assert feasible(wheels=ORTHOGONAL, attitude=turned, duration=just(TURN, expected)) == expected
    about_z = (ABOUT_X[0], 0.0, 0.0, ABOUT_X[1])
    time = 2.0 * math.sqrt(ANGLE * 14.0 / FREE)
    assert feasible(wheels=ORTHOGONAL, attitude=about_z, duration=just(time, expected)) == expected
    # About the diagonal of x and y, the wheel along y gives out first.
    slanted = (ABOUT_X[0], math.sqrt(0.5) * ABOUT_X[1], math.sqrt(0.5) * ABOUT_X[1], 0.0)
    time = 2.0 * math.sqrt(ANGLE * 12.0 * math.sqrt(0.5) / FREE)
    assert feasible(wheels=ORTHOGONAL, attitude=slanted, duration=just(time, expected)) == expected


@BOTH
def test_a_momentum_limit_makes_the_turn_coast(expected):
    wheels = WheelArray(np.eye(3), 0.2, 0.3)  # N m s: at most 0.03 rad/s
    time = ANGLE / 0.03 + 0.03 / (FREE / 10.0)
    assert feasible(wheels=wheels, attitude=ABOUT_X, duration=just(time, expected)) == expected
    # What is stored already, whichever way, is not there for the turn.
    time = ANGLE / 0.02 + 0.02 / (FREE / 10.0)
    for momentum in ((0.1, 0.0, 0.0), (0.0, -0.1, 0.0)):
        duration = just(time, expected)
        assert feasible(wheels=wheels, attitude=ABOUT_X, momentum=momentum, duration=duration) == expected
    # A speed limit is a momentum limit.
    fast = WheelArray(np.eye(3), 0.2, spin_inertia=0.02, speed_limit=15.0)
    duration = just(ANGLE / 0.03 + 0.03 / (FREE / 10.0), expected)
    assert feasible(wheels=fast, attitude=ABOUT_X, duration=duration) == expected


@BOTH
def test_an_initial_rate_must_be_braked_first(expected):
    rate, acceleration = 0.081, FREE / 10.0
    stopping = rate / acceleration
    assert feasible(wheels=ORTHOGONAL, rate=(0.0, rate, 0.0), duration=just(stopping, expected)) == expected
    duration = just(TURN + stopping, expected)
    assert feasible(wheels=ORTHOGONAL, attitude=ABOUT_X, rate=(0.0, 0.0, rate), duration=duration) == expected


def test_the_turn_fits_before_the_fault_or_after_it():
    slow = 2.0 * math.sqrt(ANGLE * 10.0 / (0.5 * FREE))  # s with half the torque
    assert (slow, 40.0 - slow) == pytest.approx((28.02, 11.98), abs=0.01)
    for onset, expected in ((0.0, True), (11.9, True), (12.1, False), (19.7, False), (19.9, True), (35.0, True)):
        fault = LossOfEffectiveness(wheel=0, onset=onset, effectiveness=0.5)
        assert feasible(fault, wheels=ORTHOGONAL, attitude=ABOUT_X, duration=60.0) == expected


def test_the_turn_fits_between_two_faults_or_after_both():
    # Neither fault takes anything from a turn about x, but each makes it start again: 19.8 s, before 40 s are over.
    early = LossOfEffectiveness(wheel=1, onset=5.0, effectiveness=0.9)
    for onset, expected in ((5.0, True), (20.1, True), (20.3, False), (24.7, False), (24.9, True), (70.0, True)):
        late = LossOfEffectiveness(wheel=1, onset=onset, effectiveness=0.9)
        for faults in ((early, late), (late, early)):
            assert feasible(*faults, wheels=ORTHOGONAL, attitude=ABOUT_X, duration=60.0) == expected


@BOTH
def test_of_several_set_points_the_last_turn_is_asked(expected):
    points = SetPoints(((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), ABOUT_X), (0.0, 10.0, 30.0))
    assert feasible(wheels=ORTHOGONAL, reference=points, duration=just(30.0 + TURN, expected)) == expected


def test_delays_and_faults_of_sensors_do_not_matter():
    faults = (
        CommandDelay(wheel=0, onset=5.0, periods=5),
        CommandDelay(wheel=1, onset=75.0, periods=5),
        GyroBiasStep(onset=5.0),
        StarTrackerOutage(onset=1.0),
        AttitudeSpike(onset=79.0),
    )
    for expected in (True, False):
        duration = just(TURN, expected)
        for chosen in [(fault,) for fault in faults] + [faults, faults[:2]]:
            assert feasible(*chosen, wheels=ORTHOGONAL, attitude=ABOUT_X, duration=duration) == expected
    assert feasible(*faults, wheels=ORTHOGONAL, attitude=ABOUT_X)
    # Nor do they take the time before another fault away.
    fault = LossOfEffectiveness(wheel=0, onset=75.0, effectiveness=0.5)
    assert feasible(*faults, fault, wheels=ORTHOGONAL, attitude=ABOUT_X)


# -------------------------------------------------------------------------------------------------------- friction


def rubbing(friction, **changes):
    return WheelArray(**{"axes": np.eye(3), "torque_limit": 0.2, "momentum_limit": H, "spin_inertia": 0.02, **changes},
                      friction=friction)  # fmt: skip


@pytest.mark.parametrize(("side", "expected"), [(-1e-3, True), (1e-3, False)])
def test_friction_takes_its_share_of_the_torque(side, expected):
    friction = Friction(coulomb=5e-3, breakaway=1e-2, viscous=1e-4)  # 0.06 N m at 600 rad/s

    def asked(push, *faults, wheels):
        return feasible(*faults, wheels=wheels, duration=30.0, disturbance=Disturbance((push + side, 0, 0)))

    assert asked(FREE - 0.07, wheels=rubbing(friction)) == expected
    assert asked(FREE - 0.01, wheels=rubbing(friction, momentum_limit=None)) == expected
    assert asked(FREE - 0.01 - 0.03, wheels=rubbing(friction, speed_limit=300.0)) == expected
    assert asked(FREE, wheels=rubbing((None, friction, friction))) == expected
    for direction in ("both", "forward", "backward", "either"):
        risen = FrictionRise(wheel=0, factor=4.0, direction=direction, onset=3.0)
        assert asked(FREE - 0.10, risen, wheels=rubbing(friction)) == expected
        elsewhere = FrictionRise(wheel=1, factor=4.0, direction=direction, onset=3.0)
        assert asked(FREE - 0.07, elsewhere, wheels=rubbing(friction)) == expected
    late = FrictionRise(wheel=0, factor=4.0, onset=30.0)
    assert asked(FREE - 0.07, late, wheels=rubbing(friction)) == expected
    drifting = DriftingEffectiveness(wheel=0, effectiveness=0.8)
    assert asked(0.8 * FREE - 0.07, drifting, wheels=rubbing(friction)) == expected


@BOTH
def test_friction_slows_the_turn(expected):
    wheels = rubbing(Friction(coulomb=0.05))
    time = 2.0 * math.sqrt(ANGLE * 10.0 / (FREE - 0.05))
    assert feasible(wheels=wheels, attitude=ABOUT_X, duration=just(time, expected)) == expected
    # Risen friction holds after the fault, not before it.
    fault = FrictionRise(wheel=0, factor=2.0, onset=0.0)
    slower = 2.0 * math.sqrt(ANGLE * 10.0 / (FREE - 0.10))
    assert feasible(fault, wheels=wheels, attitude=ABOUT_X, duration=just(slower, expected)) == expected
    fault = FrictionRise(wheel=0, factor=2.0, onset=time + (0.05 if expected else -0.05))
    assert feasible(fault, wheels=wheels, attitude=ABOUT_X, duration=60.0) == expected


def test_wheels_without_limits_do_anything_at_once():
    wheels = WheelArray(np.eye(3), None)
    assert feasible(wheels=wheels, attitude=(0.0, 1.0, 0.0, 0.0), rate=(1.0, 1.0, 1.0), duration=20.1)
