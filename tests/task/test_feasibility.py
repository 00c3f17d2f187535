"""Labels of feasibility for cases solved by hand.

Three orthogonal wheels of 0.2 N m turn a body of 10 kg m^2 about x with 0.02 rad/s^2. Success asks for 19 of the last
20 s on target.
"""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

from ftac_gym import faults, scenarios
from ftac_gym.attitude import quaternion_from_rotation_vector, rotate_to_body
from ftac_gym.spacecraft import Friction, Spacecraft, WheelArray
from ftac_gym.task import Disturbance, InitialState, MRPSinusoid, RateProfile, SampledReference, Scenario, SetPoints
from ftac_gym.task.feasibility import (
    MOST_STEPS,
    PLANS,
    TORQUE_SHARE,
    flights,
    plan_numbers,
    reference_motion,
    step_count,
)

PYRAMID = WheelArray.sign_pyramid(0.2, 12.0)
ORTHOGONAL = WheelArray(np.eye(3), 0.2, 12.0)
QUARTER = 2.0 * math.sqrt(0.5 * math.pi * 10.0 / 0.2)  # s, 17.7: shortest quarter turn about x from rest to rest
BOTH = pytest.mark.parametrize("expected", [True, False])


def turn(angle, axis=(1.0, 0.0, 0.0)):
    axis = np.array(axis) / np.linalg.norm(axis)
    return (math.cos(0.5 * angle), *(math.sin(0.5 * angle) * axis))


AT_TARGET = turn(0.0)


def feasible(*listed, wheels=PYRAMID, attitude=AT_TARGET, rate=(0.0,) * 3, momentum=0.0, **parts):
    scenario = Scenario(**{
        "name": "label",
        "spacecraft": Spacecraft(np.diag([10.0, 12.0, 14.0]), wheels),
        "initial_state": InitialState.fixed(attitude, rate, momentum),
        "faults": faults.FaultSchedule(listed) if listed else None,
        "duration": 100.0,
        **parts,
    })  # fmt: skip
    labels = scenario.draw(0, 2).feasible
    assert labels.shape == (2,) and labels.dtype == np.bool_ and labels[0] == labels[1]
    return bool(labels[0])


def pushed(x=0.0, y=0.0, z=0.0):
    return Disturbance(constant=(x, y, z))


# ------------------------------------------------------------------------------------------------------------- time


@pytest.mark.parametrize("angle", [0.3, 0.5 * math.pi, math.pi])
def test_a_turn_just_fits_or_just_does_not(angle):
    needed = 2.0 * math.sqrt(angle * 10.0 / 0.2)
    assert feasible(wheels=ORTHOGONAL, attitude=turn(angle), duration=round(1.1 * needed + 20.0, 1))
    assert not feasible(wheels=ORTHOGONAL, attitude=turn(angle), duration=round(0.97 * needed + 19.0, 1))


@BOTH
def test_a_turn_that_the_momentum_limits_coasts(expected):
    wheels = WheelArray(np.eye(3), 0.2, 1.0)  # 0.1 rad/s at most
    needed = 0.5 * math.pi / 0.1 + 0.1 / 0.02
    assert needed > QUARTER + 2.0
    duration = 1.1 * needed + 20.0 if expected else 0.97 * needed + 19.0
    assert feasible(wheels=wheels, attitude=turn(0.5 * math.pi), duration=round(duration, 1)) == expected


@BOTH
def test_an_initial_rate_away_from_the_target_is_braked_first(expected):
    # Away at 0.1 rad/s: 5 s to stop and 0.25 rad further.
    needed = 5.0 + 2.0 * math.sqrt((0.5 * math.pi + 0.25) * 10.0 / 0.2)
    duration = round(1.1 * needed + 20.0 if expected else 0.97 * needed + 19.0, 1)
    start = {"attitude": turn(0.5 * math.pi), "rate": (0.1, 0.0, 0.0)}
    assert feasible(wheels=ORTHOGONAL, duration=duration, **start) == expected


@BOTH
def test_of_several_set_points_the_last_turn_counts(expected):
    points = SetPoints((turn(0.0), turn(math.pi), turn(0.5 * math.pi)), (0.0, 10.0, 60.0))
    duration = 60.0 + (1.1 * QUARTER + 20.0 if expected else 0.9 * QUARTER + 19.0)
    assert feasible(wheels=ORTHOGONAL, reference=points, duration=round(duration, 1)) == expected


