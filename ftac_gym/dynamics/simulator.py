"""True plant of N spacecraft, each in an episode of its own."""

import os
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import numpy.typing as npt
from numba import config

from ftac_gym.dynamics.command_queue import CommandQueue
from ftac_gym.dynamics.divergence import MOVED, SEEN, divergence
from ftac_gym.dynamics.instruments import WITHOUT, Instruments, instruments
from ftac_gym.dynamics.merging import merged, with_faults
from ftac_gym.dynamics.plant import advance
from ftac_gym.dynamics.sensing import sense
from ftac_gym.dynamics.state import State, identity_quaternions
from ftac_gym.dynamics.wheel_table import wheel_table
from ftac_gym.faults import DrawnFaults, FaultEffect, fault_effect
from ftac_gym.faults.checking import check_faults
from ftac_gym.task.episodes import Episodes
from ftac_gym.task.fitting import fitted
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.reach import fastest_rate
from ftac_gym.task.sampled_reference import table_of
from ftac_gym.task.scenario import Scenario
from ftac_gym.task.sensor_suite import SensorSuite
from ftac_gym.task.vibration import modal_energy, vibration_torque
from ftac_gym.utils.parameters import FloatArray, is_whole, real_numbers, require

THREAD_BATCH = 512
"""Least number of spacecraft of one thread: with fewer, waking the thread costs more than it saves."""


