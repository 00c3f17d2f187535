"""Recoveries from faults against cases computed by hand."""

import numpy as np
import pytest
from helpers.histories import PERIOD, STEPS, errors, history, one
from hypothesis import given
from hypothesis import strategies as st

from ftac_gym.evaluation.metrics.recovery import first_return
from ftac_gym.faults import Bias, FaultKind, GyroBiasStep, LossOfEffectiveness, Outage

SLEW = [(0, 30.0), (20, 0.5)]


def found(pieces, onset=None, faults=None):
    """Return (onset, time, recovered, peak) of the faults that count, in the order of their onsets."""
    result = history(error=errors(pieces), onset=onset, faults=faults).recoveries()
    counted = result.counted[0]
    assert np.isnan(result.time[0, ~counted]).all() and not result.recovered[0, ~counted].any()
    arrays = (result.onset, result.time, result.recovered, result.peak)
    return [tuple(np.round(row, 9)) for row in np.transpose([array[0, counted] for array in arrays])]


def test_recovery_lasts_from_the_onset_to_the_end_of_the_excursion():
    assert found([*SLEW, (52, 7.0), (65, 0.2)], [5.0]) == [(5.0, 1.5, True, 7.0)]
    # A fault between two samples.
    assert found([*SLEW, (52, 7.0), (65, 0.2)], [5.04]) == [(5.04, 1.46, True, 7.0)]


@pytest.mark.parametrize("onset", np.arange(1, 30) * 0.1 + 2.0)
def test_rounding_does_not_lengthen_a_recovery(onset):
    """Some multiples of the control period, 3.3 s for example, have a difference that rounds upwards."""
    (place,) = np.flatnonzero(np.isclose(np.arange(STEPS + 1) * PERIOD, onset))
    time = history(error=errors([*SLEW, (place + 2, 7.0), (place + 30, 0.2)]), onset=[onset]).recoveries().time
    assert np.nanmax(time) == 3.0


def test_a_harmless_fault_takes_no_time_to_recover_from():
    assert found(SLEW, [5.0]) == [(5.0, 0.0, True, 0.5)]


def test_a_loss_of_the_target_for_less_than_a_second_is_no_excursion():
    assert found([*SLEW, (52, 7.0), (61, 0.2)], [5.0]) == [(5.0, 0.0, True, 7.0)]
    assert found([*SLEW, (52, 7.0), (62, 0.2)], [5.0]) == [(5.0, 1.2, True, 7.0)]


def test_a_return_for_less_than_a_second_is_none():
    # Back from 6.5 s to 7.4 s, which is too short, and from 8 s on.
    assert found([*SLEW, (52, 7.0), (65, 0.2), (74, 3.0), (80, 0.2)], [5.0]) == [(5.0, 3.0, True, 7.0)]
    assert found([*SLEW, (52, 7.0), (65, 0.2), (75, 3.0), (80, 0.2)], [5.0]) == [(5.0, 1.5, True, 7.0)]


def test_a_recovery_that_is_not_seen_is_censored_at_the_end():
    assert found([(0, 0.5), (60, 7.0)], [5.0]) == [(5.0, 5.0, False, 7.0)]
    # On target for less than a second at the end.
    assert found([(0, 0.5), (60, 7.0), (95, 0.5)], [5.0]) == [(5.0, 5.0, False, 7.0)]


def test_a_later_fault_neither_shortens_nor_lengthens_a_recovery():
    early = Bias(wheel=0, onset=3.0)
    disaster = Outage(wheel=1, onset=6.0)
    # Recovered before the disaster, and lost for good after it.
    lost = [*SLEW, (31, 4.0), (45, 0.5), (61, 90.0)]
    assert found(lost, faults=[early, disaster]) == [(3.0, 1.5, True, 4.0), (6.0, 4.0, False, 90.0)]
    # Not recovered before it: censored there, and the disaster does not count.
    late = [*SLEW, (31, 4.0), (70, 0.5)]
    assert found(late, faults=[disaster, early]) == [(3.0, 3.0, False, 4.0)]


