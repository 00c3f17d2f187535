"""Scenarios: the definitions of tasks."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, get_args, get_type_hints

import numpy as np
import numpy.typing as npt

from ftac_gym.faults import Fault, FaultDistribution, FaultSchedule
from ftac_gym.faults.table import FLIPS
from ftac_gym.spacecraft.spacecraft import Spacecraft
from ftac_gym.task.changes import changed, changed_faults
from ftac_gym.task.disturbances import Disturbance
from ftac_gym.task.episodes import Episodes
from ftac_gym.task.external_torque import ExternalTorque, checked
from ftac_gym.task.inertia import InertiaUncertainty
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.integrability import check_motion, check_numbers
from ftac_gym.task.low_orbit import LowOrbitTorque
from ftac_gym.task.objective import CostBounds, RewardWeights, SuccessCriterion
from ftac_gym.task.pointing import check_pointing
from ftac_gym.task.prescribed_bound import PrescribedBound
from ftac_gym.task.references import MRPSinusoid, RateProfile, SetPoints
from ftac_gym.task.sampled_reference import SampledReference
from ftac_gym.task.sensor_suite import SensorSuite
from ftac_gym.task.sensors import SENSOR, SensorErrors
from ftac_gym.task.vibration import AppendageUncertainty, check_modes
from ftac_gym.utils.parameters import (
    FloatArray,
    Interval,
    Matrix,
    bounds,
    draw,
    fields_named,
    interval,
    is_whole,
    matrix,
    non_negative,
    normalise,
    optional,
    positive,
    require,
    require_keywords,
    rows,
)
from ftac_gym.utils.serialization import LATER_PART, from_plain, parse_json, serializable, to_plain

LONGEST_EXTRA = 20
"""Limit of the extra loop delay [control periods]: the commands of that time are held in memory."""

LARGEST_ERROR = 2.0
"""Limit of the error of a wheel axis, the distance of opposite unit vectors."""


@serializable
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
        External torque; of several disturbances in a tuple it is the sum.
    sensors
        Errors and timing of the sensors: by their data sheets, or white noise and a walking bias as papers have them.
    inertia_uncertainty
        Difference of the true inertia from the nominal one.
    control_period
        Time between two commands [s]; a multiple of ``physics_step``.
    physics_step
        Step of the plant's integrator [s].
    duration
        Length of an episode [s]; a multiple of ``control_period``.
    tumble_rate
        Body rate above which the environment ends an episode [rad/s]; None never ends it.
    reward
        Reward weights.
    success
        Success criterion.
    prescribed_bound
        Bounds on the attitude error, by which every policy is measured; None for none.
    appendage_uncertainty
        Difference of the true vibration modes from the nominal ones; None for none.
    misalignment
        3 x m, in body axes: difference of the true wheel axes from the nominal ones, columns of length 2 at most;
        None for none.
    loop_delay
        Time from a measurement until the command that it leads to takes effect [s]; a multiple of ``physics_step``. It
        is known to on-board software; late wheels come on top.
    extra_delay
        Loop delay beyond it, in whole control periods from 0 to 20, drawn for each episode and told to no policy; a
        number or a pair (low, high), both included.
    cost_bounds
        Bounds on pointing error and wheel commands, outside of which time counts as ``info["cost"]``.

    Raises
    ------
    ValueError
        If a value breaks a rule; the message names the field and the rule.
    """

    name: str
    spacecraft: Spacecraft
    initial_state: InitialState = field(default_factory=InitialState)
    reference: SetPoints | MRPSinusoid | RateProfile | SampledReference = field(default_factory=SetPoints)
    faults: FaultDistribution | FaultSchedule | None = None
    disturbance: Disturbance | LowOrbitTorque | tuple[Disturbance | LowOrbitTorque, ...] | None = None
    sensors: SensorErrors | SensorSuite | None = None
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
    cost_bounds: CostBounds = field(default=CostBounds(), metadata=LATER_PART)
    loop_delay: float = field(default=0.0, metadata=LATER_PART)
    extra_delay: Interval = field(default=0.0, metadata=LATER_PART)

    def __post_init__(self) -> None:
        """Check the fields, each alone and together."""
        for name, hint in _FIELD_CLASSES.items():
            value = getattr(self, name)
            names = " or ".join("None" if part is type(None) else part.__name__ for part in get_args(hint) or (hint,))
            require(isinstance(value, hint), name, f"must be a {names}", value)
        object.__setattr__(self, "disturbance", checked(self.disturbance))
        normalise(self, positive, "control_period", "physics_step", "duration")
        normalise(self, optional(positive), "tumble_rate")
        normalise(self, non_negative, "loop_delay")
        normalise(self, lambda value, name: interval(value, name, 0.0, LONGEST_EXTRA), "extra_delay")
        check_numbers(self)
        whole = all(bound.is_integer() for bound in bounds(self.extra_delay))
        require(whole, "extra_delay", "must be whole numbers of control periods", self.extra_delay)
        for name, unit_name, count in (
            ("control_period", "physics_step", self.substeps),
            ("duration", "control_period", self.horizon),
        ):
            value, unit = getattr(self, name), getattr(self, unit_name)
            whole = count >= 1 and abs(count * unit - value) <= 1e-9 * max(1.0, value)
            require(whole, name, f"must be a multiple of {unit_name} = {unit!r} s", value)
        whole = abs(self.delay_steps * self.physics_step - self.loop_delay) <= 1e-9 * max(1.0, self.loop_delay)
        rule = f"must be a multiple of physics_step = {self.physics_step!r} s"
        require(whole, "loop_delay", rule, self.loop_delay)
        require(self.loop_delay < self.duration, "loop_delay", "must be below the duration", self.loop_delay)
        with fields_named("initial_state."):
            self.initial_state.check(self.spacecraft.wheels.momentum_limits, self.spacecraft.modes)
        if isinstance(self.reference, SampledReference):
            last = self.reference.times[-1]
            rule = f"must not exceed the time of the last sample of the reference, {last:g} s"
            require(self.duration <= last + 1e-9, "duration", rule, self.duration)
        if self.misalignment is not None:
            error = matrix(self.misalignment, 3, self.spacecraft.wheels.count, "misalignment")
            worst = float(np.linalg.norm(error, axis=0).max())
            rule = f"must have columns of at most {LARGEST_ERROR:g}, the distance of opposite unit vectors"
            require(worst <= LARGEST_ERROR, "misalignment", rule, worst)
            rank = int(np.linalg.matrix_rank(self.spacecraft.wheels.axis_matrix + error, tol=1e-3))
            nominal = int(np.linalg.matrix_rank(self.spacecraft.wheels.axis_matrix))
            require(rank == nominal, "misalignment", f"must leave axes that span {nominal} dimensions", rank)
            object.__setattr__(self, "misalignment", rows(error))
        if (uncertainty := self.appendage_uncertainty) is not None:
            bends = self.spacecraft.appendages is not None
            require(bends, "appendage_uncertainty", "needs a spacecraft with appendages", uncertainty)
        if self.faults is not None:
            with fields_named("faults.", friction="spacecraft.wheels.friction"):
                self.faults.check(self.spacecraft.wheels)
            # On average a chain then uses at most half of the flips that are drawn.
            shortest = 4.0 * self.duration / FLIPS
            rule = f"with mean_resting must add up to at least {shortest:.3g} s for this duration"
            for fault in self.known_faults:
                if fault.mean_acting is not None and fault.mean_resting is not None:
                    enough = fault.mean_acting + fault.mean_resting >= shortest
                    require(enough, "faults.mean_acting", rule, fault.mean_acting)
        check_pointing(self)
        check_motion(self)

    @property
    def known_faults(self) -> tuple[Fault, ...]:
        """Faults that can occur, listed or as kinds of a distribution; those with a wheel of their own come last."""
        return () if self.faults is None else tuple(self.faults.faults)

    @property
    def external_torque(self) -> ExternalTorque:
        """Sum of the disturbances."""
        return ExternalTorque.of(self.disturbance)

    @property
    def substeps(self) -> int:
        """Physics steps per control period."""
        return round(self.control_period / self.physics_step)

    @property
    def delay_steps(self) -> int:
        """Physics steps of the nominal loop delay."""
        return round(self.loop_delay / self.physics_step)

    @property
    def horizon(self) -> int:
        """Control periods per episode."""
        return round(self.duration / self.control_period)

    def replace(self, **changes: Any) -> Scenario:
        """Return a copy with some fields changed.

        Parts have short forms:

        - a dict of some of its fields changes the part that is there, or the default part where there is none, as in
          ``reward={"on_target": 1.0}`` or ``spacecraft={"wheels": {"torque_limit": 0.1}}``;
        - a dict with ``"type"``, in the form of :meth:`to_dict`, is a new part;
        - several disturbances may be a list of objects and of such dicts;
        - faults may be one fault or a list of faults, or text as in ``faults="outage:0@5, bias:2@20"``, see
          :func:`~ftac_gym.faults.specification.parse_all`; text that starts with ``+``, as in ``faults="+outage:0"``,
          adds faults to those that are there.

        Raises
        ------
        TypeError
            If a name is no field of a scenario.
        ValueError
            If a value breaks a rule.
        """
        check_fields(changes, "Scenario.replace")
        hints = get_type_hints(Scenario)
        parts = {
            name: changed_faults(self.faults, value, hints[name])
            if name == "faults"
            else changed(getattr(self, name), value, name, hints[name])
            for name, value in changes.items()
        }
        return dataclasses.replace(self, **parts)

    def to_dict(self) -> dict[str, Any]:
        """Return plain JSON data."""
        return to_plain(self)

    @cached_property
    def _json(self) -> str:
        return json.dumps(self.to_dict(), allow_nan=False)

    def to_json(self) -> str:
        """Return the scenario as JSON text."""
        return self._json

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Scenario:
        """Rebuild a scenario from :meth:`to_dict`; raises ValueError for other data."""
        require(isinstance(data, Mapping), "scenario", "must describe a Scenario", data)
        scenario: Scenario = from_plain(data, "scenario", Scenario)
        return scenario

    @classmethod
    def from_json(cls, text: str) -> Scenario:
        """Rebuild a scenario from :meth:`to_json`; raises ValueError for other text."""
        return cls.from_dict(parse_json(text, "scenario"))

    def draw(self, seed: int, count: int) -> Episodes:
        """Draw episodes 0 to ``count - 1`` of a seed.

        Raises
        ------
        ValueError
            If the seed is negative or the count is not positive.
        """
        require(is_whole(seed) and seed >= 0, "seed", "must be a non-negative integer", seed)
        require(is_whole(count) and count > 0, "count", "must be a positive integer", count)
        return self.draw_episodes([int(seed)] * int(count), np.arange(count))

    def draw_episodes(self, seeds: Sequence[int], index: npt.NDArray[np.int64]) -> Episodes:
        """Draw one episode for each pair of a seed (N,) and an episode number within that seed (N,)."""
        from ftac_gym.utils.randomness import keys_from_seeds  # Compiled: scenarios alone do not need Numba.

        unique, inverse = np.unique(np.array(seeds, dtype=object), return_inverse=True)
        return self.draw_from_keys(keys_from_seeds(unique)[inverse], np.asarray(index, dtype=np.int64))

    def draw_from_keys(self, keys: npt.NDArray[np.uint32], index: npt.NDArray[np.int64]) -> Episodes:
        """Draw one episode for each pair of a cipher key (N, 2) and an episode number (N,)."""
        from ftac_gym.utils.randomness import Stream, uniforms

        spacecraft, wheels = self.spacecraft, self.spacecraft.wheels

        def deviates(stream: Stream, count: int) -> FloatArray:
            return uniforms(keys, index, stream, count)

        # The defaults of these parts draw nominal values, no faults and no torque.
        uncertainty = self.inertia_uncertainty or InertiaUncertainty()
        vibration = self.appendage_uncertainty or AppendageUncertainty()
        source, torque = self.faults or FaultSchedule(()), self.external_torque
        uniform = deviates(Stream.INITIAL_STATE, self.initial_state.uniform_count(wheels.count, spacecraft.modes))
        initial = self.initial_state.draw(uniform, wheels.momentum_limits, spacecraft.modes)
        inertia = uncertainty.draw(spacecraft.inertia_matrix, deviates(Stream.INERTIA, uncertainty.uniform_count))
        uniform = deviates(Stream.MODES, vibration.uniform_count(spacecraft.modes))
        modes = vibration.draw(spacecraft.appendages, uniform)
        check_modes(modes, inertia, self.physics_step)
        uniform = deviates(Stream.FAULTS, source.uniform_count(wheels.count))
        faults = source.draw(uniform, deviates(Stream.SWITCHING, source.switching_count), wheels.torque_limits)
        uniform = deviates(Stream.DISTURBANCE, torque.uniform_count)
        disturbance, harmonics = torque.draw(uniform, inertia["constant"])
        if self.sensors is None:
            sensors = np.zeros(len(index), SENSOR)
        else:
            sensors = self.sensors.draw(deviates(Stream.SENSORS, self.sensors.uniform_count))
        uniform = deviates(Stream.REFERENCE, self.reference.uniform_count)
        reference, set_points = self.reference.draw(uniform)
        episodes = Episodes(
            scenario_json=self.to_json(),
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
            feasible=np.zeros(len(index), dtype=np.bool_),
            modes=modes,
            extra_delay=self._draw_extra_delay(deviates(Stream.DELAY, 1)[:, 0]),
        )
        return dataclasses.replace(episodes, feasible=self.feasibility(episodes))

    def _draw_extra_delay(self, uniform: FloatArray) -> npt.NDArray[np.int64]:
        """Return the extra delay (N,) [control periods] at uniform deviates (N,)."""
        low, high = bounds(self.extra_delay)
        # The minimum is for a deviate just below one, which rounding can take beyond the interval.
        return np.minimum(np.floor(draw((low, high + 1.0), uniform)), high).astype(np.int64)

    def feasibility(self, episodes: Episodes) -> npt.NDArray[np.bool_]:
        """Label episodes as feasible or not in this scenario, (N,); see :mod:`ftac_gym.task.feasibility`."""
        from ftac_gym.task.feasibility import feasibility_labels  # Compiled: scenarios alone do not need Numba.

        return feasibility_labels(self, episodes)


def check_fields(changes: Iterable[str], call: str) -> None:
    """Raise a TypeError, in the name of a call, if a keyword is no field of a scenario."""
    require_keywords(changes, [item.name for item in dataclasses.fields(Scenario)], call, "fields of a scenario")


def success_steps(scenario: Scenario) -> int:
    """Return the number of control periods in the window of success before the end; a part of one counts as one."""
    return min(math.ceil(scenario.success.hold / scenario.control_period - 1e-9), scenario.horizon)


_FIELD_CLASSES = {
    name: hint
    for name, hint in get_type_hints(Scenario).items()
    if all(isinstance(part, type) and part is not float for part in get_args(hint) or (hint,))
}
"""Class, or union of classes, of every field that holds an object rather than numbers."""
