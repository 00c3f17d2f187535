"""Intervals of shares and of their paired differences that cover near zero and one too.

A percentile bootstrap of equal values has no width: of 500 successes in 500 episodes it says "1 to 1". Shares have
Wilson's interval instead, and paired differences that of Bonett and Price 2012 (J. Educ. Behav. Stat. 37(4)).
Both need a number of independent episodes. For a single run it is that of the episodes. For several training seeds, and
for shares of time, it is the number with the variance of the bootstrap over seeds and episodes. Where all values are
equal, it is that of the episodes.
"""

from __future__ import annotations

import numpy as np
from scipy import stats

from ftac_gym.evaluation.bootstrap import CONFIDENCE

_Z = float(stats.norm.ppf(0.5 + 0.5 * CONFIDENCE))


def effective_count(spread: float, variance: float, episodes: int) -> float:
    """Return the number of independent episodes with which a mean has a variance.

    Parameters
    ----------
    spread
        Variance of a single episode, ``p (1 - p)`` of a share p.
    variance
        Variance of the mean.
    episodes
        The number if either is zero.
    """
    # The variance of equal values is rounding.
    return spread / variance if spread > 0.0 and variance > 1e-12 * spread else float(episodes)


def share_ends(share: float, count: float) -> tuple[float, float]:
    """Return both ends of Wilson's interval (Wilson 1927, J. Am. Stat. Assoc. 22).

    Parameters
    ----------
    share
        The share, in [0, 1].
    count
        Number of independent episodes, not only whole ones.
    """
    scale = 1.0 + _Z**2 / count
    middle = share + 0.5 * _Z**2 / count
    half = _Z * np.sqrt(share * (1.0 - share) / count + 0.25 * (_Z / count) ** 2)
    low, high = (middle - half) / scale, (middle + half) / scale
    return float(np.clip(low, 0.0, share)), float(np.clip(high, share, 1.0))


def difference_ends(better: float, worse: float, count: float) -> tuple[float, float]:
    """Return both ends of the interval of a paired difference of shares.

    Parameters
    ----------
    better, worse
        Share of the pairs in which only the first is a success, and only the second.
    count
        Number of independent pairs, not only whole ones.
    """
    first, second = ((share * count + 1.0) / (count + 2.0) for share in (better, worse))
    middle = first - second
    half = _Z * np.sqrt((first + second - middle**2) / (count + 2.0))
    value = better - worse
    return float(np.clip(middle - half, -1.0, value)), float(np.clip(middle + half, value, 1.0))


def newcombe_ends(first: float, second: float, count: float) -> tuple[float, float]:
    """Return both ends of the interval of a difference of two shares of as many episodes, taken for independent.

    It is the square-and-add interval of Newcombe 1998 (Stat. Med. 17, method 10).
    """
    (low, high), (other_low, other_high) = share_ends(first, count), share_ends(second, count)
    value = first - second
    return value - np.hypot(first - low, other_high - second), value + np.hypot(high - first, second - other_low)
