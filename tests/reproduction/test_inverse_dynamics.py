"""Wheel torques of references: closed forms, a linear programme, and an open-loop flight along the reference."""

import math

import numpy as np
import pytest
from scipy.optimize import linprog

from ftac_gym import scenarios
from ftac_gym.attitude import angle_between
from ftac_gym.dynamics import Simulator
from ftac_gym.faults import Bias, FaultSchedule, LossOfEffectiveness, Outage
from ftac_gym.reproduction.inverse_dynamics import peak_wheel_torque, required_torque
from ftac_gym.spacecraft.layouts import orthogonal_and_skew, sign_pyramid, three_orthogonal
from ftac_gym.spacecraft.spacecraft import Spacecraft
from ftac_gym.spacecraft.wheel_array import WheelArray
from ftac_gym.task.disturbances import Disturbance, Harmonic
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.references import MRPSinusoid, RateProfile, SetPoints, fixed_attitude
from ftac_gym.task.scenario import Scenario

MOMENTS = np.array([10.0, 12.0, 15.0])  # kg m^2
ZHANG_ZHOU = scenarios.get("zhang_zhou_2019_feasible")


def task(reference, axes=None, inertia=None, **parts):
    inertia = np.diag(MOMENTS) if inertia is None else inertia
    wheels = WheelArray(axes or three_orthogonal(), 1.0, momentum_coupling=False)
    return Scenario(
        name="task", spacecraft=Spacecraft(inertia, wheels), reference=reference, control_period=0.01,
        physics_step=0.01, duration=20.0, **parts,
    )  # fmt: skip


def swing(axis, amplitude=0.2, frequency=0.7):
    """A reference that swings about one body axis by the angle 4 atan(amplitude sin(frequency t))."""
    along = np.eye(3)[axis]
    return MRPSinusoid(tuple(amplitude * along), tuple(frequency * along))


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_swing_about_a_principal_axis(axis):
    """J angle'', with the angle differentiated by hand."""
    a, f = 0.2, 0.7
    time = np.linspace(0.0, 9.0, 500)
    sine, cosine = a * np.sin(f * time), a * np.cos(f * time)
    # angle' = 4 f c / (1 + s^2)
    acceleration = -4.0 * f**2 * (sine / (1.0 + sine**2) + 2.0 * sine * cosine**2 / (1.0 + sine**2) ** 2)
    scenario = task(swing(axis))
    expected = np.outer(MOMENTS[axis] * acceleration, np.eye(3)[axis])
    np.testing.assert_allclose(required_torque(scenario, time), expected, atol=1e-13)
    for allocation in ("minimax", "pseudo_inverse"):
        peak = peak_wheel_torque(scenario, allocation, time=time)
        assert peak == pytest.approx(MOMENTS[axis] * np.abs(acceleration).max(), rel=1e-12)


def test_a_steady_spin():
    about_principal = task(RateProfile(amplitude=(0.0,) * 3, frequency=(0.0,) * 3, constant=(0.0, 0.0, 0.3)))
    assert peak_wheel_torque(about_principal) == 0.0
    rate = np.array([0.1, -0.2, 0.3])
    tilted = task(RateProfile(amplitude=(0.0,) * 3, frequency=(0.0,) * 3, constant=tuple(rate)))
    gyroscopic = np.array(
        [
            (MOMENTS[2] - MOMENTS[1]) * rate[1] * rate[2],
            (MOMENTS[0] - MOMENTS[2]) * rate[2] * rate[0],
            (MOMENTS[1] - MOMENTS[0]) * rate[0] * rate[1],
        ]
    )
    np.testing.assert_allclose(required_torque(tilted, [0.0, 3.0]), [gyroscopic, gyroscopic], atol=1e-15)
    assert peak_wheel_torque(tilted) == pytest.approx(np.abs(gyroscopic).max())


def test_a_rate_profile():
    profile = RateProfile(amplitude=(0.2, 0.0, 0.0), frequency=(0.5, 0.0, 0.0), phase=(0.3, 0.0, 0.0))
    time = np.linspace(0.0, 20.0, 300)
    expected = np.outer(0.1 * MOMENTS[0] * np.cos(0.5 * time + 0.3), [1.0, 0.0, 0.0])
    np.testing.assert_allclose(required_torque(task(profile), time), expected, atol=1e-14)


def test_the_time_scale_enters_squared():
    slow, fast = (task(swing(0, frequency=frequency)) for frequency in (0.1, 0.2))
    time = np.linspace(0.0, 100.0, 1001)
    assert peak_wheel_torque(fast, time=0.5 * time) == pytest.approx(4.0 * peak_wheel_torque(slow, time=time))


@pytest.mark.parametrize("reference", [fixed_attitude(), SetPoints(((1, 0, 0, 0), (0, 1, 0, 0)), (0.0, 5.0))])
def test_at_rest_only_the_external_torque_is_left(reference):
    constant, wave = np.array([0.03, 0.0, -0.01]), Harmonic((0.0, 0.2, 0.0), frequency=0.9, phase=(0.0, 0.4, 0.0))
    scenario = task(reference, disturbance=Disturbance(tuple(constant), (wave,)))
    assert peak_wheel_torque(scenario) == 0.0
    time = np.linspace(0.0, 20.0, 400)
    expected = -constant - np.outer(0.2 * np.sin(0.9 * time + 0.4), [0.0, 1.0, 0.0])
    np.testing.assert_allclose(required_torque(scenario, time, disturbance=True), expected, atol=1e-15)
    assert peak_wheel_torque(scenario, disturbance=True) == pytest.approx(0.2, rel=1e-4)


