"""The regulator in the loop: exact near the target, optimal there, and smooth where the profile limits the error."""

import numpy as np
import pytest
from scipy.linalg import solve_discrete_are

from ftac_gym import baselines, scenarios
from ftac_gym.attitude import quaternion_from_rotation_vector, rotation_vector_from_quaternion
from ftac_gym.baselines.components.allocation import MinimaxAllocation
from ftac_gym.baselines.components.linear_quadratic import sampled_body
from ftac_gym.dynamics import Simulator
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.measurement import Measurement

QUIET = {"faults": None, "sensors": None, "disturbance": None, "inertia_uncertainty": None, "loop_delay": 0.0}
CALM = scenarios.get("flagship").replace(**QUIET)
WHEELS, INERTIA = CALM.spacecraft.wheels, CALM.spacecraft.inertia_matrix
RAW = {"attitude_filter_time": 0.0, "isolation": "none", "prediction": False, "calm_share": 0.0}


def torque_at(angles, axis, rates=0.0, **gains):
    """Return the torque (n, 3) [N m] for errors of some angles [rad] about an axis and rates about it [rad/s]."""
    count = len(angles)
    still, ones = np.zeros((count, 3)), np.ones((count, 1))
    measurement = Measurement(
        np.zeros(count), quaternion_from_rotation_vector(np.outer(angles, axis)), still + np.outer(ones * rates, axis),
        np.zeros((count, 4)), np.zeros((count, 4)), np.ones(count, dtype=bool), np.tile([1.0, 0, 0, 0], (count, 1)),
        still, still,
    )  # fmt: skip
    return baselines.make("lqr", CALM, count, **RAW, **gains).act(measurement) @ WHEELS.axis_matrix.T


def test_the_regulator_solves_the_riccati_equation():
    """The weights written out, in shares of the wheels' torque limits."""
    law = baselines.make("lqr", CALM)
    loop = CALM.control_period + CALM.loop_delay
    shares = np.linalg.pinv(WHEELS.axis_matrix) / WHEELS.torque_limits[:, None]
    angle, rate = shares @ INERTIA / loop**2, shares @ INERTIA / loop
    state, effort = np.zeros((6, 6)), shares.T @ shares
    state[:3, :3] = law.gains.angle_weight * angle.T @ angle
    state[3:, 3:] = law.gains.rate_weight * rate.T @ rate
    transition, effect = sampled_body(INERTIA, CALM.control_period)
    solution = solve_discrete_are(transition, effect, state, effort)
    gain = np.linalg.solve(effort + effect.T @ solution @ effect, effect.T @ solution @ transition)
    np.testing.assert_allclose(law.regulator, gain, rtol=1e-9)


def test_the_regulator_keeps_the_axis_of_the_error():
    """K1 = k1 J and K2 = k2 J for the whole inertia, with k1 and k2 of the double integrator of one axis."""
    law = baselines.make("lqr", CALM)
    loop, period = CALM.control_period + CALM.loop_delay, CALM.control_period
    transition, effect = np.array([[1.0, period], [0.0, 1.0]]), np.array([[0.5 * period**2], [period]])
    state = np.diag([law.gains.angle_weight / loop**4, law.gains.rate_weight / loop**2])
    solution = solve_discrete_are(transition, effect, state, np.eye(1))
    one_axis = np.linalg.solve(1.0 + effect.T @ solution @ effect, effect.T @ solution @ transition)[0]
    np.testing.assert_allclose(law.regulator, np.kron(one_axis, INERTIA), rtol=1e-7, atol=1e-7)
    assert np.abs(INERTIA - np.diag(np.diag(INERTIA))).max() > 0.1


