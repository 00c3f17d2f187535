"""Labels of feasibility for cases solved by hand."""

import itertools
import math

import numpy as np
import pytest

from ftac_gym import faults
from ftac_gym.spacecraft import Spacecraft, WheelArray
from ftac_gym.task import Disturbance, Harmonic, InitialState, Scenario
from ftac_gym.task.feasibility import TORQUE_RESERVE

PYRAMID = WheelArray.sign_pyramid(0.2, 12.0)
ORTHOGONAL = WheelArray(np.eye(3), 0.2, 12.0)
ROOMY = WheelArray(np.eye(3), 0.2, 100.0)
DISTANCE = 0.5 * math.sqrt(2.0)
SIX = WheelArray(DISTANCE * np.array([[1, 1, 1, 1, 0, 0], [1, -1, 0, 0, 1, 1], [0, 0, 1, -1, 1, -1]]), torque_limit=0.2)


def feasible(
    *listed, wheels=PYRAMID, duration=100.0, attitude=(1.0, 0.0, 0.0, 0.0), rate=(0.0,) * 3, momentum=0.0, **parts
):
    scenario = Scenario(
        name="label",
        spacecraft=Spacecraft(np.diag([10.0, 12.0, 14.0]), wheels),
        initial_state=InitialState.fixed(attitude, rate, momentum),
        faults=faults.FaultSchedule(listed) if listed else None,
        duration=duration,
        **parts,
    )
    labels = scenario.draw(0, 2).feasible
    assert labels.shape == (2,) and labels.dtype == np.bool_ and labels[0] == labels[1]
    return bool(labels[0])


def test_healthy_wheels_are_feasible():
    for wheels in (PYRAMID, ORTHOGONAL, SIX):
        assert feasible(wheels=wheels)


@pytest.mark.parametrize("kind", [faults.Outage, faults.LockInPlace])
def test_one_dead_wheel(kind):
    for wheel in range(3):
        assert not feasible(kind(wheel=wheel, onset=5.0), wheels=ORTHOGONAL)
    for wheel in range(4):
        assert feasible(kind(wheel=wheel, onset=5.0), wheels=PYRAMID)


def test_two_dead_wheels():
    for pair in itertools.combinations(range(4), 2):
        assert not feasible(*(faults.Outage(wheel=wheel) for wheel in pair), wheels=PYRAMID)
        assert feasible(*(faults.Outage(wheel=wheel) for wheel in pair), wheels=SIX)


def test_hard_over_on_the_sign_pyramid():
    # Wheel 0 = wheel 1 - wheel 2 + wheel 3: to hold a fraction f of its limit each of the others must give f.
    edge = 1.0 - TORQUE_RESERVE
    for wheel, sign in itertools.product(range(4), (-1.0, 1.0)):
        for fraction, expected in ((1.0, False), (1.01 * edge, False), (0.99 * edge, True), (0.5, True)):
            fault = faults.HardOver(wheel=wheel, fraction=sign * fraction, random_sign=False, onset=40.0)
            assert feasible(fault) == expected


def test_equal_wheels_get_equal_labels():
    # 0.15 N m for 100 s fills the wheel, and so the three others to the brim: the edge of the envelope.
    labels = {
        feasible(faults.HardOver(wheel=wheel, fraction=sign * 0.75, random_sign=False))
        for wheel, sign in itertools.product(range(4), (-1.0, 1.0))
    }
    assert len(labels) == 1


def test_bias_counts_against_the_wheel_itself():
    free = (1.0 - TORQUE_RESERVE) * 0.2
    for sign in (-1.0, 1.0):
        assert feasible(faults.Bias(wheel=0, constant=0.99 * sign * free), wheels=ORTHOGONAL)
        assert not feasible(faults.Bias(wheel=0, constant=1.01 * sign * free), wheels=ORTHOGONAL)


