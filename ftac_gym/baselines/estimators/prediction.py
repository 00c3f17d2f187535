"""Prediction of attitude and rate over the loop delay as a component."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ftac_gym.attitude import cross
from ftac_gym.baselines.estimators.plant_kernel import SMOOTH
from ftac_gym.baselines.estimators.prediction_kernel import predict
from ftac_gym.baselines.estimators.wheel_kernel import LONGEST_LOOP
from ftac_gym.baselines.memory import Memory
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray


class DelayPrediction:
    """Attitude and rate at the moment at which the next command takes effect.

    The commands that take effect until then are known, and so is their torque. The loop behind the prediction has no
    delay (the predictor of Smith, 1957, in the form of Artstein, IEEE T-AC 27(4), 1982, for states).

    Parameters
    ----------
    scenario
        The task.
    memory
        Store of the commands on their way.
    alone
        Whether the prediction is by the nominal spacecraft, without an estimator of the plant.
    """

    def __init__(self, scenario: Scenario, memory: Memory, alone: bool = True) -> None:
        self._memory = memory
        wheels = scenario.spacecraft.wheels
        self._axes = np.ascontiguousarray(wheels.axis_matrix.T)
        self._whole, part = divmod(scenario.delay_steps, scenario.substeps)
        self._first = part * scenario.physics_step
        self._nominal = scenario.loop_delay
        self._inertia, self._period = scenario.spacecraft.inertia_matrix, scenario.control_period
        # Without an estimate of the stored momentum, its half that the body has is left out too.
        self._ideal = not wheels.momentum_coupling
        length = self._whole + bool(part) + (0 if alone else LONGEST_LOOP)
        memory.add("commands_on_their_way", (length, wheels.count))
        if alone:
            memory.add("predicted_from", (3,), initial=np.nan)
            memory.add("unexplained_torque", (3,))

    def nominal(
        self, measurement: Measurement, attitude: FloatArray, rate: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Take in a measurement, and predict by the nominal spacecraft and the torque that it leaves unexplained.

        Without that torque the prediction is wrong by a constant under a constant disturbance.

        Parameters
        ----------
        measurement
            Source of the commands.
        attitude, rate
            Attitude (N, 4) and rate (N, 3) [rad/s] now.
        """
        memory = self._memory
        momentum = rate @ self._inertia if self._ideal else np.zeros_like(rate)
        before = memory["predicted_from"]
        change = (rate - before) / self._period
        residual = change @ self._inertia - measurement.command_in_effect @ self._axes
        if self._ideal:
            residual += cross(rate, momentum)
        torque = memory["unexplained_torque"]
        # A spacecraft just reset has no period behind it to balance.
        torque = torque + SMOOTH * np.where(np.isnan(before), 0.0, residual - torque)
        memory["predicted_from"], memory["unexplained_torque"] = rate, torque
        inertia = np.repeat(self._inertia[None], len(rate), axis=0)
        count, wheels = measurement.last_command.shape
        none, one, zero = np.zeros(count, dtype=np.int64), np.ones((count, wheels)), np.zeros((count, wheels))
        return self.ahead(measurement, attitude, rate, inertia, momentum, torque, one, zero, none)

    def ahead(
        self,
        measurement: Measurement,
        attitude: FloatArray,
        rate: FloatArray,
        inertia: FloatArray,
        momentum: FloatArray,
        torque: FloatArray,
        response: FloatArray,
        level: FloatArray,
        late: npt.NDArray[np.int64],
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Take in a measurement, and predict attitude and rate.

        The momentum is carried on in place, since its body axes turn.

        Parameters
        ----------
        measurement
            Source of the command given last.
        attitude, rate
            Attitude (N, 4) and rate (N, 3) [rad/s] now.
        inertia
            (N, 3, 3) [kg m^2].
        momentum
            (N, 3) total angular momentum, in body axes [N m s].
        torque
            (N, 3) torque on the body besides that of the wheels, in body axes [N m].
        response, level
            (N, m) torque of each wheel over its command, and besides it [N m].
        late
            (N,) delay of the loop beyond the nominal one [control periods].

        Returns
        -------
        Attitude (N, 4) and rate (N, 3) [rad/s] after the loop delay, and that delay (N,) [s].
        """
        queue = measurement.last_command[:, None]
        before = self._memory["commands_on_their_way"]
        if before.shape[1] > 1:
            queue = np.concatenate([before[:, 1:], queue], axis=1)
        self._memory["commands_on_their_way"] = queue
        attitude, rate = np.array(attitude), np.array(rate)
        predict(
            attitude, rate, inertia, momentum, torque, np.ascontiguousarray(queue), response, level, late,
            self._axes, self._first, self._period, self._whole,
        )  # fmt: skip
        delay: FloatArray = self._nominal + self._period * late.astype(np.float64)
        return attitude, rate, delay
