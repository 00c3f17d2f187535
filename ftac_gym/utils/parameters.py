"""Checks of parameters, and uniform ranges to draw from: the vocabulary of every scenario dataclass."""

import math
import numbers
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]

Interval = float | tuple[float, float]
"""A fixed value, or a uniform distribution between a lower and an upper bound."""

Intervals = tuple[Interval, Interval, Interval]
"""One interval per body axis."""

Vector = tuple[float, ...]
Matrix = tuple[tuple[float, ...], ...]


LONGEST_MESSAGE = 500
"""Characters of an error message; a long value in it is cut."""

LEAST_VALUE = 60
"""Characters of a long value that a message shows, however long its rule is."""


def require(condition: bool, field: str, rule: str, value: object) -> None:
    """Raise a ValueError that names the field, the rule and the offending value unless the condition holds."""
    if not condition:
        raise broken(field, rule, value)


def broken(field: str, rule: str, value: object) -> ValueError:
    """Return the error of a broken rule: one line with the field, the rule and the offending value.

    The value is cut where the line is too long; a rule is not, since it lists the names that are right.
    """
    part = f"{field} {rule}, got "
    return ValueError(part + in_one_line(_shown(value), max(LONGEST_MESSAGE - len(part), LEAST_VALUE)))


def require_keywords(given: Iterable[str], known: Sequence[str], call: str, what: str) -> None:
    """Raise a TypeError, as a call of Python does, if a keyword is not among the known names.

    Parameters
    ----------
    given
        The keywords.
    known
        The names that the call takes.
    call
        Name of the function or class, for the message.
    what
        Plural noun for the known names, for the message.
    """
    for name in given:
        if name not in known:
            unexpected = f"{call}() got an unexpected keyword argument {in_one_line(repr(name), LEAST_VALUE)}"
            raise TypeError(f"{unexpected}; {what} are {list(known)}")


def in_one_line(message: str, longest: int = LONGEST_MESSAGE) -> str:
    """Return an error message, or a part of one, as one line with so many characters at most."""
    line = " ".join(message.split()) if "\n" in message else message
    return line if len(line) <= longest else f"{line[: longest - 4]} ..."


def _shown(value: object) -> str:
    try:
        return repr(value)
    except (ValueError, RecursionError):  # An integer of thousands of digits, or lists in lists without end.
        return f"{type(value).__name__} too large to print"


def normalise(instance: object, rule: Callable[[Any, str], Any], *names: str) -> None:
    """Replace fields of a frozen dataclass by their checked values, ``rule(value, name)``."""
    for name in names:
        object.__setattr__(instance, name, rule(getattr(instance, name), name))


def optional(rule: Callable[[Any, str], Any]) -> Callable[[Any, str], Any]:
    """Return a rule that accepts None besides the values of another rule."""
    return lambda value, field: None if value is None else rule(value, field)


@contextmanager
def fields_named(prefix: str = "", **names: str) -> Iterator[None]:
    """Translate field names in the errors of a part into those of the whole: ``fields_named("rate_")``.

    Parameters
    ----------
    prefix
        Prefix of the whole in front of the names of the part's fields.
    **names
        The whole's name of a field, if it is not the prefixed one.
    """
    try:
        yield
    except ValueError as error:
        field, _, rest = str(error).partition(" ")
        raise ValueError(f"{names.get(field, prefix + field)} {rest}") from None


def within(value: float, low: float, high: float, field: str) -> float:
    """Return the value as a float; raise a ValueError unless it lies between two bounds, neither included."""
    number = finite(value, field)
    require(low < number < high, field, f"must lie within ({low:g}, {high:g})", value)
    return number


def is_number(value: object) -> bool:
    """Return whether a value is one real number, of Python or NumPy; truth values and text are none."""
    if isinstance(value, np.ndarray):
        return value.ndim == 0 and value.dtype.kind in "iuf"
    return isinstance(value, numbers.Real) and not isinstance(value, bool)


