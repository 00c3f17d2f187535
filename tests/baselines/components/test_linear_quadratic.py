"""The sampled regulator: an exact model, the optimal gain, and a closed loop that no other gain improves."""

import numpy as np
from scipy.linalg import expm, solve_discrete_are

from ftac_gym.baselines.components.linear_quadratic import regulator, sampled_body

INERTIA = np.array([[12.0, 1.5, -0.7], [1.5, 19.0, 2.0], [-0.7, 2.0, 24.0]])  # kg m^2
PERIOD = 0.1  # s
TRANSITION, EFFECT = sampled_body(INERTIA, PERIOD)
STATE = np.diag([4e4, 5e4, 6e4, 9e3, 7e3, 8e3])
EFFORT = np.array([[20.0, 3.0, 0.0], [3.0, 25.0, 1.0], [0.0, 1.0, 30.0]])
GAIN = regulator(TRANSITION, EFFECT, STATE, EFFORT)


def cost(gain, start, steps=2000):
    """Return the sum of x' Q x + u' R u along the closed loop."""
    total = 0.0
    for _ in range(steps):
        command = -gain @ start
        total += start @ STATE @ start + command @ EFFORT @ command
        start = TRANSITION @ start + EFFECT @ command
    return total


def test_the_model_is_exact_under_a_held_torque():
    continuous = np.zeros((9, 9))
    continuous[:3, 3:6], continuous[3:6, 6:] = np.eye(3), np.linalg.inv(INERTIA)
    exact = expm(PERIOD * continuous)
    np.testing.assert_allclose(TRANSITION, exact[:6, :6], atol=1e-15)
    np.testing.assert_allclose(EFFECT, exact[:6, 6:], atol=1e-15)


def test_the_gain_is_that_of_the_riccati_equation():
    solution = solve_discrete_are(TRANSITION, EFFECT, STATE, EFFORT)
    weighted = EFFECT.T @ solution
    np.testing.assert_allclose((EFFORT + weighted @ EFFECT) @ GAIN, weighted @ TRANSITION, rtol=1e-9)
    assert np.abs(np.linalg.eigvals(TRANSITION - EFFECT @ GAIN)).max() < 1.0


def test_the_cost_of_the_closed_loop_is_that_of_the_riccati_solution():
    solution = solve_discrete_are(TRANSITION, EFFECT, STATE, EFFORT)
    start = np.array([0.01, -0.02, 0.03, 0.004, 0.001, -0.002])
    np.testing.assert_allclose(cost(GAIN, start), start @ solution @ start, rtol=1e-9)


def test_no_other_gain_costs_less():
    """From random starts, with random changes of the gain; the loss grows with the square of the change."""
    random = np.random.default_rng(0)
    for start in random.normal(size=(5, 6)):
        best, direction = cost(GAIN, start), random.normal(size=GAIN.shape) * np.abs(GAIN).max()
        losses = [cost(GAIN + size * direction, start) - best for size in (-0.02, -0.01, 0.01, 0.02)]
        assert min(losses) > 0.0
        np.testing.assert_allclose(losses[0] + losses[3], 4.0 * (losses[1] + losses[2]), rtol=0.1)


def test_a_dearer_effort_gives_a_slower_loop():
    slow = regulator(TRANSITION, EFFECT, STATE, 100.0 * EFFORT)
    poles = [np.abs(np.linalg.eigvals(TRANSITION - EFFECT @ gain)).min() for gain in (GAIN, slow)]
    assert poles[0] < poles[1] < 1.0 and np.abs(slow).max() < 0.5 * np.abs(GAIN).max()
