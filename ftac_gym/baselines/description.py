"""Description of a baseline in words and numbers: summary, information tier, gains and the stability of its loop."""

from __future__ import annotations

import inspect
from typing import Any

from ftac_gym.baselines.baseline import Baseline
from ftac_gym.baselines.custom import BaselineLike, label
from ftac_gym.baselines.gains import offered
from ftac_gym.baselines.linear_loop import NoLinearLoopError, loop_margins
from ftac_gym.baselines.registry import build
from ftac_gym.baselines.units import Unit
from ftac_gym.task.scenario import Scenario


def describe(name: BaselineLike, scenario: Scenario, gains: str = "default", **changes: Any) -> str:
    """Return summary, information tier, gains and the stability of the loop of a baseline in a task, as text.

    Parameters and errors are those of :func:`ftac_gym.baselines.make`.

    Examples
    --------
    >>> from ftac_gym import baselines, scenarios
    >>> print(baselines.describe("pd_dob", scenarios.get("flagship")))  # doctest: +SKIP
    """
    baseline = build(name, scenario, gains=gains, **changes)
    lines = [
        f"{label(name)} in {scenario.name}, {gains} gains",
        inspect.getdoc(type(baseline)).partition("\n")[0],  # type: ignore[union-attr]  # Baseline has a docstring.
        f"information: {baseline.information}",
        "gains:",
        *(f"  {line}" for line in _gain_lines(baseline)),
        f"loop of {scenario.control_period:g} s with a delay of {scenario.loop_delay:g} s: {stability(baseline)}",
    ]
    return "\n".join(lines)


def stability(baseline: Baseline) -> str:
    """Return spectral radius and margins of the linear loop of a baseline as text, or the reason why there are none."""
    try:
        return str(loop_margins(baseline))
    except NoLinearLoopError as error:
        return f"no linear loop: {error}"


def _gain_lines(baseline: Baseline) -> list[str]:
    """Return each gain with its value and unit, also in SI units where that is a unit of the scenario.

    Of a baseline without a dataclass of gains these are the arguments that were given.
    """
    fields = offered(baseline.gains)
    if not fields:
        kind, (args, kwargs) = type(baseline), baseline.arguments
        bound = inspect.signature(kind).bind(*args, **kwargs)
        bound.apply_defaults()
        given = {key: value for key, value in bound.arguments.items() if key not in ("scenario", "num_spacecraft")}
        return [f"{key} = {value}" for key, value in given.items()] or ["none"]
    shown = []
    for item in fields:
        unit = item.metadata.get("unit")
        text = f"{item.name} = {_number(getattr(baseline.gains, item.name))}"
        if isinstance(unit, Unit):
            text += f" {unit} = {_number(getattr(baseline.scheduled, item.name))} {unit.si}"
        elif isinstance(unit, str) and unit:
            text += f" {unit}"
        shown.append(text)
    return shown


def _number(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)
