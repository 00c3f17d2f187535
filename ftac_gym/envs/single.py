"""One faulty spacecraft as a Gymnasium environment."""

import math
from typing import Any

import gymnasium as gym
import numpy as np
import numpy.typing as npt

from ftac_gym.envs.base import BatchEnvironment, requested_episodes, resolve_scenario
from ftac_gym.envs.batch import SpacecraftBatch
from ftac_gym.envs.rendering.display import RENDER_MODES
from ftac_gym.envs.reward import REWARD_KEYS, total
from ftac_gym.scenarios import ScenarioLike
from ftac_gym.utils.parameters import require

Observation = npt.NDArray[np.float32]


class SpacecraftFTCEnv(BatchEnvironment, gym.Env[Observation, npt.NDArray[Any]]):
    """Attitude control of one spacecraft under hidden faults of its reaction wheels.

    ## Description

    A body with reaction wheels turns to the commanded attitude and holds it. In most episodes one or two wheels lose
    effectiveness, add torque of their own, go dead, lock at the torque they had, or run away. No signal names the
    wheel, the time or the size of a fault. Inertia, external torque and sensor errors are random too. The plant is
    integrated with RK4 at the scenario's physics step; the agent acts once per control period.

    ## Action space

    ``Box(-1, 1, (wheels,), float32)``: the torque of each wheel over its limit, held for one control period. Values
    outside are clipped; wrong shapes and non-finite values raise ``ValueError``.

    ## Observation space

    A bounded ``Box``; :func:`ftac_gym.envs.observation.observation_layout` lists its named slices, and
    ``env.unwrapped.observation_slices`` holds them. The tier is chosen by ``observation``: ``"attitude"`` (attitude,
    rate, own commands), ``"telemetry"`` (and wheel momentum and sensor status), ``"oracle"`` (and the true faults).

    ## Rewards

    The sum of the named terms ``info["reward/NAME"]``; :mod:`ftac_gym.envs.reward` lists them. Their weights are the
    scenario's ``reward``. By default no step is negative, so that ending an episode never pays.

    ## Starting state

    Drawn from the scenario: for the flagship an attitude uniform over all rotations, rates up to 1 deg/s, wheel
    momenta up to 1 N m s. Episode ``k`` after ``reset(seed=s)`` is episode ``k`` of ``scenario.draw(s, ...)``.

    ## Episode end

    Terminated when the body turns faster than the scenario's ``tumble_rate``; truncated after its ``duration``.

    ## Info

    - ``time`` [s], ``attitude_error`` [deg], ``rate_error`` [deg/s].
    - ``availability``: share of the control periods so far on target.
    - ``is_success``: the scenario's ``success`` over the last ``hold`` seconds: on target for ``share`` of them, and
      never beyond ``limit`` cones. Exploration noise can hide it: evaluate without noise.
    - ``cost`` [s]: time of this period outside the scenario's ``cost_bounds``, for safe reinforcement learning.
    - ``reward/NAME``, after a step: the terms of the reward.
    - ``feasible``: a controller with the truth and all faults in advance passes the episode.
    - ``fault/kind``, ``fault/wheel``, ``fault/onset`` [s], ``fault/active``: the true faults, an entry for each that an
      episode of the scenario can have, in the order of their onsets. A kind is a number of
      :class:`~ftac_gym.faults.table.FaultKind`. Where there is no fault, kind is 0, and wheel and onset are -1; wheel
      is -1 for sensors too. Active is whether the fault acts now.

    The errors are true, and so are labels and faults: no policy is given any of them.

    ## Rendering

    ``render_mode="rgb_array"`` returns frames (height, width, 3), ``"human"`` shows them in a window in real time; both
    need the extra ``render``. A frame shows the truth: body, panels and target, the path of the boresight, and the
    errors. It also shows torque, momentum and health of the wheels, and names the acting faults. Set
    ``env.unwrapped.policy_name`` to add the name of the policy. ``metadata["render_fps"]`` is one frame per control
    period.

    ## Arguments

    Parameters
    ----------
    scenario
        A name, a file ``FILE.json``, ``"module:function"``, a :class:`~ftac_gym.task.scenario.Scenario`, or its dict or
        JSON text, see :func:`ftac_gym.scenarios.resolve`; None for the id's own.
    observation
        Information tier.
    render_mode
        None, ``"rgb_array"`` or ``"human"``.
    width, height
        Size of a frame [pixels].
    default_scenario
        Name of the scenario that the id stands for.
    **scenario_changes
        Fields of the scenario to replace, for example ``duration=60.0``, ``faults=None``, ``faults="outage:0@5"`` or
        ``reward={"on_target": 1.0}``; see :meth:`~ftac_gym.task.scenario.Scenario.replace` for the short forms.

    Raises
    ------
    TypeError
        If a keyword is no argument and no field of a scenario.
    ValueError
        If a name is unknown or a value breaks a rule.
    gymnasium.error.DependencyNotInstalled
        If a window is asked for and pygame is missing.
    """

    metadata: dict[str, Any] = {"render_modes": list(RENDER_MODES), "render_fps": 10}  # noqa: RUF012  as in Gymnasium

    def __init__(
        self,
        scenario: ScenarioLike | None = None,
        observation: str = "attitude",
        render_mode: str | None = None,
        width: int = 640,
        height: int = 480,
        default_scenario: str = "flagship",
        **scenario_changes: Any,
    ) -> None:
        chosen = resolve_scenario(scenario, default_scenario, scenario_changes, type(self).__name__)
        self._prepare(SpacecraftBatch(chosen, observation, num_spacecraft=1), render_mode, width, height)
        self.observation_space = self.batch.observation_space
        self.action_space = self.batch.action_space
        self._seeded = False

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Start the next episode.

        Parameters
        ----------
        seed
            Start over with episode 0 of this seed; None goes on with the next episode.
        options
            ``{"episodes": Episodes}`` replays the given single episode, which
            :func:`~ftac_gym.task.fitting.fitted` checks and labels for this scenario.

        Returns
        -------
        Observation and info.

        Raises
        ------
        ValueError
            If the seed is a truth value, the options are no dict, or an option is unknown or unfit.
        """
        require(not isinstance(seed, bool), "seed", "must be an integer or None", seed)
        episodes = requested_episodes(options, ("episodes",))
        super().reset(seed=seed)
        if seed is not None or not self._seeded:
            # Without a seed Gymnasium draws one from the operating system's entropy.
            known = self.np_random_seed
            self.batch.seed(0, known if known is not None and known >= 0 else int(self.np_random.integers(2**63)))
            self._seeded = True
        observation = np.empty((1, self.batch.observer.layout.size), dtype=np.float32)
        self.batch.reset(self.batch.indices, observation, episodes)
        self._show()
        return observation[0], self._info()

    def step(self, action: npt.ArrayLike) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Hold an action for one control period.

        Parameters
        ----------
        action
            (wheels,) fractions of the torque limits.

        Returns
        -------
        Observation, reward, terminated, truncated, info.

        Raises
        ------
        ValueError
            If the action has the wrong shape or is not finite.
        DivergenceError
            If a spacecraft has diverged; the error names it, the time and the quantity.
        """
        action = np.asarray(action)
        if action.shape != self.action_space.shape:
            raise ValueError(f"action must have shape {self.action_space.shape}, got {action.shape}")
        observation, terms, terminated, truncated = self.batch.step(action[None])
        info = self._info()
        values = terms[:, 0].tolist()
        info.update(zip(REWARD_KEYS, values, strict=True))
        self._show()
        return observation[0], total(values), bool(terminated[0]), bool(truncated[0]), info

    def render(self) -> npt.NDArray[np.uint8] | None:
        """Return a frame (height, width, 3) of the present moment; None in a window or without a render mode."""
        frames = self._display.render(self.policy_name)
        return None if frames is None else frames[0]

    def close(self) -> None:
        """Close the window, if there is one; a second call does nothing."""
        self._close_display()

    def _info(self) -> dict[str, Any]:
        # The same keys and values as SpacecraftBatch.facts, without the cost of arrays.
        simulator, reward = self.batch.simulator, self.batch.reward
        faults = self.batch.true_faults.facts()
        ticks, period = int(simulator.ticks[0]), self.batch.scenario.control_period
        return {
            "time": ticks * period,
            "attitude_error": math.degrees(reward.attitude_error[0]),
            "rate_error": math.degrees(reward.rate_error[0]),
            "is_success": bool(reward.success[0]),
            "availability": int(reward.periods_on_target[0]) / max(ticks, 1),
            "cost": period if reward.outside[0] else 0.0,
            "feasible": bool(simulator.feasible[0]),
            "fault/kind": faults["fault/kind"][0],
            "fault/wheel": faults["fault/wheel"][0],
            "fault/onset": faults["fault/onset"][0],
            "fault/active": faults["fault/active"][0],
        }
