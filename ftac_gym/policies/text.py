"""Policies of other libraries and of a user's modules as text, for the command line."""

from __future__ import annotations

import inspect
import json
import re
from collections.abc import Callable
from typing import Any

from ftac_gym.policies.external import ExternalPolicy
from ftac_gym.policies.onnx import load_onnx
from ftac_gym.policies.sb3 import load_sb3
from ftac_gym.policies.zoo import load_zoo
from ftac_gym.utils.importing import called, imported, is_path
from ftac_gym.utils.parameters import require

LOADERS: dict[str, Callable[..., Any]] = {"sb3": load_sb3, "onnx": load_onnx, "zoo": load_zoo}
"""Prefixes of a path, ``"sb3:model.zip"`` for example. Those of files with pickles must be written: they run code."""

_OF_OBJECTS = ("observation", "hold", "batched", "wrappers")
"""Arguments of :class:`~ftac_gym.policies.external.ExternalPolicy` that a text can have."""

_CALL = "()"


def is_external(text: str) -> bool:
    """Tell whether a text names a policy of another library or an object of a user's module."""
    head, _ = _parted(text)
    return head.partition(":")[0] in LOADERS or is_path(head.removesuffix(_CALL))


def external(text: str) -> Any:
    """Return what a text names.

    Parameters
    ----------
    text
        One of

        - ``"sb3:PATH"``, ``"onnx:PATH"``, ``"zoo:FOLDER"``: see the functions of :data:`LOADERS`;
        - ``"module:name"``: a function of the observation, or any other policy, in a module that is imported;
        - ``"module:name()"``: what this function returns, a policy.

        Arguments may follow, as words ``NAME=VALUE`` with values in JSON or plain text:
        ``"sb3:model.zip hold=5 observation=telemetry"``.

    Returns
    -------
    A policy in any form that :func:`~ftac_gym.policies.resolve` takes, without text.

    Raises
    ------
    ValueError
        If there is no such file or object, or an argument is unknown or refused.
    MissingExtra
        If a library is not installed; the message has the command that installs it.
    """
    head, arguments = _parted(text)
    prefix, _, rest = head.partition(":")
    if prefix in LOADERS:
        known = list(inspect.signature(LOADERS[prefix]).parameters)[1:]
        _check_names(arguments, known, head)
        return LOADERS[prefix](rest, **arguments)
    found = imported(head.removesuffix(_CALL), "policy")
    require(found is not None, "policy", "must be defined in its module", head)
    if head.endswith(_CALL):
        require(callable(found), "policy", "must be a function or a class where () follows", head)
        found = called(found, head, "policy")
    require(not isinstance(found, str), "policy", "must not be text", head)
    if not arguments:
        return found
    _check_names(arguments, _OF_OBJECTS, head)
    return ExternalPolicy(found, **arguments)


def _check_names(arguments: dict[str, Any], known: Any, head: str) -> None:
    for name in arguments:
        require(name in known, f"arguments of {head}", f"must be among {list(known)}", name)


def _parted(text: str) -> tuple[str, dict[str, Any]]:
    """Return a text without its arguments, and the arguments."""
    # Spaces may be part of a path, or of a value.
    head, *words = re.split(r"\s+(?=\w+=)", text.strip())
    pairs = (word.partition("=") for word in words)
    return head, {name: _value(value) for name, _, value in pairs}


def _value(text: str) -> Any:
    try:
        return json.loads(text)
    except ValueError:
        return text
