"""The interface of every analytical policy."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from ftac_gym.baselines.estimate import FaultEstimate
from ftac_gym.baselines.gains import SearchSpace, flat, nested
from ftac_gym.baselines.interface import as_action, measurement_of
from ftac_gym.baselines.memory import Memory
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, require

BoolArray = npt.NDArray[np.bool_]


class Baseline(ABC):
    """A digital controller of N craft: one call per control period, its output held until the next.

    It is built from the scenario's nominal parameters and never sees the true ones.

    Parameters
    ----------
    scenario
        The task.
    num_spacecraft
        Number of craft N.
    """

    information: str = "attitude"
    """The tier of information it uses: attitude, telemetry or oracle."""
    search_space: ClassVar[SearchSpace] = {}
    """Where a tuner looks for the gains of the law itself."""
    shares: ClassVar[Mapping[str, tuple[str, str]]] = {}
    """Gains that are searched as a share of another, which limits them: share: (gain, the gain that limits it)."""
    schedulable: ClassVar[Mapping[str, tuple[float, float]]] = {}
    """Gains that may change while the law runs, each with its usual bounds: see :meth:`schedule`."""

    def __init__(self, scenario: Scenario, num_spacecraft: int = 1) -> None:
        require(isinstance(scenario, Scenario), "scenario", "must be a Scenario", scenario)
        whole = isinstance(num_spacecraft, (int, np.integer)) and num_spacecraft > 0
        require(whole, "num_spacecraft", "must be a positive integer", num_spacecraft)
        self.scenario = scenario
        self.num_spacecraft = int(num_spacecraft)
        self.memory = Memory(self.num_spacecraft)
        """All that the baseline and its observers carry from one call to the next."""

    @classmethod
    def space(cls, **gains: Any) -> SearchSpace:
        """Return where a tuner looks, for the variant of the law that has these gains."""
        return cls.search_space

    @classmethod
    def gains_at(cls, point: Mapping[str, float]) -> dict[str, Any]:
        """Return the gains at a point of the search space."""
        gains = nested(point)
        for share, (gain, limit) in cls.shares.items():
            gains[gain] = gains[limit] * gains.pop(share)
        return gains

    @classmethod
    def point_of(cls, gains: Mapping[str, Any]) -> dict[str, float]:
        """Return the point of the search space that has these gains, as far as they say: what :meth:`gains_at` undoes.

        Gains that are no numbers, or are not given, are left out.
        """
        point = flat(gains)
        for share, (gain, limit) in cls.shares.items():
            point[share] = point.pop(gain) / point[limit]
        return point

    @abstractmethod
    def act(self, measurement: Measurement) -> FloatArray:
        """Return the wheel torques to command, (N, wheels) [N m], within their limits."""

    def reset(self, mask: BoolArray | None = None) -> None:
        """Forget the past of the craft in the mask (N,), or of all; the others are left untouched."""
        chosen = np.ones(self.num_spacecraft, dtype=np.bool_) if mask is None else np.asarray(mask)
        valid = chosen.shape == (self.num_spacecraft,) and chosen.dtype == np.bool_
        require(valid, "mask", f"must be a boolean array of shape ({self.num_spacecraft},)", mask)
        self.memory.reset(chosen)

    def schedule(self, gains: Mapping[str, FloatArray]) -> None:
        """Set gains for the coming calls of :meth:`act`, by craft; those that are left out are the law's own again.

        They are an input, not a memory: a reset leaves them alone.

        Parameters
        ----------
        gains
            Values (N,) by the name of the gain, one of :attr:`schedulable`. Gains that are searched as a share of
            another are scheduled so too: they follow what limits them.

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
        """Use checked gains, each (N, 1): what a law with schedulable gains says."""
        raise NotImplementedError(f"{type(self).__name__} must say how it uses its schedulable gains")

    def act_only(self, measurement: Measurement, mask: BoolArray) -> FloatArray:
        """Act for the craft in the mask (N,) alone: the memory of the others is kept, their rows mean nothing."""
        before = self.memory.copy()
        if mask.any():
            # The others do what the first of these does, so that nothing of theirs can be refused.
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
            A single, vector or SB3 vector environment of this package, wrapped or not, with as many craft.
        """
        return BaselinePolicy(self, env)


class BaselinePolicy:
    """Stable-Baselines3's ``predict`` for a baseline.

    The observation is ignored: a baseline reads the measurement behind it, which holds the same knowledge.

    Parameters
    ----------
    baseline
        The baseline; its number of craft must be that of the environment.
    env
        Where the measurements come from.
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
            (size,) or (N, size); only its number of axes is looked at.
        state
            Ignored: the state is in the baseline.
        episode_start
            (N,) which craft have just been reset, so that the measurement is the first of their episode; None takes
            those whose clock stands at zero. In NEXT_STEP mode that is one call after the one that ended the episode.
        deterministic
            Ignored: a baseline always is.
        """
        measurement = measurement_of(self.env, truth=self.baseline.information == "oracle")
        craft = self.baseline.num_spacecraft
        require(
            len(measurement) == craft, "num_spacecraft", f"must be that of the environment, {len(measurement)}", craft
        )
        started = measurement.time == 0.0 if episode_start is None else np.atleast_1d(episode_start).astype(np.bool_)
        if started.any():
            self.baseline.reset(started)
        action = as_action(self.baseline.act(measurement), self._torque_limits)
        return (action if np.ndim(observation) > 1 else action[0]), None