@BOTH
def test_a_fault_leaves_the_turn_before_it_alone(expected):
    weak = faults.LossOfEffectiveness(wheel=0, effectiveness=0.01, onset=QUARTER * (1.15 if expected else 0.8))
    assert feasible(weak, wheels=ORTHOGONAL, attitude=turn(0.5 * math.pi), duration=60.0) == expected


def test_a_turn_may_go_on_after_a_fault_that_recovers():
    # From 5 s to 65 s nothing acts about x; a quarter turn with what is left needs 13 s more and 20 s of success.
    out = faults.Outage(wheel=0, onset=5.0, recovery=65.0)
    assert feasible(out, wheels=ORTHOGONAL, attitude=turn(0.5 * math.pi), duration=105.0)
    assert not feasible(out, wheels=ORTHOGONAL, attitude=turn(0.5 * math.pi), duration=80.0)


# ----------------------------------------------------------------------------------------------------------- torque


@pytest.mark.parametrize("kind", [faults.Outage, faults.LockInPlace, faults.Seizure])
def test_a_dead_wheel(kind):
    for wheels, wheel, expected in ((ORTHOGONAL, 0, False), (ORTHOGONAL, 1, True), (PYRAMID, 0, True)):
        fault = kind(wheel=wheel, onset=5.0)
        assert feasible(fault, wheels=wheels, attitude=turn(0.5 * math.pi), disturbance=pushed(1e-3)) == expected


def test_wheels_that_fail_one_after_the_other_do_not_fail_together():
    short = [faults.Outage(wheel=wheel, onset=30.0 + 10.0 * wheel, duration=6.0) for wheel in range(4)]
    assert feasible(*short, attitude=turn(math.pi), disturbance=pushed(1e-3, 1e-3))
    lasting = [replace(fault, duration=None) for fault in short[:2]]
    assert not feasible(*lasting, attitude=turn(math.pi), disturbance=pushed(1e-3, 1e-3))


def test_a_body_at_rest_on_target_needs_no_wheels():
    dead = [faults.Outage(wheel=wheel, onset=60.0) for wheel in range(3)]
    assert feasible(*dead, wheels=ORTHOGONAL, attitude=turn(0.5 * math.pi))
    assert not feasible(*dead, wheels=ORTHOGONAL, attitude=turn(0.5 * math.pi), disturbance=pushed(1e-3))


def test_the_other_three_wheels_hold_one_that_is_stuck():
    # Wheel 0 = wheel 1 - wheel 2 + wheel 3: each of the others must give the same torque.
    for wheel, sign in itertools.product(range(4), (-1.0, 1.0)):
        for fraction, expected in ((0.9, True), (1.0, False)):
            stuck = faults.HardOver(wheel=wheel, fraction=sign * fraction, random_sign=False, onset=60.0)
            assert feasible(stuck, attitude=turn(0.5 * math.pi)) == expected
            # A bias of another wheel takes as much from one side of its torque.
            bias = sign * (1.0 if wheel in (0, 2) else -1.0) * 0.05
            other = faults.Bias(wheel=1 if wheel != 1 else 0, constant=bias, onset=70.0)
            assert feasible(replace(stuck, fraction=sign * 0.7), other)


@BOTH
def test_a_bias_is_held_by_the_wheel_itself(expected):
    size = 0.19 if expected else 0.21
    for sign in (-1.0, 1.0):
        assert feasible(faults.Bias(wheel=0, constant=sign * size), wheels=ORTHOGONAL, duration=50.0) == expected
        slope = sign * size / 50.0
        assert feasible(faults.Bias(wheel=0, slope=slope), wheels=ORTHOGONAL, duration=50.0) == expected


