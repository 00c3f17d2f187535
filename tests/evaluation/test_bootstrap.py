"""Statistics over training seeds and episodes, against plain loops over published formulas and on data of known truth.

The loops follow Agarwal et al. 2021 and their library rliable, with episodes as tasks and training seeds as runs. They
cover interquartile mean over all runs and tasks, stratified bootstrap, probability of improvement, performance profile.
"""

import random as plain_random
from statistics import fmean

import numpy as np
import pytest
from scipy import stats

from ftac_gym.evaluation import estimate, interquartile_mean, paired_difference
from ftac_gym.evaluation.bootstrap import RESAMPLES
from ftac_gym.evaluation.profiles import performance_profile
from ftac_gym.evaluation.statistics import (
    mean,
    probability_of_improvement,
    relative_difference,
)

HOLE = float("nan")
FIRST = np.array([[1.0, 4.0, 2.5, HOLE, 8.0, 0.5], [2.0, 3.0, 2.5, 7.0, 6.0, HOLE], [1.5, 9.0, HOLE, 5.0, 6.5, 0.25]])
SECOND = np.array([[1.5, 4.0, HOLE, 6.0, 7.0, 1.0], [2.0, HOLE, 3.5, 5.0, 6.0, 0.5]])


def known(rows):
    """All values of a list of rows, in one list."""
    return [value for row in rows for value in row if value == value]


def plain_interquartile_mean(rows):
    values = sorted(known(rows))
    cut = len(values) // 4
    return fmean(values[cut : len(values) - cut])


def plain_mean(rows):
    return fmean(known(rows))


def plain_improvement(first, second):
    """P(X > Y) + P(X = Y) / 2 of all pairs of runs, averaged over tasks."""
    tasks = []
    for task in range(len(first[0])):
        scores = []
        for run in first:
            for other in second:
                x, y = run[task], other[task]
                if x == x and y == y:
                    scores.append(1.0 if x > y else 0.5 if x == y else 0.0)
        if scores:
            tasks.append(fmean(scores))
    return fmean(tasks)


def plain_difference(first, second):
    """The mean of x - y over all pairs of runs of the same task."""
    pairs = [x - y for run in first for other in second for x, y in zip(run, other, strict=True) if x == x and y == y]
    return fmean(pairs)


def drawn_anew(rows, levels, tasks=None):
    """One resample by loops: runs within every task, or whole runs and the given tasks."""
    count = len(rows)
    if levels == "seeds":
        columns = [[rows[plain_random.randrange(count)][task] for _ in rows] for task in range(len(rows[0]))]
        return [list(row) for row in zip(*columns, strict=True)]
    runs = [plain_random.randrange(count) for _ in rows]
    return [[rows[run][task] for task in tasks] for run in runs]


def plain_interval(statistic, levels, *data, resamples=2500):
    plain_random.seed(1)
    count = len(data[0][0])
    values = []
    for _ in range(resamples):
        tasks = [plain_random.randrange(count) for _ in range(count)]
        values.append(statistic(*(drawn_anew(rows, levels, tasks) for rows in data)))
    values.sort()
    return values[int(0.025 * resamples)], values[int(0.975 * resamples)]


def test_point_estimates_are_those_of_plain_loops():
    assert estimate(FIRST).value == pytest.approx(plain_mean(FIRST))
    assert estimate(FIRST, interquartile_mean).value == pytest.approx(plain_interquartile_mean(FIRST))
    assert paired_difference(FIRST, SECOND).value == pytest.approx(plain_difference(FIRST, SECOND))
    assert probability_of_improvement(FIRST, SECOND).value == pytest.approx(plain_improvement(FIRST, SECOND))
    smaller = probability_of_improvement(FIRST, SECOND, smaller_is_better=True)
    assert smaller.value == pytest.approx(plain_improvement(SECOND, FIRST))
    thresholds = [0.0, 0.5, 2.5, 6.25, 9.0]
    above = [fmean([value > threshold for value in known(FIRST)]) for threshold in thresholds]
    profile = performance_profile(FIRST, thresholds)
    np.testing.assert_allclose(profile.y, above)
    np.testing.assert_array_equal(profile.x, thresholds)
    below = performance_profile(FIRST, thresholds, smaller_is_better=True)
    np.testing.assert_allclose(below.y, 1.0 - np.array(above))
    assert estimate(FIRST).count == profile.count == 6


