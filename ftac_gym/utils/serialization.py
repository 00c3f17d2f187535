"""Frozen dataclasses to plain JSON data and back, with the class named in each object."""

import dataclasses
import json
import math
from collections.abc import Mapping
from typing import Any, TypeVar

from ftac_gym.utils.parameters import require

T = TypeVar("T")

TYPE_KEY = "type"

LATER_PART = {"later part": True}
"""Metadata of a field that is not written while it has its default.

Text from before the field existed thus stays the same.
"""

_CLASSES: dict[str, type] = {}
"""All serializable classes by name. It grows while modules are imported and is the only state of the process, next to
Gymnasium's registry of ids."""


def serializable(cls: type[T]) -> type[T]:
    """Register a dataclass under its name, so that :func:`from_plain` can build it; used as a decorator.

    A class that is defined again, by running its module once more, replaces its predecessor.

    Raises
    ------
    ValueError
        If another class has the name.
    """
    other = _CLASSES.get(cls.__name__)
    if other is not None and not same_definition(other, cls):
        require(False, "name", f"must be new; {other.__module__}.{other.__name__} has it", cls.__name__)
    _CLASSES[cls.__name__] = cls
    return cls


def classes() -> dict[str, type]:
    """Return all serializable classes by name, in the order of their registration."""
    return dict(_CLASSES)


def same_definition(first: type, second: type) -> bool:
    """Return whether two classes come from the same place of the same module."""
    return (first.__module__, first.__qualname__) == (second.__module__, second.__qualname__)


def required_fields(cls: type) -> list[str]:
    """Return the names of a dataclass's fields without a default."""
    missing = dataclasses.MISSING
    return [
        item.name for item in dataclasses.fields(cls) if item.default is missing and item.default_factory is missing
    ]


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


def parse_json(text: str | bytes) -> Any:
    """Return the data of JSON text, strictly.

    Raises
    ------
    ValueError
        If the text is no JSON, is nested too deeply, has a key twice in one object, or a number that is not finite.
    """

    def unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        found = dict(pairs)
        twice = next((key for index, (key, _) in enumerate(pairs) if key in dict(pairs[:index])), None)
        require(len(found) == len(pairs), "JSON", "must have every key once in an object", twice)
        return found

    def number(literal: str) -> float:
        value = float(literal)
        require(math.isfinite(value), "JSON", "must have finite numbers", literal[:40])
        return value

    try:
        return json.loads(text, object_pairs_hook=unique, parse_constant=number, parse_float=number)
    except RecursionError:
        raise ValueError("JSON must not be nested so deeply") from None


def from_plain(value: Any) -> Any:
    """Rebuild what :func:`to_plain` wrote.

    Parameters
    ----------
    value
        Plain data; every dict must name a serializable class under ``"type"``.

    Raises
    ------
    ValueError
        If a dict names no class or an unknown one, has a field that the class does not, or lacks one that it needs.
    """
    if isinstance(value, Mapping):
        name = str(value.get(TYPE_KEY))
        if name not in _CLASSES:
            hint = "a custom fault kind is registered once its module is imported"
            raise ValueError(f"{TYPE_KEY} must be one of {sorted(_CLASSES)}, got {name!r}; {hint}")
        cls = _CLASSES[name]
        known = {field.name for field in dataclasses.fields(cls)}
        fields = {key: from_plain(item) for key, item in value.items() if key != TYPE_KEY}
        if unknown := sorted(set(fields) - known):
            raise ValueError(f"{name} has no field {unknown[0]!r}; its fields are {sorted(known)}")
        if missing := sorted(set(required_fields(cls)) - set(fields)):
            raise ValueError(f"{name} needs the field {missing[0]!r}")
        return cls(**fields)
    if isinstance(value, (list, tuple)):
        return tuple(from_plain(item) for item in value)
    return value
