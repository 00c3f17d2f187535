"""Checks of arrays from elsewhere: shape, data type, and rules for the fields of records."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from ftac_gym.utils.parameters import require

BoolArray = npt.NDArray[np.bool_]

Rule = tuple[Callable[[Any], BoolArray], str]
"""Test of an array, which returns an array of the same shape or of its first axes, and its text for messages."""

FINITE: Rule = (np.isfinite, "must be finite")
NOT_NEGATIVE: Rule = (lambda values: np.isfinite(values) & (values >= 0), "must be finite and not negative")
FLAG: Rule = (lambda values: (values == 0) | (values == 1), "must be 0 or 1")
UNIT_QUATERNION: Rule = (
    lambda values: np.abs(np.sum(values * values, axis=-1) - 1.0) < 1e-6,
    "must be a unit quaternion, scalar first",
)


def check_form(array: Any, dtype: npt.DTypeLike, shape: tuple[int | None, ...], name: str) -> None:
    """Raise a ValueError unless an array has a data type and a shape, of which None leaves a length open."""
    require(isinstance(array, np.ndarray), name, "must be an array", type(array).__name__)
    fits = array.ndim == len(shape) and all(want in (None, have) for have, want in zip(array.shape, shape, strict=True))
    lengths = ", ".join("*" if length is None else str(length) for length in shape)
    require(fits, name, f"must have shape ({lengths})", array.shape)
    expected = np.dtype(dtype)
    if array.dtype == expected:
        return
    given, fields = array.dtype.names or (), expected.names or ()
    for field in fields:
        require(field in given, name, f"must have the field {field!r}", given or array.dtype)
    require(bool(fields) and len(fields) == len(given), name, f"must be of the type {fields or expected}", array.dtype)
    for field in fields:
        want, have = expected[field], array.dtype[field]
        require(want == have, f"{name}.{field}", f"must be of the type {want}", have)
    require(False, name, "must have its fields side by side", array.dtype.itemsize)


def check_values(values: npt.NDArray[Any], rule: Rule, name: str) -> None:
    """Raise a ValueError that shows the first of the values for which a rule does not hold."""
    test, text = rule
    with np.errstate(all="ignore"):
        valid = np.asarray(test(values))
    if not valid.all():
        require(False, name, text, values[~valid][0].tolist())


def check_finite(values: npt.NDArray[Any], name: str) -> None:
    """Raise a ValueError that shows the first values that are not finite, if there are any."""
    sound = np.isfinite(values)
    require(bool(sound.all()), name, "must be finite", values[~sound][:3])


def check_fields(table: npt.NDArray[np.void], rules: Mapping[str, Rule], name: str) -> None:
    """Raise a ValueError unless each field of records follows its rule; fields without one must be finite."""
    for field in table.dtype.names or ():
        check_values(table[field], rules.get(field, FINITE), f"{name}.{field}")
