"""Bounds of prescribed performance: the check of the start, mirrored bounds, the transformed error."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from ftac_gym.baselines.components.error_transformation import ErrorTransformation, Transformed
from ftac_gym.baselines.gains import Gains, parameter
from ftac_gym.baselines.memory import Memory
from ftac_gym.baselines.rules import interval
from ftac_gym.task.prescribed_bound import PrescribedBound
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, fields_named, require


@dataclass(frozen=True)
class PrescribedGains(Gains):
    """Gains of :class:`PrescribedError` in a controller."""

    bound: Mapping[str, Any] | None = parameter(None, "Fields of the prescribed bound that differ from the scenario's")
    mirror: bool = parameter(False, "Whether the bounds are mirrored, axis by axis, to the signs of the start")
    margin: float = parameter(1e-5, "Margin of the error transformation", "", interval(0.0, 0.5))


class PrescribedError:
    """The transformed attitude error of N spacecraft, each of which must start within its bounds.

    Parameters
    ----------
    scenario
        The task; its ``prescribed_bound`` is the default.
    memory
        Store of the spacecraft that have started and of the mirrored bounds.
    gains
        Bound, mirroring and margin. Without a bound of the task, the fields differ from the defaults of
        :class:`~ftac_gym.task.prescribed_bound.PrescribedBound`. Mirrored bounds are exchanged, axis by axis, where the
        start has the sign of the narrower side. Metrics take the bound of the scenario: give them one whose bound is
        ``bound.mirrored(axes)``.

    Raises
    ------
    ValueError
        If a value breaks a rule.
    """

    def __init__(self, scenario: Scenario, memory: Memory, gains: PrescribedGains) -> None:
        changes = gains.bound
        known = [item.name for item in fields(PrescribedBound)]
        require(changes is None or isinstance(changes, Mapping), "bound", f"must be a mapping with {known}", changes)
        for name in changes or {}:
            require(name in known, "bound", f"must have fields among {known}", name)
        with fields_named("bound."):
            self.bound = replace(scenario.prescribed_bound or PrescribedBound(), **(changes or {}))
        self._transformation = ErrorTransformation(self.bound, gains.margin)
        require(isinstance(gains.mirror, bool), "mirror", "must be True or False", gains.mirror)
        self._mirror = gains.mirror
        self._memory = memory
        memory.add("within_bounds", (1,), initial=False)
        memory.add("mirrored", (3,), initial=False)

    def peek(self, error: FloatArray, time: FloatArray) -> tuple[Transformed, FloatArray]:
        """Return the transformed errors of MRPs (N, 3) at times (N,) [s], and the mask of mirrored bounds (N, 3).

        Raises
        ------
        ValueError
            If a spacecraft that acts for the first time is outside its bounds.
        """
        fresh, mirrored = ~self._memory["within_bounds"], self._memory["mirrored"]
        if fresh.any():
            low, high = self.bound.bound(time)
            if self._mirror:
                # By the final factors: those at the start may be equal on both sides.
                wider_above = np.array(self.bound.upper) > np.array(self.bound.lower)
                wider_below = np.array(self.bound.lower) > np.array(self.bound.upper)
                mirrored = np.where(fresh, np.where(error < 0.0, wider_above, wider_below), mirrored)
            new = fresh[:, 0]
            lowest, highest = np.where(mirrored, -high, low), np.where(mirrored, -low, high)
            _check_start(error[new], lowest[new], highest[new], time[new], np.flatnonzero(new))
        return self._transformation(error, time, mirrored if self._mirror else None), mirrored

    def update(self, error: FloatArray, time: FloatArray) -> Transformed:
        """Return the transformed errors and record that the spacecraft have started."""
        transformed, mirrored = self.peek(error, time)
        if not self._memory["within_bounds"].all():
            self._memory["within_bounds"] = np.ones_like(self._memory["within_bounds"])
            self._memory["mirrored"] = mirrored
        return transformed


def _check_start(
    error: FloatArray, low: FloatArray, high: FloatArray, time: FloatArray, spacecraft: npt.NDArray[np.intp]
) -> None:
    """Raise a ValueError with axis, excess and remedy if an MRP (n, 3) is not between its bounds."""
    require(bool(np.isfinite(error).all()), "attitude", "must be finite", error.tolist())
    excess = np.maximum(low - error, error - high)
    if (excess < 0.0).all():
        return
    row, axis = np.unravel_index(int(np.argmax(excess)), excess.shape)
    value, lowest, highest = error[row], low[row], high[row]
    axes = np.flatnonzero(excess[row] >= 0.0)
    remedy = f"mirror=True, or bound.lower and bound.upper exchanged on axes {axes.tolist()}, would hold this start"
    if not ((-highest < value) & (value < -lowest))[axes].all():
        remedy = "mirrored bounds would not hold it either: bound.initial must be larger"
    raise ValueError(
        f"attitude of spacecraft {spacecraft[row]}, which starts at {time[row]:.6g} s, must be within its "
        f"prescribed bound, ({lowest[axis]:.6g}, {highest[axis]:.6g}) for MRP axis {axis}, got {value[axis]:.6g}, "
        f"outside by {excess[row, axis]:.3g}; {remedy}"
    )
