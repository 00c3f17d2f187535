"""The severity of a fault distribution: from healthy spacecraft to the faults as described, growing in between."""

import dataclasses

import numpy as np
import pytest

from ftac_gym import faults, scenarios
from ftac_gym.faults.table import no_faults, no_sensor_faults
from ftac_gym.spacecraft import Friction, WheelArray

FLAGSHIP = scenarios.get("flagship")
WHEELS = WheelArray(FLAGSHIP.spacecraft.wheels.axes, 0.2, 12.0, spin_inertia=0.02, friction=Friction(0.01))
SPACECRAFT = dataclasses.replace(FLAGSHIP.spacecraft, wheels=WHEELS)
GRADUAL = [
    faults.LossOfEffectiveness(effectiveness=(0.2, 0.6), amplitude=(0.1, 0.2), frequency=1.0, phase=(0.0, 6.0)),
    faults.DriftingEffectiveness(onset=(1.0, 5.0), rise=(5.0, 9.0), effectiveness=(0.0, 0.4)),
    faults.Bias(onset=(1.0, 9.0), constant=(0.02, 0.05), slope=1e-3, amplitude=0.03, frequency=0.4, random_sign=True),
    faults.Bias(slope=(1e-3, 2e-3), duration=20.0, rise=2.0, fall=4.0, period=3.0, on_time=(1.0, 2.0)),
    faults.Outage(onset=(1.0, 9.0)),
    faults.HardOver(fraction=(0.3, 0.6)),
    faults.FrictionRise(factor=(2.0, 20.0), direction="either", rise=(1.0, 5.0)),
    faults.IntermittentShutdown(),
    faults.GyroBiasStep(size=(1e-4, 2e-4), onset=(1.0, 9.0)),
    faults.AttitudeSpike(angle=(0.1, 0.2), period=(3.0, 4.0), on_time=0.5),
]
WHOLE = [faults.LockInPlace(onset=(1.0, 9.0)), faults.Seizure(), faults.CommandDelay(), faults.StarTrackerOutage()]
MAGNITUDES = (
    "effectiveness",
    "effectiveness_amplitude",
    "bias",
    "bias_slope",
    "bias_amplitude",
    "friction_forward",
    "friction_backward",
    "rate_bias",
    "attitude_turn",
)


def of_kind(fault):
    return type(fault).__name__


def drawn(listed, severity, count=400, **fields):
    source = faults.FaultDistribution(tuple(listed), severity=severity, **fields)
    return FLAGSHIP.replace(spacecraft=SPACECRAFT, faults=source).draw(3, count)


def everything(severity, count=400):
    return drawn([kind(onset=(2.0, 80.0)) for kind in faults.KINDS], severity, count, fault_counts=(0.1, 0.4, 0.3, 0.2))


def assert_healthy(episodes):
    assert np.all(episodes.faults == no_faults(1, 1)[0, 0, 0])
    assert np.all(episodes.sensor_faults == no_sensor_faults(1, 1)[0, 0])
    assert np.all(np.isposinf(episodes.first_onset))


def test_the_lists_cover_every_kind():
    assert {type(fault) for fault in GRADUAL + WHOLE} == set(faults.KINDS)


@pytest.mark.parametrize("fault", GRADUAL + WHOLE, ids=of_kind)
def test_severity_zero_is_healthy(fault):
    assert_healthy(drawn([fault], 0.0, 50))


def test_severity_zero_of_everything_is_the_healthy_scenario():
    episodes = everything(0.0)
    assert_healthy(episodes)
    assert episodes.feasible.mean() > 0.9
    plain = FLAGSHIP.replace(spacecraft=SPACECRAFT, faults=None).draw(3, 400)
    np.testing.assert_array_equal(episodes.feasible, plain.feasible)


def test_severity_one_is_what_the_kinds_say():
    kinds = tuple(kind(onset=(2.0, 80.0)) for kind in faults.KINDS)
    plain = faults.FaultDistribution(kinds, fault_counts=(0.1, 0.4, 0.3, 0.2))
    without = FLAGSHIP.replace(spacecraft=SPACECRAFT, faults=plain).draw(3, 400)
    for name, array in everything(1.0).arrays().items():
        np.testing.assert_array_equal(array, without.arrays()[name], err_msg=name)


@pytest.mark.parametrize("severity", [0.25, 0.7])
@pytest.mark.parametrize("fault", GRADUAL, ids=of_kind)
def test_magnitudes_shrink_in_proportion(fault, severity):
    whole, part = drawn([fault], 1.0), drawn([fault], severity)
    np.testing.assert_array_equal(part.switches, whole.switches)
    for small, large, healthy in (
        (part.faults, whole.faults, no_faults(1, 1)[0, 0, 0]),
        (part.sensor_faults, whole.sensor_faults, no_sensor_faults(1, 1)[0, 0]),
    ):
        np.testing.assert_array_equal(small["kind"] > 0, large["kind"] > 0)
        for name in small.dtype.names:
            expected = large[name]
            if name in MAGNITUDES:
                expected = healthy[name] + severity * (large[name] - healthy[name])
            np.testing.assert_allclose(small[name], expected, rtol=1e-12, err_msg=name)


