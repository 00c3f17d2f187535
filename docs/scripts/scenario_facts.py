"""Tables of what a scenario holds, in Markdown."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
from docstring_parts import document, field_meanings, numpy_section, simple_table, to_markdown
from pages import markdown_table

from ftac_gym.envs.observation import TIERS, observation_layout
from ftac_gym.envs.reward import __doc__ as reward_text
from ftac_gym.faults import Fault, FaultDistribution, FaultSchedule
from ftac_gym.task.scenario import Scenario


def number(value: float) -> str:
    """Return a number with four digits."""
    return f"{value:.4g}"


def show(value: Any, interval: bool = False) -> str:
    """Return a value of a field in words.

    Parameters
    ----------
    value
        The value.
    interval
        Whether a pair of numbers is the range of a uniform distribution instead of a vector.
    """
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int | float):
        return number(value)
    if isinstance(value, tuple):
        if interval and len(value) == 2 and all(isinstance(item, int | float) for item in value):
            return f"{number(value[0])} to {number(value[1])}"
        if not interval and any(isinstance(item, tuple) for item in value):
            return "; ".join(", ".join(show(item) for item in row) for row in value)
        shown = [show(item, interval) for item in value]
        if len(shown) > 1 and len(set(shown)) == 1:
            return f"{shown[0]} each"
        return ("; " if dataclasses.is_dataclass(value[0]) else ", ").join(shown)
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        inner = {name: f"({text})" if ", " in text else text for name, text in field_values(value).items()}
        return f"{type(value).__name__}: " + ", ".join(f"{name} {text}" for name, text in inner.items())
    return str(value)


def field_values(part: Any, skip: tuple[str, ...] = ()) -> dict[str, str]:
    """Return the fields of a part that are on, by name, in words."""
    values = {}
    for item in dataclasses.fields(part):
        value = getattr(part, item.name)
        # An effect of size zero that is off by default is not worth a line.
        off = value is None or (value == item.default and not np.any(value))
        if not off and item.name not in skip:
            values[item.name] = show(value, interval="Interval" in str(item.type))
    return values


def _in_degrees(value: Any, meaning: str) -> str:
    """Return an angle that is one number or one range in degrees too, where the meaning says that it is one."""
    unit = next((unit for unit in ("rad/s", "rad") if f"[{unit}]" in meaning), None)
    scalars = value if isinstance(value, tuple) and len(value) == 2 else (value,)
    if unit is None or not all(isinstance(item, float) and item != 0.0 for item in scalars):
        return ""
    return f" ({' to '.join(number(math.degrees(item)) for item in scalars)} {unit.replace('rad', 'deg')})"


def fields(part: Any, skip: tuple[str, ...] = ()) -> str:
    """Return a table of the fields of a part: value, and meaning with its unit."""
    meanings = field_meanings(type(part))
    rows = []
    for name, shown in field_values(part, skip).items():
        meaning = meanings.get(name, "")
        rows.append((f"`{name}`", shown + _in_degrees(getattr(part, name), meaning), meaning))
    return markdown_table(("field", "value", "meaning"), rows)


def part(value: Any, otherwise: str, skip: tuple[str, ...] = ()) -> str:
    """Return the class of a part of a scenario and a table of its fields, or what holds without it."""
    if value is None:
        return f"{otherwise}\n"
    name = f"{type(value).__module__}.{type(value).__name__}"
    return f"{{py:class}}`~{name}`:\n\n{fields(value, skip)}"


def _magnitudes(fault: Fault) -> str:
    """Return the fields of a fault in which it differs from its kind's defaults, but for its wheel."""
    shown = field_values(fault)
    defaults = {item.name: item.default for item in dataclasses.fields(fault)}
    differs = [name for name in shown if name != "wheel" and getattr(fault, name) != defaults[name]]
    return ", ".join(f"`{name}` {shown[name]}" for name in differs)


def _kind(fault: Fault) -> str:
    return f"{{py:class}}`~{type(fault).__module__}.{type(fault).__name__}`"


def faults(scenario: Scenario) -> str:
    """Return the faults of a scenario and their weights."""
    drawn = scenario.faults
    if drawn is None:
        return "None.\n"
    if isinstance(drawn, FaultSchedule):
        rows = []
        for fault in drawn.faults:
            wheel = getattr(fault, "wheel", None)
            rows.append(("the sensors" if wheel is None else f"wheel {wheel}", _kind(fault), _magnitudes(fault)))
        return "The same in every episode; times in [s], torques in [N m].\n\n" + markdown_table(
            ("strikes", "kind", "how"), rows
        )
    assert isinstance(drawn, FaultDistribution)
    words = {0: "have none", 1: "one fault", 2: "two faults", 3: "three faults"}
    shares = [(count, share) for count, share in enumerate(drawn.fault_counts) if share > 0.0]
    counts = [f"{share:.0%} {words.get(count, f'{count} faults')}" for count, share in shares]
    rows = [
        (f"{weight:.1%}", _kind(fault), _magnitudes(fault))
        for weight, fault in zip(drawn.weights or (), drawn.kinds, strict=True)
    ]
    head = f"Of the episodes {', '.join(counts)}. Times in [s], torques in [N m]; a range is drawn from"
    return f"{head} uniformly.\n\n" + markdown_table(("share", "kind", "how"), rows)


def observations(scenario: Scenario) -> str:
    """Return the slices of the observation in each tier."""
    texts = {row[0].strip("`"): to_markdown(row[2]) for row in simple_table(document(observation_layout))}
    layouts = {tier: observation_layout(scenario, tier) for tier in TIERS}
    oracle = layouts["oracle"]
    rows = []
    for name, place in oracle.slices.items():
        where = [
            f"{layout.slices[name].start}:{layout.slices[name].stop}" if name in layout.slices else ""
            for layout in layouts.values()
        ]
        bound = number(float(oracle.high[place.start]))
        rows.append((f"`{name}`", str(place.stop - place.start), *where, f"±{bound}", texts[name]))
    sizes = ", ".join(f"{layout.size} in the tier `{tier}`" for tier, layout in layouts.items())
    return f"Numbers: {sizes}.\n\n" + markdown_table(("slice", "length", *TIERS, "bound", "what it is"), rows)


def reward(scenario: Scenario) -> str:
    """Return the terms of the reward with their weights."""
    terms = {row[0].strip("`"): to_markdown(row[1]) for row in simple_table(reward_text or "")}
    rows = [(f"`{name}`", number(getattr(scenario.reward, name)), text) for name, text in terms.items()]
    return markdown_table(("term", "weight", "what it adds per step"), rows)


def arguments(text: str) -> str:
    """Return the arguments in a NumPy docstring, and what they raise."""
    rows = [(f"`{name}`", meaning) for name, meaning in numpy_section(text, "Parameters").items()]
    raised = [
        f"Raises `{name}`: {meaning[0].lower()}{meaning[1:]}" for name, meaning in numpy_section(text, "Raises").items()
    ]
    return markdown_table(("argument", "meaning"), rows) + "\n" + "\n\n".join(raised) + "\n"
