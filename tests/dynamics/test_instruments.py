"""Sensors of a suite: random walks by Allan deviation, timing of the star tracker by hand, noise, telemetry, replay."""

import copy
import pickle

import numpy as np
import pytest
from helpers.sensing import ARCSECOND, DEGREE, PERIOD, Flight, at_rest, flown, task

from ftac_gym import attitude as att
from ftac_gym.dynamics import Simulator
from ftac_gym.faults import AttitudeSpike, GyroBiasStep, StarTrackerOutage
from ftac_gym.task import Gyro, InitialState, ModalTelemetry, SensorErrors, SensorSuite, StarTracker, WheelTelemetry

NOISY = SensorSuite(
    star_tracker=StarTracker(rate=5.0, latency=0.15, cross_noise=6.0, boresight_noise=40.0, boresight=(0.6, 0.0, 0.8)),
    gyro=Gyro(
        angle_random_walk=0.01, rate_random_walk=0.12, bias=(-1.0, 1.0), bias_instability=0.1, correlation_time=5.0,
        scale_factor=(-100.0, 100.0), misalignment=(0.0, 0.02),
    ),
    wheels=WheelTelemetry(noise=1e-3), modes=ModalTelemetry(displacement_noise=1e-4, rate_noise=1e-3),
)  # fmt: skip


# ------------------------------------------------------------------------------------------------------------- gyros


