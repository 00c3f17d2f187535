"""The interface of every analytical policy, and its adapter to Stable-Baselines3's ``predict``."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from ftac_gym.baselines.estimate import FaultEstimate
from ftac_gym.baselines.gains import SearchSpace, schedule_of, with_schedule
from ftac_gym.baselines.interface import as_action, measurement_of
from ftac_gym.baselines.memory import Memory
from ftac_gym.baselines.tunable import Tunable
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, require

BoolArray = npt.NDArray[np.bool_]


class Baseline(Tunable, ABC):
    """A digital controller of N spacecraft: one call per control period, its output held until the next.

    It is built from the scenario's nominal parameters and never receives the true ones. A subclass has the equations in
    :meth:`act`, its gains as a dataclass (:mod:`~ftac_gym.baselines.gains`) and its state in :attr:`memory`.

    Parameters
    ----------
    scenario
        The task.
    num_spacecraft
        Number of spacecraft N.
    **gains
        Gains that differ from the defaults.

    Raises
    ------
    TypeError
        If a gain is unknown.
    ValueError
        If a gain breaks a rule, or the baseline does not fit the scenario.
    """

    information: str = "attitude"
    """Tier of the information that it uses: attitude, telemetry or oracle."""
    rest_only: ClassVar[str] = ""
    """Reason why the reference must be at rest; empty for a baseline that follows a moving one."""
    needs_torque_limits: ClassVar[bool] = False
    """True for a baseline that needs a torque limit of every wheel."""

    def __init__(self, scenario: Scenario, num_spacecraft: int = 1, **gains: Any) -> None:
        super().__init__(**gains)
        require(isinstance(scenario, Scenario), "scenario", "must be a Scenario", scenario)
        whole = isinstance(num_spacecraft, (int, np.integer)) and num_spacecraft > 0
        require(whole, "num_spacecraft", "must be a positive integer", num_spacecraft)
        reference, wheels = scenario.reference, scenario.spacecraft.wheels
        rule = f"must be at rest: {self.rest_only}"
        require(not (self.rest_only and reference.moving), "reference", rule, type(reference).__name__)
        limited = not self.needs_torque_limits or bool(np.isfinite(wheels.torque_limits).all())
        require(limited, "torque_limit", "must be finite for every wheel", wheels.torque_limits.tolist())
        self.scenario = scenario
        self.num_spacecraft = int(num_spacecraft)
        self.memory = Memory(self.num_spacecraft)
        """State of the baseline and its observers between two calls."""
        self.scheduled: Any = self.gains
        """The gains in use: ``gains``, with arrays (N, 1) for those that are scheduled."""
        self._inertia = scenario.spacecraft.inertia_matrix
        self._torque_limits = wheels.torque_limits
        self._period = scenario.control_period
        self._moving = reference.moving
        self._build()

    def _build(self) -> None:
        """Build the parts from ``gains`` and :attr:`scenario`, and add their state to :attr:`memory`."""

    @classmethod
    def space(cls, **gains: Any) -> SearchSpace:
        """Return the ranges that a tuner searches, for the variant with these gains."""
        return cls.search_space

    @abstractmethod
    def act(self, measurement: Measurement) -> FloatArray:
        """Return the wheel torques to command, (N, wheels) [N m], within their limits."""

    def reset(self, mask: BoolArray | None = None) -> None:
        """Set the memory of the spacecraft in the mask (N,), or of all, to its initial values."""
        chosen = np.ones(self.num_spacecraft, dtype=np.bool_) if mask is None else np.asarray(mask)
        valid = chosen.shape == (self.num_spacecraft,) and chosen.dtype == np.bool_
        require(valid, "mask", f"must be a boolean array of shape ({self.num_spacecraft},)", mask)
        self.memory.reset(chosen)

    def schedule(self, gains: Mapping[str, FloatArray]) -> None:
        """Set gains for the coming calls of :meth:`act`, by spacecraft; those left out return to ``gains``.

        They are an input, no state: a reset does not change them.

        Parameters
        ----------
        gains
            Values (N,) by the name of the gain, one of ``schedulable``. Gains that are searched as a share of
            another are scheduled so too: they follow the gain that limits them.

        Raises
        ------
        ValueError
            If a gain is not schedulable, or its values are not N positive numbers.
        """
        columns = {}
        for name, values in gains.items():
            known = sorted(self.schedulable)
            require(name in known, f"scheduled gain of {type(self).__name__}", f"must be among {known}", name)
            array = np.asarray(values, dtype=np.float64)
            valid = array.shape == (self.num_spacecraft,) and bool(np.isfinite(array).all() and (array > 0.0).all())
            require(valid, name, f"must be {self.num_spacecraft} positive numbers", values)
            columns[name] = array[:, None]
        if self.schedulable:
            self._schedule(columns)

    def _schedule(self, gains: Mapping[str, FloatArray]) -> None:
        """Use checked gains, each (N, 1); overridden where more than :attr:`scheduled` depends on them."""
        if not schedule_of(self.gains):
            raise NotImplementedError(f"{type(self).__name__} must override _schedule, or have a dataclass of gains")
        self.scheduled = with_schedule(self.gains, gains)

    def act_only(self, measurement: Measurement, mask: BoolArray) -> FloatArray:
        """Act for the spacecraft in the mask (N,) alone: the memory of the others is kept, their rows are undefined."""
        before = self.memory.copy()
        if mask.any():
            # The others repeat the first of these, so that no measurement of theirs can raise an error.
            rows = np.where(mask, np.arange(self.num_spacecraft), np.argmax(mask))
            measurement = measurement.take(rows)
            self.memory.restore({name: array[rows] for name, array in before.items()}, ~mask)
        command = self.act(measurement)
        self.memory.restore(before, ~mask)
        return command

    @property
    def estimate(self) -> FaultEstimate | None:
        """The latest estimate of the observer inside, or None if there is none."""
        return None

    def as_policy(self, env: Any) -> BaselinePolicy:
        """Return an object with Stable-Baselines3's ``predict``, reading measurements from an environment.

        Parameters
        ----------
        env
            A single, vector or SB3 vector environment of this package, wrapped or not, of as many spacecraft.
        """
        return BaselinePolicy(self, env)


class BaselinePolicy:
    """Stable-Baselines3's ``predict`` for a baseline.

    The observation is ignored: a baseline reads the measurement behind it, which has the same information.

    Parameters
    ----------
    baseline
        The baseline; its number of spacecraft must be that of the environment.
    env
        The source of the measurements.
    """

    def __init__(self, baseline: Baseline, env: Any) -> None:
        self.baseline = baseline
        self.env = env
        self._torque_limits = baseline.scenario.spacecraft.wheels.torque_limits

    def predict(
        self,
        observation: npt.NDArray[Any],
        state: tuple[npt.NDArray[Any], ...] | None = None,
        episode_start: npt.NDArray[Any] | None = None,
        deterministic: bool = False,
    ) -> tuple[FloatArray, None]:
        """Return the action for the present measurement, batched exactly if the observation is.

        Parameters
        ----------
        observation
            (size,) or (N, size); only its number of axes is used.
        state
            Ignored: the state is in the baseline.
        episode_start
            (N,) flags of the spacecraft whose measurement is the first of their episode; None takes those whose time is
            zero. In NEXT_STEP mode that is one call after the call that ended the episode.
        deterministic
            Ignored: a baseline always is.
        """
        measurement = measurement_of(self.env, truth=self.baseline.information == "oracle")
        count, rule = self.baseline.num_spacecraft, f"must be that of the environment, {len(measurement)}"
        require(len(measurement) == count, "num_spacecraft", rule, count)
        started = measurement.time == 0.0 if episode_start is None else np.atleast_1d(episode_start).astype(np.bool_)
        if started.any():
            self.baseline.reset(started)
        action = as_action(self.baseline.act(measurement), self._torque_limits)
        return (action if np.ndim(observation) > 1 else action[0]), None
