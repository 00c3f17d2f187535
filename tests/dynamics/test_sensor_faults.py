"""Measurements under sensor faults: steps of the gyro bias, spikes and outages of the star tracker."""

import dataclasses
from itertools import pairwise

import numpy as np
import pytest

from ftac_gym import attitude as att
from ftac_gym.dynamics import Simulator
from ftac_gym.faults import AttitudeSpike, FaultDistribution, FaultSchedule, GyroBiasStep, StarTrackerOutage
from ftac_gym.spacecraft.spacecraft import Spacecraft
from ftac_gym.spacecraft.wheel_array import WheelArray
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.scenario import Scenario
from ftac_gym.task.sensors import SensorErrors

PERIOD, CRAFT = 0.1, 20  # s
NOISE = SensorErrors(attitude_noise=1e-4, rate_noise=2e-5, gyro_bias=(-1e-5, 1e-5), gyro_bias_walk=1e-6)


def craft(*faults, **changes):
    fields = {
        "name": "sensors",
        "spacecraft": Spacecraft(
            np.array([[10.0, 1.2, 0.5], [1.2, 19.0, 1.5], [0.5, 1.5, 25.0]]), WheelArray(np.eye(3), 0.2)
        ),
        "initial_state": InitialState(max_rate=0.2),
        "faults": FaultSchedule(faults),
        "control_period": PERIOD,
        "physics_step": 0.02,
        "duration": 20.0,
    }
    return Scenario(**{**fields, **changes})


class Flight:
    """True and measured states (T + 1, N, ...) of an open-loop flight, with the errors of the measurement."""

    def __init__(self, scenario, steps=100, command=0.1, count=CRAFT):
        self.episodes = scenario.draw(0, count)
        simulator = Simulator(scenario, count)
        simulator.reset(self.episodes)
        random, rows = np.random.default_rng(0), []
        for step in range(steps + 1):
            if step:
                simulator.step(random.uniform(-command, command, (count, 3)))
            measured, state = simulator.measurement(), simulator.state
            true = state.attitude.copy(), state.rate.copy()
            rows.append((*true, measured.attitude, measured.rate, measured.star_tracker_valid))
        columns = [np.array(column) for column in zip(*rows, strict=True)]
        self.true_attitude, self.true_rate, self.attitude, self.rate, self.valid = columns
        self.time = np.arange(steps + 1) * PERIOD
        self.rate_error = self.rate - self.true_rate
        self.turn = att.rotation_vector_from_quaternion(att.quaternion_error(self.attitude, self.true_attitude))


# ------------------------------------------------------------------------------------------------------------- gyros


@pytest.mark.parametrize("sensors", [None, NOISE], ids=["perfect", "noisy"])
def test_a_bias_step_adds_to_the_rate_alone(sensors):
    step = GyroBiasStep(onset=2.0, size=(1e-3, 2e-3), rise=3.0, duration=6.0, fall=2.0)
    faulty, plain = Flight(craft(step, sensors=sensors)), Flight(craft(sensors=sensors))
    part = np.clip(np.minimum((faulty.time - 2.0) / 3.0, (8.0 - faulty.time) / 2.0), 0.0, 1.0)
    bias = faulty.episodes.sensor_faults["rate_bias"][:, 0]
    expected = part[:, None, None] * bias
    np.testing.assert_allclose(faulty.rate - plain.rate, expected, rtol=0.0, atol=1e-15)
    np.testing.assert_array_equal(faulty.attitude, plain.attitude)
    assert faulty.valid.all()
    assert np.abs(faulty.rate - plain.rate).max() > 5e-4


def test_an_abrupt_bias_step_is_there_from_its_onset_on():
    flight = Flight(craft(GyroBiasStep(onset=2.05, size=1e-3)), steps=40)
    seen = np.linalg.norm(flight.rate_error, axis=2)
    np.testing.assert_allclose(seen, np.where(flight.time > 2.05, 1e-3, 0.0)[:, None] * np.ones(CRAFT), atol=1e-15)


