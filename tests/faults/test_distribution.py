"""Random faults: shares of healthy episodes, of kinds and of wheels."""

import numpy as np
from helpers.fault_draws import COUNT, LIMITS, assert_shares, draw, draw_all, faulty_rows, only

from ftac_gym.faults import (
    AttitudeSpike,
    Bias,
    FaultKind,
    GyroBiasStep,
    HardOver,
    IntermittentShutdown,
    LockInPlace,
    Outage,
)
from ftac_gym.faults.table import no_faults, no_sensor_faults


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
    kinds = faulty_rows(table)["kind"]
    assert len(kinds) == COUNT
    assert_shares([np.sum(kinds == FaultKind.BIAS), np.sum(kinds == FaultKind.LOCK_IN_PLACE)], (1.0, 3.0))
    assert not np.any(kinds == FaultKind.OUTAGE)


def test_kinds_are_equally_likely_without_weights():
    kinds = faulty_rows(draw(only(Bias(), Outage(), LockInPlace(), HardOver())))["kind"]
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


def test_faults_of_the_sensors_count_with_those_of_wheels():
    drawn = draw_all(only(Outage(), GyroBiasStep(), weights=(1.0, 3.0), fault_counts=(1.0, 2.0, 3.0)))
    wheels, sensors = drawn.wheels["kind"][:, :, 0] > 0, drawn.sensors["kind"] > 0
    assert wheels.shape == (COUNT, 4) and sensors.shape == (COUNT, 2)
    number = wheels.sum(axis=1) + sensors.sum(axis=1)
    assert_shares(np.bincount(number, minlength=3), (1.0, 2.0, 3.0))
    assert_shares([wheels.sum(), sensors.sum()], (1.0, 3.0))
    healthy = drawn.sensors[~sensors]
    assert np.all(healthy == no_sensor_faults(1, 1)[0, 0])


def test_sensors_that_cannot_fail_have_no_table():
    assert draw_all(only(Outage(), fault_counts=(0.0, 0.0, 1.0)), 5).sensors.shape == (5, 0)
    assert draw_all(only(GyroBiasStep(), fault_counts=(1.0,)), 5).sensors.shape == (5, 0)


def test_episodes_do_not_depend_on_how_many_are_drawn():
    source = only(
        Bias(constant=(0.0, 0.1)), HardOver(), IntermittentShutdown(), AttitudeSpike(angle=(0.0, 1.0)),
        fault_counts=(0.2, 0.4, 0.4),
    )  # fmt: skip
    random = np.random.default_rng(1)
    uniform, chances = random.random((50, source.uniform_count(4))), random.random((50, source.switching_count))
    many, two = source.draw(uniform, chances, LIMITS), source.draw(uniform[7:9], chances[7:9], LIMITS)
    for part, same in zip(many.take(np.array([7, 8])), two, strict=True):
        np.testing.assert_array_equal(part, same)
