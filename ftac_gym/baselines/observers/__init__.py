"""Observers, one per file; those of faults by name.

All derive from :class:`~ftac_gym.baselines.observers.observer.FaultObserver`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ftac_gym.baselines.gains import Gains, SearchSpace, offered
from ftac_gym.baselines.memory import Memory
from ftac_gym.baselines.observers.fuzzy_observer import FuzzyObserver
from ftac_gym.baselines.observers.iterative_learning_observer import IterativeLearningObserver
from ftac_gym.baselines.observers.learning_observer import LearningObserver, ScaledLearningObserver
from ftac_gym.baselines.observers.multiple_model import MultipleModelObserver, MultipleModelTelemetryObserver
from ftac_gym.baselines.observers.observer import FaultObserver
from ftac_gym.baselines.observers.sliding_mode_observer import ScaledSlidingModeObserver, SlidingModeObserver
from ftac_gym.baselines.observers.tachometer import Tachometer
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import require, require_keywords

PRINTED_LEARNING: dict[str, Any] = {
    "rate_gain": (80.0, 50.0, 60.0),
    # The first three rows of the 4 x 3 matrices of Table 1.
    "first": ((8.0, 0.0, 0.0), (0.0, 15.0, 0.0), (0.0, 0.0, 12.0)),
    "second": ((20.0, 0.0, 0.0), (0.0, 3.0, 0.0), (0.0, 0.0, 8.0)),
}
"""M, H1 and H2 of Table 1 of Cao et al. 2022."""

_OBSERVERS: dict[str, tuple[type[FaultObserver], Mapping[str, Any]]] = {
    "asmo": (SlidingModeObserver, {}),
    "asmo_scaled": (ScaledSlidingModeObserver, {}),
    "asmo_printed": (SlidingModeObserver, {"effectiveness_gain": 0.5, "bias_gain": 1.0, "layer": 0.0}),
    "lo": (LearningObserver, {**PRINTED_LEARNING, "forgetting": 0.9, "switching": 2.5, "full_torque": None}),
    "lo_corrected": (LearningObserver, {}),
    "lo_scaled": (ScaledLearningObserver, {}),
    "fafeo": (FuzzyObserver, {}),
    "ilo_class": (IterativeLearningObserver, {}),
    "tachometer": (Tachometer, {}),
    "multiple_model": (MultipleModelObserver, {}),
    "multiple_model_telemetry": (MultipleModelTelemetryObserver, {}),
}

OF_TORQUES = ("fafeo", "ilo_class")
"""Observers of the torque on the body, without estimates of single wheels."""


def names() -> list[str]:
    """Return the names of the fault observers."""
    return sorted(_OBSERVERS)


def _found(name: str) -> tuple[type[FaultObserver], Mapping[str, Any]]:
    require(name in _OBSERVERS, "observer", f"must be one of {names()}", name)
    return _OBSERVERS[name]


def make(name: str, scenario: Scenario, memory: Memory, **gains: Any) -> FaultObserver:
    """Build a fault observer.

    Parameters
    ----------
    name
        One of :func:`names`.
    scenario
        The task.
    memory
        Store of its state.
    **gains
        Gains that differ from the defaults; see the class.

    Raises
    ------
    TypeError
        If a gain is unknown.
    ValueError
        If the name is unknown, a gain breaks a rule, or the observer does not fit the scenario's wheels.
    """
    observer, preset = _found(name)
    require_keywords(gains, [item.name for item in offered(observer.gains)], "observers.make", f"gains of {name}")
    return observer(scenario, memory, **{**preset, **gains})


def gains_of(name: str) -> Gains:
    """Return the default gains of the class of a fault observer."""
    return _found(name)[0].gains


def defaults(name: str) -> dict[str, Any]:
    """Return the default gains of a fault observer."""
    observer, preset = _found(name)
    return {**{item.name: getattr(observer.gains, item.name) for item in offered(observer.gains)}, **preset}


def information(name: str) -> str:
    """Return the tier of information that a fault observer needs."""
    return _found(name)[0].information


def search_space(name: str) -> SearchSpace:
    """Return the ranges that a tuner searches for a fault observer, by the name of the gain."""
    return _found(name)[0].search_space