def test_steps_add_up_and_may_come_and_go():
    first, second = GyroBiasStep(size=1e-3, period=1.0, on_time=0.3), GyroBiasStep(onset=1.5, size=2e-3)
    flight = Flight(craft(first, second), steps=50)
    bias = flight.episodes.sensor_faults["rate_bias"]
    window = ((flight.time + 1e-9) % 1.0 < 0.3 - 1e-6)[:, None, None]
    expected = window * bias[:, 0] + (flight.time > 1.45)[:, None, None] * bias[:, 1]
    np.testing.assert_allclose(flight.rate_error, expected, rtol=0.0, atol=1e-15)


def test_misaligned_gyros_turn_the_rate_to_first_order():
    angle = 0.02
    flight = Flight(craft(sensors=SensorErrors(gyro_misalignment=angle), faults=None))
    tilt = flight.episodes.sensors["gyro_misalignment"]
    np.testing.assert_allclose(np.linalg.norm(tilt, axis=1), angle)
    turned = att.rotate_to_reference(att.quaternion_from_rotation_vector(tilt), flight.true_rate)
    speed = np.linalg.norm(flight.true_rate, axis=2, keepdims=True)
    assert np.linalg.norm((turned - flight.rate) / speed, axis=2).max() < 0.51 * angle**2
    assert np.linalg.norm(flight.rate_error / speed, axis=2).max() > 0.9 * angle  # it is not lost within the bound
    # The error is the angle times the part of the rate across the axis, and lies across both.
    axis = tilt / angle
    across = np.linalg.norm(np.cross(axis, flight.true_rate), axis=2)
    np.testing.assert_allclose(np.linalg.norm(flight.rate_error, axis=2), angle * across, rtol=1e-9)
    for vector in (np.broadcast_to(axis, flight.rate.shape), flight.true_rate):
        np.testing.assert_allclose(np.sum(vector * flight.rate_error, axis=2), 0.0, atol=1e-15)
    np.testing.assert_array_equal(flight.attitude, Flight(craft(faults=None)).attitude)


def test_misalignment_and_bias_step_add_up():
    errors, step = SensorErrors(gyro_misalignment=(0.01, 0.02)), GyroBiasStep(onset=1.0, size=1e-3)
    both, tilted, stepped = (
        Flight(craft(*faults, sensors=sensors)).rate_error
        for faults, sensors in (((step,), errors), ((), errors), ((step,), None))
    )
    np.testing.assert_allclose(both, tilted + stepped, rtol=0.0, atol=1e-15)


# ------------------------------------------------------------------------------------------------------------ spikes


def test_a_spike_turns_the_attitude_exactly_and_periodically():
    flight = Flight(craft(AttitudeSpike(onset=1.0, angle=(0.01, 3.0), period=0.7, on_time=0.2)))
    inside = (flight.time > 0.95) & ((flight.time - 1.0 + 1e-6) % 0.7 < 0.2 - 1e-3)
    assert np.flatnonzero(inside).tolist()[:6] == [10, 11, 17, 18, 24, 25]
    turn = flight.episodes.sensor_faults["attitude_turn"][:, 0]
    np.testing.assert_allclose(flight.turn, inside[:, None, None] * turn, rtol=0.0, atol=1e-12)
    np.testing.assert_array_equal(flight.rate, flight.true_rate)
    np.testing.assert_allclose(np.linalg.norm(flight.attitude, axis=2), 1.0, atol=1e-15)
    assert flight.valid.all()


def test_tiny_spikes_are_exact_too():
    flight = Flight(craft(AttitudeSpike(angle=(1e-9, 1e-4))), steps=1, count=50)
    turn = flight.episodes.sensor_faults["attitude_turn"][:, 0]
    np.testing.assert_allclose(flight.turn[1], turn, rtol=0.0, atol=1e-15)


def test_spikes_grow_and_add_up_as_rotation_vectors():
    flight = Flight(craft(AttitudeSpike(onset=1.0, angle=0.5, rise=2.0), AttitudeSpike(onset=2.0, angle=(0.1, 0.3))))
    first, second = np.moveaxis(flight.episodes.sensor_faults["attitude_turn"], 1, 0)
    grown = np.clip((flight.time - 1.0) / 2.0, 0.0, 1.0)[:, None, None]
    expected = grown * first + (flight.time > 1.95)[:, None, None] * second
    np.testing.assert_allclose(flight.turn, expected, rtol=0.0, atol=1e-12)


