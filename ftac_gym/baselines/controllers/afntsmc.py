"""The adaptive non-singular terminal sliding mode of Lu and Xia 2013, comparator of Ma, Wang and Wang 2023."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from ftac_gym.baselines.components.adaptation import LeakyAdaptation
from ftac_gym.baselines.components.reaching import PowerReaching
from ftac_gym.baselines.components.surfaces import NonsingularTerminalSurface
from ftac_gym.baselines.controllers.hybrid import HybridController
from ftac_gym.baselines.gains import Range, SearchSpace
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, fields_named, positive


class AFNTSMC(HybridController):
    """Eqs. (45)-(52) of Ma et al. 2023.

        S = w_e + k2 e_v + k3 S_au(e_v),  S_au = sig(e)^nu outside |e| = bound, a parabola inside
        u = -tau S - b0 sig(S)^x0 - X S,  X_i = (psi_i / e5^2 + phi_i |xi|^2 / e6^2) / 2
        psi_i' = -e3 psi_i + n1 S_i^2 / (2 e5^2)
        phi_i' = -e4 phi_i + n2 S_i^2 |xi|^2 / (2 e6^2),  |xi| = max(|w|^2, |w|)

    with e3 = e4, e5 = e6 and n1 = n2, as all their values are. The paper tests S with the power on the whole axis for
    being zero as well; a sampled S never is. There is no feed-forward: what the reference needs is left to X. The law
    goes to e_4 = 1, the long way round if the quaternion starts with e_4 < 0: ``hysteresis`` would mend that.

    Parameters
    ----------
    scenario, num_spacecraft
        As for every baseline.
    linear, terminal
        k2, k3 [rad/s].
    exponent
        nu = nu1 / nu2.
    bound
        epsilon of the surface.
    reaching_linear, reaching_power_gain, reaching_exponent
        tau [N m s/rad], beta_0, chi_0.
    adaptation
        n1 = n2.
    forgetting
        e3 = e4 [1/s].
    width
        e5 = e6.
    initial_bound
        psi(0) = phi(0).
    hysteresis
        As for :class:`~ftac_gym.baselines.controllers.hsfc.HSFC`; None, as printed, unwinds.
    attitude_filter_time
        Time constant of the attitude filter [s]; zero for none.

    Raises
    ------
    ValueError
        If a gain breaks a rule.
    """

    search_space: ClassVar[SearchSpace] = {
        "linear": Range(0.005, 1.0, log=True),
        "terminal": Range(0.005, 1.0, log=True),
        "exponent": Range(0.5, 0.95),
        "bound": Range(1e-3, 0.2, log=True),
        "reaching_linear": Range(1.0, 100.0, log=True),
        "reaching_power_gain": Range(1e-3, 10.0, log=True),
        "adaptation": Range(1e-4, 6.0, log=True),
        "attitude_filter_time": Range(0.0, 5.0),
    }

    def __init__(
        self,
        scenario: Scenario,
        num_spacecraft: int = 1,
        linear: float = 1.0,
        terminal: float = 1.0,
        exponent: float = 0.6,
        bound: float = 1e-3,
        reaching_linear: float = 20.0,
        reaching_power_gain: float = 10.0,
        reaching_exponent: float = 0.5,
        adaptation: float = 6.0,
        forgetting: float = 0.35,
        width: float = 0.16,
        initial_bound: float = 0.1,
        hysteresis: float | None = None,
        attitude_filter_time: float = 0.0,
    ) -> None:
        super().__init__(scenario, num_spacecraft, hysteresis, attitude_filter_time)
        self._surface = NonsingularTerminalSurface(linear, terminal, exponent, bound)
        with fields_named("reaching_"):
            self._reaching = PowerReaching(reaching_linear, reaching_power_gain, reaching_exponent)
        self._half = 0.5 / positive(width, "width") ** 2
        with fields_named(gain="adaptation", leak="forgetting", initial="initial_bound"):
            self._still, self._turning = (
                LeakyAdaptation(self.memory, name, 3, adaptation, forgetting, self._period, initial_bound)
                for name in ("bound_at_rest", "bound_in_motion")
            )

    def sliding_variable(self, measurement: Measurement) -> FloatArray:
        """Return S (N, 3) [rad/s] at a measurement, for its unfiltered attitude."""
        motion = self._motion(measurement.attitude, measurement, short_way=False)
        error, logic = self._hybrid.peek(motion.error)
        variable: FloatArray = motion.rate_error + self._surface(logic * error[:, 1:])[0]
        return variable

    def act(self, measurement: Measurement) -> FloatArray:
        """Return the wheel torques to command, (N, wheels) [N m]."""
        motion = self._motion(self._filter.update(measurement), measurement, short_way=False)
        error, logic = self._hybrid.update(motion.error)
        variable = motion.rate_error + self._surface(logic * error[:, 1:])[0]
        square = np.einsum("ni,ni->n", measurement.rate, measurement.rate)[:, None]
        growth = np.maximum(square * square, square)
        adaptive = self._half * (self._still.value + self._turning.value * growth)
        torque = self._reaching(variable) - adaptive * variable
        drive = self._half * variable * variable
        self._still.update(drive)
        self._turning.update(drive * growth)
        return self._to_wheels(torque)
