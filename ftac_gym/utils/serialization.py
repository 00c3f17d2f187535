"""Frozen dataclasses to plain JSON data and back, with the class named in each object."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

TYPE_KEY = "type"

LATER_PART = {"later part": True}
"""Metadata of a field that is not written where it has its default: what was written before it existed stays the same
text."""


def to_plain(value: Any) -> Any:
    """Turn a (nested) dataclass into dicts, lists, numbers, strings and None."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        fields = {
            field.name: to_plain(getattr(value, field.name))
            for field in dataclasses.fields(value)
            if not (field.metadata == LATER_PART and getattr(value, field.name) == field.default)
        }
        return {TYPE_KEY: type(value).__name__, **fields}
    if isinstance(value, (tuple, list)):
        return [to_plain(item) for item in value]
    return value


def from_plain(value: Any, classes: Mapping[str, type], hint: str = "") -> Any:
    """Rebuild what :func:`to_plain` wrote.

    Parameters
    ----------
    value
        Plain data; every dict must name its class under ``"type"``.
    classes
        The classes that may be built, by name.
    hint
        What to say after the message of an unknown class.

    Raises
    ------
    ValueError
        If a dict names no class or an unknown one, has a field that the class does not, or lacks one that it needs.
    """
    if isinstance(value, Mapping):
        name = str(value.get(TYPE_KEY))
        if name not in classes:
            raise ValueError(f"{TYPE_KEY} must be one of {sorted(classes)}, got {name!r}{hint}")
        known = {field.name for field in dataclasses.fields(classes[name])}
        fields = {key: from_plain(item, classes, hint) for key, item in value.items() if key != TYPE_KEY}
        if unknown := sorted(set(fields) - known):
            raise ValueError(f"{name} has no field {unknown[0]!r}; its fields are {sorted(known)}")
        required = {
            field.name
            for field in dataclasses.fields(classes[name])
            if field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING
        }
        if missing := sorted(required - set(fields)):
            raise ValueError(f"{name} needs the field {missing[0]!r}")
        return classes[name](**fields)
    if isinstance(value, (list, tuple)):
        return tuple(from_plain(item, classes, hint) for item in value)
    return value
