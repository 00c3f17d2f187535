"""Faults that come and go at random: a two-state Markov chain, drawn with the episode."""

import numpy as np
import pytest
from scipy import stats

from ftac_gym import scenarios
from ftac_gym.faults import (
    AttitudeSpike,
    Bias,
    FaultDistribution,
    FaultSchedule,
    GyroBiasStep,
    IntermittentShutdown,
    LossOfEffectiveness,
    Outage,
    fault_effect,
)

FLAGSHIP = scenarios.get("flagship")
ACTING, RESTING = 3.0, 7.0  # s
CHAIN = {"mean_acting": ACTING, "mean_resting": RESTING}
COUNT = 2000


def drawn_from(*faults, count=COUNT, seed=0, **fields):
    source = FaultDistribution(faults, **fields) if fields else FaultSchedule(faults)
    return FLAGSHIP.replace(faults=source).draw(seed, count)


def effect_at(episodes, time):
    still = np.zeros((len(episodes), 4))
    moment = np.broadcast_to(np.asarray(time, dtype=float), (len(episodes),))
    return fault_effect(episodes.drawn_faults, moment, FLAGSHIP.spacecraft.wheels, still, still)


def holding_times(episodes, chain, onset):
    """Times that the fault stays acting (N, 32), and that it stays away (N, 32) [s]."""
    times = np.diff(episodes.switches[:, chain], axis=1, prepend=onset[:, None])
    return times[:, 0::2], times[:, 1::2]


@pytest.mark.parametrize("source", ["schedule", "distribution"])
def test_holding_times_are_exponential_with_the_given_means(source):
    if source == "schedule":
        episodes = drawn_from(Bias(wheel=1), Outage(wheel=2, onset=(2.0, 9.0), **CHAIN))
        onset, chain = episodes.faults["onset"][:, 2, 0], 1
    else:
        episodes = drawn_from(Outage(onset=(2.0, 9.0), **CHAIN), weights=(1.0,))
        onset, chain = episodes.faults["onset"].min(axis=(1, 2)), 0
    acting, resting = holding_times(episodes, chain, onset)
    for times, mean in ((acting, ACTING), (resting, RESTING)):
        assert times.min() >= 0.0
        assert stats.kstest(times.ravel(), "expon", (0.0, mean)).pvalue > 1e-3
        # No memory: neither from one stay to the next nor of the onset.
        assert abs(np.corrcoef(times[:, 1:].ravel(), times[:, :-1].ravel())[0, 1]) < 0.02
        assert abs(np.corrcoef(times[:, 0], onset)[0, 1]) < 0.1
    assert abs(np.corrcoef(acting.ravel(), resting.ravel())[0, 1]) < 0.02


def test_a_chain_starts_acting_and_decays_to_its_stationary_share():
    """The share of acting faults decays from one to the stationary share with the sum of the two rates."""
    episodes = drawn_from(Outage(wheel=0, onset=5.0, **CHAIN), count=6000)
    share, rate = ACTING / (ACTING + RESTING), 1.0 / ACTING + 1.0 / RESTING
    assert np.all(effect_at(episodes, 4.99).effectiveness == 1.0)
    assert np.all(effect_at(episodes, 5.0).effectiveness[:, 0] == 0.0)
    for since in (0.5, 2.0, 5.0, 20.0, 110.0):
        acting = np.mean(effect_at(episodes, 5.0 + since).effectiveness[:, 0] == 0.0)
        assert acting == pytest.approx(share + (1.0 - share) * np.exp(-rate * since), abs=0.025)


def test_it_flips_exactly_at_the_drawn_times():
    episodes = drawn_from(IntermittentShutdown(wheel=3, onset=1.0), count=200)
    for flip in range(6):
        moment = episodes.switches[:, 0, flip]
        before, after = (effect_at(episodes, moment + shift).effectiveness[:, 3] for shift in (-1e-6, 1e-6))
        # Two flips can lie closer together than this test can tell.
        apart = np.abs(np.diff(episodes.switches[:, 0, : flip + 2], axis=1)).min(axis=1) > 1e-5
        assert apart.mean() > 0.99
        assert np.all(before[apart] == flip % 2) and np.all(after[apart] == 1 - flip % 2)


