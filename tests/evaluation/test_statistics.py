"""Estimates and their intervals, on data of known truth."""

import numpy as np
import pytest
from scipy import stats

from ftac_gym.evaluation import estimate, interquartile_mean, paired_difference
from ftac_gym.evaluation.statistics import mean


@pytest.mark.parametrize(
    ("statistic", "draw", "truth"),
    [
        (mean, lambda random, count: random.normal(3.0, 2.0, count), 3.0),
        (mean, lambda random, count: (random.random(count) < 0.7).astype(float), 0.7),
        (interquartile_mean, lambda random, count: random.normal(3.0, 2.0, count), 3.0),
    ],
    ids=["mean", "success", "interquartile mean"],
)
def test_interval_covers_the_truth_as_often_as_it_says(statistic, draw, truth):
    random, trials = np.random.default_rng(0), 150
    covered = 0
    for _ in range(trials):
        result = estimate(draw(random, 100), statistic)
        assert result.low <= result.value <= result.high
        covered += result.low <= truth <= result.high
    # 95 % nominal; the percentile bootstrap is a little short. Chance alone stays within these bounds.
    assert 0.88 <= covered / trials <= 0.995


def test_interval_of_the_mean_is_that_of_the_central_limit_theorem():
    values = np.random.default_rng(1).normal(size=1000)
    result = estimate(values)
    half_width = 1.96 * values.std() / np.sqrt(1000)
    assert result.value == pytest.approx(values.mean()) and result.count == 1000
    assert (result.high - result.low) / 2.0 == pytest.approx(half_width, rel=0.08)


def test_interval_shrinks_with_the_number_of_episodes():
    values = np.random.default_rng(2).normal(size=1600)
    small, large = estimate(values[:100]), estimate(values)
    assert (small.high - small.low) / (large.high - large.low) == pytest.approx(4.0, rel=0.25)


def test_interquartile_mean():
    assert interquartile_mean(np.array([1e9, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, -1e9])) == pytest.approx(4.5)
    values = np.random.default_rng(0).normal(size=(5, 40))
    np.testing.assert_allclose(interquartile_mean(values, axis=1), [stats.trim_mean(row, 0.25) for row in values])


def test_missing_values_are_left_out():
    values = np.random.default_rng(3).normal(size=50)
    holes = np.insert(values, [0, 10, 50], np.nan)
    assert estimate(holes) == estimate(values)
    assert estimate(holes).count == 50


def test_no_values():
    for empty in (np.array([]), np.full(3, np.nan)):
        result = estimate(empty)
        assert result.count == 0 and np.isnan([result.value, result.low, result.high]).all()
        assert not result.excludes_zero


@pytest.mark.parametrize("values", [[4.0], [4.0, 4.0, 4.0]])
def test_values_without_spread(values):
    result = estimate(np.array(values))
    assert (result.value, result.low, result.high, result.count) == (4.0, 4.0, 4.0, len(values))


def test_reproducible_and_seeded():
    values = np.random.default_rng(4).normal(size=60)
    assert estimate(values, seed=1) == estimate(values, seed=1)
    assert estimate(values, seed=1).low != estimate(values, seed=2).low


def test_pairing_removes_what_the_two_have_in_common():
    random = np.random.default_rng(5)
    luck = random.normal(0.0, 10.0, 200)
    first, second = luck + random.normal(0.3, 0.5, 200), luck + random.normal(0.0, 0.5, 200)
    paired = paired_difference(first, second)
    apart = estimate(first), estimate(second)
    assert paired.excludes_zero and paired.low < 0.3 < paired.high
    assert apart[0].low < apart[1].value < apart[0].high  # alone they cannot be told apart
    assert (paired.high - paired.low) < 0.1 * (apart[0].high - apart[0].low)


def test_paired_difference_covers_the_truth():
    random, covered = np.random.default_rng(6), 0
    for _ in range(100):
        luck = random.exponential(5.0, 80)
        result = paired_difference(luck + random.normal(1.0, 1.0, 80), luck)
        covered += result.low <= 1.0 <= result.high
    assert 0.87 <= covered / 100 <= 1.0


def test_paired_difference_needs_both():
    first, second = np.array([1.0, np.nan, 3.0, 5.0]), np.array([0.5, 1.0, np.nan, 4.0])
    result = paired_difference(first, second)
    assert result.count == 2 and result.value == pytest.approx(0.75)
    assert paired_difference(second, first).value == pytest.approx(-0.75)


def test_paired_difference_of_different_episodes():
    with pytest.raises(ValueError, match="episodes must be the same 3 for both, got 4"):
        paired_difference(np.zeros(3), np.zeros(4))


@pytest.mark.parametrize(("shift", "excludes"), [(5.0, True), (-5.0, True), (0.0, False)])
def test_excludes_zero(shift, excludes):
    values = np.random.default_rng(7).normal(size=100)
    assert estimate(values - values.mean() + shift).excludes_zero is excludes
