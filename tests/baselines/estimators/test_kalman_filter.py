"""The attitude filter: consistency with its own covariance, Riccati's solution, faults of sensors, and bad input."""

import dataclasses
import functools

import numpy as np
import pytest
from helpers.filtered import FilteredFlight, normalised
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import solve_discrete_are
from scipy.stats import chi2

from ftac_gym import baselines, scenarios
from ftac_gym.attitude import quaternion_from_rotation_vector, quaternion_product
from ftac_gym.baselines.estimators.attitude_kernel import ATTITUDE_STATE, CONFIRMING, filter_attitude
from ftac_gym.baselines.estimators.models import attitude_model, attitude_model_of
from ftac_gym.faults import AttitudeSpike, FaultSchedule, GyroBiasStep, StarTrackerOutage
from ftac_gym.task import SensorSuite

FLAGSHIP = scenarios.get("flagship").replace(faults=None)
POINTING = FLAGSHIP.replace(initial_state=scenarios.get("flagship_pointing").initial_state)
"""On target from the start: the bias does not vary with the rate."""

EPISODES = 100
ORDINARY = {"attitude_noise": 3e-5, "angle_random_walk": 3e-6, "bias": 5e-6, "bias_walk": 1e-8}
"""Noise of the order of the flagship's."""

PERIODS = 120
ARCSECOND = np.pi / 648000.0


@pytest.fixture(scope="module", params=["flagship", "flagship_noise"])
def flight(request):
    """A hundred healthy flights; the second have three times the noise, as their data sheet says."""
    return FilteredFlight(scenarios.get(request.param).replace(faults=None), EPISODES, 120.0)


def faulty(fault, gate=0.9999, duration=60.0, count=20, task=POINTING):
    return FilteredFlight(task.replace(faults=FaultSchedule((fault,))), count, duration, gate)


# --------------------------------------------------------------------------------------------------------- consistency


def test_innovations_have_the_size_that_the_filter_says(flight):
    """Their mean of all episodes lies within its 95 % bounds in 95 % of the periods, and their quantiles are right."""
    arrived = ~np.isnan(flight.innovations).any(axis=1)
    assert arrived.sum() == 598  # 5 Hz for 120 s, of which the first starts the filter and the last arrives too late
    innovations = flight.innovations[arrived]
    low, high = chi2.ppf([0.025, 0.975], 3 * EPISODES) / EPISODES
    mean = innovations.mean(axis=1)
    # In slews the covariance is pessimistic, see below.
    assert np.mean((low <= mean) & (mean <= high)) > 0.92
    for share in (0.5, 0.95, 0.99):
        # A binomial share of 59,700 has this standard deviation; errors in proportion to the rate are pessimistic.
        deviation = np.sqrt(share * (1.0 - share) / innovations.size)
        assert np.mean(innovations > chi2.ppf(share, 3)) == pytest.approx(1.0 - share, abs=3.0 * deviation + 0.003)


def test_innovations_at_rest_lie_within_their_95_percent_bounds_and_do_not_drift(flight):
    """At rest no error in proportion to the rate widens the covariance: the mean over all is exact."""
    late = flight.innovations[400:]
    parts = [part[~np.isnan(part)] for part in (late, *np.array_split(late, 4))]
    low, high = chi2.ppf([0.025, 0.975], 3 * parts[0].size) / parts[0].size
    assert low <= parts[0].mean() <= high
    for part in parts[1:]:
        assert part.mean() == pytest.approx(3.0, abs=4.0 * np.sqrt(6.0 / part.size))


def test_no_good_sample_is_left_out(flight):
    assert np.mean(flight.rejected > 0) < 3e-4  # 1e-4 by the gate of 0.9999


def test_errors_have_the_size_of_their_covariance(flight):
    """Squared errors of attitude and bias in units of their covariance, mean over episodes, at rest."""
    low, high = chi2.ppf([0.001, 0.999], 3 * EPISODES) / EPISODES
    for part in (slice(0, 3), slice(3, 6)):
        errors, covariance = flight.errors[400::100, :, part], flight.covariance[400::100, :, part, part]
        found = normalised(errors, covariance).mean(axis=1)
        assert (found < high).all() and (found > 0.85 * low).all(), found
    joint = normalised(flight.errors[400::100], flight.covariance[400::100]).mean(axis=1)
    assert joint.mean() == pytest.approx(6.0, abs=0.6)


def test_errors_in_the_slew_are_no_larger_than_the_filter_says(flight):
    """The bias then varies with the rate, by the errors of scale and alignment."""
    high = chi2.ppf(0.999, 6 * EPISODES) / EPISODES
    assert normalised(flight.errors[10:300:10], flight.covariance[10:300:10]).mean(axis=1).max() < 1.3 * high


