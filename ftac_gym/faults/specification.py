"""Faults as short text, for command lines: ``seizure:2@15``."""

import dataclasses
import re
from collections.abc import Mapping
from math import radians
from typing import Any

from ftac_gym.faults.fault import Fault, WheelFault
from ftac_gym.faults.registry import registered
from ftac_gym.faults.table import FaultKind
from ftac_gym.utils.parameters import broken, require

FORM = "KIND:WHEEL@ONSET,FIELD=VALUE,..."
"""Form of a specification; the kind is required, and the wheel for faults of wheels."""

NO_FAULTS = "none"
"""Text of a healthy spacecraft."""

ADDED = "+"
"""Start of a text whose faults come on top of those of a scenario."""

EXAMPLES: Mapping[int, Mapping[str, Any]] = {
    FaultKind.LOSS_OF_EFFECTIVENESS: {"effectiveness": 0.1},
    FaultKind.DRIFTING_EFFECTIVENESS: {"effectiveness": 0.0, "rise": 30.0},
    FaultKind.BIAS: {"amplitude": 0.08, "frequency": 0.3},
    FaultKind.OUTAGE: {},
    FaultKind.LOCK_IN_PLACE: {},
    FaultKind.HARD_OVER: {"fraction": 0.5, "random_sign": False},
    FaultKind.FRICTION_RISE: {"factor": 100.0, "rise": 30.0},
    FaultKind.SEIZURE: {"brake": 2.0},
    FaultKind.INTERMITTENT_SHUTDOWN: {},
    FaultKind.COMMAND_DELAY: {"periods": 3.0},
    FaultKind.GYRO_BIAS_STEP: {"size": radians(0.05)},
    FaultKind.STAR_TRACKER_OUTAGE: {"duration": 60.0},
    FaultKind.ATTITUDE_SPIKE: {"angle": radians(2.0), "period": 15.0, "on_time": 0.3},
}
"""Fields of an example of each kind, besides wheel and onset; for wheels like the flagship's."""

SAMPLES = ("seizure:2@15", "loss_of_effectiveness:0@10,effectiveness=0.3", "star_tracker_outage@20,duration=30")


def name_of(kind: type[Fault]) -> str:
    """Return the name of a kind in specifications: its label with underscores."""
    return kind.kind.label.replace(" ", "_")


def kinds() -> dict[str, type[Fault]]:
    """Return all fault kinds, custom ones included, by their names in specifications."""
    return {name_of(kind): kind for kind in registered().values()}


def example(kind: type[Fault], **fields: Any) -> Fault:
    """Return a fault of a kind, with a clearly visible size unless one is given.

    Parameters
    ----------
    kind
        One of the fault kinds.
    **fields
        Changes to the example. If they set a field of the kind itself, such as a magnitude, its other fields have the
        defaults of the class.
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
        ``KIND:WHEEL@ONSET,FIELD=VALUE,...``. The kind is its label with underscores or hyphens. The wheel counts from
        zero and is for faults of wheels only. The onset [s] is zero if not given. The fields are those of the kind's
        class. A value is a number, a range ``LOW..HIGH``, ``true``, ``false`` or a word. Other fields are those of
        :func:`example`.

    Raises
    ------
    ValueError
        If the text has another form, or the kind, a field or a value is unknown. The message lists the kinds or the
        fields and has an example.
    """
    require(isinstance(text, str), "fault", f"must be text of the form {FORM}", text)
    known = kinds()
    head, *assignments = (part.strip() for part in text.split(","))
    place, at, onset = head.partition("@")
    label, colon, wheel = place.partition(":")
    kind = known.get(label.strip().lower().replace("-", "_"))
    forms = f"must have the form {FORM}, for example {', '.join(map(repr, SAMPLES))}, with a KIND of {list(known)}"
    if kind is None:
        raise broken("fault", forms, text)
    fields: dict[str, Any] = {"onset": _number(onset, "ONSET", forms, text)} if at else {}
    if issubclass(kind, WheelFault):
        number = re.fullmatch(r"[0-9]{1,9}", wheel.strip()) is not None
        require(number, "fault", f"needs a WHEEL, as in '{name_of(kind)}:2@15'", text)
        fields["wheel"] = int(wheel)
    else:
        require(not colon, "fault", f"affects no wheel: write '{name_of(kind)}@15'", text)
    settable = [field.name for field in dataclasses.fields(kind) if field.name not in ("wheel", "onset")]
    for assignment in assignments:
        name, equals, value = (part.strip() for part in assignment.partition("="))
        rule = f"has the fields {settable}, given as FIELD=VALUE"
        require(bool(equals) and name in settable, name_of(kind), rule, assignment)
        require(name not in fields, name_of(kind), "must have every field once", assignment)
        fields[name] = _value(value)
    return example(kind, **fields)


def parse_all(text: str) -> tuple[Fault, ...]:
    """Turn a text into faults.

    Parameters
    ----------
    text
        Specifications of :func:`parse`, joined by commas: ``"outage:0@5, bias:2@20, constant=0.05"`` is an outage and
        a bias. A part with ``=`` is a field of the fault before it.

    Raises
    ------
    ValueError
        As for :func:`parse`.
    """
    faults: list[str] = []
    for part in text.split(","):
        if "=" in part and faults:
            faults[-1] += f",{part}"
        else:
            faults.append(part)
    return tuple(map(parse, faults))


def _number(text: str, part: str, forms: str, whole: str) -> Any:
    value = _value(text)
    require(not isinstance(value, (str, bool)), part, f"must be a number [s]; a fault {forms}", whole)
    return value


def _value(text: str) -> Any:
    """Turn a text into a number, a range or a truth value; other words stay as they are."""
    low, dots, high = text.partition("..")
    try:
        return (float(low), float(high)) if dots else float(text)
    except ValueError:
        return {"true": True, "false": False}.get(text.lower(), text)
