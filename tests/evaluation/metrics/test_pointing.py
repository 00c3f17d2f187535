"""Pointing error and prescribed bounds against histories made by hand."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.histories import DEGREE, PERIOD, STEPS, errors, history, one

from ftac_gym.attitude import quaternion_from_mrp, quaternion_product
from ftac_gym.evaluation import episode_metrics
from ftac_gym.task.prescribed_bound import PrescribedBound


def test_final_error():
    error = errors([(0, 50.0), (81, 3.0), (91, 4.0)])  # of the last 20 samples, 10 are 3 and 10 are 4 degrees
    assert one("final_error", error=error) == pytest.approx(np.sqrt(12.5))


def test_integrated_error():
    assert one("integrated_error", error=errors([(0, 2.0)])) == pytest.approx(2.0 * STEPS * PERIOD)
    assert one("integrated_error", error=errors([(0, 9.0), (51, 0.0)])) == pytest.approx(9.0 * 5.0)


def test_path_ratio_of_the_shortest_way_is_one():
    turn = 90.0
    error = np.maximum(turn * (1.0 - np.arange(STEPS + 1) / 50.0), 0.0)[:, None]
    rate = np.where(np.arange(STEPS + 1) <= 50, turn * DEGREE / 5.0, 0.0)[:, None]
    rate[0] = 0.0
    assert one("path_ratio", error=error, rate_error=rate) == pytest.approx(1.0)
    assert one("path_ratio", error=error, rate_error=3.0 * rate) == pytest.approx(3.0)


def bounded(error_mrp, bound):
    """Return the metrics of a spacecraft whose attitude error is an MRP (STEPS + 1, N, 3)."""
    made = history(count=error_mrp.shape[1])
    identity = np.zeros_like(made.attitude)
    identity[..., 0] = 1.0
    # The same error, about a reference that is turned.
    reference = quaternion_product(np.array([0.6, 0.0, 0.8, 0.0]), identity)
    return episode_metrics(
        replace(
            made,
            scenario=made.scenario.replace(prescribed_bound=bound),
            attitude=quaternion_product(reference, quaternion_from_mrp(error_mrp)),
            reference_attitude=reference,
        )
    )


def test_a_prescribed_bound_is_kept_or_not_by_any_policy():
    bound = PrescribedBound(initial=0.5, final=0.1, decay=0.3, lower=(1.0, 1.0, 0.2), upper=(0.5, 1.0, 1.0))
    time = np.arange(STEPS + 1) * PERIOD
    low, high = bound.bound(time)
    share = np.array([0.5, 0.1, 0.01, 1.01])  # of the way from the lower bound to the upper one
    error = low[:, None] + share[:, None] * (high - low)[:, None]
    error[0, 3] = 0.0
    metrics = bounded(error, bound)
    np.testing.assert_array_equal(metrics["bound_kept"], [1.0, 1.0, 1.0, 0.0])
    np.testing.assert_allclose(metrics["bound_margin"], [0.5, 0.1, 0.01, -0.01], atol=1e-12)
    error[50, 0, 2] = high[50, 2] + 1e-6  # one sample of one axis is enough
    assert bounded(error, bound)["bound_kept"][0] == 0.0


def test_without_a_bound_there_is_nothing_to_keep():
    metrics = episode_metrics(history(count=2))
    assert np.isnan(metrics["bound_kept"]).all() and np.isnan(metrics["bound_margin"]).all()
