"""Tests of `ftac_gym.task.sensors`: what is drawn and what is refused (for what is measured see test_sensing)."""

import numpy as np
import pytest
from scipy import stats

from ftac_gym.task import SensorErrors


def test_noise_levels_are_those_given():
    table = SensorErrors(attitude_noise=1e-4, rate_noise=2e-5, gyro_bias_walk=3e-7).draw(np.zeros((4, 6)))
    assert table.shape == (4,)
    assert np.all(table["attitude_noise"] == 1e-4)
    assert np.all(table["rate_noise"] == 2e-5)
    assert np.all(table["gyro_bias_walk"] == 3e-7)
    assert np.all(table["gyro_bias"] == 0.0)
    assert np.all(table["gyro_misalignment"] == 0.0)


def test_initial_gyro_bias_is_uniform_and_independent_on_each_axis():
    errors = SensorErrors(gyro_bias=(-1e-5, 3e-5))
    bias = errors.draw(np.random.default_rng(0).random((3000, errors.uniform_count)))["gyro_bias"]
    assert bias.shape == (3000, 3)
    for column in bias.T:
        assert stats.kstest(column, "uniform", (-1e-5, 4e-5)).pvalue > 1e-3
    assert np.abs(np.corrcoef(bias.T) - np.eye(3)).max() < 0.1


def test_fixed_gyro_bias_is_the_same_for_all():
    assert np.all(SensorErrors(gyro_bias=2e-6).draw(np.random.default_rng(0).random((5, 6)))["gyro_bias"] == 2e-6)


def test_gyros_are_turned_by_the_given_angle_about_any_axis():
    errors = SensorErrors(gyro_misalignment=(1e-3, 3e-3), gyro_bias=(-1.0, 1.0))
    table = errors.draw(np.random.default_rng(1).random((3000, errors.uniform_count)))
    angle = np.linalg.norm(table["gyro_misalignment"], axis=1)
    assert stats.kstest(angle, "uniform", (1e-3, 2e-3)).pvalue > 1e-3
    # On the unit sphere each coordinate is uniform, and the squares of two of them correlate by -1/2.
    axis = table["gyro_misalignment"] / angle[:, None]
    for column in axis.T:
        assert stats.kstest(column, "uniform", (-1.0, 2.0)).pvalue > 1e-3
    others = np.column_stack([axis, angle, table["gyro_bias"]])
    assert np.abs(np.corrcoef(others.T) - np.eye(7)).max() < 0.1


@pytest.mark.parametrize("field", ["attitude_noise", "rate_noise", "gyro_bias_walk"])
@pytest.mark.parametrize(
    ("value", "rule"),
    [(-1e-9, "must not be negative"), (float("nan"), "must be finite"), ("small", "must be a number")],
)
def test_noise_rules(field, value, rule):
    with pytest.raises(ValueError, match=f"{field} {rule}"):
        SensorErrors(**{field: value})


@pytest.mark.parametrize(
    ("value", "rule"),
    [
        (-1e-9, r"must stay within \[0, 0.1\]"),
        (0.11, r"must stay within \[0, 0.1\]"),
        ((0.05, 0.2), r"must stay within \[0, 0.1\]"),
        ((0.02, 0.01), "must have low <= high"),
        (float("nan"), "must be finite"),
        ("small", "must be a number"),
    ],
)
def test_misalignment_rules(value, rule):
    with pytest.raises(ValueError, match=f"gyro_misalignment {rule}"):
        SensorErrors(gyro_misalignment=value)


def test_gyro_bias_rules():
    with pytest.raises(ValueError, match="gyro_bias must have low <= high"):
        SensorErrors(gyro_bias=(1.0, -1.0))
    with pytest.raises(ValueError, match=r"gyro_bias must be a number or a pair \(low, high\)"):
        SensorErrors(gyro_bias=(1.0, 2.0, 3.0))
