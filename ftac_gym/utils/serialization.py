"""Frozen dataclasses to plain JSON data and back, with the class named in each object."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any, TypeVar, get_args, get_type_hints

import numpy as np

from ftac_gym.utils.parameters import in_one_line, require

T = TypeVar("T")

TYPE_KEY = "type"

LATER_PART = {"later part": True}
"""Metadata of a field that is not written while it has its default.

Text from before the field existed thus stays the same.
"""

_CLASSES: dict[str, type] = {}
"""All serializable classes by name. It grows while modules are imported. With Gymnasium's registry of ids and a user's
scenarios by name it is the only state of the process."""


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
    """Turn a dataclass, or dicts and lists with dataclasses inside, into dicts, lists, numbers, strings and None."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        fields = {
            field.name: to_plain(getattr(value, field.name))
            for field in dataclasses.fields(value)
            if not (field.metadata == LATER_PART and getattr(value, field.name) == field.default)
        }
        return {TYPE_KEY: type(value).__name__, **fields}
    if isinstance(value, (tuple, list)):
        return [to_plain(item) for item in value]
    if isinstance(value, Mapping):
        return {name: to_plain(item) for name, item in value.items()}
    return value


def reads_as_number(text: str) -> bool:
    """Tell whether a text is a number in Python's form, ``"1e-4"`` for example."""
    try:
        float(text)
    except ValueError:
        return False
    return True


def parse_json(text: str | bytes, path: str = "JSON") -> Any:
    """Return the data of JSON text, strictly.

    Parameters
    ----------
    text
        The text.
    path
        Name of the data in messages.

    Raises
    ------
    ValueError
        If the text is no JSON, is nested too deeply, has a key twice in one object, or a number that is not finite.
        The message has the path of the place.
    """
    require(isinstance(text, (str, bytes, bytearray)), path, "must be JSON text", text)
    try:
        data = json.loads(text, object_pairs_hook=_unique, parse_int=_integer)
        _check_plain(data, path)
    except RecursionError:
        raise _too_deep(path) from None
    except (json.JSONDecodeError, UnicodeDecodeError) as error:
        raise ValueError(f"{path} must be JSON text: {error}") from None
    return data


def _unique(pairs: list[tuple[str, Any]]) -> dict[str, Any] | _Twice:
    found = dict(pairs)
    if len(found) == len(pairs):
        return found
    names = [name for name, _ in pairs]
    return _Twice(next(name for name in names if names.count(name) > 1))


def _integer(literal: str) -> int | float:
    try:
        return int(literal)
    except ValueError:  # Python refuses thousands of digits; this is infinite.
        return float(literal)


@dataclasses.dataclass(frozen=True)
class _Twice:
    """A JSON object with a key twice."""

    key: str


def _check_plain(data: Any, path: str) -> None:
    if isinstance(data, _Twice):
        require(False, path, "must have every key once", data.key)
    if isinstance(data, dict):
        for key, item in data.items():
            _check_plain(item, f"{path}.{key}")
    elif isinstance(data, list):
        for index, item in enumerate(data):
            _check_plain(item, f"{path}[{index}]")
    elif isinstance(data, float):
        require(math.isfinite(data), path, "must be finite", data)


def _too_deep(path: str) -> ValueError:
    return ValueError(f"{path} must not be nested so deeply")


def from_plain(value: Any, path: str, hint: Any = object) -> Any:
    """Rebuild what :func:`to_plain` wrote.

    Parameters
    ----------
    value
        Plain data; every dict must name a serializable class under ``"type"``.
    path
        Name of the value in messages.
    hint
        Type annotation of the place of the value; its classes are those that a dict may name.

    Raises
    ------
    ValueError
        If a dict names no class or one that does not fit, or a field is unknown, missing or breaks a rule. The message
        has the path of the field.
    """
    try:
        return _rebuilt(value, path, tuple(classes_of(hint)))
    except RecursionError:
        raise _too_deep(path) from None


def _rebuilt(value: Any, path: str, bases: tuple[type, ...]) -> Any:
    if isinstance(value, (list, tuple)):
        return tuple(_rebuilt(item, f"{path}[{index}]", bases) for index, item in enumerate(value))
    if not isinstance(value, Mapping):
        return value
    name, cls = value.get(TYPE_KEY), _named(value, path, bases)
    known = [field.name for field in dataclasses.fields(cls)]
    for key in value:
        if key not in (TYPE_KEY, *known):
            raise ValueError(in_one_line(f"{path}: {name} has no field {key!r}; its fields are {sorted(known)}"))
    for key in required_fields(cls):
        if key not in value:
            raise ValueError(f"{path}: {name} needs the field {key!r}")
    hints = hints_of(cls)
    fields = {
        key: _rebuilt(value[key], f"{path}.{key}", tuple(classes_of(hints[key]))) for key in known if key in value
    }
    try:
        with np.errstate(all="ignore"):  # Huge numbers overflow in the checks that refuse them.
            return cls(**fields)
    except ValueError as error:
        raise ValueError(in_one_line(f"{path}.{error}")) from None
    except (TypeError, AttributeError, LookupError, ArithmeticError) as error:  # Of a class from elsewhere.
        raise ValueError(in_one_line(f"{path} must describe a {name}, which raises {error!r}")) from error


def _named(value: Mapping[str, Any], path: str, bases: tuple[type, ...]) -> type:
    """Return the class that an object names, one of some classes or derived from them."""
    name = value.get(TYPE_KEY)
    require(bool(bases), path, "must not be an object", dict(value))
    fitting = sorted(known for known, cls in _CLASSES.items() if issubclass(cls, bases))
    if isinstance(name, str) and name in fitting:
        return _CLASSES[name]
    if isinstance(name, str) and name in _CLASSES:
        require(False, path, f"must describe a {' or '.join(fitting)}", name)
    custom = "; a custom fault kind is registered once its module is imported" if len(fitting) > len(bases) else ""
    raise ValueError(in_one_line(f"{path}.{TYPE_KEY} must be one of {fitting}, got {name!r}{custom}"))


def classes_of(hint: Any) -> Iterator[type]:
    """Yield the classes of objects in a type annotation."""
    if hint is object or (isinstance(hint, type) and dataclasses.is_dataclass(hint)):
        yield hint
    for part in get_args(hint):
        yield from classes_of(part)


@cache
def hints_of(cls: type) -> dict[str, Any]:
    """Return the type annotations of a class's fields; ``object`` for all where they cannot be evaluated."""
    try:
        return get_type_hints(cls)
    except (NameError, TypeError):  # Of a class inside a function, for example.
        return {field.name: object for field in dataclasses.fields(cls)}
