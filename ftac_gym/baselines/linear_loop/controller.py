"""Linear model of a baseline near rest on target, from its answers to small changes of measurement and memory."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ftac_gym.attitude import quaternion_from_rotation_vector
from ftac_gym.faults import FaultEffect
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray

if TYPE_CHECKING:
    from ftac_gym.baselines.baseline import Baseline

Arrays = dict[str, npt.NDArray[Any]]
"""Arrays of a memory by name."""

WIDTH = 64
"""Spacecraft of one batch of changes."""
SETTLING, LONGEST_SETTLING = 3, 100
"""Control periods at rest before the changes: the least, and the most while the memory still moves."""
EXCITATION = 6
"""Control periods of random measurements, which show the numbers of the memory that the motion moves."""
SMALL, LARGE = 1e-5, 1e-4
"""Sizes of the changes over the limits of success."""
AGREEMENT = 0.05
"""Largest difference of the models of two sizes, over the sum of both."""
MOVED = 1e-7
"""Least movement of a number of the memory, over its own size: below, it is rounding."""


class NoLinearLoopError(ValueError):
    """Error of a baseline that has no linear model near rest on target; the text is the reason."""


@dataclass(frozen=True, eq=False)
class LinearController:
    """Model x' = A x + B y, u = C x + D y of one control period, in units of the usual changes of x.

    Attributes
    ----------
    transition, entry
        A (n, n) and B (n, p) of the memory x.
    output, direct
        C (m, n) and D (m, p) of the wheel commands u [N m].
    channels
        Columns of the measurement y (p) by name: attitude error [rad], rate [rad/s], and fields of
        :class:`~ftac_gym.task.measurement.Measurement`.
    """

    transition: FloatArray
    entry: FloatArray
    output: FloatArray
    direct: FloatArray
    channels: dict[str, slice]


def linearise(baseline: Baseline) -> LinearController:
    """Return the linear model of a baseline around rest on target, where its memory has settled.

    The baseline is a black box: central differences of a call, for every number of its measurement and for every
    number of its memory that measurements move. Counters, flags and times are no such numbers. A new sample of the star
    tracker is there in every control period. A filter whose covariance still converges is taken as it then is.

    Parameters
    ----------
    baseline
        The baseline, which is left as it is.

    Raises
    ------
    NoLinearLoopError
        If the commands are not finite, or the models of small and of larger changes differ.
    """
    with np.errstate(all="ignore"):  # Commands that are not finite are an error below.
        probe = _Probe(baseline)
        models = [probe.model(size) for size in (SMALL, LARGE)]
    small, large = (np.block([[model.transition, model.entry], [model.output, model.direct]]) for model in models)
    if not (np.isfinite(small).all() and np.isfinite(large).all()):
        raise NoLinearLoopError("its commands near rest are not finite")
    scale = np.abs(small).max(axis=1, keepdims=True) + np.abs(large).max(axis=1, keepdims=True)
    difference = np.abs(large - small).max(axis=1, keepdims=True) / np.where(scale > 0.0, scale, 1.0)
    if (worst := float(difference.max(initial=0.0))) > AGREEMENT:
        factor = (1.0 + worst) / max(1.0 - worst, 1e-9)
        sizes = f"from {SMALL:g} to {LARGE:g} of the limits of success"
        raise NoLinearLoopError(
            f"its gains near rest depend on the size of the error, by a factor of {factor:.2g} {sizes}"
        )
    return models[0]


class _Probe:
    """Baseline at rest on target, with the arrays of its memory as vectors."""

    def __init__(self, baseline: Baseline) -> None:
        self.baseline = baseline.again(WIDTH)
        self.scenario = baseline.scenario
        self.tick = self.scenario.horizon
        sizes = channel_sizes(self.scenario)
        ends = np.cumsum([len(size) for size in sizes.values()])
        self.channels = {name: slice(end - len(sizes[name]), end) for name, end in zip(sizes, ends, strict=True)}
        self.sizes = np.concatenate(list(sizes.values()))
        still = np.zeros((WIDTH, len(self.sizes)))
        before: Arrays = {}
        for call in range(LONGEST_SETTLING):
            self.act(still)
            now = self.baseline.memory.copy()
            if call >= SETTLING and settled(before, now):
                break
            before = now
        self.start, self.start_tick = self.memory(), self.tick
        self.rest = self.state()[0]
        self.moved, self.units = self.excite()

    def memory(self) -> Arrays:
        """Return a copy of the memory."""
        return {name: array.copy() for name, array in self.baseline.memory.copy().items()}

    def state(self) -> FloatArray:
        """Return the numbers of the memory, (N, n); what is no real number is left out."""
        return np.concatenate([part.reshape(WIDTH, -1) for part in real_parts(self.baseline.memory.copy())], axis=1)

    def act(self, change: FloatArray) -> FloatArray:
        """Return the commands for changes (N, p) of the measurement at rest; time goes on by a control period."""
        parts = {name: change[:, columns] for name, columns in self.channels.items()}
        self.tick += 1
        return self.baseline.act(measured(self.baseline, self.tick - 1, parts))

    def restart(self) -> None:
        """Return to rest."""
        self.tick = self.start_tick
        for name, array in self.start.items():
            self.baseline.memory[name] = array.copy()

    def excite(self) -> tuple[npt.NDArray[np.intp], FloatArray]:
        """Return the numbers of the memory that random measurements move, and their movement over that of these.

        Numbers that move with the square of the measurements have no part in a linear model.
        """
        small, large = (self.movement(size) for size in (SMALL, LARGE))
        linear = large < 0.5 * (LARGE / SMALL) ** 2 * small
        moved = np.flatnonzero(linear & (small > MOVED * SMALL * np.abs(self.rest)))
        return moved, small[moved] / SMALL

    def movement(self, size: float) -> FloatArray:
        """Return the largest spread (n,) of the numbers of the memory under random measurements of a size."""
        random = np.random.default_rng(0)
        self.restart()
        movement = np.zeros_like(self.rest)
        for _ in range(EXCITATION):
            self.act(size * self.sizes * random.uniform(-1.0, 1.0, (WIDTH, len(self.sizes))))
            movement = np.maximum(movement, self.state().std(axis=0))
        return movement

    def model(self, size: float) -> LinearController:
        """Return the model for changes of a size, over the usual ones."""
        moved, units = self.moved, np.concatenate([self.units, self.sizes])
        steps = size * units
        count, states = len(steps), len(moved)
        after, commands = [], []
        for rows in np.array_split(np.arange(2 * count), -(-2 * count // WIDTH)):
            change = np.zeros((WIDTH, count))
            change[np.arange(len(rows)), rows % count] = np.where(rows < count, 1.0, -1.0)
            change *= steps
            self.restart()
            memory = self.memory()
            write(memory, moved, change[:, :states])
            for name, array in memory.items():
                self.baseline.memory[name] = array
            commands.append(self.act(change[:, states:])[: len(rows)])
            after.append(self.state()[: len(rows), moved])
        half = [0.5 * (values[:count] - values[count:]) for values in map(np.concatenate, (after, commands))]
        # Of the memory in units of its movement, of the measurement in its own.
        scaled = np.where(np.arange(count) < states, size, steps)
        state, output = (part.T / scaled for part in half)
        state /= self.units[:, None]
        return LinearController(
            state[:, :states], state[:, states:], output[:, :states], output[:, states:], self.channels
        )


def measured(baseline: Baseline, tick: int, parts: Mapping[str, FloatArray]) -> Measurement:
    """Return the measurement of healthy spacecraft without sensor errors, whose reference rests.

    Parameters
    ----------
    baseline
        The baseline that it is for: an oracle gets the truth.
    tick
        Control periods since the start.
    parts
        Arrays of N rows by the name of the field; of the attitude its error, a rotation vector (N, 3) [rad].
    """
    parts, scenario = dict(parts), baseline.scenario
    attitude = quaternion_from_rotation_vector(parts.pop("attitude"))
    count, wheels = len(attitude), scenario.spacecraft.wheels.count
    truth = None
    if baseline.information == "oracle":
        none, working = np.zeros((count, 3)), np.zeros(count, dtype=np.bool_)
        bias, delay = np.zeros((count, wheels)), np.zeros((count, wheels), dtype=np.int64)
        truth = FaultEffect(np.ones((count, wheels)), bias, delay, none, none.copy(), working)
    return Measurement(
        time=np.full(count, tick * scenario.control_period),
        attitude=attitude,
        star_tracker_valid=np.ones(count, dtype=np.bool_),
        reference_attitude=np.tile([1.0, 0.0, 0.0, 0.0], (count, 1)),
        reference_rate=np.zeros((count, 3)),
        reference_acceleration=np.zeros((count, 3)),
        truth=truth,
        **parts,
    )


def settled(before: Arrays, now: Arrays) -> bool:
    """Tell whether the arrays of a memory, except the time, are those of a control period before, up to rounding."""
    for name, array in now.items():
        pairs = zip(real_parts({name: before[name]}), real_parts({name: array}), strict=True)
        others = array.dtype.kind != "f" and array.dtype.names is None and (array != before[name]).any()
        if name != "called_at" and (others or any((abs(b - a) > MOVED * abs(b)).any() for a, b in pairs)):
            return False
    return True


def real_parts(arrays: Arrays) -> list[npt.NDArray[np.float64]]:
    """Return views of the real numbers in the arrays of a memory, among them those in fields of structured arrays."""
    parts = []
    for array in arrays.values():
        for part in [array] if array.dtype.names is None else [array[name] for name in array.dtype.names]:
            if part.dtype.kind == "f":
                parts.append(part)
    return parts


def write(arrays: Arrays, entries: npt.NDArray[np.intp], change: FloatArray) -> None:
    """Add changes (N, n) to some of the real numbers of a memory, in place."""
    first = 0
    for part in real_parts(arrays):
        size = part[0].size
        inside = np.flatnonzero((entries >= first) & (entries < first + size))
        if len(inside):
            columns = np.unravel_index(entries[inside] - first, part.shape[1:]) if part.ndim > 1 else ()
            rows = (np.arange(len(part))[:, None], *columns) if part.ndim > 1 else (np.arange(len(part))[:, None],)
            part[rows] += change[:, inside]
        first += size


def channel_sizes(scenario: Scenario) -> dict[str, FloatArray]:
    """Return the usual size of every number of a measurement, by the name of its field.

    Angle and rate are the limits of success; commands make that rate in a control period.
    """
    spacecraft, success = scenario.spacecraft, scenario.success
    wheels, appendages = spacecraft.wheels.count, spacecraft.appendages
    torque = float(np.linalg.eigvalsh(spacecraft.inertia_matrix)[0]) * success.rate / scenario.control_period
    sizes = {
        "attitude": np.full(3, success.angle),
        "rate": np.full(3, success.rate),
        "wheel_momentum": np.full(wheels, torque * scenario.control_period),
        "last_command": np.full(wheels, torque),
        "command_in_effect": np.full(wheels, torque),
    }
    if appendages is not None:
        rate = success.rate * np.maximum(np.linalg.norm(appendages.coupling_matrix, axis=1), 1e-3)
        sizes |= {"modal_displacement": rate / np.array(appendages.frequencies), "modal_rate": rate}
    return sizes
