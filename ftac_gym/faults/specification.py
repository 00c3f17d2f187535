"""Faults as short text, for command lines: ``seizure:2@15``."""

from __future__ import annotations

import dataclasses
from typing import Any

from ftac_gym.faults.examples import EXAMPLES
from ftac_gym.faults.fault import Fault, WheelFault
from ftac_gym.faults.registry import registered
from ftac_gym.utils.parameters import require

FORM = "KIND:WHEEL@ONSET,FIELD=VALUE,..."
"""The form of a specification; only the kind is a must, and a wheel for what strikes one."""

SAMPLES = ("seizure:2@15", "loss_of_effectiveness:0@10,effectiveness=0.3", "star_tracker_outage@20,duration=30")


def name_of(kind: type[Fault]) -> str:
    """Return what a specification calls a kind: its label with underscores."""
    return kind.kind.label.replace(" ", "_")


def kinds() -> dict[str, type[Fault]]:
    """Return all fault kinds by the names that specifications use, registered ones among them."""
    return {name_of(kind): kind for kind in registered().values()}


def example(kind: type[Fault], **fields: Any) -> Fault:
    """Return a fault of a kind, strong enough to be seen where its size is not given.

    Parameters
    ----------
    kind
        One of the fault kinds.
    **fields
        What differs from the example. With a field of the kind's own, a magnitude, the others of its own are those of
        the class.
    """
    shared = {field.name for field in dataclasses.fields(WheelFault)}
    shown = EXAMPLES.get(kind.kind, {})
    if not shared.issuperset(fields):
        shown = {name: value for name, value in shown.items() if name in shared}
    return kind(**{**shown, **fields})


def parse(text: str) -> Fault:
    """Turn a specification into a fault.

    Parameters
    ----------
    text
        ``KIND:WHEEL@ONSET,FIELD=VALUE,...``: the kind's label with underscores or hyphens; the wheel, counted from
        zero, for the kinds that strike one; the onset [s], zero if not given; fields of the kind's class. A value is a
        number, a range ``LOW..HIGH``, ``true``, ``false`` or a word. See :func:`example` for what is not given.

    Raises
    ------
    ValueError
        If the text has another form, or the kind, a field or a value is not known; the message lists the known kinds
        or fields and has an example.
    """
    known = kinds()
    head, *assignments = (part.strip() for part in text.split(","))
    place, at, onset = head.partition("@")
    label, colon, wheel = place.partition(":")
    kind = known.get(label.strip().lower().replace("-", "_"))
    forms = f"must have the form {FORM}, for example {', '.join(map(repr, SAMPLES))}, with a KIND of {list(known)}"
    require(kind is not None, "fault", forms, text)
    assert kind is not None
    fields: dict[str, Any] = {"onset": _number(onset, "ONSET", forms, text)} if at else {}
    strikes = issubclass(kind, WheelFault)
    if strikes:
        require(wheel.strip().isdigit(), "fault", f"needs a WHEEL, as in '{name_of(kind)}:2@15'", text)
        fields["wheel"] = int(wheel)
    else:
        require(not colon, "fault", f"strikes no wheel: write '{name_of(kind)}@15'", text)
    settable = [field.name for field in dataclasses.fields(kind) if field.name not in ("wheel", "onset")]
    for assignment in assignments:
        name, equals, value = (part.strip() for part in assignment.partition("="))
        rule = f"has the fields {settable}, given as FIELD=VALUE"
        require(bool(equals) and name in settable, name_of(kind), rule, assignment)
        fields[name] = _value(value)
    return example(kind, **fields)


def _number(text: str, part: str, forms: str, whole: str) -> Any:
    value = _value(text)
    require(not isinstance(value, (str, bool)), part, f"must be a number [s]; a fault {forms}", whole)
    return value


def _value(text: str) -> Any:
    """Return the number, the range, the truth value or the word that a text stands for."""
    low, dots, high = text.partition("..")
    try:
        return (float(low), float(high)) if dots else float(text)
    except ValueError:
        return {"true": True, "false": False}.get(text.lower(), text)