def finite(value: float, field: str) -> float:
    """Return the value as a float; raise a ValueError unless it is one finite number."""
    require(is_number(value), field, "must be a number", value)
    number = _float(value)
    require(math.isfinite(number), field, "must be finite", value)
    return number


def _float(value: Any) -> float:
    try:
        return float(value)
    except OverflowError:  # An integer beyond all floats.
        return math.inf


def flag(value: bool, field: str) -> bool:
    """Return the value as a bool; raise a ValueError unless it is a truth value of Python or NumPy."""
    require(isinstance(value, (bool, np.bool_)), field, "must be True or False", value)
    return bool(value)


def positive(value: float, field: str) -> float:
    """Return the value as a float; raise a ValueError unless it is finite and above zero."""
    number = finite(value, field)
    require(number > 0.0, field, "must be positive", value)
    return number


def non_negative(value: float, field: str) -> float:
    """Return the value as a float; raise a ValueError unless it is finite and not below zero."""
    number = finite(value, field)
    require(number >= 0.0, field, "must not be negative", value)
    return number


def is_whole(value: object) -> bool:
    """Return whether a value is an integer of Python or NumPy; truth values are none."""
    return isinstance(value, (int, np.integer)) and not isinstance(value, bool)


def whole(value: int, least: int, field: str) -> int:
    """Return the value as an int; raise a ValueError unless it is a whole number that is not below the least one."""
    require(is_whole(value) and value >= least, field, f"must be a whole number, {least} or more", value)
    return int(value)


def vector(values: Sequence[float], length: int | None, field: str) -> Vector:
    """Return the values as a tuple of floats; raise a ValueError unless there are ``length`` finite numbers.

    With None any length is right.
    """
    array = as_array(values)
    if array is None or array.ndim != 1 or length not in (None, len(array)):
        rule = "must be a list of numbers" if length is None else f"must have {length} numbers"
        raise broken(field, rule, values)
    require(bool(np.isfinite(array).all()), field, "must be finite", values)
    return tuple(float(value) for value in array)


def each(values: float | Sequence[float], count: int, field: str, rule: Callable[[Any, str], float]) -> Vector:
    """Return ``count`` numbers that a rule has checked, from as many or from one for all."""
    listed: Any = (_float(values),) * count if is_number(values) else values
    return tuple(rule(value, f"{field}[{index}]") for index, value in enumerate(vector(listed, count, field)))


def matrix(values: object, rows: int, columns: int | None, field: str) -> FloatArray:
    """Return an array (rows, columns); raise a ValueError unless it is one of finite numbers. None: any width."""
    shape = f"{rows} x {columns if columns is not None else 'm'}"
    array = as_array(values)
    if array is None or array.ndim != 2 or array.shape != (rows, columns or array.shape[1]) or array.shape[1] == 0:
        raise broken(field, f"must be {shape}", values)
    require(bool(np.isfinite(array).all()), field, "must be finite", values)
    return array


def as_array(values: object) -> FloatArray | None:
    """Return numbers, or lists of them, as an array; None if there is anything else among them."""
    try:
        return np.asarray(_floats(values), dtype=np.float64)
    except (TypeError, ValueError, RecursionError):
        return None


def _floats(values: Any) -> Any:
    if isinstance(values, (tuple, list)):
        return [_floats(value) for value in values]
    if is_number(values):
        return _float(values)
    array = np.asarray(values)
    if array.dtype.kind not in "iuf":
        raise TypeError
    return array


def rows(array: FloatArray) -> Matrix:
    """Return a matrix as nested tuples of floats, the form of a field."""
    return tuple(tuple(float(value) for value in row) for row in array)


def unit_quaternion(values: Sequence[float], field: str) -> Vector:
    """Return the values as a tuple; raise a ValueError unless they are a unit quaternion (scalar first) to 1e-3."""
    quaternion = vector(values, 4, field)
    norm = math.sqrt(sum(value * value for value in quaternion))
    require(abs(norm - 1.0) < 1e-3, field, "must be a unit quaternion, scalar first", values)
    # Normalised values stay as they are, so that a round trip through JSON changes nothing.
    return quaternion if abs(norm - 1.0) < 1e-15 else tuple(value / norm for value in quaternion)


