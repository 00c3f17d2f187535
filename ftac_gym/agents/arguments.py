"""Checks of the arguments of an interface's wrappers, before there is an environment to wrap."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from dataclasses import fields
from typing import Any

from ftac_gym import baselines, wrappers
from ftac_gym.baselines import observers
from ftac_gym.baselines.gains import Gains, offered
from ftac_gym.utils.importing import is_path
from ftac_gym.utils.parameters import fields_named, is_number, require
from ftac_gym.utils.sizes import check_size
from ftac_gym.wrappers.fault_estimate import SOURCES
from ftac_gym.wrappers.history import check_length
from ftac_gym.wrappers.residual import AuthorityProfile


def check_arguments(wrapper: str, arguments: Mapping[str, Any], base: str | None) -> None:
    """Check the arguments of a wrapper: names, types and sizes. No module of a custom base is imported.

    Parameters
    ----------
    wrapper
        Its name in :mod:`ftac_gym.wrappers`.
    arguments
        The arguments.
    base
        The baseline on which it acts; None if it has none.

    Raises
    ------
    ValueError
        If there is no such argument, or a value is refused.
    """
    _check_types(arguments, wrapper)
    with fields_named(f"{wrapper}: "):
        for name, value in arguments.items():
            check_size(value, name)
        parameters = inspect.signature(getattr(wrappers, wrapper)).parameters.values()
        own = {item.name for item in parameters if item.kind is not item.VAR_KEYWORD} - {"env"}
        others = {name: value for name, value in arguments.items() if name not in own}
        if wrapper == "ObservationHistory":
            check_length(arguments.get("steps", 4), arguments.get("stride", 1))
        if wrapper == "ResidualPolicy":
            names = {item.name for item in fields(AuthorityProfile)}
            profile = {name: value for name, value in arguments.items() if name in names}
            AuthorityProfile(**{"authority": 0.5, **profile})
        if base is not None and is_path(base):
            return
        known, gains = set[str](), Gains()
        if base is not None:
            known, gains = {"gains", *baselines.defaults(base)}, baselines.baseline_class(base).gains
        elif wrapper == "FaultEstimateObservation":
            source = arguments.get("source") or "none"
            require(source in SOURCES, "source", f"must be None or one of {list(SOURCES)}", source)
            if source in observers.names():
                gains = observers.gains_of(source)
                known = {item.name for item in offered(gains)}
            elif source == "dob":
                known = {"bandwidth"}
        for name in others:
            require(name in known, "arguments", f"must be among {sorted(own | known)}", name)
        for item in offered(gains):
            if item.name in others and (rule := item.metadata.get("rule")):
                rule(others[item.name], item.name)
        if base is not None:
            _check_observer(base, others)


def _check_observer(base: str, gains: Mapping[str, Any]) -> None:
    """Check the names of an observer's gains among those of a base."""
    chosen = {**baselines.defaults(base), **gains}
    given, kind = gains.get("observer"), chosen.get("faults")
    if isinstance(given, Mapping) and kind in observers.names():
        known = [item.name for item in offered(observers.gains_of(kind))]
        for name in given:
            require(name in known, "observer", f"must have gains among {known}", name)


def _check_types(value: Any, field: str) -> None:
    """Check that a value is one of JSON, or a tuple of such."""
    if isinstance(value, Mapping):
        for name, entry in value.items():
            require(isinstance(name, str), field, "must have names of type str", name)
            _check_types(entry, f"{field}.{name}")
    elif isinstance(value, (tuple, list)):
        for entry in value:
            _check_types(entry, field)
    else:
        plain = value is None or isinstance(value, (bool, str)) or is_number(value)
        require(plain, field, "must be a number, text, true, false or null, or lists and objects of them", value)