def test_the_filter_is_better_than_its_samples(flight):
    sample = FLAGSHIP.sensors.star_tracker.cross_noise
    across = np.abs(flight.attitude_error[600:, :, :2]).std() / ARCSECOND
    assert across < 0.5 * sample * (3.0 if flight.covariance[-1, 0, 0, 0] > (3.0 * ARCSECOND) ** 2 else 1.0)


# ------------------------------------------------------------------------------------------------- against the textbook


def discrete(model):
    """Transition, process noise, output and measurement variance of one axis at rest."""
    period, walk = model.period, model.period * model.bias_walk
    transition = np.array([[1.0, -period], [0.0, 1.0]])
    process = np.array(
        [[period * (model.angle_walk + period * walk / 3.0), -0.5 * period * walk], [-0.5 * period * walk, walk]]
    )
    return transition, process, np.array([[1.0, 0.0]]), np.array([[model.cross_variance]])


def updated(covariance, output, variance):
    gain = covariance @ output.T / (output @ covariance @ output.T + variance)
    return covariance - gain @ output @ covariance, gain


def fly(model, attitudes, ages, rates):
    """Return the states along a flight of one spacecraft."""
    state, found = np.zeros(1, ATTITUDE_STATE), []
    for k, (attitude, age, rate) in enumerate(zip(attitudes, ages, rates, strict=True)):
        filter_attitude(state, model, np.array([k * model.period]), attitude[None], np.array([age]), rate[None])
        found.append(state[0].copy())
    return np.array(found)


@pytest.mark.parametrize(
    "change", [{}, {"bias_walk": 1e-6}, {"angle_random_walk": 1e-4, "bias_walk": 1e-6}, {"attitude_noise": 1e-3}]
)
def test_steady_covariance_solves_riccatis_equation(change):
    model = attitude_model(0.1, **{**ORDINARY, **change})
    transition, process, output, variance = discrete(model)
    predicted = solve_discrete_are(transition.T, output.T, process, variance)
    expected, _ = updated(predicted, output, variance)
    steps = 60_000
    identity = np.tile([1.0, 0.0, 0.0, 0.0], (steps, 1))
    last = fly(model, identity, np.zeros(steps), np.zeros((steps, 3)))[-1]["covariance"]
    for axis in range(3):
        pair = np.ix_([axis, 3 + axis], [axis, 3 + axis])
        np.testing.assert_allclose(last[pair], expected, rtol=1e-4)
    assert abs(last[0, 1]) + abs(last[0, 4]) + abs(last[3, 4]) < 1e-12 * last[0, 0]