def test_bias_is_judged_at_its_worst():
    free = (1.0 - TORQUE_RESERVE) * 0.2
    slow, fast = 0.99 * free / 80.0, 1.01 * free / 80.0
    assert feasible(faults.Bias(wheel=0, onset=20.0, slope=slow), wheels=ORTHOGONAL)
    assert not feasible(faults.Bias(wheel=0, onset=20.0, slope=fast), wheels=ORTHOGONAL)
    assert feasible(faults.Bias(wheel=0, onset=20.0, recovery=60.0, slope=fast), wheels=ORTHOGONAL)
    assert not feasible(faults.Bias(wheel=0, constant=-0.1, amplitude=0.07, frequency=1.0), wheels=ORTHOGONAL)
    assert feasible(faults.Bias(wheel=0, constant=-0.1, amplitude=0.05, frequency=1.0), wheels=ORTHOGONAL)
    assert not feasible(
        faults.Bias(wheel=0, amplitude=1.01 * free / 100.0, exponent=1.0, frequency=1.0), wheels=ORTHOGONAL
    )
    assert feasible(faults.Bias(wheel=0, amplitude=0.99 * free / 100.0, exponent=1.0, frequency=1.0), wheels=ORTHOGONAL)


def test_loss_of_effectiveness_is_judged_at_its_worst():
    push = Disturbance(constant=(0.05, 0.0, 0.0))  # needs e * 0.8 * 0.2 >= 0.05, so e >= 0.3125
    for effectiveness, expected in ((0.32, True), (0.30, False)):
        fault = faults.LossOfEffectiveness(wheel=0, effectiveness=effectiveness)
        assert feasible(fault, wheels=ORTHOGONAL, disturbance=push) == expected
        swinging = faults.LossOfEffectiveness(wheel=0, effectiveness=effectiveness + 0.2, amplitude=0.2, frequency=1.0)
        assert feasible(swinging, wheels=ORTHOGONAL, disturbance=push) == expected


@pytest.mark.parametrize(("size", "expected"), [(0.159, True), (0.161, False)])
def test_disturbance_must_leave_the_reserve(size, expected):
    assert feasible(wheels=ROOMY, disturbance=Disturbance(constant=(0.0, size, 0.0))) == expected
    swing = Disturbance((0.0, 0.1, 0.0), (Harmonic((0.0, size - 0.1, 0.0), frequency=1.0, phase=(0.0, 2.0, 0.0)),))
    assert feasible(wheels=ROOMY, disturbance=swing) == expected
    scaled = Disturbance((0.0, 4.0 * size, 0.0), rate_offset=0.0)
    assert feasible(wheels=ROOMY, disturbance=scaled, rate=(0.5, 0.0, 0.0)) == expected


def test_a_fault_after_the_end_does_not_count():
    for onset, expected in ((99.9, False), (100.0, True), (500.0, True)):
        assert feasible(faults.Outage(wheel=0, onset=onset), wheels=ORTHOGONAL) == expected


def test_momentum_of_a_runaway_wheel_must_fit_into_the_others():
    wheels = WheelArray(PYRAMID.axes, 0.2, (12.0, 4.0, 4.0, 4.0))
    fault = {"wheel": 0, "fraction": 0.25, "random_sign": False}  # 0.05 N m for 100 s pours 5 N m s
    assert not feasible(faults.HardOver(**fault), wheels=wheels)
    assert feasible(faults.HardOver(**fault), wheels=PYRAMID)
    assert feasible(faults.HardOver(**fault, recovery=79.0), wheels=wheels)
    assert not feasible(faults.HardOver(**fault, recovery=81.0), wheels=wheels)
    assert feasible(faults.HardOver(**fault, onset=21.0), wheels=wheels)
    small = WheelArray(PYRAMID.axes, 0.2, (3.9, 4.0, 4.0, 4.0))  # ... but no more than the wheel itself can hold
    assert feasible(faults.HardOver(**fault), wheels=small)


def test_opposite_faults_at_different_times_do_not_cancel():
    early = faults.HardOver(wheel=0, fraction=1.0, random_sign=False, onset=0.0, recovery=10.0)
    late = faults.HardOver(wheel=0, fraction=-1.0, random_sign=False, onset=20.0, recovery=30.0)
    assert not feasible(early) and not feasible(late)
    assert not feasible(early, late)


