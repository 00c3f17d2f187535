"""Labels that depend on what is asked: momentum to hold, friction to overcome, and time to turn; solved by hand.

Three orthogonal wheels of 0.2 N m, a fifth of which is kept for control, turn a body of 10 kg m^2 about x with
0.016 rad/s^2; success must be held for the last 20 s.
"""

import math
from dataclasses import replace

import numpy as np
import pytest

from ftac_gym.faults import (
    AttitudeSpike,
    CommandDelay,
    FaultSchedule,
    FrictionRise,
    GyroBiasStep,
    IntermittentShutdown,
    LossOfEffectiveness,
    Outage,
    Seizure,
    StarTrackerOutage,
)
from ftac_gym.spacecraft import Friction, Spacecraft, WheelArray
from ftac_gym.task import Disturbance, InitialState, MRPSinusoid, Scenario, SetPoints

WHEELS = WheelArray(np.eye(3), 0.2, 12.0)
PYRAMID = WheelArray.sign_pyramid(0.2, 12.0)
HOLD = 20.0  # s
ACCELERATION = 0.8 * 0.2 / 10.0  # rad/s^2
ANGLE = 0.5 * math.pi
DIRECT = 2.0 * math.sqrt(ANGLE / ACCELERATION)  # s, 19.8


def feasible(*faults, wheels=WHEELS, angle=0.0, rate=0.0, momentum=0.0, duration=100.0, **changes):
    attitude = (math.cos(0.5 * angle), math.sin(0.5 * angle), 0.0, 0.0)
    scenario = Scenario(**{
        "name": "demand",
        "spacecraft": Spacecraft(np.diag([10.0, 12.0, 14.0]), wheels),
        "initial_state": InitialState.fixed(attitude=attitude, rate=(rate, 0.0, 0.0), wheel_momentum=momentum),
        "faults": FaultSchedule(faults),
        "duration": duration,
        **changes,
    })  # fmt: skip
    return bool(scenario.draw(0, 1).feasible[0])


def rounded(time):
    """A duration on the grid of control periods."""
    return round(time, 1)


# ------------------------------------------------------------------------------------------------------------- time


@pytest.mark.parametrize("angle", [0.1, ANGLE, math.pi])
def test_a_turn_takes_twice_the_root_of_angle_over_acceleration(angle):
    needed = 2.0 * math.sqrt(angle / ACCELERATION) + HOLD
    assert feasible(angle=angle, duration=rounded(needed + 0.1))
    assert not feasible(angle=angle, duration=rounded(needed - 0.1))


def test_a_turn_that_the_momentum_limits_coasts():
    wheels = WheelArray(np.eye(3), 0.2, 1.0)  # 0.1 rad/s at most
    needed = ANGLE / 0.1 + 0.1 / ACCELERATION + HOLD
    assert needed > DIRECT + HOLD + 2.0
    assert feasible(angle=ANGLE, wheels=wheels, duration=rounded(needed + 0.1))
    assert not feasible(angle=ANGLE, wheels=wheels, duration=rounded(needed - 0.1))


def test_an_initial_rate_must_be_stopped_first():
    needed = DIRECT + 0.04 / ACCELERATION + HOLD
    assert feasible(angle=ANGLE, rate=0.04, duration=rounded(needed + 0.1))
    assert not feasible(angle=ANGLE, rate=-0.04, duration=rounded(needed - 0.1))


def test_a_disturbance_slows_the_turn_down():
    push = Disturbance(constant=(0.04, 0.0, 0.0))
    needed = 2.0 * math.sqrt(ANGLE / (0.12 / 10.0)) + HOLD
    assert feasible(angle=ANGLE, disturbance=push, duration=rounded(needed + 0.1))
    assert not feasible(angle=ANGLE, disturbance=push, duration=rounded(needed - 0.1))


def test_a_fault_after_the_turn_leaves_it_alone():
    weak = {"wheel": 0, "effectiveness": 0.01}
    assert feasible(LossOfEffectiveness(**weak, onset=DIRECT + 0.1), angle=ANGLE)
    assert not feasible(LossOfEffectiveness(**weak, onset=DIRECT - 0.1), angle=ANGLE)


def test_a_fault_before_the_end_of_the_turn_makes_it_start_again():
    half = 2.0 * math.sqrt(ANGLE / (0.5 * ACCELERATION))
    for onset in (0.0, 10.0):
        needed = onset + half + HOLD
        fault = LossOfEffectiveness(wheel=0, effectiveness=0.5, onset=onset)
        assert feasible(fault, angle=ANGLE, duration=rounded(needed + 0.2))
        assert not feasible(fault, angle=ANGLE, duration=rounded(needed - 0.2))


def test_the_turn_may_lie_between_two_faults_or_after_the_last():
    half = 2.0 * math.sqrt(ANGLE / (0.5 * ACCELERATION))  # s, 28.0
    early = LossOfEffectiveness(wheel=0, effectiveness=0.5, onset=1.0)
    late = LossOfEffectiveness(wheel=1, effectiveness=0.9, onset=1.0 + half - 0.1)
    needed = 1.0 + half - 0.1 + half + HOLD
    assert feasible(early, late, angle=ANGLE, duration=rounded(needed + 0.2))
    assert not feasible(early, late, angle=ANGLE, duration=rounded(needed - 0.2))
    later = replace(late, onset=1.0 + half + 0.1)
    assert feasible(early, later, angle=ANGLE, duration=rounded(1.0 + half + HOLD + 0.2))


