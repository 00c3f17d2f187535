"""Linear sampled loop of a baseline and its nominal spacecraft: spectral radius, gain margins and delay margin."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.linalg import block_diag, schur, solve_sylvester

from ftac_gym.baselines.linear_loop.controller import LinearController, NoLinearLoopError, linearise
from ftac_gym.baselines.linear_loop.spacecraft import spacecraft_model
from ftac_gym.baselines.linear_loop.system import System, held_parts
from ftac_gym.baselines.once import judged_once
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray

if TYPE_CHECKING:
    from ftac_gym.baselines.baseline import Baseline

NEUTRAL = 1e-6
"""Distance of the spectral radius from 1 within which a loop neither decays nor grows: rounding."""
SLOW = 1e-4
"""Distance from 1 within which the eigenvalue of a mode that does not decay is that of a mode at rest."""
PART = 1e-5
"""Least part of attitude and rate in a neutral mode."""
LARGEST_FACTOR, FACTORS = 1e3, 24
"""Limit of the gain factors that are tried, up and down, and their number each way before the bisection."""
LONGEST_QUEUE = 20
"""Further delay up to which the loop is closed exactly [control periods]; beyond, its phase alone counts."""
FREQUENCIES = 1500
"""Frequencies at which the loop is evaluated for long delays."""
ACCURACY = 1e-4
"""Relative accuracy of the margins."""


@dataclass(frozen=True)
class LoopMargins:
    """Stability of a linear sampled loop near rest on target.

    Attributes
    ----------
    spectral_radius
        Largest magnitude of a mode in which the attitude takes part, per control period [-]; below 1 it decays.
    largest_gain, smallest_gain
        Factors on the torque of all wheels within which no motion grows [-]. Infinite and zero stand for no such
        factor up to 1,000 or down to 1/1,000, NaN for a loop that is unstable without a factor.
    delay_margin
        Further loop delay that the baseline is not told, up to which no motion grows [s]; infinite or NaN as before.
    """

    spectral_radius: float
    largest_gain: float = math.nan
    smallest_gain: float = math.nan
    delay_margin: float = math.nan

    @property
    def stable(self) -> bool:
        """True if every motion decays."""
        return self.spectral_radius < 1.0 - NEUTRAL

    @property
    def unstable(self) -> bool:
        """True if a motion grows; a neutral loop, such as one that damps the rate alone, is not stable either."""
        return self.spectral_radius > 1.0 + NEUTRAL

    def __str__(self) -> str:
        """Return the numbers with their names and units."""
        text = f"spectral radius {self.spectral_radius:.6g} per control period"
        if self.unstable:
            return f"{text}: unstable"
        largest = f"{self.largest_gain:.3g}" if math.isfinite(self.largest_gain) else f"over {LARGEST_FACTOR:g}"
        delay = f"{self.delay_margin:.3g} s" if math.isfinite(self.delay_margin) else "unlimited"
        neutral = "" if self.stable else " (neutral: a motion stays)"
        return f"{text}{neutral}, gain margin {self.smallest_gain:.3g} to {largest}, delay margin {delay}"


def loop_margins(baseline: Baseline) -> LoopMargins:
    """Return spectral radius and margins of a baseline with its nominal spacecraft, control period and loop delay.

    Parameters
    ----------
    baseline
        The baseline, which is left as it is.

    Raises
    ------
    NoLinearLoopError
        If it has no linear model near rest.
    """
    loop = linear_loop(baseline)
    margins = LoopMargins(loop.radius())
    if margins.unstable:
        return margins
    return LoopMargins(
        margins.spectral_radius,
        largest_gain=loop.gain_margin(LARGEST_FACTOR),
        smallest_gain=loop.gain_margin(1.0 / LARGEST_FACTOR),
        delay_margin=loop.delay_margin(),
    )


def linear_loop(baseline: Baseline) -> LinearLoop:
    """Return the linear loop of a baseline, found once in a process for the same class, scenario and gains.

    Parameters and errors are those of :func:`loop_margins`.
    """
    found = judged_once(baseline, _loop)
    if isinstance(found, NoLinearLoopError):
        raise found
    return found


def _loop(baseline: Baseline) -> LinearLoop | NoLinearLoopError:
    """Return the loop, or the error of a baseline that has none: a cache keeps both."""
    try:
        return LinearLoop(linearise(baseline), baseline.scenario)
    except NoLinearLoopError as error:
        return error


class LinearLoop:
    """Loop of a linear controller and the nominal spacecraft, closed with any gain and any further delay.

    The spacecraft starts at rest with empty wheels, so that no gyroscopic torque is linear in its state. Its vibration
    modes and the lag of its wheels are included; friction and dead-bands are not.

    Parameters
    ----------
    controller
        The controller.
    scenario
        The task.
    """

    def __init__(self, controller: LinearController, scenario: Scenario) -> None:
        self.period, self.delay = scenario.control_period, scenario.loop_delay
        plant, names = spacecraft_model(scenario)
        told = told_controller(controller, scenario, names)
        telemetry = np.abs(np.concatenate([told.b, told.d])[:, names["wheel_momentum"]]).max(initial=0.0)
        blind = bool(telemetry == 0.0)
        if blind:
            # Nothing then depends on the momenta, which are states and outputs of the same numbers.
            keep = np.delete(np.arange(len(plant.a)), names["wheel_momentum"])
            seen = np.delete(np.arange(len(plant.c)), names["wheel_momentum"])
            plant = System(plant.a[np.ix_(keep, keep)], plant.b[keep], plant.c[np.ix_(seen, keep)], plant.d[seen])
            told = System(told.a, told.b[:, seen], told.c, told.d[:, seen])
        if blind and scenario.spacecraft.wheels.lag is None:
            # The body then feels the sum of the wheels alone.
            axes = scenario.spacecraft.wheels.axis_matrix
            told = System(told.a, told.b, axes @ told.c, axes @ told.d)
            plant = System(plant.a, plant.b @ np.linalg.pinv(axes), plant.c, np.zeros((len(plant.c), 3)))
        self.plant, self.controller = plant, told
        radius = self.radius()
        # The part between measurement and torque is quicker to compute with, if rounding leaves it whole.
        self.controller = told.reduced()
        if abs(self.radius() - radius) > NEUTRAL:
            self.controller = told

    def radius(self, gain: float = 1.0, further_delay: float = 0.0) -> float:
        """Return the spectral radius with a factor on all torques, and with a delay that the controller is not told.

        Parameters
        ----------
        gain
            The factor.
        further_delay
            The delay beyond the nominal one [s], any part of a control period.
        """
        matrix = self.closed(gain, further_delay)
        values = np.linalg.eigvals(matrix)
        still = np.array([_still(value) for value in values])
        if still.any() and not _moves_attitude(matrix):
            values = values[~still]
        return float(np.abs(values).max(initial=0.0))

    def closed(self, gain: float, further_delay: float) -> FloatArray:
        """Return the matrix of one control period of the loop: spacecraft, controller, commands on their way."""
        plant, controller = self.plant, self.controller
        periods, late = self.split(further_delay)
        transition, first, rest = held_parts(plant, self.period, late)
        states, memory, commands = len(plant.a), len(controller.a), plant.b.shape[1]
        queue = periods + (1 if late > 0.0 else 0)
        size = states + memory + queue * commands
        matrix = np.zeros((size, size))
        matrix[:states, :states] = transition
        # The command of this moment, then those before it, as rows over the state.
        now = np.concatenate([controller.d @ plant.c, controller.c, np.zeros((commands, queue * commands))], axis=1)
        past = np.eye(size)[states + memory :].reshape(queue, commands, size)
        given = [now, *past]
        matrix[:states] += gain * rest @ given[periods]
        if late > 0.0:
            matrix[:states] += gain * first @ given[periods + 1]
        matrix[states : states + memory, :states] = controller.b @ plant.c
        matrix[states : states + memory, states : states + memory] = controller.a
        if queue:
            matrix[states + memory :] = np.concatenate(given[:queue])
        return matrix

    def split(self, further_delay: float) -> tuple[int, float]:
        """Return the whole control periods of the delay, and the rest [s]."""
        total = (self.delay + further_delay) / self.period
        periods = math.floor(total + 1e-9)
        late = (total - periods) * self.period
        return periods, late if late > 1e-9 * self.period else 0.0

    def gain_margin(self, end: float) -> float:
        """Return the factor nearest to 1 at which a motion grows, towards ``end``; inf or 0 for none."""
        factors = np.geomspace(1.0, end, FACTORS + 1).tolist()
        found = _edge(factors, lambda factor: self.radius(gain=factor))
        return found if found is not None else (math.inf if end > 1.0 else 0.0)

    def delay_margin(self) -> float:
        """Return the least further delay at which a motion grows [s], infinite for none."""
        delays = [self.period * count for count in range(LONGEST_QUEUE + 1)]
        found = _edge(delays, lambda delay: self.radius(further_delay=delay))
        return found if found is not None else self._long_delay_margin()

    def _long_delay_margin(self) -> float:
        """Return the delay margin by the phases at which an eigenvalue of the open loop has magnitude 1 [s]."""
        frequencies = np.geomspace(1e-6, math.pi, FREQUENCIES)
        values = self._open_loop(frequencies)
        best = math.inf
        order = np.argsort(np.abs(values), axis=1)
        sizes = np.log(np.take_along_axis(np.abs(values), order, axis=1))
        for index, locus in zip(*np.nonzero(np.diff(np.sign(sizes), axis=0)), strict=True):
            low, high = frequencies[index], frequencies[index + 1]
            for _ in range(30):
                middle = math.sqrt(low * high)
                value = self._open_loop(np.array([middle]))[0]
                value = value[np.argsort(np.abs(value))][locus]
                above = math.log(abs(value)) * sizes[index, locus] > 0.0
                low, high = (middle, high) if above else (low, middle)
            turn = (np.angle(-value) % (2.0 * math.pi)) / middle * self.period
            best = min(best, turn)
        return best

    def _open_loop(self, frequencies: FloatArray) -> Any:
        """Return the eigenvalues of minus the open loop at frequencies [rad per control period], (F, commands)."""
        z = np.exp(1j * frequencies)[:, None, None]
        plant, controller = self.plant, self.controller
        periods, late = self.split(0.0)
        transition, first, rest = held_parts(plant, self.period, late)
        response = np.linalg.solve(z * np.eye(len(transition)) - transition, rest + first / z) / z**periods
        inside = np.linalg.solve(z * np.eye(len(controller.a)) - controller.a, controller.b.astype(np.complex128))
        return np.linalg.eigvals(-(controller.c @ inside + controller.d) @ plant.c @ response)


def _still(value: complex) -> bool:
    """Tell whether a mode neither decays nor visibly grows, by its eigenvalue."""
    return abs(value) > 1.0 - NEUTRAL and abs(value - 1.0) < SLOW


def _moves_attitude(matrix: FloatArray) -> bool:
    """Tell whether attitude and rate, the first six states, take part in the modes of a loop that are still.

    Momentum that wheels only store, and estimates that no motion excites, have such modes without a motion.
    """
    # The types of SciPy name the sort of real matrices alone.
    upper, basis, count = schur(matrix.astype(np.complex128), sort=_still)  # type: ignore[arg-type]
    coupling = solve_sylvester(upper[:count, :count], -upper[count:, count:], -upper[:count, count:])
    left = basis[:, :count].conj().T - coupling @ basis[:, count:].conj().T
    return bool(np.abs(basis[:6, :count] @ left[:, :6]).max(initial=0.0) > PART)


def _edge(values: Sequence[float], radius: Callable[[float], float]) -> float | None:
    """Return where a motion of a loop first grows along values from its own, by bisection; None if it does not."""
    unstable = next((index for index in range(1, len(values)) if radius(values[index]) > 1.0 + NEUTRAL), None)
    if unstable is None:
        return None
    inside, outside = values[unstable - 1], values[unstable]
    while abs(outside - inside) > ACCURACY * abs(outside):
        middle = 0.5 * (inside + outside)
        inside, outside = (inside, middle) if radius(middle) > 1.0 + NEUTRAL else (middle, outside)
    return inside


def told_controller(controller: LinearController, scenario: Scenario, names: dict[str, slice]) -> System:
    """Return a controller with the memory of its own commands, by which the measurement tells it what is in effect.

    Its input is the output of :func:`spacecraft_model`; its output are the wheel commands [N m].
    """
    periods, steps = divmod(scenario.delay_steps, scenario.substeps)
    late, count = steps / scenario.substeps, scenario.spacecraft.wheels.count
    length = periods + (2 if steps else 1)
    states, inputs = len(controller.transition), max(columns.stop for columns in names.values())
    shift = np.eye(count * length, k=-count)
    from_queue = np.zeros((controller.entry.shape[1], count * length))
    from_queue[controller.channels["last_command"], :count] = np.eye(count)
    for age, weight in ((periods, 1.0 - late), (periods + 1, late)):
        if weight > 0.0:
            from_queue[controller.channels["command_in_effect"], age * count : (age + 1) * count] = weight * np.eye(
                count
            )
    choose = np.zeros((controller.entry.shape[1], inputs))
    for name, rows in names.items():
        if name in controller.channels:
            choose[controller.channels[name], rows] = np.eye(rows.stop - rows.start)
    a = block_diag(controller.transition, shift)
    a[:states, states:] = controller.entry @ from_queue
    c = np.concatenate([controller.output, controller.direct @ from_queue], axis=1)
    d = controller.direct @ choose
    a[states : states + count] = c
    b = np.concatenate([controller.entry @ choose, d, np.zeros((count * (length - 1), inputs))])
    return System(a, b, c, d)
