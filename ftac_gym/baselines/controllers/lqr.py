"""Linear-quadratic regulation of the error, limited by the slew profile."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ftac_gym.baselines.components.allocation import pseudo_inverse
from ftac_gym.baselines.components.linear_quadratic import regulator, sampled_body
from ftac_gym.baselines.controllers.profile import ProfileController, ProfileGains
from ftac_gym.baselines.estimate import FaultEstimate
from ftac_gym.baselines.gains import Range, changed, parameter
from ftac_gym.baselines.observers.disturbance_observer import DisturbanceObserver
from ftac_gym.baselines.units import PER_LOOP
from ftac_gym.task.measurement import Measurement
from ftac_gym.utils.parameters import FloatArray, positive


@dataclass(frozen=True)
class LQRGains(ProfileGains):
    """Gains of :class:`LQR`."""

    braking_share: float = changed(ProfileGains, "braking_share", 0.85)
    angle_weight: float = parameter(3.0, "p, of the error angle", "", positive, Range(0.01, 20.0, log=True))
    rate_weight: float = parameter(6.0, "d, of the rate error", "", positive, Range(0.05, 20.0, log=True))
    bandwidth: float = parameter(
        0.12, "Bandwidth of the observer", PER_LOOP, positive, Range(0.02, 1.0, log=True), (0.02, 1.0)
    )


class LQR(ProfileController):
    """Linear-quadratic regulator on an error that the slew profile limits, with a disturbance observer.

    Small errors x = (phi, w_e), with the rotation vector phi = theta n of the error, follow phi' = w_e, J w_e' = tau.
    For a torque that is held for the control period, tau = -K1 phi - K2 w_e minimises the sum over all periods of::

        p |S J phi / L^2|^2 + d |S J w_e / L|^2 + |S tau|^2,    S = diag(1 / limit_j) D^+

    (Bryson and Ho 1975). S gives the shares of the wheels' limits that a torque takes, and L is the time of the loop.
    Every term is thus in shares of the wheels, and the weights suit any spacecraft. One matrix S in all terms makes
    K1 = k1 J and K2 = k2 J, with numbers k1 and k2 that depend on p, d and T / L alone. An error then keeps its axis
    (Wie, Weiss and Arapostathis 1989), and every axis has the same margin of delay.

    The regulator is right for small errors only: at a large angle it asks for a rate at which no wheel can stop. Its
    pull towards the target, of k1 theta, is therefore limited to that of a law that follows the slew profile::

        torque = J (-n min(k1 theta, k2 s - s') - k2 w_e)

    where s is the rate of the profile of slope c = k1 / k2 at the angle theta + a / k1 and s' its deceleration. The
    second term is then the tangent of the first where braking begins, at theta = a / c^2 - a / k1. Up to there torque
    and poles are those of the regulator; beyond, the motion in balance is w_e = -s n. A limit of the error, instead of
    gains that change, keeps the damping along the whole slew. Wie, Bailey and Heiberg 2002 limit the error in the same
    way, without a feed-forward of the deceleration.

    Close to the target the pull is also limited, so that the way back from a disturbance stays on target::

        pull <= k2 v_c + k1 max(theta - theta_c, 0)

    theta_c is a share of the success cone, v_c half of the largest rate of success.

    Raises
    ------
    ValueError
        If a gain breaks a rule or a wheel has no torque limit.
    """

    gains = LQRGains()

    def _build(self) -> None:
        super()._build()
        own: LQRGains = self.scheduled
        shares = pseudo_inverse(self.scenario.spacecraft.wheels.axis_matrix) / self._torque_limits[:, None]
        effort, inertia, loop = shares.T @ shares, self._inertia, self.scales.loop_time
        weights = np.diag([own.angle_weight / loop**4, own.rate_weight / loop**2])
        state = np.kron(weights, inertia @ effort @ inertia).astype(np.float64)
        self.regulator = regulator(*sampled_body(inertia, self._period), state, effort)
        """K (3, 6), from rotation vector [rad] and rate error [rad/s] to the torque [N m] that they ask for."""
        per_inertia = np.linalg.solve(inertia, self.regulator)
        self._stiffness, self._damping = (float(np.trace(part)) / 3.0 for part in np.hsplit(per_inertia, 2))
        self._observer = DisturbanceObserver(self.scenario, self.memory, own.bandwidth, self._gyroscopic)

    def _schedule(self, gains: Mapping[str, FloatArray]) -> None:
        super()._schedule(gains)
        self._observer.set_bandwidth(self.scheduled.bandwidth)

    def act(self, measurement: Measurement) -> FloatArray:
        """Return the wheel torques to command, (N, wheels) [N m]."""
        own: LQRGains = self.scheduled
        motion = self._motion(measurement, move_on=True)
        slew = self._slew(motion.error, self._stiffness / self._damping, self._stiffness)
        pull = np.minimum(self._stiffness * slew.angle, self._damping * slew.speed - slew.deceleration)
        if own.calm_share > 0.0:
            # The profile is asked at a shifted angle, where its own calm rate has no meaning.
            success = self.scenario.success
            beyond = np.maximum(slew.angle - own.calm_share * success.angle, 0.0)
            pull = np.minimum(pull, self._damping * (0.5 * success.rate) + self._stiffness * beyond)
        acceleration = -pull * slew.axis - self._damping * motion.rate_error
        if self._moving:
            acceleration += motion.feed_forward(measurement)
        torque = self._torque(acceleration) + self._gyroscopic_torque(measurement)
        residual = None if self.plant is None else self.plant.residual
        return self._to_wheels(torque - self._observer.update(measurement, residual))

    @property
    def estimate(self) -> FaultEstimate:
        """The estimated torque, and that of the isolation."""
        return self._estimate_with(self._observer.disturbance)