def test_a_spike_comes_on_top_of_the_noise():
    """The noise turns first and is the same as without the spike."""
    spiked, plain = Flight(craft(AttitudeSpike(onset=1.0, angle=0.2), sensors=NOISE)), Flight(craft(sensors=NOISE))
    jump = att.rotation_vector_from_quaternion(att.quaternion_error(spiked.attitude, plain.attitude))
    turn = spiked.episodes.sensor_faults["attitude_turn"][:, 0]
    np.testing.assert_allclose(jump[10:], np.broadcast_to(turn, jump[10:].shape), rtol=0.0, atol=1e-12)
    np.testing.assert_array_equal(spiked.attitude[:10], plain.attitude[:10])


# ----------------------------------------------------------------------------------------------------------- outages


def carried(start, rates):
    """Carry attitudes (N, 4) forward with the mean of successive rates (T + 1, N, 3); returns (T + 1, N, 4)."""
    rows = [start]
    for before, after in pairwise(rates):
        turn = att.quaternion_from_rotation_vector(0.5 * PERIOD * (before + after))
        rows.append(att.quaternion_product(rows[-1], turn))
    return np.array(rows)


@pytest.mark.parametrize("sensors", [None, NOISE], ids=["perfect", "noisy"])
def test_the_valid_flag_tells_when_the_star_tracker_is_out(sensors):
    flight = Flight(craft(StarTrackerOutage(onset=2.0, duration=3.0), sensors=sensors))
    np.testing.assert_array_equal(flight.valid, np.tile((flight.time < 1.95) | (flight.time > 4.95), (CRAFT, 1)).T)


@pytest.mark.parametrize("misalignment", [0.0, 0.05])
def test_in_an_outage_the_gyros_carry_the_last_measured_attitude_forward(misalignment):
    sensors = dataclasses.replace(NOISE, attitude_noise=5e-3, rate_noise=1e-3, gyro_misalignment=misalignment)
    outage, step = StarTrackerOutage(onset=2.0, duration=3.0), GyroBiasStep(onset=3.0, size=1e-2)
    flight, plain = Flight(craft(step, outage, sensors=sensors)), Flight(craft(step, sensors=sensors))
    # From the last measurement before the outage, tick 19, to the last one within it, tick 49.
    expected = carried(flight.attitude[19], flight.rate[19:50])
    np.testing.assert_allclose(flight.attitude[19:50], expected, rtol=0.0, atol=1e-13)
    np.testing.assert_array_equal(flight.rate, plain.rate)
    for ticks in (slice(0, 20), slice(50, None)):  # before and after as if nothing had been
        np.testing.assert_array_equal(flight.attitude[ticks], plain.attitude[ticks])
    # While it lasts there is no noise of the star tracker, and the errors of the gyros pile up.
    drift = np.linalg.norm(flight.turn, axis=2)
    assert np.median(drift[49]) > 0.015 and np.median(drift[55]) < 0.012


def test_perfect_gyros_stay_close_to_the_truth():
    flight = Flight(craft(StarTrackerOutage(onset=1.0)), steps=150)
    assert np.abs(flight.true_rate).max() > 0.1
    error = np.linalg.norm(flight.turn, axis=2)
    assert not flight.valid[-1].any()
    assert error[:10].max() < 1e-12
    assert 0.0 < error.max() < 5e-5


def test_perfect_gyros_are_exact_for_a_steady_spin():
    scenario = craft(
        StarTrackerOutage(onset=1.0), initial_state=InitialState.fixed(rate=(0.0, 0.3, 0.0)),
        spacecraft=Spacecraft(np.diag([10.0, 12.0, 14.0]), WheelArray(np.eye(3), 0.2)),
    )  # fmt: skip
    flight = Flight(scenario, command=0.0, count=1, steps=150)
    assert np.linalg.norm(flight.turn, axis=2).max() < 1e-10


def test_a_gyro_bias_turns_the_carried_attitude_away_at_its_own_rate():
    at_rest = craft(
        StarTrackerOutage(onset=2.0, recovery=12.0), GyroBiasStep(onset=4.0, size=1e-3),
        initial_state=InitialState.fixed(),
    )  # fmt: skip
    flight = Flight(at_rest, command=0.0, steps=150)
    drift = np.linalg.norm(flight.turn, axis=2)
    # The mean of two rates: half the bias counts for the period in which it sets in.
    expected = np.where(flight.time < 11.95, 1e-3 * np.maximum(flight.time - 3.95, 0.0), 0.0)
    expected[flight.time < 3.98] = 0.0
    np.testing.assert_allclose(drift, np.tile(expected, (CRAFT, 1)).T, rtol=0.0, atol=1e-10)


