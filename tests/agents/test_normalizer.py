"""Standardisation of observations: bit for bit that of Stable-Baselines3, and fixed."""

import numpy as np
import pytest
from helpers.networks import SIZE, environment, observations

from ftac_gym.agents.normalizer import Normalizer

WHOLE = {"mean": np.zeros(3), "variance": np.ones(3), "clip": 1.0, "epsilon": 1e-8, "count": 1.0}


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_it_equals_stable_baselines(dtype):
    trained = environment()
    given = observations().astype(dtype) * np.logspace(-8, 8, SIZE).astype(dtype)
    standardised = Normalizer.of(trained).normalize(given)
    expected = trained.normalize_obs(given)
    assert standardised.dtype == expected.dtype == np.float32 and (np.abs(standardised) == 5.0).any()
    np.testing.assert_array_equal(standardised, expected)


def test_it_stands_still_while_the_training_goes_on():
    trained = environment()
    normalizer = Normalizer.of(trained)
    before = normalizer.normalize(observations())
    trained.obs_rms.update(np.ones((10, SIZE)))
    trained.obs_rms.mean += 1.0
    np.testing.assert_array_equal(normalizer.normalize(observations()), before)


def test_observations_that_a_training_left_as_they_are_have_none():
    trained = environment()
    trained.norm_obs = False
    assert Normalizer.of(trained) is None and Normalizer.of(None) is None


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"mean": np.zeros(3, dtype=np.float32)}, "mean must be one row of float64"),
        ({"mean": np.array([0.0, np.nan, 0.0])}, "mean must be finite"),
        ({"variance": np.ones(2)}, r"variance must have shape \(3,\), got \(2,\)"),
        ({"variance": np.array([1.0, -1.0, 1.0])}, "variance must not be negative, got -1.0"),
        ({"clip": 0.0}, "clip must be positive"),
        ({"epsilon": float("nan")}, "epsilon must be finite"),
    ],
)
def test_what_is_refused(change, message):
    with pytest.raises(ValueError, match=message):
        Normalizer(
            **{"mean": np.zeros(3), "variance": np.ones(3), "clip": 1.0, "epsilon": 1e-8, "count": 1.0, **change}
        )