@pytest.mark.parametrize("levels", ["seeds", "both"])
def test_intervals_are_those_of_plain_loops(levels):
    """rliable's stratified bootstrap, and that of rows and columns; within the scatter of 2500 resamples."""
    random = np.random.default_rng(8)
    luck = random.exponential(2.0, 14)
    first = luck + random.normal(0.4, 0.8, (4, 14)) + random.normal(0.0, 0.5, (4, 1))
    second = luck + random.normal(0.0, 0.8, (3, 14))
    plain = first.tolist(), second.tolist()
    profile = performance_profile(first, [2.0], levels=levels)
    found = [
        (estimate(first, mean, levels=levels), plain_mean, plain[:1]),
        (estimate(first, interquartile_mean, levels=levels), plain_interquartile_mean, plain[:1]),
        (paired_difference(first, second, levels=levels), plain_difference, plain),
        (probability_of_improvement(first, second, levels=levels), plain_improvement, plain),
    ]
    ends = [((item.low, item.high), plain_interval(statistic, levels, *data)) for item, statistic, data in found]
    share = plain_interval(lambda rows: fmean([value > 2.0 for value in known(rows)]), levels, plain[0])
    ends.append(((profile.low[0], profile.high[0]), share))
    for (low, high), (expected_low, expected_high) in ends:
        width = expected_high - expected_low
        assert low == pytest.approx(expected_low, abs=0.1 * width)
        assert high == pytest.approx(expected_high, abs=0.1 * width)


@pytest.mark.parametrize("statistic", [mean, interquartile_mean, np.median])
@pytest.mark.parametrize("size", [2, 7, 60, 501])
def test_a_single_run_has_the_interval_of_scipy(statistic, size):
    values = np.random.default_rng(9).gamma(3.0, 2.0, size)
    found = estimate(values, statistic, seed=3)
    ends = stats.bootstrap(
        (values,), statistic, n_resamples=RESAMPLES, method="percentile", rng=np.random.default_rng(3)
    ).confidence_interval
    assert (found.value, found.low, found.high) == (statistic(values), ends.low, ends.high)


def test_any_statistic_goes_over_seeds():
    known_values = known(FIRST.tolist())
    assert estimate(FIRST, np.median).value == np.median(known_values)
    assert estimate(FIRST, np.median).low >= min(known_values)


def seeds_on_episodes(random, seeds, episodes, shift=0.0):
    """Return scores to which seeds, episodes and chance contribute; their mean is the shift."""
    seed, episode = random.normal(0.0, 0.6, (seeds, 1)), random.normal(0.0, 1.0, episodes)
    return shift + seed + episode + random.normal(0.0, 0.5, (seeds, episodes))


def test_both_levels_cover_a_new_seed_on_new_episodes():
    random, trials = np.random.default_rng(10), 120
    covered = dict.fromkeys(("both", "seeds"), 0)
    for _ in range(trials):
        values = seeds_on_episodes(random, 8, 40)
        for levels in covered:
            result = estimate(values, levels=levels)
            covered[levels] += result.low <= 0.0 <= result.high
    # With eight seeds the bootstrap is slightly short of its nominal 95 %; seeds in fixed episodes vary much less.
    assert 0.85 <= covered["both"] / trials <= 0.99
    assert covered["seeds"] / trials < 0.5


def test_the_difference_covers_the_truth_and_pairs():
    random, covered = np.random.default_rng(11), 0
    for _ in range(100):
        luck = 5.0 * random.normal(size=60)
        first, second = (luck + random.normal(shift, 0.5, (seeds, 60)) for seeds, shift in ((5, 0.3), (1, 0.0)))
        result = paired_difference(first, second)
        covered += result.low <= 0.3 <= result.high
        assert result.high - result.low < 0.6  # luck alone has an interval of 2.5
    assert 0.88 <= covered / 100 <= 1.0


def test_a_single_run_is_judged_over_its_episodes():
    values, other = np.random.default_rng(12).normal(size=(2, 300))
    for statistic in (mean, interquartile_mean):
        assert estimate(values[None], statistic) == estimate(values, statistic)
        assert paired_difference(values[None], other, statistic) == estimate(values - other, statistic)
    fixed = estimate(values, levels="seeds")
    assert fixed.low == fixed.high == pytest.approx(fixed.value)  # there is no other run to draw


