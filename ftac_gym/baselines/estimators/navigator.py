"""The estimators in front of a controller: attitude filter, isolation of faulty wheels, prediction over the delay."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ftac_gym.attitude import quaternion_from_rotation_vector, quaternion_product
from ftac_gym.baselines.components.slew_profile import PlantEstimate
from ftac_gym.baselines.estimate import FaultEstimate
from ftac_gym.baselines.estimators.kalman_filter import AttitudeKalmanFilter
from ftac_gym.baselines.estimators.models import attitude_model_of, has_both_sensors, isolates, plant_model_of
from ftac_gym.baselines.estimators.plant_estimator import PlantEstimator, PlantSummary
from ftac_gym.baselines.estimators.prediction import DelayPrediction
from ftac_gym.baselines.gains import Gains, parameter
from ftac_gym.baselines.memory import Memory
from ftac_gym.baselines.rules import choice, interval
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, flag


@dataclass(frozen=True)
class NavigationGains(Gains):
    """Gains of :class:`Navigator` in a controller."""

    filter: str = parameter(
        "auto",
        "Attitude filter. ``auto`` is ``kalman`` where the scenario has a star tracker and gyros, else ``none``",
        rule=choice("auto", "kalman", "none"),
    )
    gate: float = parameter(
        0.9999,
        "Probability with which the innovation gate accepts a good sample of the star tracker. 1 for no gate",
        rule=interval(0.0, 1.0, closed=True),
    )
    prediction: bool = parameter(True, "Whether attitude and rate are predicted over the loop delay", rule=flag)
    isolation: str = parameter(
        "none",
        "Isolation of faulty wheels: from the rate, or from the rate and telemetry. ``auto`` is ``rate`` for a rigid "
        "spacecraft whose wheels have torque limits, else ``none``",
        rule=choice("auto", "rate", "telemetry", "none"),
    )


@dataclass(frozen=True, eq=False)
class Navigated(Measurement):
    """A measurement that has passed the estimators of a controller."""


class Navigator:
    """Estimators that turn a measurement into that of the moment at which the next command takes effect.

    A controller behind them sees a filtered attitude, a rate without bias, and a loop without delay. Its own observers
    find in the command given last the one that explains the motion.

    Parameters
    ----------
    scenario
        The task.
    memory
        Store of the state.
    gains
        Gains.

    Raises
    ------
    ValueError
        If a filter is asked for without gyros, or isolation for a flexible spacecraft or wheels without torque limits.
    """

    def __init__(self, scenario: Scenario, memory: Memory, gains: NavigationGains) -> None:
        self._moving = scenario.reference.moving
        self._coupled = scenario.spacecraft.wheels.momentum_coupling
        self.filter: AttitudeKalmanFilter | None = None
        """The attitude filter, or None."""
        if gains.filter == "kalman" or (gains.filter == "auto" and has_both_sensors(scenario)):
            self.filter = AttitudeKalmanFilter(attitude_model_of(scenario, gains.gate), memory)
        self.estimator: PlantEstimator | None = None
        """The estimator of faulty wheels, or None."""
        if gains.isolation in ("rate", "telemetry") or (gains.isolation == "auto" and isolates(scenario)):
            model = plant_model_of(scenario, gains.isolation == "telemetry")
            self.estimator = PlantEstimator(model, memory)
        self.prediction: DelayPrediction | None = None
        """The prediction, or None."""
        if gains.prediction and (scenario.loop_delay > 0.0 or self.estimator is not None):
            self.prediction = DelayPrediction(scenario, memory, alone=self.estimator is None)
        telemetry = self.estimator is not None and gains.isolation == "telemetry"
        self.information = "telemetry" if telemetry else "attitude"
        """Tier of the information that it uses."""

    def update(self, measurement: Measurement) -> tuple[Measurement, PlantEstimate | None]:
        """Take in a measurement.

        Returns
        -------
        The measurement of the moment at which the next command takes effect, and the estimate of the plant then: None
        without isolation.
        """
        attitude, rate = measurement.attitude, measurement.rate
        if self.filter is not None:
            attitude, rate = self.filter.update(measurement)
        own, summary = self.estimator, None
        if own is not None:
            own.update(measurement, attitude, rate)
            summary = own.summary(attitude)
        time, explains = measurement.time, measurement.command_in_effect
        reference, reference_rate = measurement.reference_attitude, measurement.reference_rate
        if self.prediction is not None:
            attitude, rate, delays = self._ahead(self.prediction, measurement, attitude, rate, summary)
            time, explains = time + delays, measurement.last_command
            if self._moving:
                delay, acceleration = delays[:, None], measurement.reference_acceleration
                turn = delay * (reference_rate + (0.5 * delay) * acceleration)
                reference = quaternion_product(reference, quaternion_from_rotation_vector(turn))
                reference_rate = reference_rate + delay * acceleration
        navigated = Navigated(
            time,
            attitude,
            rate,
            measurement.wheel_momentum,
            measurement.last_command,
            measurement.star_tracker_valid,
            reference,
            reference_rate,
            measurement.reference_acceleration,
            measurement.truth,
            measurement.modal_displacement,
            measurement.modal_rate,
            explains,
            measurement.attitude_age,
        )
        return navigated, None if own is None or summary is None else own.plant(summary)

    def _ahead(
        self,
        prediction: DelayPrediction,
        measurement: Measurement,
        attitude: FloatArray,
        rate: FloatArray,
        summary: PlantSummary | None,
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Predict as :class:`DelayPrediction` does; carry the summary's momentum on."""
        if summary is None or self.estimator is None:
            return prediction.nominal(measurement, attitude, rate)
        if not self._coupled:
            summary.momentum[:] = np.einsum("nij,nj->ni", summary.inertia, rate)
        torque = np.ascontiguousarray(self.estimator.unexplained)
        return prediction.ahead(
            measurement,
            attitude,
            rate,
            summary.inertia,
            summary.momentum,
            torque,
            summary.response,
            summary.level,
            summary.late,
        )

    @property
    def estimate(self) -> FaultEstimate | None:
        """The latest estimate of the faults; None without isolation."""
        return None if self.estimator is None else self.estimator.estimate
