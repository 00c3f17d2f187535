"""Rules of the fault kinds, the distribution and the schedule: each broken rule names its field."""

import math

import numpy as np
import pytest

from ftac_gym.faults import (
    Bias,
    Fault,
    FaultDistribution,
    FaultKind,
    FaultSchedule,
    HardOver,
    LockInPlace,
    LossOfEffectiveness,
    Outage,
    SensorFault,
    WheelFault,
)
from ftac_gym.wheels import WheelArray

KINDS = [Bias, HardOver, LockInPlace, LossOfEffectiveness, Outage]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(
    ("timing", "message"),
    [
        ({"wheel": -1}, "wheel must be a non-negative integer or None"),
        ({"wheel": 1.0}, "wheel must be a non-negative integer or None"),
        ({"wheel": True}, "wheel must be a non-negative integer or None"),
        ({"wheel": "first"}, "wheel must be a non-negative integer or None"),
        ({"onset": -1.0}, "onset must not be negative"),
        ({"onset": (-1.0, 5.0)}, "onset must not be negative"),
        ({"onset": (5.0, 1.0)}, "onset must have low <= high"),
        ({"onset": math.inf}, "onset must be finite"),
        ({"onset": None}, "onset must be a number"),
        ({"onset": 5.0, "recovery": 5.0}, "recovery must come after the onset"),
        ({"onset": (1.0, 5.0), "recovery": (4.0, 9.0)}, "recovery must come after the onset"),
        ({"recovery": math.nan}, "recovery must be finite"),
        ({"period": 2.0}, "on_time must come with period"),
        ({"on_time": 2.0}, "on_time must come with period"),
        ({"period": 2.0, "on_time": 2.1}, "on_time must not exceed the period"),
        ({"period": (1.0, 3.0), "on_time": (0.5, 2.0)}, "on_time must not exceed the period"),
        ({"period": 2.0, "on_time": 0.0}, "on_time must be positive"),
        ({"period": 2.0, "on_time": (-1.0, 1.0)}, "on_time must be positive"),
    ],
)
def test_timing_rules_hold_for_every_kind(kind, timing, message):
    with pytest.raises(ValueError, match=message):
        kind(**timing)


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: LossOfEffectiveness(effectiveness=1.1), r"effectiveness .* must stay within \[0, 1\]"),
        (lambda: LossOfEffectiveness(effectiveness=-0.1), r"effectiveness .* must stay within \[0, 1\]"),
        (lambda: LossOfEffectiveness(effectiveness=0.5, amplitude=0.6), r"effectiveness .* must stay within \[0, 1\]"),
        (lambda: LossOfEffectiveness(effectiveness=0.5, amplitude=-0.6), r"effectiveness .* must stay within \[0, 1\]"),
        (
            lambda: LossOfEffectiveness(effectiveness=(0.2, 0.5), amplitude=(0.0, 0.3)),
            r"effectiveness .* must stay within \[0, 1\]",
        ),
        (lambda: LossOfEffectiveness(frequency=(2.0, 1.0)), "frequency must have low <= high"),
        (lambda: LossOfEffectiveness(phase=math.nan), "phase must be finite"),
        (lambda: Bias(exponent=-0.5), "exponent must not be negative"),
        (lambda: Bias(exponent=(-0.5, 1.0)), "exponent must not be negative"),
        (lambda: Bias(constant="large"), "constant must be a number"),
        (lambda: Bias(slope=(1.0, 0.0)), "slope must have low <= high"),
        (lambda: Bias(amplitude=(0.0, 1.0, 2.0)), "amplitude must be a number or a pair"),
        (lambda: Bias(frequency=math.inf), "frequency must be finite"),
        (lambda: Bias(phase=math.nan), "phase must be finite"),
        (lambda: HardOver(fraction=1.1), r"fraction must stay within \[-1, 1\]"),
        (lambda: HardOver(fraction=(-1.1, 0.0)), r"fraction must stay within \[-1, 1\]"),
    ],
)
def test_magnitude_rules(build, message):
    with pytest.raises(ValueError, match=message):
        build()


def test_edge_values_are_accepted():
    LossOfEffectiveness(effectiveness=0.5, amplitude=0.5)
    LossOfEffectiveness(effectiveness=(0.0, 1.0))
    HardOver(fraction=(-1.0, 1.0))
    Bias(exponent=0.0, onset=0.0, period=2.0, on_time=2.0)
    Outage(wheel=np.int64(3), onset=(1.0, 5.0), recovery=(5.1, 6.0))


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: FaultDistribution(kinds=()), "kinds must name at least one fault kind"),
        (lambda: FaultDistribution(kinds=("bias",)), "kinds must hold Fault objects"),
        (lambda: FaultDistribution(kinds=(Bias(wheel=1),)), "kinds must leave wheel=None"),
        (lambda: FaultDistribution(kinds=(Bias(),), weights=(1.0, 2.0)), "weights must match the 1 kinds"),
        (lambda: FaultDistribution(kinds=(Bias(), Outage()), weights=(1.0, -2.0)), "weights must be non-negative"),
        (lambda: FaultDistribution(kinds=(Bias(),), weights=(0.0,)), "weights must be .* with a positive sum"),
        (lambda: FaultDistribution(kinds=(Bias(),), weights=(math.nan,)), "weights must be non-negative"),
        (lambda: FaultDistribution(kinds=(Bias(),), fault_counts=()), "fault_counts must be non-negative"),
        (lambda: FaultDistribution(kinds=(Bias(),), fault_counts=(0.5, -0.1)), "fault_counts must be non-negative"),
        (lambda: FaultSchedule(("outage",)), "faults must hold Fault objects"),
        (lambda: FaultSchedule((Outage(),)), "faults must each name a wheel"),
    ],
)
def test_source_rules(build, message):
    with pytest.raises(ValueError, match=message):
        build()


def test_more_fault_counts_than_wheels_are_refused():
    source = FaultDistribution(kinds=(Outage(),), fault_counts=(0.0, 0.0, 0.0, 1.0))
    source.check(WheelArray(np.eye(3), 0.2))
    with pytest.raises(ValueError, match="fault_counts must not exceed the 2 wheels of the craft"):
        source.check(WheelArray(np.eye(3)[:, :2], 0.2))


def test_a_scheduled_wheel_that_does_not_exist_is_refused():
    FaultSchedule((Outage(wheel=3),)).check(WheelArray.sign_pyramid(0.2, None))
    with pytest.raises(ValueError, match="wheel must be below the number of wheels, 4"):
        FaultSchedule((Outage(wheel=4),)).check(WheelArray.sign_pyramid(0.2, None))


def test_hard_over_needs_a_torque_limit():
    with pytest.raises(ValueError, match="HardOver needs wheels with a torque limit"):
        FaultSchedule((HardOver(wheel=0),)).draw(np.zeros((1, 14)), np.zeros((1, 0)), np.array([np.inf]))


def test_the_base_class_is_no_fault():
    for base in (Fault(), WheelFault(wheel=0), SensorFault()):
        with pytest.raises(ValueError, match="faults must hold Fault objects of a concrete kind"):
            FaultSchedule((base,))


def test_kinds_have_distinct_labels():
    assert FaultKind.NONE.label == "healthy"
    assert FaultKind.LOCK_IN_PLACE.label == "lock in place"
    assert len({kind.label for kind in FaultKind}) == len(FaultKind)
    assert sorted(kind.kind for kind in KINDS) == sorted(set(FaultKind) - {FaultKind.NONE})
