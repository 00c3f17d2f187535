"""Draws of random faults, and a test of their shares."""

import numpy as np
from scipy import stats

from ftac_gym.faults import FaultDistribution, FaultKind

COUNT = 6000
LIMITS = np.array([0.1, 0.2, 0.3, 0.4])


def draw_all(source, count=COUNT, limits=LIMITS, seed=0):
    uniform = np.random.default_rng(seed).random((count, source.uniform_count(len(limits))))
    switching = np.random.default_rng(seed + 1).random((count, source.switching_count))
    return source.draw(uniform, switching, limits)


def draw(source, count=COUNT, limits=LIMITS, seed=0):
    return draw_all(source, count, limits, seed).wheels


def only(*kinds, **fields):
    return FaultDistribution(kinds=kinds, **fields)


def faulty_rows(table):
    return table[table["kind"] != FaultKind.NONE]


def assert_shares(observed, expected):
    expected = np.asarray(expected, dtype=float)
    assert stats.chisquare(observed, expected / expected.sum() * np.sum(observed)).pvalue > 1e-3