def test_an_outage_from_the_start_begins_with_a_measurement():
    flight = Flight(craft(StarTrackerOutage(), sensors=NOISE), steps=30)
    assert not flight.valid.any()
    assert np.linalg.norm(flight.turn[0], axis=1).min() > 0.0
    assert np.linalg.norm(flight.turn[0], axis=1).max() < 6e-4
    np.testing.assert_allclose(flight.attitude, carried(flight.attitude[0], flight.rate), rtol=0.0, atol=1e-13)


def test_what_is_not_measured_cannot_spike():
    outage, spike = StarTrackerOutage(onset=2.0, duration=3.0), AttitudeSpike(onset=2.5, angle=0.5, duration=1.0)
    np.testing.assert_array_equal(Flight(craft(outage, spike)).attitude, Flight(craft(outage)).attitude)
    # But a spike just before is what the gyros carry forward.
    early = Flight(craft(outage, AttitudeSpike(onset=1.5, angle=0.5, duration=1.0)))
    np.testing.assert_allclose(np.linalg.norm(early.turn[15:50], axis=2), 0.5, atol=1e-3)
    assert np.linalg.norm(early.turn[50:], axis=2).max() < 1e-12


def test_outages_at_random():
    scenario = craft(StarTrackerOutage(onset=1.0, mean_acting=1.0, mean_resting=2.0))
    flight = Flight(scenario, steps=150, count=40)
    flips = (flight.episodes.switches[:, 0] <= flight.time[:, None, None]).sum(axis=2)
    out = (flight.time > 0.95)[:, None] & (flips % 2 == 0)
    np.testing.assert_array_equal(flight.valid, ~out)
    assert 0.2 < out.mean() < 0.5
    assert np.linalg.norm(flight.turn[~out], axis=1).max() < 1e-12
    assert 0.0 < np.linalg.norm(flight.turn[out], axis=1).max() < 5e-5


def test_a_reset_of_others_does_not_end_an_outage():
    scenario = craft(StarTrackerOutage(onset=1.0), sensors=NOISE)
    undisturbed, simulator = Simulator(scenario, 3), Simulator(scenario, 3)
    for item in (undisturbed, simulator):
        item.reset(scenario.draw(0, 3))
    mask = np.array([False, True, False])
    for step in range(40):
        if step == 20:
            simulator.reset(scenario.draw(9, 1), mask)
            np.testing.assert_array_equal(simulator.measurement().star_tracker_valid, mask)
        for item in (undisturbed, simulator):
            item.step(np.full((3, 3), 0.05))
        for name in ("attitude", "rate", "star_tracker_valid"):
            one, other = getattr(simulator.measurement(), name), getattr(undisturbed.measurement(), name)
            np.testing.assert_array_equal(one[~mask], other[~mask])
    fresh = Simulator(scenario, 1)
    fresh.reset(scenario.draw(9, 1))
    for _ in range(20):
        fresh.step(np.full((1, 3), 0.05))
    np.testing.assert_array_equal(simulator.measurement().attitude[1], fresh.measurement().attitude[0])


def test_craft_with_different_faults_do_not_mix():
    kinds = (GyroBiasStep(size=1e-3), AttitudeSpike(angle=0.1), StarTrackerOutage(onset=1.0))
    flight = Flight(craft(faults=FaultDistribution(kinds, fault_counts=(0.3, 0.4, 0.3))), count=60, steps=30)
    faults = flight.episodes.sensor_faults
    assert flight.episodes.sensor_faults.shape == (60, 2)
    drifting, turned, out = ((faults["kind"] == kind.kind).any(axis=1) for kind in kinds)
    np.testing.assert_array_equal(np.abs(flight.rate_error[5]).max(axis=1) > 0.0, drifting)
    np.testing.assert_array_equal(np.linalg.norm(flight.turn[5], axis=1) > 1e-9, turned)
    np.testing.assert_array_equal(~flight.valid[-1], out)
