"""Base of everything with gains: signature, documentation, search space and schedule from the fields of its gains."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from inspect import Parameter, Signature
from textwrap import indent
from typing import Any, ClassVar

from ftac_gym.baselines.gains import (
    Gains,
    SearchSpace,
    description,
    flat,
    nested,
    offered,
    schedule_of,
    search_space_of,
    shares_of,
)
from ftac_gym.utils.parameters import require_keywords

_ARGUMENTS = {
    "scenario": "The task.",
    "num_spacecraft": "Number of spacecraft N.",
    "memory": "Store of the state.",
}
"""Parameters other than gains, in words."""

_RAISES = "Raises\n------\nValueError\n    If a gain breaks a rule."


class Tunable:
    """A class whose keyword arguments are the fields of a :class:`~ftac_gym.baselines.gains.Gains`.

    A subclass with gains of its own sets ``gains``. One with a plain ``__init__`` instead may set ``search_space`` and
    ``schedulable`` itself.

    Parameters
    ----------
    **gains
        Gains that differ from the defaults.

    Raises
    ------
    TypeError
        If a gain is unknown.
    ValueError
        If a gain breaks a rule.
    """

    gains: Gains = Gains()
    """The gains; of the class, the defaults."""
    search_space: ClassVar[SearchSpace] = {}
    """Ranges that a tuner searches, by the name of the gain, of its share, or ``"part.gain"``."""
    shares: ClassVar[Mapping[str, tuple[str, str]]] = {}
    """Gains that are searched as a share of another, which limits them: share: (gain, the gain that limits it)."""
    schedulable: ClassVar[Mapping[str, tuple[float, float]]] = {}
    """Gains that may change from one control period to the next, each with its usual bounds."""
    __signature__: ClassVar[Signature]

    def __init__(self, **gains: Any) -> None:
        known = [item.name for item in offered(self.gains)]
        name = type(self).__name__
        require_keywords(gains, known, name, f"gains of {name}")
        self.gains = type(self.gains)(**gains)

    def __init_subclass__(cls) -> None:
        """Derive what the fields of the gains say."""
        super().__init_subclass__()
        if "gains" in cls.__dict__:
            derived = {"search_space": search_space_of, "shares": shares_of, "schedulable": schedule_of}
            for name, derive in derived.items():
                if name not in cls.__dict__:
                    setattr(cls, name, derive(cls.gains))
        cls.__signature__ = _signature(cls)
        if cls.__dict__.get("__doc__"):
            cls.__doc__ = _document(cls)

    @classmethod
    def gains_at(cls, point: Mapping[str, float]) -> dict[str, Any]:
        """Return the gains at a point of the search space."""
        gains = nested(point)
        for share, (gain, limit) in cls.shares.items():
            gains[gain] = gains[limit] * gains.pop(share)
        return gains

    @classmethod
    def point_of(cls, gains: Mapping[str, Any]) -> dict[str, float]:
        """Return the point of the search space that has these gains: the inverse of :meth:`gains_at`.

        Gains that are no numbers, or are not given, are left out.
        """
        point = flat(gains)
        for share, (gain, limit) in cls.shares.items():
            point[share] = point.pop(gain) / point[limit]
        return point


def _signature(cls: type[Tunable]) -> Signature:
    """Return all parameters of a class: its own, those of its base classes and the fields of its gains."""
    found: dict[str, Parameter] = {}
    for base in cls.__mro__:
        if base is Tunable:
            keywords = (
                Parameter(item.name, Parameter.KEYWORD_ONLY, default=item.default, annotation=item.type)
                for item in offered(cls.gains)
            )
            found = {**{item.name: item for item in keywords}, **found}
            break
        if "__init__" not in base.__dict__:
            continue
        parameters = inspect.signature(base.__init__).parameters.values()  # type: ignore[misc]
        found = {**{item.name: item for item in parameters}, **found}
        if not any(item.kind is Parameter.VAR_KEYWORD for item in parameters):
            break
    variable = (Parameter.VAR_KEYWORD, Parameter.VAR_POSITIONAL)
    listed = [item for item in found.values() if item.kind not in variable and item.name != "self"]
    # Python sorts no parameters; a keyword that a subclass adds stands behind all others.
    return Signature(sorted(listed, key=lambda item: (item.kind, item.default is not Parameter.empty)))


def _document(cls: type[Tunable]) -> str:
    """Return the docstring of a class with the section Parameters, before the section Raises."""
    text = inspect.cleandoc(cls.__doc__ or "")
    words = {**_ARGUMENTS, **{item.name: _entry(cls, item) for item in offered(cls.gains)}}
    names = list(cls.__signature__.parameters)
    if "\nParameters\n---" in text or not all(name in words for name in names):
        return text
    entries = "\n".join(f"{name}\n{indent(words[name], '    ')}" for name in names)
    head, raises, rest = text.partition("\nRaises\n------\n")
    return f"{head.rstrip()}\n\nParameters\n----------\n{entries}\n\n" + (f"{raises[1:]}{rest}" if raises else _RAISES)


def _entry(cls: type[Tunable], item: Any) -> str:
    """Return what the docstring says of a gain: meaning, unit, rule, search and schedule."""
    data = item.metadata
    share = data.get("share")
    name = "" if share is None else f" as ``{share.name}``, its share of ``{share.of}``,"
    parts = [description(item)]
    search, schedule = data.get("search"), data.get("schedule")
    if search is not None and not isinstance(search, Mapping):
        parts.append(f"Searched{name} {search}.")
    if schedule is not None:
        parts.append(f"Scheduled{name} from {schedule[0]:g} to {schedule[1]:g}.")
    return " ".join(parts)
