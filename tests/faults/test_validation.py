"""Rules of the fault kinds, the distribution and the schedule: each broken rule names its field."""

import math

import numpy as np
import pytest

from ftac_gym import faults
from ftac_gym.spacecraft import WheelArray

WHOLE = [faults.LockInPlace, faults.Seizure, faults.CommandDelay, faults.StarTrackerOutage]
"""Kinds that are there whole or not at all."""

GRADUAL = [kind for kind in faults.KINDS if kind not in WHOLE]


@pytest.mark.parametrize("kind", [kind for kind in faults.KINDS if issubclass(kind, faults.WheelFault)])
@pytest.mark.parametrize("wheel", [-1, 1.0, True, "first"])
def test_a_wheel_is_an_index(kind, wheel):
    with pytest.raises(ValueError, match="wheel must be a non-negative integer or None"):
        kind(wheel=wheel)


@pytest.mark.parametrize("kind", faults.KINDS)
@pytest.mark.parametrize(
    ("timing", "message"),
    [
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
        ({"duration": 0.0}, "duration must be positive"),
        ({"duration": (-1.0, 5.0)}, "duration must be positive"),
        ({"duration": (5.0, 1.0)}, "duration must have low <= high"),
        ({"duration": math.inf}, "duration must be finite"),
        ({"duration": 5.0, "recovery": 9.0}, "duration must not come with recovery"),
        ({"rise": -1.0, "duration": 5.0}, "rise must not be negative"),
        ({"rise": (-1.0, 5.0)}, "rise must not be negative"),
        ({"rise": math.nan}, "rise must be finite"),
        ({"fall": -1.0, "recovery": 9.0}, "fall must not be negative"),
        ({"fall": (2.0, 1.0), "recovery": 9.0}, "fall must have low <= high"),
        ({"fall": "slow"}, "fall must be a number"),
        ({"mean_acting": 2.0, "mean_resting": None}, "mean_resting must come with mean_acting"),
        ({"mean_acting": None, "mean_resting": 2.0}, "mean_resting must come with mean_acting"),
        ({"mean_acting": 0.0, "mean_resting": 2.0}, "mean_acting must be positive"),
        ({"mean_acting": 2.0, "mean_resting": -1.0}, "mean_resting must be positive"),
        ({"mean_acting": math.inf, "mean_resting": 2.0}, "mean_acting must be finite"),
        ({"mean_acting": 2.0, "mean_resting": math.nan}, "mean_resting must be finite"),
        ({"mean_acting": (1.0, 2.0), "mean_resting": 2.0}, "mean_acting must be a number"),
        (
            {"mean_acting": 2.0, "mean_resting": 3.0, "period": 2.0, "on_time": 1.0},
            "mean_acting must not come with period",
        ),
    ],
)
def test_timing_rules_hold_for_every_kind(kind, timing, message):
    with pytest.raises(ValueError, match=message):
        kind(**timing)


@pytest.mark.parametrize("kind", GRADUAL)
@pytest.mark.parametrize("fall", [1.0, (0.0, 1.0)])
def test_only_what_ends_can_fall(kind, fall):
    with pytest.raises(ValueError, match="fall needs recovery or duration"):
        kind(fall=fall)
    kind(fall=fall, duration=0.5)
    kind(fall=fall, recovery=2.0)


@pytest.mark.parametrize("kind", WHOLE)
@pytest.mark.parametrize("profile", [1.0, (0.0, 1.0)])
def test_what_is_there_whole_or_not_at_all_neither_rises_nor_falls(kind, profile):
    with pytest.raises(ValueError, match=f"rise must be zero: {kind.__name__} is there whole or not at all"):
        kind(rise=profile)
    with pytest.raises(ValueError, match=f"fall must be zero: {kind.__name__} is there whole or not at all"):
        kind(fall=profile, duration=9.0)
    assert not kind.gradual
    kind(rise=0.0, fall=(0.0, 0.0), duration=9.0)


