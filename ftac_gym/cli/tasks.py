"""Scenarios of the command line, and the short names of their tables and folders."""

import traceback
from pathlib import Path

from ftac_gym import scenarios
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.importing import is_path
from ftac_gym.utils.parameters import in_one_line, require


def scenario_of(text: str, option: str = "scenario") -> Scenario:
    """Return a scenario by NAME, FILE.json or module:function; end the program with a line if there is none."""
    try:
        return scenarios.resolve(text)
    except ValueError as error:
        message = " ".join(str(error).split())
        if message.startswith("scenario "):
            raise SystemExit(f"--{option}{message.removeprefix('scenario')}") from None
        # A part that an own function builds does not know of the function.
        place = "" if message.startswith(text) else f" {text}"
        raise SystemExit(f"--{option}{place}: {message}") from None
    except Exception as error:  # Of the user's own module.
        last = traceback.extract_tb(error.__traceback__)[-1]
        place = f"{Path(last.filename).name}, line {last.lineno}"
        raise SystemExit(f"--{option} {text}: {in_one_line(f'{type(error).__name__}: {error}')} ({place})") from error


def short_name(text: str) -> str:
    """Return the name of a scenario of the command line in tables and folders.

    Returns
    -------
    The name itself, the stem of a file, or the name of a function.

    Raises
    ------
    ValueError
        If a file or a function has the name of a scenario of the package, whose results they would be mixed with.
    """
    if text in scenarios.names():
        return text
    name = text.rpartition(":")[2] if is_path(text) else Path(text).stem
    free = not scenarios.is_shipped(name)
    require(free, "scenario", "must not be called like one of the package: rename the file or the function", text)
    return name


def is_own(text: str | None) -> bool:
    """Tell whether a scenario of the command line is a user's own."""
    return text is not None and not scenarios.is_shipped(text)