def test_the_difference_is_that_of_the_estimates_in_tables():
    random = np.random.default_rng(13)
    first, second = random.exponential(size=(5, 90)), random.exponential(size=(2, 90))
    for statistic in (mean, interquartile_mean):
        one, other = estimate(first, statistic).value, estimate(second, statistic).value
        share = relative_difference(first, second, statistic)
        assert share.value == pytest.approx(one / other - 1.0) and share.low < share.value < share.high
    assert paired_difference(first, second).value == pytest.approx(estimate(first).value - estimate(second).value)
    assert relative_difference(first, first).value == 0.0


def test_episodes_without_any_value_do_not_matter():
    random = np.random.default_rng(14)
    first, second = random.normal(size=(3, 20)), random.normal(size=(2, 20))
    first[0, 3] = second[1, 5] = HOLE
    holes = [np.insert(item, [0, 7, 20], HOLE, axis=1) for item in (first, second)]
    assert estimate(holes[0]) == estimate(first)
    assert paired_difference(*holes) == paired_difference(first, second)
    assert probability_of_improvement(*holes) == probability_of_improvement(first, second)
    assert paired_difference(*holes).count == 20
    # An episode that one of the two has no value in is none of the pair's.
    second[:, 0] = HOLE
    assert paired_difference(first, second).count == probability_of_improvement(first, second).count == 19
    without = paired_difference(first[:, 1:], second[:, 1:])
    assert paired_difference(first, second) == without


@pytest.mark.parametrize("empty", [np.array([]), np.full((3, 4), HOLE)])
def test_no_values_of_any_seed(empty):
    for result in (estimate(empty), paired_difference(empty, empty)):
        assert result.count == 0 and np.isnan([result.value, result.low, result.high]).all()
    assert np.isnan(probability_of_improvement(empty, empty).value)
    assert np.isnan(performance_profile(empty, [0.0, 1.0]).y).all()


def test_improvement_is_a_fair_comparison():
    random = np.random.default_rng(15)
    first, second = np.round(random.normal(size=(5, 50)), 1), np.round(random.normal(size=(3, 50)), 1)
    there, back = probability_of_improvement(first, second), probability_of_improvement(second, first)
    assert there.value + back.value == pytest.approx(1.0)
    assert there.low < 0.5 < there.high
    same = probability_of_improvement(first[0], first[0])
    assert (same.value, same.low, same.high) == (0.5, 0.5, 0.5)
    sure = probability_of_improvement(first + 10.0, second)
    assert (sure.value, sure.low, sure.high) == (1.0, 1.0, 1.0)
    assert probability_of_improvement(first + 10.0, second, smaller_is_better=True).high == 0.0


def test_a_profile_falls_from_one_to_nothing_in_its_band():
    values = seeds_on_episodes(np.random.default_rng(16), 5, 80)
    profile = performance_profile(values, np.linspace(-6.0, 6.0, 40))
    assert profile.y[0] == profile.low[0] == 1.0 and profile.y[-1] == profile.high[-1] == 0.0
    assert (np.diff(profile.y) <= 0.0).all()
    assert (profile.low <= profile.y).all() and (profile.y <= profile.high).all()
    assert (profile.high - profile.low).max() > 0.1


def test_resampling_is_seeded():
    random = np.random.default_rng(17)
    first, second = random.normal(size=(3, 30)), random.normal(size=(3, 30))
    for measure in (estimate, lambda *a, **k: paired_difference(*a, second, **k)):
        assert measure(first, seed=1) == measure(first, seed=1) != measure(first, seed=2)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: estimate(FIRST, levels="episodes"), "levels must be 'both' or 'seeds', got 'episodes'"),
        (lambda: estimate(FIRST[None]), r"values must have shape \(seeds, episodes\).* got \(1, 3, 6\)"),
        (lambda: paired_difference(FIRST, SECOND[:, 1:]), "episodes must be the same 6 for both, got 5"),
        (lambda: probability_of_improvement(FIRST, SECOND[:, 1:]), "episodes must be the same 6 for both, got 5"),
    ],
)
def test_bad_data_and_levels_are_refused(call, message):
    with pytest.raises(ValueError, match=message):
        call()