@pytest.mark.parametrize("fault", GRADUAL, ids=of_kind)
def test_what_a_fault_does_shrinks_in_proportion(fault):
    random = np.random.default_rng(0)
    time, momentum = random.uniform(0.0, 40.0, 400), random.uniform(-2.0, 2.0, (400, 4))
    none = np.zeros((400, 4))
    whole, part = (
        faults.fault_effect(drawn([fault], severity).drawn_faults, time, WHEELS, momentum, none)
        for severity in (1.0, 0.4)
    )
    np.testing.assert_allclose(1.0 - part.effectiveness, 0.4 * (1.0 - whole.effectiveness), atol=1e-12)
    for name in ("bias", "rate_bias", "attitude_turn"):
        np.testing.assert_allclose(getattr(part, name), 0.4 * getattr(whole, name), atol=1e-12)
    changes = [1.0 - whole.effectiveness, whole.bias, whole.rate_bias, whole.attitude_turn]
    assert any(np.abs(change).max() > 0.0 for change in changes)


@pytest.mark.parametrize("fault", WHOLE, ids=of_kind)
def test_what_is_there_whole_or_not_at_all_becomes_rarer(fault):
    whole = drawn([fault], 1.0, 2000)
    before = np.zeros(2000, dtype=bool)
    for severity in (0.1, 0.3, 0.6, 0.9, 1.0):
        episodes = drawn([fault], severity, 2000)
        affected = np.isfinite(episodes.first_onset)
        assert np.all(affected[before])  # the same seed only adds faults
        assert affected.mean() == pytest.approx(severity, abs=0.04)
        for part, all_of_it in zip(episodes[affected].drawn_faults, whole[affected].drawn_faults, strict=True):
            np.testing.assert_array_equal(part, all_of_it)
        assert_healthy(episodes[~affected])
        before = affected


def test_episodes_of_a_seed_grow_worse_monotonically():
    worst, before, possible = everything(1.0), None, None
    for severity in (0.0, 0.05, 0.2, 0.5, 0.8, 0.99, 1.0):
        episodes = everything(severity)
        for now, end in ((episodes.faults, worst.faults), (episodes.sensor_faults, worst.sensor_faults)):
            affected = now["kind"] > 0
            np.testing.assert_array_equal(now["kind"][affected], end["kind"][affected])
            np.testing.assert_array_equal(now["onset"][affected], end["onset"][affected])
        there = np.concatenate([episodes.faults["kind"][:, :, 0], episodes.sensor_faults["kind"]], axis=1) > 0
        assert before is None or (there | ~before).all()
        assert possible is None or (possible | ~episodes.feasible).all()
        before, possible = there, episodes.feasible
        for name in ("initial", "inertia", "disturbance", "sensors", "key", "index"):
            np.testing.assert_array_equal(episodes.arrays()[name], worst.arrays()[name])
    assert there.any(axis=1).mean() == pytest.approx(0.9, abs=0.06)


def test_a_fault_that_is_thinned_out_leaves_the_others_of_its_episode():
    """With two faults per episode, the second stays what and where it is, whether or not the first is there."""
    listed = [faults.LockInPlace(onset=(1.0, 9.0)), faults.Bias(onset=(1.0, 9.0), constant=0.1)]
    whole, part = (drawn(listed, severity, 1000, fault_counts=(0.0, 0.0, 1.0)) for severity in (1.0, 0.3))
    there, biased = part.faults["kind"] > 0, whole.faults["kind"] == faults.Bias.kind
    np.testing.assert_array_equal(there[biased], True)
    np.testing.assert_allclose(part.faults["bias"][biased], 0.03)
    np.testing.assert_array_equal(part.faults["onset"][there], whole.faults["onset"][there])
    locked = whole.faults["kind"] == faults.LockInPlace.kind
    assert there[locked].mean() == pytest.approx(0.3, abs=0.05)
    # Each of the two faults is there with probability 1/2 + 1/2 * 0.3, independently.
    counts = np.bincount(there.sum(axis=(1, 2)), minlength=3) / 1000
    assert counts == pytest.approx([0.35**2, 2.0 * 0.35 * 0.65, 0.65**2], abs=0.05)


def test_a_lock_that_occurs_is_impossible_or_not_at_any_severity():
    """The label looks at the effectiveness of a wheel; that of a locked one is zero at any severity."""
    listed, counts = [faults.LockInPlace(onset=(1.0, 9.0))], (0.0, 0.0, 0.0, 0.0, 1.0)
    episodes = drawn(listed, 0.6, 300, fault_counts=counts)
    locked = (episodes.faults["kind"] > 0).sum(axis=(1, 2))
    assert not episodes.feasible[locked >= 2].any()  # two wheels cannot turn a body about three axes
    assert episodes.feasible[locked == 0].all()
    assert set(locked) == {0, 1, 2, 3, 4}


@pytest.mark.parametrize("severity", [0.0, 0.5])
def test_severity_changes_no_shape(severity):
    """So that a running simulator can go on with episodes of another severity."""
    for name, array in everything(severity, 5).arrays().items():
        other = everything(1.0, 5).arrays()[name]
        assert array.shape == other.shape and array.dtype == other.dtype
