"""Tests of `ftac_gym.utils.randomness`: known answers, distributions, and independence of what was asked for."""

import numpy as np
import pytest
from scipy import stats

from ftac_gym.utils.randomness import Stream, keys_from_seeds, normal_pair, philox, uniforms

KNOWN_ANSWERS = [  # Random123 1.14, tests/kat_vectors, "philox4x32 10"
    (
        (0, 0, 0, 0),
        (0, 0),
        (0x6627E8D5, 0xE169C58D, 0xBC57AC4C, 0x9B00DBD8),
    ),
    (
        (0xFFFFFFFF, 0xFFFFFFFF, 0xFFFFFFFF, 0xFFFFFFFF),
        (0xFFFFFFFF, 0xFFFFFFFF),
        (0x408F276D, 0x41C83B0E, 0xA20BC7C6, 0x6D5451FD),
    ),
    (
        (0x243F6A88, 0x85A308D3, 0x13198A2E, 0x03707344),
        (0xA4093822, 0x299F31D0),
        (0xD16CFE09, 0x94FDCCEB, 0x5001E420, 0x24126EA1),
    ),
]


def deviates(seed=0, episodes=1000, purpose=Stream.FAULTS, count=8):
    keys = np.repeat(keys_from_seeds([seed]), episodes, axis=0)
    return uniforms(keys, np.arange(episodes), purpose, count)


def assert_uncorrelated(a, b):
    correlation = np.corrcoef(a.ravel(), b.ravel())[0, 1]
    assert abs(correlation) < 5.0 / np.sqrt(a.size)


# ------------------------------------------------------------------------------------------------------- the cipher


@pytest.mark.parametrize(("counter", "key", "expected"), KNOWN_ANSWERS)
def test_philox_gives_the_known_answers_of_random123(counter, key, expected):
    assert tuple(int(word) for word in philox(*counter, *key)) == expected


def test_philox_accepts_numpy_words():
    counter, key, expected = KNOWN_ANSWERS[2]
    assert tuple(int(word) for word in philox(*np.array(counter, np.uint32), *np.array(key, np.uint32))) == expected


# --------------------------------------------------------------------------------------------------------- uniforms


def test_uniforms_are_uniform_in_the_unit_interval():
    numbers = deviates(episodes=5000)
    assert numbers.shape == (5000, 8)
    assert numbers.min() >= 0.0 and numbers.max() < 1.0
    assert stats.kstest(numbers.ravel(), "uniform").pvalue > 1e-3
    for column in numbers.T:
        assert stats.kstest(column, "uniform").pvalue > 1e-3


def test_low_bits_of_uniforms_are_random_too():
    fraction = np.modf(deviates(episodes=5000).ravel() * 2.0**40)[0]
    assert stats.kstest(fraction, "uniform").pvalue > 1e-3


@pytest.mark.parametrize("count", [1, 2, 5, 8])
def test_a_number_does_not_depend_on_how_many_are_asked_for(count):
    np.testing.assert_array_equal(deviates(count=count), deviates(count=9)[:, :count])


def test_a_number_does_not_depend_on_the_other_episodes_or_their_order():
    keys, episodes = keys_from_seeds([3, 4, 5]), np.array([10, 0, 7])
    together = uniforms(keys, episodes, Stream.INERTIA, 6)
    for row in (2, 0, 1):
        alone = uniforms(keys[row : row + 1], episodes[row : row + 1], Stream.INERTIA, 6)
        np.testing.assert_array_equal(alone[0], together[row])


def test_numbers_differ_between_seeds_episodes_purposes_and_positions():
    streams = [deviates(seed, 50, purpose, 8) for seed in (0, 1, 2**40) for purpose in Stream]
    everything = np.concatenate([stream.ravel() for stream in streams])
    assert len(np.unique(everything)) == everything.size


@pytest.mark.parametrize("purpose", [purpose for purpose in Stream if purpose is not Stream.FAULTS])
def test_purposes_are_independent(purpose):
    assert_uncorrelated(deviates(episodes=5000), deviates(episodes=5000, purpose=purpose))


def test_episodes_seeds_and_positions_are_independent():
    numbers = deviates(episodes=5000)
    assert_uncorrelated(numbers[1:], numbers[:-1])
    assert_uncorrelated(numbers[:, 1:], numbers[:, :-1])
    assert_uncorrelated(numbers, deviates(seed=1, episodes=5000))


def test_pairs_of_neighbouring_numbers_fill_the_square():
    numbers = deviates(episodes=10_000, count=2)
    counts = np.histogram2d(numbers[:, 0], numbers[:, 1], bins=10, range=[[0, 1], [0, 1]])[0]
    assert stats.chisquare(counts.ravel()).pvalue > 1e-3


def test_numbers_stay_what_they_were_when_episode_lists_were_frozen():
    numbers = uniforms(keys_from_seeds([0]), np.array([3]), Stream.FAULTS, 3)
    np.testing.assert_array_equal(numbers, [[0.4706930000445658, 0.21812443248614954, 0.47628000266377635]])


# ------------------------------------------------------------------------------------------------------------- keys


def test_keys_are_reproducible_and_distinct():
    keys = keys_from_seeds(range(2000))
    assert keys.shape == (2000, 2) and keys.dtype == np.uint32
    np.testing.assert_array_equal(keys[100:102], keys_from_seeds([100, 101]))
    assert len(np.unique(keys, axis=0)) == 2000


def test_keys_accept_seeds_of_any_size():
    assert len(np.unique(keys_from_seeds([0, 2**31, 2**32, 2**64, 2**200]), axis=0)) == 5


def test_no_seeds_make_no_keys():
    assert keys_from_seeds([]).shape == (0, 2)


def test_negative_seed_is_refused():
    with pytest.raises(ValueError, match="non-negative"):
        keys_from_seeds([3, -1])


# ---------------------------------------------------------------------------------------------------------- normals


def test_normal_pairs_are_standard_normal_and_independent():
    words = np.random.default_rng(0).integers(0, 2**32, size=(20_000, 2), dtype=np.uint64)
    pairs = np.array([normal_pair(a, b) for a, b in words])
    for column in pairs.T:
        assert stats.kstest(column, "norm").pvalue > 1e-3
    assert_uncorrelated(pairs[:, 0], pairs[:, 1])
    assert_uncorrelated(pairs[:, 0] ** 2, pairs[:, 1] ** 2)


@pytest.mark.parametrize("first", [0, 2**32 - 1])
@pytest.mark.parametrize("second", [0, 2**32 - 1])
def test_normal_pairs_are_finite_for_the_extreme_words(first, second):
    assert np.isfinite(normal_pair(np.uint64(first), np.uint64(second))).all()
