"""Optimal-control solver that says whether episodes can be passed, beside the feasibility label and flown policies.

All faults, the true inertia, the true wheel axes and the disturbance are known to it. For each episode it searches a
flight from the start into the success criterion. The share of the last ``hold`` seconds that may be missed is their
beginning, in which the spacecraft is within ``limit`` cones; then every time is on target.

The method is direct multiple shooting. The grid has the times at which faults switch. In each interval every wheel has
a constant torque, within the bounds of its effectiveness, bias, friction and power limit. Wheels that follow no command
have the torque of their fault. A locked one keeps that of the interval before the onset. A seizing one has that of its
brake, and one with a bias this bias until the momentum limit. Attitude, rate and momenta follow by Runge-Kutta steps.

IPOPT (CasADi) minimises the distance from the target in the window. The first guesses are the flight of the label, and
turns about the axis of the error: fast, slow, and the long way round. ``passes`` means that one of them converged to a
flight on target, with a residual of 1e-6. ``impossible`` means that none did, within its limits of iterations and time:
evidence, and no proof.

CasADi is no dependency of the package: pip install casadi

The script draws episodes of :func:`cases` and flies policies through them. It solves feasible ones that no policy
passes, and infeasible ones. ``tests/task/test_feasibility_verdicts.py`` compares the file ``--output`` with the label.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ftac_gym import scenarios
from ftac_gym.attitude import (
    quaternion_error,
    quaternion_from_rotation_vector,
    quaternion_product,
    rotate_to_body,
    rotate_to_reference,
    rotation_vector_from_quaternion,
)
from ftac_gym.evaluation import rollout
from ftac_gym.faults.effect import fault_effect, presence
from ftac_gym.policies import DeferredBaseline
from ftac_gym.task import MRPSinusoid, Scenario
from ftac_gym.task.episodes import Episodes
from ftac_gym.task.feasibility import flights, reference_motion
from ftac_gym.utils.console import run_program
from ftac_gym.utils.directions import across
from ftac_gym.utils.parameters import FloatArray

BEND = 0.6
"""Largest distance of the bent first guesses from the straight turn [rad]."""

SEED = 777
"""Seed of the episodes."""


@dataclass(frozen=True)
class Config:
    """Episodes, discretisation, and policies to compare with."""

    episodes: int = 300
    """Drawn episodes of each case, which the policies fly."""
    feasible: int = 5
    """Episodes of each case for the solver, of the feasible ones that no policy passes."""
    infeasible: int = 5
    """Episodes of each case for the solver, of the infeasible ones."""
    intervals: int = 90
    """Intervals of constant torque."""
    policies: tuple[str, ...] = ("pd_dob", "nftsm_oracle", "nftsm_telemetry")
    """Tuned baselines that fly."""
    cases: tuple[str, ...] = ()
    """Cases to take; all by default."""
    output: Path | None = None
    """File for the verdicts. Those that it has of the same scenario are kept, and not solved again."""


def cases() -> dict[str, Scenario]:
    """Return the scenarios of the comparison: the splits, and harder variants of them."""
    flagship, hardware = scenarios.get("flagship"), scenarios.get("flagship_hardware")
    tracking, unseen = scenarios.get("flagship_tracking"), scenarios.get("flagship_unseen")
    random = np.random.default_rng(3).normal(size=(3, 4))
    tilt = 0.3 * random / np.linalg.norm(random, axis=0)
    slow = replace(hardware.spacecraft.wheels, power_limit=25.0)
    swing, frequency, phase = (0.1, 0.3), (0.03, 0.12), (0.0, 2.0 * np.pi)
    fast = MRPSinusoid(amplitude=(swing,) * 3, frequency=(frequency,) * 3, phase=(phase,) * 3)
    listed = [
        *(scenarios.get(f"flagship{name}") for name in ("", "_severe", "_double", "_unseen", "_hardware", "_tracking")),
        *(stored(flagship, momentum) for momentum in (4.0, 8.0, 12.0)),
        stored(unseen, 6.0),
        stored(tracking, 6.0),
        flagship.replace(name="flagship_short", duration=55.0),
        stored(flagship, 3.0).replace(name="flagship_misaligned", misalignment=tilt),
        stored(hardware, 8.0).replace(name="hardware_power", spacecraft=replace(hardware.spacecraft, wheels=slow)),
        tracking.replace(name="tracking_fast", reference=fast),
    ]
    return {item.name: item.replace(loop_delay=0.0, extra_delay=0) for item in listed}


def bare(scenario: Scenario) -> Scenario:
    """Return a scenario without what the label leaves out."""
    return scenario.replace(sensors=None)


def stored(scenario: Scenario, momentum: float) -> Scenario:
    """Return a scenario whose wheels start with up to a momentum [N m s]."""
    state = replace(scenario.initial_state, wheel_momentum=(-momentum, momentum))
    return scenario.replace(name=f"{scenario.name}_stored_{momentum:g}", initial_state=state)


@dataclass(frozen=True)
class Problem:
    """One episode on a grid of K intervals.

    Attributes
    ----------
    times
        (K + 1,) [s].
    target, target_rate
        (K + 1, 4) attitude of the reference, and (K + 1, 3) its rate in its own axes [rad/s].
    effectiveness, bias, locked, brake, rubbing
        (K, m) state of the wheels in each interval: torques [N m], ``rubbing`` a factor on the dry friction.
    external
        (K, 3) disturbance [N m].
    attitude, rate, momentum, inertia
        The start, (4,), (3,), (m,), and the true inertia (3, 3).
    """

    times: FloatArray
    target: FloatArray
    target_rate: FloatArray
    effectiveness: FloatArray
    bias: FloatArray
    locked: FloatArray
    brake: FloatArray
    rubbing: FloatArray
    external: FloatArray
    attitude: FloatArray
    rate: FloatArray
    momentum: FloatArray
    inertia: FloatArray

    @classmethod
    def of(cls, scenario: Scenario, episode: Episodes, intervals: int) -> Problem:
        """Return the problem of one episode."""
        success, duration, wheels = scenario.success, scenario.duration, scenario.spacecraft.wheels
        begin = duration - success.hold
        fixed = [begin, begin + (1.0 - success.share) * success.hold]
        times = snapped(np.linspace(0.0, duration, intervals + 1), [*fixed, *switching_times(episode, duration)])
        middle = 0.5 * (times[1:] + times[:-1])
        many = episode[np.zeros(intervals, dtype=int)]
        still = np.zeros((intervals, wheels.count))
        part = presence(many.faults, many.switches, middle)
        effect = fault_effect(many.drawn_faults, middle, wheels, still + 1e-9, still)
        stuck = (part > 0.0) & ((many.faults["locked"] > 0.5) | (many.faults["brake"] > 0.0))
        risen = np.maximum(many.faults["friction_forward"], many.faults["friction_backward"])
        rubbing = 1.0 + part * (risen - 1.0)
        harmonics, angle = episode.harmonics[0], middle[:, None] * episode.harmonics["frequency"][0]
        external = episode.disturbance["constant"][0] + np.sin(angle) @ harmonics["sine"]
        target, target_rate = followed(scenario, episode, times)
        return cls(
            times=times,
            target=target,
            target_rate=target_rate,
            effectiveness=effect.effectiveness,
            bias=np.where(stuck.any(axis=2), 0.0, effect.bias),
            locked=((part > 0.0) & (many.faults["locked"] > 0.5)).any(axis=2).astype(float),
            brake=np.where(part > 0.0, many.faults["brake"], 0.0).sum(axis=2),
            rubbing=rubbing.prod(axis=2),
            external=external + np.cos(angle) @ harmonics["cosine"],
            attitude=episode.initial["attitude"][0],
            rate=episode.initial["rate"][0],
            momentum=episode.initial["wheel_momentum"][0],
            inertia=episode.inertia["constant"][0],
        )


def switching_times(episode: Episodes, duration: float) -> list[float]:
    """Return the times at which faults of wheels switch on and off [s]."""
    found: set[float] = set()
    for fault in episode.faults.ravel():
        if fault["kind"] == 0 or fault["onset"] >= duration:
            continue
        found |= {fault["onset"], min(fault["recovery"], duration)}
        if fault["period"] > 0.0:
            starts = np.arange(fault["onset"], min(fault["recovery"], duration), fault["period"])
            found |= {*starts, *(starts + fault["on_time"])}
        if fault["chain"] >= 0:
            found |= set(episode.switches[0, fault["chain"]])
    return sorted(time for time in found if 0.0 < time < duration)


def snapped(times: FloatArray, fixed: list[float]) -> FloatArray:
    """Return times with the nearest inner one moved to each fixed time, the first ones first."""
    moved, free = times.copy(), np.ones(len(times), dtype=bool)
    free[[0, -1]] = False
    for time in fixed:
        nearest = int(np.argmin(np.where(free, np.abs(times - time), np.inf)))
        if abs(times[nearest] - time) < times[1] - times[0]:
            moved[nearest], free[nearest] = time, False
    return np.maximum.accumulate(np.sort(moved) + 1e-3 * np.arange(len(times)) / len(times))


def followed(scenario: Scenario, episode: Episodes, times: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return attitude (T, 4) and rate (T, 3) [rad/s] of the reference at times (T,) [s]."""
    fine = np.unique(np.concatenate([times, np.arange(0.0, times[-1], 0.02)]))
    aims, rates = reference_motion(scenario.reference, episode, fine)
    if not rates.shape[1]:
        points = episode.set_points[0]
        return points["attitude"][np.searchsorted(points["time"], times + 1e-9) - 1], np.zeros((len(times), 3))
    attitude, turns = [aims[0]], 0.5 * (rates[0, 1:] + rates[0, :-1]) * np.diff(fine)[:, None]
    for turn in quaternion_from_rotation_vector(turns):
        attitude.append(quaternion_product(attitude[-1], turn))
    chosen = np.searchsorted(fine, times)
    return np.array(attitude)[chosen], rates[0, chosen]


