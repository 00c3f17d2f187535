"""The multiple-model estimator of inertia, momentum and faulty wheels as a component."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ftac_gym.baselines.components.slew_profile import PlantEstimate
from ftac_gym.baselines.estimate import FaultEstimate, WheelCondition
from ftac_gym.baselines.estimators.plant_kernel import estimate_plant, summarise
from ftac_gym.baselines.estimators.plant_state import PLANT_STATE, PlantModel
from ftac_gym.baselines.estimators.wheel_kernel import WHEEL_STATE
from ftac_gym.baselines.memory import Memory
from ftac_gym.task.measurement import Measurement
from ftac_gym.utils.parameters import FloatArray


class PlantSummary(NamedTuple):
    """Estimates of N spacecraft with m wheels, for controllers and prediction.

    Attributes
    ----------
    inertia
        (N, 3, 3) [kg m^2].
    momentum
        (N, 3) total angular momentum, in body axes [N m s].
    response
        (N, m) torque of each wheel over its command, besides a constant.
    level
        (N, m) torque that each wheel gives besides its response to the command [N m].
    missing_torque
        (N, 3) torque on the body of the latter, in body axes [N m].
    usable
        (N, m) usable share of each wheel's torque limit.
    late
        (N,) delay of the loop beyond the nominal one [control periods].
    """

    inertia: FloatArray
    momentum: FloatArray
    response: FloatArray
    level: FloatArray
    missing_torque: FloatArray
    usable: FloatArray
    late: npt.NDArray[np.int64]


class PlantEstimator:
    """Inertia, angular momentum, missing torque and condition of every wheel, from rate and commands.

    See :mod:`~ftac_gym.baselines.estimators.plant_kernel` for the method.

    Parameters
    ----------
    model
        Nominal spacecraft, see :func:`~ftac_gym.baselines.estimators.models.plant_model_of`.
    memory
        Store of the state.
    """

    def __init__(self, model: PlantModel, memory: Memory) -> None:
        self.model = model
        self._memory = memory
        wheels = len(model.limits)
        nominal = np.zeros((), PLANT_STATE)
        nominal["parameters"] = model.start
        memory.add("plant", (), initial=nominal)
        initial = np.zeros((), WHEEL_STATE)
        initial["effectiveness"] = 1.0
        memory.add("wheels", (wheels,), initial=initial)
        memory.add("momentum_before", (wheels,))

    def update(self, measurement: Measurement, attitude: FloatArray, rate: FloatArray) -> None:
        """Take in a measurement.

        Parameters
        ----------
        measurement
            Source of the command in effect and of the wheel momenta.
        attitude, rate
            Filtered attitude (N, 4), and rate without bias (N, 3) [rad/s].
        """
        memory, before = self._memory, self._memory["momentum_before"].copy()
        estimate_plant(
            memory["plant"],
            memory["wheels"],
            self.model,
            attitude,
            rate,
            measurement.command_in_effect,
            measurement.wheel_momentum,
            before,
        )
        memory["momentum_before"] = before

    def summary(self, attitude: FloatArray) -> PlantSummary:
        """Return what the state says at an attitude (N, 4)."""
        plant, wheels = self._memory["plant"], self._memory["wheels"]
        count, number = wheels.shape
        result = PlantSummary(
            inertia=np.empty((count, 3, 3)),
            momentum=np.empty((count, 3)),
            response=np.empty((count, number)),
            level=np.empty((count, number)),
            missing_torque=np.empty((count, 3)),
            usable=np.empty((count, number)),
            late=np.empty(count, dtype=np.int64),
        )
        summarise(plant, wheels, self.model, attitude, *result)
        return result

    @property
    def unexplained(self) -> FloatArray:
        """(N, 3) low-passed torque that neither commands nor estimated faults explain, in body axes [N m]."""
        torque: FloatArray = self._memory["plant"]["slow"].copy()
        return torque

    def plant(self, summary: PlantSummary) -> PlantEstimate:
        """Return the estimate of the plant for a controller."""
        return PlantEstimate(
            inertia=summary.inertia,
            momentum=summary.momentum if self.model.coupled else None,
            missing_torque=summary.missing_torque,
            usable=summary.usable,
            residual=self._memory["plant"]["rest"].copy(),
        )

    @property
    def estimate(self) -> FaultEstimate:
        """The latest estimate of the faults."""
        wheels = self._memory["wheels"]
        condition = wheels["kind"].copy()
        constant = np.isin(condition, (WheelCondition.BIAS, WheelCondition.UNKNOWN, WheelCondition.LOCK))
        dead = np.isin(condition, (WheelCondition.LOCK, WheelCondition.OUTAGE))
        return FaultEstimate(
            disturbance=self.unexplained,
            effectiveness=np.where(dead, 0.0, wheels["effectiveness"]),
            bias=np.where(constant, wheels["level"], 0.0),
            identifiable=condition != WheelCondition.UNKNOWN,
            alarm=condition != WheelCondition.HEALTHY,
            condition=condition,
            delay=wheels["delay"].copy(),
        )
