"""Models of sensors and spacecraft for the estimators, from the data sheets and nominal parameters of a scenario."""

from __future__ import annotations

import math

import numpy as np
from scipy.stats import chi2

from ftac_gym.baselines.estimators.attitude_kernel import AttitudeModel
from ftac_gym.baselines.estimators.plant_state import PlantModel
from ftac_gym.task.gyro import DEGREE, DEGREE_PER_HOUR, DEGREE_PER_HOUR_PER_ROOT_HOUR, DEGREE_PER_ROOT_HOUR, Gyro
from ftac_gym.task.scenario import Scenario
from ftac_gym.task.sensor_suite import ARCSECOND, SensorSuite
from ftac_gym.task.sensors import SensorErrors
from ftac_gym.utils.parameters import FloatArray, Interval, bounds, largest, non_negative, positive, require

SMALLEST_ANGLE, SMALLEST_WALK = 1e-8, 1e-8
"""Least noise of an attitude sample [rad], and least angle random walk [rad per square root of second].

They stand for sensors without errors, whose covariance is not positive.
"""

INERTIA_SPREAD = 0.12
"""Standard deviation of a moment of inertia over its nominal value, and twice that of a product over its bound."""


def mean_square(value: Interval) -> float:
    """Return the mean square of a number that is drawn uniformly from an interval."""
    low, high = bounds(value)
    return (low * low + low * high + high * high) / 3.0


def attitude_model(
    period: float,
    *,
    attitude_noise: float,
    angle_random_walk: float,
    bias: float,
    bias_walk: float = 0.0,
    boresight_noise: float | None = None,
    boresight: tuple[float, float, float] = (0.0, 0.0, 1.0),
    linear_error: float = 0.0,
    gate: float = 1.0,
) -> AttitudeModel:
    """Return the model of an attitude filter.

    Parameters
    ----------
    period
        Control period [s].
    attitude_noise
        Standard deviation of a sample of the star tracker about each axis, or across its boresight [rad].
    angle_random_walk
        Intensity of the white noise of the gyros [rad per square root of second].
    bias
        Standard deviation of each gyro bias at the start [rad/s].
    bias_walk
        Intensity of the random walk of the bias [rad/s per square root of second].
    boresight_noise
        Standard deviation of a sample about the boresight [rad]; None for that of the other axes.
    boresight
        Direction of the boresight in body axes.
    linear_error
        Standard deviation of rate errors in proportion to the rate [-].
    gate
        Probability with which the innovation gate accepts a sample whose errors are those of the model; 1 for no gate.

    Raises
    ------
    ValueError
        If a standard deviation that makes up the covariance is not positive, another one is negative, or the gate is no
        probability.
    """
    about = attitude_noise if boresight_noise is None else boresight_noise
    require(0.0 < gate <= 1.0, "gate", "must lie within (0, 1]", gate)
    return AttitudeModel(
        period=positive(period, "period"),
        angle_walk=positive(angle_random_walk, "angle_random_walk") ** 2,
        bias_walk=non_negative(bias_walk, "bias_walk") ** 2,
        bias_start=positive(bias, "bias") ** 2,
        linear_error=non_negative(linear_error, "linear_error") ** 2,
        cross_variance=positive(attitude_noise, "attitude_noise") ** 2,
        boresight_variance=positive(about, "boresight_noise") ** 2,
        boresight=np.array(boresight, dtype=np.float64),
        gate=float(chi2.ppf(gate, 3)),
    )


def has_both_sensors(scenario: Scenario) -> bool:
    """Tell whether a scenario has a star tracker and gyros with errors, as a Kalman filter needs them."""
    sensors = scenario.sensors
    if isinstance(sensors, SensorSuite):
        return sensors.gyro is not None and sensors.star_tracker is not None
    return isinstance(sensors, SensorErrors) and sensors.attitude_noise > 0.0


def attitude_model_of(scenario: Scenario, gate: float) -> AttitudeModel:
    """Return the model by the data sheets of a scenario.

    Of a value that is drawn from an interval, the model has the largest, or the mean square of a bias.

    Raises
    ------
    ValueError
        If the scenario has no gyros.
    """
    sensors, period = scenario.sensors, scenario.control_period
    if isinstance(sensors, SensorErrors):
        walk = sensors.rate_noise * math.sqrt(period)
        turn = largest(sensors.gyro_misalignment)
        return attitude_model(
            period,
            attitude_noise=max(sensors.attitude_noise, SMALLEST_ANGLE),
            angle_random_walk=max(walk, SMALLEST_WALK),
            bias=max(math.sqrt(mean_square(sensors.gyro_bias)), SMALLEST_WALK),
            bias_walk=sensors.gyro_bias_walk,
            linear_error=turn,
            gate=gate,
        )
    rule = "must have gyros for the filter 'kalman'"
    require(isinstance(sensors, SensorSuite) and sensors.gyro is not None, "sensors", rule, sensors)
    assert isinstance(sensors, SensorSuite) and sensors.gyro is not None
    gyro, tracker = sensors.gyro, sensors.star_tracker
    cross = SMALLEST_ANGLE if tracker is None else max(ARCSECOND * largest(tracker.cross_noise), SMALLEST_ANGLE)
    about = cross if tracker is None else max(ARCSECOND * largest(tracker.boresight_noise), SMALLEST_ANGLE)
    instability = (DEGREE_PER_HOUR * largest(gyro.bias_instability)) ** 2
    start = DEGREE_PER_HOUR**2 * mean_square(gyro.bias) + instability
    walk = (DEGREE_PER_HOUR_PER_ROOT_HOUR * largest(gyro.rate_random_walk)) ** 2
    x, y, z = (0.0, 0.0, 1.0) if tracker is None else tracker.boresight
    return attitude_model(
        period,
        attitude_noise=cross,
        boresight_noise=about,
        boresight=(x, y, z),
        angle_random_walk=max(DEGREE_PER_ROOT_HOUR * largest(gyro.angle_random_walk), SMALLEST_WALK),
        bias=max(math.sqrt(start), SMALLEST_WALK),
        bias_walk=math.sqrt(walk + 2.0 * instability / gyro.correlation_time),
        linear_error=_linear_error(gyro),
        gate=gate,
    )


