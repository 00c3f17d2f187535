"""Drawn episodes, with all the numbers that a replay needs."""

from __future__ import annotations

import hashlib
import json
import math
import struct
import zlib
from dataclasses import dataclass, fields
from os import PathLike
from pathlib import Path
from tokenize import TokenError
from typing import Any
from zipfile import BadZipFile

import numpy as np
import numpy.typing as npt

from ftac_gym.faults import DrawnFaults
from ftac_gym.utils.files import reading, replacing

RecordArray = npt.NDArray[np.void]
_DAMAGE = (BadZipFile, zlib.error, struct.error, TokenError, RuntimeError, MemoryError, OverflowError)
"""Further errors of NumPy and of Python's zipfile about a damaged archive."""

Selection = int | slice | npt.NDArray[Any]


@dataclass(frozen=True, eq=False)
class Episodes:
    """The drawn numbers of N episodes, one array per concept with the episode on the first axis.

    Episode ``k`` of seed ``s`` is the same for every policy, on one spacecraft or on a thousand.

    Attributes
    ----------
    scenario_json
        The scenario they were drawn from.
    key
        (N, 2) cipher keys of the seeds.
    index
        (N,) episode number within its seed.
    initial
        Records attitude, rate [rad/s], wheel_momentum [N m s], (N,).
    inertia
        INERTIA records (N,).
    faults
        FAULT records (N, wheels, layers).
    sensor_faults
        SENSOR_FAULT records (N, faults).
    switches
        (N, chains, FLIPS) times at which random chains of faults flip [s].
    disturbance
        DISTURBANCE records (N,).
    harmonics
        HARMONIC records (N, K).
    sensors
        SENSOR records (N,).
    reference
        REFERENCE records (N,).
    set_points
        SET_POINT records (N, points).
    feasible
        (N,) whether a controller with all faults in advance passes; see :mod:`ftac_gym.task.feasibility`.
    modes
        MODE records (N, k) of the vibration modes; k = 0 for rigid spacecraft.
    extra_delay
        (N,) loop delay beyond the nominal one, in control periods.
    """

    scenario_json: str
    key: npt.NDArray[np.uint32]
    index: npt.NDArray[np.int64]
    initial: RecordArray
    inertia: RecordArray
    faults: RecordArray
    sensor_faults: RecordArray
    switches: npt.NDArray[np.float64]
    disturbance: RecordArray
    harmonics: RecordArray
    sensors: RecordArray
    reference: RecordArray
    set_points: RecordArray
    feasible: npt.NDArray[np.bool_]
    modes: RecordArray
    extra_delay: npt.NDArray[np.int64]

    def __len__(self) -> int:
        """Return the number of episodes N."""
        return len(self.index)

    def __getitem__(self, selection: Selection) -> Episodes:
        """Return some of the episodes; an integer gives one episode, ready to replay."""
        if isinstance(selection, (int, np.integer)):
            if not -len(self) <= selection < len(self):
                raise IndexError(f"episode {selection} of {len(self)}")
            position = int(selection) % len(self)
            selection = slice(position, position + 1)
        return Episodes(self.scenario_json, *(array[selection] for array in self.arrays().values()))

    @property
    def drawn_faults(self) -> DrawnFaults:
        """The tables of all faults."""
        return DrawnFaults(self.faults, self.sensor_faults, self.switches)

    @property
    def first_onset(self) -> npt.NDArray[np.float64]:
        """(N,) onset of the first fault [s], infinite if there is none.

        A fault that acts from the start is a condition of the episode rather than an event in it. It counts if no other
        fault begins later.
        """
        tables = (self.faults, self.sensor_faults)
        flat = [table.reshape(len(self), math.prod(table.shape[1:])) for table in tables]
        onsets = np.concatenate([np.where(table["kind"] > 0, table["onset"], np.inf) for table in flat], axis=1)
        later = np.where(onsets > 0.0, onsets, np.inf).min(axis=1, initial=np.inf)
        first: npt.NDArray[np.float64] = np.where(np.isfinite(later), later, onsets.min(axis=1, initial=np.inf))
        return first

    def arrays(self) -> dict[str, npt.NDArray[Any]]:
        """Return all arrays by name, in the order of the fields."""
        return {field.name: getattr(self, field.name) for field in fields(self) if field.name != "scenario_json"}

    def digest(self) -> str:
        """Return the SHA-256 of the scenario and of all numbers, in hexadecimal.

        Numbers count to single precision. The same episodes drawn on another machine, with a sine that differs in the
        last bit, thus have the same digest.
        """
        state = hashlib.sha256(self.scenario_json.encode())
        for name, array in self.arrays().items():
            if name == "modes" and array.shape[1] == 0:
                continue  # Episodes of rigid spacecraft keep the digest from before there were modes.
            state.update(f"{name}{array.shape}{json.dumps(array.dtype.descr)}".encode())
            _hash_numbers(state, array)
        return state.hexdigest()

    def save(self, path: str | PathLike[str]) -> None:
        """Write the episodes to an ``.npz`` file, which is complete or absent."""
        with replacing(Path(path)) as file:
            np.savez_compressed(file, scenario_json=np.array(self.scenario_json), **self.arrays())  # type: ignore[arg-type]

    @classmethod
    def load(cls, path: str | PathLike[str]) -> Episodes:
        """Read a file of :meth:`save`, and check all numbers in it.

        Raises
        ------
        ValueError
            If the file cannot be read, holds no episodes, or holds a number that is none of an episode. The message has
            the path, and the name of the array and the field.
        """
        from ftac_gym.task.fitting import fitted  # Above this module: it needs scenarios.
        from ftac_gym.task.scenario import Scenario

        names = [field.name for field in fields(cls)]
        with reading(Path(path), "use a file that Episodes.save has written", *_DAMAGE):
            with open(path, "rb") as file:
                data = np.load(file, allow_pickle=False)
                if not isinstance(data, np.lib.npyio.NpzFile):
                    raise ValueError("it holds no episodes but a single array")
                if missing := [name for name in names if name not in data]:
                    raise ValueError(f"it holds no episodes: it lacks {missing[0]!r}")
                values: dict[str, Any] = {name: data[name] for name in names}
            episodes = cls(**{**values, "scenario_json": str(values["scenario_json"])})
            return fitted(episodes, Scenario.from_json(episodes.scenario_json))


def _hash_numbers(state: hashlib._Hash, array: npt.NDArray[Any]) -> None:
    if array.dtype.names is not None:
        for name in array.dtype.names:
            _hash_numbers(state, array[name])
    else:
        with np.errstate(over="ignore"):  # Numbers beyond single precision count as infinite.
            single = array.astype(np.float32) if array.dtype.kind == "f" else array
        state.update(np.ascontiguousarray(single).tobytes())
