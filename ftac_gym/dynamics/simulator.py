"""The true plant: N craft side by side, each in an episode of its own."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import numpy.typing as npt

from ftac_gym.dynamics.episode_tables import Tables, faults_in, with_episodes, with_faults
from ftac_gym.dynamics.plant import advance
from ftac_gym.dynamics.sensing import sense
from ftac_gym.dynamics.state import State
from ftac_gym.dynamics.wheel_table import wheel_table
from ftac_gym.faults import DrawnFaults, FaultEffect, fault_effect
from ftac_gym.faults.table import LONGEST_DELAY
from ftac_gym.task.episodes import Episodes
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.scenario import Scenario
from ftac_gym.task.vibration import modal_energy, vibration_torque
from ftac_gym.utils.parameters import FloatArray, require

THREAD_BATCH = 512
"""Craft that one thread must have at least: below it, waking the thread costs more than it saves."""


class Simulator:
    """The truth about N craft. It knows nothing of rewards or policies.

    Parameters
    ----------
    scenario
        What to simulate.
    num_spacecraft
        Number of craft N.
    threads
        Number of threads that share the craft; the result does not depend on it.

    Raises
    ------
    ValueError
        If ``num_spacecraft`` or ``threads`` is not a positive integer.
    """

    def __init__(self, scenario: Scenario, num_spacecraft: int, threads: int = 1) -> None:
        require(isinstance(scenario, Scenario), "scenario", "must be a Scenario", scenario)
        for name, value in (("num_spacecraft", num_spacecraft), ("threads", threads)):
            require(isinstance(value, (int, np.integer)) and value > 0, name, "must be a positive integer", value)
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

        count = self.num_spacecraft
        self.state = State(
            np.tile([1.0, 0.0, 0.0, 0.0], (count, 1)),
            np.zeros((count, 3)),
            np.zeros((count, wheels.count)),
            np.zeros((count, wheels.count)),
            np.zeros((count, wheels.count)),
            np.zeros((count, scenario.spacecraft.modes)),
            np.zeros((count, scenario.spacecraft.modes)),
        )
        self.ticks = np.zeros(count, dtype=np.int64)
        """(N,) control periods since the start of each craft's episode."""
        self.reference_attitude = np.tile([1.0, 0.0, 0.0, 0.0], (count, 1))
        self.reference_rate = np.zeros((count, 3))
        self.reference_acceleration = np.zeros((count, 3))
        self.measured_attitude = np.tile([1.0, 0.0, 0.0, 0.0], (count, 1))
        self.measured_rate = np.zeros((count, 3))
        self.star_tracker_valid = np.ones(count, dtype=np.bool_)
        self.last_command = np.zeros((count, wheels.count))
        self._past = np.zeros((count, 0, wheels.count))
        self._gyro_bias = np.zeros((count, 3))
        self._all = np.arange(count)
        self._tables: Tables | None = None
        self._pool: ThreadPoolExecutor | None = None

    def __getstate__(self) -> dict[str, Any]:
        """Leave the threads out of copies and pickles."""
        return {**self.__dict__, "_pool": None}

    @property
    def time(self) -> FloatArray:
        """(N,) time since the start of each craft's episode [s]."""
        time: FloatArray = self.ticks.astype(np.float64) * self.scenario.control_period
        return time

    @property
    def faults(self) -> DrawnFaults:
        """The faults of the episodes that the craft are in: views, not to be written to."""
        return faults_in(self._drawn())

    @property
    def modal_energy(self) -> FloatArray:
        """(N,) energy of the vibration modes [J]."""
        state = self.state
        return modal_energy(self._drawn()["modes"]["stiffness"], state.modal_displacement, state.modal_rate)

    @property
    def vibration_torque(self) -> FloatArray:
        """(N, 3) torque of the vibration modes on the body [N m], body axes."""
        state = self.state
        return vibration_torque(self._drawn()["modes"], state.modal_displacement, state.modal_rate, state.rate)

    @property
    def feasible(self) -> npt.NDArray[np.bool_]:
        """(N,) whether each craft's episode can be done at all: a view, not to be written to."""
        return self._drawn()["feasible"]

    @property
    def episodes(self) -> Episodes:
        """The episodes that the craft are in (a copy)."""
        tables = self._drawn()
        return Episodes(self.scenario.to_json(), **{name: array.copy() for name, array in tables.items()})

    def reset(self, episodes: Episodes, mask: npt.NDArray[np.bool_] | None = None) -> None:
        """Start new episodes.

        Parameters
        ----------
        episodes
            One episode for each craft to be reset, in their order.
        mask
            (N,) which craft to reset; None for all. The others are left untouched.

        Raises
        ------
        ValueError
            If the mask has the wrong shape, the number of episodes is not that of the craft to be reset, the episodes
            do not fit the scenario, or some craft has never been reset.
        """
        if mask is None:
            chosen = self._all
        else:
            mask = np.asarray(mask)
            valid = mask.shape == (self.num_spacecraft,) and mask.dtype == np.bool_
            require(valid, "mask", f"must be a boolean array of shape ({self.num_spacecraft},)", mask)
            chosen = np.flatnonzero(mask)
        require(len(episodes) == len(chosen), "episodes", f"must be {len(chosen)}, one per craft reset", len(episodes))
        wheels = episodes.faults.shape[1]
        require(wheels == len(self._torque_limits), "episodes", f"must have {len(self._torque_limits)} wheels", wheels)
        modes, known = episodes.modes.shape[1], self.scenario.spacecraft.modes
        require(modes == known, "episodes", f"must be of craft with {known} vibration modes", modes)
        if self._tables is None:
            require(len(chosen) == self.num_spacecraft, "mask", "must cover all craft at the first reset", mask)
            self._tables = {name: np.array(array) for name, array in episodes.arrays().items()}
        else:
            self._tables = with_episodes(self._tables, episodes, chosen)
        tables = self._tables
        for part, name in ((self.state.attitude, "attitude"), (self.state.rate, "rate")):
            part[chosen] = tables["initial"][name][chosen]
        self.state.wheel_momentum[chosen] = tables["initial"]["wheel_momentum"][chosen]
        if self.scenario.spacecraft.modes:
            self.state.modal_displacement[chosen] = tables["initial"]["modal_displacement"][chosen]
            self.state.modal_rate[chosen] = tables["initial"]["modal_rate"][chosen]
        self.state.wheel_torque[chosen] = 0.0
        self.state.motor_torque[chosen] = 0.0
        self.last_command[chosen] = 0.0
        self._remember(episodes.faults)
        self._past[chosen] = 0.0
        self.ticks[chosen] = 0
        self._gyro_bias[chosen] = tables["sensors"]["gyro_bias"][chosen]
        self._sense(chosen)

    def step(self, command: npt.ArrayLike) -> None:
        """Hold a command for one control period.

        Parameters
        ----------
        command
            (N, wheels) torque of each wheel on the body [N m]; beyond its torque limit a wheel gives the limit.

        Raises
        ------
        ValueError
            If the command has the wrong shape or is not finite.
        RuntimeError
            If the simulator was never reset.
        """
        torque = np.asarray(command, dtype=np.float64)
        require(
            torque.shape == self.last_command.shape, "command", f"must have shape {self.last_command.shape}", torque
        )
        require(bool(np.isfinite(torque).all()), "command", "must be finite", torque)
        np.clip(torque, -self._torque_limits, self._torque_limits, out=self.last_command)
        self.advance()

    def advance(self) -> None:
        """Hold ``last_command`` for one control period: :meth:`step` without its checks and its limiter."""
        shared = self.plant_arguments()
        parts = min(self.threads, max(1, self.num_spacecraft // THREAD_BATCH))
        if parts == 1:
            advance(0, self.num_spacecraft, *shared)
        else:
            if self._pool is None:
                self._pool = ThreadPoolExecutor(self.threads)
            edges = np.linspace(0, self.num_spacecraft, parts + 1).astype(int)
            list(self._pool.map(lambda first, end: advance(first, end, *shared), edges[:-1], edges[1:]))
        self._sense(self._all)

    def plant_arguments(self) -> tuple[Any, ...]:
        """Return what the compiled plant is called with after the range of craft."""
        tables, state = self._drawn(), self.state
        # Rigid craft get none of it: the compiler then makes a plant of its own for them.
        bending = (tables["modes"], state.modal_displacement, state.modal_rate) if self._bends else (None, None, None)
        return (
            state.attitude, state.rate, state.wheel_momentum, state.motor_torque, state.wheel_torque, self.ticks,
            self.last_command, self._past, self._wheel_table, self._coupled, tables["inertia"], self._rate_torque,
            *bending, tables["faults"], tables["switches"],
            tables["disturbance"], tables["harmonics"], self._step, self._substeps,
        )  # fmt: skip

    def set_faults(self, drawn: DrawnFaults) -> None:
        """Change what is wrong with the craft in the middle of their episodes; see :mod:`ftac_gym.faults.live`.

        ``episodes`` then are those with these faults from the start: flown again, they give the same flight. Only a
        command delay that comes to craft without any begins as if the commands had always been the latest one. The
        labels of feasibility stay those of the episodes as they were drawn.

        Parameters
        ----------
        drawn
            The faults of all craft, past and present.

        Raises
        ------
        ValueError
            If they are for another number of craft or wheels.
        """
        tables = self._drawn()
        craft, wheels = self.last_command.shape
        given = tuple(len(table) for table in drawn), drawn.wheels.shape[1]
        rule = f"must be for {craft} craft of {wheels} wheels; craft in each table, and wheels"
        require(given == ((craft,) * 3, wheels), "faults", rule, given)
        # A copy: the tables are written to when craft begin new episodes.
        self._tables = with_faults(tables, drawn.copy())
        self._remember(drawn.wheels)

    def _remember(self, faults: npt.NDArray[np.void]) -> None:
        """Keep past commands from now on if craft that get these faults may need them."""
        if not self._past.shape[1] and (faults["delay"] > 0).any():
            self._past = np.repeat(self.last_command[:, None], LONGEST_DELAY, axis=1)

    def truth(self) -> FaultEffect:
        """Return what the faults of all craft do now."""
        wheels = self.scenario.spacecraft.wheels
        return fault_effect(self.faults, self.time, wheels, self.state.wheel_momentum, self.state.wheel_torque)

    def measurement(self, truth: bool = False) -> Measurement:
        """Return what the craft measure now; the arrays are the caller's to keep.

        Parameters
        ----------
        truth
            Whether to add what the faults do, for an oracle.
        """
        return Measurement(
            time=self.time,
            attitude=self.measured_attitude.copy(),
            rate=self.measured_rate.copy(),
            wheel_momentum=self.state.wheel_momentum.copy(),
            last_command=self.last_command.copy(),
            star_tracker_valid=self.star_tracker_valid.copy(),
            reference_attitude=self.reference_attitude.copy(),
            reference_rate=self.reference_rate.copy(),
            reference_acceleration=self.reference_acceleration.copy(),
            modal_displacement=self.state.modal_displacement.copy(),
            modal_rate=self.state.modal_rate.copy(),
            truth=self.truth() if truth else None,
        )

    def _drawn(self) -> Tables:
        if self._tables is None:
            raise RuntimeError("the simulator must be reset before it is used")
        return self._tables

    def _sense(self, craft: npt.NDArray[np.int64]) -> None:
        tables = self._drawn()
        sense(
            craft, self.state.attitude, self.state.rate, self.ticks, self._step, self._substeps, tables["reference"],
            tables["set_points"], self.reference_attitude, self.reference_rate, self.reference_acceleration,
            tables["sensors"], tables["sensor_faults"], tables["switches"], tables["key"], tables["index"],
            self._gyro_bias, self.measured_attitude, self.measured_rate, self.star_tracker_valid,
        )  # fmt: skip
