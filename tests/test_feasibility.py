"""Tests of `ftac_gym.feasibility`: the envelope against linear programming, and labels of cases solved by hand."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from ftac_gym.disturbances import Disturbance, Harmonic
from ftac_gym.faults import (
    AttitudeSpike,
    Bias,
    CommandDelay,
    DriftingEffectiveness,
    FaultSchedule,
    FrictionRise,
    GyroBiasStep,
    HardOver,
    IntermittentShutdown,
    LockInPlace,
    LossOfEffectiveness,
    Outage,
    Seizure,
    StarTrackerOutage,
)
from ftac_gym.feasibility import TORQUE_RESERVE, Envelope, envelope_normals
from ftac_gym.friction import Friction
from ftac_gym.initial_state import InitialState
from ftac_gym.references import MRPSinusoid, SetPoints
from ftac_gym.scenario import Scenario
from ftac_gym.spacecraft import Spacecraft
from ftac_gym.wheels import WheelArray

PYRAMID = WheelArray.sign_pyramid(0.2, 12.0)
ORTHOGONAL = WheelArray(np.eye(3), 0.2, 12.0)
ROOMY = WheelArray(np.eye(3), 0.2, 100.0)
DISTANCE = 0.5 * math.sqrt(2.0)
SIX = WheelArray(DISTANCE * np.array([[1, 1, 1, 1, 0, 0], [1, -1, 0, 0, 1, 1], [0, 0, 1, -1, 1, -1]]), torque_limit=0.2)


def feasible(
    *faults, wheels=PYRAMID, duration=100.0, attitude=(1.0, 0.0, 0.0, 0.0), rate=(0.0,) * 3, momentum=0.0, **parts
):
    scenario = Scenario(
        name="label",
        spacecraft=Spacecraft(np.diag([10.0, 12.0, 14.0]), wheels),
        initial_state=InitialState.fixed(attitude, rate, momentum),
        faults=FaultSchedule(faults) if faults else None,
        duration=duration,
        **parts,
    )
    labels = scenario.draw(0, 2).feasible
    assert labels.shape == (2,) and labels.dtype == np.bool_ and labels[0] == labels[1]
    return bool(labels[0])


# --------------------------------------------------------------------------------------------------------- envelope


def largest_scale(point, axes, reach):
    """Largest s for which some |tau_j| <= reach_j gives D tau = s point."""
    wheels = axes.shape[1]
    solution = linprog(
        c=np.r_[np.zeros(wheels), -1.0],
        A_eq=np.column_stack([axes, -point]),
        b_eq=np.zeros(3),
        bounds=[*((-limit, limit) for limit in reach), (0.0, None)],
    )
    assert solution.success
    return -solution.fun


@st.composite
def envelope(draw):
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    wheels = draw(st.integers(3, 6))
    axes = rng.normal(size=(3, wheels))
    axes /= np.linalg.norm(axes, axis=0)
    assume(np.linalg.svd(axes, compute_uv=False)[-1] > 0.05)
    return rng, axes, rng.uniform(0.1, 1.0, wheels)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(envelope(), st.floats(0.01, 2.0))
def test_point_inside_exactly_if_a_linear_program_says_so(drawn, size):
    rng, axes, reach = drawn
    point = rng.normal(size=3) * size
    scale = largest_scale(point, axes, reach)
    for factor, expected in ((0.999 * scale, True), (1.001 * scale, False)):
        inside = Envelope(axes).contains(factor * point[None], np.zeros((1, 3)), reach[None])
        assert inside.shape == (1,) and inside[0] == expected


@settings(max_examples=25, deadline=None, derandomize=True)
@given(envelope(), st.floats(0.01, 1.0))
def test_box_inside_exactly_if_all_its_corners_are(drawn, size):
    rng, axes, reach = drawn
    point, margin = rng.normal(size=3) * size, rng.uniform(0.0, size, 3)
    corners = point + margin * np.array(list(itertools.product([-1.0, 1.0], repeat=3)))
    scale = min(largest_scale(corner, axes, reach) for corner in corners)
    for factor, expected in ((0.999 * scale, True), (1.001 * scale, False)):
        assert Envelope(axes).contains(factor * point[None], factor * margin[None], reach[None])[0] == expected


def test_dead_wheels_leave_the_envelope_of_the_others():
    axes = SIX.axis_matrix
    reach = np.array([[1.0, 1.0, 0.0, 0.5, 1.0, 0.0]])
    alive = reach[0] > 0.0
    for point in np.random.default_rng(0).normal(size=(20, 3)):
        scale = largest_scale(point, axes[:, alive], reach[0, alive])
        assert Envelope(axes).contains(0.999 * scale * point[None], np.zeros((1, 3)), reach)[0]
        assert not Envelope(axes).contains(1.001 * scale * point[None], np.zeros((1, 3)), reach)[0]


@pytest.mark.parametrize("reach", [(0.0, 1.0, 1.0), (0.0, 0.0, 0.0), (1e-300, 0.0, 1.0)])
def test_wheels_that_do_not_span_space_hold_nothing(reach):
    assert not Envelope(np.eye(3)).contains(np.zeros((1, 3)), np.zeros((1, 3)), np.array([reach]))[0]


@pytest.mark.parametrize("axes", [np.eye(3)[:, :1], np.eye(3)[:, :2], np.eye(3)[:, [0, 0, 0, 0]]])
def test_too_few_directions_hold_nothing(axes):
    assert not Envelope(axes).contains(np.zeros((2, 3)), np.zeros((2, 3)), np.ones((2, axes.shape[1]))).any()


def test_unlimited_wheels_hold_everything():
    assert Envelope(PYRAMID.axis_matrix).contains(np.full((1, 3), 1e6), np.ones((1, 3)), np.full((1, 4), np.inf))[0]


def test_envelope_normals_are_unit_normals_of_pairs():
    normals = envelope_normals(SIX.axis_matrix)
    assert normals.shape == (15, 3)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0)
    assert np.all(np.sum(np.abs(normals @ SIX.axis_matrix) < 1e-12, axis=1) >= 2)
    assert len(envelope_normals(np.eye(3)[:, [0, 0, 1]])) == 2


# ----------------------------------------------------------------------------------------------------------- labels


def test_healthy_wheels_are_feasible():
    for wheels in (PYRAMID, ORTHOGONAL, SIX):
        assert feasible(wheels=wheels)


@pytest.mark.parametrize("kind", [Outage, LockInPlace])
def test_one_dead_wheel(kind):
    for wheel in range(3):
        assert not feasible(kind(wheel=wheel, onset=5.0), wheels=ORTHOGONAL)
    for wheel in range(4):
        assert feasible(kind(wheel=wheel, onset=5.0), wheels=PYRAMID)


def test_two_dead_wheels():
    for pair in itertools.combinations(range(4), 2):
        assert not feasible(*(Outage(wheel=wheel) for wheel in pair), wheels=PYRAMID)
        assert feasible(*(Outage(wheel=wheel) for wheel in pair), wheels=SIX)


def test_hard_over_on_the_sign_pyramid():
    # Wheel 0 = wheel 1 - wheel 2 + wheel 3: to hold a fraction f of its limit each of the others must give f.
    edge = 1.0 - TORQUE_RESERVE
    for wheel, sign in itertools.product(range(4), (-1.0, 1.0)):
        for fraction, expected in ((1.0, False), (1.01 * edge, False), (0.99 * edge, True), (0.5, True)):
            fault = HardOver(wheel=wheel, fraction=sign * fraction, random_sign=False, onset=40.0)
            assert feasible(fault) == expected


def test_equal_wheels_get_equal_labels():
    # 0.15 N m for 100 s fills the wheel, and so the three others to the brim: the edge of the envelope.
    labels = {
        feasible(HardOver(wheel=wheel, fraction=sign * 0.75, random_sign=False))
        for wheel, sign in itertools.product(range(4), (-1.0, 1.0))
    }
    assert len(labels) == 1


def test_bias_counts_against_the_wheel_itself():
    free = (1.0 - TORQUE_RESERVE) * 0.2
    for sign in (-1.0, 1.0):
        assert feasible(Bias(wheel=0, constant=0.99 * sign * free), wheels=ORTHOGONAL)
        assert not feasible(Bias(wheel=0, constant=1.01 * sign * free), wheels=ORTHOGONAL)


def test_bias_is_judged_at_its_worst():
    free = (1.0 - TORQUE_RESERVE) * 0.2
    slow, fast = 0.99 * free / 80.0, 1.01 * free / 80.0
    assert feasible(Bias(wheel=0, onset=20.0, slope=slow), wheels=ORTHOGONAL)
    assert not feasible(Bias(wheel=0, onset=20.0, slope=fast), wheels=ORTHOGONAL)
    assert feasible(Bias(wheel=0, onset=20.0, recovery=60.0, slope=fast), wheels=ORTHOGONAL)
    assert not feasible(Bias(wheel=0, constant=-0.1, amplitude=0.07, frequency=1.0), wheels=ORTHOGONAL)
    assert feasible(Bias(wheel=0, constant=-0.1, amplitude=0.05, frequency=1.0), wheels=ORTHOGONAL)
    assert not feasible(Bias(wheel=0, amplitude=1.01 * free / 100.0, exponent=1.0, frequency=1.0), wheels=ORTHOGONAL)
    assert feasible(Bias(wheel=0, amplitude=0.99 * free / 100.0, exponent=1.0, frequency=1.0), wheels=ORTHOGONAL)


def test_loss_of_effectiveness_is_judged_at_its_worst():
    push = Disturbance(constant=(0.05, 0.0, 0.0))  # needs e * 0.8 * 0.2 >= 0.05, so e >= 0.3125
    for effectiveness, expected in ((0.32, True), (0.30, False)):
        fault = LossOfEffectiveness(wheel=0, effectiveness=effectiveness)
        assert feasible(fault, wheels=ORTHOGONAL, disturbance=push) == expected
        swinging = LossOfEffectiveness(wheel=0, effectiveness=effectiveness + 0.2, amplitude=0.2, frequency=1.0)
        assert feasible(swinging, wheels=ORTHOGONAL, disturbance=push) == expected


@pytest.mark.parametrize(("size", "expected"), [(0.159, True), (0.161, False)])
def test_disturbance_must_leave_the_reserve(size, expected):
    assert feasible(wheels=ROOMY, disturbance=Disturbance(constant=(0.0, size, 0.0))) == expected
    swing = Disturbance((0.0, 0.1, 0.0), (Harmonic((0.0, size - 0.1, 0.0), frequency=1.0, phase=(0.0, 2.0, 0.0)),))
    assert feasible(wheels=ROOMY, disturbance=swing) == expected
    scaled = Disturbance((0.0, 100.0 * size, 0.0), rate_offset=0.0)
    assert feasible(wheels=ROOMY, disturbance=scaled, rate=(0.1, 0.0, 0.0)) == expected


def test_a_fault_after_the_end_does_not_count():
    for onset, expected in ((99.9, False), (100.0, True), (500.0, True)):
        assert feasible(Outage(wheel=0, onset=onset), wheels=ORTHOGONAL) == expected


def test_momentum_of_a_runaway_wheel_must_fit_into_the_others():
    wheels = WheelArray(PYRAMID.axes, 0.2, (12.0, 4.0, 4.0, 4.0))
    fault = {"wheel": 0, "fraction": 0.25, "random_sign": False}  # 0.05 N m for 100 s pours 5 N m s
    assert not feasible(HardOver(**fault), wheels=wheels)
    assert feasible(HardOver(**fault), wheels=PYRAMID)
    assert feasible(HardOver(**fault, recovery=79.0), wheels=wheels)
    assert not feasible(HardOver(**fault, recovery=81.0), wheels=wheels)
    assert feasible(HardOver(**fault, onset=21.0), wheels=wheels)
    small = WheelArray(PYRAMID.axes, 0.2, (3.9, 4.0, 4.0, 4.0))  # ... but no more than the wheel itself can hold
    assert feasible(HardOver(**fault), wheels=small)


def test_opposite_faults_at_different_times_do_not_cancel():
    early = HardOver(wheel=0, fraction=1.0, random_sign=False, onset=0.0, recovery=10.0)
    late = HardOver(wheel=0, fraction=-1.0, random_sign=False, onset=20.0, recovery=30.0)
    assert not feasible(early) and not feasible(late)
    assert not feasible(early, late)


def test_a_dead_wheel_with_a_bias_runs_away_too():
    wheels = WheelArray(PYRAMID.axes, 0.2, (12.0, 4.0, 4.0, 4.0))
    assert not feasible(Outage(wheel=0), Bias(wheel=0, constant=0.05), wheels=wheels)


# --------------------------------------------------------------------------------------------- momentum to be held

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


@pytest.mark.parametrize("kind", [Outage, Seizure, IntermittentShutdown])
@pytest.mark.parametrize(("share", "expected"), [(0.99, True), (1.01, False)])
def test_what_a_floating_or_seized_wheel_holds_is_left_to_the_others(kind, share, expected):
    # Three wheels of the sign pyramid hold a ball of sqrt(2/3) of their limit.
    ball = math.sqrt(2.0 / 3.0) * H
    for wheel in range(4):
        momentum = share * ball * np.eye(4)[wheel]
        assert feasible(wheels=PYRAMID, momentum=momentum)
        for dead in range(4):
            assert feasible(kind(wheel=dead, onset=50.0), wheels=PYRAMID, momentum=momentum) == expected


def test_a_seized_wheel_counts_as_dead():
    for wheel in range(3):
        assert not feasible(Seizure(wheel=wheel, onset=5.0), wheels=ORTHOGONAL)
        # ... even if it would let go: the label looks at the worst moment.
        assert not feasible(Seizure(wheel=wheel, onset=5.0, recovery=6.0), wheels=ORTHOGONAL)
    for wheel in range(4):
        assert feasible(Seizure(wheel=wheel, onset=5.0), wheels=PYRAMID)
    assert not feasible(Seizure(wheel=0), Outage(wheel=2), wheels=PYRAMID)
    assert feasible(Seizure(wheel=0), Outage(wheel=2), wheels=SIX)


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
def test_a_disturbance_slows_the_turn(expected):
    time = 2.0 * math.sqrt(ANGLE * 10.0 / (FREE - 0.05))
    push = Disturbance((0.05, 0.0, 0.0))
    duration = just(time, expected)
    assert feasible(wheels=ORTHOGONAL, attitude=ABOUT_X, disturbance=push, duration=duration) == expected


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
    rate, acceleration = 0.08, FREE / 10.0
    stopping = rate / acceleration
    assert feasible(wheels=ORTHOGONAL, rate=(0.0, rate, 0.0), duration=just(stopping, expected)) == expected
    duration = just(TURN + stopping, expected)
    assert feasible(wheels=ORTHOGONAL, attitude=ABOUT_X, rate=(0.0, 0.0, rate), duration=duration) == expected


def test_the_turn_fits_before_the_fault_or_after_it():
    slow = 2.0 * math.sqrt(ANGLE * 10.0 / (0.5 * FREE))  # s with half the torque: 28.0
    for onset, expected in ((0.0, True), (60.0 - slow - 0.1, True), (60.0 - slow + 0.1, False)):
        fault = LossOfEffectiveness(wheel=0, onset=onset, effectiveness=0.5)
        assert feasible(fault, wheels=ORTHOGONAL, attitude=ABOUT_X, duration=80.0) == expected
    for onset, expected in ((TURN - 0.1, False), (TURN + 0.1, True), (70.0, True)):
        fault = LossOfEffectiveness(wheel=0, onset=onset, effectiveness=0.5)
        assert feasible(fault, wheels=ORTHOGONAL, attitude=ABOUT_X, duration=45.0) == (
            (expected and onset < 45.0) or True
        )


def test_the_last_of_several_faults_counts_for_the_time_after_them():
    early = LossOfEffectiveness(wheel=1, onset=5.0, effectiveness=0.9)
    for onset, expected in ((79.9 - TURN, True), (80.1 - TURN, False)):
        late = LossOfEffectiveness(wheel=1, onset=onset, effectiveness=0.9)
        assert feasible(early, late, wheels=ORTHOGONAL, attitude=ABOUT_X) == expected
        assert feasible(late, wheels=ORTHOGONAL, attitude=ABOUT_X)  # before it there was time enough


@BOTH
def test_of_several_set_points_the_last_turn_is_asked(expected):
    points = SetPoints(((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), ABOUT_X), (0.0, 10.0, 30.0))
    assert feasible(wheels=ORTHOGONAL, reference=points, duration=just(30.0 + TURN, expected)) == expected


def test_moving_references_are_not_asked_for_a_turn():
    back = (0.0, 1.0, 0.0, 0.0)
    moving = MRPSinusoid(amplitude=(0.1,) * 3, frequency=(0.05,) * 3)
    assert not feasible(wheels=ORTHOGONAL, attitude=back, duration=30.0)
    assert feasible(wheels=ORTHOGONAL, attitude=back, duration=30.0, reference=moving)
    assert not feasible(Outage(wheel=0), wheels=ORTHOGONAL, duration=30.0, reference=moving)


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
        return feasible(*faults, wheels=wheels, disturbance=Disturbance((push + side, 0.0, 0.0)))

    assert asked(FREE - 0.07, wheels=rubbing(friction)) == expected
    assert asked(FREE - 0.01, wheels=rubbing(friction, momentum_limit=None)) == expected
    assert asked(FREE - 0.01 - 0.03, wheels=rubbing(friction, speed_limit=300.0)) == expected
    assert asked(FREE, wheels=rubbing((None, friction, friction))) == expected
    for direction in ("both", "forward", "backward", "either"):
        risen = FrictionRise(wheel=0, factor=4.0, direction=direction, onset=3.0)
        assert asked(FREE - 0.10, risen, wheels=rubbing(friction)) == expected
        elsewhere = FrictionRise(wheel=1, factor=4.0, direction=direction, onset=3.0)
        assert asked(FREE - 0.07, elsewhere, wheels=rubbing(friction)) == expected
    late = FrictionRise(wheel=0, factor=4.0, onset=100.0)
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


@pytest.mark.parametrize("count", [1, 2])
@pytest.mark.parametrize("limits", [(0.2, 1.0), (None, None), (0.2, None), (None, 1.0)])
def test_one_or_two_wheels_are_never_enough(count, limits):
    wheels = WheelArray(np.eye(3)[:, :count], *limits)
    for attitude in ((1.0, 0.0, 0.0, 0.0), ABOUT_X):
        assert not feasible(wheels=wheels, attitude=attitude, rate=(0.01, 0.0, 0.0))
        assert not feasible(wheels=wheels, attitude=attitude)


def test_wheels_without_limits_do_anything_at_once():
    wheels = WheelArray(np.eye(3), None)
    assert feasible(wheels=wheels, attitude=(0.0, 1.0, 0.0, 0.0), rate=(1.0, 1.0, 1.0), duration=20.1)
