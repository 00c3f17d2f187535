"""The multiple-model estimator of faulty wheels as a fault observer."""

from __future__ import annotations

from dataclasses import dataclass

from ftac_gym.baselines.estimate import FaultEstimate
from ftac_gym.baselines.estimators.kalman_filter import AttitudeKalmanFilter
from ftac_gym.baselines.estimators.models import attitude_model_of, has_both_sensors, plant_model_of
from ftac_gym.baselines.estimators.plant_estimator import PlantEstimator
from ftac_gym.baselines.gains import Gains, parameter
from ftac_gym.baselines.observers.observer import FaultObserver
from ftac_gym.baselines.rules import interval
from ftac_gym.task.measurement import Measurement
from ftac_gym.utils.parameters import FloatArray, positive


@dataclass(frozen=True)
class MultipleModelGains(Gains):
    """Gains of :class:`MultipleModelObserver`."""

    threshold: float = parameter(60.0, "Score of a faulty wheel", "", positive)
    margin: float = parameter(
        10.0, "Least difference of twice the logarithms of likelihood between two kinds of fault", "", positive
    )
    gate: float = parameter(
        0.9999, "Probability with which the filter accepts a good sample", "", interval(0.0, 1.0, closed=True)
    )


class MultipleModelObserver(FaultObserver):
    """Condition of every wheel from rate and commands: effectiveness, bias, lock, outage or delay.

    Controllers have the same estimator in front of them by ``isolation``; this form is for wrappers, for the residuals
    of learned policies, and for recording. The filter of attitude and gyro bias comes with it where the scenario has
    both sensors.

    Raises
    ------
    ValueError
        If a gain breaks a rule, the spacecraft is flexible, or a wheel has no torque limit.
    """

    gains = MultipleModelGains()
    telemetry = False

    def _build(self) -> None:
        super()._build()
        model = plant_model_of(self._scenario, self.telemetry)
        model = model._replace(threshold=self.gains.threshold, margin=self.gains.margin)
        self._filter: AttitudeKalmanFilter | None = None
        # Behind the filter of a controller there is nothing left to filter.
        if has_both_sensors(self._scenario) and not self._memory.has("attitude_filter"):
            self._filter = AttitudeKalmanFilter(attitude_model_of(self._scenario, self.gains.gate), self._memory)
        self._estimator = PlantEstimator(model, self._memory)

    def update(self, measurement: Measurement, command: FloatArray, dt: float) -> FaultEstimate:
        """Take in a measurement; its command in effect is that of the period which ends with it."""
        attitude, rate = measurement.attitude, measurement.rate
        if self._filter is not None:
            attitude, rate = self._filter.update(measurement)
        self._estimator.update(measurement, attitude, rate)
        return self.estimate

    @property
    def estimate(self) -> FaultEstimate:
        """The latest estimate."""
        return self._estimator.estimate


class MultipleModelTelemetryObserver(MultipleModelObserver):
    """The same with the momentum of every wheel from its tachometer."""

    information = "telemetry"
    telemetry = True
