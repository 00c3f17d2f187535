"""A terminal sliding-mode controller: the comparator of Cao, Gong and Han 2022."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from ftac_gym.attitude import mrp_derivative
from ftac_gym.baselines.components.reaching import PowerReaching
from ftac_gym.baselines.components.surfaces import FastTerminalSurface
from ftac_gym.baselines.controllers.relative import RelativeController
from ftac_gym.baselines.gains import Range, SearchSpace
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, fields_named


class TSMCClass(RelativeController):
    """s = w_e + a sigma + b sig(sigma)^p with s' = -k s - l sig(s)^g.

    Of the comparator [10] (Zhang, Biggs, Ye and Sun 2020) the paper gives neither equations nor parameters; this is a
    member of its family, finite-time terminal sliding mode in MRPs, with gains of our own.

    Parameters
    ----------
    scenario, num_spacecraft
        As for every baseline.
    faults, observer
        Where the estimates of the faults come from.
    linear, terminal, exponent, guard
        a, b [rad/s], p, and where the slope of the power is held, see
        :class:`~ftac_gym.baselines.components.surfaces.FastTerminalSurface`.
    reaching_linear, reaching_power_gain, reaching_exponent
        k [1/s], l, g.
    attitude_filter_time
        Time constant of the attitude filter [s]; zero for none.

    Raises
    ------
    ValueError
        If a gain breaks a rule.
    """

    search_space: ClassVar[SearchSpace] = {
        "linear": Range(0.01, 1.0, log=True),
        "terminal": Range(0.01, 1.0, log=True),
        "exponent": Range(0.5, 0.95),
        "guard": Range(1e-5, 0.1, log=True),
        "reaching_linear": Range(0.1, 8.0, log=True),
        "reaching_power_gain": Range(1e-3, 1.0, log=True),
        "attitude_filter_time": Range(0.0, 5.0),
    }

    def __init__(
        self,
        scenario: Scenario,
        num_spacecraft: int = 1,
        faults: str = "none",
        observer: Mapping[str, Any] | None = None,
        linear: float = 0.3,
        terminal: float = 0.3,
        exponent: float = 5.0 / 7.0,
        guard: float = 0.02,
        reaching_linear: float = 1.0,
        reaching_power_gain: float = 0.2,
        reaching_exponent: float = 0.5,
        attitude_filter_time: float = 0.0,
    ) -> None:
        super().__init__(
            scenario, num_spacecraft, faults=faults, observer=observer, attitude_filter_time=attitude_filter_time
        )
        self._surface = FastTerminalSurface(linear, terminal, exponent, guard)
        with fields_named("reaching_"):
            self._reaching = PowerReaching(reaching_linear, reaching_power_gain, reaching_exponent)

    def _variable(self, measurement: Measurement, error: FloatArray, rate_error: FloatArray) -> FloatArray:
        return rate_error + self._surface(error)[0]

    def _acceleration(self, measurement: Measurement, error: FloatArray, rate_error: FloatArray) -> FloatArray:
        term, slope = self._surface(error)
        return self._reaching(rate_error + term) - slope * mrp_derivative(error, rate_error)