def test_a_small_error_decays_as_the_linear_closed_loop_does():
    start = InitialState(angle=2e-4, max_rate=1e-6, wheel_momentum=0.0)
    simulator, law = Simulator(CALM.replace(initial_state=start), 4), baselines.make("lqr", CALM, 4, **RAW)
    simulator.reset(simulator.scenario.draw(0, 4))
    transition, effect = sampled_body(INERTIA, CALM.control_period)
    states = []
    for _ in range(40):
        measurement = simulator.measurement()
        angle = rotation_vector_from_quaternion(law._motion(measurement, move_on=False).error)
        states.append(np.hstack((angle, measurement.rate)))
        simulator.step(law.act(measurement))
    closed = transition - effect @ law.regulator
    for step in (1, 5, 10, 39):
        expected = states[0] @ np.linalg.matrix_power(closed, step).T
        np.testing.assert_allclose(states[step], expected, atol=1e-3 * np.abs(states[0]).max())
    assert np.abs(states[39]).max() < 0.01 * np.abs(states[0]).max()


def numbers(law):
    """Return k1 [1/s^2], k2 [1/s] and the slope [1/s]."""
    stiffness, damping = law.regulator[0, 0] / INERTIA[0, 0], law.regulator[0, 3] / INERTIA[0, 0]
    return stiffness, damping, stiffness / damping


def braking_about(axis, share):
    """Return a share of the deceleration of healthy wheels about an axis [rad/s^2]."""
    return share / (np.abs(MinimaxAllocation(WHEELS)((INERTIA @ axis)[None])) / WHEELS.torque_limits).max()


@pytest.mark.parametrize("axis", np.vstack([np.eye(3), [[0.6, -0.64, 0.48]]]))
def test_the_limit_of_the_error_is_smooth(axis):
    """The torque is that of the regulator up to the tangent; value and slope are continuous there.

    A rate keeps the wheels from saturating.
    """
    law = baselines.make("lqr", CALM, **RAW)
    stiffness, _, slope = numbers(law)
    end = braking_about(axis, law.gains.braking_share) * (1.0 / slope**2 - 1.0 / stiffness)
    angles = np.linspace(0.5 * end, 1.5 * end, 2001)
    torque = torque_at(angles, axis, -slope * end)
    exact = -(angles[:, None] * axis) @ law.regulator[:, :3].T + slope * end * (law.regulator[:, 3:] @ axis)
    np.testing.assert_allclose(torque[:1001], exact[:1001], atol=1e-9)
    assert np.abs(torque[1500:] - exact[1500:]).max(axis=1).min() > 1e-4
    steps = np.diff(torque @ axis)
    assert np.abs(np.diff(steps)).max() < 0.01 * np.abs(steps[0])


def test_on_the_profile_it_asks_for_the_deceleration_of_the_profile():
    """At the demanded rate of its angle it brakes at a; at the rate limit it coasts."""
    axis, share = np.array([0.6, -0.64, 0.48]), 0.5
    law = baselines.make("lqr", CALM, braking_share=share, **RAW)
    braking, limit = braking_about(axis, share), law.scheduled.rate_limit
    stiffness, _, slope = numbers(law)
    angles = np.array([0.05, 0.2, 0.5, 2.5])
    speed = np.sqrt(2.0 * braking * (angles + braking / stiffness - 0.5 * braking / slope**2))
    assert (speed[:3] < limit).all() and speed[3] > limit
    rates = -np.minimum(speed, limit)
    torque = np.array([torque_at([a], axis, v, braking_share=share)[0] for a, v in zip(angles, rates, strict=True)])
    expected = np.outer([braking, braking, braking, 0.0], INERTIA @ axis)
    np.testing.assert_allclose(torque, expected, rtol=1e-6, atol=1e-9)


def test_a_slew_keeps_its_axis():
    start = InitialState(angle=(1.5, 2.5), max_rate=0.0, wheel_momentum=0.0)
    simulator, law = Simulator(CALM.replace(initial_state=start), 8), baselines.make("lqr", CALM, 8, **RAW)
    simulator.reset(simulator.scenario.draw(0, 8))
    first = law._motion(simulator.measurement(), move_on=False).error[:, 1:]
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    for _ in range(100):
        simulator.step(law.act(simulator.measurement()))
        rate = simulator.state.rate
        np.testing.assert_allclose(rate, np.vecdot(rate, first)[:, None] * first, atol=1e-9)
    assert np.linalg.norm(rate, axis=1).min() > 0.05