@pytest.mark.parametrize("kind", GRADUAL)
def test_everything_else_rises_and_falls(kind):
    fault = kind(onset=1.0, rise=(1.0, 2.0), duration=0.5, fall=3.0)  # it may even end before it is all there
    assert kind.gradual and (fault.rise, fault.fall, fault.duration) == ((1.0, 2.0), 3.0, 0.5)


@pytest.mark.parametrize("kind", faults.KINDS)
def test_every_kind_can_come_and_go_at_random(kind):
    assert kind(mean_acting=2.0, mean_resting=3).random_chain
    assert kind().random_chain == (kind is faults.IntermittentShutdown)


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: faults.LossOfEffectiveness(effectiveness=1.1), r"effectiveness .* must stay within \[0, 1\]"),
        (lambda: faults.LossOfEffectiveness(effectiveness=-0.1), r"effectiveness .* must stay within \[0, 1\]"),
        (
            lambda: faults.LossOfEffectiveness(effectiveness=0.5, amplitude=0.6),
            r"effectiveness .* must stay within \[0, 1\]",
        ),
        (
            lambda: faults.LossOfEffectiveness(effectiveness=0.5, amplitude=-0.6),
            r"effectiveness .* must stay within \[0, 1\]",
        ),
        (
            lambda: faults.LossOfEffectiveness(effectiveness=(0.2, 0.5), amplitude=(0.0, 0.3)),
            r"effectiveness .* must stay within \[0, 1\]",
        ),
        (lambda: faults.LossOfEffectiveness(frequency=(2.0, 1.0)), "frequency must have low <= high"),
        (lambda: faults.LossOfEffectiveness(phase=math.nan), "phase must be finite"),
        (lambda: faults.Bias(exponent=-0.5), "exponent must not be negative"),
        (lambda: faults.Bias(exponent=(-0.5, 1.0)), "exponent must not be negative"),
        (lambda: faults.Bias(constant="large"), "constant must be a number"),
        (lambda: faults.Bias(slope=(1.0, 0.0)), "slope must have low <= high"),
        (lambda: faults.Bias(amplitude=(0.0, 1.0, 2.0)), "amplitude must be a number or a pair"),
        (lambda: faults.Bias(frequency=math.inf), "frequency must be finite"),
        (lambda: faults.Bias(phase=math.nan), "phase must be finite"),
        (lambda: faults.HardOver(fraction=1.1), r"fraction must stay within \[-1, 1\]"),
        (lambda: faults.HardOver(fraction=(-1.1, 0.0)), r"fraction must stay within \[-1, 1\]"),
        (lambda: faults.DriftingEffectiveness(effectiveness=-0.1), r"effectiveness must stay within \[0, 1\]"),
        (lambda: faults.DriftingEffectiveness(effectiveness=(0.5, 1.1)), r"effectiveness must stay within \[0, 1\]"),
        (lambda: faults.DriftingEffectiveness(rise=0.0), "rise must be positive"),
        (lambda: faults.DriftingEffectiveness(rise=(0.0, 5.0)), "rise must be positive"),
        (lambda: faults.FrictionRise(factor=0.9), "factor must not be below 1"),
        (lambda: faults.FrictionRise(factor=(0.5, 3.0)), "factor must not be below 1"),
        (lambda: faults.FrictionRise(factor=math.inf), "factor must be finite"),
        (
            lambda: faults.FrictionRise(direction="sideways"),
            r"direction must be one of \['both', .*'either'\], got 'sideways'",
        ),
        (lambda: faults.FrictionRise(direction=None), "direction must be one of"),
        (lambda: faults.Seizure(brake=1.0), "brake must exceed 1"),
        (lambda: faults.Seizure(brake=(0.9, 2.0)), "brake must exceed 1"),
        (lambda: faults.Seizure(brake="hard"), "brake must be a number"),
        (lambda: faults.IntermittentShutdown(mean_acting=None, mean_resting=None), "mean_acting must be given"),
        (lambda: faults.CommandDelay(periods=0), "periods must be whole numbers from 1 to 5"),
        (lambda: faults.CommandDelay(periods=6), "periods must be whole numbers from 1 to 5"),
        (lambda: faults.CommandDelay(periods=(1, 6)), "periods must be whole numbers from 1 to 5"),
        (lambda: faults.CommandDelay(periods=(0, 2)), "periods must be whole numbers from 1 to 5"),
        (lambda: faults.CommandDelay(periods=1.5), "periods must be whole numbers from 1 to 5"),
        (lambda: faults.CommandDelay(periods=(1, 2.5)), "periods must be whole numbers from 1 to 5"),
        (lambda: faults.CommandDelay(periods=-1), "periods must be whole numbers from 1 to 5"),
        (lambda: faults.CommandDelay(periods=math.nan), "periods must be finite"),
        (lambda: faults.GyroBiasStep(size=-1e-4), "size must not be negative"),
        (lambda: faults.GyroBiasStep(size=(-1e-4, 1e-4)), "size must not be negative"),
        (lambda: faults.GyroBiasStep(size=math.nan), "size must be finite"),
        (lambda: faults.AttitudeSpike(angle=-0.1), r"angle must stay within \[0, pi\]"),
        (lambda: faults.AttitudeSpike(angle=(1.0, 3.2)), r"angle must stay within \[0, pi\]"),
        (lambda: faults.AttitudeSpike(angle=math.inf), "angle must be finite"),
    ],
)
def test_magnitude_rules(build, message):
    with pytest.raises(ValueError, match=message):
        build()


