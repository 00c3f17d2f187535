"""Pointing error budgets after ECSS-E-ST-60-10C (2008), over the window of the last ``success.hold`` seconds.

The error is the rotation vector of the attitude error, e(t). The *absolute* performance error (APE) is ``|e(t)|``. The
*mean* performance error (MPE) is the length of the mean of e over the window. The *relative* performance error (RPE) is
``|e(t) - mean e|``. The values of one episode are those of the standard's *temporal* interpretation: the level that the
error stays below for so much of the time. Over all episodes, :func:`pointing_budgets` pools the samples: the *mixed*
interpretation, over time and ensemble together.

============ ==========================================================================================================
``ape_95``   95th percentile of the APE over the window
``ape_997``  99.7th percentile of the APE
``mpe``      MPE
``rpe_95``   95th percentile of the RPE over the window
``rpe_997``  99.7th percentile of the RPE
============ ==========================================================================================================
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from ftac_gym.evaluation.metrics.metric import Metric
from ftac_gym.utils.parameters import FloatArray

if TYPE_CHECKING:
    from ftac_gym.evaluation.metrics.history import Rollout

CONFIDENCES = (95.0, 99.7)
"""Levels of confidence of the budgets [%]."""

METRICS = tuple(Metric(name, "deg") for name in ("ape_95", "ape_997", "mpe", "rpe_95", "rpe_997"))


def measure(history: Rollout) -> dict[str, FloatArray]:
    """Return the metrics, arrays (N,) by name."""
    absolute = np.percentile(history.attitude_error[history.window], CONFIDENCES, axis=0)
    relative = np.percentile(history.relative_error, CONFIDENCES, axis=0)
    mean = np.linalg.norm(history.error_vector.mean(axis=0), axis=1)
    return dict(zip((metric.name for metric in METRICS), np.degrees([*absolute, mean, *relative]), strict=True))


def pointing_budgets(
    absolute: npt.NDArray[np.floating], mean: FloatArray, relative: npt.NDArray[np.floating]
) -> dict[str, tuple[float, float]]:
    """Return the budgets of an ensemble in the mixed interpretation.

    Parameters
    ----------
    absolute, relative
        APE and RPE, (K, N) over the window of each episode.
    mean
        (N,) MPE.

    Returns
    -------
    Levels at 95 and 99.7 % confidence, in the units of the errors, by ``"APE"``, ``"MPE"`` and ``"RPE"``; NaN without
    episodes.
    """
    samples = {"APE": absolute, "MPE": mean, "RPE": relative}
    return {
        name: tuple(np.percentile(values, CONFIDENCES).tolist()) if values.size else (np.nan, np.nan)
        for name, values in samples.items()
    }
