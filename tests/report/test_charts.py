"""Charts of the report."""

import numpy as np
from helpers.benchmarks import agent

from ftac_gym.report.charts import spread
from ftac_gym.report.pictures import training_curve


def test_training_curves_are_the_mean_and_the_range_of_seeds():
    rows = [{"steps": 100.0 * k, "success": 0.1 * k} for k in range(1, 5)]
    later = [{"steps": 100.0 * k + 50.0, "success": 0.1 * k + 0.25} for k in range(1, 4)]
    entry = agent("a", curves=(tuple(rows), tuple(later)))
    curve = training_curve(entry, "success")
    np.testing.assert_allclose(curve.x, [200.0, 300.0])
    np.testing.assert_allclose(curve.low, [0.2, 0.3])
    np.testing.assert_allclose(curve.high, [0.4, 0.5])
    np.testing.assert_allclose(curve.y, [0.3, 0.4])
    assert training_curve(entry, "mean_return") is None


def test_labels_are_spread_no_further_than_needed():
    np.testing.assert_allclose(spread(np.array([0.1, 0.5, 0.9]), 0.1), [0.1, 0.5, 0.9])
    np.testing.assert_allclose(spread(np.array([0.2, 0.5, 0.5, 0.5]), 0.1), [0.2, 0.4, 0.5, 0.6])
    np.testing.assert_allclose(spread(np.array([0.99, 1.0]), 0.1), [0.9, 1.0])
    placed = spread(np.sort(np.random.default_rng(0).random(30)), 0.05)
    assert (np.diff(placed) >= 0.05 - 1e-12).all()
    assert spread(np.zeros(0), 0.1).size == 0
