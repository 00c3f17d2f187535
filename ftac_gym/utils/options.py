"""Options of a program from a file of settings, each checked against the annotation of its field."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

from ftac_gym.utils.parameters import require

Options = TypeVar("Options")

_NAMES = {int: "a whole number", float: "a number", bool: "true or false", str: "text", Path: "text", NoneType: "null"}


def options_of(cls: type[Options], data: Any) -> Options:
    """Return the options that JSON data describe; those that are not there have their defaults.

    Parameters
    ----------
    cls
        Dataclass of the options. Its fields are numbers, truth values, text, paths, literals, tuples of one of these,
        and any of them or None.
    data
        The data.

    Raises
    ------
    ValueError
        If the data are no object, name another option, or a value has another type; the message names the option.
    """
    require(isinstance(data, Mapping), "settings", "must be an object", data)
    hints, known = get_type_hints(cls), [item.name for item in dataclasses.fields(cls)]  # type: ignore[arg-type]
    for name, value in data.items():
        require(name in known, "settings", f"must be among {known}", name)
        require(_fits(value, hints[name]), name, f"must be {_described(hints[name])}", value)
    return cls(**{name: _built(value, hints[name]) for name, value in data.items()})


def _fits(value: Any, hint: Any) -> bool:
    origin, parts = get_origin(hint), get_args(hint)
    if origin in (Union, UnionType):
        return any(_fits(value, part) for part in parts)
    if origin is Literal:
        return any(type(value) is type(part) and value == part for part in parts)
    if origin is tuple:
        return isinstance(value, list) and all(_fits(item, parts[0]) for item in value)
    return type(value) in {float: (int, float), Path: (str,)}.get(hint, (hint,))


def _described(hint: Any) -> str:
    origin, parts = get_origin(hint), get_args(hint)
    if origin in (Union, UnionType):
        return " or ".join(map(_described, parts))
    if origin is Literal:
        return f"one of {list(parts)}"
    return f"a list, each {_described(parts[0])}" if origin is tuple else _NAMES[hint]


def _built(value: Any, hint: Any) -> Any:
    if isinstance(value, list):
        return tuple(value)
    return Path(value) if hint is Path else value
