"""Detection, isolation and false alarms against histories made by hand, and for estimators of known quality."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ftac_gym import scenarios
from ftac_gym.evaluation.diagnosis.alarms import Alarms
from ftac_gym.evaluation.diagnosis.detection import NO_WHEEL, detections, false_alarms
from ftac_gym.faults import Bias, FaultSchedule, GyroBiasStep, Outage

STEPS, PERIOD, WHEELS, GRACE = 100, 0.1, 4, 2.0
FLAGSHIP = scenarios.get("flagship").replace(duration=STEPS * PERIOD)


def episodes_of(*faults, count=1):
    return FLAGSHIP.replace(faults=FaultSchedule(faults) if faults else None).draw(0, count)


def alarms(*spans, body=()):
    """Return alarms of a spacecraft from triples (wheel, first, last) and pairs (first, last) of times [s]."""
    wheels, torque = np.zeros((STEPS, 1, WHEELS)), np.zeros((STEPS, 1), dtype=bool)
    for wheel, first, last, *weight in spans:
        wheels[round(first / PERIOD) : round(last / PERIOD), 0, wheel] = weight[0] if weight else 1.0
    for first, last in body:
        torque[round(first / PERIOD) : round(last / PERIOD)] = True
    return Alarms(wheels, torque, names_wheels=True)


def found(raised, *faults):
    return detections(raised, episodes_of(*faults), PERIOD, GRACE)


def wrong(raised, *faults):
    count, healthy, time = false_alarms(raised, episodes_of(*faults), PERIOD, GRACE)
    return int(count[0]), float(healthy[0]), float(time[0])


def test_the_delay_is_from_the_onset_to_the_first_alarm():
    (fault,) = found(alarms((2, 4.5, 10.0)), Outage(wheel=2, onset=3.04))
    assert fault["delay"] == pytest.approx(1.46) and fault["watched"] == pytest.approx(6.96)
    assert (fault["named"], fault["wheel"]) == (2, 2)


def test_a_missed_fault_is_watched_to_its_end():
    missed = found(alarms((1, 8.0, 10.0)), Bias(wheel=1, constant=0.1, onset=3.0, recovery=7.0))
    assert np.isnan(missed["delay"][0]) and missed["watched"][0] == pytest.approx(4.0)
    assert missed["named"][0] == NO_WHEEL
    to_the_end = found(alarms(), Outage(wheel=1, onset=3.0))
    assert np.isnan(to_the_end["delay"][0]) and to_the_end["watched"][0] == pytest.approx(7.0)


def test_faults_after_the_last_command_do_not_count():
    assert len(found(alarms(), Outage(wheel=0, onset=9.95))) == 0
    assert len(found(alarms(), Outage(wheel=0, onset=9.9))) == 1


def test_the_wheel_of_most_weight_is_named():
    assert found(alarms((0, 3.0, 3.5), (2, 3.5, 9.0)), Outage(wheel=2, onset=3.0))["named"] == [2]
    assert found(alarms((0, 3.0, 9.0, 3.0), (2, 3.0, 9.0, 1.5)), Outage(wheel=2, onset=3.0))["named"] == [0]
    tied = found(alarms((0, 3.0, 9.0), (2, 3.0, 9.0)), Outage(wheel=2, onset=3.0))
    assert tied["named"] == [NO_WHEEL] and tied["delay"] == [0.0]


def test_an_alarm_of_the_body_detects_and_names_no_wheel():
    (fault,) = found(alarms(body=[(5.0, 10.0)]), Outage(wheel=2, onset=3.0))
    assert fault["delay"] == pytest.approx(2.0) and fault["named"] == NO_WHEEL


def test_an_alarm_that_stands_already_announces_nothing():
    outage = Outage(wheel=2, onset=3.0)
    assert np.isnan(found(alarms((2, 1.0, 10.0)), outage)["delay"][0])
    assert np.isnan(found(alarms(body=[(0.0, 10.0)]), outage)["delay"][0])
    again = found(alarms((2, 1.0, 4.0), (2, 6.0, 10.0)), outage)
    assert again["delay"] == pytest.approx([3.0])
    other = found(alarms((0, 1.0, 10.0), (2, 3.5, 10.0)), outage)
    assert other["delay"] == pytest.approx([0.5]) and other["named"] == [2]


def test_each_of_two_faults_has_its_own_alarm():
    faults = Outage(wheel=1, onset=2.0), Outage(wheel=3, onset=6.0)
    first, second = found(alarms((1, 2.5, 10.0), (3, 7.0, 10.0)), *faults)
    assert (first["delay"], second["delay"]) == pytest.approx((0.5, 1.0))
    assert (first["named"], second["named"]) == (1, 3)
    first, second = found(alarms((1, 2.5, 10.0)), *faults)
    assert first["delay"] == pytest.approx(0.5) and np.isnan(second["delay"])
    # Wheel 3 is healthy at four seconds, so that its alarm is a wrong name for the fault of wheel 1.
    first, second = found(alarms((3, 4.0, 5.5)), *faults)
    assert first["named"] == 3 and np.isnan(second["delay"])


def test_two_faults_of_a_wheel_are_two():
    faults = (
        Bias(wheel=1, constant=0.1, onset=1.0, recovery=3.0),
        Bias(wheel=1, constant=0.1, onset=6.0, recovery=8.0),
    )
    both = found(alarms((1, 1.2, 3.0), (1, 6.7, 8.0)), *faults)
    np.testing.assert_allclose(both["delay"], [0.2, 0.7], atol=1e-12)


def test_false_alarms_begin_where_no_fault_acts():
    assert wrong(alarms((0, 1.0, 2.0), body=[(4.0, 4.5)])) == pytest.approx((2, 10.0, 1.5))
    # Alarms of two wheels at once are one alarm of the spacecraft.
    assert wrong(alarms((0, 1.0, 2.0), (1, 1.5, 3.0))) == pytest.approx((1, 10.0, 2.0))
    # A wrong wheel while a fault acts is no false alarm: it costs isolation.
    assert wrong(alarms((0, 5.0, 6.0)), Outage(wheel=2, onset=4.0)) == pytest.approx((0, 4.0, 0.0))


def test_an_alarm_may_outlast_a_fault_by_the_grace_period():
    fault = Bias(wheel=1, constant=0.1, onset=1.0, recovery=4.0)
    assert wrong(alarms((1, 1.0, 6.0)), fault) == pytest.approx((0, 1.0 + 4.0, 0.0))
    assert wrong(alarms((1, 1.0, 7.5)), fault) == pytest.approx((1, 5.0, 1.5))
    assert wrong(alarms((1, 1.0, 4.0), (0, 9.0, 9.5)), fault) == pytest.approx((1, 5.0, 0.5))


def test_faults_of_sensors_are_no_faults_of_wheels_and_no_healthy_time():
    fault = GyroBiasStep(size=0.01, onset=4.0)
    raised = alarms((1, 5.0, 6.0))
    assert len(found(raised, fault)) == 0 and wrong(raised, fault) == pytest.approx((0, 4.0, 0.0))


ONSETS = st.floats(0.0, 9.8)
WHEEL = st.integers(0, WHEELS - 1)


@given(onset=ONSETS, length=st.floats(0.3, 20.0), wheel=WHEEL)
def test_a_quiet_estimator_misses_everything(onset, length, wheel):
    fault = Bias(wheel=wheel, constant=0.1, onset=onset, duration=length)
    found_, wrong_ = found(alarms(), fault), wrong(alarms(), fault)
    assert np.isnan(found_["delay"]).all() and wrong_[0] == wrong_[2] == 0
    assert found_["watched"] == pytest.approx(min(length, 10.0 - onset))


@given(onset=ONSETS, length=st.floats(0.3, 20.0), wheel=WHEEL)
def test_a_perfect_estimator_has_no_delay_beyond_sampling(onset, length, wheel):
    fault = Bias(wheel=wheel, constant=0.1, onset=onset, duration=length)
    time = np.arange(STEPS) * PERIOD
    raised = alarms()
    raised.wheels[(time >= onset - 1e-9) & (time < onset + length - 1e-9), 0, wheel] = 1.0
    (one,), false = found(raised, fault), wrong(raised, fault)
    assert 0.0 <= one["delay"] < PERIOD and one["named"] == wheel
    assert false[0] == false[2] == 0


@given(onset=st.floats(0.2, 9.8), wheel=WHEEL)
def test_an_alarm_that_never_ends_finds_nothing(onset, wheel):
    raised = alarms(*((index, 0.0, 10.0) for index in range(WHEELS)), body=[(0.0, 10.0)])
    fault = Outage(wheel=wheel, onset=onset)
    (one,), (count, healthy, time) = found(raised, fault), wrong(raised, fault)
    assert np.isnan(one["delay"]) and count == 1 and healthy == time == pytest.approx(onset, abs=PERIOD)
