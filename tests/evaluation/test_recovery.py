"""Shares and medians of recovery times with censored ones, against SciPy and cases by hand."""

import numpy as np
import pytest
from scipy import stats

from ftac_gym.evaluation.metrics import Recoveries
from ftac_gym.evaluation.recovery import recovered_difference, recovered_within, recovery_survival


def recoveries(times, recovered, width=1):
    """Return recoveries of N episodes with faults at 10 s, from times (N, F); NaN for no fault."""
    time = np.array(times, dtype=float).reshape(-1, width)
    there = ~np.isnan(time)
    seen = np.broadcast_to(np.array(recovered).reshape(-1, width), time.shape) & there
    return Recoveries(there.astype(np.int64), np.where(there, 10.0, np.nan), time, seen, time)


def everything(item):
    return np.ones(len(item.time), dtype=bool)


def test_by_hand_with_a_censored_time():
    """Kaplan-Meier: of five, one recovers after 2 s; one is seen for 4 s; of the remaining three one after 6 s."""
    item = recoveries([2.0, 4.0, 6.0, 30.0, 50.0], [True, False, True, True, False])
    found = recovered_within([item], everything(item), 10.0)
    assert found.value == pytest.approx(1.0 - 4.0 / 5.0 * 2.0 / 3.0)
    assert (found.count, found.defined, found.total) == (5, 4, 5)
    assert found.low < found.value < found.high
    curve = recovery_survival([item], everything(item)[:, None])
    assert curve.median.value == 30.0 and (curve.events, curve.total) == (3, 5)


def test_the_share_is_that_of_scipy():
    random = np.random.default_rng(0)
    time, seen = random.integers(0, 30, (40, 2)).astype(float), random.random((40, 2)) < 0.7
    time[random.random((40, 2)) < 0.3] = np.nan
    item = recoveries(time, seen, 2)
    known = ~np.isnan(time)
    sample = stats.CensoredData(uncensored=time[known & seen], right=time[known & ~seen])
    for limit in (0.0, 5.0, 10.0, 29.0):
        found = recovered_within([item], everything(item), limit)
        assert found.value == pytest.approx(1.0 - stats.ecdf(sample).sf.evaluate(limit), abs=1e-12)


def test_without_censored_times_it_is_the_share_and_seeds_and_episodes_are_chosen():
    one = recoveries([1.0, 20.0, 3.0, np.nan], True)
    two = recoveries([1.0, 2.0, np.nan, 40.0], True)
    chosen = np.array([True, True, True, False])
    found = recovered_within([one, two], chosen)
    assert found.value == pytest.approx(4.0 / 5.0) and (found.count, found.total) == (3, 5)


def test_all_recovered_is_not_certain_and_nothing_is_unknown():
    item = recoveries(np.ones(50), True)
    found = recovered_within([item], everything(item))
    assert found.value == found.high == 1.0 and 0.9 < found.low < 0.95
    nothing = recoveries(np.full(5, np.nan), False)
    empty = recovered_within([nothing], everything(nothing))
    assert np.isnan([empty.value, empty.low, empty.high]).all() and empty.count == empty.total == 0
    none = recovered_difference([nothing], [nothing], everything(nothing))
    assert np.isnan(none.value) and none.count == 0 and not none.excludes_zero


def test_the_interval_covers_the_share_with_faults_that_belong_together():
    """Both faults of an episode recover, or none: the episodes are the independent ones."""
    random, covered = np.random.default_rng(1), 0
    for _ in range(100):
        good = np.repeat(random.random(80) < 0.8, 2)
        item = recoveries(np.where(good, 3.0, 30.0), good, 2)
        found = recovered_within([item], everything(item))
        covered += found.low <= 0.8 <= found.high
    assert 0.88 <= covered / 100 <= 1.0


def test_differences_are_over_the_same_episodes():
    random = np.random.default_rng(2)
    luck = random.random(300)
    first, second = (recoveries(np.where(luck < level, 3.0, 30.0), True) for level in (0.9, 0.8))
    found = recovered_difference([first], [second], everything(first))
    assert found.value == pytest.approx((luck < 0.9).mean() - (luck < 0.8).mean()) and found.excludes_zero
    apart = [recovered_within([item], everything(item)) for item in (first, second)]
    assert found.high - found.low < apart[0].high - apart[0].low + apart[1].high - apart[1].low
    same = recovered_difference([first], [first], everything(first))
    assert same.value == 0.0 and same.low < 0.0 < same.high
