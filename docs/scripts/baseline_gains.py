"""Tables of a baseline's gains: default, tuned, and what they mean."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from docstring_parts import field_meanings
from pages import markdown_table
from scenario_facts import show

from ftac_gym import baselines
from ftac_gym.baselines import observers, tuned
from ftac_gym.baselines.memory import Memory
from ftac_gym.task.prescribed_bound import PrescribedBound
from ftac_gym.task.scenario import Scenario

HIDDEN = ("faults", "telemetry")
"""Parameters that are no gains: the page says elsewhere what they choose."""


def flat(gains: Mapping[str, Any]) -> dict[str, Any]:
    """Return gains by their names, with those of parts as ``part.gain``; a part without gains is left out."""
    found: dict[str, Any] = {}
    for name, value in gains.items():
        if isinstance(value, Mapping):
            found |= {f"{name}.{inner}": item for inner, item in value.items()}
        else:
            found[name] = value
    return found


@dataclass(frozen=True)
class Described:
    """What the code says of a parameter.

    Parameters
    ----------
    kind
        Its type.
    default
        Its default, in words.
    meaning
        What it means, with its unit.
    """

    kind: str = ""
    default: str = ""
    meaning: str = ""


def described(name: str, scenario: Scenario) -> dict[str, Described]:
    """Return what the code says of each gain of a baseline, those of its parts included."""
    parts: dict[str, type] = {"": baselines.baseline_class(name), "bound.": PrescribedBound}
    kind = baselines.defaults(name).get("faults")
    if kind in observers.names():
        parts["observer."] = type(observers.make(kind, scenario, Memory(1)))
    found: dict[str, Described] = {}
    for part, cls in parts.items():
        known = inspect.signature(cls).parameters
        for gain, meaning in field_meanings(cls).items():
            if gain in known:
                item = known[gain]
                # A scenario may prescribe other bounds than those of the class.
                fixed = item.default not in (item.empty, None) and part != "bound."
                found[part + gain] = Described(str(item.annotation), show(item.default) if fixed else "", meaning)
    return found


def table(name: str, scenario: Scenario) -> str:
    """Return the gains of a baseline, default against tuned, as a table."""
    known = described(name, scenario)
    default = {key: value for key, value in flat(baselines.defaults(name)).items() if key not in HIDDEN}
    found = flat(tuned.gains(name)) if name in tuned.names() else {}
    # A part without gains of its own has those of its class, or of the scenario.
    optional = ("observer", "bound")
    rows = []
    for key in [*default, *(key for key in found if key not in default)]:
        if key in optional and default[key] is None:
            continue
        unset = "its own" if key.partition(".")[0] in optional else "`None`"
        shown = [show(source[key]) if source.get(key) is not None else "" for source in (default, found)]
        item = known.get(key, Described())
        first = shown[0] or (item.default if key not in default else "") or unset
        rows.append([f"`{key}`", f"`{item.kind}`", first, *shown[1 : 1 + bool(found)], item.meaning])
    return markdown_table(("gain", "type", "default", *(("tuned",) if found else ()), "meaning"), rows)


def provenance(name: str) -> str:
    """Return where the tuned gains of a baseline come from, in words."""
    if name not in tuned.names():
        return "There are no tuned gains of this name."
    source = tuned.record(name)["provenance"]
    returns = source["fresh_mean_return"]
    return (
        f"The tuned gains come from {source['trials']} trials of {source['episodes']} episodes of"
        f" `{source['scenario']}` at commit `{source['commit'][:10]}`, with `{source['command']}` ({source['sampler']},"
        f" seed {source['sampler_seed']}). On fresh episodes their mean return is {returns['tuned']:.4g}, that of the"
        f" default gains {returns['default']:.4g}. An empty cell keeps the default."
    )


def schedulable(name: str) -> str:
    """Return which gains may change in flight, in words."""
    found = baselines.baseline_class(name).schedulable
    if not found:
        return "None of them can be scheduled by an agent."
    ranges = ", ".join(f"`{gain}` ({low:.4g} to {high:.4g})" for gain, (low, high) in found.items())
    return f"An agent may schedule these in flight, usually within the range given: {ranges}."