@BOTH
def test_effectiveness_and_friction_against_a_disturbance(expected):
    push, roomy = pushed(0.05), WheelArray(np.eye(3), 0.2, 100.0)
    weak = faults.LossOfEffectiveness(wheel=0, effectiveness=0.28 if expected else 0.24)
    assert feasible(weak, wheels=roomy, disturbance=push) == expected
    rubbing = replace(roomy, spin_inertia=0.02, friction=Friction(coulomb=0.13 if expected else 0.16))
    assert feasible(wheels=rubbing, disturbance=push, momentum=(10.0, 0.0, 0.0)) == expected
    risen = faults.FrictionRise(wheel=0, factor=2.0, rise=0.0)
    half = replace(roomy, spin_inertia=0.02, friction=Friction(coulomb=0.065 if expected else 0.08))
    assert feasible(risen, wheels=half, disturbance=push, momentum=(10.0, 0.0, 0.0)) == expected


@BOTH
def test_misaligned_axes(expected):
    # The true axis of wheel z leans towards x: it acts about z with a tenth of its torque.
    lean = np.zeros((3, 3))
    lean[:, 2] = (math.sqrt(0.99), 0.0, -0.9)
    push = pushed(z=0.01 if expected else 0.03)
    assert feasible(wheels=ORTHOGONAL, misalignment=lean, disturbance=push, duration=60.0) == expected
    assert feasible(wheels=ORTHOGONAL, disturbance=push, duration=60.0)


@BOTH
def test_power_limit(expected):
    # To hold 0.12 N m the wheel goes from 6 to 10.8 N m s in 40 s: 65 W at the end, 36 W at the start.
    limit = 80.0 if expected else 50.0
    wheels = WheelArray(np.eye(3), 0.2, 100.0, spin_inertia=0.02, power_limit=limit)
    assert feasible(wheels=wheels, disturbance=pushed(0.12), momentum=(6.0, 0.0, 0.0), duration=40.0) == expected


# --------------------------------------------------------------------------------------------------------- momentum


def test_momentum_of_a_runaway_wheel_must_fit_into_the_others():
    wheels = WheelArray(PYRAMID.axes, 0.2, (12.0, 4.0, 4.0, 4.0))
    fault = {"wheel": 0, "fraction": 0.25, "random_sign": False}  # 0.05 N m for 100 s pours 5 N m s
    assert not feasible(faults.HardOver(**fault), wheels=wheels)
    assert feasible(faults.HardOver(**fault), wheels=PYRAMID)
    assert feasible(faults.HardOver(**fault, recovery=70.0), wheels=wheels)
    assert feasible(faults.HardOver(**fault, onset=30.0), wheels=wheels)
    assert not feasible(faults.Outage(wheel=0), faults.Bias(wheel=0, constant=0.05), wheels=wheels)


@BOTH
def test_a_disturbance_fills_the_wheels(expected):
    push = pushed(x=0.05 if expected else 0.07)  # 100 s and 6 N m s at the start
    assert feasible(wheels=ORTHOGONAL, momentum=(6.0, 0.0, 0.0), disturbance=push) == expected


def test_the_wheels_must_hold_the_momentum_at_the_target():
    # (h, h, 0) turned by 45 deg about z is along x or y, with sqrt(2) h: 9.9 N m s fits into a wheel, 14.1 does not.
    eighth = turn(0.25 * math.pi, (0.0, 0.0, 1.0))
    assert feasible(wheels=ORTHOGONAL, attitude=eighth, momentum=(7.0, 7.0, 0.0), duration=200.0)
    assert not feasible(wheels=ORTHOGONAL, attitude=eighth, momentum=(10.0, 10.0, 0.0), duration=400.0)
    # A turn about the momentum itself leaves it where it is.
    along = turn(0.25 * math.pi, (1.0, 1.0, 0.0))
    assert feasible(wheels=ORTHOGONAL, attitude=along, momentum=(10.0, 10.0, 0.0))


def test_stored_momentum_must_be_turned_by_torque():
    # 7 N m s across the axis of the turn: the wheels must give 7 * 0.25 pi = 5.5 N m s along the way, at 0.2 N m.
    eighth = {"wheels": ORTHOGONAL, "attitude": turn(0.25 * math.pi)}
    assert feasible(**eighth, momentum=(0.0, 7.0, 0.0), duration=100.0)
    assert not feasible(**eighth, momentum=(0.0, 7.0, 0.0), duration=40.0)
    assert feasible(**eighth, momentum=(7.0, 0.0, 0.0), duration=40.0)
    # Eight N m s a wheel of the flagship are 18.5 N m s along z, and half a turn about x takes 58 N m s.
    assert not feasible(attitude=turn(math.pi), momentum=8.0, duration=120.0)
    assert feasible(attitude=turn(math.pi, (0.0, 0.0, 1.0)), momentum=8.0, duration=120.0)


