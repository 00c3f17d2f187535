"""Random faults: shares of healthy episodes, kinds and wheels, and the ranges of timing and magnitudes."""

import numpy as np
import pytest
from scipy import stats

from ftac_gym.faults import (
    Bias,
    FaultDistribution,
    FaultKind,
    HardOver,
    LockInPlace,
    LossOfEffectiveness,
    Outage,
)
from ftac_gym.faults.table import no_faults

COUNT = 6000
LIMITS = np.array([0.1, 0.2, 0.3, 0.4])


def draw(source, count=COUNT, limits=LIMITS, seed=0):
    uniform = np.random.default_rng(seed).random((count, source.uniform_count(len(limits))))
    switching = np.random.default_rng(seed + 1).random((count, source.switching_count))
    return source.draw(uniform, switching, limits).wheels


def only(*kinds, **fields):
    return FaultDistribution(kinds=kinds, **fields)


def struck_rows(table):
    return table[table["kind"] != FaultKind.NONE]


def assert_shares(observed, expected):
    expected = np.asarray(expected, dtype=float)
    assert stats.chisquare(observed, expected / expected.sum() * np.sum(observed)).pvalue > 1e-3


# --------------------------------------------------------------------------------------------------- who is struck


def test_number_of_faults_has_the_given_shares():
    table = draw(only(Outage(), fault_counts=(1.0, 5.0, 3.0, 1.0)))
    assert table.shape == (COUNT, 4, 1)
    faulty = (table["kind"][:, :, 0] != FaultKind.NONE).sum(axis=1)
    assert_shares(np.bincount(faulty, minlength=4), (1.0, 5.0, 3.0, 1.0))


def test_every_wheel_and_every_pair_is_equally_likely():
    single = draw(only(Outage()))["kind"][:, :, 0] != FaultKind.NONE
    assert_shares(single.sum(axis=0), np.ones(4))
    double = draw(only(Outage(), fault_counts=(0.0, 0.0, 1.0)))["kind"][:, :, 0] != FaultKind.NONE
    pairs = double @ (1 << np.arange(4))
    assert_shares(np.unique(pairs, return_counts=True)[1], np.ones(6))


def test_kinds_have_the_given_weights():
    table = draw(only(Bias(), Outage(), LockInPlace(), weights=(1.0, 0.0, 3.0)))
    kinds = struck_rows(table)["kind"]
    assert len(kinds) == COUNT
    assert_shares([np.sum(kinds == FaultKind.BIAS), np.sum(kinds == FaultKind.LOCK_IN_PLACE)], (1.0, 3.0))
    assert not np.any(kinds == FaultKind.OUTAGE)


def test_kinds_are_equally_likely_without_weights():
    kinds = struck_rows(draw(only(Bias(), Outage(), LockInPlace(), HardOver())))["kind"]
    assert_shares(np.unique(kinds, return_counts=True)[1], np.ones(4))


def test_two_faults_of_one_episode_are_drawn_independently():
    table = draw(only(Bias(onset=(0.0, 10.0)), Outage(onset=(0.0, 10.0)), fault_counts=(0.0, 0.0, 1.0)))
    onset = table["onset"][:, :, 0]
    first, second = onset[np.isfinite(onset)].reshape(-1, 2).T
    assert abs(np.corrcoef(first, second)[0, 1]) < 0.07
    kinds = table["kind"][:, :, 0]
    same = np.array([len(set(row[row > 0])) == 1 for row in kinds])
    assert_shares([same.sum(), (~same).sum()], (1.0, 1.0))


def test_healthy_wheels_keep_the_healthy_record():
    table = draw(only(Bias(onset=1.0, constant=0.05)))
    healthy = table[table["kind"] == FaultKind.NONE]
    assert np.all(healthy == no_faults(1, 1)[0, 0, 0])


