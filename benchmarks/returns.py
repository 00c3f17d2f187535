"""Table of returns: undiscounted returns of zero action, random action, baselines and agents on every environment id.

    python benchmarks/returns.py                            # all ids; writes docs/environments/returns.csv
    python benchmarks/returns.py --ids SpacecraftFTC-v0     # some ids; the others keep their lines

The best baseline of an id is chosen on episodes of another seed than those of the table. A tumble ends the return, as
it ends the episode of the environment.
"""

import argparse
import csv
import time
from collections.abc import Iterable
from pathlib import Path

import gymnasium as gym
import numpy as np

import ftac_gym  # noqa: F401  registers the environments
from ftac_gym import baselines, scenarios
from ftac_gym.dynamics import DivergenceError
from ftac_gym.evaluation import estimate, rollout
from ftac_gym.policies.policy import TUNED
from ftac_gym.task import Scenario
from ftac_gym.utils.parameters import FloatArray

FILE = Path(__file__).parents[1] / "docs" / "environments" / "returns.csv"
COLUMNS = ("id", "role", "policy", "mean", "low", "high", "episodes")
AGENTS = {"flagship": "agent", "flexible": "agent"}
"""Scenarios that an agent of the package was trained for."""

OURS = ("pd", "pd_dob", "pd_shaped", "nftsm")
"""Baselines to choose from where episodes differ, with default and tuned gains: the leading ones of the results."""


def returns(scenario: Scenario, policy: str, seed: int, count: int) -> FloatArray:
    """Return the undiscounted returns (N,) of a policy on episodes 0 to ``count - 1`` of a seed."""
    history = rollout(scenario, policy, seed=seed, count=count)
    limit = np.inf if scenario.tumble_rate is None else scenario.tumble_rate
    tumbling = np.linalg.norm(history.rate[1:], axis=2) > limit
    before = np.cumsum(tumbling, axis=0) - tumbling
    return np.where(before == 0, history.reward, 0.0).sum(axis=0)


def candidates(scenario: Scenario) -> list[str]:
    """Return the baselines that the best one is chosen from: without the oracles, which have the true faults."""
    if varies(scenario):
        return [*OURS, *(name + TUNED for name in OURS)]
    return [name for name in baselines.names() if not name.endswith("_oracle")]


def varies(scenario: Scenario) -> bool:
    """Return whether episodes differ from one another in more than the noise of the sensors."""
    first, second = scenario.draw(0, 1), scenario.draw(0, 2)[1]
    ours, theirs = first.arrays(), second.arrays()
    return any(not np.array_equal(ours[name], theirs[name]) for name in ours if name not in ("key", "index"))


def best(scenario: Scenario, names: Iterable[str], seed: int, count: int) -> str:
    """Return the baseline with the largest mean return; those that do not fit or diverge are left out."""
    means: dict[str, float] = {}
    for name in names:
        try:
            means[name] = float(returns(scenario, name, seed, count).mean())
        except (ValueError, DivergenceError):
            continue
    return max(means, key=means.__getitem__)


def measure(environment_id: str, seed: int, count: int) -> list[list[str]]:
    """Return the lines of an id."""
    name = gym.spec(environment_id).kwargs["default_scenario"]
    scenario = scenarios.get(name)
    drawn = count if varies(scenario) else 1
    chosen = best(scenario, candidates(scenario), seed + 1, max(1, drawn // 8))
    rows = [("zero", "zero"), ("random", "random"), ("pd", "pd"), ("best baseline", chosen)]
    rows += [("agent", AGENTS[name])] if name in AGENTS else []
    lines = []
    for role, policy in rows:
        start = time.perf_counter()
        values = returns(scenario, policy, seed, drawn)
        item = estimate(values)
        interval = (item.value, item.low, item.high) if drawn > 1 else (item.value,) * 3
        lines.append([environment_id, role, policy, *(f"{value:.1f}" for value in interval), str(drawn)])
        print(*lines[-1], f"{time.perf_counter() - start:.0f} s", flush=True)
    return lines


def main() -> None:
    """Measure and write the table."""
    known = [name for name in gym.registry if name.startswith("SpacecraftFTC")]
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--ids", nargs="*", default=known, choices=known)
    parser.add_argument("--episodes", type=int, default=200)
    parser.add_argument("--seed", type=int, default=700_000)
    parser.add_argument("--file", type=Path, default=FILE)
    given = parser.parse_args()
    kept: dict[str, list[list[str]]] = {}
    if given.file.exists():
        for line in list(csv.reader(given.file.read_text(encoding="utf-8").splitlines()))[1:]:
            kept.setdefault(line[0], []).append(line)
    for environment_id in given.ids:
        kept[environment_id] = measure(environment_id, given.seed, given.episodes)
        with given.file.open("w", encoding="utf-8", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows(
                [COLUMNS, *(line for name in known for line in kept.get(name, []))]
            )


if __name__ == "__main__":
    main()
