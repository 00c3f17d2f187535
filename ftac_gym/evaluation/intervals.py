"""Censored times, shares and rates of events, with 95 % intervals of their own distributions.

They describe independent events. Several faults of an episode are not quite that, and the same faults of several
policies are paired: differences of policies need :mod:`ftac_gym.evaluation.statistics`.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import stats

from ftac_gym.evaluation.bootstrap import CONFIDENCE
from ftac_gym.evaluation.shares import share_ends
from ftac_gym.evaluation.statistics import Estimate
from ftac_gym.utils.parameters import FloatArray, require, whole


@dataclass(frozen=True, eq=False)
class Survival:
    """Kaplan-Meier estimate of the share of times that exceed each time.

    Attributes
    ----------
    times
        (K,) increasing times: zero, those of events and those of censored ones.
    share, low, high
        (K,) share beyond each of them, from there on, with pointwise intervals. They are by the logarithm of the
        logarithm, and Wilson's where the share is one or zero.
    events, total
        Number of events, and of all times.
    """

    times: FloatArray
    share: FloatArray
    low: FloatArray
    high: FloatArray
    events: int
    total: int

    def within(self, limit: float) -> Estimate:
        """Return the share of times up to a limit, both included; NaN without times, a ValueError below zero."""
        require(limit >= 0.0, "limit", "must not be negative", limit)
        if not self.total:
            return Estimate(np.nan, np.nan, np.nan, 0, 0, 0)
        last = int(np.searchsorted(self.times, limit, side="right")) - 1
        value, low, high = (1.0 - float(curve[last]) for curve in (self.share, self.high, self.low))
        return Estimate(value, low, high, self.total, self.events, self.total)

    @property
    def median(self) -> Estimate:
        """Median time with its interval (Brookmeyer and Crowley 1982); infinite if half of them lie beyond all events.

        NaN without times.
        """
        value, low, high = (self._first(curve) for curve in (self.share, self.low, self.high))
        return Estimate(value, low, high, self.total, self.events, self.total)

    def _first(self, curve: FloatArray) -> float:
        """Return the first time at which a curve is at most one half."""
        if not self.total:
            return np.nan
        # Products of shares round: one half can end up a bit above itself.
        reached = np.flatnonzero(curve <= 0.5 + 1e-12)
        return float(self.times[reached[0]]) if reached.size else np.inf


def survival(times: npt.ArrayLike, observed: npt.ArrayLike) -> Survival:
    """Estimate the distribution of times that are only known to exceed a limit where no event was observed.

    Parameters
    ----------
    times
        (M,) time of the event, or time for which none was observed.
    observed
        (M,) whether the event was observed; the time is censored where it was not.

    Raises
    ------
    ValueError
        If the two do not match, or a time is negative or not finite.
    """
    found = np.asarray(times, dtype=np.float64)
    seen = np.asarray(observed, dtype=np.bool_)
    require(found.ndim == 1 and found.shape == seen.shape, "observed", f"must have shape {found.shape}", seen.shape)
    valid = bool(np.isfinite(found).all() and (found >= 0.0).all())
    require(valid, "times", "must be finite and not negative", found)
    if not found.size:
        nothing = np.zeros(0)
        return Survival(nothing, nothing, nothing, nothing, 0, 0)
    sample = stats.CensoredData(uncensored=found[seen], right=found[~seen])
    curve = stats.ecdf(sample).sf
    share = curve.probabilities
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore", RuntimeWarning)
        band: Any = curve.confidence_interval(CONFIDENCE, method="log-log")
    low, high = band.low.probabilities, band.high.probabilities
    for place in np.flatnonzero((share == 1.0) | (share == 0.0)):
        # The band is not defined there. Times that were censored before say nothing about this one.
        known = len(found) - int((found[~seen] < curve.quantiles[place]).sum())
        low[place], high[place] = share_ends(share[place], known)
    start, end = share_ends(1.0, len(found))
    return Survival(
        times=np.append(0.0, curve.quantiles),
        share=np.append(1.0, share),
        low=np.append(start, low),
        high=np.append(end, high),
        events=int(seen.sum()),
        total=len(found),
    )


def share_of_count(count: int, total: int) -> Estimate:
    """Return a share of independent cases with Wilson's interval; NaN without cases.

    The interval covers near shares of zero and one too, where a bootstrap of equal values has no width.

    Raises
    ------
    ValueError
        If the count is not a whole number within [0, total].
    """
    require(whole(count, 0, "count") <= whole(total, 0, "total"), "count", f"must be within [0, {total}]", count)
    if not total:
        return Estimate(np.nan, np.nan, np.nan, 0, 0, 0)
    return Estimate(count / total, *share_ends(count / total, total), int(total), int(total), int(total))


def rate_of_count(count: int, exposure: float) -> Estimate:
    """Return a rate of independent events with the exact interval of Poisson's distribution (Garwood 1936).

    Parameters
    ----------
    count
        Number of events.
    exposure
        Time in which they were counted; the rate has its inverse unit. NaN for none.

    Raises
    ------
    ValueError
        If the count is no whole number, or one is negative.
    """
    whole(count, 0, "count")
    require(exposure >= 0.0, "exposure", "must not be negative", exposure)
    if exposure == 0.0:
        return Estimate(np.nan, np.nan, np.nan, 0, 0, 0)
    tail = 0.5 * (1.0 - CONFIDENCE)
    low = stats.chi2.ppf(tail, 2 * count) / 2.0 if count else 0.0
    high = stats.chi2.ppf(1.0 - tail, 2 * (count + 1)) / 2.0
    return Estimate(count / exposure, float(low) / exposure, float(high) / exposure, count, count, count)
