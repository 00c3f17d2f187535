"""Physics of the plant: conserved quantities, closed-form motions, order of the integrator, and the unit quaternion."""

from itertools import pairwise

import numpy as np
import pytest

from ftac_gym import attitude as att
from ftac_gym.dynamics import Simulator
from ftac_gym.faults import Bias, FaultSchedule, LossOfEffectiveness
from ftac_gym.spacecraft.spacecraft import Spacecraft
from ftac_gym.spacecraft.wheel_array import WheelArray
from ftac_gym.task.disturbances import Disturbance, Harmonic
from ftac_gym.task.inertia import InertiaUncertainty
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.scenario import Scenario

INERTIA = np.array([[10.0, 1.2, 0.5], [1.2, 19.0, 1.5], [0.5, 1.5, 25.0]])  # kg m^2
PYRAMID = WheelArray.sign_pyramid(0.2, None).axis_matrix


def craft(
    inertia=INERTIA, rate=(0.03, -0.04, 0.02), momentum=0.0, coupling=True, attitude=(0.5, -0.5, 0.5, 0.5), **parts
):
    return Scenario(
        name="physics",
        spacecraft=Spacecraft(inertia, WheelArray(PYRAMID, 0.2, None, coupling)),
        initial_state=InitialState.fixed(attitude, rate, momentum),
        **parts,
    )


def start(scenario, count=1):
    simulator = Simulator(scenario, count)
    simulator.reset(scenario.draw(0, count))
    return simulator


def run(scenario, commands):
    """Run one spacecraft under commands (T, m) and return the simulator."""
    simulator = start(scenario)
    for command in commands:
        simulator.step(command[None])
    return simulator


def inertial_momentum(state, inertia, axes):
    return att.rotate_to_reference(state.attitude, state.rate @ inertia + state.wheel_momentum @ axes.T)


def kinetic_energy(state, inertia):
    return 0.5 * np.einsum("ni,ij,nj->n", state.rate, inertia, state.rate)


# ----------------------------------------------------------------------------------------------- conserved quantities


def test_angular_momentum_is_conserved_whatever_the_wheels_do():
    scenario = craft(momentum=(1.0, -0.5, 0.3, 2.0), duration=1000.0)
    simulator = start(scenario, 4)
    before = inertial_momentum(simulator.state, INERTIA, PYRAMID)
    rng = np.random.default_rng(0)
    phase = rng.uniform(0.0, 6.0, (4, 4))
    travelled = 0.0
    for step in range(scenario.horizon):
        simulator.step(0.1 * np.sin(0.05 * step + phase) + rng.uniform(-0.1, 0.1, (4, 4)))
        travelled = max(travelled, np.abs(simulator.state.wheel_momentum).max())
    drift = inertial_momentum(simulator.state, INERTIA, PYRAMID) - before
    assert np.linalg.norm(drift, axis=1).max() < 1e-10 * np.linalg.norm(before, axis=1).min()
    assert travelled > 2.5  # N m s: the wheels did move


@pytest.mark.parametrize("momentum", [0.0, (1.0, -0.5, 0.3, 2.0)])
@pytest.mark.parametrize("coupling", [True, False])
def test_kinetic_energy_is_conserved_without_torque(momentum, coupling):
    scenario = craft(momentum=momentum, coupling=coupling, duration=1000.0)
    simulator = start(scenario)
    before = kinetic_energy(simulator.state, INERTIA)
    for _ in range(scenario.horizon):
        simulator.step(np.zeros((1, 4)))
    assert simulator.time[0] == pytest.approx(1000.0)
    np.testing.assert_allclose(kinetic_energy(simulator.state, INERTIA), before, rtol=1e-10)
    if not coupling:  # The body's own momentum: that of the wheels does not act.
        body = np.zeros((3, 4))
        initial = start(scenario).state
        drift = inertial_momentum(simulator.state, INERTIA, body) - inertial_momentum(initial, INERTIA, body)
        assert np.linalg.norm(drift) < 1e-10 * np.linalg.norm(initial.rate @ INERTIA)


def test_stored_momentum_turns_the_body_only_if_coupled():
    ends = {}
    for coupling in (True, False):
        for momentum in (0.0, 2.0):
            ends[coupling, momentum] = run(craft(momentum=momentum, coupling=coupling), np.zeros((50, 4))).state.rate
    np.testing.assert_array_equal(ends[False, 0.0], ends[False, 2.0])
    np.testing.assert_array_equal(ends[False, 0.0], ends[True, 0.0])
    assert np.abs(ends[True, 2.0] - ends[True, 0.0]).max() > 1e-3


def test_energy_changes_by_the_work_of_the_wheels():
    command = np.array([[0.05, -0.02, 0.01, 0.03]])
    simulator = start(craft(momentum=0.5, physics_step=0.01, control_period=0.01))
    before = kinetic_energy(simulator.state, INERTIA)
    power = [simulator.state.rate @ PYRAMID @ command[0]]
    for _ in range(1000):
        simulator.step(command)
        power.append(simulator.state.rate @ PYRAMID @ command[0])
    power = np.array(power)[:, 0]
    work = 0.01 / 3.0 * (power[0] + power[-1] + 4.0 * power[1:-1:2].sum() + 2.0 * power[2:-1:2].sum())
    assert kinetic_energy(simulator.state, INERTIA)[0] - before[0] == pytest.approx(work, rel=1e-8)


def test_quaternion_stays_a_unit_quaternion():
    simulator = run(craft(rate=(0.9, -1.1, 0.7), momentum=1.0), np.zeros((2000, 4)))
    assert abs(np.linalg.norm(simulator.state.attitude) - 1.0) < 1e-15


# ------------------------------------------------------------------------------------------------- closed-form motions


