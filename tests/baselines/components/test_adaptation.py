"""Gains that grow and are forgotten, in closed form; and the saturation function."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ftac_gym.baselines.components.adaptation import LeakyAdaptation
from ftac_gym.baselines.components.reaching import saturation, soft_sign
from ftac_gym.baselines.memory import Memory

PERIOD = 0.1


def adaptation(gain=2.0, leak=0.5, period=PERIOD, initial=0.3, count=2, columns=3):
    return LeakyAdaptation(Memory(count), "gain", columns, gain, leak, period, initial)


@pytest.mark.parametrize("leak", [0.5, 10.0])
def test_a_constant_drive_gives_a_geometric_series(leak):
    grown, drive = adaptation(leak=leak), np.array([[1.0, -2.0, 0.0], [0.5, 3.0, 7.0]])
    np.testing.assert_array_equal(grown.value, np.full((2, 3), 0.3))
    kept = 1.0 - leak * PERIOD
    for step in range(1, 30):
        grown.update(drive)
        series = 2.0 * PERIOD * drive * sum(kept**power for power in range(step))
        np.testing.assert_allclose(grown.value, 0.3 * kept**step + series, rtol=1e-12, atol=1e-15)


def test_it_settles_where_the_drive_balances_the_leak():
    grown, drive = adaptation(gain=4.0, leak=2.0), np.array([[1.0, 2.0, 3.0], [0.0, 10.0, 0.1]])
    for _ in range(200):
        grown.update(drive)
    np.testing.assert_allclose(grown.value, 4.0 * drive / 2.0, rtol=1e-12, atol=1e-15)


def test_without_a_leak_it_only_grows():
    grown, drive = adaptation(leak=0.0, initial=0.0), np.abs(np.random.default_rng(0).normal(size=(50, 2, 3)))
    for part in drive:
        before = grown.value.copy()
        grown.update(part)
        assert (grown.value > before).all()
    np.testing.assert_allclose(grown.value, 2.0 * PERIOD * drive.sum(axis=0), rtol=1e-12)


@given(
    leak=st.floats(0.0, 1.0 / PERIOD), gain=st.floats(0.0, 1e3), initial=st.floats(0.0, 1e3),
    drives=st.lists(st.floats(0.0, 1e3), max_size=20),
)  # fmt: skip
def test_it_keeps_its_sign_under_a_drive_of_one_sign(leak, gain, initial, drives):
    grown = adaptation(gain=gain, leak=leak, initial=initial, count=1, columns=1)
    for drive in drives:
        grown.update(np.array([[drive]]))
        assert grown.value[0, 0] >= -1e-12 * max(initial, gain * max(drives))


def test_craft_that_are_reset_start_again_alone():
    memory = Memory(3)
    grown = LeakyAdaptation(memory, "gain", 1, 1.0, 0.1, PERIOD, initial=2.0)
    grown.update(np.ones((3, 1)))
    memory.reset(np.array([False, True, False]))
    np.testing.assert_allclose(grown.value[:, 0], [2.08, 2.0, 2.08])


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"leak": 10.01}, "leak must be at most one over the control period, 10.0 1/s, got 10.01"),
        ({"leak": 0.6, "period": 2.0}, "leak must be at most one over the control period, 0.5 1/s, got 0.6"),
        ({"leak": -1.0}, "leak must not be negative"),
        ({"gain": -1.0}, "gain must not be negative"),
        ({"gain": np.inf}, "gain must be finite"),
        ({"initial": np.nan}, "initial must be finite"),
    ],
)
def test_bad_values(changes, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        adaptation(**changes)


def test_saturation_is_linear_within_its_width_and_one_outside():
    values = np.array([-1e9, -0.2, -0.1, 0.0, 0.05, 0.2, 0.3])
    np.testing.assert_allclose(saturation(values, 0.2), [-1.0, -1.0, -0.5, 0.0, 0.25, 1.0, 1.0], rtol=1e-15)


def test_saturation_without_a_width_is_the_sign():
    values = np.array([-3.0, -1e-300, 0.0, 1e-300, 2.0])
    np.testing.assert_array_equal(saturation(values, 0.0), [-1.0, -1.0, 0.0, 1.0, 1.0])
    np.testing.assert_allclose(saturation(np.array([-1e-6, 1e-6]), 1e-9), [-1.0, 1.0])  # and the limit of small ones


def test_the_soft_sign_stays_within_one_and_is_linear_at_zero():
    values, width = np.array([-1e300, -2.0, 0.0, 1e-9, 2.0]), np.array([0.5])
    np.testing.assert_allclose(soft_sign(values, width), [-1.0, -0.8, 0.0, 2e-9, 0.8], rtol=1e-8)
