"""Gains of a baseline, set by an agent in every control period."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium import spaces

from ftac_gym import baselines
from ftac_gym.baselines import as_action
from ftac_gym.baselines.gains import merged
from ftac_gym.utils.parameters import FloatArray, fields_named, finite, require
from ftac_gym.wrappers.residual import BaseTransform
from ftac_gym.wrappers.transform import wrapper

Ranges = Mapping[str, Sequence[float]]


def schedulable_bases() -> list[str]:
    """Return the names of the baselines whose gains an agent can set."""
    return [
        name
        for name in baselines.names()
        if baselines.baseline_class(name).schedulable and baselines.defaults(name).get("faults") != "oracle"
    ]


class Scheduling(BaseTransform):
    """Let the agent set a few gains of a baseline, which acts.

    The action has one entry within [-1, 1] for each gain. Zero is the base's default, bit for bit, and 1 and -1 are the
    ends of its range; between them the gain is geometric in the action. The gains are those of the coming control
    period, for each spacecraft its own.

    Parameters
    ----------
    env
        An environment of this package, single or vector.
    base
        Name of the baseline, one of :func:`schedulable_bases`, a custom class, or its path as ``"module:Class"``.
    ranges
        Gain to (low, high); the base's default lies between them. None takes all gains that the base can schedule,
        within their usual bounds (:attr:`~ftac_gym.baselines.tunable.Tunable.schedulable`).
    **gains
        Gains of the baseline.

    Raises
    ------
    TypeError
        If a gain is unknown.
    ValueError
        If the environment is not of this package, the base has no gains to schedule or is an oracle, or a gain or a
        range is refused.
    """

    def __init__(
        self, env: Any, base: baselines.BaselineLike = "pd_dob", ranges: Ranges | None = None, **gains: Any
    ) -> None:
        super().__init__(env, base, gains)
        law = type(self.baseline)
        require(bool(law.schedulable), "base", f"must have gains to schedule, as {schedulable_bases()} have", base)
        changes = {name: value for name, value in gains.items() if name != "gains"}
        chosen = baselines.chosen(base, gains.get("gains", "default"), changes)
        everything = law.point_of(merged(baselines.defaults(base), chosen))
        point = {name: everything[name] for name in law.schedulable}
        given = dict(law.schedulable) if ranges is None else ranges
        valid = isinstance(given, Mapping) and len(given) > 0
        require(valid, "ranges", "must map at least one gain to a pair (low, high)", ranges)
        rows = []
        for name, pair in given.items():
            require(name in law.schedulable, "ranges", f"must be of gains among {sorted(law.schedulable)}", name)
            low, high = _pair(pair, f"ranges[{name!r}]")
            require(low > 0.0, f"ranges[{name!r}]", "must start above zero", low)
            default = point[name]
            rule = f"must lie strictly inside its range ({low:g}, {high:g})"
            require(low < default < high, f"{name} of {base}", rule, default)
            for end in (low, high):
                # The constructor of the base checks the ends of the range.
                with fields_named(**{f"{base}:": f"ranges[{name!r}] of {base}:"}):
                    baselines.build(base, self.inner.scenario, 1, **merged(gains, law.gains_at({**point, name: end})))
            rows.append((low, default, high))
        self.gains = tuple(given)
        """The gains that the action sets, in its order."""
        self._low, self._default, self._high = np.array(rows).T
        self.action_space = spaces.Box(-1.0, 1.0, (len(rows),), dtype=np.float32)

    def values(self, actions: npt.NDArray[Any]) -> FloatArray:
        """Return the gains (N, k) for actions (N, k)."""
        share = np.clip(actions, -1.0, 1.0)
        end = np.where(share > 0.0, self._high, self._low)
        # No rounding at zero: a ratio to the power of zero is one.
        return np.clip(self._default * (end / self._default) ** np.abs(share), self._low, self._high)

    def command(self, actions: npt.NDArray[Any]) -> FloatArray:
        """Return the base's actions at the present measurement with the gains for the actions (N, k)."""
        actions = np.asarray(actions, dtype=np.float64)
        require(bool(np.isfinite(actions).all()), "action", "must be finite", actions)
        measurement = self.measure(np.ones(self.num_spacecraft, dtype=np.bool_), self.baseline.reset)
        self.baseline.schedule(dict(zip(self.gains, self.values(actions).T, strict=True)))
        return as_action(self.baseline.respond(measurement), self._limits)


def _pair(value: Any, field: str) -> tuple[float, float]:
    listed = isinstance(value, (list, tuple, np.ndarray)) and len(value) == 2
    require(listed, field, "must be a pair (low, high)", value)
    return finite(value[0], field), finite(value[1], field)


GainScheduling = wrapper("GainScheduling", Scheduling)
