"""Base of the controllers whose gains are in units of the scenario."""

from __future__ import annotations

from collections.abc import Mapping

from ftac_gym.baselines.baseline import Baseline
from ftac_gym.baselines.units import Scales, factors_of, physical
from ftac_gym.utils.parameters import FloatArray


class ScaledController(Baseline):
    """A controller with gains in the units of :mod:`ftac_gym.baselines.units`.

    ``gains`` holds them as they are given, ``scheduled`` in SI units.
    """

    def _build(self) -> None:
        self.scales = Scales.of(self.scenario)
        """The sizes of the scenario."""
        self._factors = factors_of(self.gains, self.scales)
        self.scheduled = physical(self.gains, self._factors)
        super()._build()

    def _schedule(self, gains: Mapping[str, FloatArray]) -> None:
        super()._schedule(gains)
        self.scheduled = physical(self.scheduled, self._factors)
