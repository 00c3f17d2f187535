"""The interface of every analytical policy, and its adapter to Stable-Baselines3's ``predict``."""

from __future__ import annotations

import inspect
from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar, Self

import numpy as np
import numpy.typing as npt

from ftac_gym.baselines.clock import timed
from ftac_gym.baselines.estimate import FaultEstimate
from ftac_gym.baselines.estimators.navigator import NavigationGains, Navigator
from ftac_gym.baselines.gains import SearchSpace, schedule_of, with_schedule
from ftac_gym.baselines.interface import as_action, check_scenario, measurement_of, source_of
from ftac_gym.baselines.memory import Memory
from ftac_gym.baselines.sampling import warn_of_long_period
from ftac_gym.baselines.tunable import Tunable
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, is_whole, require

BoolArray = npt.NDArray[np.bool_]


class Baseline(Tunable, ABC):
    """A digital controller of N spacecraft: one call per control period, its output held until the next.

    It is built from the scenario's nominal parameters and never receives the true ones. A subclass has the equations in
    :meth:`act`, its gains as a dataclass (:mod:`~ftac_gym.baselines.gains`) and its state in :attr:`memory`. Every
    ``act`` checks the number of spacecraft and the time since the last call: zero or one control period.

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

    arguments: tuple[tuple[Any, ...], dict[str, Any]] = ((), {})
    """Positional and keyword arguments that it was built with."""
    _served: Any = None
    """Source of the measurements of the present episodes; None before the first, and in copies."""

    def __new__(cls, *args: Any, **kwargs: Any) -> Self:
        """Keep the arguments, from which the baseline is built again for other numbers of spacecraft."""
        self = super().__new__(cls)
        self.arguments = args, kwargs
        return self

    def __init_subclass__(cls) -> None:
        """Put the checks in front of a subclass's :meth:`act`."""
        super().__init_subclass__()
        if "act" in cls.__dict__:
            cls.act = timed(cls.__dict__["act"])  # type: ignore[assignment,method-assign]

    def __init__(self, scenario: Scenario, num_spacecraft: int = 1, **gains: Any) -> None:
        super().__init__(**gains)
        require(isinstance(scenario, Scenario), "scenario", "must be a Scenario", scenario)
        counted = is_whole(num_spacecraft) and num_spacecraft > 0
        require(counted, "num_spacecraft", "must be a positive integer", num_spacecraft)
        reference, wheels = scenario.reference, scenario.spacecraft.wheels
        rule = f"must be at rest: {self.rest_only}"
        require(not (self.rest_only and reference.moving), "reference", rule, type(reference).__name__)
        limited = not self.needs_torque_limits or bool(np.isfinite(wheels.torque_limits).all())
        require(limited, "torque_limit", "must be finite for every wheel", wheels.torque_limits.tolist())
        self.scenario = scenario
        self.num_spacecraft = int(num_spacecraft)
        self.memory = Memory(self.num_spacecraft)
        """State of the baseline and its observers between two calls."""
        self.memory.add("called_at", (), initial=np.nan)
        self.memory.add("command", (wheels.count,))
        self.scheduled: Any = self.gains
        """The gains in use: ``gains``, with arrays (N, 1) for those that are scheduled."""
        self._inertia = scenario.spacecraft.inertia_matrix
        self._torque_limits = wheels.torque_limits
        self._period = scenario.control_period
        self._moving = reference.moving
        self._navigator: Navigator | None = None
        if isinstance(self.gains, NavigationGains):
            self._navigator = Navigator(scenario, self.memory, self.gains)
            self.information = self._navigator.information
        self._build()

    def _build(self) -> None:
        """Build the parts from ``gains`` and :attr:`scenario`, and add their state to :attr:`memory`."""

    def _navigated(self, measurement: Measurement) -> Measurement:
        """Return the measurement that the equations of :meth:`act` get: that of the estimators, where there are any."""
        if self._navigator is None:
            return measurement
        return self._navigator.update(measurement)[0]

    def __getstate__(self) -> dict[str, Any]:
        """Leave the environment out of copies and pickles."""
        return {**self.__dict__, "_served": None}

    def again(self, num_spacecraft: int) -> Self:
        """Build the same baseline for another number of spacecraft."""
        args, kwargs = self.arguments
        bound = inspect.signature(type(self)).bind(*args, **kwargs)
        bound.arguments["num_spacecraft"] = num_spacecraft
        return type(self)(*bound.args, **bound.kwargs)

    @classmethod
    def space(cls, **gains: Any) -> SearchSpace:
        """Return the ranges that a tuner searches, for the variant with these gains."""
        return cls.search_space

    @abstractmethod
    def act(self, measurement: Measurement) -> FloatArray:
        """Return the wheel torques to command, (N, wheels) [N m], within their limits.

        Raises
        ------
        ValueError
            If the measurement is of another number of spacecraft, or the time since the last call is neither zero nor
            the control period.
        """

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

    def respond(self, measurement: Measurement, started: BoolArray | None = None) -> FloatArray:
        """Return the wheel torques (N, wheels) [N m] for the control period that begins at a measurement.

        Spacecraft whose time is that of the last call hold their command: a second call changes nothing.

        Parameters
        ----------
        measurement
            The measurement.
        started
            (N,) spacecraft whose measurement is the first of their episode; their memory is reset. None: those that
            have just been reset.
        """
        if started is not None and started.any():
            self.reset(started)
        due = measurement.time != self.memory["called_at"]
        if due.all():
            return self.act(measurement)
        held = self.memory["command"]
        return np.where(due[:, None], self.act_only(measurement, due), held) if due.any() else held

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

        Raises
        ------
        ValueError
            If the environment has another number of spacecraft, or its scenario differs in what a baseline is built
            from.

        Warns
        -----
        SampledInstability
            If the control period is too long for the gains.
        """
        policy = BaselinePolicy(self, env)
        warn_of_long_period(self)
        return policy


class BaselinePolicy:
    """Stable-Baselines3's ``predict`` for a baseline.

    The observation is ignored: a baseline reads the measurement behind it, which has the same information.

    Parameters
    ----------
    baseline
        The baseline; spacecraft, control period and number of spacecraft must be those of the environment. It serves
        one environment at a time: another takes it over when all of its episodes start.
    env
        The source of the measurements.

    Raises
    ------
    ValueError
        If the environment is not of this package, or does not fit the baseline.
    """

    def __init__(self, baseline: Baseline, env: Any) -> None:
        check_scenario(env, baseline.scenario, baseline.num_spacecraft)
        self.baseline = baseline
        self.env = env
        self._source = source_of(env)
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
            (N,) flags of spacecraft whose measurement is the first of their episode, besides those whose time is zero.
            None: those alone.
        deterministic
            Ignored: a baseline always is.

        Raises
        ------
        ValueError
            If the time since the last call is neither zero, for which the last action is returned again, nor the
            control period; or if the baseline serves another environment.
        """
        baseline = self.baseline
        measurement = measurement_of(self.env, truth=baseline.information == "oracle")
        started = measurement.time == 0.0
        if episode_start is not None:
            started |= np.atleast_1d(episode_start).astype(np.bool_)
        if baseline._served is None or started.all():
            baseline._served = self._source
        rule = "must serve one environment at a time: build another one for the other environment"
        require(baseline._served is self._source, "baseline", rule, type(baseline).__name__)
        action = as_action(baseline.respond(measurement, started), self._torque_limits)
        return (action if np.ndim(observation) > 1 else action[0]), None