def test_stored_momentum_is_tilted_the_shortest_way():
    """Half a turn about (1, 0, 1) takes 8 N m s from the wheel along z to the one along x.

    At 0.2 N m that takes 40 s. Straight from z to x, the larger of both torques for each angle takes 56.6 s; the turn
    about the axis of the error also fills and empties the wheel along y, and takes 69.3 s.
    """
    case = {"wheels": ORTHOGONAL, "attitude": turn(0.999 * math.pi, (1.0, 0.0, 1.0)), "momentum": (0.0, 0.0, 8.0)}
    # In 79 s before the last 20 s there is time for the first and its start and end; the second is too slow.
    assert feasible(**case, duration=99.0)
    assert not feasible(**case, duration=58.0)


@pytest.mark.parametrize("reference", [SetPoints(), MRPSinusoid((0.2,) * 3, ((0.03, 0.1),) * 3, ((0.0, 6.28),) * 3)])
def test_the_flights_keep_the_angular_momentum(reference):
    scenario = scenarios.get("flagship").replace(
        reference=reference, faults=None, disturbance=None, initial_state={"wheel_momentum": (-4.0, 4.0)}
    )
    episodes = scenario.draw(0, 20)
    axes = scenario.spacecraft.wheels.axis_matrix
    for number in range(len(episodes)):
        _, times, path = flights(scenario, episodes[number])
        attitude, (_, rates) = (
            quaternion_from_rotation_vector(path[:, :3]),
            reference_motion(scenario.reference, episodes[number], times),
        )
        rate = path[:, 3:6] + (rotate_to_body(attitude, rates[0]) if rates.size else 0.0)
        momentum = np.linalg.norm(path[:, 6:] @ axes.T + rate @ episodes.inertia["constant"][number], axis=1)
        np.testing.assert_allclose(momentum, momentum[0], atol=0.06)


def test_torquers_store_no_momentum():
    torquers = WheelArray(PYRAMID.axes, 0.2, 12.0, momentum_coupling=False)
    assert feasible(wheels=torquers, attitude=turn(math.pi), momentum=8.0)


def test_the_momentum_of_a_seized_wheel_goes_to_the_others():
    small = WheelArray(PYRAMID.axes, 0.2, (12.0, 4.0, 4.0, 4.0))
    for momentum, expected in ((3.0, True), (6.0, False)):
        fault = faults.Seizure(wheel=0, onset=20.0, brake=2.0)
        assert feasible(fault, wheels=small, momentum=(momentum, 0.0, 0.0, 0.0)) == expected


# ------------------------------------------------------------------------------------------------ moving references


@BOTH
def test_following_takes_its_torque(expected):
    # 10 kg m^2 * A * 0.5 rad/s: 0.15 or 0.25 N m at the crest.
    swing = RateProfile(amplitude=(0.03 if expected else 0.05, 0.0, 0.0), frequency=(0.5, 0.0, 0.0))
    assert feasible(wheels=ORTHOGONAL, reference=swing) == expected
    steady = RateProfile(amplitude=(0.0,) * 3, frequency=(0.0,) * 3, constant=(0.012 if expected else 0.024, 0.0, 0.0))
    # Stored momentum across the rate: 0.12 or 0.24 N m.
    start = {"rate": (steady.constant[0][0] if isinstance(steady.constant[0], tuple) else steady.constant[0], 0.0, 0.0)}
    assert feasible(wheels=ORTHOGONAL, reference=steady, momentum=(0.0, 10.0, 0.0), **start) == expected


@BOTH
def test_a_moving_reference_must_be_caught(expected):
    moving = MRPSinusoid(amplitude=(0.02,) * 3, frequency=(0.05,) * 3)
    duration = 90.0 if expected else 30.0
    assert feasible(attitude=turn(3.0), reference=moving, duration=duration) == expected


