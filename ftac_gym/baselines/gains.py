"""Gains as data: one frozen dataclass per baseline, from whose fields all else about its gains is derived.

A baseline declares a dataclass of gains and takes an instance of it, which holds the defaults, as its class attribute::

    @dataclass(frozen=True)
    class RateDamperGains(Gains):
        \"\"\"Gains of :class:`RateDamper`.\"\"\"

        rate_gain: float = parameter(2.0, "Damping", "1/s", positive, search=Range(0.5, 8.0), schedule=(1.0, 6.0))
        floor: float = parameter(0.1, "Smallest torque", "N m", non_negative)


    class RateDamper(Baseline):
        \"\"\"Damping of the body rate.\"\"\"

        gains = RateDamperGains()

        def act(self, measurement):
            torque = -self.scheduled.rate_gain * measurement.rate @ self._inertia
            ...

``RateDamper(scenario, 4, rate_gain=3.0)`` checks the values by the rules of the fields and stores them as
``self.gains``; ``self.scheduled`` has the same fields, with arrays (N, 1) for the gains that are scheduled. The class
gets from the fields its signature, the section Parameters of its docstring, ``search_space``, ``shares`` and
``schedulable`` (:mod:`~ftac_gym.baselines.tunable`). What remains to be written:

- the equations, in the docstring of the class, which ends before the section Parameters;
- rules between several gains, in ``__post_init__`` of the dataclass after ``super().__post_init__()``;
- rules between gains and scenario, in ``__init__`` of the class after ``super().__init__``.

A dataclass extends that of its base class by inheritance. There :func:`changed` gives an inherited gain another
default, search range or text at its old place, and :func:`fixed` takes it out of the signature. The order of the fields
is that of the actions of :func:`~ftac_gym.wrappers.gain_scheduling.GainScheduling`.
"""

from __future__ import annotations

from collections.abc import Mapping
from copy import copy
from dataclasses import Field, dataclass, fields
from dataclasses import field as dataclass_field
from typing import Any, TypeVar

import numpy as np

from ftac_gym.baselines.rules import Check, words_of
from ftac_gym.baselines.units import Unit
from ftac_gym.utils.parameters import FloatArray, require
from ftac_gym.utils.sizes import check_size


@dataclass(frozen=True)
class Range:
    """An interval for one gain.

    Parameters
    ----------
    low, high
        Its ends, low below high.
    log
        Whether the gain is searched on a logarithmic scale; needs a positive low end.

    Raises
    ------
    ValueError
        If the ends are out of order or a logarithmic scale reaches zero.
    """

    low: float
    high: float
    log: bool = False

    def __post_init__(self) -> None:
        """Check the fields."""
        require(self.low < self.high, "low", f"must be below high = {self.high!r}", self.low)
        require(not self.log or self.low > 0.0, "low", "must be positive on a logarithmic scale", self.low)

    def __str__(self) -> str:
        """Return the interval in words."""
        return f"from {self.low:g} to {self.high:g}{', logarithmic' if self.log else ''}"


G = TypeVar("G", bound="Gains")

SearchSpace = Mapping[str, Range]
"""Ranges by the name of the gain; ``"part.gain"`` is a gain of a part, such as the observer."""


@dataclass(frozen=True)
class Share:
    """A gain as a share of another gain, which it must be below: searched and scheduled instead of the gain itself.

    Parameters
    ----------
    name
        Name of the share in search space and schedule.
    of
        The gain that limits it.
    """

    name: str
    of: str


def parameter(
    default: Any,
    meaning: str = "",
    unit: str | Unit | Mapping[str, Unit] = "",
    rule: Check | None = None,
    search: Range | SearchSpace | None = None,
    schedule: tuple[float, float] | None = None,
    share: Share | None = None,
) -> Any:
    """Return the dataclass field of a gain or of another parameter.

    Parameters
    ----------
    default
        Its default.
    meaning
        Its meaning: sentences without the last full stop.
    unit
        Its unit, which is shown after the first sentence: text for a physical gain, or a unit of the scenario; by the
        name of the entry, for a gain that is a mapping.
    rule
        Check of its value, see :mod:`~ftac_gym.baselines.rules`; None takes every value.
    search
        Range for a tuner; of the share, if there is one; by the name of the gain, for the gains of a part.
    schedule
        Usual bounds within which the gain, or its share, may change from one control period to the next; None for a
        gain that may not.
    share
        The share of another gain that is searched and scheduled instead.
    """
    metadata = {
        "meaning": meaning, "unit": unit, "rule": rule, "search": search, "schedule": schedule, "share": share
    }  # fmt: skip
    return dataclass_field(default=default, metadata=metadata)


def fixed(value: Any) -> Any:
    """Return the dataclass field of an inherited gain that a subclass does not offer."""
    return dataclass_field(default=value, init=False)


