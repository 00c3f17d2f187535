"""Censored times, shares and rates against closed forms, hand cases and their coverage."""

import numpy as np
import pytest

from ftac_gym.evaluation.intervals import rate_of_count, share_of_count, survival


def test_without_censoring_it_is_the_empirical_distribution():
    found = survival([1.0, 2.0, 3.0, 4.0], [True] * 4)
    assert found.median.value == 2.0 and (found.median.defined, found.median.total) == (4, 4)
    assert [found.within(limit).value for limit in (0.5, 1.0, 2.5, 4.0)] == [0.0, 0.25, 0.5, 1.0]


def test_a_product_of_conditional_shares():
    # At 1 s one of five, at 3 s one of the three that are left: 4/5, then 4/5 * 2/3; at 5 s the last one.
    found = survival([1.0, 2.0, 3.0, 4.0, 5.0], [True, False, True, False, True])
    np.testing.assert_allclose(found.share, [1.0, 0.8, 0.8, 0.8 * 2 / 3, 0.8 * 2 / 3, 0.0], atol=1e-15)
    assert found.median.value == 5.0 and (found.median.defined, found.median.total) == (3, 5)


def test_a_median_that_is_not_reached_is_infinite():
    found = survival([1.0, 10.0, 10.0, 10.0], [True, False, False, False])
    assert found.median.value == np.inf == found.median.high
    assert found.within(10.0).value == pytest.approx(0.25)
    assert survival([3.0, 4.0], [False, False]).median.value == np.inf
    assert np.isnan(survival([], []).median.value) and np.isnan(survival([], []).within(1.0).value)


def test_the_interval_of_a_median_covers():
    random, truth, hits = np.random.default_rng(0), np.log(2.0), 0
    for _ in range(200):
        event, end = random.exponential(1.0, 60), random.uniform(0.0, 4.0, 60)
        estimate = survival(np.minimum(event, end), event <= end).median
        hits += estimate.low <= truth <= estimate.high
    assert 182 <= hits <= 199  # 0.95 +- 3.5 standard deviations


@pytest.mark.parametrize("count", [1, 2, 3, 5])
def test_intervals_of_few_times_cover_too(count):
    random, median, within = np.random.default_rng(0), 0, 0
    for _ in range(200):
        event, end = random.exponential(1.0, count), random.uniform(0.0, 3.0, count)
        found = survival(np.minimum(event, end), event <= end)
        median += found.median.low <= np.log(2.0) <= found.median.high
        share = found.within(0.5)
        within += share.low <= 1.0 - np.exp(-0.5) <= share.high
    # The approximations of small samples cover 0.9 of the time.
    assert median >= 172 and within >= 172


def test_times_that_are_all_alike_leave_room():
    late, censored = survival([20.0] * 3, [True] * 3), survival([1.0, 2.0], [False, False])
    assert late.within(10.0).value == late.within(10.0).low == 0.0
    assert late.within(10.0).high == pytest.approx(share_of_count(0, 3).high)
    assert late.within(20.0).low == pytest.approx(share_of_count(3, 3).low)
    assert (censored.median.low, censored.median.value, censored.median.high) == (0.0, np.inf, np.inf)


def test_shares_have_width_at_their_ends():
    none, all_of_them = share_of_count(0, 20), share_of_count(20, 20)
    assert none.value == none.low == 0.0 and none.high == pytest.approx(3.8415 / (20 + 3.8415), rel=1e-4)
    assert all_of_them.low == pytest.approx(1.0 - none.high)
    assert np.isnan(share_of_count(0, 0).value)


def test_no_event_leaves_three_over_the_time():
    rate = rate_of_count(0, 10.0)
    assert (rate.value, rate.low) == (0.0, 0.0) and rate.high == pytest.approx(-np.log(0.025) / 10.0)
    # Garwood's table for ten events.
    rate = rate_of_count(10, 2.0)
    assert (rate.value, rate.count) == (5.0, 10)
    assert (rate.low * 2.0, rate.high * 2.0) == pytest.approx((4.795, 18.390), abs=1e-3)
    assert np.isnan(rate_of_count(0, 0.0).value)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: survival([1.0, -1.0], [True, True]), "times must be finite and not negative"),
        (lambda: survival([1.0, np.nan], [True, True]), "times must be finite and not negative"),
        (lambda: survival([1.0], [True, True]), r"observed must have shape \(1,\), got \(2,\)"),
        (lambda: share_of_count(3, 2), r"count must be within \[0, 2\], got 3"),
        (lambda: share_of_count("3", 2), "count must be a whole number, 0 or more, got '3'"),
        (lambda: rate_of_count(1, -1.0), "exposure must not be negative"),
        (lambda: survival([1.0], [True]).within(-1.0), "limit must not be negative, got -1.0"),
    ],
)
def test_wrong_input_is_named(call, message):
    with pytest.raises(ValueError, match=message):
        call()
