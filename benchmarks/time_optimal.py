"""Time-optimal turns of the flagship's frozen episodes, a bound on settling times, beside those of controllers.

For each episode, the script searches the shortest time from the start into the success cone at rest. The wheels are
ideal and healthy, and there is neither noise nor disturbance. The total momentum H is constant in the reference frame,
which leaves attitude and rate as states: J w' = D u - w x C(q) H with |u| within the torque limits. The momentum limits
of the wheels are checked afterwards.

The method is direct multiple shooting with one Runge-Kutta step per interval of constant torque and a free end time,
solved by IPOPT (CasADi). The first guesses are the turns about the axis of the error, both ways round, and optionally
paths bent aside. A local optimum is an upper bound of the optimum. As no controller beats the optimum of any episode,
the interquartile mean of the optima bounds that of every controller, with two exceptions:

- Of the faults of training, only a bias lets a wheel exceed its limit. If one occurs before the time found, the problem
  is solved again with the limit of that wheel widened by the bias, from the start: ``whatever the biases``.
- Torque is held and settling counted in control periods: ``in control periods``. (The disturbance is below a thousandth
  of the torque.)

``proven`` needs no optimiser. Gyroscopic torque does no work, so that sqrt(w.J w) changes by max |J^-1/2 D u| at most.
The integral of sqrt(w.J w) is at least the angle times the root of the smallest principal inertia.

CasADi is no dependency of the package: pip install casadi

For example:

    python benchmarks/time_optimal.py --episodes 120 --torque-share 0.9 --baselines pd_dob
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from tqdm import tqdm

from ftac_gym import scenarios
from ftac_gym.attitude import (
    canonical,
    quaternion_error,
    quaternion_from_rotation_vector,
    rotate_to_reference,
    rotation_vector_from_quaternion,
)
from ftac_gym.baselines.components.allocation import MinimaxAllocation
from ftac_gym.evaluation import interquartile_mean, rollout
from ftac_gym.faults.table import FaultKind
from ftac_gym.policies import DeferredBaseline
from ftac_gym.scenarios import frozen
from ftac_gym.spacecraft.wheel_array import WheelArray
from ftac_gym.task.episodes import Episodes
from ftac_gym.task.objective import SuccessCriterion
from ftac_gym.utils.console import run_program
from ftac_gym.utils.directions import across
from ftac_gym.utils.parameters import FloatArray, require

BEND = 0.6
"""Largest distance of the further first guesses from the straight turn [rad]."""


@dataclass(frozen=True)
class Config:
    """Episodes, discretisation, and controllers to compare with."""

    episodes: int = 500
    """Feasible episodes, the first of the frozen ones."""
    intervals: int = 40
    """Intervals of constant torque."""
    torque_share: float = 1.0
    """Share of the torque limits that may be used: less for a margin."""
    bends: int = 0
    """Further first guesses each way round, the path bent aside in so many directions."""
    baselines: tuple[str, ...] = ("pd_dob", "nftsm_observer", "nftsm_oracle")
    """Tuned controllers to compare with."""


class Start(NamedTuple):
    """Error quaternion (4,), rate (3,) [rad/s], wheel momentum (m,) [N m s] and true inertia (3, 3) of an episode."""

    error: FloatArray
    rate: FloatArray
    momentum: FloatArray
    inertia: FloatArray

    def turn(self, way: float = 1.0) -> tuple[float, FloatArray]:
        """Return angle [rad] and axis (3,) of the error, the short way round (1) or the long (-1)."""
        vector = rotation_vector_from_quaternion(canonical(self.error))
        angle = float(np.linalg.norm(vector))
        axis = vector / max(angle, 1e-12)
        return (angle, axis) if way > 0.0 else (2.0 * np.pi - angle, -axis)


class TimeOptimalTurn:
    """The minimum-time problem, built once and solved for many starts.

    Parameters
    ----------
    wheels
        The wheels.
    success
        The cone to reach, and the rate in it.
    intervals
        Intervals of constant torque.
    """

    def __init__(self, wheels: WheelArray, success: SuccessCriterion, intervals: int) -> None:
        try:
            import casadi as ca
        except ImportError:
            raise SystemExit("this benchmark needs CasADi: pip install casadi") from None
        self._wheels, self._intervals, count = wheels, intervals, wheels.count
        state, given = ca.SX.sym("state", 7), ca.SX.sym("given", count + 12)  # torque, inverse inertia, momentum
        scalar, vector, rate, momentum = state[0], state[1:4], state[4:], given[-3:]
        twice = 2.0 * ca.cross(vector, momentum)
        in_body = momentum - scalar * twice + ca.cross(vector, twice)
        torque = ca.DM(wheels.axis_matrix) @ given[:count] - ca.cross(rate, in_body)
        change = ca.vertcat(
            -0.5 * ca.dot(vector, rate),
            0.5 * (scalar * rate + ca.cross(vector, rate)),
            ca.reshape(given[count:-3], 3, 3) @ torque,
        )
        advance = ca.simpleRK(ca.Function("field", [state, given], [change]), 1, 4).expand().map(intervals)
        time, states, constants = ca.MX.sym("time"), ca.MX.sym("states", 7, intervals + 1), ca.MX.sym("constants", 12)
        torques, last = ca.MX.sym("torques", count, intervals), states[:, -1]
        held = ca.vertcat(torques, ca.repmat(constants, 1, intervals))
        ends = advance(states[:, :-1], held, ca.repmat(time / intervals, 1, intervals))
        final = ca.sumsqr(last[1:4]) / np.sin(0.5 * success.angle) ** 2, ca.sumsqr(last[4:]) / success.rate**2
        problem = {
            "x": ca.vertcat(time, ca.vec(states), ca.vec(torques)),
            "p": constants,
            "f": time,
            "g": ca.vertcat(ca.vec(states[:, 1:] - ends), *final),
        }
        options = {"print_time": False, "ipopt": {"print_level": 0, "sb": "yes", "mu_strategy": "adaptive"}}
        self._solve: Any = ca.nlpsol("solve", "ipopt", problem, options)

    def shortest(self, start: Start, limits: FloatArray, bends: int = 0) -> float:
        """Return the shortest time found [s] within torque limits (m,) [N m]; NaN without a solution.

        Raises
        ------
        ValueError
            If a wheel leaves its momentum limits on the way.
        """
        defects, torques = np.zeros(7 * self._intervals), np.tile(limits, self._intervals)
        momentum = start.inertia @ start.rate + self._wheels.axis_matrix @ start.momentum
        constants = np.append(np.linalg.inv(start.inertia), rotate_to_reference(start.error, momentum))
        shortest = np.nan
        for way, bend in product((1.0, -1.0), range(bends + 1)):
            time, states = self._guess(start, limits, way, 2.0 * np.pi * bend / bends if bend else None)
            bounds = np.full(states.size - 7, np.inf)  # of all but the first state, which is given
            solution = self._solve(
                x0=np.concatenate([[time], states.ravel(), 0.0 * torques]),
                p=constants,
                lbx=np.concatenate([[0.1], states[0], -bounds, -torques]),
                ubx=np.concatenate([[1e3], states[0], bounds, torques]),
                lbg=np.concatenate([defects, [-np.inf, -np.inf]]),
                ubg=np.concatenate([defects, [1.0, 1.0]]),
            )
            if self._solve.stats()["success"]:
                time = float(solution["f"])
                applied = np.asarray(solution["x"])[1 + states.size :].reshape(self._intervals, -1)
                reached = start.momentum - applied.cumsum(axis=0) * time / self._intervals
                within = bool(np.all(np.abs(reached) <= self._wheels.momentum_limits))
                require(within, "wheel_momentum", "must stay within its limits on a time-optimal turn", reached)
                shortest = float(np.fmin(shortest, time))
        return shortest

    def _guess(self, start: Start, limits: FloatArray, way: float, bend: float | None) -> tuple[float, FloatArray]:
        """Return time [s] and states (nodes, 7) of a bang-bang turn, bent aside in a direction [rad] unless None."""
        angle, axis = start.turn(way)
        time = bang_bang_time(start, way, self._wheels, limits)
        share = np.linspace(0.0, 1.0, self._intervals + 1)[:, None]
        path = angle * np.where(share < 0.5, 1.0 - 2.0 * share**2, 2.0 * (1.0 - share) ** 2) * axis
        if bend is not None:
            aside = across(axis)
            path += BEND * np.sin(np.pi * share) * (np.cos(bend) * aside + np.sin(bend) * np.cross(axis, aside))
        rate = -4.0 * angle / time * np.minimum(share, 1.0 - share) * axis
        states = np.concatenate([quaternion_from_rotation_vector(path), rate], axis=1)
        states[0] = np.append(way * canonical(start.error), start.rate)
        return time, states


def bang_bang_time(start: Start, way: float, wheels: WheelArray, limits: FloatArray) -> float:
    """Return the time of a turn from rest to rest about the axis of the error with the minimax torque [s]."""
    angle, axis = start.turn(way)
    share = np.abs(MinimaxAllocation(wheels)((start.inertia @ axis)[None])[0] / limits).max()
    return 2.0 * float(np.sqrt(angle * share))


def proven_time(start: Start, wheels: WheelArray, limits: FloatArray, success: SuccessCriterion) -> float:
    """Return a lower bound on the time of every controller with healthy wheels [s]."""
    corners = np.array(list(product((-1.0, 1.0), repeat=wheels.count))) * limits @ wheels.axis_matrix.T
    acceleration = np.sqrt(np.einsum("ci,ij,cj->c", corners, np.linalg.inv(start.inertia), corners).max())
    principal = np.linalg.eigvalsh(start.inertia)
    distance = np.sqrt(principal[0]) * max(start.turn()[0] - success.angle, 0.0)
    first, last = np.sqrt(start.rate @ start.inertia @ start.rate), np.sqrt(principal[-1]) * success.rate
    peak = np.sqrt(acceleration * distance + 0.5 * (first**2 + last**2))
    return max(float((2.0 * peak - first - last) / acceleration), 0.0)


def bias_torque(episodes: Episodes, until: FloatArray) -> FloatArray:
    """Return the most that biases add to each wheel before a time (N,) [s] of each episode, (N, m) [N m]."""
    faults = episodes.faults
    since = np.maximum(until[:, None, None] - faults["onset"], 0.0)
    swing = np.abs(faults["bias_amplitude"]) * np.maximum(since ** faults["bias_exponent"], 1.0)
    most = np.abs(faults["bias"]) + np.abs(faults["bias_slope"]) * since + swing
    added: FloatArray = np.where((faults["kind"] == FaultKind.BIAS) & (since > 0.0), most, 0.0).sum(axis=2)
    return added


def main(config: Config) -> None:
    """Solve, fly and print."""
    scenario, episodes = scenarios.get("flagship"), frozen.load("flagship", config.episodes)
    episodes = episodes[episodes.feasible]
    wheels, success, period = scenario.spacecraft.wheels, scenario.success, scenario.control_period
    limits, initial = config.torque_share * wheels.torque_limits, episodes.initial
    error = quaternion_error(initial["attitude"], episodes.set_points["attitude"][:, 0])
    drawn = (error, initial["rate"], initial["wheel_momentum"], episodes.inertia["constant"])
    starts = [Start(*values) for values in zip(*drawn, strict=True)]
    turn = TimeOptimalTurn(wheels, success, config.intervals)
    found = np.array([turn.shortest(start, limits, config.bends) for start in tqdm(starts, unit="episode")])
    solved = np.flatnonzero(~np.isnan(found))
    starts, found, episodes = [starts[k] for k in solved], found[solved], episodes[solved]
    added, helped = bias_torque(episodes, found), found.copy()
    for k in tqdm(np.flatnonzero(added.any(axis=1)), "with biases", unit="episode"):
        helped[k] = np.fmin(turn.shortest(starts[k], limits + added[k], config.bends), found[k])
    rows = {
        "time-optimal": found,
        "time-optimal, whatever the biases": helped,
        "time-optimal, in control periods": np.ceil(found / period - 1e-6) * period,
        "proven": np.array([proven_time(start, wheels, limits, success) for start in starts]),
        "bang-bang about the axis of the error": np.array([bang_bang_time(s, 1.0, wheels, limits) for s in starts]),
    }
    for name in config.baselines:
        flown = rollout(scenario, DeferredBaseline(name, "tuned"), episodes)
        rows[f"{name}, tuned"] = flown.metrics()["settling_time"]
    print(f"{len(found)} of {config.episodes} feasible episodes solved, {config.torque_share:g} of the torque; first "
          f"fault later than the optimum in {np.mean(episodes.first_onset > found):.0%}, first bias in "
          f"{np.mean(~added.any(axis=1)):.0%}")  # fmt: skip
    best, mean = float(interquartile_mean(found)), float(found.mean())
    heading = "interq. mean    mean  median   optimum shorter by: interq. mean    mean  sooner in"
    print(f"{'settling time [s]':40s} {heading}")
    for name, values in rows.items():
        middle, sooner = float(interquartile_mean(values)), int((values < helped - 0.01).sum())
        print(f"{name:40s} {middle:12.2f} {values.mean():7.2f} {np.median(values):7.2f} {1.0 - best / middle:33.1%} "
              f"{1.0 - mean / values.mean():7.1%} {sooner:10d}")  # fmt: skip


if __name__ == "__main__":
    run_program(main, Config, __doc__)