def test_the_end_of_another_fault_ends_the_view_and_that_of_the_fault_itself_does_not():
    pieces = [*SLEW, (45, 4.0), (75, 0.5)]
    passing = LossOfEffectiveness(wheel=1, onset=0.5, effectiveness=0.5, recovery=6.0)
    lasting = Bias(wheel=0, onset=4.0)
    assert found(pieces, faults=[passing, lasting]) == [(4.0, 2.0, False, 4.0)]
    own = Bias(wheel=0, onset=4.0, recovery=6.0)
    assert found(pieces, faults=[own]) == [(4.0, 3.5, True, 4.0)]


def test_faults_of_sensors_count_and_two_at_once_are_one():
    faults = [GyroBiasStep(onset=5.0), Bias(wheel=0, onset=5.0), Bias(wheel=2, onset=5.0)]
    result = history(error=errors([*SLEW, (52, 7.0), (65, 0.2)]), faults=faults).recoveries()
    assert result.counted.sum() == 1 and np.nansum(result.time) == pytest.approx(1.5)
    alone = history(error=errors(SLEW), faults=[GyroBiasStep(onset=5.0)]).recoveries()
    assert alone.kind[alone.counted].tolist() == [FaultKind.GYRO_BIAS_STEP]


@pytest.mark.parametrize(
    ("pieces", "onset"),
    [
        ([(0, 30.0), (60, 0.5)], [5.0]),  # during the slew
        ([(0, 0.5), (35, 3.0)], [5.0]),  # on target 1.5 s before
        ([(0, 0.5)], None),  # healthy
        ([(0, 0.5)], [0.0]),  # from the start
        ([(0, 0.5)], [10.0]),  # after the episode
        ([(0, 0.5)], [25.0]),
        ([(0, 0.5)], [9.5]),  # too late to lose anything for a second
    ],
)
def test_faults_that_do_not_count(pieces, onset):
    assert found(pieces, onset) == []
    assert np.isnan(one("peak_after_fault", error=errors(pieces), onset=onset))


def test_on_target_within_the_last_second_is_enough():
    assert found([(0, 0.5), (45, 3.0), (70, 0.5)], [5.0]) == [(5.0, 2.0, True, 3.0)]


def test_peak_after_fault_is_the_largest_over_the_faults_that_count():
    pieces = [*SLEW, (31, 4.0), (45, 0.5), (61, 2.0)]
    assert one("peak_after_fault", error=errors(pieces), onset=[3.0, 6.0]) == pytest.approx(4.0)
    assert one("peak_after_fault", error=errors(pieces), onset=[6.0]) == pytest.approx(2.0)


@given(st.lists(st.booleans(), max_size=40), st.integers(1, 4))
def test_a_return_ends_an_excursion_and_begins_a_stay(flags, least):
    held = np.array(flags, dtype=bool)
    back = first_return(held, least)
    if back is None:
        # Some loss of the target is not followed by a stay.
        last = max(np.flatnonzero(~held), default=0)
        assert len(held) - 1 - last < least
    elif back > 0:
        assert held[back : back + least].all() and len(held) >= back + least
        assert not held[back - 1]
    else:
        stays = [k for k in range(len(held)) if k + least <= len(held) and held[k : k + least].all()]
        for k in np.flatnonzero(~held):
            assert min(stay for stay in stays if stay > k) - k < least or held[k - 1 : k].any()


def test_recoveries_of_many_episodes_are_those_of_each():
    random = np.random.default_rng(3)
    error = np.where(random.random((STEPS + 1, 8)).cumsum(axis=0) % 11.0 < 8.0, 0.5, 4.0)
    together = history(error=error, onset=[2.0, 6.0], count=8).recoveries()
    for k in range(8):
        alone = history(error=error[:, k : k + 1], onset=[2.0, 6.0]).recoveries()
        np.testing.assert_array_equal(alone.time[0], together.time[k])
        np.testing.assert_array_equal(alone.recovered[0], together.recovered[k])
    assert (together.time[together.counted] <= STEPS * PERIOD).all() and together.counted.sum() > 4
