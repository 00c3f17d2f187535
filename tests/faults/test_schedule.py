"""Scheduled faults: all of them, in every episode, with several layers on one wheel."""

import numpy as np
import pytest

from ftac_gym.faults import Bias, FaultKind, FaultSchedule, HardOver, LossOfEffectiveness, Outage
from ftac_gym.faults.table import no_faults

LIMITS = np.array([0.1, 0.2, 0.3, 0.4])


def draw(schedule, count=20, seed=0):
    uniform = np.random.default_rng(seed).random((count, schedule.uniform_count(len(LIMITS))))
    return schedule.draw(uniform, np.zeros((count, 0)), LIMITS).wheels


def test_every_episode_has_all_faults_on_their_wheels():
    table = draw(FaultSchedule((Outage(wheel=2, onset=3.0), Bias(wheel=0, constant=0.1))))
    assert table.shape == (20, 4, 1)
    assert np.all(table["kind"][:, 2] == FaultKind.OUTAGE) and np.all(table["onset"][:, 2] == 3.0)
    assert np.all(table["kind"][:, 0] == FaultKind.BIAS) and np.all(table["bias"][:, 0] == 0.1)
    assert np.all(table[:, [1, 3]] == no_faults(1, 1)[0, 0, 0])


def test_several_faults_of_one_wheel_are_layers():
    schedule = FaultSchedule(
        (LossOfEffectiveness(wheel=1, effectiveness=0.4), Outage(wheel=0), Bias(wheel=1, constant=0.2), Bias(wheel=1))
    )
    assert schedule.layers() == 3
    table = draw(schedule)
    assert table.shape == (20, 4, 3)
    assert sorted(table["kind"][0, 1]) == [
        FaultKind.LOSS_OF_EFFECTIVENESS,
        FaultKind.BIAS,
        FaultKind.BIAS,
    ]
    assert np.all(np.sort(table["kind"][:, 0], axis=1)[:, :2] == FaultKind.NONE)


def test_the_order_of_the_wheels_in_the_list_does_not_matter():
    faults = (Outage(wheel=3, onset=1.0), Bias(wheel=1, constant=0.1), LossOfEffectiveness(wheel=2))
    np.testing.assert_array_equal(draw(FaultSchedule(faults)), draw(FaultSchedule(faults[::-1])))


def test_intervals_differ_between_episodes_and_between_faults():
    table = draw(FaultSchedule(tuple(Bias(wheel=wheel, constant=(0.0, 1.0)) for wheel in (0, 0, 1))))
    drawn = table["bias"][:, [0, 0, 1], [0, 1, 0]]
    assert len(np.unique(drawn)) == drawn.size


def test_hard_over_uses_the_limit_of_its_wheel():
    table = draw(FaultSchedule((HardOver(wheel=3, fraction=0.5, random_sign=False),)))
    np.testing.assert_allclose(table["bias"][:, 3, 0], 0.2)


@pytest.mark.parametrize("count", [1, 5])
def test_an_empty_schedule_is_healthy(count):
    np.testing.assert_array_equal(draw(FaultSchedule(()), count), no_faults(count, 4))


def test_a_list_is_as_good_as_a_tuple():
    assert FaultSchedule([Outage(wheel=1)]) == FaultSchedule((Outage(wheel=1),))
