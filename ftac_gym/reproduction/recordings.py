"""Plans of flights, their recordings, and the measures that several papers need."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from ftac_gym.task.prescribed_bound import PrescribedBound
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray

Measured = TypeVar("Measured")


@dataclass(frozen=True)
class Plan:
    """Flight of a baseline in a scenario.

    Attributes
    ----------
    scenario
        The task.
    baseline
        Name of a baseline.
    gains
        Gains that differ from its defaults.
    seed, num_spacecraft
        Seed of the episodes, and the number of them, which fly side by side.
    flipped
        Whether the quaternions at the start have the other sign, which is the same attitude. A baseline that
        distinguishes the two turns the other way.
    recorded
        Names in the baseline's memory whose histories are recorded.
    """

    scenario: Scenario
    baseline: str
    gains: Mapping[str, Any] = field(default_factory=dict)
    seed: int = 0
    num_spacecraft: int = 1
    flipped: bool = False
    recorded: tuple[str, ...] = ()


def below_from(time: FloatArray, values: FloatArray, limit: float) -> float:
    """Return the time [s] from which values (T,) at times (T,) stay below a limit; infinity if they do not."""
    above = np.flatnonzero(~(values < limit))
    if len(above) == 0:
        return 0.0
    return float(time[above[-1] + 1]) if above[-1] + 1 < len(time) else float("inf")


@dataclass(frozen=True, eq=False)
class Recording:
    """Time histories of N spacecraft over T control periods.

    Attributes
    ----------
    plan
        The plan that was flown.
    time
        (T + 1,) [s].
    error
        (T + 1, N) angle between body and reference [deg].
    attitude, reference
        (T + 1, N, 3) short-branch MRPs.
    rate
        (T + 1, N, 3) body rate [rad/s].
    command
        (T, N, m) wheel torques commanded [N m].
    true_effectiveness, true_bias
        (T, N, m) the truth, the bias in [N m].
    true_vibration
        (T + 1, N, 3) true torque of the vibration modes [N m]; zero for a rigid spacecraft.
    modal_energy
        (T + 1, N) energy of the vibration modes [J]; zero for a rigid spacecraft.
    effectiveness, bias
        (T, N, m) estimates of the observer, the bias in [N m]; None if it has none.
    disturbance
        (T, N, 3) estimate of the torque that the commands do not explain [N m]; None if the observer has none.
    vibration
        (T, N, 3) estimate of the torque of the vibration modes [N m]; None if the observer has none.
    rate_mismatch
        (T, N, 3) measured minus estimated rate [rad/s]; None without an observer.
    identifiable
        (T, N, m) whether each wheel had sustained torque; None without an observer.
    memory
        (T + 1, N, ...) histories of the baseline's memory that the plan names.
    """

    plan: Plan
    time: FloatArray
    error: FloatArray
    attitude: FloatArray
    reference: FloatArray
    rate: FloatArray
    command: FloatArray
    true_effectiveness: FloatArray
    true_bias: FloatArray
    true_vibration: FloatArray
    modal_energy: FloatArray
    effectiveness: FloatArray | None = None
    bias: FloatArray | None = None
    disturbance: FloatArray | None = None
    vibration: FloatArray | None = None
    rate_mismatch: FloatArray | None = None
    identifiable: FloatArray | None = None
    memory: Mapping[str, FloatArray] = field(default_factory=dict)

    @property
    def scenario(self) -> Scenario:
        """The task."""
        return self.plan.scenario

    def last(self, window: float = 10.0) -> npt.NDArray[np.bool_]:
        """Return which of the (T + 1) samples lie in the last ``window`` seconds."""
        return np.asarray(self.time >= self.time[-1] - window)

    def settling(self, angle: float, spacecraft: int = 0) -> float:
        """Return the time [s] from which a spacecraft's error stays below an angle [deg]; infinity if never."""
        return below_from(self.time, self.error[:, spacecraft], angle)

    def arrivals(self, angle: float = 0.1) -> FloatArray:
        """Return the settling times of all spacecraft for an angle [deg], (N,) [s]."""
        return np.array([self.settling(angle, spacecraft) for spacecraft in range(self.error.shape[1])])

    def steady(self, window: float = 10.0) -> float:
        """Return the largest error in the last ``window`` seconds [deg], of all spacecraft."""
        return float(self.error[self.last(window)].max())

    def spent(self, commanded: bool = False) -> FloatArray:
        """Return the integral of the squared torques of the first spacecraft's wheels, (T + 1,) [N^2 m^2 s].

        They are the torques that the wheels apply, faults included, or those that the baseline commands.
        """
        torque = self.command[:, 0]
        if not commanded:
            torque = self.true_effectiveness[:, 0] * torque + self.true_bias[:, 0]
        spent = np.cumsum((torque**2).sum(axis=1)) * self.scenario.control_period
        return np.concatenate(([0.0], spent))

    def energy(self, until: float = np.inf, commanded: bool = False) -> float:
        """Return the integral of the squared torques up to a time [s]; see :meth:`spent`."""
        return float(self.spent(commanded)[self.time <= until + 1e-9][-1])

    def speed(self) -> FloatArray:
        """Return the magnitude of the first spacecraft's rate, (T + 1,) [deg/s]."""
        return np.asarray(np.degrees(np.linalg.norm(self.rate[:, 0], axis=1)))

    def path_ratio(self) -> FloatArray:
        """Return the angle turned over the shortest one, (N,), for a reference at rest."""
        speed = np.linalg.norm(self.rate[1:], axis=2)
        return np.asarray(np.degrees(speed.sum(axis=0) * self.scenario.control_period) / self.error[0])

    def margin(self, bound: PrescribedBound) -> FloatArray:
        """Return the distance of the first spacecraft to a bound, as the least share of its width, (T + 1,).

        It is negative outside the bound. The reference must be the identity.
        """
        return np.asarray(bound.margin(self.attitude[:, 0], self.time).min(axis=1))

    def component_accuracy(self) -> FloatArray:
        """Return the largest ``|sigma_i - sigma_d,i|`` of the last 10 s, (3,), as the angle 4 atan [deg]."""
        late = self.last()
        difference = np.abs(self.attitude[late] - self.reference[late]).max(axis=(0, 1))
        return np.asarray(np.degrees(4.0 * np.arctan(difference)))

    def peak(self) -> float:
        """Return the largest wheel torque commanded, of all spacecraft [N m]."""
        return float(np.abs(self.command).max())

    def chatter(self, start: float = 0.0, end: float = np.inf) -> float:
        """Return the total variation of the first spacecraft's commands per second [N m/s], mean over the wheels.

        The commands are those from one time [s] until before another.
        """
        command = self.command[(self.time[:-1] >= start) & (self.time[:-1] < end), 0]
        variation = np.abs(np.diff(command, axis=0)).sum(axis=0).mean()
        return float(variation / max(len(command), 1) / self.scenario.control_period)

    def at_limit(self) -> npt.NDArray[np.bool_]:
        """Return whether each wheel of the first spacecraft is commanded its limit, (T, m)."""
        limits = self.scenario.spacecraft.wheels.torque_limits
        return np.asarray(np.abs(self.command[:, 0]) >= limits * (1.0 - 1e-9))

    def saturated(self) -> float:
        """Return the share of time in which the wheels of the first spacecraft are commanded their limit."""
        return float(self.at_limit().mean())

    def estimate_error(self, window: float = 10.0) -> FloatArray:
        """Return the largest ``|e^ - e|`` of each wheel of the first spacecraft in the last ``window`` seconds, (m,).

        Raises
        ------
        ValueError
            If the observer does not estimate the effectiveness.
        """
        if self.effectiveness is None:
            raise ValueError("effectiveness must have been estimated to have an error, got None")
        late = self.last(window)[:-1]
        return np.asarray(np.abs(self.effectiveness - self.true_effectiveness)[late, 0].max(axis=0))


class Recordings(dict[str, Recording]):
    """Recordings by the name of their plan."""

    def chosen(self, names: Iterable[str], form: str = "{}") -> Recordings:
        """Return some recordings by short names.

        Parameters
        ----------
        names
            Short names.
        form
            Name of a plan, with braces in place of the short name.
        """
        return Recordings({name: self[form.format(name)] for name in names})

    def relabelled(self, names: Mapping[str, str]) -> Recordings:
        """Return the recordings of plans with names (label: name), by label."""
        return Recordings({label: self[name] for label, name in names.items()})

    def measured(self, measure: Callable[[Recording], Measured]) -> dict[str, Measured]:
        """Return a measure of each recording, by name."""
        return {name: measure(recording) for name, recording in self.items()}
