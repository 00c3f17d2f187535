"""True faults of the present episodes, for ``info``: what no policy is given."""

from typing import Any

import numpy as np
import numpy.typing as npt

from ftac_gym.dynamics import Simulator
from ftac_gym.faults import signals
from ftac_gym.faults.signals import acts
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.compiling import entry_point

NO_WHEEL = -1
"""Wheel of a fault of the sensors, and of an entry without a fault."""

NO_ONSET = -1.0
"""Onset of an entry without a fault [s]; loggers and JSON take finite numbers only."""

_TIMES = ("onset", "recovery", "period", "on_time")
_ENTRY = np.dtype([("kind", "i8"), ("wheel", "i8"), ("chain", "i8"), *((name, "f8") for name in _TIMES)])


def most_faults(scenario: Scenario) -> int:
    """Return the number of entries for the faults of an episode: as many as it can have, and at least one."""
    return 1 if scenario.faults is None else max(1, scenario.faults.most_faults)


class TrueFaults:
    """The faults of N episodes, each in the order of their onsets.

    Parameters
    ----------
    simulator
        Source of the faults.
    """

    def __init__(self, simulator: Simulator) -> None:
        self._simulator = simulator
        shape = simulator.num_spacecraft, most_faults(simulator.scenario)
        self._entries = np.zeros(shape, dtype=_ENTRY)
        # Contiguous: a single environment copies them in every step.
        self._known = [np.zeros(shape, dtype=_ENTRY[name]) for name in ("kind", "wheel", "onset")]
        self._tables: Any = None

    def begin(self, rows: npt.NDArray[np.int64]) -> None:
        """Read the faults of the episodes that the listed spacecraft are in."""
        drawn = self._simulator.faults
        self._tables = drawn.wheels
        parts = []
        for table in (drawn.wheels[rows], drawn.sensors[rows]):
            part = np.zeros(table.shape, dtype=_ENTRY)
            for name in ("kind", "chain", *_TIMES):
                part[name] = table[name]
            part["wheel"] = np.arange(table.shape[1])[:, None] if table.ndim == 3 else NO_WHEEL
            parts.append(part.reshape(len(rows), -1))
        found = np.concatenate(parts, axis=1)
        empty = found["kind"] == 0
        order = np.argsort(np.where(empty, np.inf, found["onset"]), axis=1, kind="stable")
        found["onset"][empty], found["wheel"][empty] = NO_ONSET, NO_WHEEL
        width = min(found.shape[1], self._entries.shape[1])
        self._entries[rows] = np.zeros((), dtype=_ENTRY)
        self._entries["onset"][rows], self._entries["wheel"][rows] = NO_ONSET, NO_WHEEL
        chosen = np.take_along_axis(found, order[:, :width], axis=1)
        self._entries[rows, :width] = chosen
        for array, name in zip(self._known, ("kind", "wheel", "onset"), strict=True):
            array[rows] = self._entries[name][rows]

    def facts(self) -> dict[str, npt.NDArray[Any]]:
        """Return the entries of ``info``, fresh arrays (N, entries): kind, wheel, onset [s], and whether it acts."""
        simulator = self._simulator
        drawn = simulator.faults
        if drawn.wheels is not self._tables:  # Faults were changed while the episodes run.
            self.begin(np.arange(len(self._entries)))
        active = np.empty(self._entries.shape, dtype=np.bool_)
        _acting(self._entries, drawn.switches, simulator.ticks, simulator.scenario.control_period, active)
        kind, wheel, onset = self._known
        return {
            "fault/kind": kind.copy(),
            "fault/wheel": wheel.copy(),
            "fault/onset": onset.copy(),
            "fault/active": active,
        }


@entry_point(signals)
def _acting(entries: Any, switches: Any, ticks: Any, control_period: float, active: Any) -> None:
    """Write whether each fault acts now."""
    for i in range(entries.shape[0]):
        for k in range(entries.shape[1]):
            active[i, k] = entries[i, k].kind > 0 and acts(entries[i, k], switches, i, ticks[i] * control_period)
