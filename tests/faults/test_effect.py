"""`fault_effect`, the truth for oracles and plots, against hand calculation."""

import numpy as np
import pytest

from ftac_gym import faults
from ftac_gym.spacecraft import Friction, WheelArray

ONE_WHEEL = WheelArray(np.eye(3)[:, :1], 0.2)


def whole_effect_of(*listed, times, last=0.0, momentum=0.0, array=ONE_WHEEL):
    """Effect at several times on a spacecraft with one wheel."""
    schedule, wheels = faults.FaultSchedule(listed), array.count
    drawn = schedule.draw(np.zeros((1, schedule.uniform_count(wheels))), np.zeros((1, 0)), array.torque_limits)
    times = np.atleast_1d(np.asarray(times, dtype=float))
    drawn = drawn.take(np.zeros(len(times), dtype=int))
    spinning, applied = np.full((len(times), wheels), momentum), np.full((len(times), wheels), last)
    return faults.fault_effect(drawn, times, array, spinning, applied)


def effect_of(*listed, times, last=0.0):
    """Effectiveness and bias of wheel 0 at several times."""
    effect = whole_effect_of(*listed, times=times, last=last)
    return effect.effectiveness[:, 0], effect.bias[:, 0]


def test_healthy_wheels_follow_commands():
    wheels, times = WheelArray.sign_pyramid(0.2, None), np.array([0.0, 1.0, 1e6])
    drawn = faults.FaultSchedule(()).draw(np.zeros((3, 1)), np.zeros((3, 0)), wheels.torque_limits)
    effect = faults.fault_effect(drawn, times, wheels, np.ones((3, 4)), np.ones((3, 4)))
    assert np.all(effect.effectiveness == 1.0) and np.all(effect.bias == 0.0) and np.all(effect.delay == 0)
    assert np.all(effect.rate_bias == 0.0) and np.all(effect.attitude_turn == 0.0)
    assert not effect.star_tracker_out.any()


def test_a_fault_acts_from_onset_to_recovery():
    times = [0.0, 1.98, 2.0, 2.5, 2.98, 3.0, 9.0]
    effectiveness, bias = effect_of(faults.Bias(wheel=0, onset=2.0, recovery=3.0, constant=0.1), times=times)
    np.testing.assert_allclose(bias, [0.0, 0.0, 0.1, 0.1, 0.1, 0.0, 0.0])
    assert np.all(effectiveness == 1.0)


def test_an_intermittent_fault_acts_at_the_start_of_each_period():
    fault = faults.Outage(wheel=0, onset=1.0, period=0.5, on_time=0.2, recovery=2.1)
    times = [0.9, 1.0, 1.1, 1.2, 1.4, 1.5, 1.68, 1.7, 2.0, 2.1]
    np.testing.assert_allclose(effect_of(fault, times=times)[0], [1, 0, 0, 1, 1, 0, 0, 1, 0, 1])


def test_rounding_of_the_time_does_not_shift_an_event():
    fault = faults.Outage(wheel=0, onset=0.3, period=0.1, on_time=0.05)
    times = np.arange(31, 60) * 0.1  # 0.30000000000000004 and the like
    assert np.all(effect_of(fault, times=times)[0] == 0.0)


def test_effectiveness_swings_with_the_time_of_the_episode():
    fault = faults.LossOfEffectiveness(wheel=0, onset=2.0, effectiveness=0.6, amplitude=0.3, frequency=0.7, phase=0.4)
    times = np.array([1.0, 2.0, 5.5])
    expected = np.where(times < 2.0, 1.0, 0.6 + 0.3 * np.sin(0.7 * times + 0.4))
    np.testing.assert_allclose(effect_of(fault, times=times)[0], expected)


