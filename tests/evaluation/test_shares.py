"""Intervals of shares: against SciPy's, and how often they cover near zero and one."""

import numpy as np
import pytest
from scipy import stats

from ftac_gym.evaluation import estimate, paired_difference
from ftac_gym.evaluation.bootstrap import CONFIDENCE
from ftac_gym.evaluation.shares import newcombe_ends, share_ends
from ftac_gym.evaluation.statistics import share


@pytest.mark.parametrize(("count", "total"), [(0, 20), (20, 20), (497, 500), (250, 500), (1, 1)])
def test_a_share_of_a_single_run_has_wilsons_interval(count, total):
    values = (np.arange(total) < count).astype(float)
    expected = stats.binomtest(count, total).proportion_ci(CONFIDENCE, method="wilson")
    found = estimate(values, share)
    assert (found.value, found.count) == (count / total, total)
    assert (found.low, found.high) == pytest.approx((expected.low, expected.high), abs=1e-12)


def test_five_hundred_of_five_hundred_are_not_certain():
    assert 0.98 < estimate(np.ones(500), share).low < 0.995
    assert 0.98 < estimate(np.ones((5, 500)), share).low < 0.995


@pytest.mark.parametrize("truth", [0.98, 0.99, 0.5])
def test_the_interval_of_a_share_covers_it(truth):
    random = np.random.default_rng(1)
    ends = [share_ends(count / 200, 200) for count in random.binomial(200, truth, size=3000)]
    covered = np.mean([low <= truth <= high for low, high in ends])
    assert 0.93 <= covered <= 0.985


@pytest.mark.parametrize("dependence", [0.0, 1.0])
def test_the_interval_of_several_seeds_covers_the_share(dependence):
    """Seeds that fail in episodes of their own, and seeds that all fail in the same episodes."""
    random, covered, trials = np.random.default_rng(2), 0, 100
    for _ in range(trials):
        common, own = random.random((1, 150)), random.random((3, 150))
        found = estimate((np.where(dependence > 0.5, common, own) < 0.985).astype(float) * np.ones((3, 1)), share)
        covered += found.low <= 0.985 <= found.high
    assert covered >= 0.9 * trials


@pytest.mark.parametrize(("first", "second", "low", "high"), [(0.99, 0.99, 0.93, 1.0), (0.99, 0.95, 0.92, 0.99)])
def test_the_interval_of_a_paired_difference_covers_it(first, second, low, high):
    random, covered = np.random.default_rng(3), 0
    for _ in range(150):
        luck = random.random(200)  # the failures of the better one are failures of the other too
        found = paired_difference((luck < first).astype(float), (luck < second).astype(float), share)
        covered += found.low <= first - second <= found.high
    assert low <= covered / 150 <= high


def test_a_paired_difference_by_hand():
    """Bonett and Price: of 20 pairs, 4 are for the first alone and 1 for the second alone."""
    first = np.array([1.0] * 14 + [0.0] * 6)
    second = np.array([1.0] * 10 + [0.0] * 9 + [1.0])
    found = paired_difference(first, second, share)
    middle, half = (5 - 2) / 22, 1.959964 * np.sqrt((7 / 22 - (3 / 22) ** 2) / 22)
    assert found.value == pytest.approx(3 / 20)
    assert (found.low, found.high) == pytest.approx((middle - half, middle + half), rel=1e-6)


def test_two_that_never_fail_are_not_told_apart_and_not_equal_for_sure():
    found = paired_difference(np.ones(200), np.ones(200), share)
    assert found.value == 0.0 and -0.02 < found.low < -0.005 and found.high == -found.low
    assert not found.excludes_zero
    sure = paired_difference(np.ones((2, 100)), np.zeros((3, 100)), share)
    assert sure.value == sure.high == 1.0 and 0.9 < sure.low < 1.0


def test_a_share_of_time_keeps_the_bootstraps_width_and_has_one_at_the_end():
    values = np.clip(np.random.default_rng(4).normal(0.8, 0.05, 400), 0.0, 1.0)
    found, plain = estimate(values, share), estimate(values)
    assert found.value == plain.value
    assert (found.high - found.low) == pytest.approx(plain.high - plain.low, rel=0.05)
    assert estimate(np.ones(400), share).low < 1.0


@pytest.mark.parametrize("count", [1, 3, 30])
def test_equal_shares_of_time_leave_room(count):
    found = estimate(np.full(count, 0.9), share)
    assert (found.low, found.high) == pytest.approx(share_ends(0.9, count))


def test_the_ends_of_a_difference_of_independent_shares():
    """Two equal shares have an interval about zero, wider than that of either share by the root of two."""
    low, high = newcombe_ends(0.9, 0.9, 50)
    ends = share_ends(0.9, 50)
    assert low == pytest.approx(-high) and high == pytest.approx(np.hypot(ends[1] - 0.9, 0.9 - ends[0]))
