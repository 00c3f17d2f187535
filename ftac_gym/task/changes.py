"""Short forms in which the fields of a scenario may be changed."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

from ftac_gym.faults import Fault, FaultDistribution, FaultSchedule
from ftac_gym.faults.specification import ADDED, NO_FAULTS, parse_all
from ftac_gym.utils.serialization import TYPE_KEY, classes, classes_of, from_plain, hints_of, required_fields


def changed(present: Any, change: Any, field: str, hint: Any) -> Any:
    """Return the new value of a field.

    Parameters
    ----------
    present
        Its value before.
    change
        The new value; a dict with ``"type"``, in the form of :meth:`~ftac_gym.task.scenario.Scenario.to_dict`; or a
        dict of some fields, which change the part that is there, or the default part where there is none. Where that
        part can be of several classes, the fields must be those of one of them alone. A list may hold such dicts with
        ``"type"``.
    field
        Name of the field, for messages.
    hint
        Type annotation of the field.

    Raises
    ------
    ValueError
        If a dict names an unknown field, or a value breaks a rule; the message has the path of the field.
    """
    if isinstance(change, Mapping):
        return from_plain(_merged(present, change, hint), field, hint)
    if isinstance(change, (list, tuple)):
        parts = enumerate(change)
        return tuple(from_plain(p, f"{field}[{k}]", hint) if isinstance(p, Mapping) else p for k, p in parts)
    return change


def changed_faults(present: Any, change: Any, hint: Any) -> Any:
    """Return the new faults; beside the forms of :func:`changed` they may be a fault, a list of faults, or text.

    Parameters
    ----------
    present
        The faults before.
    change
        A fault, or a list of faults, each an object, its plain dict, or text: the schedule of these faults. Text is of
        the form of :func:`~ftac_gym.faults.specification.parse_all`, for example ``"outage:0@5"``; ``"none"`` is None.
        Text that starts with ``+`` adds its faults to those present: to the ``always`` of a distribution. So does a
        list of such texts.
    hint
        Type annotation of the field.

    Raises
    ------
    ValueError
        If there is no such fault, or a value breaks a rule.
    """
    if isinstance(change, str) and change == NO_FAULTS:
        return None
    if isinstance(change, (str, Fault)) or _describes_fault(change):
        change = [change]
    if not isinstance(change, (list, tuple)):
        return changed(present, change, "faults", hint)
    if change and all(isinstance(item, str) and item.startswith(ADDED) for item in change):
        return _with(present, tuple(fault for item in change for fault in parse_all(item.removeprefix(ADDED))))
    found: list[Any] = []
    for number, item in enumerate(change):
        if isinstance(item, str):
            found.extend(parse_all(item))
        else:
            found.append(from_plain(item, f"faults[{number}]", Fault))
    return FaultSchedule(tuple(found))


def _with(present: FaultDistribution | FaultSchedule | None, added: tuple[Fault, ...]) -> Any:
    """Return the faults with some that are in every episode."""
    if isinstance(present, FaultDistribution):
        return dataclasses.replace(present, always=(*present.always, *added))
    return FaultSchedule((*(present.faults if present is not None else ()), *added))


def _describes_fault(change: Any) -> bool:
    kind = classes().get(str(change.get(TYPE_KEY))) if isinstance(change, Mapping) else None
    return kind is not None and issubclass(kind, Fault)


def _merged(present: Any, change: Mapping[str, Any], hint: Any) -> Mapping[str, Any]:
    """Return the complete description of a part of which some fields change."""
    if TYPE_KEY in change:
        return change
    if dataclasses.is_dataclass(present) and not isinstance(present, type):
        cls: type = type(present)
        before = {item.name: getattr(present, item.name) for item in dataclasses.fields(present)}
    else:
        candidates = list(classes_of(hint))
        if len(candidates) > 1:
            given = set(change)
            candidates = [kind for kind in candidates if set(required_fields(kind)) <= given <= set(hints_of(kind))]
        if len(candidates) != 1:
            return change
        cls, before = candidates[0], {}
    hints = hints_of(cls)
    after = {
        name: _merged(before.get(name), value, hints.get(name, object)) if isinstance(value, Mapping) else value
        for name, value in change.items()
    }
    return {TYPE_KEY: cls.__name__, **before, **after}
