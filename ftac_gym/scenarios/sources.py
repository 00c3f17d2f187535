"""Scenarios from what a user gives: a name, a file, a function, or data."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ftac_gym.scenarios import library
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.files import reason_of
from ftac_gym.utils.importing import called, imported, is_path
from ftac_gym.utils.parameters import broken, require

ScenarioLike = Scenario | Mapping[str, Any] | str | os.PathLike[str]
"""A scenario in one of the forms that :func:`resolve` takes."""

_FORMS = "a file FILE.json, 'module:function', JSON text, a dict, or a Scenario"


def resolve(source: ScenarioLike) -> Scenario:
    """Return the scenario that a user names.

    Parameters
    ----------
    source
        One of

        - the name of a scenario of the package or of a registered one, see :func:`~ftac_gym.scenarios.register`;
        - the path of a file that holds :meth:`~ftac_gym.task.scenario.Scenario.to_json`; as text, it ends in ``.json``;
        - ``"module:function"``: a function without arguments that returns a scenario, or the scenario itself. The
          module is imported, from the working directory first;
        - the JSON text, or the plain dict of :meth:`~ftac_gym.task.scenario.Scenario.to_dict`;
        - a :class:`~ftac_gym.task.scenario.Scenario`, which is returned.

    Raises
    ------
    ValueError
        If there is no such scenario, or its data break a rule. The message is one line that says what was tried.
    """
    if isinstance(source, Scenario):
        return source
    if isinstance(source, Mapping):
        return Scenario.from_dict(source)
    require(isinstance(source, (str, os.PathLike)), "scenario", f"must be a name, {_FORMS}", source)
    text = os.fspath(source)
    if isinstance(source, str):
        if text.lstrip().startswith("{"):
            return Scenario.from_json(text)
        if (found := library.find(text)) is not None:
            return found
        if is_path(text):
            return _returned(text)
    if isinstance(source, os.PathLike) or text.lower().endswith(".json"):
        return _read(Path(text))
    raise broken("scenario", f"must be one of {library.names()}, {_FORMS}", source)


def _read(path: Path) -> Scenario:
    try:
        return Scenario.from_json(path.read_text(encoding="utf-8-sig"))
    except OSError as error:
        raise ValueError(f"scenario must be a file that can be read, got {str(path)!r}: {error.strerror}") from None
    except ValueError as error:
        raise ValueError(f"{path}: {reason_of(error)}") from None


def _returned(path: str) -> Scenario:
    found = imported(path, "scenario")
    require(found is not None, "scenario", "must be defined in its module", path)
    scenario = called(found, path, "scenario") if callable(found) else found
    if not isinstance(scenario, Scenario):
        raise broken(f"scenario from {path!r}", "must be a Scenario", scenario)
    return scenario
