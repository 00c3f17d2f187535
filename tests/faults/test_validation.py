"""Rules of the fault kinds, the distribution and the schedule: each broken rule names its field."""

import math

import numpy as np
import pytest

from ftac_gym.faults import (
    KINDS,
    AttitudeSpike,
    Bias,
    CommandDelay,
    DriftingEffectiveness,
    Fault,
    FaultDistribution,
    FaultKind,
    FaultSchedule,
    FrictionRise,
    GyroBiasStep,
    HardOver,
    IntermittentShutdown,
    LockInPlace,
    LossOfEffectiveness,
    Outage,
    Seizure,
    SensorFault,
    StarTrackerOutage,
    WheelFault,
)
from ftac_gym.spacecraft import WheelArray

WHOLE = [LockInPlace, Seizure, CommandDelay, StarTrackerOutage]
"""Kinds that are there whole or not at all."""

GRADUAL = [kind for kind in KINDS if kind not in WHOLE]


@pytest.mark.parametrize("kind", [kind for kind in KINDS if issubclass(kind, WheelFault)])
@pytest.mark.parametrize("wheel", [-1, 1.0, True, "first"])
def test_a_wheel_is_an_index(kind, wheel):
    with pytest.raises(ValueError, match="wheel must be a non-negative integer or None"):
        kind(wheel=wheel)


@pytest.mark.parametrize("kind", KINDS)
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


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_can_come_and_go_at_random(kind):
    assert kind(mean_acting=2.0, mean_resting=3).random_chain
    assert kind().random_chain == (kind is IntermittentShutdown)


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
        (lambda: DriftingEffectiveness(effectiveness=-0.1), r"effectiveness must stay within \[0, 1\]"),
        (lambda: DriftingEffectiveness(effectiveness=(0.5, 1.1)), r"effectiveness must stay within \[0, 1\]"),
        (lambda: DriftingEffectiveness(rise=0.0), "rise must be positive"),
        (lambda: DriftingEffectiveness(rise=(0.0, 5.0)), "rise must be positive"),
        (lambda: FrictionRise(factor=0.9), "factor must not be below 1"),
        (lambda: FrictionRise(factor=(0.5, 3.0)), "factor must not be below 1"),
        (lambda: FrictionRise(factor=math.inf), "factor must be finite"),
        (
            lambda: FrictionRise(direction="sideways"),
            r"direction must be one of \['both', .*'either'\], got 'sideways'",
        ),
        (lambda: FrictionRise(direction=None), "direction must be one of"),
        (lambda: Seizure(brake=1.0), "brake must exceed 1"),
        (lambda: Seizure(brake=(0.9, 2.0)), "brake must exceed 1"),
        (lambda: Seizure(brake="hard"), "brake must be a number"),
        (lambda: IntermittentShutdown(mean_acting=None, mean_resting=None), "mean_acting must be given"),
        (lambda: CommandDelay(periods=0), "periods must be whole numbers from 1 to 5"),
        (lambda: CommandDelay(periods=6), "periods must be whole numbers from 1 to 5"),
        (lambda: CommandDelay(periods=(1, 6)), "periods must be whole numbers from 1 to 5"),
        (lambda: CommandDelay(periods=(0, 2)), "periods must be whole numbers from 1 to 5"),
        (lambda: CommandDelay(periods=1.5), "periods must be whole numbers from 1 to 5"),
        (lambda: CommandDelay(periods=(1, 2.5)), "periods must be whole numbers from 1 to 5"),
        (lambda: CommandDelay(periods=-1), "periods must be whole numbers from 1 to 5"),
        (lambda: CommandDelay(periods=math.nan), "periods must be finite"),
        (lambda: GyroBiasStep(size=-1e-4), "size must not be negative"),
        (lambda: GyroBiasStep(size=(-1e-4, 1e-4)), "size must not be negative"),
        (lambda: GyroBiasStep(size=math.nan), "size must be finite"),
        (lambda: AttitudeSpike(angle=-0.1), r"angle must stay within \[0, pi\]"),
        (lambda: AttitudeSpike(angle=(1.0, 3.2)), r"angle must stay within \[0, pi\]"),
        (lambda: AttitudeSpike(angle=math.inf), "angle must be finite"),
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
    DriftingEffectiveness(effectiveness=(0.0, 1.0), rise=1e-3)
    FrictionRise(factor=1.0, rise=0.0)
    CommandDelay(periods=(1, 5))
    CommandDelay(periods=5.0)
    AttitudeSpike(angle=(0.0, math.pi))
    GyroBiasStep(size=0.0)
    FaultDistribution(kinds=(Bias(),), severity=0)
    FaultDistribution(kinds=(Bias(),), severity=1)


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
        (lambda: FaultDistribution(kinds=(Bias(),), severity=-0.1), r"severity must be within \[0, 1\], got -0.1"),
        (lambda: FaultDistribution(kinds=(Bias(),), severity=1.1), r"severity must be within \[0, 1\], got 1.1"),
        (lambda: FaultDistribution(kinds=(Bias(),), severity=math.nan), "severity must be finite"),
        (lambda: FaultDistribution(kinds=(Bias(),), severity=None), "severity must be a number"),
        (lambda: FaultDistribution(kinds=(SensorFault(),)), "kinds must hold Fault objects of a concrete kind"),
        (lambda: FaultDistribution(kinds=(Bias,)), "kinds must hold Fault objects of a concrete kind"),
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
    with pytest.raises(ValueError, match="fault_counts must not exceed the 2 wheels of the spacecraft"):
        source.check(WheelArray(np.eye(3)[:, :2], 0.2))


def test_a_scheduled_wheel_that_does_not_exist_is_refused():
    FaultSchedule((Outage(wheel=3),)).check(WheelArray.sign_pyramid(0.2, None))
    with pytest.raises(ValueError, match="wheel must be below the number of wheels, 4"):
        FaultSchedule((Outage(wheel=4),)).check(WheelArray.sign_pyramid(0.2, None))


@pytest.mark.parametrize("kind", [HardOver, Seizure])
def test_what_is_measured_in_torque_limits_needs_one(kind):
    with pytest.raises(ValueError, match=f"{kind.__name__} needs wheels with a torque limit; torque_limit"):
        FaultSchedule((kind(wheel=0),)).draw(np.zeros((1, 14)), np.zeros((1, 0)), np.array([np.inf]))


def test_faults_of_the_sensors_name_no_wheel():
    FaultSchedule((GyroBiasStep(), AttitudeSpike(), StarTrackerOutage())).check(WheelArray(np.eye(3), 0.2))
    source = FaultDistribution((GyroBiasStep(), Outage()), fault_counts=(0.0, 0.0, 1.0))
    source.check(WheelArray(np.eye(3)[:, :2], 0.2))
    with pytest.raises(TypeError):
        GyroBiasStep(wheel=1)


def test_the_base_class_is_no_fault():
    for base in (Fault(), WheelFault(wheel=0), SensorFault()):
        with pytest.raises(ValueError, match="faults must hold Fault objects of a concrete kind"):
            FaultSchedule((base,))


def test_kinds_have_distinct_labels():
    assert FaultKind.NONE.label == "healthy"
    assert FaultKind.LOCK_IN_PLACE.label == "lock in place"
    assert len({kind.label for kind in FaultKind}) == len(FaultKind)
    assert sorted(kind.kind for kind in KINDS) == sorted(set(FaultKind) - {FaultKind.NONE})
