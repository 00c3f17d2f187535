"""Checks of fault tables, before the compiled plant takes their numbers as indices, divisors and branches."""

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from ftac_gym.faults.table import FAULT, FLIPS, LONGEST_DELAY, SENSOR_FAULT, CustomKind, DrawnFaults, FaultKind
from ftac_gym.utils.serialization import classes
from ftac_gym.utils.tables import FLAG, NOT_NEGATIVE, Rule, check_fields, check_form, check_values

_RULES: Mapping[str, Rule] = {
    **dict.fromkeys(("period", "on_time", "rise", "fall", "brake", "bias_exponent"), NOT_NEGATIVE),
    **dict.fromkeys(("friction_forward", "friction_backward"), NOT_NEGATIVE),
    **dict.fromkeys(("locked", "outage"), FLAG),
    "delay": (lambda values: (values >= 0) & (values <= LONGEST_DELAY), f"must be within [0, {LONGEST_DELAY}]"),
}
"""Rules of the fields of FAULT and SENSOR_FAULT for which it is not enough to be finite."""

_SWITCHES: Rule = (
    lambda values: values >= np.concatenate([np.zeros_like(values[..., :1]), values[..., :-1]], axis=-1),
    "must hold times that are not negative and do not decrease",
)


def check_records(table: npt.NDArray[np.void], name: str) -> None:
    """Raise a ValueError unless the times and magnitudes of FAULT or SENSOR_FAULT records can be evaluated."""
    healthy, onset = table["kind"] == FaultKind.NONE, table["onset"]
    times: Mapping[str, Rule] = {
        # The plant looks at the times alone: what has no kind must never act.
        "onset": (
            lambda values: np.where(healthy, values == np.inf, np.isfinite(values) & (values >= 0.0)),
            "must be finite and not negative for a fault, and infinite for none",
        ),
        "recovery": (lambda values: values >= onset, "must not come before the onset"),
    }
    check_fields(table, {**_RULES, **times}, name)


def check_faults(drawn: DrawnFaults, spacecraft: int, wheels: int, prefix: str = "") -> None:
    """Raise a ValueError unless fault tables are ones that the compiled plant can take.

    Parameters
    ----------
    drawn
        The tables.
    spacecraft, wheels
        Number of spacecraft, and of wheels of each.
    prefix
        Prefix of the names of tables in messages.
    """
    check_form(drawn.switches, np.float64, (spacecraft, None, FLIPS), f"{prefix}switches")
    check_values(drawn.switches, _SWITCHES, f"{prefix}switches")
    chains = drawn.switches.shape[1]
    named = (getattr(cls, "kind", None) for cls in classes().values())
    kinds = [0, *(int(kind) for kind in named if isinstance(kind, (FaultKind, CustomKind)))]
    rules: Mapping[str, Rule] = {
        "kind": (lambda values: np.isin(values, kinds), "must be the number of a registered fault kind, or 0"),
        "chain": (lambda values: (values >= -1) & (values < chains), f"must be one of the {chains} chains, or -1"),
    }
    for table, dtype, shape, name in (
        (drawn.wheels, FAULT, (spacecraft, wheels, None), "faults"),
        (drawn.sensors, SENSOR_FAULT, (spacecraft, None), "sensor_faults"),
    ):
        check_form(table, dtype, shape, f"{prefix}{name}")
        for field, rule in rules.items():
            check_values(table[field], rule, f"{prefix}{name}.{field}")
        check_records(table, f"{prefix}{name}")
