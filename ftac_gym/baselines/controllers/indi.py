"""Incremental nonlinear dynamic inversion of the measured angular acceleration."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ftac_gym.baselines.controllers.pd import PD, PDGains
from ftac_gym.baselines.estimate import FaultEstimate
from ftac_gym.baselines.gains import Range, changed, parameter
from ftac_gym.baselines.units import PER_LOOP
from ftac_gym.task.measurement import Measurement
from ftac_gym.utils.parameters import FloatArray, positive


@dataclass(frozen=True)
class INDIGains(PDGains):
    """Gains of :class:`INDI`."""

    braking_share: float = changed(PDGains, "braking_share", 0.85)
    rate_gain: float = changed(PDGains, "rate_gain", 1.6)
    position_gain: float = changed(PDGains, "position_gain", 0.75)
    filter_bandwidth: float = parameter(
        0.25, "Bandwidth of each stage of the filter", PER_LOOP, positive, Range(0.04, 2.0, log=True), (0.04, 2.0)
    )


class INDI(PD):
    """Incremental nonlinear dynamic inversion: the last torque, corrected by what is missing of an acceleration.

    ::

        D u = D u0_f + J (nu - w'_f) + g - g_f

    where ``pd`` demands the acceleration nu along the slew profile. The command in effect is u0, and w' the difference
    of two rates. With the momentum measured or estimated, g is the gyroscopic torque. The index f marks a low-pass
    filter of two equal stages. Torque and acceleration pass the same filter and stay synchronous: it delays the
    correction, not the inversion (Smeur, Chu and de Croon 2016; for spacecraft Acquatella et al. 2012).

    Where faulty wheels are isolated, the model of the motion is that of the estimators, and the allocation takes the
    torque of these wheels off. All other torque enters by the measured acceleration alone. Of the model, the increment
    needs J and D. u0 is a command within the limits of the wheels, so that nothing winds up in saturation. The law does
    not adapt the effectiveness of the wheels by itself: a wrong one changes the size of an increment, not the torque in
    balance.

    Raises
    ------
    ValueError
        If a gain breaks a rule or a wheel has no torque limit.
    """

    gains = INDIGains()

    def _build(self) -> None:
        super()._build()
        self._axes_transposed = self.scenario.spacecraft.wheels.axis_matrix.T.copy()
        memory = self.memory
        memory.add("last_rate", (3,))
        memory.add("unstarted", (1,), initial=True)
        # Torque that the motion shows beyond that of the command, after one stage of the filter and after two.
        memory.add("half_filtered", (3,))
        memory.add("filtered", (3,))
        self._set_bandwidth()

    def _set_bandwidth(self) -> None:
        self._stage: float | FloatArray = 1.0 - np.exp(-self.scheduled.filter_bandwidth * self._period)

    def _schedule(self, gains: Mapping[str, FloatArray]) -> None:
        super()._schedule(gains)
        self._set_bandwidth()

    def act(self, measurement: Measurement) -> FloatArray:
        """Return the wheel torques to command, (N, wheels) [N m]."""
        self._filter_together(measurement)
        return self._to_wheels(self._demand(measurement) - self.memory["filtered"])

    def _filter_together(self, measurement: Measurement) -> None:
        """Take the last period into the filter.

        The filter is linear: it may take the sum of J w', g and -D u0 instead of each.
        """
        memory = self.memory
        beyond = self._beyond_command(measurement)
        # A spacecraft just reset has no period behind it.
        half, filtered = memory["half_filtered"], memory["filtered"]
        half = half + self._stage * (np.where(memory["unstarted"], 0.0, beyond) - half)
        memory["half_filtered"], memory["filtered"] = half, filtered + self._stage * (half - filtered)
        memory["last_rate"], memory["unstarted"] = measurement.rate, np.zeros_like(memory["unstarted"])

    def _beyond_command(self, measurement: Measurement) -> FloatArray:
        """Return J w' + g - D u0 of the last period, (N, 3) [N m], without the torque of isolated wheels."""
        if self.plant is not None and self.plant.residual is not None:
            return self.plant.residual
        acceleration = (measurement.rate - self.memory["last_rate"]) / self._period
        torque = measurement.command_in_effect @ self._axes_transposed
        return self._torque(acceleration) + self._gyroscopic_torque(measurement) - torque

    @property
    def estimate(self) -> FaultEstimate:
        """The torque that the command does not explain, filtered, and the estimate of the isolation."""
        return self._estimate_with(self.memory["filtered"])
