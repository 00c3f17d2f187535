"""Controllers that compute a torque from the errors, without an estimate of the faults."""

from __future__ import annotations

from ftac_gym.baselines.components.allocation import MinimaxAllocation, within_limits
from ftac_gym.baselines.controllers.filtered import FilteredController
from ftac_gym.utils.parameters import FloatArray


class DirectController(FilteredController):
    """Attitude filter, errors and wheels of a controller; the torque is defined by the subclass.

    Three wheels are limited one by one, as in the papers. Redundant wheels get the command with the smallest largest
    share and are scaled together at the limits, which keeps the direction of the torque.
    """

    def _build(self) -> None:
        super()._build()
        self._minimax = MinimaxAllocation(self.scenario.spacecraft.wheels)

    def _to_wheels(self, torque: FloatArray) -> FloatArray:
        """Return wheel torques (N, m) [N m] within the limits for a torque (N, 3) [N m] on the body."""
        plant = self.plant
        command = self._minimax(torque) if plant is None else self._to_usable_wheels(torque, plant)
        return within_limits(command, self._torque_limits)
