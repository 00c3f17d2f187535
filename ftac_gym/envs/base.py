"""Arguments, attributes and methods that the single and the vector environment share."""

import copy
import dataclasses
import os
from collections.abc import Mapping
from typing import Any

from gymnasium.envs.registration import EnvSpec

from ftac_gym import scenarios
from ftac_gym.envs.batch import SpacecraftBatch
from ftac_gym.envs.rendering.display import Display
from ftac_gym.faults import FaultDistribution
from ftac_gym.scenarios import ScenarioLike
from ftac_gym.task.episodes import Episodes
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.reach import check_reach
from ftac_gym.task.scenario import Scenario, check_fields
from ftac_gym.utils.parameters import broken, require
from ftac_gym.utils.serialization import to_plain


def resolve_scenario(scenario: ScenarioLike | None, default: str, changes: Mapping[str, Any], call: str) -> Scenario:
    """Return the scenario that the arguments of ``gym.make`` describe.

    Parameters
    ----------
    scenario
        See :func:`ftac_gym.scenarios.resolve`; None for the default.
    default
        Name of the default scenario.
    changes
        Fields to replace, by name.
    call
        Name of the class that was called, for messages.

    Raises
    ------
    TypeError
        If a change is no field of a scenario.
    ValueError
        If a name is unknown or a value breaks a rule.
    """
    check_fields(changes, call)
    base = scenarios.resolve(default if scenario is None else scenario)
    return base.replace(**changes) if changes else base


def requested_episodes(options: Mapping[str, Any] | None, names: tuple[str, ...]) -> Episodes | None:
    """Return the episodes that the options of a reset ask for, if any.

    Raises
    ------
    ValueError
        If the options are no dict, an option is not one of the names, or the episodes are none.
    """
    require(options is None or isinstance(options, Mapping), "reset options", "must be a dict or None", options)
    for name in options or {}:
        require(name in names, "reset option", f"must be one of {list(names)}", name)
    episodes = (options or {}).get("episodes")
    valid = episodes is None or isinstance(episodes, Episodes)
    require(valid, 'options["episodes"]', "must be an Episodes object", episodes)
    return episodes


class BatchEnvironment:
    """Environment over a batch of spacecraft."""

    metadata: dict[str, Any]
    batch: SpacecraftBatch
    render_mode: str | None
    full_torque: bool = True
    """True if a learner may push all wheels with all their torque, which the physics step must integrate then."""
    policy_name: str = ""
    """Name that frames show for the policy; none if empty."""
    _display: Display
    _spec: EnvSpec | None = None

    def _prepare(self, batch: SpacecraftBatch, render_mode: str | None, width: int, height: int) -> None:
        """Set the shared attributes.

        Raises
        ------
        ValueError
            If full torque makes rates beyond the physics step. For a display see its class.
        """
        if self.full_torque:
            check_reach(batch.scenario, commanded=True)
        self.batch = batch
        self.render_mode = render_mode
        self._display = Display(batch, render_mode, width, height)
        self.metadata = {**self.metadata, "render_fps": round(1.0 / batch.scenario.control_period, 6)}

    @property
    def spec(self) -> EnvSpec | None:
        """The specification that makes this environment again, with scenarios and their parts as plain data.

        ``max_episode_steps`` is the length of its own episodes. The registry has none: Gymnasium would end every
        episode there, whatever ``duration`` an environment is made with. It does so with a ``spec`` too: another
        duration of it needs ``gym.make(env.spec, duration=80.0, max_episode_steps=-1)``.
        """
        return self._spec

    @spec.setter
    def spec(self, value: EnvSpec | None) -> None:
        if value is not None:
            value = copy.copy(value)
            value.max_episode_steps = self.batch.horizon
            value.kwargs = {name: to_plain(item) for name, item in value.kwargs.items()}
            source = value.kwargs.get("scenario")
            if isinstance(source, (str, os.PathLike)) and not scenarios.is_shipped(source):
                # Another process may not have the file, the function or the registered name.
                value.kwargs["scenario"] = self.scenario.to_dict()
        self._spec = value

    @property
    def scenario(self) -> Scenario:
        """The scenario."""
        return self.batch.scenario

    @property
    def observation_slices(self) -> dict[str, slice]:
        """Named parts of the observation of one spacecraft."""
        return dict(self.batch.observer.layout.slices)

    def set_severity(self, severity: float) -> None:
        """Set the severity of the faults of the coming episodes, in [0, 1]; running episodes do not change.

        A hook for curricula: ``env.unwrapped.set_severity(0.3)``, or ``env_method("set_severity", 0.3)`` of any
        Stable-Baselines3 vector environment. See :class:`~ftac_gym.faults.FaultDistribution`. From now on ``spec``
        makes environments of this severity. Gymnasium's wrappers keep the ``spec`` that was first read from them: read
        it later, or that of ``env.unwrapped``.

        Raises
        ------
        ValueError
            If the severity is not within [0, 1], or the scenario has no fault distribution.
        """
        faults = self.batch.scenario.faults
        if not isinstance(faults, FaultDistribution):
            raise broken("faults", "must be a FaultDistribution to have a severity", faults)
        self.batch.scenario = self.batch.scenario.replace(faults=dataclasses.replace(faults, severity=severity))
        self.batch.simulator.scenario = self.batch.scenario
        if self._spec is not None:
            spec = copy.copy(self._spec)
            spec.kwargs = {**spec.kwargs, "faults": self.batch.scenario.faults}
            self.spec = spec

    def measurement(self, truth: bool = False) -> Measurement:
        """Return the present measurement, the input of baselines; its first axis is always that of the spacecraft.

        Parameters
        ----------
        truth
            Whether to add the true effect of the faults; only an oracle may have it.
        """
        return self.batch.simulator.measurement(truth)

    def _show(self) -> None:
        self._display.show(self.policy_name)

    def _close_display(self) -> None:
        """Close the window; an environment whose constructor raised has none."""
        if hasattr(self, "_display"):
            self._display.close()