def test_bias_grows_and_swings_with_the_time_since_onset():
    fault = faults.Bias(
        wheel=0, onset=2.0, constant=0.01, slope=0.002, amplitude=0.3, exponent=1.5, frequency=0.7, phase=0.4
    )
    times = np.array([1.0, 2.0, 5.5])
    since = np.maximum(times - 2.0, 0.0)
    expected = np.where(times < 2.0, 0.0, 0.01 + 0.002 * since + 0.3 * since**1.5 * np.sin(0.7 * since + 0.4))
    np.testing.assert_allclose(effect_of(fault, times=times)[1], expected)


def test_layers_multiply_their_effectiveness_and_add_their_bias():
    effectiveness, bias = effect_of(
        faults.LossOfEffectiveness(wheel=0, effectiveness=0.5),
        faults.LossOfEffectiveness(wheel=0, effectiveness=0.4),
        faults.Bias(wheel=0, constant=0.1),
        faults.Bias(wheel=0, constant=-0.03),
        times=1.0,
    )
    np.testing.assert_allclose([effectiveness[0], bias[0]], [0.2, 0.07])


def test_a_locked_wheel_repeats_its_torque_whatever_else_is_wrong():
    effectiveness, bias = effect_of(
        faults.LockInPlace(wheel=0), faults.Bias(wheel=0, constant=0.1), times=1.0, last=-0.07
    )
    assert effectiveness[0] == 0.0 and bias[0] == -0.07


def test_hard_over_ignores_the_command():
    effectiveness, bias = effect_of(faults.HardOver(wheel=0, fraction=0.5, random_sign=False), times=1.0)
    assert effectiveness[0] == 0.0 and bias[0] == pytest.approx(0.1)


def test_a_fault_grows_from_its_onset():
    times = [1.0, 2.0, 2.5, 4.0, 6.0, 50.0]
    grown = np.array([0.0, 0.0, 0.125, 0.5, 1.0, 1.0])
    fault = faults.LossOfEffectiveness(wheel=0, onset=2.0, rise=4.0, effectiveness=0.2)
    np.testing.assert_allclose(effect_of(fault, times=times)[0], 1.0 - 0.8 * grown)
    drift = faults.DriftingEffectiveness(wheel=0, onset=2.0, rise=4.0, effectiveness=0.2)
    np.testing.assert_allclose(effect_of(drift, times=times)[0], 1.0 - 0.8 * grown)
    bias = faults.Bias(wheel=0, onset=2.0, rise=4.0, constant=0.1, slope=0.01)
    expected = grown * (0.1 + 0.01 * np.maximum(np.array(times) - 2.0, 0.0))
    np.testing.assert_allclose(effect_of(bias, times=times)[1], expected)


def test_a_fault_shrinks_before_its_end():
    times = [2.0, 4.0, 5.0, 7.0, 7.9, 8.0, 9.0]
    left = np.array([1.0, 1.0, 0.75, 0.25, 0.025, 0.0, 0.0])
    for end in ({"recovery": 8.0}, {"duration": 6.0}):
        fault = faults.Outage(wheel=0, onset=2.0, fall=4.0, **end)
        np.testing.assert_allclose(effect_of(fault, times=times)[0], 1.0 - left, atol=1e-12)


def test_a_fault_may_end_before_it_is_all_there():
    times = [2.0, 4.0, 4.99, 5.0, 6.0]
    abrupt = faults.Bias(wheel=0, onset=2.0, rise=10.0, recovery=5.0, constant=1.0)
    np.testing.assert_allclose(effect_of(abrupt, times=times)[1], [0.0, 0.2, 0.299, 0.0, 0.0])
    # Where growing and shrinking overlap, the smaller part counts.
    both = faults.Bias(wheel=0, onset=2.0, rise=10.0, recovery=5.0, fall=2.0, constant=1.0)
    np.testing.assert_allclose(effect_of(both, times=times)[1], [0.0, 0.2, 0.005, 0.0, 0.0], atol=1e-12)
    longer = faults.Bias(wheel=0, onset=2.0, recovery=5.0, fall=6.0, constant=1.0)
    np.testing.assert_allclose(effect_of(longer, times=times)[1], [0.5, 1.0 / 6.0, 0.01 / 6.0, 0.0, 0.0], atol=1e-12)


