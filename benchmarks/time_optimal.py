"""How short settling can be at all: time-optimal turns of the flagship's frozen episodes, beside what controllers take.

For each episode the shortest time is sought in which ideal, healthy wheels bring the true craft from its start into the
success cone at rest: J w' = -w x (J w + D h) + D u, h' = -u, |u| and |h| within their limits; no noise, no disturbance,
no fault. By direct multiple shooting with Runge-Kutta steps and a free end time, solved by IPOPT (CasADi). A local
optimum is an upper bound of the optimum; both ways round are tried. Faults take torque away: for episodes whose first
fault comes later than this time it is a bound, for the others nearly so.

Needs CasADi, which the package does not: pip install casadi

Example
-------
    python benchmarks/time_optimal.py --episodes 60
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import tyro
from tqdm import tqdm

from ftac_gym import scenarios
from ftac_gym.attitude import quaternion_error
from ftac_gym.baselines.allocation import MinimaxAllocation
from ftac_gym.evaluation import BaselineContestant, interquartile_mean, rollout
from ftac_gym.parameters import FloatArray
from ftac_gym.scenarios import frozen


@dataclass(frozen=True)
class Config:
    """What to solve."""

    episodes: int = 60
    """Feasible episodes, the first of the frozen ones."""
    intervals: int = 50
    """Intervals of constant torque."""
    torque_share: float = 1.0
    """Share of the torque limits that may be used: less for a margin."""
    baselines: tuple[str, ...] = ("pd_dob", "nftsm_observer", "nftsm_oracle")
    """Tuned controllers to compare with."""


class Solver:
    """The minimum-time problem of one craft, built once and solved for many starts.

    Parameters
    ----------
    axes
        (3, m) wheel axes.
    torque_limits, momentum_limits
        (m,) [N m], [N m s].
    angle, rate
        The success cone [rad], [rad/s].
    intervals
        Intervals of constant torque.
    """

    def __init__(
        self, axes: FloatArray, torque_limits: FloatArray, momentum_limits: FloatArray, angle: float, rate: float,
        intervals: int,
    ) -> None:  # fmt: skip
        try:
            import casadi as ca
        except ImportError:
            raise SystemExit("this benchmark needs CasADi: pip install casadi") from None
        wheels = axes.shape[1]
        self._wheels, self._intervals, self._axes = wheels, intervals, axes
        self._angle = angle
        state, torque, inertia = ca.SX.sym("x", 7 + wheels), ca.SX.sym("u", wheels), ca.SX.sym("J", 3, 3)
        q, w, h = state[:4], state[4:7], state[7:]
        total = inertia @ w + ca.DM(axes) @ h
        rates = ca.vertcat(
            -0.5 * ca.dot(q[1:], w),
            0.5 * (q[0] * w + ca.cross(q[1:], w)),
            ca.solve(inertia, ca.DM(axes) @ torque - ca.cross(w, total)),
            -torque,
        )
        field = ca.Function("field", [state, torque, inertia], [rates])
        step = ca.SX.sym("dt")
        k1 = field(state, torque, inertia)
        k2 = field(state + 0.5 * step * k1, torque, inertia)
        k3 = field(state + 0.5 * step * k2, torque, inertia)
        k4 = field(state + step * k3, torque, inertia)
        following = state + step / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
        advance = ca.Function("advance", [state, torque, inertia, step], [following])
        time, states = ca.MX.sym("T"), ca.MX.sym("X", 7 + wheels, intervals + 1)
        torques, craft = ca.MX.sym("U", wheels, intervals), ca.MX.sym("J", 3, 3)
        ends = advance.map(intervals)(
            states[:, :-1], torques, ca.repmat(craft, 1, intervals), ca.repmat(time / intervals, 1, intervals)
        )
        last = states[:, -1]
        constraints = ca.vertcat(
            ca.vec(states[:, 1:] - ends), ca.dot(last[1:4], last[1:4]) / np.sin(0.5 * angle) ** 2,
            ca.dot(last[4:7], last[4:7]) / rate**2,
        )  # fmt: skip
        problem = {"x": ca.vertcat(time, ca.vec(states), ca.vec(torques)), "p": ca.vec(craft), "f": time,
                   "g": constraints}  # fmt: skip
        quiet = {"ipopt.print_level": 0, "print_time": False, "ipopt.sb": "yes", "ipopt.max_iter": 400}
        self._solve = ca.nlpsol("solve", "ipopt", problem, quiet)
        free = np.inf * np.ones((7 + wheels, intervals + 1))
        free[7:] = momentum_limits[:, None]
        self._state_bounds = free
        self._torque_bounds = np.repeat(torque_limits, intervals)
        self._defects = (7 + wheels) * intervals

    def shortest(self, start: FloatArray, inertia: FloatArray, guess: float) -> float:
        """Return the shortest time found from a start (7 + m,) [s]; NaN if none was."""
        times = []
        for sign in (1.0, -1.0):
            begin = start.copy()
            begin[:4] *= sign
            share = np.linspace(0.0, 1.0, self._intervals + 1)
            turn = 2.0 * np.arccos(np.clip(begin[0], -1.0, 1.0)) * (1.0 - share)
            axis = begin[1:4] / max(float(np.linalg.norm(begin[1:4])), 1e-12)
            states = np.tile(begin, (self._intervals + 1, 1)).T
            states[0], states[1:4] = np.cos(0.5 * turn), axis[:, None] * np.sin(0.5 * turn)
            span = guess if sign > 0.0 else 1.5 * guess
            speed = turn[0] / span * np.minimum(4.0 * share, 4.0 * (1.0 - share))
            states[4:7] = -axis[:, None] * speed
            states[:, 0] = begin
            low, high = -self._state_bounds, self._state_bounds.copy()
            low[:, 0] = high[:, 0] = begin
            solution = self._solve(
                x0=np.concatenate([[span], states.T.ravel(), np.zeros(self._wheels * self._intervals)]),
                p=inertia.T.ravel(),
                lbx=np.concatenate([[0.1], low.T.ravel(), -self._ordered()]),
                ubx=np.concatenate([[400.0], high.T.ravel(), self._ordered()]),
                lbg=np.concatenate([np.zeros(self._defects), [-np.inf, -np.inf]]),
                ubg=np.concatenate([np.zeros(self._defects), [1.0, 1.0]]),
            )
            if self._solve.stats()["success"]:
                times.append(float(solution["f"]))
        return min(times, default=float("nan"))

    def _ordered(self) -> Any:
        """Return the torque bounds, interval by interval."""
        return self._torque_bounds.reshape(self._wheels, self._intervals).T.ravel()


def main(config: Config) -> None:
    """Solve, fly and print."""
    scenario, episodes = scenarios.get("flagship"), frozen.load("flagship", config.episodes)
    wheels, success = scenario.spacecraft.wheels, scenario.success
    limits = config.torque_share * wheels.torque_limits
    solver = Solver(
        wheels.axis_matrix, limits, wheels.momentum_limits, success.angle, success.rate, config.intervals
    )  # fmt: skip
    feasible = episodes.feasible
    error = quaternion_error(episodes.initial["attitude"], episodes.set_points["attitude"][:, 0])[feasible]
    error *= np.where(error[:, :1] < 0.0, -1.0, 1.0)
    inertia = episodes.inertia["constant"][feasible]
    start = np.concatenate(
        [error, episodes.initial["rate"][feasible], episodes.initial["wheel_momentum"][feasible]], axis=1
    )
    sine = np.linalg.norm(error[:, 1:], axis=1)
    angle, axis = 2.0 * np.arctan2(sine, error[:, 0]), error[:, 1:] / np.maximum(sine, 1e-12)[:, None]
    needed = np.abs(MinimaxAllocation(wheels)(np.einsum("nij,nj->ni", inertia, axis)) / limits).max(axis=1)
    eigenaxis = 2.0 * np.sqrt(angle * needed)
    rows = zip(start, inertia, eigenaxis, strict=True)
    found = np.array([solver.shortest(*row) for row in tqdm(rows, total=len(start), unit="episode")])
    solved = ~np.isnan(found)
    print(f"{config.episodes} feasible episodes of the flagship, {config.torque_share:g} of the torque; "
          f"{int(solved.sum())} solved; in {np.mean((episodes.first_onset[feasible] > found)[solved]):.0%} of them the "
          "first fault comes later")  # fmt: skip
    known = {"time-optimal": found, "about the axis of the error, bang-bang": eigenaxis}
    for name in config.baselines:
        flown = rollout(scenario, BaselineContestant(name, "tuned"), episodes)
        known[f"{name}, tuned"] = flown.metrics()["settling_time"][feasible]
    best = float(interquartile_mean(found[solved]))
    print(f"{'':42s} interquartile mean [s]   median [s]   time-optimal is shorter by")
    for name, values in known.items():
        middle = float(interquartile_mean(values[solved]))
        print(f"{name:42s} {middle:22.2f} {np.median(values[solved]):12.2f} {1.0 - best / middle:28.1%}")


if __name__ == "__main__":
    main(tyro.cli(Config, description=__doc__))