class Simulator:
    """True state, measurement and faults of N spacecraft, without rewards and policies.

    Parameters
    ----------
    scenario
        The scenario.
    num_spacecraft
        Number of spacecraft N.
    threads
        Number of threads that share the spacecraft; the result does not depend on it.

    Raises
    ------
    ValueError
        If ``num_spacecraft`` or ``threads`` is not a positive integer.
    """

    def __init__(self, scenario: Scenario, num_spacecraft: int, threads: int = 1) -> None:
        # In plain Python, fields of records have no names.
        disabled = config.DISABLE_JIT  # type: ignore[attr-defined]  # Numba sets it from the environment.
        require(not disabled, "NUMBA_DISABLE_JIT", "must be unset or 0: the simulation runs as compiled code", disabled)
        require(isinstance(scenario, Scenario), "scenario", "must be a Scenario", scenario)
        for name, value in (("num_spacecraft", num_spacecraft), ("threads", threads)):
            require(is_whole(value) and value > 0, name, "must be a positive integer", value)
        self.scenario = scenario
        self.num_spacecraft = int(num_spacecraft)
        self.threads = int(threads)
        wheels = scenario.spacecraft.wheels
        self._torque_limits = wheels.torque_limits
        self._wheel_table = wheel_table(wheels, scenario.physics_step)
        if scenario.misalignment is not None:
            self._wheel_table["axis"] += np.transpose(scenario.misalignment)
        self._coupled = wheels.momentum_coupling
        self._bends = scenario.spacecraft.modes > 0
        uncertainty = scenario.inertia_uncertainty
        self._rate_torque = uncertainty is not None and uncertainty.rate_torque
        self._step, self._substeps = scenario.physics_step, scenario.substeps
        self._largest_rate = fastest_rate(scenario)
        self._trajectory = table_of(scenario.reference, scenario.control_period, scenario.horizon)

        count = self.num_spacecraft
        self.state = State.at_rest(count, wheels.count, scenario.spacecraft.modes)
        self.ticks = np.zeros(count, dtype=np.int64)
        """(N,) control periods since the start of each episode."""
        self.reference_attitude, self.measured_attitude = identity_quaternions(count), identity_quaternions(count)
        self.reference_rate, self.reference_acceleration = np.zeros((count, 3)), np.zeros((count, 3))
        self.measured_rate, self._gyro_bias = np.zeros((count, 3)), np.zeros((count, 3))
        self.star_tracker_valid = np.ones(count, dtype=np.bool_)
        self._queue = CommandQueue(count, wheels.count, scenario.delay_steps, scenario.substeps)
        self._fix_ticks = np.zeros(count, dtype=np.int64)
        suite = scenario.sensors
        self._instruments: Instruments | None = None
        if isinstance(suite, SensorSuite):
            self._instruments = instruments(suite, scenario.control_period, self.state)
        source = self._instruments or self.state
        self.measured_wheel_momentum = source.wheel_momentum
        """(N, m) measured momentum of the wheels [N m s]; the true array where it is measured without errors."""
        self.measured_modal_displacement, self.measured_modal_rate = source.modal_displacement, source.modal_rate
        self._indices = np.arange(count)
        self._episodes: Episodes | None = None
        self._pool: tuple[int, ThreadPoolExecutor] | None = None

    def __getstate__(self) -> dict[str, Any]:
        """Leave the threads out of copies and pickles."""
        return {**self.__dict__, "_pool": None}

    def _threads(self) -> ThreadPoolExecutor:
        """Return the threads of this process: a forked child has those of its parent in name only."""
        if self._pool is None or self._pool[0] != os.getpid():
            self._pool = os.getpid(), ThreadPoolExecutor(self.threads)
        return self._pool[1]

    @property
    def time(self) -> FloatArray:
        """(N,) time since the start of each episode [s]."""
        return self.ticks.astype(np.float64) * self.scenario.control_period

    @property
    def attitude_age(self) -> FloatArray:
        """(N,) time since the sample of the star tracker was taken that the measured attitude is from [s]."""
        return (self.ticks - self._fix_ticks).astype(np.float64) * self.scenario.control_period

    @property
    def last_command(self) -> FloatArray:
        """(N, m) command given last [N m], a view: what is written to it is held by :meth:`advance`."""
        return self._queue.latest

    @property
    def command_in_effect(self) -> FloatArray:
        """(N, m) mean command in effect over the last control period [N m], by the nominal loop delay."""
        return self._queue.in_effect

    @property
    def faults(self) -> DrawnFaults:
        """Faults of the present episodes: views, not to be written to."""
        return self._drawn().drawn_faults

    @property
    def modal_energy(self) -> FloatArray:
        """(N,) energy of the vibration modes [J]."""
        state = self.state
        return modal_energy(self._drawn().modes["stiffness"], state.modal_displacement, state.modal_rate)

    @property
    def vibration_torque(self) -> FloatArray:
        """(N, 3) torque of the vibration modes on the body [N m], body axes."""
        state = self.state
        return vibration_torque(self._drawn().modes, state.modal_displacement, state.modal_rate, state.rate)

    @property
    def feasible(self) -> npt.NDArray[np.bool_]:
        """(N,) labels of feasibility of the present episodes: a view, not to be written to."""
        return self._drawn().feasible

    @property
    def episodes(self) -> Episodes:
        """Copy of the present episodes."""
        return _copied(self._drawn(), self.scenario)

    def reset(self, episodes: Episodes, mask: npt.NDArray[np.bool_] | None = None) -> None:
        """Start new episodes from any source.

        Parameters
        ----------
        episodes
            One episode for each spacecraft to be reset, in their order; of the scenario, or of another one for which
            :func:`~ftac_gym.task.fitting.fitted` can take them.
        mask
            (N,) True for the spacecraft to reset; None for all. The others do not change.

        Raises
        ------
        ValueError
            If the mask has the wrong shape, or does not cover all spacecraft at the first reset. Also if the episodes
            do not fit the scenario, hold a wrong number, or are not one for each spacecraft to be reset.
        """
        episodes = fitted(episodes, self.scenario)
        rows = self._indices
        if mask is not None:
            mask = np.asarray(mask)
            valid = mask.shape == (self.num_spacecraft,) and mask.dtype == np.bool_
            require(valid, "mask", f"must be a boolean array of shape ({self.num_spacecraft},)", mask)
            rows = np.flatnonzero(mask)
        count = len(episodes)
        require(count == len(rows), "episodes", f"must be {len(rows)}, one per spacecraft reset", count)
        self.begin(episodes, rows)

    def begin(self, episodes: Episodes, rows: npt.NDArray[np.int64]) -> None:
        """Start episodes that the scenario has drawn for the listed spacecraft, without the checks of :meth:`reset`."""
        if self._episodes is None:
            whole = len(rows) == self.num_spacecraft
            require(whole, "mask", "must cover all spacecraft at the first reset; it has", rows.tolist())
            self._episodes = _copied(episodes, self.scenario)
        else:
            self._episodes = merged(self._episodes, episodes, rows)
        initial = self._episodes.initial
        for name in initial.dtype.names or ():
            getattr(self.state, name)[rows] = initial[name][rows]
        self._gyro_bias[rows] = self._episodes.sensors["gyro_bias"][rows]
        self._queue.begin(rows, episodes.extra_delay)
        for array in (self.state.wheel_torque, self.state.motor_torque, self.ticks):
            array[rows] = 0
        self._sense(rows)

    def step(self, command: npt.ArrayLike) -> None:
        """Give a command and advance by one control period; the command takes effect after the loop delay.

        Parameters
        ----------
        command
            (N, wheels) torque of each wheel on the body [N m]; beyond its torque limit a wheel gives the limit.

        Raises
        ------
        ValueError
            If the command has the wrong shape, is not finite, or does not consist of real numbers.
        RuntimeError
            If the simulator was never reset.
        DivergenceError
            If a spacecraft has diverged: its state is not finite, or too fast for the physics step.
        """
        given, shape = np.asarray(command), self.last_command.shape
        require(given.shape == shape, "command", f"must have shape {shape}", given)
        torque = real_numbers(given, "command").astype(np.float64, copy=False)
        require(bool(np.isfinite(torque).all()), "command", "must be finite", torque)
        np.clip(torque, -self._torque_limits, self._torque_limits, out=self.last_command)
        self.advance()

    def advance(self) -> None:
        """Advance by one control period after ``last_command``, without the checks and the limiter of :meth:`step`."""
        for part in range(len(self._queue.parts)):
            self._turn(self.plant_arguments(part))
        self.ticks += 1
        self._queue.shift()
        self._sense(self._indices)

    def _turn(self, shared: tuple[Any, ...]) -> None:
        """Advance all spacecraft by a part of a control period, each thread some of them."""
        parts = min(self.threads, max(1, self.num_spacecraft // THREAD_BATCH))
        if parts == 1:
            advance(0, self.num_spacecraft, *shared)
        else:
            edges = np.linspace(0, self.num_spacecraft, parts + 1).astype(int)
            list(self._threads().map(lambda first, end: advance(first, end, *shared), edges[:-1], edges[1:]))

    def plant_arguments(self, part: int = -1) -> tuple[Any, ...]:
        """Return the arguments of the compiled plant after the range of spacecraft, for a part of a control period."""
        episodes, state, queue = self._drawn(), self.state, self._queue
        further, first, steps = queue.parts[part]
        # With None the compiler makes a plant without modes.
        bending = (episodes.modes, state.modal_displacement, state.modal_rate) if self._bends else (None, None, None)
        return (
            state.attitude, state.rate, state.wheel_momentum, state.motor_torque, state.wheel_torque,
            self.ticks, first, queue.commands, queue.lag + further, self._wheel_table, self._coupled, episodes.inertia,
            self._rate_torque, *bending, episodes.faults, episodes.switches, episodes.disturbance, episodes.harmonics,
            self._step, steps, self._step * self._substeps,
        )  # fmt: skip

    def set_faults(self, drawn: DrawnFaults) -> None:
        """Change the faults in the middle of the episodes; see :mod:`ftac_gym.faults.live`.

        ``episodes`` then are those with these faults from the start: flown again, they give the same flight.
        The labels of feasibility stay those of the episodes as they were drawn.

        Parameters
        ----------
        drawn
            The faults of all spacecraft, past and present.

        Raises
        ------
        ValueError
            If they are for another number of spacecraft or wheels, or hold a number that is none of a fault.
        """
        count, wheels = self.last_command.shape
        given = tuple(len(table) for table in drawn), drawn.wheels.shape[1]
        rule = f"must be for {count} spacecraft of {wheels} wheels; rows of each table, and wheels"
        require(given == ((count,) * 3, wheels), "faults", rule, given)
        check_faults(drawn, count, wheels)
        # A copy: new episodes are written to the tables.
        self._episodes = with_faults(self._drawn(), drawn.copy())

    def truth(self) -> FaultEffect:
        """Return the present effect of the faults of all spacecraft."""
        wheels = self.scenario.spacecraft.wheels
        return fault_effect(self.faults, self.time, wheels, self.state.wheel_momentum, self.state.wheel_torque)

    def measurement(self, truth: bool = False) -> Measurement:
        """Return the present measurement, with arrays of its own.

        Parameters
        ----------
        truth
            Whether to add the effect of the faults, for an oracle.
        """
        return Measurement(
            time=self.time,
            attitude=self.measured_attitude.copy(),
            rate=self.measured_rate.copy(),
            wheel_momentum=self.measured_wheel_momentum.copy(),
            last_command=self.last_command.copy(),
            command_in_effect=self.command_in_effect.copy(),
            star_tracker_valid=self.star_tracker_valid.copy(),
            attitude_age=self.attitude_age,
            reference_attitude=self.reference_attitude.copy(),
            reference_rate=self.reference_rate.copy(),
            reference_acceleration=self.reference_acceleration.copy(),
            modal_displacement=self.measured_modal_displacement.copy(),
            modal_rate=self.measured_modal_rate.copy(),
            truth=self.truth() if truth else None,
        )

    def _drawn(self) -> Episodes:
        if self._episodes is None:
            raise RuntimeError("the simulator must be reset before it is used")
        return self._episodes

    def _sense(self, rows: npt.NDArray[np.int64]) -> None:
        episodes, state = self._drawn(), self.state
        errors, suite_sensors = (None, episodes.sensors) if self._instruments else (episodes.sensors, None)
        diverged = sense(
            rows, state.attitude, state.rate, self.ticks, self._step, self._substeps, episodes.reference,
            episodes.set_points, self.reference_attitude, self.reference_rate, self.reference_acceleration,
            errors, episodes.sensor_faults, episodes.switches, episodes.key, episodes.index,
            self._gyro_bias, self.measured_attitude, self.measured_rate, self.star_tracker_valid, self._fix_ticks,
            suite_sensors, *(self._instruments or WITHOUT), state.wheel_momentum, state.modal_displacement,
            state.modal_rate, self._largest_rate,
        )  # fmt: skip
        if self._trajectory is not None:
            ticks = np.minimum(self.ticks[rows], len(self._trajectory[0]) - 1)
            followed = self.reference_attitude, self.reference_rate, self.reference_acceleration
            for values, table in zip(followed, self._trajectory, strict=True):
                values[rows] = table[ticks]
        if diverged:
            parts = {name: getattr(state, name) for name in MOVED}, {name: getattr(self, name) for name in SEEN}
            raise divergence(*parts, self.time, rows, self._largest_rate)


def _copied(episodes: Episodes, scenario: Scenario) -> Episodes:
    """Return the episodes as those of the scenario, with arrays of their own."""
    return Episodes(scenario.to_json(), **{name: array.copy() for name, array in episodes.arrays().items()})