@dataclass(frozen=True)
class Gains:
    """Gains of a baseline or of an observer.

    Raises
    ------
    ValueError
        If a value breaks the rule of its field, or is too large for a controller to compute with.
    """

    def __post_init__(self) -> None:
        """Check every field by its rule, store the value that the rule returns, and compare shares with limits."""
        for item in fields(self):
            if rule := item.metadata.get("rule"):
                object.__setattr__(self, item.name, rule(getattr(self, item.name), item.name))
            check_size(getattr(self, item.name), item.name)
        for name, of in shares_of(self).values():
            limit, value = getattr(self, of), getattr(self, name)
            require(value < limit, name, f"must be below {of} = {limit!r}", value)


def changed(base: type[Gains], name: str, default: Any = ..., **metadata: Any) -> Any:
    """Return an inherited field with another default or other arguments of :func:`parameter`."""
    item = next(item for item in fields(base) if item.name == name)
    return parameter(item.default if default is ... else default, **{**item.metadata, **metadata})


def offered(gains: Gains) -> tuple[Field[Any], ...]:
    """Return the fields that a user can set."""
    return tuple(item for item in fields(gains) if item.init)


def shares_of(gains: Gains) -> dict[str, tuple[str, str]]:
    """Return the shares: name of the share to the gain and the gain that limits it."""
    found = ((item.name, item.metadata.get("share")) for item in offered(gains))
    return {share.name: (name, share.of) for name, share in found if share is not None}


def search_space_of(gains: Gains) -> dict[str, Range]:
    """Return the ranges that a tuner searches, by the name of the gain, its share, or ``"part.gain"``."""
    space: dict[str, Range] = {}
    for item in offered(gains):
        search = item.metadata.get("search")
        if isinstance(search, Mapping):
            space.update({f"{item.name}.{name}": part for name, part in search.items()})
        elif search is not None:
            space[_searched(item)] = search
    return space


def schedule_of(gains: Gains) -> dict[str, tuple[float, float]]:
    """Return the usual bounds of the gains that may be scheduled, by the name of the gain or of its share."""
    return {_searched(item): bounds for item in offered(gains) if (bounds := item.metadata.get("schedule"))}


def with_schedule(gains: G, values: Mapping[str, FloatArray]) -> G:
    """Return gains with arrays (N, 1) in place of some numbers, unchecked; shares follow their limits.

    Parameters
    ----------
    gains
        The gains without a schedule.
    values
        Arrays (N, 1) by the name of the gain or of its share.
    """
    result, shares = copy(gains), shares_of(gains)
    for name, (gain, limit) in shares.items():
        own, own_limit = getattr(gains, gain), getattr(gains, limit)
        if name in values or limit in values:
            share, now = values.get(name, own / own_limit), values.get(limit, own_limit)
            object.__setattr__(result, gain, scheduled_share(own, own_limit, share, now))
    for name in values.keys() - shares.keys():
        object.__setattr__(result, name, values[name])
    return result


def _searched(item: Field[Any]) -> str:
    share = item.metadata.get("share")
    return item.name if share is None else str(share.name)


def description(item: Field[Any]) -> str:
    """Return the meaning of a gain with its unit and its rule, in sentences."""
    data = item.metadata
    first, stop, rest = data.get("meaning", "").partition(". ")
    symbol = data.get("unit", "")
    if isinstance(symbol, Mapping):
        symbol = ", ".join(f"{name} in {part}" for name, part in symbol.items())
    unit = f" [{symbol}]" if symbol else ""
    text = f"{first}{unit}{stop}{rest}."
    rule = data.get("rule")
    words = words_of(rule) if rule is not None else ""
    return text if words in ("", "flag", "mapping", "finite") else f"{text} {words[0].upper()}{words[1:]}."


def nested(point: Mapping[str, float]) -> dict[str, Any]:
    """Return gains from a point of a search space: ``{"part.gain": 1}`` becomes ``{"part": {"gain": 1}}``."""
    gains: dict[str, Any] = {}
    for name, value in point.items():
        part, dot, gain = name.partition(".")
        if dot:
            gains.setdefault(part, {})[gain] = value
        else:
            gains[name] = value
    return gains


def flat(gains: Mapping[str, Any]) -> dict[str, float]:
    """Return the numbers among gains under their names in a search space: the inverse of :func:`nested`."""
    point: dict[str, float] = {}
    for name, value in gains.items():
        if isinstance(value, Mapping):
            point.update({f"{name}.{gain}": number for gain, number in flat(value).items()})
        elif isinstance(value, (int, float)) and not isinstance(value, bool):
            point[name] = float(value)
    return point


def scheduled_share(own: float, limit: float, share: float | FloatArray, now: float | FloatArray) -> float | FloatArray:
    """Return a gain that is a share of another, which limits it.

    Parameters
    ----------
    own, limit
        The gain and its limit without a schedule.
    share
        The scheduled share; ``own / limit`` gives back the gain to the bit where the limit is unchanged.
    now
        The scheduled limit.
    """
    return np.where(share == own / limit, own, share * limit) * (now / limit)


def merged(*layers: Mapping[str, Any]) -> dict[str, Any]:
    """Return gains in which later layers replace earlier ones, part by part."""
    gains: dict[str, Any] = {}
    for layer in layers:
        for name, value in layer.items():
            known = gains.get(name)
            if isinstance(known, Mapping) and isinstance(value, Mapping):
                value = {**known, **value}
            gains[name] = value
    return gains
