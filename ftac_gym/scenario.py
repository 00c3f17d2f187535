"""A scenario: everything that defines a task, and the drawing of its episodes."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from ftac_gym import feasibility
from ftac_gym.attitude import quaternion_error, rotation_vector_from_quaternion
from ftac_gym.disturbances import DISTURBANCE, HARMONIC, Disturbance, Harmonic
from ftac_gym.episodes import Episodes, RecordArray
from ftac_gym.faults import KINDS, FaultDistribution, FaultSchedule
from ftac_gym.faults.table import FLIPS, healthy
from ftac_gym.friction import Friction
from ftac_gym.inertia import InertiaUncertainty, exact_inertia
from ftac_gym.initial_state import InitialState
from ftac_gym.low_orbit import LowOrbitTorque
from ftac_gym.objective import RewardWeights, SuccessCriterion
from ftac_gym.parameters import FloatArray, positive, require
from ftac_gym.prescribed_bound import PrescribedBound
from ftac_gym.references import MRPSinusoid, RateProfile, Reference, SetPoints
from ftac_gym.sensors import SENSOR, SensorErrors
from ftac_gym.serialization import LATER_PART, from_plain, to_plain
from ftac_gym.spacecraft import Spacecraft
from ftac_gym.wheels import WheelArray


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
        rebuilt = {
            name: from_plain(value, _CLASSES) if isinstance(value, Mapping) else value
            for name, value in changes.items()
        }
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
        scenario = from_plain(data, _CLASSES)
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
        return draw_episodes(self, [int(seed)] * int(count), np.arange(count))


def success_steps(scenario: Scenario) -> int:
    """Return for how many control periods before the end a craft must be on target."""
    return math.ceil(scenario.success.hold / scenario.control_period - 1e-9)


def draw_episodes(scenario: Scenario, seeds: Sequence[int], index: np.ndarray) -> Episodes:
    """Draw one episode for each pair of a seed and an episode number.

    Parameters
    ----------
    scenario
        What to draw from.
    seeds
        N seeds.
    index
        (N,) episode number within each seed.
    """
    from ftac_gym.randomness import keys_from_seeds  # Numba takes half a second to import; draw it in when needed.

    unique, inverse = np.unique(np.array(seeds, dtype=object), return_inverse=True)
    return draw_from_keys(scenario, keys_from_seeds(unique)[inverse], np.asarray(index, dtype=np.int64))


def draw_from_keys(scenario: Scenario, keys: np.ndarray, index: np.ndarray) -> Episodes:
    """Draw one episode for each pair of a cipher key (N, 2) and an episode number (N,)."""
    from ftac_gym.randomness import Purpose, uniforms

    count, craft, wheels = len(index), scenario.spacecraft, scenario.spacecraft.wheels

    def deviates(purpose: Purpose, numbers: int) -> FloatArray:
        return uniforms(keys, index, purpose, numbers)

    start = scenario.initial_state
    initial = start.draw(deviates(Purpose.INITIAL_STATE, start.uniform_count(wheels.count)), wheels.momentum_limits)
    if (uncertainty := scenario.inertia_uncertainty) is None:
        inertia: RecordArray = exact_inertia(craft.inertia_matrix, count)
    else:
        inertia = uncertainty.draw(craft.inertia_matrix, deviates(Purpose.INERTIA, uncertainty.uniform_count))
    if (source := scenario.faults) is None:
        faults = healthy(count, wheels.count)
    else:
        uniform = deviates(Purpose.FAULTS, source.uniform_count(wheels.count))
        faults = source.draw(uniform, deviates(Purpose.SWITCHING, source.switching_count), wheels.torque_limits)
    if (torque := scenario.disturbance) is None:
        disturbance, harmonics = np.zeros(count, DISTURBANCE), np.zeros((count, 0), HARMONIC)
    else:
        uniform = deviates(Purpose.DISTURBANCE, torque.uniform_count)
        disturbance, harmonics = torque.draw(uniform, inertia["constant"])
    if (errors := scenario.sensors) is None:
        sensors: RecordArray = np.zeros(count, SENSOR)
    else:
        sensors = errors.draw(deviates(Purpose.SENSORS, errors.uniform_count))
    command = scenario.reference
    reference, set_points = command.draw(deviates(Purpose.REFERENCE, command.uniform_count))

    demand = _demand(scenario, initial, inertia, disturbance, harmonics, set_points)
    return Episodes(
        scenario_json=scenario.to_json(),
        key=keys,
        index=index,
        initial=initial,
        inertia=inertia,
        faults=faults.wheels,
        sensor_faults=faults.sensors,
        switches=faults.switches,
        disturbance=disturbance,
        harmonics=harmonics,
        sensors=sensors,
        reference=reference,
        set_points=set_points,
        feasible=feasibility.label(faults.wheels, wheels, demand),
    )


def _demand(
    scenario: Scenario,
    initial: RecordArray,
    inertia: RecordArray,
    disturbance: RecordArray,
    harmonics: RecordArray,
    set_points: RecordArray,
) -> feasibility.Demand:
    """Return what drawn episodes ask of the wheels: of several set points the last turn, of a moving reference none."""
    largest = np.abs(disturbance["constant"]) + np.hypot(harmonics["sine"], harmonics["cosine"]).sum(axis=1)
    fastest = np.sum(initial["rate"] ** 2, axis=1) + disturbance["rate_offset"]
    largest = largest * np.where(disturbance["rate_scaled"] > 0.5, fastest, 1.0)[:, None]
    wheels = scenario.spacecraft.wheels
    body = np.einsum("nij,nj->ni", inertia["constant"], initial["rate"])
    total = body + initial["wheel_momentum"] @ wheels.axis_matrix.T if wheels.momentum_coupling else body
    points = set_points["attitude"]
    before = points[:, -2] if points.shape[1] > 1 else initial["attitude"]
    turn = rotation_vector_from_quaternion(quaternion_error(before, points[:, -1]))
    angle = np.zeros(len(turn)) if scenario.reference.moving else np.linalg.norm(turn, axis=1)
    # Where there is nothing to turn, any axis will do.
    axis = np.where(angle[:, None] > 1e-9, turn / np.maximum(angle, 1e-9)[:, None], (1.0, 0.0, 0.0))
    hold = min(scenario.success.hold, scenario.duration)
    return feasibility.Demand(
        disturbance=largest,
        momentum=np.linalg.norm(total, axis=1) + np.linalg.norm(largest, axis=1) * scenario.duration,
        effort=np.einsum("nij,nj->ni", inertia["constant"], axis),
        angle=angle,
        rate=np.linalg.norm(initial["rate"], axis=1),
        start=float(set_points["time"][0, -1]),
        deadline=scenario.duration - hold,
        duration=scenario.duration,
    )


_CLASSES: dict[str, type] = {
    entry.__name__: entry
    for entry in (
        Scenario, Spacecraft, WheelArray, InitialState, SetPoints, MRPSinusoid, RateProfile, FaultDistribution,
        FaultSchedule, *KINDS, Friction, Disturbance, LowOrbitTorque, Harmonic, SensorErrors,
        InertiaUncertainty, RewardWeights, SuccessCriterion, PrescribedBound,
    )
}  # fmt: skip

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
}
