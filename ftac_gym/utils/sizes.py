"""Limit of the size of numbers, which keeps what is computed from them within double precision."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np

from ftac_gym.utils.parameters import finite, is_number, require

LARGEST_NUMBER = 1e12
"""Limit of every number of a scenario and of gains: products of ten of them stay within double precision."""


def check_size(value: Any, field: str) -> None:
    """Check the numbers in a value: in dataclasses, mappings, lists and arrays, or alone.

    Parameters
    ----------
    value
        The value; text, truth values and None in it are left alone.
    field
        Name of the value in messages; without one, that of a dataclass is left out.

    Raises
    ------
    ValueError
        If a number is larger than :data:`LARGEST_NUMBER`, or not finite; the message has the path of the number.
    """
    if _fits(value):  # Paths are needed for errors alone.
        return
    if dataclasses.is_dataclass(value):
        for item in dataclasses.fields(value):
            check_size(getattr(value, item.name), f"{field}.{item.name}" if field else item.name)
    elif isinstance(value, Mapping):
        for name, entry in value.items():
            check_size(entry, f"{field}.{name}")
    elif isinstance(value, (tuple, list)) or (isinstance(value, np.ndarray) and value.ndim > 0):
        for index, entry in enumerate(value):
            check_size(entry, f"{field}[{index}]")
    elif is_number(value):
        require(abs(finite(value, field)) <= LARGEST_NUMBER, field, f"must be within {LARGEST_NUMBER:g} of zero", value)


def _fits(value: Any) -> bool:
    """Return whether all numbers in a value are within :data:`LARGEST_NUMBER` of zero."""
    kind = type(value)
    if kind is float or kind is int:
        return bool(-LARGEST_NUMBER <= value <= LARGEST_NUMBER)
    if isinstance(value, (tuple, list)) or (isinstance(value, np.ndarray) and value.ndim > 0):
        return all(map(_fits, value))
    if dataclasses.is_dataclass(value):
        return all(_fits(getattr(value, item.name)) for item in dataclasses.fields(value))
    if isinstance(value, Mapping):
        return all(map(_fits, value.values()))
    return not is_number(value) or bool(-LARGEST_NUMBER <= value <= LARGEST_NUMBER)
