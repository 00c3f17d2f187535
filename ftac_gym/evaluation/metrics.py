"""Time histories of episodes, and their metrics, one value for each episode."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ftac_gym.attitude import mrp_from_quaternion, quaternion_error, rotation_vector_from_quaternion
from ftac_gym.baselines import FaultEstimate
from ftac_gym.task.episodes import Episodes
from ftac_gym.task.scenario import Scenario, success_steps
from ftac_gym.task.vibration import modal_energy, vibration_torque
from ftac_gym.utils.parameters import FloatArray

Metrics = dict[str, FloatArray]

HIGHER_IS_BETTER = frozenset({"availability", "success", "return", "bound_kept", "bound_margin"})
"""Metrics that are better if they are larger; all others are better if they are smaller."""

SHARES = frozenset({"availability", "success", "bound_kept"})
"""Metrics with a mean that is a share itself, of the time or of the episodes; others have robust statistics."""

PARTIAL = frozenset({"peak_after_fault", "recovery_time"})
"""Metrics that are defined for some episodes of a task and not for others: a count belongs beside them."""

UNITS: dict[str, str] = {
    "availability": "share",
    "success": "share",
    "settling_time": "s",
    "final_error": "deg",
    "final_error_95": "deg",
    "integrated_error": "deg s",
    "peak_after_fault": "deg",
    "recovery_time": "s",
    "energy": "N2 m2 s",
    "chatter": "N m/s",
    "saturation": "share",
    "path_ratio": "-",
    "bound_kept": "share",
    "bound_margin": "-",
    "jitter": "deg",
    "modal_energy": "J s",
    "residual_energy": "J",
    "vibration_torque": "N m",
    "return": "-",
}
"""Unit of each metric, in the order of tables."""


@dataclass(frozen=True, eq=False)
class Rollout:
    """Time histories of N episodes of T control periods; the truth, not the measurement.

    Attributes
    ----------
    scenario, episodes
        Task and episodes.
    time
        (T + 1,) [s].
    attitude_error
        (T + 1, N) pointing error [rad].
    rate_error
        (T + 1, N) magnitude of the rate error [rad/s].
    attitude
        (T + 1, N, 4) quaternions.
    reference_attitude
        (T + 1, N, 4) quaternions of the reference.
    rate
        (T + 1, N, 3) body rates [rad/s].
    wheel_momentum
        (T + 1, N, m) [N m s].
    command
        (T, N, m) commanded wheel torques [N m].
    applied_torque
        (T, N, m) mean torque that each wheel applied in each control period [N m].
    reward
        (T, N) rewards.
    modal_displacement, modal_rate
        (T + 1, N, k) vibration modes [kg^1/2 m, kg^1/2 m/s]; k = 0 for rigid spacecraft.
    estimates
        (T, N, ...) fault estimates of the policy at the start of each control period, when it commands; None if they
        were not recorded.
    """

    scenario: Scenario
    episodes: Episodes
    time: FloatArray
    attitude_error: FloatArray
    rate_error: FloatArray
    attitude: FloatArray
    reference_attitude: FloatArray
    rate: FloatArray
    wheel_momentum: FloatArray
    command: FloatArray
    applied_torque: FloatArray
    reward: FloatArray
    modal_displacement: FloatArray
    modal_rate: FloatArray
    estimates: FaultEstimate | None = None

    @property
    def modal_energy(self) -> FloatArray:
        """Energy of the vibration modes, (T + 1, N) [J]."""
        return modal_energy(self.episodes.modes["stiffness"], self.modal_displacement, self.modal_rate)

    @property
    def vibration_torque(self) -> FloatArray:
        """Torque of the vibration modes on the body, (T + 1, N, 3) [N m], body axes."""
        return vibration_torque(self.episodes.modes, self.modal_displacement, self.modal_rate, self.rate)

    @property
    def error_mrp(self) -> FloatArray:
        """MRP of the attitude error, (T + 1, N, 3), short branch."""
        return mrp_from_quaternion(quaternion_error(self.attitude, self.reference_attitude))

    def metrics(self) -> Metrics:
        """Evaluate every episode."""
        return episode_metrics(self)

    def feasible_metrics(self) -> Metrics:
        """Evaluate the feasible episodes."""
        return {name: values[self.episodes.feasible] for name, values in self.metrics().items()}


def episode_metrics(history: Rollout) -> Metrics:
    """Evaluate every episode of a rollout.

    Theta is the true pointing error. *On target* means inside the cone and below the rate limit of ``success``; the
    window is that of the last ``success.hold`` seconds. A sample stands for the control period that it ends.

    ===================== ==========================================================================================
    ``availability``      share of the control periods on target
    ``success``           1 if on target for ``success.share`` of the window and never beyond ``success.limit`` cones
                          in it, else 0
    ``settling_time``     time after which the spacecraft stays on target to the end; the duration if it never does
    ``final_error``       root mean square of theta over the window
    ``final_error_95``    95th percentile of theta over the window
    ``integrated_error``  integral of theta over the episode
    ``peak_after_fault``  largest theta after the first fault; NaN unless on target at its onset
    ``recovery_time``     from that onset until on target to the end; NaN unless on target at the onset
    ``energy``            integral of the sum of squared applied wheel torques (means over control periods)
    ``chatter``           total variation of the wheel commands, summed over wheels, per second
    ``saturation``        share of wheel commands at their limit
    ``path_ratio``        integral of the rate error over the initial angle: 1 is the shortest way
    ``bound_kept``        1 if the error stayed within the scenario's prescribed bound, else 0; NaN without a bound
    ``bound_margin``      least distance to a bound over the width between both; negative outside; NaN without a bound
    ``jitter``            root mean square of the pointing error about its mean over the window
    ``modal_energy``      integral of the energy of the vibration modes over the episode; NaN without modes
    ``residual_energy``   mean of that energy over the window; NaN without modes
    ``vibration_torque``  root mean square of the modes' torque on the body over the window; NaN without modes
    ``return``            sum of the rewards: the objective of agents
    ===================== ==========================================================================================

    Returns
    -------
    Arrays (N,) by name.
    """
    scenario = history.scenario
    period, success = scenario.control_period, scenario.success
    error, rate_error = history.attitude_error, history.rate_error
    on_target = (error < success.angle) & (rate_error < success.rate)
    steps = len(error) - 1
    hold = success_steps(scenario)
    window = np.degrees(error[-hold:])
    settled = _settled_from(on_target)
    onset = history.episodes.first_onset
    onset_step = np.ceil(np.where(np.isfinite(onset), onset, 0.0) / period - 1e-9).astype(int)
    countable = np.isfinite(onset) & (onset_step < steps)
    onset_step = np.minimum(onset_step, steps)
    spacecraft = np.arange(error.shape[1])
    countable &= on_target[onset_step, spacecraft]
    after = np.arange(steps + 1)[:, None] >= onset_step
    peak = np.degrees(np.where(after, error, 0.0).max(axis=0))
    recovery = np.maximum(np.minimum(settled, steps) - onset_step, 0) * period
    limits = scenario.spacecraft.wheels.torque_limits
    changes = np.abs(np.diff(history.command, axis=0)).sum(axis=(0, 2))
    margin = np.full(error.shape[1], np.nan)
    if scenario.prescribed_bound is not None:
        inside = scenario.prescribed_bound.margin(history.error_mrp, history.time[:, None])
        margin = inside.min(axis=(0, 2))
    late = rotation_vector_from_quaternion(
        quaternion_error(history.attitude[-hold:], history.reference_attitude[-hold:])
    )
    jitter = np.sqrt(((late - late.mean(axis=0)) ** 2).sum(axis=2).mean(axis=0))
    vibration_energy, residual_energy, pull = (np.full(error.shape[1], np.nan) for _ in range(3))
    if scenario.spacecraft.modes:
        energy = history.modal_energy
        vibration_energy, residual_energy = energy[1:].sum(axis=0) * period, energy[-hold:].mean(axis=0)
        pull = np.sqrt((history.vibration_torque[-hold:] ** 2).sum(axis=2).mean(axis=0))
    reached = success.reached(
        period, steps, on_target[-hold:].sum(axis=0), (error[-hold:] > success.largest_error).sum(axis=0)
    )
    return {
        "availability": on_target[1:].mean(axis=0),
        "success": reached.astype(np.float64),
        "settling_time": np.minimum(settled, steps) * period,
        "final_error": np.sqrt(np.mean(window**2, axis=0)),
        "final_error_95": np.percentile(window, 95.0, axis=0),
        "integrated_error": np.degrees(error[1:].sum(axis=0)) * period,
        "peak_after_fault": np.where(countable, peak, np.nan),
        "recovery_time": np.where(countable, recovery, np.nan),
        "energy": np.sum(history.applied_torque**2, axis=(0, 2)) * period,
        "chatter": changes / (steps * period),
        "saturation": np.mean(np.abs(history.command) >= limits * (1.0 - 1e-9), axis=(0, 2)),
        "path_ratio": rate_error[1:].sum(axis=0) * period / np.maximum(error[0], 1e-3),
        "bound_kept": np.where(np.isnan(margin), np.nan, margin > 0.0),
        "bound_margin": margin,
        "jitter": np.degrees(jitter),
        "modal_energy": vibration_energy,
        "residual_energy": residual_energy,
        "vibration_torque": pull,
        "return": history.reward.sum(axis=0),
    }


def _settled_from(on_target: npt.NDArray[np.bool_]) -> npt.NDArray[np.int64]:
    """Return the first step after which each spacecraft (steps, N) stays on target; the number of steps if none."""
    outside = ~on_target
    last_outside = len(outside) - 1 - np.argmax(outside[::-1], axis=0)
    return np.where(outside.any(axis=0), last_outside + 1, 0)


def summarize(metrics: Metrics) -> dict[str, float]:
    """Return the mean of shares and the median of every other metric, without NaN."""
    summary = {}
    for name, values in metrics.items():
        known = values[~np.isnan(values)]
        middle = np.mean if name in SHARES else np.median
        summary[name] = float(middle(known)) if known.size else float("nan")
    return summary


def counted(metrics: Metrics) -> dict[str, float]:
    """Return :func:`summarize` with counts: ``episodes``, and ``NAME_defined`` after each partial metric."""
    summary: dict[str, float] = {"episodes": float(len(metrics["return"]))}
    for name, value in summarize(metrics).items():
        summary[name] = value
        if name in PARTIAL:
            summary[f"{name}_defined"] = float((~np.isnan(metrics[name])).sum())
    return summary


def described(metrics: Metrics) -> str:
    """Return :func:`summarize` as a line, with the number of values where a metric is not defined for all episodes."""
    known = {name: int((~np.isnan(values)).sum()) for name, values in metrics.items()}
    return ", ".join(
        f"{'median return' if name == 'return' else name} {value:.4g}{share_of(known[name], metrics[name].size)}"
        for name, value in summarize(metrics).items()
        if known[name]
    )


def share_of(defined: int, total: int) -> str:
    """Return the number of values that a statistic is over, as " (93 of 100)"; nothing if all are defined."""
    return f" ({defined} of {total})" if defined < total else ""