def test_a_dead_wheel_with_a_bias_runs_away_too():
    wheels = WheelArray(PYRAMID.axes, 0.2, (12.0, 4.0, 4.0, 4.0))
    assert not feasible(faults.Outage(wheel=0), faults.Bias(wheel=0, constant=0.05), wheels=wheels)


H = 12.0  # N m s: limit of the wheels of both arrays


@pytest.mark.parametrize(("share", "expected"), [(0.99, True), (1.01, False)])
def test_the_total_momentum_must_fit_in_any_direction(share, expected):
    # Three orthogonal wheels hold the ball of their own limit; where it points now does not matter.
    pair = share * H / math.sqrt(2.0)
    for momentum in ((pair, pair, 0.0), (0.0, -pair, pair), (-pair, 0.0, -pair)):
        assert feasible(wheels=ORTHOGONAL, momentum=momentum) == expected
    # The body's own momentum counts too: 14 kg m^2 about z.
    assert feasible(wheels=ORTHOGONAL, momentum=(0.0, 0.0, 5.0), rate=(0.0, 0.0, (share * H - 5.0) / 14.0)) == expected
    # And what the disturbance may add in 100 s, which is the same for a torque that swings.
    push = (share * H - 8.0) / 100.0
    assert feasible(wheels=ORTHOGONAL, momentum=(8.0, 0, 0), disturbance=Disturbance((0.0, push, 0.0))) == expected
    swing = Disturbance((0.0,) * 3, (Harmonic((0.0, push, 0.0), frequency=1.0),))
    assert feasible(wheels=ORTHOGONAL, momentum=(8.0, 0, 0), disturbance=swing) == expected


def test_opposite_momenta_cancel_and_torquers_store_none():
    assert feasible(wheels=ORTHOGONAL, momentum=(0.9 * H, 0.0, 0.0), rate=(-0.8 * H / 10.0, 0.0, 0.0))
    torquers = WheelArray(np.eye(3), 0.2, H, momentum_coupling=False)
    assert feasible(wheels=torquers, momentum=(0.9 * H,) * 3)


@pytest.mark.parametrize("kind", [faults.Outage, faults.Seizure, faults.IntermittentShutdown])
@pytest.mark.parametrize(("share", "expected"), [(0.99, True), (1.01, False)])
def test_the_momentum_of_a_floating_or_seized_wheel_goes_to_the_others(kind, share, expected):
    # Three wheels of the sign pyramid hold a ball of sqrt(2/3) of their limit.
    ball = math.sqrt(2.0 / 3.0) * H
    for wheel in range(4):
        momentum = share * ball * np.eye(4)[wheel]
        assert feasible(wheels=PYRAMID, momentum=momentum)
        for dead in range(4):
            assert feasible(kind(wheel=dead, onset=50.0), wheels=PYRAMID, momentum=momentum) == expected


def test_a_seized_wheel_counts_as_dead():
    for wheel in range(3):
        assert not feasible(faults.Seizure(wheel=wheel, onset=5.0), wheels=ORTHOGONAL)
        # ... even if it would let go: the label looks at the worst moment.
        assert not feasible(faults.Seizure(wheel=wheel, onset=5.0, recovery=6.0), wheels=ORTHOGONAL)
    for wheel in range(4):
        assert feasible(faults.Seizure(wheel=wheel, onset=5.0), wheels=PYRAMID)
    assert not feasible(faults.Seizure(wheel=0), faults.Outage(wheel=2), wheels=PYRAMID)
    assert feasible(faults.Seizure(wheel=0), faults.Outage(wheel=2), wheels=SIX)


@pytest.mark.parametrize("count", [1, 2])
@pytest.mark.parametrize("limits", [(0.2, 1.0), (None, None), (0.2, None), (None, 1.0)])
def test_one_or_two_wheels_are_never_enough(count, limits):
    wheels = WheelArray(np.eye(3)[:, :count], *limits)
    for attitude in ((1.0, 0.0, 0.0, 0.0), (0.6, 0.8, 0.0, 0.0)):
        assert not feasible(wheels=wheels, attitude=attitude, rate=(0.01, 0.0, 0.0))
        assert not feasible(wheels=wheels, attitude=attitude)