def test_an_external_torque_that_grows_with_the_rate():
    turning = RateProfile(amplitude=(0.0,) * 3, frequency=(0.0,) * 3, constant=(0.0, 0.0, 0.4))
    scenario = task(turning, disturbance=Disturbance((0.5, 0.0, 0.0), rate_offset=0.05))
    np.testing.assert_allclose(required_torque(scenario, [1.0], disturbance=True), [[-0.5 * 0.21, 0.0, 0.0]])


def test_faults_are_allocated_around():
    """Hold out against 0.1 N m about x: what is left of the wheels, and what they add, decides the command."""

    def peak(axes, *faults):
        scenario = task(fixed_attitude(), axes, disturbance=Disturbance((-0.1, 0.0, 0.0)), faults=FaultSchedule(faults))
        return peak_wheel_torque(scenario, disturbance=True, faults=True)

    three = three_orthogonal()
    assert peak(three) == pytest.approx(0.1)
    assert peak(three, LossOfEffectiveness(wheel=0, onset=3.0, effectiveness=0.4)) == pytest.approx(0.25)
    assert peak(three, Bias(wheel=0, onset=3.0, constant=-0.06)) == pytest.approx(0.16)
    late = LossOfEffectiveness(wheel=0, onset=30.0, effectiveness=0.4)  # after the end of the episode
    assert peak(three, late) == pytest.approx(0.1)
    # Without the first wheel, the skew one pushes and those along y and z hold against it.
    assert peak(orthogonal_and_skew(), Outage(wheel=0, onset=3.0)) == pytest.approx(0.1 * math.sqrt(3.0))
    with pytest.raises(ValueError, match="axes must span three dimensions"):
        peak(three, Outage(wheel=0, onset=3.0))


@pytest.mark.parametrize("axes", [orthogonal_and_skew(), sign_pyramid()], ids=["skew", "pyramid"])
@pytest.mark.parametrize("effectiveness", [1.0, 0.5])
def test_minimax_is_the_smallest_peak(axes, effectiveness):
    faults = FaultSchedule((LossOfEffectiveness(wheel=1, effectiveness=effectiveness),))
    inertia = np.array([[10.0, 1.0, 0.5], [1.0, 12.0, -1.0], [0.5, -1.0, 15.0]])
    scenario = task(MRPSinusoid((0.2, 0.1, 0.15), (0.5, 0.8, 0.3)), axes, inertia, faults=faults)
    gives = np.array(axes) * [1.0, effectiveness, 1.0, 1.0]
    for time in np.linspace(0.0, 19.0, 15):
        torque = required_torque(scenario, [time])[0]
        # Minimise s over (u, s) with gives u = torque and |u_j| <= s.
        bounds = np.block([[np.eye(4), -np.ones((4, 1))], [-np.eye(4), -np.ones((4, 1))]])
        answer = linprog(
            [0.0] * 4 + [1.0], bounds, np.zeros(8), np.hstack([gives, np.zeros((3, 1))]), torque,
            [(None, None)] * 4 + [(0.0, None)],
        )  # fmt: skip
        peak = peak_wheel_torque(scenario, faults=True, time=[time])
        assert peak == pytest.approx(answer.fun, rel=1e-7)
        least_squares = np.linalg.lstsq(gives, torque)[0]
        assert peak_wheel_torque(scenario, "pseudo_inverse", faults=True, time=[time]) == pytest.approx(
            np.abs(least_squares).max()
        )
        assert peak <= np.abs(least_squares).max() + 1e-12


def test_the_required_torque_follows_the_reference():
    """Open loop, from the reference's own start, with the external torque and without faults."""
    start = InitialState.fixed(rate=np.linalg.solve(0.25 * np.eye(3), [0.06, 0.04, 0.04]))
    scenario = ZHANG_ZHOU.replace(faults=None, inertia_uncertainty=None, initial_state=start)
    simulator = Simulator(scenario, 1)
    simulator.reset(scenario.draw(0, 1))
    np.testing.assert_allclose(simulator.state.rate, simulator.reference_rate, atol=1e-15)
    middle = 0.01 * (np.arange(1000) + 0.5)
    torque = required_torque(scenario, middle, disturbance=True)
    for command in torque @ np.linalg.pinv(scenario.spacecraft.wheels.axis_matrix).T:
        simulator.step(command[None])
    assert angle_between(simulator.state.attitude, simulator.reference_attitude)[0] < 1e-4


def test_random_episodes_differ():
    scenario = task(MRPSinusoid(((0.1, 0.3),) * 3, ((0.2, 0.6),) * 3))
    peaks = [peak_wheel_torque(scenario, seed=seed) for seed in (0, 1, 0)]
    assert peaks[0] == peaks[2] != peaks[1]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"allocation": "guess"}, r"allocation must be one of \['minimax', 'pseudo_inverse'\], got 'guess'"),
        ({"time": []}, "time must be a list of finite numbers"),
        ({"time": 3.0}, "time must be a list of finite numbers, got"),
        ({"time": [0.0, math.nan]}, "time must be a list of finite numbers"),
    ],
)
def test_bad_arguments(arguments, message):
    with pytest.raises(ValueError, match=message):
        peak_wheel_torque(ZHANG_ZHOU, **arguments)


def test_stored_momentum_is_refused():
    with pytest.raises(ValueError, match="momentum_coupling must be False: stored momentum is not followed here"):
        peak_wheel_torque(scenarios.get("flagship_tracking"))
