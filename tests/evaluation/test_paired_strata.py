"""Paired differences of policies with unequal numbers of training seeds, against closed forms."""

import numpy as np
import pytest

from ftac_gym.evaluation import paired_difference


def test_each_value_counts_as_often_as_it_has_partners():
    """In an episode with s known seeds of the first and t of the second, a value of the first is in t pairs."""
    random = np.random.default_rng(20)
    first, second = random.normal(3.0, 1.0, (5, 7)), random.normal(0.0, 1.0, (3, 7))
    first[0:4, 1] = first[0:3, 4] = second[0:2, 2] = second[1, 4] = np.nan
    known, partners = (np.count_nonzero(~np.isnan(item), axis=0) for item in (first, second))
    assert not np.array_equal(known, partners)
    total = (partners * np.nansum(first, axis=0) - known * np.nansum(second, axis=0)).sum()
    found = paired_difference(first, second)
    assert found.value == pytest.approx(total / (known * partners).sum(), rel=1e-12)
    assert (found.count, found.defined, found.total) == (7, (known * partners).sum(), 5 * 3 * 7)


@pytest.mark.parametrize("exchanged", [False, True])
@pytest.mark.parametrize("levels", ["seeds", "both"])
def test_the_variance_of_each_policy_is_divided_by_its_own_number_of_seeds(levels, exchanged):
    """The first has few seeds with a large spread: weights of the wrong policy make the interval too narrow.

    With ``"seeds"`` the seeds of every episode are a stratum of their own. With ``"both"`` a seed is drawn for all
    episodes, here with the same value in all of them.
    """
    random, episodes = np.random.default_rng(21), 30
    width = episodes if levels == "seeds" else 1
    few, many = (np.tile(random.normal(0.0, spread, (seeds, width)), episodes // width) for seeds, spread in
                 ((8, 4.0), (24, 1.0)))  # fmt: skip
    variances = [(item.var(axis=0) / len(item)).sum() / (episodes * width) for item in (few, many)]
    found = paired_difference(*((many, few) if exchanged else (few, many)), levels=levels)
    sign = -1.0 if exchanged else 1.0
    assert found.value == pytest.approx(sign * (few.mean() - many.mean()))
    assert (found.high - found.low) / 2.0 == pytest.approx(1.96 * np.sqrt(sum(variances)), rel=0.08)
