"""A scenario: everything that defines a task."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from ftac_gym.faults import FaultDistribution, FaultSchedule, registered
from ftac_gym.faults.table import FLIPS
from ftac_gym.spacecraft.appendages import FlexibleAppendages
from ftac_gym.spacecraft.friction import Friction
from ftac_gym.spacecraft.spacecraft import Spacecraft
from ftac_gym.spacecraft.wheel_array import WheelArray
from ftac_gym.task.disturbances import Disturbance, Harmonic
from ftac_gym.task.episodes import Episodes
from ftac_gym.task.inertia import InertiaUncertainty
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.low_orbit import LowOrbitTorque
from ftac_gym.task.objective import RewardWeights, SuccessCriterion
from ftac_gym.task.prescribed_bound import PrescribedBound
from ftac_gym.task.references import MRPSinusoid, RateProfile, Reference, SetPoints
from ftac_gym.task.sensors import SensorErrors
from ftac_gym.task.vibration import LARGEST_PHASE, AppendageUncertainty, exact_modes, fastest_pole
from ftac_gym.utils.parameters import Matrix, matrix, positive, require
from ftac_gym.utils.serialization import LATER_PART, from_plain, to_plain


def _multiple(value: float, unit: float, name: str, unit_name: str) -> int:
    count = round(value / unit)
    whole = count >= 1 and abs(count * unit - value) <= 1e-9 * max(1.0, value)
    require(whole, name, f"must be a multiple of {unit_name} = {unit!r} s", value)
    return count


@dataclass(frozen=True, kw_only=True)
class Scenario:
    """Immutable description of a task; ``None`` switches a part off.

    Parameters
    ----------
    name
        Name, for reports.
    spacecraft
        Nominal spacecraft.
    initial_state
        Distribution of the start.
    reference
        Attitude command.
    faults
        Fault distribution or schedule.
    disturbance
        External torque.
    sensors
        Sensor errors.
    inertia_uncertainty
        How the true inertia differs from the nominal one.
    control_period
        Time between two commands [s]; a multiple of ``physics_step``.
    physics_step
        Step of the plant's integrator [s].
    duration
        Length of an episode [s]; a multiple of ``control_period``.
    tumble_rate
        The environment ends an episode when the body turns faster than this [rad/s]; None never ends it.
    reward
        Reward weights.
    success
        Success criterion.
    prescribed_bound
        Bounds that the attitude error shall keep to, by which every policy is measured; None for none.
    appendage_uncertainty
        How the true vibration modes differ from the nominal ones; None if they do not.
    misalignment
        3 x m, in body axes: by how much the true wheel axes differ from the nominal ones; None for not at all. The
        feasibility label does not look at it.

    Raises
    ------
    ValueError
        If a value breaks a rule; the message names the field and the rule.
    """

    name: str
    spacecraft: Spacecraft
    initial_state: InitialState = field(default_factory=InitialState)
    reference: Reference = field(default_factory=SetPoints)
    faults: FaultDistribution | FaultSchedule | None = None
    disturbance: Disturbance | LowOrbitTorque | None = None
    sensors: SensorErrors | None = None
    inertia_uncertainty: InertiaUncertainty | None = None
    control_period: float = 0.1
    physics_step: float = 0.02
    duration: float = 120.0
    tumble_rate: float | None = None
    reward: RewardWeights = field(default_factory=RewardWeights)
    success: SuccessCriterion = field(default_factory=SuccessCriterion)
    prescribed_bound: PrescribedBound | None = field(default=None, metadata=LATER_PART)
    appendage_uncertainty: AppendageUncertainty | None = field(default=None, metadata=LATER_PART)
    misalignment: Matrix | None = field(default=None, metadata=LATER_PART)

    def __post_init__(self) -> None:
        """Check the fields, each alone and together."""
        for item in dataclasses.fields(self):
            value = getattr(self, item.name)
            if item.name in _FIELD_CLASSES:
                classes = _FIELD_CLASSES[item.name]
                names = " or ".join("None" if entry is type(None) else entry.__name__ for entry in classes)
                require(isinstance(value, classes), item.name, f"must be a {names}", value)
        for name in ("control_period", "physics_step", "duration"):
            object.__setattr__(self, name, positive(getattr(self, name), name))
        _multiple(self.control_period, self.physics_step, "control_period", "physics_step")
        _multiple(self.duration, self.control_period, "duration", "control_period")
        if self.tumble_rate is not None:
            object.__setattr__(self, "tumble_rate", positive(self.tumble_rate, "tumble_rate"))
        if self.misalignment is not None:
            error = matrix(self.misalignment, 3, self.spacecraft.wheels.count, "misalignment")
            rank = int(np.linalg.matrix_rank(self.spacecraft.wheels.axis_matrix + error, tol=1e-3))
            nominal = int(np.linalg.matrix_rank(self.spacecraft.wheels.axis_matrix))
            require(rank == nominal, "misalignment", f"must leave axes that span {nominal} dimensions", rank)
            object.__setattr__(self, "misalignment", tuple(tuple(float(value) for value in row) for row in error))
        if (appendages := self.spacecraft.appendages) is not None:
            fastest = float(fastest_pole(exact_modes(appendages, 1), self.spacecraft.inertia_matrix[None])[0])
            rule = (
                f"must be at most {LARGEST_PHASE / fastest:.3g} s: the fastest pole of the modes is {fastest:.4g} 1/s"
            )
            require(self.physics_step * fastest <= LARGEST_PHASE, "physics_step", rule, self.physics_step)
        if (uncertainty := self.appendage_uncertainty) is not None:
            require(appendages is not None, "appendage_uncertainty", "needs a spacecraft with appendages", uncertainty)
        if self.faults is not None:
            self.faults.check(self.spacecraft.wheels)
            for fault in self.faults.faults:
                if fault.mean_acting is not None and fault.mean_resting is not None:
                    # So many flips are drawn that a chain that flips half as often on average does not run out.
                    shortest = 4.0 * self.duration / FLIPS
                    mean = fault.mean_acting + fault.mean_resting
                    rule = f"with mean_resting must add up to at least {shortest:.3g} s for this duration"
                    require(mean >= shortest, "mean_acting", rule, fault.mean_acting)

    @property
    def substeps(self) -> int:
        """Physics steps per control period."""
        return _multiple(self.control_period, self.physics_step, "control_period", "physics_step")

    @property
    def horizon(self) -> int:
        """Control periods per episode."""
        return _multiple(self.duration, self.control_period, "duration", "control_period")

    def replace(self, **changes: Any) -> Scenario:
        """Return a copy with some fields changed.

        A part may also be given as the plain dict that :meth:`to_dict` would make of it.

        Raises
        ------
        ValueError
            If a name is no field of a scenario, or a value breaks a rule.
        """
        known = [item.name for item in dataclasses.fields(self)]
        for name in changes:
            require(name in known, "scenario change", f"must be one of {known}", name)
        rebuilt = {name: _rebuilt(value) if isinstance(value, Mapping) else value for name, value in changes.items()}
        return dataclasses.replace(self, **rebuilt)

    def to_dict(self) -> dict[str, Any]:
        """Return plain JSON data."""
        plain: dict[str, Any] = to_plain(self)
        return plain

    @cached_property
    def _json(self) -> str:
        return json.dumps(self.to_dict(), allow_nan=False)

    def to_json(self) -> str:
        """Return the scenario as JSON text."""
        return self._json

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Scenario:
        """Rebuild what :meth:`to_dict` made; raises ValueError for anything else."""
        scenario = _rebuilt(data)
        require(isinstance(scenario, Scenario), "scenario", "must describe a Scenario", type(scenario).__name__)
        return scenario  # type: ignore[no-any-return]

    @classmethod
    def from_json(cls, text: str) -> Scenario:
        """Rebuild what :meth:`to_json` made; raises ValueError for anything else."""
        return cls.from_dict(json.loads(text))

    def draw(self, seed: int, count: int) -> Episodes:
        """Draw episodes 0 to ``count - 1`` of a seed.

        Raises
        ------
        ValueError
            If the seed is negative or the count is not positive.
        """
        require(isinstance(seed, (int, np.integer)) and seed >= 0, "seed", "must be a non-negative integer", seed)
        require(isinstance(count, (int, np.integer)) and count > 0, "count", "must be a positive integer", count)
        from ftac_gym.task.drawing import draw_episodes

        return draw_episodes(self, [int(seed)] * int(count), np.arange(count))


def success_steps(scenario: Scenario) -> int:
    """Return for how many control periods before the end a craft must be on target."""
    return math.ceil(scenario.success.hold / scenario.control_period - 1e-9)


PARTS: Mapping[str, type] = {
    entry.__name__: entry
    for entry in (
        Scenario, Spacecraft, WheelArray, InitialState, SetPoints, MRPSinusoid, RateProfile, FaultDistribution,
        FaultSchedule, Friction, Disturbance, LowOrbitTorque, Harmonic, SensorErrors,
        InertiaUncertainty, RewardWeights, SuccessCriterion, PrescribedBound,
        FlexibleAppendages, AppendageUncertainty,
    )
}  # fmt: skip
"""What a scenario is made of besides faults, by the name in its JSON."""


def _rebuilt(data: Any) -> Any:
    """Return what plain data stands for; kinds of fault from outside of the package if they are registered by now."""
    return from_plain(
        data, {**PARTS, **registered()}, "; a fault kind of your own is known once its module is imported"
    )


_FIELD_CLASSES: dict[str, tuple[type, ...]] = {
    "name": (str,),
    "spacecraft": (Spacecraft,),
    "initial_state": (InitialState,),
    "reference": (SetPoints, MRPSinusoid, RateProfile),
    "faults": (FaultDistribution, FaultSchedule, type(None)),
    "disturbance": (Disturbance, LowOrbitTorque, type(None)),
    "sensors": (SensorErrors, type(None)),
    "inertia_uncertainty": (InertiaUncertainty, type(None)),
    "reward": (RewardWeights,),
    "success": (SuccessCriterion,),
    "prescribed_bound": (PrescribedBound, type(None)),
    "appendage_uncertainty": (AppendageUncertainty, type(None)),
}