def _linear_error(gyro: Gyro) -> float:
    """Return the standard deviation of the error of a rate over the rate, from scale factors and alignment."""
    scale, turn = mean_square(gyro.scale_factor) * 1e-12, mean_square(gyro.misalignment) * DEGREE**2
    return math.sqrt(scale + turn)


def rate_noise_of(scenario: Scenario) -> float:
    """Return the standard deviation of a rate sample [rad/s], by the data sheet of the gyros."""
    sensors = scenario.sensors
    if isinstance(sensors, SensorErrors):
        return sensors.rate_noise
    if isinstance(sensors, SensorSuite) and sensors.gyro is not None:
        walk = DEGREE_PER_ROOT_HOUR * largest(sensors.gyro.angle_random_walk)
        return walk / math.sqrt(scenario.control_period)
    return 0.0


def isolates(scenario: Scenario) -> bool:
    """Tell whether faulty wheels of a scenario can be isolated: its body is rigid and its wheels have torque limits."""
    spacecraft = scenario.spacecraft
    return spacecraft.appendages is None and bool(np.isfinite(spacecraft.wheels.torque_limits).all())


def _assured_torque(scenario: Scenario) -> FloatArray:
    """Return the torque (m,) [N m] that each wheel gives at its largest speed; infinite without a power limit."""
    wheels = scenario.spacecraft.wheels
    nothing = np.full(wheels.count, np.inf)
    if wheels.power_limit is None or wheels.spin_inertia is None:
        return nothing
    power, inertia = (np.broadcast_to(item, wheels.count) for item in (wheels.power_limit, wheels.spin_inertia))
    fastest = wheels.momentum_limits / inertia
    return np.where(np.isfinite(fastest), power / fastest, 0.0)


def plant_model_of(scenario: Scenario, telemetry: bool) -> PlantModel:
    """Return the model of a scenario's nominal spacecraft for the estimator of faulty wheels.

    Raises
    ------
    ValueError
        If the spacecraft has appendages, whose vibration is no fault, or a wheel without a torque limit.
    """
    spacecraft, wheels = scenario.spacecraft, scenario.spacecraft.wheels
    rule = "must be rigid for the isolation of faulty wheels"
    require(spacecraft.appendages is None, "spacecraft", rule, "appendages")
    limits, period, inertia = wheels.torque_limits, scenario.control_period, spacecraft.inertia_matrix
    rule = "must be finite for every wheel for the isolation of faulty wheels"
    require(bool(np.isfinite(limits).all()), "torque_limit", rule, limits.tolist())
    pairs = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    moments = np.diag(inertia)
    bound = [math.sqrt(moments[i] * moments[k]) * INERTIA_SPREAD * (1.0 if i == k else 0.5) for i, k in pairs]
    largest_limit = float(limits.max())
    momentum_limits = wheels.momentum_limits
    # Without a limit the momentum of a minute of full torque.
    stored = float(np.where(np.isfinite(momentum_limits), momentum_limits, 60.0 * limits).max())
    spread = np.diag(np.array([*bound, *(0.5 * stored,) * 3]) ** 2)
    noise = 2.0 * (max(rate_noise_of(scenario), 1e-9) / period) ** 2
    sensors = scenario.sensors
    tachometer = math.inf
    if telemetry:
        error = 0.0
        if isinstance(sensors, SensorSuite) and sensors.wheels is not None:
            error = math.hypot(largest(sensors.wheels.noise), sensors.wheels.quantum / math.sqrt(12.0))
        tachometer = 2.0 * (error / period) ** 2 + (0.01 * largest_limit) ** 2
    friction = max((0.0 if item is None else item.breakaway or item.coulomb) for item in wheels.frictions)
    return PlantModel(
        period=period,
        axes=np.ascontiguousarray(wheels.axis_matrix.T),
        limits=limits,
        assured=_assured_torque(scenario),
        coupled=wheels.momentum_coupling,
        start=np.array([*(inertia[i, k] for i, k in pairs), 0.0, 0.0, 0.0]),
        spread=spread,
        noise=noise * inertia @ inertia.T,
        # The noise of a regressor biases what is learned: by a hundredth here.
        excitation=100.0 * noise,
        tolerance=0.01,
        floor=0.005 * largest_limit + friction + float(wheels.dead_bands.max()),
        lags=wheels.lags,
        tachometer=tachometer,
        drift=4.0,
        largest=25.0,
        threshold=60.0,
        margin=10.0,
    )