class Solver:
    """The problem of a scenario, built once.

    Parameters
    ----------
    scenario
        The scenario.
    intervals
        Intervals of constant torque.
    """

    def __init__(self, scenario: Scenario, intervals: int) -> None:
        try:
            import casadi as ca
        except ImportError:
            raise SystemExit("this benchmark needs CasADi: pip install casadi") from None
        self.scenario, self.intervals = scenario, intervals
        wheels, success = scenario.spacecraft.wheels, scenario.success
        axes = wheels.axis_matrix + (0.0 if scenario.misalignment is None else np.array(scenario.misalignment))
        self._axes, m = axes, wheels.count
        coupled = float(wheels.momentum_coupling)
        inverse_inertia = 1.0 / wheels.spin_inertias
        coulomb = np.array([0.0 if item is None else item.coulomb for item in wheels.frictions])
        viscous = np.array([0.0 if item is None else item.viscous for item in wheels.frictions])
        self._powered = bool(np.isfinite(wheels.power_limits).all())
        self._most = wheels.torque_limits
        edge = np.minimum(wheels.momentum_limits, 1e6)

        q, w, h = ca.SX.sym("q", 4), ca.SX.sym("w", 3), ca.SX.sym("h", m)
        torque, external, step, inertia = ca.SX.sym("t", m), ca.SX.sym("d", 3), ca.SX.sym("s"), ca.SX.sym("J", 3, 3)
        inverse = ca.SX.sym("I", 3, 3)
        bent = ca.cross(w, inertia @ w + coupled * (ca.DM(axes) @ h))
        change = ca.vertcat(
            -0.5 * ca.dot(q[1:], w),
            0.5 * (q[0] * w + ca.cross(q[1:], w)),
            inverse @ (ca.DM(axes) @ torque + external - bent),
            -torque,
        )
        state, given = ca.vertcat(q, w, h), ca.vertcat(torque, external, step, ca.vec(inertia), ca.vec(inverse))
        field = ca.Function("field", [state, given], [change])
        now = state
        for _ in range(2):
            k1 = field(now, given)
            k2 = field(now + 0.25 * step * k1, given)
            k3 = field(now + 0.25 * step * k2, given)
            k4 = field(now + 0.5 * step * k3, given)
            now = now + step / 12.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
        advance = ca.Function("advance", [state, given], [now]).map(intervals)

        before, after, last = h, ca.SX.sym("a", m), ca.SX.sym("l", m)
        bias, locked, brake, dead, rub = (ca.SX.sym(name, m) for name in "bzkex")

        def limited(value: Any, bottom: Any, top: Any) -> Any:
            """Return a value between bounds, smooth to 1e-4."""
            upper = 0.5 * (value + top - ca.sqrt((value - top) ** 2 + 1e-8))
            return 0.5 * (upper + bottom + ca.sqrt((upper - bottom) ** 2 + 1e-8))

        middle = 0.5 * (before + after)
        friction = ca.tanh(middle / 0.02) * coulomb * rub + viscous * inverse_inertia * middle
        held = limited(bias + friction, (before - edge) / step, (before + edge) / step)
        braked = limited(before / step, -brake, brake)
        own = ca.if_else(locked > 0.5, last, ca.if_else(brake > 0.0, braked, held))
        rule = ca.if_else(dead > 0.5, torque - own, torque - bias - friction)
        power = ca.vertcat(*((torque - friction) * momentum * inverse_inertia for momentum in (before, after)))
        names = [torque, before, after, last, step, bias, locked, brake, dead, rub]
        rules = ca.Function("rules", names, [rule, power]).map(intervals)

        aim, aim_rate = ca.SX.sym("aim", 4), ca.SX.sym("aim_rate", 3)
        scalar = ca.dot(aim, q)
        vector = aim[0] * q[1:] - q[0] * aim[1:] - ca.cross(aim[1:], q[1:])
        twice = 2.0 * ca.cross(vector, aim_rate)
        relative = w - (aim_rate - scalar * twice + ca.cross(vector, twice))
        offsets = [vector / np.sin(0.5 * success.angle), relative / success.rate]
        miss = ca.Function("miss", [state, aim, aim_rate], offsets).map(intervals + 1)

        states, torques = ca.MX.sym("states", 7 + m, intervals + 1), ca.MX.sym("torques", m, intervals)
        slack = ca.MX.sym("slack", 2, intervals + 1)
        table = ca.MX.sym("table", 5 * m + 4, intervals)  # bias, locked, brake, dead, rubbing, disturbance, step
        aims, fixed = ca.MX.sym("aims", 7, intervals + 1), ca.MX.sym("fixed", 18)
        weight = ca.MX.sym("weight", intervals + 1)
        ends = advance(states[:, :-1], ca.vertcat(torques, table[5 * m :, :], ca.repmat(fixed, 1, intervals)))
        lasts = ca.horzcat(ca.DM.zeros(m, 1), torques[:, :-1])
        columns = [table[m * i : m * (i + 1), :] for i in range(5)]
        rule_values, power_values = rules(torques, states[7:, :-1], states[7:, 1:], lasts, table[-1, :], *columns)
        angle, rate = miss(states, aims[:4, :], aims[4:, :])
        off = ca.vertcat(ca.sum1(angle**2), ca.sum1(rate**2)) - 1.0 - 100.0 * slack
        effort = ca.sumsqr(torques / np.mean(wheels.torque_limits)) / intervals
        problem = {
            "x": ca.vertcat(ca.vec(states), ca.vec(torques), ca.vec(slack)),
            "p": ca.vertcat(ca.vec(table), ca.vec(aims), fixed, weight),
            "f": ca.dot(weight, ca.sum1(slack).T) + 1e-4 * effort,
            "g": ca.vertcat(
                ca.vec(states[:, 1:] - ends),
                ca.vec(rule_values),
                ca.vec(off),
                *([ca.vec(power_values)] if self._powered else []),
            ),
        }
        ipopt = {"print_level": 0, "sb": "yes", "mu_strategy": "adaptive", "max_iter": 500, "tol": 1e-6,
                 "acceptable_tol": 1e-4, "acceptable_constr_viol_tol": 1e-6, "max_cpu_time": 60.0}  # fmt: skip
        self._solve: Any = ca.nlpsol("solve", "ipopt", problem, {"print_time": False, "ipopt": ipopt})

    def passes(self, episode: Episodes, guesses: int = 4) -> bool:
        """Return whether a flight passes one episode."""
        scenario, wheels, success = self.scenario, self.scenario.spacecraft.wheels, self.scenario.success
        problem, intervals, m = Problem.of(scenario, episode, self.intervals), self.intervals, wheels.count
        dead = (problem.effectiveness == 0.0) | (problem.locked > 0.5) | (problem.brake > 0.0)
        given = problem.bias, problem.locked, problem.brake, dead, problem.rubbing, problem.external
        table = np.concatenate([*given, np.diff(problem.times)[:, None]], axis=1)
        begin = scenario.duration - success.hold
        window = problem.times > begin + (1.0 - success.share) * success.hold - 1e-2
        early = (problem.times > begin - 1e-2) & ~window
        weight = np.where(window, 1.0, 0.0)
        aims = np.concatenate([problem.target, problem.target_rate], axis=1)
        fixed = np.concatenate([problem.inertia.ravel(), np.linalg.inv(problem.inertia).ravel()])
        edge = np.minimum(wheels.momentum_limits, 1e6)
        start = np.concatenate([problem.attitude, problem.rate, problem.momentum])
        high = np.tile(np.append(np.full(7, np.inf), edge), (intervals + 1, 1))
        low = -high
        low[0] = high[0] = start
        bound = np.where(dead, 0.0, np.abs(problem.effectiveness) * self._most)
        # Early in the window the angle may reach its largest value, and the rate any.
        farthest, off = np.full((intervals + 1, 2), np.inf), np.full((intervals + 1, 2), np.inf)
        largest = np.sin(0.5 * min(success.largest_error, np.pi)) / np.sin(0.5 * success.angle)
        farthest[early | window, 0] = largest**2 / 100.0
        off[early, 0], off[window] = 0.0, 0.0
        widest = np.maximum(np.abs(problem.bias) + wheels.torque_limits, problem.brake) * 2.0 + 1.0
        power = np.tile(wheels.power_limits, 2 * intervals) if self._powered else np.empty(0)
        for number in range(guesses):
            states, torques = self._guess(problem, number) if number else self._labelled(problem, episode)
            states[0] = start
            solution = self._solve(
                x0=np.concatenate([states.ravel(), torques.ravel(), np.zeros(2 * (intervals + 1))]),
                p=np.concatenate([table.ravel(), aims.ravel(), fixed, weight]),
                lbx=np.concatenate([low.ravel(), -widest.ravel(), np.zeros(2 * (intervals + 1))]),
                ubx=np.concatenate([high.ravel(), widest.ravel(), farthest.ravel()]),
                lbg=np.concatenate(
                    [np.zeros((7 + m) * intervals), -bound.ravel(), np.full(2 * (intervals + 1), -np.inf), -power]
                ),
                ubg=np.concatenate([np.zeros((7 + m) * intervals), bound.ravel(), off.ravel(), power]),
            )
            slack = np.asarray(solution["x"]).ravel()[-2 * (intervals + 1) :].reshape(-1, 2)
            if self._solve.stats()["success"] and slack[window].max() < 1e-4:
                return True
        return False

    def _labelled(self, problem: Problem, episode: Episodes) -> tuple[FloatArray, FloatArray]:
        """Return states (K + 1, 7 + m) and torques (K, m) of the flight of the label."""
        _, times, path = flights(self.scenario, episode)
        values = np.stack([np.interp(problem.times, times, column) for column in path.T], axis=1)
        turn = quaternion_from_rotation_vector(values[:, :3])
        rate = values[:, 3:6] + rotate_to_body(turn, problem.target_rate)
        torque = -np.diff(values[:, 6:], axis=0) / np.diff(problem.times)[:, None]
        return np.concatenate([quaternion_product(problem.target, turn), rate, values[:, 6:]], axis=1), torque

    def _guess(self, problem: Problem, number: int) -> tuple[FloatArray, FloatArray]:
        """Return states (K + 1, 7 + m) and torques (K, m) of a turn; the number chooses its way, speed and bend."""
        times, success = problem.times, self.scenario.success
        error = rotation_vector_from_quaternion(quaternion_error(problem.attitude, problem.target[0]))
        angle = float(np.linalg.norm(error))
        axis = error / angle if angle > 1e-9 else np.array([1.0, 0.0, 0.0])
        ways = (1, 0.95, None), (1, 0.5, None), (-1, 0.95, None), (1, 0.95, 0.0), (1, 0.95, np.pi)
        way, pace, bend = ways[number - 1]
        if way < 0:
            angle, axis = 2.0 * np.pi - angle, -axis
        share = np.clip(times / (pace * (times[-1] - success.hold)), 0.0, 1.0)[:, None]
        path = angle * (1.0 - share**2 * (3.0 - 2.0 * share)) * axis
        if bend is not None:
            aside = across(axis)
            path = path + BEND * np.sin(np.pi * share) * (np.cos(bend) * aside + np.sin(bend) * np.cross(axis, aside))
        attitude = quaternion_product(problem.target, quaternion_from_rotation_vector(path))
        rate = np.zeros((len(times), 3))
        turn = quaternion_error(attitude[1:], attitude[:-1])
        rate[1:] = rotation_vector_from_quaternion(turn) / np.diff(times)[:, None]
        total = rotate_to_reference(problem.attitude, problem.inertia @ problem.rate + self._axes @ problem.momentum)
        needed = rotate_to_body(attitude, np.tile(total, (len(times), 1))) - rate @ problem.inertia
        spread = np.linalg.pinv(self._axes)
        momentum = (problem.momentum - spread @ (self._axes @ problem.momentum)) + needed @ spread.T
        limit = 0.95 * np.minimum(self.scenario.spacecraft.wheels.momentum_limits, 1e6)
        momentum = np.clip(momentum, -limit, limit)
        torque = -np.diff(momentum, axis=0) / np.diff(times)[:, None]
        return np.concatenate([attitude, rate, momentum], axis=1), np.clip(torque, -self._most, self._most)