def test_episodes_do_not_depend_on_how_many_are_drawn():
    source = only(Bias(constant=(0.0, 0.1)), HardOver(), fault_counts=(0.2, 0.4, 0.4))
    uniform = np.random.default_rng(1).random((50, source.uniform_count(4)))
    none = np.zeros((50, 0))
    many, two = source.draw(uniform, none, LIMITS), source.draw(uniform[7:9], none[7:9], LIMITS)
    np.testing.assert_array_equal(many.wheels[7:9], two.wheels)


# ------------------------------------------------------------------------------------------------ when and how much


@pytest.mark.parametrize(
    ("fault", "expected"),
    [
        (
            Bias(onset=(2.0, 8.0), recovery=(9.0, 11.0), period=(3.0, 4.0), on_time=(1.0, 2.0)),
            {"onset": (2.0, 8.0), "recovery": (9.0, 11.0), "period": (3.0, 4.0), "on_time": (1.0, 2.0)},
        ),
        (
            LossOfEffectiveness(
                effectiveness=(0.3, 0.7), amplitude=(0.1, 0.3), frequency=(0.1, 2.0), phase=(-1.0, 1.0)
            ),
            {
                "effectiveness": (0.3, 0.7),
                "effectiveness_amplitude": (0.1, 0.3),
                "effectiveness_frequency": (0.1, 2.0),
                "effectiveness_phase": (-1.0, 1.0),
            },
        ),
        (
            Bias(
                constant=(0.01, 0.1),
                slope=(1e-4, 1e-3),
                amplitude=(0.2, 0.3),
                exponent=(0.0, 2.0),
                frequency=(0.5, 1.5),
                phase=(0.0, 3.0),
            ),
            {
                "bias": (0.01, 0.1),
                "bias_slope": (1e-4, 1e-3),
                "bias_amplitude": (0.2, 0.3),
                "bias_exponent": (0.0, 2.0),
                "bias_frequency": (0.5, 1.5),
                "bias_phase": (0.0, 3.0),
            },
        ),
    ],
)
def test_intervals_are_filled_uniformly_and_independently(fault, expected):
    rows = struck_rows(draw(only(fault)))
    assert np.all(rows["kind"] == fault.kind)
    for field, (low, high) in expected.items():
        assert stats.kstest(rows[field], "uniform", (low, high - low)).pvalue > 1e-3, field
    correlation = np.corrcoef([rows[field] for field in expected]) - np.eye(len(expected))
    assert np.abs(correlation).max() < 0.07


def test_faults_never_end_unless_told_so():
    assert np.all(np.isposinf(struck_rows(draw(only(Outage(onset=3.0))))["recovery"]))


def test_random_sign_turns_the_whole_bias():
    rows = struck_rows(draw(only(Bias(constant=0.02, slope=0.01, amplitude=0.5, random_sign=True))))
    sign = np.sign(rows["bias"])
    assert_shares([np.sum(sign > 0), np.sum(sign < 0)], (1.0, 1.0))
    np.testing.assert_allclose(rows["bias"], 0.02 * sign)
    np.testing.assert_allclose(rows["bias_slope"], 0.01 * sign)
    np.testing.assert_allclose(rows["bias_amplitude"], 0.5 * sign)


def test_without_random_sign_the_bias_keeps_its_own():
    assert np.all(struck_rows(draw(only(Bias(constant=-0.02))))["bias"] == -0.02)


def test_hard_over_is_a_fraction_of_the_struck_wheels_limit():
    table = draw(only(HardOver(fraction=(0.2, 0.5))))
    wheel = np.nonzero(table["kind"][:, :, 0])[1]
    rows = struck_rows(table)
    fraction = rows["bias"] / LIMITS[wheel]
    assert stats.kstest(np.abs(fraction), "uniform", (0.2, 0.3)).pvalue > 1e-3
    assert_shares([np.sum(fraction > 0), np.sum(fraction < 0)], (1.0, 1.0))
    assert np.all(rows["effectiveness"] == 0.0)
    signed = struck_rows(draw(only(HardOver(fraction=-0.5, random_sign=False)), limits=np.full(4, 0.2)))
    assert np.all(signed["bias"] == -0.1)