def test_an_intermittent_fault_goes_on_growing_while_it_rests():
    fault = faults.Bias(wheel=0, onset=1.0, rise=4.0, period=2.0, on_time=0.5, constant=1.0)
    times = [1.0, 1.2, 1.6, 3.0, 3.4, 3.5, 5.0, 7.2, 7.5]
    np.testing.assert_allclose(effect_of(fault, times=times)[1], [0.0, 0.05, 0.0, 0.5, 0.6, 0.0, 1.0, 1.0, 0.0])


def test_the_longest_delay_of_a_wheel_counts():
    delays = (
        faults.CommandDelay(wheel=0, periods=3, onset=1.0, recovery=3.0),
        faults.CommandDelay(wheel=0, periods=2, onset=2.0),
    )
    for order in (delays, delays[::-1]):
        effect = whole_effect_of(*order, times=[0.5, 1.0, 2.5, 3.0])
        np.testing.assert_array_equal(effect.delay[:, 0], [0, 3, 3, 2])
        assert np.all(effect.effectiveness == 1.0) and np.all(effect.bias == 0.0)


def test_excess_friction_is_bias():
    array = WheelArray(np.eye(3)[:, :1], 0.2, spin_inertia=0.02, friction=Friction(0.01, 0.013, viscous=1e-4))
    for momentum, factor in ((2.0, 5.0), (-2.0, 3.0)):
        dry = array.frictions[0].dry(momentum / 0.02)
        forward = faults.FrictionRise(wheel=0, onset=1.0, rise=4.0, factor=5.0, direction="forward")
        backward = faults.FrictionRise(wheel=0, onset=1.0, rise=4.0, factor=3.0, direction="backward")
        both = faults.FrictionRise(wheel=0, onset=1.0, rise=0.0, factor=2.0)
        effect = whole_effect_of(forward, backward, times=[0.5, 3.0, 9.0], momentum=momentum, array=array)
        np.testing.assert_allclose(effect.bias[:, 0], [0.0, 0.5 * (factor - 1.0) * dry, (factor - 1.0) * dry])
        layered = whole_effect_of(forward, backward, both, times=9.0, momentum=momentum, array=array)
        np.testing.assert_allclose(layered.bias[0, 0], (2.0 * factor - 1.0) * dry)
        assert np.sign(effect.bias[-1, 0]) == np.sign(momentum)  # drag slows the wheel and pushes the body along


def test_a_seized_wheel_cannot_change_its_torque():
    effectiveness, bias = effect_of(faults.Seizure(wheel=0, onset=1.0), times=[0.5, 1.0, 9.0], last=-0.07)
    np.testing.assert_array_equal(effectiveness, [1.0, 0.0, 0.0])
    np.testing.assert_array_equal(bias, [0.0, -0.07, -0.07])


def test_faults_of_the_sensors_add_up():
    gyro = faults.GyroBiasStep(onset=1.0, rise=2.0, size=0.01), faults.GyroBiasStep(onset=2.0, recovery=4.0, size=0.03)
    spike = faults.AttitudeSpike(onset=1.0, period=1.0, on_time=0.5, angle=0.4)
    out = faults.StarTrackerOutage(onset=2.0, duration=1.5)
    effect = whole_effect_of(*gyro, spike, out, times=[0.5, 2.0, 2.75, 3.0, 4.5])
    # All directions are the same here: uniform deviates of zero.
    np.testing.assert_allclose(np.linalg.norm(effect.rate_bias, axis=1), [0.0, 0.035, 0.03875, 0.04, 0.01])
    np.testing.assert_allclose(np.linalg.norm(effect.attitude_turn, axis=1), [0.0, 0.4, 0.0, 0.4, 0.0])
    np.testing.assert_array_equal(effect.star_tracker_out, [False, True, True, True, False])
    assert np.all(effect.effectiveness == 1.0) and np.all(effect.bias == 0.0)