def test_edge_values_are_accepted():
    faults.LossOfEffectiveness(effectiveness=0.5, amplitude=0.5)
    faults.LossOfEffectiveness(effectiveness=(0.0, 1.0))
    faults.HardOver(fraction=(-1.0, 1.0))
    faults.Bias(exponent=0.0, onset=0.0, period=2.0, on_time=2.0)
    faults.Outage(wheel=np.int64(3), onset=(1.0, 5.0), recovery=(5.1, 6.0))
    faults.DriftingEffectiveness(effectiveness=(0.0, 1.0), rise=1e-3)
    faults.FrictionRise(factor=1.0, rise=0.0)
    faults.CommandDelay(periods=(1, 5))
    faults.CommandDelay(periods=5.0)
    faults.AttitudeSpike(angle=(0.0, math.pi))
    faults.GyroBiasStep(size=0.0)
    faults.FaultDistribution(kinds=(faults.Bias(),), severity=0)
    faults.FaultDistribution(kinds=(faults.Bias(),), severity=1)


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: faults.FaultDistribution(kinds=()), "kinds must name at least one fault kind"),
        (lambda: faults.FaultDistribution(kinds=("bias",)), "kinds must hold Fault objects"),
        (lambda: faults.FaultDistribution(kinds=(faults.Bias(wheel=1),)), "kinds must leave wheel=None"),
        (
            lambda: faults.FaultDistribution(kinds=(faults.Bias(),), weights=(1.0, 2.0)),
            "weights must match the 1 kinds",
        ),
        (
            lambda: faults.FaultDistribution(kinds=(faults.Bias(), faults.Outage()), weights=(1.0, -2.0)),
            "weights must be non-negative",
        ),
        (
            lambda: faults.FaultDistribution(kinds=(faults.Bias(),), weights=(0.0,)),
            "weights must be .* with a positive sum",
        ),
        (lambda: faults.FaultDistribution(kinds=(faults.Bias(),), weights=(math.nan,)), "weights must be non-negative"),
        (
            lambda: faults.FaultDistribution(kinds=(faults.Bias(),), fault_counts=()),
            "fault_counts must be non-negative",
        ),
        (
            lambda: faults.FaultDistribution(kinds=(faults.Bias(),), fault_counts=(0.5, -0.1)),
            "fault_counts must be non-negative",
        ),
        (
            lambda: faults.FaultDistribution(kinds=(faults.Bias(),), severity=-0.1),
            r"severity must be within \[0, 1\], got -0.1",
        ),
        (
            lambda: faults.FaultDistribution(kinds=(faults.Bias(),), severity=1.1),
            r"severity must be within \[0, 1\], got 1.1",
        ),
        (lambda: faults.FaultDistribution(kinds=(faults.Bias(),), severity=math.nan), "severity must be finite"),
        (lambda: faults.FaultDistribution(kinds=(faults.Bias(),), severity=None), "severity must be a number"),
        (
            lambda: faults.FaultDistribution(kinds=(faults.SensorFault(),)),
            "kinds must hold Fault objects of a concrete kind",
        ),
        (lambda: faults.FaultDistribution(kinds=(faults.Bias,)), "kinds must hold Fault objects of a concrete kind"),
        (lambda: faults.FaultSchedule(("outage",)), "faults must hold Fault objects"),
        (lambda: faults.FaultSchedule((faults.Outage(),)), "faults must each name a wheel"),
    ],
)
def test_source_rules(build, message):
    with pytest.raises(ValueError, match=message):
        build()


