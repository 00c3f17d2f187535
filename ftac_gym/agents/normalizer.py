"""Standardisation of observations with the statistics of a training, which stand still."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ftac_gym.utils.parameters import FloatArray, non_negative, normalise, positive, require
from ftac_gym.utils.tables import check_finite

if TYPE_CHECKING:
    from stable_baselines3.common.vec_env import VecNormalize


@dataclass(frozen=True, eq=False)
class Normalizer:
    """Mean and variance of every entry of an observation; the arithmetic is that of Stable-Baselines3's VecNormalize.

    Parameters
    ----------
    mean, variance
        (size,) statistics.
    clip
        Largest magnitude of a standardised entry.
    epsilon
        Addition to the variance.
    count
        Observations that the statistics are of.

    Raises
    ------
    ValueError
        If the shapes differ, or a value is not finite or has the wrong sign.
    """

    mean: FloatArray
    variance: FloatArray
    clip: float
    epsilon: float
    count: float

    def __post_init__(self) -> None:
        """Check the statistics."""
        for name in ("mean", "variance"):
            values = getattr(self, name)
            shaped = isinstance(values, np.ndarray) and values.dtype == np.float64 and values.ndim == 1
            require(shaped, name, "must be one row of float64", getattr(values, "dtype", values))
            require(values.shape == self.mean.shape, name, f"must have shape {self.mean.shape}", values.shape)
            check_finite(values, name)
        require(bool((self.variance >= 0.0).all()), "variance", "must not be negative", float(self.variance.min()))
        normalise(self, positive, "clip", "epsilon")
        normalise(self, non_negative, "count")

    @classmethod
    def of(cls, trained: VecNormalize | None) -> Normalizer | None:
        """Return a copy of the present statistics of a VecNormalize; None if it leaves observations as they are."""
        if trained is None or not trained.norm_obs:
            return None
        statistics: Any = trained.obs_rms
        mean, variance = (np.array(values, dtype=np.float64) for values in (statistics.mean, statistics.var))
        return cls(mean, variance, trained.clip_obs, trained.epsilon, float(statistics.count))

    def check_size(self, size: int) -> None:
        """Raise a ValueError if the statistics are not of observations of this size: one entry would fit any."""
        own = len(self.mean)
        require(own == size, "normalizer", f"must be of observations of {size} entries, as the policy takes", own)

    def normalize(self, observations: npt.NDArray[Any]) -> npt.NDArray[np.float32]:
        """Return standardised observations (N, size)."""
        scaled = (observations - self.mean) / np.sqrt(self.variance + self.epsilon)
        return np.clip(scaled, -self.clip, self.clip).astype(np.float32)