def unit_vector(values: Sequence[float], field: str) -> Vector:
    """Return the values as a tuple of norm 1; raise a ValueError unless they are a unit vector (3,) to 1e-3."""
    given = vector(values, 3, field)
    norm = math.hypot(*given)
    require(abs(norm - 1.0) < 1e-3, field, "must be a unit vector", values)
    # Normalised values stay as they are, so that a round trip through JSON changes nothing.
    return given if abs(norm - 1.0) < 1e-15 else tuple(value / norm for value in given)


def real_numbers(values: npt.ArrayLike, field: str) -> npt.NDArray[Any]:
    """Return the values as an array; raise a ValueError unless they are floats or integers, of any size."""
    array = np.asarray(values)
    require(array.dtype.kind in "fiu", field, "must consist of real numbers", array.dtype)
    return array


def interval(
    value: Interval, field: str, low: float = -math.inf, high: float = math.inf, above: float = -math.inf
) -> Interval:
    """Return a checked interval: a float, or a pair in rising order, within [low, high] and larger than ``above``."""
    if isinstance(value, (tuple, list)) or (isinstance(value, np.ndarray) and value.ndim == 1):
        require(len(value) == 2, field, "must be a number or a pair (low, high)", value)
        checked: Interval = (finite(value[0], field), finite(value[1], field))
    else:
        checked = finite(value, field)
    least, most = bounds(checked)
    require(least <= most, field, "must have low <= high", value)
    if high < math.inf:
        rule = f"must stay within [{low:g}, {'pi' if high == math.pi else f'{high:g}'}]"
    else:
        rule = "must not be negative" if low == 0.0 else f"must not be below {low:g}"
    require(low <= least and most <= high, field, rule, value)
    require(above < least, field, "must be positive" if above == 0.0 else f"must exceed {above:g}", value)
    return checked


def non_negative_interval(value: Interval, field: str) -> Interval:
    """Return a checked interval without negative values."""
    return interval(value, field, low=0.0)


def positive_interval(value: Interval, field: str) -> Interval:
    """Return a checked interval of positive values."""
    return interval(value, field, above=0.0)


def intervals(values: Sequence[Interval], field: str) -> Intervals:
    """Return three checked intervals, one per body axis."""
    valid = isinstance(values, (tuple, list, np.ndarray)) and len(values) == 3
    require(valid, field, "must have three entries", values)
    first, second, third = (interval(value, f"{field}[{axis}]") for axis, value in enumerate(values))
    return (first, second, third)


def bounds(value: Interval) -> tuple[float, float]:
    """Return (low, high) of an interval; both are the value itself when it is fixed."""
    return value if isinstance(value, tuple) else (value, value)


def largest(value: Interval) -> float:
    """Return the largest magnitude in an interval."""
    return max(abs(bound) for bound in bounds(value))


def draw(value: Interval, uniform: FloatArray) -> FloatArray:
    """Map uniform deviates in [0, 1) onto an interval, elementwise."""
    low, high = bounds(value)
    return low + (high - low) * uniform


def draw_axes(values: Intervals, uniform: FloatArray) -> FloatArray:
    """Map uniform deviates (N, 3) onto one interval per axis."""
    low, high = np.array([bounds(value) for value in values]).T
    return low + (high - low) * uniform


def uniform_directions(uniform: FloatArray) -> FloatArray:
    """Return unit vectors (N, 3), uniform on the sphere, from uniform deviates (N, 2)."""
    height = 2.0 * uniform[:, 0] - 1.0
    radius = np.sqrt(1.0 - height * height)
    longitude = 2.0 * np.pi * uniform[:, 1]
    return np.stack([radius * np.cos(longitude), radius * np.sin(longitude), height], axis=1)