def test_what_takes_away_no_torque_takes_no_time():
    # No fault at 15 s may make the turn start again.
    others = (
        CommandDelay(wheel=0, onset=15.0),
        GyroBiasStep(onset=15.0, size=0.01),
        StarTrackerOutage(onset=15.0),
        AttitudeSpike(onset=15.0, angle=1.0),
    )
    assert feasible(*others, angle=ANGLE, duration=rounded(DIRECT + HOLD + 0.2))


def test_the_last_set_point_must_be_reached():
    turn = (math.cos(0.5 * ANGLE), math.sin(0.5 * ANGLE), 0.0, 0.0)
    command = SetPoints(((1.0, 0.0, 0.0, 0.0), turn), (0.0, 40.0))
    needed = 40.0 + DIRECT + HOLD
    assert feasible(reference=command, duration=rounded(needed + 0.1))
    assert not feasible(reference=command, duration=rounded(needed - 0.1))


def test_moving_references_are_not_asked_for_time():
    moving = MRPSinusoid(amplitude=(0.1, 0.1, 0.1), frequency=(0.01, 0.01, 0.01))
    assert feasible(reference=moving, angle=math.pi, duration=21.0)
    assert not feasible(angle=math.pi, duration=21.0)


# --------------------------------------------------------------------------------------------------------- momentum


@pytest.mark.parametrize(("momentum", "expected"), [(11.9, True), (12.1, False)])
def test_the_momentum_at_the_start_must_fit_in_any_direction(momentum, expected):
    # 12.1 N m s along z fit into two of four pyramid wheels or more, but along x they would not.
    spread = WheelArray(np.eye(3), 0.2, (12.0, 20.0, 20.0))
    assert feasible(wheels=spread, momentum=(0.0, momentum, 0.0)) == expected


def test_body_and_wheels_add_up():
    spread = WheelArray(np.eye(3), 0.2, (12.0, 20.0, 20.0))
    assert feasible(wheels=spread, momentum=(11.0, 0.0, 0.0), rate=0.09)
    assert not feasible(wheels=spread, momentum=(11.0, 0.0, 0.0), rate=0.11)
    assert feasible(wheels=spread, momentum=(11.0, 0.0, 0.0), rate=-0.11)  # against each other


def test_torquers_without_stored_momentum_carry_none():
    spread = WheelArray(np.eye(3), 0.2, (12.0, 20.0, 20.0), momentum_coupling=False)
    assert feasible(wheels=spread, momentum=(0.0, 19.0, 0.0))


@pytest.mark.parametrize(("push", "expected"), [(0.119, True), (0.121, False)])
def test_a_disturbance_fills_the_wheels(push, expected):
    assert feasible(disturbance=Disturbance(constant=(push, 0.0, 0.0)), duration=100.0) == expected


def test_after_a_loss_the_others_must_hold_the_momentum():
    # The envelope of three wheels of the pyramid reaches 0.816 times a wheel's limit in its weakest direction.
    reach = 12.0 * 2.0 * math.sqrt(6.0) / 6.0
    assert feasible(Outage(wheel=3), wheels=PYRAMID, momentum=(0.99 * reach, 0.0, 0.0, 0.0))
    assert not feasible(Outage(wheel=3), wheels=PYRAMID, momentum=(1.01 * reach, 0.0, 0.0, 0.0))
    assert feasible(wheels=PYRAMID, momentum=(1.01 * reach, 0.0, 0.0, 0.0))


# --------------------------------------------------------------------------------------------------- dead and rubbing


@pytest.mark.parametrize("fault", [Seizure(wheel=0, onset=30.0), IntermittentShutdown(wheel=0, onset=30.0)])
def test_a_seized_or_stopping_wheel_counts_as_dead(fault):
    assert not feasible(fault)
    assert feasible(fault, wheels=PYRAMID)


def rubbing(breakaway, viscous=0.0):
    return replace(WHEELS, spin_inertia=0.02, friction=Friction(0.5 * breakaway, breakaway, viscous=viscous))


@pytest.mark.parametrize(("breakaway", "expected"), [(0.159, True), (0.161, False)])
def test_friction_must_leave_the_reserve(breakaway, expected):
    assert feasible(wheels=rubbing(breakaway)) == expected
    assert feasible(FrictionRise(wheel=1, onset=5.0, factor=4.0), wheels=rubbing(0.25 * breakaway)) == expected


def test_friction_that_rises_after_the_end_does_not_count():
    assert feasible(FrictionRise(wheel=1, onset=100.0, factor=4.0), wheels=rubbing(0.05))
    assert not feasible(FrictionRise(wheel=1, onset=99.0, factor=4.0), wheels=rubbing(0.05))


def test_viscous_friction_counts_at_the_momentum_limit():
    fastest = 12.0 / 0.02
    assert feasible(wheels=rubbing(0.06, 0.099 / fastest))
    assert not feasible(wheels=rubbing(0.06, 0.101 / fastest))


def test_friction_slows_the_turn_down():
    needed = 2.0 * math.sqrt(ANGLE / (0.12 / 10.0)) + HOLD
    assert feasible(wheels=rubbing(0.04), angle=ANGLE, duration=rounded(needed + 0.1))
    assert not feasible(wheels=rubbing(0.04), angle=ANGLE, duration=rounded(needed - 0.1))