def test_more_fault_counts_than_wheels_are_refused():
    source = faults.FaultDistribution(kinds=(faults.Outage(),), fault_counts=(0.0, 0.0, 0.0, 1.0))
    source.check(WheelArray(np.eye(3), 0.2))
    with pytest.raises(ValueError, match="fault_counts must not exceed the 2 wheels of the spacecraft"):
        source.check(WheelArray(np.eye(3)[:, :2], 0.2))


def test_a_scheduled_wheel_that_does_not_exist_is_refused():
    faults.FaultSchedule((faults.Outage(wheel=3),)).check(WheelArray.sign_pyramid(0.2, None))
    with pytest.raises(ValueError, match="wheel must be below the number of wheels, 4"):
        faults.FaultSchedule((faults.Outage(wheel=4),)).check(WheelArray.sign_pyramid(0.2, None))


@pytest.mark.parametrize("kind", [faults.HardOver, faults.Seizure])
def test_what_is_measured_in_torque_limits_needs_one(kind):
    with pytest.raises(ValueError, match=f"{kind.__name__} needs wheels with a torque limit; torque_limit"):
        faults.FaultSchedule((kind(wheel=0),)).draw(np.zeros((1, 14)), np.zeros((1, 0)), np.array([np.inf]))


def test_faults_of_the_sensors_name_no_wheel():
    faults.FaultSchedule((faults.GyroBiasStep(), faults.AttitudeSpike(), faults.StarTrackerOutage())).check(
        WheelArray(np.eye(3), 0.2)
    )
    source = faults.FaultDistribution((faults.GyroBiasStep(), faults.Outage()), fault_counts=(0.0, 0.0, 1.0))
    source.check(WheelArray(np.eye(3)[:, :2], 0.2))
    with pytest.raises(TypeError):
        faults.GyroBiasStep(wheel=1)


def test_the_base_class_is_no_fault():
    for base in (faults.Fault(), faults.WheelFault(wheel=0), faults.SensorFault()):
        with pytest.raises(ValueError, match="faults must hold Fault objects of a concrete kind"):
            faults.FaultSchedule((base,))


def test_kinds_have_distinct_labels():
    assert faults.FaultKind.NONE.label == "healthy"
    assert faults.FaultKind.LOCK_IN_PLACE.label == "lock in place"
    assert len({kind.label for kind in faults.FaultKind}) == len(faults.FaultKind)
    assert sorted(kind.kind for kind in faults.KINDS) == sorted(set(faults.FaultKind) - {faults.FaultKind.NONE})
