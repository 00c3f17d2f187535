"""Pointing error budgets against closed forms: a constant offset, a sine, and Gaussian noise."""

import dataclasses

import numpy as np
import pytest
from helpers.histories import DEGREE, FLAGSHIP, STEPS, history
from scipy import stats

from ftac_gym.attitude import quaternion_from_rotation_vector, quaternion_product
from ftac_gym.evaluation import episode_metrics
from ftac_gym.evaluation.metrics.budgets import pointing_budgets
from ftac_gym.task.scenario import SuccessCriterion

REFERENCE = quaternion_from_rotation_vector(np.array([0.4, -1.2, 0.8]))


def budgets(vector, hold=2.0):
    """Return the metrics of a spacecraft with a rotation vector of error (STEPS + 1, 3) [deg]."""
    turn = np.broadcast_to(np.asarray(vector)[:, None] * DEGREE, (STEPS + 1, 1, 3))
    reference = np.broadcast_to(REFERENCE, (STEPS + 1, 1, 4))
    made = history(error=np.linalg.norm(turn, axis=2) / DEGREE)
    success = SuccessCriterion(angle=DEGREE, rate=0.01, hold=hold)
    made = dataclasses.replace(
        made,
        scenario=FLAGSHIP.replace(faults=None, success=success),
        attitude=quaternion_product(reference, quaternion_from_rotation_vector(turn)),
        reference_attitude=reference,
    )
    return {name: values[0] for name, values in episode_metrics(made).items()}


def test_a_constant_offset_is_all_mean():
    found = budgets(np.tile([0.3, 0.0, -0.4], (STEPS + 1, 1)))
    for name in ("ape_95", "ape_997", "mpe"):
        assert found[name] == pytest.approx(0.5)
    assert found["rpe_95"] == pytest.approx(0.0, abs=1e-9) and found["rpe_997"] == pytest.approx(0.0, abs=1e-9)


def test_a_sine_about_an_offset():
    """Of a sine of amplitude a the magnitude stays below a sin(p pi / 2) for the share p of the time."""
    phase = 2.0 * np.pi * (np.arange(STEPS + 1) - 1) / STEPS
    sine = np.zeros((STEPS + 1, 3))
    sine[:, 1] = 0.2 * np.sin(phase)
    found = budgets(sine + np.array([0.3, 0.0, 0.0]), hold=10.0)
    assert found["mpe"] == pytest.approx(0.3)
    assert found["rpe_95"] == pytest.approx(0.2 * np.sin(0.475 * np.pi), rel=2e-3)
    assert found["rpe_997"] == pytest.approx(0.2, rel=2e-3)
    assert found["ape_997"] == pytest.approx(np.hypot(0.3, 0.2), rel=2e-3)
    assert found["jitter"] == pytest.approx(0.2 / np.sqrt(2.0), rel=1e-6)


def test_only_the_window_counts():
    error = np.zeros((STEPS + 1, 3))
    error[:81, 0], error[81:, 0] = 50.0, 0.1
    assert budgets(error)["ape_997"] == pytest.approx(0.1)


def test_the_mixed_interpretation_pools_samples_of_all_episodes():
    """Noise on three axes has the quantiles of the Maxwell distribution; offsets of episodes count in the APE alone."""
    random = np.random.default_rng(0)
    samples, episodes, size = 400, 500, 0.02
    noise = random.normal(scale=size, size=(samples, episodes, 3))
    offset = random.normal(scale=3.0 * size, size=(episodes, 3))
    relative = np.linalg.norm(noise - noise.mean(axis=0), axis=2)
    absolute = np.linalg.norm(noise + offset, axis=2)
    mean = np.linalg.norm(offset + noise.mean(axis=0), axis=1)
    found = pointing_budgets(absolute, mean, relative)
    scales = {"RPE": (size, 0.01), "APE": (np.hypot(1.0, 3.0) * size, 0.1), "MPE": (3.0 * size, 0.15)}
    for name, (scale, tolerance) in scales.items():
        expected = stats.maxwell.ppf([0.95, 0.997], scale=scale)
        np.testing.assert_allclose(found[name], expected, rtol=tolerance, err_msg=name)


def test_the_mixed_interpretation_of_unequal_episodes_is_no_mean_of_the_temporal_one():
    """One episode of forty is far off: at 95 % it is not seen, at 99.7 % it is."""
    absolute = np.full((50, 40), 0.1)
    absolute[:, 0] = 5.0
    low, high = pointing_budgets(absolute, absolute[0], absolute)["APE"]
    assert low == pytest.approx(0.1) and high == pytest.approx(5.0)


def test_without_episodes_there_is_no_budget():
    nothing = np.zeros((20, 0))
    assert np.isnan(list(pointing_budgets(nothing, np.zeros(0), nothing).values())).all()