def test_nothing_acts_after_the_recovery():
    episodes = drawn_from(Outage(wheel=0, onset=5.0, duration=(2.0, 10.0), **CHAIN), count=500)
    end = episodes.faults["recovery"][:, 0, 0]
    assert 0.2 < np.mean(effect_at(episodes, end - 1e-6).effectiveness[:, 0] == 0.0) < 0.8
    for later in (end, end + 1.0, 119.0):
        assert np.all(effect_at(episodes, later).effectiveness == 1.0)


def test_chains_of_one_episode_are_independent_of_each_other_and_of_steady_faults():
    episodes = drawn_from(
        Outage(wheel=0, **CHAIN),
        Bias(wheel=0, constant=0.1, **CHAIN),
        LossOfEffectiveness(wheel=1, effectiveness=0.5),
        Outage(wheel=2, **CHAIN),
        GyroBiasStep(size=1e-3, **CHAIN),
        AttitudeSpike(angle=0.1, mean_acting=1.0, mean_resting=30.0),
    )
    first, second = holding_times(episodes, 0, np.zeros(COUNT))[0], holding_times(episodes, 1, np.zeros(COUNT))[0]
    assert abs(np.corrcoef(first.ravel(), second.ravel())[0, 1]) < 0.02
    columns = []
    for time in (40.0, 80.0):
        effect = effect_at(episodes, time)
        assert np.all(effect.effectiveness[:, [1, 3]] == [0.5, 1.0])
        columns += [effect.effectiveness[:, 0] == 0.0, effect.bias[:, 0] > 0.0, effect.effectiveness[:, 2] == 0.0]
        columns += [np.linalg.norm(effect.rate_bias, axis=1) > 0.0]
        rare = np.linalg.norm(effect.attitude_turn, axis=1) > 0.0
        assert rare.mean() == pytest.approx(1.0 / 31.0, abs=0.015)
    for column in columns:
        assert np.mean(column) == pytest.approx(0.3, abs=0.04)
    assert np.abs(np.corrcoef(columns) - np.eye(8)).max() < 0.1


def test_two_random_faults_of_one_episode_have_chains_of_their_own():
    episodes = drawn_from(
        Outage(**CHAIN), GyroBiasStep(size=1e-3, **CHAIN), weights=(1.0, 1.0), fault_counts=(0.0, 0.0, 1.0)
    )
    effect = effect_at(episodes, 60.0)
    off = (effect.effectiveness == 0.0).sum(axis=1)
    shaken = np.array([np.linalg.norm(row) > 0.0 for row in effect.rate_bias])
    both = (episodes.faults["kind"] > 0).any(axis=(1, 2)) & (episodes.sensor_faults["kind"] > 0).any(axis=1)
    assert 0.4 < both.mean() < 0.6
    assert off[both].mean() == pytest.approx(0.3, abs=0.05) and shaken[both].mean() == pytest.approx(0.3, abs=0.05)
    assert np.mean(off[both] & shaken[both]) == pytest.approx(0.09, abs=0.03)
    two = (episodes.faults["kind"] > 0).sum(axis=(1, 2)) == 2
    assert np.bincount(off[two], minlength=3) / two.sum() == pytest.approx([0.49, 0.42, 0.09], abs=0.06)


def test_the_chain_of_a_seed_is_the_same_in_any_batch():
    fault = Outage(wheel=0, onset=(0.0, 9.0), **CHAIN)
    many, few = drawn_from(fault, count=50), drawn_from(fault, count=3)
    np.testing.assert_array_equal(many.switches[:3], few.switches)
    assert many[:3].digest() == few.digest()
    other = drawn_from(fault, count=50, seed=1)
    flips = np.concatenate([many.switches, other.switches])
    assert len(np.unique(flips)) == flips.size


def test_a_chain_changes_no_other_number():
    plain = drawn_from(Outage(onset=(0.0, 9.0)), Bias(constant=(0.0, 0.1)), weights=(1.0, 2.0), count=50)
    switching = drawn_from(Outage(onset=(0.0, 9.0), **CHAIN), Bias(constant=(0.0, 0.1)), weights=(1.0, 2.0), count=50)
    for name in ("kind", "onset", "recovery", "bias", "effectiveness"):
        np.testing.assert_array_equal(plain.faults[name], switching.faults[name])
    np.testing.assert_array_equal(plain.initial, switching.initial)
    assert plain.switches.shape == (50, 0, 64)