def allan_deviation(rate, samples):
    """Return the Allan deviation of rates (T, channels) averaged over so many samples each."""
    means = rate[: len(rate) // samples * samples].reshape(-1, samples, rate.shape[1]).mean(axis=1)
    return np.sqrt(0.5 * np.mean(np.diff(means, axis=0) ** 2))


@pytest.fixture(scope="module", params=[0.05, 0.2])
def still_gyros(request):
    """Return a function that gives a control period and the rates (T, channels) of gyros at rest."""

    def rates(**errors):
        scenario = at_rest(SensorSuite(gyro=Gyro(**errors)), control_period=request.param, physics_step=request.param)
        return request.param, Flight(scenario, steps=1000, count=150).rate.reshape(1001, -1)

    return rates


@pytest.mark.parametrize("samples", [1, 10, 50])
def test_white_noise_has_the_allan_deviation_of_the_angle_random_walk(still_gyros, samples):
    walk = 0.3 * DEGREE / 60.0
    period, rate = still_gyros(angle_random_walk=0.3)
    assert allan_deviation(rate, samples) == pytest.approx(walk / np.sqrt(samples * period), rel=0.03)


@pytest.mark.parametrize("samples", [10, 50])
def test_the_bias_walks_with_the_allan_deviation_of_the_rate_random_walk(still_gyros, samples):
    walk = 0.5 * DEGREE / 3600.0 / 60.0
    period, rate = still_gyros(rate_random_walk=0.5)
    assert np.all(rate[0] == 0.0)
    tau = samples * period
    assert allan_deviation(rate, samples) == pytest.approx(walk * np.sqrt(tau / 3.0), rel=0.04)


@pytest.mark.parametrize("samples", [5, 20, 80])
def test_the_varying_bias_has_the_allan_deviation_of_a_gauss_markov_process(still_gyros, samples):
    sigma, time = 2.0 * DEGREE / 3600.0, 4.0
    period, rate = still_gyros(bias_instability=2.0, correlation_time=time)
    x = samples * period / time
    variance = 2.0 * sigma**2 / x * (1.0 - (3.0 - 4.0 * np.exp(-x) + np.exp(-2.0 * x)) / (2.0 * x))
    assert allan_deviation(rate, samples) == pytest.approx(np.sqrt(variance), rel=0.05)


def test_the_varying_bias_is_stationary_from_the_start(still_gyros):
    period, rate = still_gyros(bias_instability=2.0, correlation_time=4.0)
    for row in rate[[0, 1, 10, 1000]]:
        assert row.std() == pytest.approx(2.0 * DEGREE / 3600.0, rel=0.12)
    lagged = np.mean(rate[:-20] * rate[20:]) / np.mean(rate**2)
    assert lagged == pytest.approx(np.exp(-20.0 * period / 4.0), abs=0.05)


@pytest.mark.parametrize("period", [0.02, 0.1, 0.5])
def test_the_drift_in_an_outage_does_not_depend_on_the_control_period(period):
    scenario = at_rest(
        SensorSuite(gyro=Gyro(angle_random_walk=0.3)), StarTrackerOutage(onset=0.001),
        control_period=period, physics_step=period,
    )  # fmt: skip
    flight = Flight(scenario, steps=round(10.0 / period), count=800)
    expected = 0.3 * DEGREE / 60.0 * np.sqrt(10.0)
    assert flight.turn[-1].std() == pytest.approx(expected, rel=0.05)


def test_errors_of_a_steady_spin_by_hand():
    spin = np.array([0.1, -0.2, 0.3])
    suite = SensorSuite(gyro=Gyro(bias=(-10.0, 10.0), scale_factor=(-9e4, 9e4), misalignment=(1.0, 5.0)))
    flight = Flight(task(suite, initial_state=InitialState.fixed(rate=spin)), steps=0, count=50)
    drawn = flight.episodes.sensors
    turned = spin + np.cross(drawn["gyro_misalignment"], spin)
    expected = (1.0 + drawn["scale_factor"]) * turned + drawn["gyro_bias"]
    np.testing.assert_allclose(flight.rate[0], expected, rtol=0.0, atol=1e-15)
    assert np.abs(drawn["scale_factor"]).max() > 0.08 and np.abs(drawn["gyro_bias"]).max() > 4e-5
    assert flight.rate_error.std() > 1e-3


def test_a_gyro_fault_adds_to_the_errors():
    step = GyroBiasStep(onset=1.0, size=1e-3)
    faulty, plain = Flight(task(NOISY, step)), Flight(task(NOISY))
    bias = faulty.episodes.sensor_faults["rate_bias"][:, 0]
    expected = (faulty.time > 0.95)[:, None, None] * bias
    np.testing.assert_allclose(faulty.rate - plain.rate, expected, rtol=0.0, atol=1e-15)


# ----------------------------------------------------------------------------------------- timing of the star tracker


@pytest.mark.parametrize(
    ("rate", "latency", "ages"),
    [
        (5.0, 0.15, [0, 1, 2, 3, 2, 3, 2, 3, 2, 3]),
        (5.0, 0.2, [0, 1, 2, 3, 2, 3, 2, 3, 2, 3]),
        (5.0, 0.1, [0, 1, 2, 1, 2, 1, 2, 1, 2, 1]),
        (5.0, 0.0, [0, 1, 0, 1, 0, 1, 0, 1, 0, 1]),
        (10.0, 0.0, [0] * 10),
        (10.0, 0.3, [0, 1, 2, 3, 3, 3, 3, 3, 3, 3]),
        (5.0, 0.5, [0, 1, 2, 3, 4, 5, 6, 5, 6, 5]),
        (2.5, 0.9, [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 9, 10, 11, 12, 9]),
    ],
)
def test_ages_by_hand(rate, latency, ages):
    """Ages in control periods of 0.1 s, from the start of the episode on."""
    suite = SensorSuite(star_tracker=StarTracker(rate=rate, latency=latency))
    flight = Flight(task(suite), steps=len(ages) - 1, count=3)
    np.testing.assert_allclose(flight.age, PERIOD * np.tile(ages, (3, 1)).T, rtol=0.0, atol=1e-12)
    assert flight.valid.all()


@pytest.mark.parametrize(("rate", "latency"), [(5.0, 0.15), (5.0, 0.5), (2.0, 0.7), (10.0, 0.35)])
def test_a_sample_is_the_one_that_was_taken_a_latency_ago(rate, latency):
    """With perfect gyros and a steady spin, the error of the attitude is that of its sample, carried along."""
    tracker = {"rate": rate, "cross_noise": 60.0, "boresight_noise": 200.0}
    start = InitialState.fixed(rate=(0.0, 0.3, 0.0))
    late, prompt = (
        Flight(task(SensorSuite(star_tracker=StarTracker(latency=delay, **tracker)), initial_state=start), command=0.0)
        for delay in (latency, 0.0)
    )
    steps = np.arange(len(late.time))
    sampled = steps - np.round(late.age[:, 0] / PERIOD).astype(int)
    assert np.all(sampled[1:] % round(1.0 / (rate * PERIOD)) == 0)
    for step, sample in zip(steps, sampled, strict=True):
        error = att.quaternion_product(prompt.attitude[sample], att.quaternion_conjugate(prompt.true_attitude[sample]))
        expected = att.quaternion_product(error, late.true_attitude[step])
        np.testing.assert_allclose(att.angle_between(late.attitude[step], expected), 0.0, atol=1e-7)
    assert np.linalg.norm(late.turn, axis=2).max() > 60.0 * ARCSECOND


def test_perfect_sensors_report_the_truth():
    flight = Flight(task(SensorSuite()), steps=100)
    np.testing.assert_array_equal(flight.rate, flight.true_rate)
    np.testing.assert_allclose(flight.turn, 0.0, atol=1e-12)
    np.testing.assert_array_equal(flight.age, 0.0)
    np.testing.assert_array_equal(flight.momentum, flight.true_momentum)


def test_latency_may_be_drawn():
    suite = SensorSuite(star_tracker=StarTracker(rate=5.0, latency=(0.05, 0.85)))
    flight = Flight(task(suite), steps=30, count=40)
    drawn = flight.episodes.sensors["latency"]
    delay = np.ceil(drawn / PERIOD - 1e-9) * PERIOD
    np.testing.assert_allclose(flight.age[15:].min(axis=0), delay, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(flight.age[15:].max(axis=0), delay + PERIOD, rtol=0.0, atol=1e-12)
    assert len(np.unique(delay)) > 5


# ------------------------------------------------------------------------------------------ noise of the star tracker


def test_noise_across_and_about_a_skew_boresight():
    axis = np.array([1.0, 2.0, -2.0]) / 3.0
    suite = SensorSuite(
        star_tracker=StarTracker(rate=10.0, cross_noise=5.0, boresight_noise=50.0, boresight=tuple(axis))
    )
    turn = Flight(at_rest(suite), steps=100, count=200).turn.reshape(-1, 3) / ARCSECOND
    along = np.outer(axis, axis)
    expected = 25.0 * (np.eye(3) - along) + 2500.0 * along
    np.testing.assert_allclose(np.cov(turn.T), expected, rtol=0.0, atol=0.03 * 2500.0)
    assert (turn @ axis).std() == pytest.approx(50.0, rel=0.03)
    across = turn - np.outer(turn @ axis, axis)
    assert np.sqrt(np.mean(np.sum(across**2, axis=1)) / 2.0) == pytest.approx(5.0, rel=0.03)
    assert np.abs(turn.mean(axis=0)).max() < 2.0


def test_noise_is_independent_between_sensors_axes_times_and_spacecraft():
    suite = SensorSuite(
        star_tracker=StarTracker(rate=10.0, cross_noise=10.0, boresight_noise=10.0), gyro=Gyro(angle_random_walk=0.1),
        wheels=WheelTelemetry(noise=1e-3),
    )  # fmt: skip
    flight = Flight(at_rest(suite), steps=100, count=200)
    channels = np.concatenate([flight.turn, flight.rate, flight.momentum - flight.true_momentum], axis=2)
    bound = 5.0 / np.sqrt(channels[..., 0].size)
    assert np.abs(np.corrcoef(channels.reshape(-1, 9).T) - np.eye(9)).max() < bound
    for channel in np.moveaxis(channels, 2, 0):
        for a, b in ((channel[1:], channel[:-1]), (channel[:, 1:], channel[:, :-1])):
            assert abs(np.corrcoef(a.ravel(), b.ravel())[0, 1]) < bound


# ------------------------------------------------------------------------------------------------------------- faults


def test_an_outage_by_hand():
    """Out from 0.95 to 1.75 s: the sample of 0.8 s, due at 1.0 s, is lost, and that of 1.8 s is due at 2.0 s."""
    suite = SensorSuite(star_tracker=StarTracker(rate=5.0, latency=0.15))
    flight = Flight(task(suite, StarTrackerOutage(onset=0.95, duration=0.8)), steps=24, count=2)
    ages = [0, 1, 2, 3, 2, 3, 2, 3, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 2, 3, 2, 3, 2]
    np.testing.assert_allclose(flight.age, PERIOD * np.tile(ages, (2, 1)).T, rtol=0.0, atol=1e-12)
    out = (flight.time > 0.95) & (flight.time < 1.75)
    np.testing.assert_array_equal(flight.valid, np.tile(~out, (2, 1)).T)


def test_a_sample_whose_delivery_falls_after_a_short_outage_arrives():
    """Out at 0.7 s only: no sample is taken or due then, and the ages are those without an outage."""
    suite = SensorSuite(star_tracker=StarTracker(rate=5.0, latency=0.2))
    flight = Flight(task(suite, StarTrackerOutage(onset=0.65, duration=0.1)), steps=12, count=1)
    np.testing.assert_allclose(flight.age[:, 0], PERIOD * np.array([0, 1, 2, 3, 2, 3, 2, 3, 2, 3, 2, 3, 2]), atol=1e-12)
    assert flight.valid[:, 0].tolist() == [True] * 7 + [False] + [True] * 5


def test_an_outage_from_the_start_begins_with_a_sample():
    suite = SensorSuite(star_tracker=StarTracker(rate=5.0, latency=0.15, cross_noise=60.0))
    flight = Flight(task(suite, StarTrackerOutage(), AttitudeSpike(angle=0.5)), steps=20)
    assert not flight.valid.any()
    np.testing.assert_allclose(flight.age, np.tile(flight.time, (flight.age.shape[1], 1)).T, atol=1e-12)
    assert 0.0 < np.linalg.norm(flight.turn, axis=2).max() < 0.01


def test_a_spike_turns_the_sample_taken_at_its_time():
    """Of 0.1 s at 1.0 s: seen from 1.2 s, when the sample of 1.0 s is due, to the next one at 1.4 s."""
    suite = SensorSuite(star_tracker=StarTracker(rate=5.0, latency=0.2))
    flight = Flight(at_rest(suite, AttitudeSpike(onset=1.0, angle=0.3, duration=0.1)), steps=20, count=4)
    seen = np.linalg.norm(flight.turn, axis=2)
    turned = (flight.time > 1.15) & (flight.time < 1.35)
    np.testing.assert_allclose(seen, np.tile(0.3 * turned, (4, 1)).T, rtol=0.0, atol=1e-12)
    missed = Flight(at_rest(suite, AttitudeSpike(onset=1.1, angle=0.3, duration=0.05)), steps=20, count=4)
    np.testing.assert_allclose(missed.turn, 0.0, atol=1e-12)  # Between two samples.


def test_simple_sensors_have_an_age_in_an_outage_only():
    flight = Flight(task(SensorErrors(attitude_noise=1e-4), StarTrackerOutage(onset=1.0, duration=0.5)), steps=20)
    expected = np.where((flight.time > 0.95) & (flight.time < 1.45), flight.time - 0.9, 0.0)
    np.testing.assert_allclose(flight.age, np.tile(expected, (flight.age.shape[1], 1)).T, rtol=0.0, atol=1e-12)


# ---------------------------------------------------------------------------------------------------------- telemetry


def test_wheel_momentum_has_white_noise_of_the_given_size():
    flight = Flight(task(SensorSuite(wheels=WheelTelemetry(noise=2e-3))), steps=100, count=100)
    error = flight.momentum - flight.true_momentum
    assert error.std() == pytest.approx(2e-3, rel=0.02) and abs(error.mean()) < 1e-4


def test_wheel_momentum_comes_in_steps_of_the_quantum():
    flight = Flight(task(SensorSuite(wheels=WheelTelemetry(quantum=0.01))), steps=50)
    error = flight.momentum - flight.true_momentum
    assert np.abs(error).max() <= 0.005 + 1e-12 and np.abs(error).max() > 0.004
    np.testing.assert_allclose(flight.momentum / 0.01, np.round(flight.momentum / 0.01), rtol=0.0, atol=1e-9)


def test_a_tiny_quantum_changes_nothing():
    flight = Flight(task(SensorSuite(wheels=WheelTelemetry(quantum=1e-20))), steps=50)
    np.testing.assert_allclose(flight.momentum, flight.true_momentum, rtol=1e-15)


def test_modes_have_white_noise_of_the_given_sizes():
    scenario = flown("flexible", NOISY)
    simulator = Simulator(scenario, 200)
    simulator.reset(scenario.draw(0, 200))
    errors = {"modal_displacement": [], "modal_rate": []}
    for _ in range(20):
        simulator.step(np.full(simulator.last_command.shape, 0.05))
        measured = simulator.measurement()
        for name, rows in errors.items():
            rows.append(getattr(measured, name) - getattr(simulator.state, name))
    for name, size in (("modal_displacement", 1e-4), ("modal_rate", 1e-3)):
        sample = np.array(errors[name])
        assert sample.std() == pytest.approx(size, rel=0.03)
        correlation = np.corrcoef(sample.reshape(-1, sample.shape[2]).T) - np.eye(sample.shape[2])
        assert np.abs(correlation).max() < 0.1


# ------------------------------------------------------------------------------------------- replay and independence


def measured_by(simulator, steps, rows=slice(None)):
    """Step with varying commands; return the measurements of some spacecraft, (T, n, .)."""
    random, shape = np.random.default_rng(3), simulator.last_command.shape[1]
    found = []
    for _ in range(steps):
        simulator.step(np.tile(random.uniform(-0.05, 0.05, shape), (simulator.num_spacecraft, 1)))
        seen = simulator.measurement()
        parts = (seen.attitude, seen.rate, seen.wheel_momentum, seen.attitude_age[:, None], seen.modal_rate)
        found.append(np.concatenate(parts, axis=1)[rows])
    return np.array(found)


@pytest.fixture(scope="module")
def noisy():
    return flown("flexible", NOISY, (StarTrackerOutage(onset=1.0, duration=0.5),))


def test_one_spacecraft_measures_as_in_a_crowd(noisy):
    episodes = noisy.draw(0, 5)
    crowd = Simulator(noisy, 5)
    crowd.reset(episodes)
    together = measured_by(crowd, 25)
    for index in range(5):
        alone = Simulator(noisy, 1)
        alone.reset(episodes[index])
        np.testing.assert_array_equal(measured_by(alone, 25)[:, 0], together[:, index])


def test_episodes_fly_again_alike_also_from_a_file(noisy, tmp_path):
    simulator = Simulator(noisy, 3)
    simulator.reset(noisy.draw(4, 3))
    first = measured_by(simulator, 20)
    simulator.episodes.save(tmp_path / "episodes.npz")
    again = Simulator(noisy, 3)
    again.reset(type(simulator.episodes).load(tmp_path / "episodes.npz"))
    np.testing.assert_array_equal(measured_by(again, 20), first)


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda item: pickle.loads(pickle.dumps(item))])
def test_a_copy_in_mid_flight_goes_on_alike_and_apart(noisy, copied):
    simulator = Simulator(noisy, 2)
    simulator.reset(noisy.draw(4, 2))
    measured_by(simulator, 7)
    twin = copied(simulator)
    expected = measured_by(simulator, 10)
    np.testing.assert_array_equal(measured_by(twin, 10), expected)


def test_a_reset_of_one_leaves_the_others(noisy):
    mask = np.array([False, True, False])
    simulator, undisturbed = Simulator(noisy, 3), Simulator(noisy, 3)
    for item in (simulator, undisturbed):
        item.reset(noisy.draw(0, 3))
        measured_by(item, 12)
    simulator.reset(noisy.draw(9, 1), mask)
    assert simulator.measurement().attitude_age.tolist() == pytest.approx([0.6, 0.0, 0.6])
    expected = measured_by(undisturbed, 12)
    found = measured_by(simulator, 12)
    np.testing.assert_array_equal(found[:, ~mask], expected[:, ~mask])
    fresh = Simulator(noisy, 1)
    fresh.reset(noisy.draw(9, 1))
    np.testing.assert_array_equal(found[:, 1], measured_by(fresh, 12)[:, 0])