def test_a_sampled_reference():
    times = np.linspace(0.0, 60.0, 61)
    for rate, expected in ((0.01, True), (0.06, False)):
        angles = 4.0 * rate * np.sin(0.25 * times)  # 10 kg m^2 * rate * 0.25 rad/s
        points = [turn(angle) for angle in angles * (1.0 if expected else 2.0)]
        start = (rate * (1.0 if expected else 2.0), 0.0, 0.0)
        reference = SampledReference(times, points)
        assert feasible(wheels=ORTHOGONAL, reference=reference, duration=60.0, rate=start) == expected


# ----------------------------------------------------------------------------------------------------- in all cases


def test_what_takes_no_torque_does_not_count():
    others = (
        faults.CommandDelay(wheel=0, onset=15.0),
        faults.GyroBiasStep(onset=15.0, size=0.01),
        faults.StarTrackerOutage(onset=15.0),
        faults.AttitudeSpike(onset=15.0, angle=1.0),
        faults.Outage(wheel=0, onset=100.0),
    )
    for duration in (1.1 * QUARTER + 20.0, 0.97 * QUARTER + 19.0):
        case = {"wheels": ORTHOGONAL, "attitude": turn(0.5 * math.pi), "duration": round(duration, 1)}
        assert feasible(*others, **case) == feasible(**case)


def test_wheels_without_limits_do_anything_at_once():
    wheels = WheelArray(np.eye(3), None)
    assert feasible(wheels=wheels, attitude=turn(math.pi), rate=(1.0, 1.0, 1.0), duration=21.0)


@pytest.mark.parametrize("count", [1, 2])
@pytest.mark.parametrize("limits", [(0.2, 1.0), (None, None), (0.2, None), (None, 1.0)])
def test_one_or_two_wheels_do_not_stop_a_tumbling_body(count, limits):
    wheels = WheelArray(np.eye(3)[:, :count], *limits)
    assert not feasible(wheels=wheels, attitude=(0.6, 0.8, 0.0, 0.0), rate=(0.01, 0.02, 0.03))


def test_a_label_depends_on_its_episode_alone():
    for name in ("flagship_double", "flagship_tracking"):
        scenario = scenarios.get(name)
        drawn = scenario.draw(3, 40)
        alone = [bool(scenario.draw_episodes([3], np.array([k])).feasible[0]) for k in range(40)]
        assert drawn.feasible.tolist() == alone
        odd = drawn[np.arange(1, 40, 2)]
        assert np.array_equal(scenario.feasibility(odd), drawn.feasible[1::2])


@pytest.mark.parametrize("reference", [SetPoints(), RateProfile((0.03, 0.0, 0.0), (0.5, 0.0, 0.0))])
def test_a_start_on_target_is_not_flown_by_the_plans_of_other_episodes(reference):
    scenario = scenarios.get("flagship").replace(reference=reference, faults=None, initial_state={"max_rate": 0.0})
    episodes = scenario.draw(0, 10)
    episodes.initial["attitude"][1::2] = AT_TARGET
    together = plan_numbers(scenario, episodes)
    assert (together[1::2] == 0).all()
    assert [plan_numbers(scenario, episodes[number])[0] for number in range(10)] == together.tolist()


def test_the_number_of_steps():
    rest, swing = np.zeros(1, [("frequency", "f8", 3)]), np.full(1, 0.5, [("frequency", "f8", 3)])
    assert [step_count(duration, rest) for duration in (1.0, 120.0, 300.0, 1e4)] == [120, 120, 300, MOST_STEPS]
    assert step_count(120.0, swing) == 240
    assert 0.9 < TORQUE_SHARE < 1.0


@pytest.mark.parametrize("name", ["flagship_severe", "flagship_double"])
def test_more_torque_makes_no_episode_infeasible(name):
    """No law: each torque leads to another flight, and a wheel that runs away fills to the brim in some episodes."""
    scenario = scenarios.get(name)
    drawn, wheels = scenario.draw(11, 300), scenario.spacecraft.wheels
    last = drawn.feasible
    assert 0 < last.sum() < 300
    for factor in (1.2, 1.5, 2.0):
        stronger = replace(wheels, torque_limit=0.2 * factor)
        labels = scenario.replace(spacecraft=replace(scenario.spacecraft, wheels=stronger)).feasibility(drawn)
        assert np.mean(last & ~labels) < 0.01
        last = labels
    assert plan_numbers(scenario, drawn).max() < len(PLANS)