@pytest.mark.parametrize(("every", "late"), [(1, 0), (2, 2), (4, 3), (5, 1)])
def test_late_samples_give_what_a_delayed_standard_filter_gives(every, late):
    """Means and covariance of one axis: the sample is taken when it is made, and carried to the present."""
    model = attitude_model(0.1, **{**ORDINARY, "bias_walk": 0.0})
    transition, process, output, variance = discrete(model)
    random, steps = np.random.default_rng(4), 400
    bias, rate = 4e-6, 0.02 * np.sin(0.1 * np.arange(steps))
    measured = rate + bias + model.angle_walk**0.5 / 0.1**0.5 * random.normal(size=steps)
    true = np.append(0.0, np.cumsum(0.05 * (rate[1:] + rate[:-1])))
    carried = np.append(0.0, np.cumsum(0.05 * (measured[1:] + measured[:-1])))
    sampled = true + model.cross_variance**0.5 * random.normal(size=steps)
    # The standard filter, which gets each sample at once.
    mean, covariance = np.array([sampled[0], 0.0]), np.diag([model.cross_variance * 2.0, model.bias_start])
    means, covariances = [mean], [covariance]
    for k in range(1, steps):
        mean = transition @ mean + np.array([carried[k] - carried[k - 1], 0.0])
        covariance = transition @ covariance @ transition.T + process
        if k % every == 0:
            covariance, gain = updated(covariance, output, variance)
            mean = mean + gain[:, 0] * (sampled[k] - mean[0])
        means.append(mean)
        covariances.append(covariance)
    ticks = np.arange(steps)
    taken = np.maximum((ticks - late) // every * every, 0)
    angles = sampled[taken] + carried - carried[taken]
    attitudes = quaternion_from_rotation_vector(angles[:, None] * np.array([1.0, 0.0, 0.0]))
    found = fly(model, attitudes, 0.1 * (ticks - taken), measured[:, None] * np.array([1.0, 0.0, 0.0]))
    for k in range(late + every, steps):
        if taken[k] == k - late:
            power = np.linalg.matrix_power(transition, late)
            ahead = power @ covariances[k - late] @ power.T
            ahead += sum(
                np.linalg.matrix_power(transition, i) @ process @ np.linalg.matrix_power(transition, i).T
                for i in range(late)
            )
            pair = found[k]["covariance"][np.ix_([0, 3], [0, 3])]
            np.testing.assert_allclose(pair, ahead, rtol=1e-6)
            angle = means[k - late][0] + carried[k] - carried[k - late] - 0.1 * late * means[k - late][1]
            q = found[k]["attitude"]
            assert 2.0 * np.arctan2(q[1], q[0]) == pytest.approx(angle, abs=1e-9)
            assert found[k]["bias"][0] == pytest.approx(means[k - late][1], abs=1e-10)


def test_boresight_has_its_own_variance_along_a_turning_body():
    """The covariance of a sample is that of its own axis, where the body pointed when it was taken."""
    sight = np.array([0.6, 0.0, 0.8])
    fields = {**ORDINARY, "boresight_noise": 3e-4, "boresight": tuple(sight), "bias": 1e-9}
    model = attitude_model(0.1, **fields)
    identity = np.tile([1.0, 0.0, 0.0, 0.0], (400, 1))
    covariance = fly(model, identity, np.zeros(400), np.zeros((400, 3)))[-1]["covariance"][:3, :3]
    values, vectors = np.linalg.eigh(covariance)
    assert values[2] > 5.0 * values[1] and abs(vectors[:, 2] @ sight) == pytest.approx(1.0, abs=1e-6)


@functools.cache
def tumble(steps):
    """Return rates of a body that tumbles and calms down, and its attitudes."""
    random, ticks = np.random.default_rng(1), np.arange(steps)
    rates = np.cumsum(0.02 * random.normal(size=(steps, 3)), axis=0) * np.exp(-ticks / 1000.0)[:, None]
    attitudes = [np.array([1.0, 0.0, 0.0, 0.0])]
    for turn in quaternion_from_rotation_vector(0.05 * (rates[1:] + rates[:-1])):
        attitudes.append(quaternion_product(attitudes[-1], turn))
    return rates, np.array(attitudes)


@given(
    noise=st.floats(-8.0, 0.0),
    walk=st.floats(-8.0, -1.0),
    bias=st.floats(-8.0, -1.0),
    bias_walk=st.floats(-12.0, -2.0),
    about=st.floats(0.0, 4.0),
    linear=st.floats(-6.0, -1.0),
    every=st.integers(1, 20),
    late=st.integers(0, 5),
)
@settings(max_examples=40)
def test_covariance_stays_symmetric_and_positive(noise, walk, bias, bias_walk, about, linear, every, late):
    """Over a long flight with any ratio of the errors, with late and rare samples of a tumbling body."""
    model = attitude_model(
        0.1, attitude_noise=10.0**noise, angle_random_walk=10.0**walk, bias=10.0**bias, bias_walk=10.0**bias_walk,
        boresight_noise=10.0 ** min(noise + about, 0.0), linear_error=10.0**linear, gate=1.0,
    )  # fmt: skip
    rates, attitudes = tumble(2000)
    ticks = np.arange(len(rates))
    ages = 0.1 * (ticks - np.maximum((ticks - late) // every * every, 0))
    found = fly(model, attitudes, ages, rates)
    covariance = found["covariance"]
    assert np.isfinite(covariance).all() and np.isfinite(found["attitude"]).all()
    np.testing.assert_allclose(np.linalg.norm(found["attitude"], axis=1), 1.0, atol=1e-12)
    size = np.sqrt(np.einsum("tii->ti", covariance))
    assert (size > 0.0).all()
    correlation = covariance / (size[:, :, None] * size[:, None, :])
    np.testing.assert_allclose(correlation, np.swapaxes(correlation, 1, 2), atol=1e-9)
    assert np.linalg.eigvalsh(correlation).min() > -1e-9


# ---------------------------------------------------------------------------------------------------- faults of sensors

SPIKES = AttitudeSpike(onset=30.0, angle=0.01, period=4.0, on_time=0.2)


def test_the_gate_keeps_false_samples_out():
    """With spikes of 0.01 rad the error stays at the noise level; without a gate it does not."""
    healthy = faulty(dataclasses.replace(SPIKES, onset=500.0)).angle[350:]
    gated, open_gate = faulty(SPIKES).angle[350:], faulty(SPIKES, gate=1.0).angle[350:]
    assert np.sqrt(np.mean(gated**2)) < 1.1 * np.sqrt(np.mean(healthy**2))
    assert np.sqrt(np.mean(open_gate**2)) > 5.0 * np.sqrt(np.mean(healthy**2))


def test_a_star_tracker_that_jumps_for_good_is_followed():
    """Five rejected samples that agree, and the next one: 1.2 s at 5 Hz, plus the latency."""
    turn = 0.01
    flight = faulty(AttitudeSpike(onset=30.0, angle=turn, duration=90.0))
    aside = flight.angle * ARCSECOND
    arrival = 303  # the first sample after the onset is taken at 30.0 or 30.2 s
    assert aside[:300].max() < 0.05 * turn
    assert aside[304].max() < 0.05 * turn and flight.rejected[304].min() >= 1
    settled = arrival + 2 * (CONFIRMING + 1)
    np.testing.assert_allclose(aside[settled:].mean(axis=0), turn, rtol=0.02)
    # Nothing stays rejected afterwards, and the bias takes no part of the jump.
    assert flight.rejected[settled:].mean() < 1e-3
    assert np.abs(flight.bias_error[settled + 100 :]).max() < 3e-5


@pytest.mark.parametrize("size", [1e-4, 3e-4, 1e-3, 1e-2])
def test_a_step_of_the_gyro_bias_is_found(size):
    """Mostly within ten seconds, in all cases within forty; the attitude is back at the noise level then."""
    flight = faulty(GyroBiasStep(onset=30.0, size=size), duration=75.0)
    # The bias of the fault is not among the true ones of the sensors.
    unknown = np.abs(np.linalg.norm(flight.bias_error, axis=2) - size) / size
    assert np.median(unknown[400]) < 0.1 and unknown[700:].max() < 0.1
    assert flight.angle[700:].max() < 30.0  # arcsec
    if size < 1e-3:
        assert flight.angle.max() * ARCSECOND < 1.5e-3


def test_a_step_of_the_bias_within_the_gate_is_learned_slowly_and_does_no_harm():
    flight = faulty(GyroBiasStep(onset=30.0, size=1e-5), duration=90.0)
    unknown = np.abs(np.linalg.norm(flight.bias_error, axis=2) - 1e-5) / 1e-5
    assert unknown[400].min() > 0.4 and np.median(unknown[-1]) < 0.4
    assert flight.angle[300:].max() < 30.0


def test_error_and_covariance_grow_together_in_an_outage():
    flight = faulty(StarTrackerOutage(onset=20.0, duration=60.0), duration=120.0, count=EPISODES)
    low, high = chi2.ppf([0.001, 0.999], 3 * EPISODES) / EPISODES
    out = slice(210, 800, 50)
    found = normalised(flight.attitude_error[out], flight.covariance[out, :, :3, :3]).mean(axis=1)
    assert (found < high).all() and (found > 0.6 * low).all(), found
    spread = np.sqrt(np.einsum("tnii->tn", flight.covariance[:, :, :3, :3]))
    assert (np.diff(spread[205:800], axis=0) > 0.0).all() and (spread[795] > 3.0 * spread[199]).all()
    assert np.isnan(flight.innovations[206:800]).all()
    # The samples after it are taken at once.
    assert (flight.rejected[800:] > 0).mean() < 1e-3 and (spread[-1] < spread[199]).all()


def test_a_data_sheet_that_is_wrong_shows_in_the_innovations():
    """Three times the noise, of which the filter is not told, gives nine times the squared innovations."""
    noisy = scenarios.get("flagship_noise").replace(faults=None)
    flight = FilteredFlight(noisy, 10, 60.0, gate=1.0, told=FLAGSHIP)
    assert np.nanmean(flight.innovations[300:]) == pytest.approx(27.0, rel=0.1)


# ------------------------------------------------------------------------------------------------------------ bad input


@pytest.mark.parametrize(
    ("name", "value", "rule"),
    [
        ("attitude_noise", 0.0, "must be positive"),
        ("attitude_noise", -1e-5, "must be positive"),
        ("angle_random_walk", 0.0, "must be positive"),
        ("bias", -1e-6, "must be positive"),
        ("bias", float("nan"), "must be"),
        ("boresight_noise", 0.0, "must be positive"),
        ("bias_walk", -1e-9, "must be non-negative|must not be negative"),
        ("linear_error", -0.1, "must be non-negative|must not be negative"),
        ("gate", 0.0, r"must lie within \(0, 1\]"),
        ("gate", 1.5, r"must lie within \(0, 1\]"),
    ],
)
def test_a_covariance_that_is_not_positive_is_refused_by_name(name, value, rule):
    with pytest.raises(ValueError, match=f"{name}.*({rule}).*got"):
        attitude_model(0.1, **{**ORDINARY, name: value})


def test_a_filter_without_gyros_is_refused_by_name():
    blind = FLAGSHIP.replace(sensors=SensorSuite(star_tracker=FLAGSHIP.sensors.star_tracker))
    for scenario in (blind, FLAGSHIP.replace(sensors=None)):
        with pytest.raises(ValueError, match="sensors must have gyros for the filter 'kalman', got"):
            baselines.make("pd_dob", scenario, filter="kalman")
        baselines.make("pd_dob", scenario, filter="auto")
    with pytest.raises(ValueError, match="sensors must have gyros"):
        attitude_model_of(blind, 0.9999)
