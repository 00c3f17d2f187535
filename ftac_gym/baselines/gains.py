"""Where the gains of a law may lie: what a tuner searches."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ftac_gym.utils.parameters import FloatArray, require


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


SearchSpace = Mapping[str, Range]
"""Ranges by the name of the gain; ``"part.gain"`` is a gain of a part, such as the observer."""


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
    """Return the numbers among gains under their names in a search space, what :func:`nested` undoes."""
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
        The gain and its limit as the law has them.
    share
        The share wanted; ``own / limit`` gives back the gain to the bit where the limit is the law's.
    now
        The limit wanted.
    """
    return np.where(share == own / limit, own, share * limit) * (now / limit)


def merged(*layers: Mapping[str, Any]) -> dict[str, Any]:
    """Return gains in which later layers go before earlier ones, part by part."""
    gains: dict[str, Any] = {}
    for layer in layers:
        for name, value in layer.items():
            known = gains.get(name)
            if isinstance(known, Mapping) and isinstance(value, Mapping):
                value = {**known, **value}
            gains[name] = value
    return gains
