"""Registered fault kinds, and the registration of custom ones."""

from typing import Any, TypeVar

from ftac_gym.faults import effectiveness_faults, sensor_faults, wheel_faults
from ftac_gym.faults.fault import Fault, SensorFault, WheelFault
from ftac_gym.faults.table import FIRST_CUSTOM_KIND, CustomKind, FaultKind
from ftac_gym.utils.parameters import require
from ftac_gym.utils.serialization import classes, required_fields, same_definition, serializable

F = TypeVar("F", bound=Fault)

KINDS: tuple[type[Fault], ...] = tuple(
    entry
    for module in (effectiveness_faults, wheel_faults, sensor_faults)
    for entry in vars(module).values()
    if isinstance(entry, type) and issubclass(entry, Fault) and entry.__module__ == module.__name__
)
"""All fault kinds of this package, those of wheels first; :func:`registered` has custom ones too."""


def register(kind: type[F]) -> type[F]:
    """Register a custom fault kind, as a decorator above ``@dataclass``.

    Scenarios may then hold it and are rebuilt from JSON with it. Tables, figures and specifications
    (:func:`~ftac_gym.faults.specification.parse`) use its label. As with Gymnasium's ids, the registration holds in
    processes that import the module of the class, and in no others.

    Parameters
    ----------
    kind
        A frozen dataclass that derives from :class:`~ftac_gym.faults.WheelFault` or
        :class:`~ftac_gym.faults.SensorFault`. It has an :class:`~ftac_gym.faults.CustomKind` as its ``kind``, and a
        method ``_fill`` that writes its magnitudes.

    Returns
    -------
    The class itself. A class that is defined again, by running its module or its notebook cell once more, replaces its
    predecessor.

    Raises
    ------
    ValueError
        If the class is none of this form, or its name, number or label is taken.
    """
    valid = isinstance(kind, type) and issubclass(kind, (WheelFault, SensorFault))
    require(valid, "kind", "must be a class that derives from WheelFault or SensorFault", kind)
    name, own = kind.__name__, kind.__dict__.get("kind")
    require(
        isinstance(own, CustomKind),
        f"kind of {name}",
        f"must be a CustomKind, as CustomKind({FIRST_CUSTOM_KIND}, 'name')",
        own,
    )
    frozen = "__dataclass_fields__" in kind.__dict__ and kind.__dataclass_params__.frozen  # type: ignore[attr-defined]
    require(frozen, name, "must be a frozen dataclass: register it above @dataclass(frozen=True, kw_only=True)", kind)
    required = required_fields(kind)
    require(not required, name, "must have a default for every field, as all kinds have", required)
    filled = any("_fill" in base.__dict__ for base in kind.__mro__ if base not in (WheelFault, SensorFault))
    require(filled, name, "must have a method _fill, which writes its magnitudes", kind)
    others = [other for other in classes().values() if not same_definition(other, kind)]
    _require_new("name", name, name, {other.__name__: other for other in others})
    kinds = [other for other in others if issubclass(other, Fault)]
    _require_new("number", name, int(kind.kind), {int(other.kind): other for other in kinds})
    _require_new("label", name, kind.kind.label, {other.kind.label: other for other in kinds})
    return serializable(kind)


def _require_new(part: str, name: str, value: Any, taken: dict[Any, type]) -> None:
    owner = taken.get(value)
    place = f"{owner.__module__}.{owner.__name__}" if owner is not None else ""
    require(owner is None, f"{part} of fault kind {name}", f"must be new; {place} has it", value)


def registered() -> dict[str, type[Fault]]:
    """Return all fault kinds by the names of their classes, those of the package first."""
    custom = [cls for cls in classes().values() if issubclass(cls, Fault) and cls not in KINDS]
    return {kind.__name__: kind for kind in (*KINDS, *custom)}


def label_of(number: int) -> str:
    """Return the label of a kind, for tables and figures, from its number in the fault tables.

    The label of a kind that is not registered in this process says "unknown".
    """
    if number == FaultKind.NONE:
        return FaultKind.NONE.label
    labels = {int(cls.kind): cls.kind.label for cls in registered().values()}
    return labels.get(number, f"unknown kind {number}")


def check_registered(fault: Any, field: str) -> None:
    """Raise a ValueError unless an object is a fault of a registered kind.

    Parameters
    ----------
    fault
        The object.
    field
        Name of the field that holds it, for the message.
    """
    concrete = isinstance(fault, Fault) and type(fault) not in (Fault, WheelFault, SensorFault)
    require(concrete, field, "must hold Fault objects of a concrete kind", fault)
    rule = "must hold faults of registered kinds: decorate the class with ftac_gym.faults.register"
    require(classes().get(type(fault).__name__) is type(fault), field, rule, fault)