def passed_by(scenario: Scenario, episodes: Episodes, names: tuple[str, ...]) -> np.ndarray:
    """Return which episodes at least one policy passes, (N,)."""
    best = np.zeros(len(episodes), dtype=bool)
    for name in names:
        best |= rollout(scenario, DeferredBaseline(name, "tuned"), episodes).metrics()["success"] > 0.5
    return best


def chosen(mask: np.ndarray, count: int) -> list[int]:
    """Return a number of the episodes of a mask (N,), spread over all of them."""
    found = np.flatnonzero(mask)
    return found[np.unique(np.linspace(0, len(found) - 1, min(count, len(found))).astype(int))].tolist()


def verdicts_in(path: Path | None) -> dict[str, dict[str, Any]]:
    """Return the verdicts of a file, empty without one."""
    return json.loads(path.read_text(encoding="utf-8")) if path is not None and path.exists() else {}


def main(config: Config) -> None:
    """Draw, fly, solve, print and write."""
    verdicts = verdicts_in(config.output)
    for name, scenario in cases().items():
        if config.cases and name not in config.cases:
            continue
        episodes = scenario.draw(SEED, config.episodes)
        feasible, passed = episodes.feasible, passed_by(scenario, episodes, config.policies)
        print(f"{name}: {feasible.mean():.3f} feasible, {passed.mean():.3f} passed by a policy, "
              f"{np.mean(~feasible & passed):.4f} infeasible and passed", flush=True)  # fmt: skip
        solver = Solver(scenario, config.intervals)
        described = bare(scenario).to_dict()
        entry = verdicts.get(name, {})
        if entry.get("scenario") != described:
            entry = {"scenario": described, "passes": [], "impossible": []}
        verdicts[name] = entry
        for index in [*chosen(feasible & ~passed, config.feasible), *chosen(~feasible, config.infeasible)]:
            if index in entry["passes"] + entry["impossible"]:
                continue
            possible = bool(passed[index]) or solver.passes(episodes[index])
            entry["passes" if possible else "impossible"].append(index)
            print(f"  {index:4d} label {feasible[index]:d} policy {passed[index]:d} solver {possible:d}", flush=True)
            numbers = np.array(entry["passes"] + entry["impossible"], dtype=np.int64)
            solved = bare(scenario).draw_episodes([SEED] * len(numbers), numbers)
            entry["digest"] = replace(solved, feasible=np.zeros(len(numbers), dtype=bool)).digest()
            if config.output is not None:
                config.output.write_text(json.dumps(verdicts, separators=(",", ":")) + "\n", encoding="utf-8")


if __name__ == "__main__":
    run_program(main, Config, __doc__)
