"""The fuzzy system: shares of rules, and the one number that it adapts."""

import numpy as np
import pytest
from helpers.prescribed_laws import Fuzzy
from hypothesis import given, settings
from hypothesis import strategies as st

from ftac_gym.baselines.components.fuzzy import FuzzyApproximator
from ftac_gym.baselines.memory import Memory

PERIOD, GAIN, LEAK, WIDTH = 0.05, 2.0, 0.3, 0.5


def system(count=4, inputs=9, rules=7, gain=GAIN, leak=LEAK):
    return FuzzyApproximator(Memory(count), inputs, gain, leak, WIDTH, PERIOD, rules)


@settings(max_examples=60, deadline=None)
@given(
    rules=st.integers(1, 12), inputs=st.integers(1, 9), size=st.sampled_from([1e-3, 0.3, 1.0, 5.0, 100.0, 1e6]),
    seed=st.integers(0, 10_000),
)  # fmt: skip
def test_memberships_are_shares(rules, inputs, size, seed):
    """They sum to one, so that P'P is within [1/N, 1]; however far away the inputs are."""
    x = size * np.random.default_rng(seed).normal(size=(4, inputs))
    shares = system(4, inputs, rules).memberships(x)
    assert shares.shape == (4, rules) and (shares >= 0.0).all()
    np.testing.assert_allclose(shares.sum(axis=1), 1.0, rtol=1e-12)
    squares = (shares**2).sum(axis=1)
    assert (squares >= (1.0 - 1e-12) / rules).all() and (squares <= 1.0 + 1e-12).all()


def test_memberships_are_normalised_gaussians():
    """Of width 1 at -3, -2, ... 3 on the diagonal, Eq. (18); the nearest centre has the largest."""
    x = np.random.default_rng(1).normal(size=(4, 6))
    centres = np.arange(-3.0, 4.0)
    grades = np.exp(-((x[:, None, :] - centres[None, :, None]) ** 2)).prod(axis=2)
    np.testing.assert_allclose(system(4, 6).memberships(x), grades / grades.sum(axis=1, keepdims=True), rtol=1e-10)
    assert system(4, 6).memberships(np.full((4, 6), 1.9)).argmax(axis=1).tolist() == [5] * 4


@pytest.mark.parametrize("size", [1.0, 1e6])
def test_all_is_finite_and_opposes_nothing(size):
    """theta P'P s / (2 h^2) has the direction of s, since theta is never negative."""
    random, fuzzy = np.random.default_rng(2), system()
    for _ in range(5):
        variable = random.normal(size=(4, 3))
        robust = fuzzy(variable, *size * random.normal(size=(3, 4, 3)))
        assert np.isfinite(robust).all() and (robust * variable >= 0.0).all()
    assert (np.abs(robust) > 0.0).all()


def test_theta_for_a_constant_drive():
    """theta_k = g/m (1 - (1 - m T)^k) with g = lambda |s|^2 P'P / (2 h^2): towards g (1 - exp(-m t)) / m."""
    fuzzy, random = system(), np.random.default_rng(3)
    variable, inputs = random.normal(size=(4, 3)), random.normal(size=(3, 4, 3))
    square = (fuzzy.memberships(np.concatenate(inputs, axis=1)) ** 2).sum(axis=1)
    weight = square / (2.0 * WIDTH**2)
    drive = GAIN * weight * (variable**2).sum(axis=1)
    for step in range(100):
        theta = drive / LEAK * (1.0 - (1.0 - LEAK * PERIOD) ** step)
        np.testing.assert_allclose(fuzzy(variable, *inputs), (theta * weight)[:, None] * variable, rtol=1e-12)
    np.testing.assert_allclose(theta, drive / LEAK * -np.expm1(-LEAK * 99 * PERIOD), rtol=0.02)
    for _ in range(2000):  # and decays
        fuzzy(np.zeros((4, 3)), *inputs)
    assert np.abs(fuzzy(variable, *inputs)).max() < 1e-10


def test_without_a_leak_theta_is_the_sum_of_the_drives():
    fuzzy, one = system(1, leak=0.0), np.array([[0.3, -0.4, 0.0]])
    inputs = (np.zeros((1, 3)),) * 3
    weight = (fuzzy.memberships(np.zeros((1, 9))) ** 2).sum() / (2.0 * WIDTH**2)
    for step in range(50):
        np.testing.assert_allclose(
            fuzzy(one, *inputs), step * PERIOD * GAIN * weight**2 * 0.25 * one, rtol=1e-12, atol=1e-16
        )  # fmt: skip


def test_agrees_with_an_independent_one_for_changing_inputs():
    random, fuzzy, other = np.random.default_rng(4), system(1), Fuzzy(PERIOD, WIDTH, GAIN, LEAK)
    for _ in range(50):
        variable, inputs = random.normal(size=3), random.normal(size=(3, 3))
        expected = other(variable, *inputs)
        np.testing.assert_allclose(fuzzy(variable[None], *inputs[:, None, :])[0], expected, rtol=1e-9, atol=1e-14)


def test_gain_zero_does_nothing():
    fuzzy, random = system(gain=0.0), np.random.default_rng(5)
    for _ in range(3):
        robust = fuzzy(random.normal(size=(4, 3)), *random.normal(size=(3, 4, 3)))
        np.testing.assert_array_equal(robust, np.zeros((4, 3)))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"gain": -1.0}, r"^fuzzy_gain must not be negative, got -1\.0"),
        ({"leak": -1.0}, r"^fuzzy_leak must not be negative, got -1\.0"),
        ({"leak": 21.0}, r"^fuzzy_leak must be at most one over the control period, 20\.0 1/s, got 21\.0"),
        ({"width": 0.0}, r"^fuzzy_width must be positive, got 0\.0"),
        ({"rules": 0}, "^rules must be a whole number, 1 or more, got 0"),
        ({"rules": 2.5}, r"^rules must be a whole number, 1 or more, got 2\.5"),
        ({"rules": True}, "^rules must be a whole number, 1 or more, got True"),
    ],
)
def test_bad_parameters(changes, message):
    with pytest.raises(ValueError, match=message):
        FuzzyApproximator(
            Memory(1), 9, **{"gain": 1.0, "leak": 0.1, "width": 0.5, "period": PERIOD, "rules": 7, **changes}
        )
