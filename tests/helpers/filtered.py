"""Flights with the attitude filter in the loop, and its errors against the truth."""

import dataclasses

import numpy as np

from ftac_gym import baselines
from ftac_gym.attitude import quaternion_error, rotation_vector_from_quaternion
from ftac_gym.baselines.estimators.kalman_filter import AttitudeKalmanFilter
from ftac_gym.baselines.estimators.models import attitude_model_of
from ftac_gym.baselines.memory import Memory
from ftac_gym.dynamics import Simulator


class FilteredFlight:
    """Errors of the filter along a flight of T periods of N spacecraft, whose law has the filter too.

    Attributes
    ----------
    innovations
        (T, N) squared normalised innovations of new samples; NaN where there is none.
    attitude_error, bias_error
        (T, N, 3) true less estimated attitude [rad] and bias [rad/s]. The bias includes errors of scale and alignment.
    covariance
        (T, N, 6, 6) covariance by the filter.
    rejected
        (T, N) samples rejected in a row.
    """

    def __init__(self, scenario, count, duration, gate=0.9999, seed=20261, law="pd_dob", told=None):
        simulator, memory = Simulator(scenario, count), Memory(count)
        simulator.reset(scenario.draw(seed, count))
        model = attitude_model_of(told or scenario, gate)
        kalman = AttitudeKalmanFilter(model, memory)
        baseline = baselines.make(law, scenario, count, gains="tuned", gate=gate)
        rows = {name: [] for name in ("innovations", "attitude_error", "bias_error", "covariance", "rejected")}
        seen = np.zeros(count)
        for _ in range(round(duration / scenario.control_period)):
            measurement = simulator.measurement()
            attitude, rate = kalman.update(measurement)
            taken = measurement.time - measurement.attitude_age
            rows["innovations"].append(np.where(taken > seen + 1e-6, kalman.innovation_square, np.nan))
            seen = taken
            error = quaternion_error(simulator.state.attitude, attitude)
            rows["attitude_error"].append(rotation_vector_from_quaternion(error))
            rows["bias_error"].append(true_bias(simulator) - kalman.bias)
            rows["covariance"].append(kalman.covariance.copy())
            rows["rejected"].append(memory["attitude_filter"]["rejected"].copy())
            assert np.array_equal(rate, measurement.rate - kalman.bias)
            simulator.step(baseline.act(measurement))
        self.innovations, self.attitude_error, self.bias_error, self.covariance, self.rejected = (
            np.array(values) for values in rows.values()
        )

    @property
    def errors(self):
        """(T, N, 6) errors of attitude and bias."""
        return np.concatenate([self.attitude_error, self.bias_error], axis=-1)

    @property
    def angle(self):
        """(T, N) attitude error [arcsec]."""
        return np.linalg.norm(self.attitude_error, axis=-1) * 648000.0 / np.pi


def true_bias(simulator):
    """Return the rate errors (N, 3) of the gyros [rad/s], except noise and faults."""
    sensors, rate = simulator.episodes.sensors, simulator.state.rate
    turned = rate + np.cross(sensors["gyro_misalignment"], rate)
    return simulator._gyro_bias + (1.0 + sensors["scale_factor"]) * turned - rate


def normalised(errors, covariance):
    """Return squared errors (..., k) in units of their covariance (..., k, k)."""
    return np.einsum("...i,...i", errors, np.linalg.solve(covariance, errors[..., None])[..., 0])


def without(scenario, **parts):
    """Return a scenario whose star tracker or gyros have other data."""
    sensors = scenario.sensors
    changed = {name: dataclasses.replace(getattr(sensors, name), **values) for name, values in parts.items()}
    return scenario.replace(sensors=dataclasses.replace(sensors, **changed))
