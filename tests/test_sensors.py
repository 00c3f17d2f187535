"""Tests of `ftac_gym.sensors`: what is drawn and what is refused (for what is measured see test_sensing)."""

import numpy as np
import pytest
from scipy import stats

from ftac_gym.sensors import SensorErrors


def test_noise_levels_are_those_given():
    table = SensorErrors(attitude_noise=1e-4, rate_noise=2e-5, gyro_bias_walk=3e-7).draw(np.zeros((4, 3)))
    assert table.shape == (4,)
    assert np.all(table["attitude_noise"] == 1e-4)
    assert np.all(table["rate_noise"] == 2e-5)
    assert np.all(table["gyro_bias_walk"] == 3e-7)
    assert np.all(table["gyro_bias"] == 0.0)


def test_initial_gyro_bias_is_uniform_and_independent_on_each_axis():
    errors = SensorErrors(gyro_bias=(-1e-5, 3e-5))
    bias = errors.draw(np.random.default_rng(0).random((3000, errors.uniform_count)))["gyro_bias"]
    assert bias.shape == (3000, 3)
    for column in bias.T:
        assert stats.kstest(column, "uniform", (-1e-5, 4e-5)).pvalue > 1e-3
    assert np.abs(np.corrcoef(bias.T) - np.eye(3)).max() < 0.1


def test_fixed_gyro_bias_is_the_same_for_all():
    assert np.all(SensorErrors(gyro_bias=2e-6).draw(np.random.default_rng(0).random((5, 3)))["gyro_bias"] == 2e-6)


@pytest.mark.parametrize("field", ["attitude_noise", "rate_noise", "gyro_bias_walk"])
@pytest.mark.parametrize(
    ("value", "rule"),
    [(-1e-9, "must not be negative"), (float("nan"), "must be finite"), ("small", "must be a number")],
)
def test_noise_rules(field, value, rule):
    with pytest.raises(ValueError, match=f"{field} {rule}"):
        SensorErrors(**{field: value})


def test_gyro_bias_rules():
    with pytest.raises(ValueError, match="gyro_bias must have low <= high"):
        SensorErrors(gyro_bias=(1.0, -1.0))
    with pytest.raises(ValueError, match=r"gyro_bias must be a number or a pair \(low, high\)"):
        SensorErrors(gyro_bias=(1.0, 2.0, 3.0))
