"""Studies of the tuner on disk: a journal of trials that survives kills, torn lines and a full disk."""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from ftac_gym.evaluation.tuning_objective import FAILED, Search
from ftac_gym.utils.files import damage
from ftac_gym.utils.parameters import finite, require
from ftac_gym.utils.serialization import parse_json

JOURNAL = "trials.jsonl"
"""File of a study in its folder."""

TORN = f"{JOURNAL}.torn"
"""File with what was damaged in the journal, and what followed there."""


@dataclass(frozen=True)
class Trial:
    """Gains that were flown, and their value by the objective; minus infinity if they could not be flown."""

    gains: dict[str, Any]
    value: float


class Study:
    """Finished trials of a search in a folder, as JSON lines: the setting, then one line for each trial.

    A journal can be damaged: by a kill or a full disk within a line, by a power loss, by other programs. The first
    damaged line and all that follows it are moved to another file, which a warning names. So are a line that stands at
    a wrong place and what follows it.

    Parameters
    ----------
    search
        Subject of the study.
    folder
        Its folder; a new one is created. One process at a time may use it (:func:`~ftac_gym.utils.files.locked`).

    Attributes
    ----------
    trials
        Finished trials in their order.

    Raises
    ------
    ValueError
        If the study in the folder has another setting, which the message names, or trials without a readable one.
    OSError
        If the journal cannot be written.
    """

    def __init__(self, search: Search, folder: Path) -> None:
        self._path = folder / JOURNAL
        folder.mkdir(parents=True, exist_ok=True)
        self._path.touch()
        content = self._path.read_bytes()
        lines = content.split(b"\n")
        now = json.loads(json.dumps(search.setting))
        then, self.trials, self._size, reason = now, [], 0, ""
        for number, line in enumerate(lines[:-1]):
            try:
                if number == 0:
                    then = _setting(line)
                else:
                    self.trials.append(_trial(line))
            except ValueError as error:
                reason = str(error)
                break
            self._size += len(line) + 1
        # Whole trials after a damaged line are not flown again either: the search asks for their gains once more.
        self._aside = dict(filter(None, map(_known, content[self._size :].split(b"\n"))))
        if self._aside and not self._size:
            raise ValueError(damage(self._path, f"line 1, its setting, is damaged: {reason}", "tune in a new folder"))
        different = [
            name if isinstance(value, dict) or name == "scenario" else f"{name} ({then.get(name)!r}, now {value!r})"
            for name, value in now.items()
            if then.get(name) != value
        ]
        rule = f"must hold a study of the same setting; this one differs in {', '.join(different)}"
        require(not different, "folder", rule, str(folder))
        if self._size < len(content):
            self._set_aside(content[self._size :], reason or "it has no end")
        if not self._size:
            self._write(now)

    @property
    def best(self) -> Trial:
        """The first trial with the largest value."""
        return max(self.trials, key=lambda trial: trial.value, default=Trial({}, FAILED))

    def recover(self, gains: Mapping[str, Any]) -> float | None:
        """Return the value of gains whose whole trial stood after a damage; None for others."""
        return self._aside.get(_key(gains))

    def expect(self, gains: Sequence[Mapping[str, Any]], first: int) -> bool:
        """Compare the trials with the gains that the search asks for; tell whether they are of this search.

        After a line that was lost, doubled or moved, it and what follows are set aside, for :meth:`recover`.

        Parameters
        ----------
        gains
            Gains of consecutive trials.
        first
            Number of the first of them.
        """
        pairs = enumerate(zip(gains, self.trials[first:], strict=False), first)
        place = next((place for place, (item, trial) in pairs if trial.gains != item), None)
        if place is None:
            return True
        wanted, before = [_key(item) for item in gains], {_key(trial.gains) for trial in self.trials[:place]}
        moved = {_key(trial.gains): trial.value for trial in self.trials[place:]}
        # Another version asks for other gains altogether.
        if not (before | moved.keys()).intersection(wanted) and _key(self.trials[place].gains) not in before:
            return False
        content = self._path.read_bytes()
        self._size = sum(map(len, content.splitlines(keepends=True)[: 1 + place]))
        self._aside = {**moved, **self._aside}
        del self.trials[place:]
        self._set_aside(content[self._size :], "its gains are not those that the search asks for here")
        return True

    def add(self, trial: Trial) -> None:
        """Append a finished trial; after an error, for example of a full disk, the journal is as before.

        Raises
        ------
        OSError
            If the journal cannot be written.
        """
        self._write({**asdict(trial), "value": None if trial.value == FAILED else trial.value})
        self.trials.append(trial)

    def _set_aside(self, damaged: bytes, reason: str) -> None:
        torn, line = self._path.with_name(TORN), 1 + self._path.read_bytes()[: self._size].count(b"\n")
        with torn.open("ab") as file:
            file.write(damaged.removesuffix(b"\n") + b"\n")
            file.flush()
            os.fsync(file.fileno())
        os.truncate(self._path, self._size)
        remedy = f"it and what follows are moved to {torn}, trials kept before it: {len(self.trials)}"
        warnings.warn(damage(self._path, f"line {line} is damaged: {reason}", remedy), stacklevel=3)

    def _write(self, record: Mapping[str, Any]) -> None:
        line = json.dumps(record, allow_nan=False).encode() + b"\n"
        try:
            with self._path.open("ab") as file:
                file.write(line)
                file.flush()
                os.fsync(file.fileno())
        except OSError as error:
            with suppress(OSError):
                os.truncate(self._path, self._size)
            raise OSError(error.errno, error.strerror, str(self._path)) from error
        self._size += len(line)


def _setting(line: bytes) -> dict[str, Any]:
    """Return the setting that a line holds; raise a ValueError if it holds none."""
    setting = parse_json(line)
    require(isinstance(setting, dict) and "gains" not in setting, "setting", "must be an object", setting)
    return dict(setting)


def _trial(line: bytes) -> Trial:
    """Return the trial that a line holds; raise a ValueError if it holds none."""
    record = parse_json(line)
    whole = isinstance(record, dict) and record.keys() == {"gains", "value"}
    require(whole, "trial", "must have gains and value", record)
    gains, value = record["gains"], record["value"]
    require(isinstance(gains, dict) and bool(gains), "gains", "must be an object with an entry for each gain", gains)
    return Trial(gains, FAILED if value is None else finite(value, "value"))


def _known(line: bytes) -> tuple[str, float] | None:
    try:
        trial = _trial(line)
    except ValueError:
        return None
    return _key(trial.gains), trial.value


def _key(gains: Mapping[str, Any]) -> str:
    return json.dumps(gains, sort_keys=True)
