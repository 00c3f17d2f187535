"""Counter-based random numbers: every number is a pure function of its address.

A generator with hidden state makes an episode depend on earlier draws. Here a number has an address instead:
``(seed, episode, stream, position)`` goes into the Philox4x32-10 block cipher (Salmon et al., "Parallel random numbers:
as easy as 1, 2, 3", SC 2011), whose output is the deviate. Hence episode ``k`` of seed ``s`` is the same on one
spacecraft or on a thousand, in any order and in any process. A batch is drawn in one compiled call.
"""

import math
from collections.abc import Iterable
from enum import IntEnum
from typing import Any

import numpy as np
import numpy.typing as npt
from numba import njit

from ftac_gym.utils.compiling import entry_point, merged

FloatArray = npt.NDArray[np.float64]
KeyArray = npt.NDArray[np.uint32]

_MULTIPLIER_0 = np.uint64(0xD2511F53)
_MULTIPLIER_1 = np.uint64(0xCD9E8D57)
_WEYL_0 = np.uint64(0x9E3779B9)
_WEYL_1 = np.uint64(0xBB67AE85)
_LOW_32 = np.uint64(0xFFFFFFFF)
_SHIFT_32 = np.uint64(32)
_SHIFT_5 = np.uint64(5)
_SHIFT_6 = np.uint64(6)
_TO_UNIT_32 = 2.0**-32
_TO_UNIT_53 = 2.0**-53


class Stream(IntEnum):
    """Streams of random numbers; those of different streams are independent."""

    INITIAL_STATE = 1
    INERTIA = 2
    FAULTS = 3
    DISTURBANCE = 4
    SENSORS = 5
    REFERENCE = 6
    NOISE = 7
    SWITCHING = 8
    MODES = 9
    DELAY = 10


_NOISE = int(Stream.NOISE)


def keys_from_seeds(seeds: Iterable[int]) -> KeyArray:
    """Turn user seeds into cipher keys.

    Parameters
    ----------
    seeds
        N non-negative integers of any size.

    Returns
    -------
    Array (N, 2) of 32-bit words, mixed by ``numpy.random.SeedSequence``.

    Raises
    ------
    ValueError
        If a seed is negative.
    """
    return np.array([np.random.SeedSequence(seed).generate_state(2) for seed in seeds], dtype=np.uint32).reshape(-1, 2)


@njit(inline="always")
def philox(c0: Any, c1: Any, c2: Any, c3: Any, k0: Any, k1: Any) -> Any:
    """Philox4x32-10: four 32-bit words (held in 64 bits) from a 128-bit counter and a 64-bit key."""
    c0, c1, c2, c3 = np.uint64(c0), np.uint64(c1), np.uint64(c2), np.uint64(c3)
    k0, k1 = np.uint64(k0), np.uint64(k1)
    for _ in range(10):
        product_0 = c0 * _MULTIPLIER_0
        product_1 = c2 * _MULTIPLIER_1
        c0 = (product_1 >> _SHIFT_32) ^ c1 ^ k0
        c1 = product_1 & _LOW_32
        c2 = (product_0 >> _SHIFT_32) ^ c3 ^ k1
        c3 = product_0 & _LOW_32
        k0 = (k0 + _WEYL_0) & _LOW_32
        k1 = (k1 + _WEYL_1) & _LOW_32
    return c0, c1, c2, c3


@njit(inline="always")
def normal_pair(word_0: Any, word_1: Any) -> Any:
    """Two independent standard normal deviates from two random words (Box and Muller)."""
    # The half makes the argument of the logarithm positive: deviates reach 6.7 standard deviations.
    radius = math.sqrt(-2.0 * math.log((word_0 + 0.5) * _TO_UNIT_32))
    turn = word_1 * _TO_UNIT_32
    sine = math.sin(2.0 * math.pi * turn)
    # The cosine from the sine costs a square root instead of a second transcendental function, and no branch.
    cosine = math.copysign(math.sqrt(max(1.0 - sine * sine, 0.0)), abs(turn - 0.5) - 0.25)
    return radius * cosine, radius * sine


@merged
def normals(tick: int, episode: int, block: int, key: Any) -> Any:
    """Return four standard normal deviates of the sensors' noise at a tick of an episode; its key has two words."""
    a, b, c, d = philox(tick, episode, _NOISE, block, key[0], key[1])
    return normal_pair(a, b) + normal_pair(c, d)


@entry_point(contract=False)
def _fill_uniforms(keys: Any, episodes: Any, stream: int, out: Any) -> None:
    for i in range(out.shape[0]):
        for block in range((out.shape[1] + 1) // 2):
            a, b, c, d = philox(block, episodes[i], stream, 0, keys[i, 0], keys[i, 1])
            out[i, 2 * block] = ((a >> _SHIFT_5) * 67108864.0 + (b >> _SHIFT_6)) * _TO_UNIT_53
            if 2 * block + 1 < out.shape[1]:
                out[i, 2 * block + 1] = ((c >> _SHIFT_5) * 67108864.0 + (d >> _SHIFT_6)) * _TO_UNIT_53


def uniforms(keys: KeyArray, episodes: npt.NDArray[np.int64], stream: Stream, count: int) -> FloatArray:
    """Draw ``count`` uniform deviates in [0, 1) for each of N episodes.

    Parameters
    ----------
    keys
        (N, 2) cipher keys of the episodes' seeds.
    episodes
        (N,) episode numbers.
    stream
        Stream of the numbers.
    count
        Number of deviates for each episode.

    Returns
    -------
    Array (N, count).
    """
    out = np.empty((len(episodes), count))
    _fill_uniforms(keys, np.ascontiguousarray(episodes), int(stream), out)
    return out
