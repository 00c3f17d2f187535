"""Alarms from flags and from thresholds."""

from dataclasses import replace

import numpy as np
import pytest

from ftac_gym import scenarios
from ftac_gym.baselines import FaultEstimate
from ftac_gym.evaluation.diagnosis.alarms import AlarmRule, alarms_of

WHEELS = scenarios.get("flagship").spacecraft.wheels  # limit 0.2 N m
RULE = AlarmRule(effectiveness=0.6, bias=0.25, disturbance=0.5, hold=0.3)
STEPS, PERIOD = 8, 0.1


def column(*values, parts=4, at=0):
    """Return an array (STEPS, 1, parts) with values along one of them."""
    array = np.zeros((STEPS, 1, parts))
    array[:, 0, at] = values
    return array


def raised(**parts):
    return alarms_of(FaultEstimate(**parts), RULE, WHEELS, PERIOD)


def test_flags_are_taken_as_they_are():
    flags = column(0, 1, 0, 1, 1, 0, 0, 0, at=2) > 0.0
    found = raised(alarm=flags, bias=column(*[9.0] * STEPS), disturbance=column(*[9.0] * STEPS, parts=3))
    np.testing.assert_array_equal(found.wheels, flags)
    assert not found.body.any() and found.names_wheels


def test_a_threshold_must_be_exceeded_for_the_hold():
    # The threshold is 0.05 N m, and 0.3 s are three periods.
    found = raised(bias=column(0.0, 0.06, 0.06, 0.04, 0.06, -0.06, -0.1, 0.06, at=1))
    np.testing.assert_allclose(found.wheels[:, 0, 1], [0, 0, 0, 0, 0, 0, 2.0, 1.2], atol=1e-12)
    assert not found.wheels[:, 0, [0, 2, 3]].any() and not found.body.any()


@pytest.mark.parametrize(("hold", "periods"), [(0.0, 1), (0.1, 1), (0.15, 2), (0.25, 3), (0.3, 3), (0.45, 5)])
def test_an_alarm_never_comes_before_the_hold(hold, periods):
    estimates = FaultEstimate(bias=column(*[0.06] * STEPS, at=1))
    found = alarms_of(estimates, replace(RULE, hold=hold), WHEELS, PERIOD)
    assert np.flatnonzero(found.wheels[:, 0, 1])[0] == periods - 1


def test_effectiveness_counts_where_it_can_be_identified():
    low = np.ones((STEPS, 1, 4))
    low[:, 0, 3] = 0.2
    np.testing.assert_allclose(raised(effectiveness=low).wheels[2:, 0, 3], 2.0)
    known = np.ones(low.shape, dtype=bool)
    known[4, 0, 3] = False
    found = raised(effectiveness=low, identifiable=known)
    np.testing.assert_array_equal(found.wheels[:, 0, 3] > 0.0, [0, 0, 1, 1, 0, 0, 0, 1])


def test_a_torque_on_the_body_names_no_wheel():
    # The length counts: 0.08 N m on two axes are 0.113 N m.
    torque = column(*[0.08] * STEPS, parts=3) + column(*[0.08] * STEPS, parts=3, at=1)
    found = raised(disturbance=torque)
    np.testing.assert_array_equal(found.body[:, 0], [0, 0, 1, 1, 1, 1, 1, 1])
    assert not found.names_wheels and not found.wheels.any()
    np.testing.assert_array_equal(found.any, found.body)


def test_wheels_without_a_limit_are_measured_in_newton_metres():
    wheels = replace(WHEELS, torque_limit=None)
    found = alarms_of(FaultEstimate(bias=np.full((STEPS, 1, wheels.count), 0.3)), RULE, wheels, PERIOD)
    np.testing.assert_allclose(found.wheels[2:], 1.2)


@pytest.mark.parametrize(
    ("field", "value", "rule"),
    [
        ("effectiveness", 1.0, "must be below 1"),
        ("effectiveness", 0.0, "must be positive"),
        ("bias", -0.1, "must be positive"),
        ("disturbance", 0.0, "must be positive"),
        ("hold", -1.0, "must not be negative|must be non-negative"),
        ("grace", float("nan"), "must be"),
    ],
)
def test_wrong_thresholds_are_named(field, value, rule):
    with pytest.raises(ValueError, match=f"{field} ({rule})"):
        AlarmRule(**{field: value})


def test_an_empty_estimate_is_refused():
    with pytest.raises(ValueError, match="estimate must have alarm, effectiveness, bias or disturbance"):
        raised(vibration=np.zeros((STEPS, 1, 3)))