@pytest.mark.parametrize("axis", range(3))
def test_constant_torque_about_a_principal_axis(axis):
    moments, torque, speed, duration = np.array([10.0, 19.0, 25.0]), 0.05, 0.02, 60.0
    scenario = craft(
        np.diag(moments), speed * np.eye(3)[axis], attitude=(1.0, 0.0, 0.0, 0.0), coupling=False, duration=duration
    )
    command = np.linalg.pinv(PYRAMID) @ (torque * np.eye(3)[axis])
    state = run(scenario, np.tile(command, (scenario.horizon, 1))).state
    expected = np.eye(3)[axis] * (speed + torque / moments[axis] * duration)
    np.testing.assert_allclose(state.rate[0], expected, atol=1e-13)
    angle = speed * duration + 0.5 * torque / moments[axis] * duration**2
    turned = att.quaternion_from_rotation_vector(angle * np.eye(3)[axis])
    assert att.angle_between(state.attitude[0], turned) < 1e-9
    np.testing.assert_allclose(state.wheel_momentum[0], -command * duration, rtol=1e-12, atol=1e-13)


def test_constant_torque_from_outside_turns_the_body_about_its_axis():
    disturbance = Disturbance(constant=(0.0, -0.01, 0.0))
    state = run(craft(np.diag([10.0, 19.0, 25.0]), (0.0,) * 3, disturbance=disturbance), np.zeros((100, 4))).state
    np.testing.assert_allclose(state.rate[0], [0.0, -0.01 / 19.0 * 10.0, 0.0], atol=1e-15)
    assert np.all(state.wheel_momentum == 0.0)


def test_harmonic_torque_from_outside():
    frequency, phase, size = 0.7, 0.4, 0.01
    disturbance = Disturbance(harmonics=(Harmonic((size, 0.0, 0.0), frequency, (phase, 0.0, 0.0)),))
    state = run(craft(np.diag([10.0, 19.0, 25.0]), (0.0,) * 3, disturbance=disturbance), np.zeros((1000, 4))).state
    expected = size / frequency / 10.0 * (np.cos(phase) - np.cos(frequency * 100.0 + phase))
    assert state.rate[0, 0] == pytest.approx(expected, rel=1e-7)


def test_axisymmetric_body_precesses():
    transverse, axial, spin, wobble, duration = 20.0, 30.0, 0.06, 0.03, 300.0
    scenario = craft(np.diag([transverse, transverse, axial]), (wobble, 0.0, spin), duration=duration)
    state = run(scenario, np.zeros((scenario.horizon, 4))).state
    relative = (axial - transverse) / transverse * spin  # rad/s: turn of the rate in body axes
    expected = [wobble * np.cos(relative * duration), wobble * np.sin(relative * duration), spin]
    np.testing.assert_allclose(state.rate[0], expected, rtol=0.0, atol=1e-10)
    # The body turns about the inertial momentum at |H|/A, and about its own axis at -relative.
    momentum = np.array([transverse * wobble, 0.0, axial * spin]) / transverse
    initial = np.array([0.5, -0.5, 0.5, 0.5])
    turn = att.quaternion_from_rotation_vector(duration * att.rotate_to_reference(initial, momentum))
    twist = att.quaternion_from_rotation_vector(np.array([0.0, 0.0, -relative * duration]))
    expected = att.quaternion_product(att.quaternion_product(turn, initial), twist)
    assert att.angle_between(state.attitude[0], expected) < 1e-8


def test_wheel_reaction_stops_a_spinning_body():
    # All the body's momentum goes into the wheels: single axis, through the wheels' own axis sums.
    scenario = craft(np.diag([10.0, 19.0, 25.0]), (0.0, 0.0, 0.02), attitude=(1.0, 0.0, 0.0, 0.0))
    command = np.linalg.pinv(PYRAMID) @ np.array([0.0, 0.0, -0.05])
    state = run(scenario, np.tile(command, (100, 1))).state  # 0.5 N m s in 10 s
    np.testing.assert_allclose(state.rate[0], 0.0, atol=1e-14)
    np.testing.assert_allclose(PYRAMID @ state.wheel_momentum[0], [0.0, 0.0, 0.5], atol=1e-13)


# -------------------------------------------------------------------------------------------------------- convergence


@pytest.mark.parametrize("coupling", [True, False])
def test_integrator_converges_with_order_four(coupling):
    scenario = craft(
        rate=(0.5, -0.6, 0.4),
        momentum=(5.0, -3.0, 4.0, 1.0),
        coupling=coupling,
        control_period=0.8,
        faults=FaultSchedule(
            (
                LossOfEffectiveness(wheel=0, onset=1.6, effectiveness=0.5, amplitude=0.4, frequency=1.5, phase=0.2),
                Bias(wheel=1, onset=2.4, recovery=6.4, amplitude=0.1, frequency=1.2, slope=0.01),
            )
        ),
        disturbance=Disturbance((0.0,) * 3, (Harmonic((0.5, 0.4, 0.3), 1.1),), rate_offset=0.1),
        inertia_uncertainty=InertiaUncertainty(amplitude=(1.0, 2.0, 1.5), frequency=(0.9,) * 3, rate_torque=True),
        physics_step=0.1,
        duration=800.0,
    )
    commands = np.random.default_rng(0).uniform(-0.2, 0.2, (10, 4))

    def end(step):
        state = run(scenario.replace(physics_step=step), commands).state
        return np.concatenate([state.attitude[0], state.rate[0], state.wheel_momentum[0]])

    truth = end(0.8 / 128)
    errors = [np.linalg.norm(end(step) - truth) for step in (0.1, 0.05, 0.025)]
    assert errors[0] > 1e-9
    for coarse, fine in pairwise(errors):
        assert 13.0 < coarse / fine < 20.0
