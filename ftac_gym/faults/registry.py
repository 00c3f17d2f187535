"""Which fault kinds there are, and how to add one from outside of the package."""

from __future__ import annotations

import dataclasses
from typing import Any, TypeVar

from ftac_gym.faults.fault import Fault, SensorFault, WheelFault
from ftac_gym.faults.table import FIRST_OWN_KIND, FaultKind, OwnKind
from ftac_gym.utils.parameters import require

F = TypeVar("F", bound=Fault)

_KINDS: dict[str, type[Fault]] = {}
"""All kinds by the name of their class. Besides Gymnasium's own registry of ids, which works the same way, it is the
only thing in this package that is known to all of a process and can change: numbers in tables and names in files mean
nothing without it. It only grows, when a module is imported."""


def register(kind: type[F]) -> type[F]:
    """Make a fault kind of your own known, as a decorator above ``@dataclass``.

    From then on scenarios may hold it and are rebuilt from JSON with it, and tables, figures and specifications
    (:func:`~ftac_gym.faults.specification.parse`) call it by its label. As with Gymnasium's ids, it is known in
    processes that import the module that defines it, and in no others.

    Parameters
    ----------
    kind
        A frozen dataclass that derives from :class:`WheelFault` or :class:`SensorFault`, with an
        :class:`~ftac_gym.faults.OwnKind` as its ``kind``, and says in ``_fill`` what it does to a wheel or to the
        sensors.

    Returns
    -------
    The class itself. A class that is defined again, by running its module or its notebook cell once more, takes the
    place of its former self.

    Raises
    ------
    ValueError
        If the class is none of this form, or its name, number or label is taken.
    """
    valid = isinstance(kind, type) and issubclass(kind, (WheelFault, SensorFault))
    require(valid, "kind", "must be a class that derives from WheelFault or SensorFault", kind)
    name, own = kind.__name__, kind.__dict__.get("kind")
    require(
        isinstance(own, OwnKind), f"kind of {name}", f"must be an OwnKind, as OwnKind({FIRST_OWN_KIND}, 'name')", own
    )
    frozen = "__dataclass_fields__" in kind.__dict__ and kind.__dataclass_params__.frozen  # type: ignore[attr-defined]
    require(frozen, name, "must be a frozen dataclass: register it above @dataclass(frozen=True, kw_only=True)", kind)
    required = [item.name for item in dataclasses.fields(kind) if _has_no_default(item)]
    require(not required, name, "must have a default for every field, as all kinds have", required)
    filled = any("_fill" in base.__dict__ for base in kind.__mro__ if base not in (WheelFault, SensorFault))
    require(filled, name, "must have a method _fill, which writes its magnitudes", kind)
    require(name not in _reserved(), "fault kind", "must have a name that no part of a scenario has", name)
    former = _KINDS.get(name)
    again = former is not None and (former.__module__, former.__qualname__) == (kind.__module__, kind.__qualname__)
    others = [other for other in _KINDS.values() if not (again and other is former)]
    for part, value in (("name", name), ("number", int(kind.kind)), ("label", kind.kind.label)):
        owner = next((other for other in others if _identity(other)[part] == value), None)
        rule = f"must be new; {owner.__module__ if owner else ''}.{owner.__name__ if owner else ''} has it"
        require(owner is None, f"{part} of fault kind {name}", rule, value)
    _KINDS[name] = kind
    return kind


def register_own(kinds: tuple[type[Fault], ...]) -> None:
    """Make the kinds of this package known: for the package itself."""
    _KINDS.update({kind.__name__: kind for kind in kinds})


def registered() -> dict[str, type[Fault]]:
    """Return all fault kinds by the names of their classes, those of the package first."""
    return dict(_KINDS)


def label_of(number: int) -> str:
    """Return what tables and figures call a kind, by its number in the fault tables.

    A number that no kind has, of episodes from a file whose kind has not been registered here, is said to be unknown.
    """
    if number == FaultKind.NONE:
        return FaultKind.NONE.label
    kind = next((kind.kind for kind in _KINDS.values() if kind.kind == number), None)
    return kind.label if kind is not None else f"unknown kind {number}"


def check_known(fault: Any, field: str) -> None:
    """Raise a ValueError unless an object is a fault of a kind that is known.

    Parameters
    ----------
    fault
        The object.
    field
        Where it was given, for the message.
    """
    concrete = isinstance(fault, Fault) and type(fault) not in (Fault, WheelFault, SensorFault)
    require(concrete, field, "must hold Fault objects of a concrete kind", fault)
    name = type(fault).__name__
    rule = "must hold faults of registered kinds: decorate the class with ftac_gym.faults.register"
    require(_KINDS.get(name) is type(fault), field, rule, fault)


def _has_no_default(field: dataclasses.Field[Any]) -> bool:
    return field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING


def _identity(kind: type[Fault]) -> dict[str, Any]:
    return {"name": kind.__name__, "number": int(kind.kind), "label": kind.kind.label}


def _reserved() -> frozenset[str]:
    # A scenario is made of faults: its module is there only once this one is.
    from ftac_gym.task.scenario import PARTS

    return frozenset(PARTS)
