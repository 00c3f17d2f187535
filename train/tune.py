"""Tune the gains of a baseline on the training split, for the agents' objective: the mean return.

Prints the best gains found, and how far they got on episodes that the search did not see.

Example
-------
    python train/tune.py --baseline pd_dob --generations 12
"""

from __future__ import annotations

import json
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import tyro
from scipy.optimize import differential_evolution
from tqdm import tqdm

from ftac_gym import scenarios
from ftac_gym.evaluation.metrics import summarize
from ftac_gym.evaluation.rollout import BaselineContestant, rollout

# The sampled rate loop of a 10 Hz controller is stable below a rate gain of 20 1/s. Searching up to 8 1/s keeps a gain
# margin of 8 dB, of which the observer takes its part: gains that only work on a perfect wheel are no use.
SPACES: dict[str, dict[str, tuple[float, float]]] = {
    "pd": {
        "rate_gain": (0.5, 8.0),
        "position_share": (0.1, 0.8),
        "braking_share": (0.2, 1.0),
        "rate_limit": (0.05, 0.3),
        "attitude_filter_time": (0.1, 5.0),
    },
}
SPACES["pd_dob"] = {**SPACES["pd"], "bandwidth": (0.2, 5.0)}


@dataclass(frozen=True)
class Config:
    """A search."""

    baseline: str = "pd_dob"
    """Baseline to tune."""
    scenario: str = "flagship"
    """Scenario whose episodes are drawn."""
    episodes: int = 300
    """Episodes that every candidate flies."""
    seed: int = 800_000
    """Seed of those episodes; the next seed checks the result."""
    population: int = 6
    """Candidates per generation and gain."""
    generations: int = 10
    """Generations of differential evolution."""
    workers: int = 2
    """Processes."""


def gains_of(baseline: str, point: np.ndarray) -> dict[str, Any]:
    """Turn a point of the search space into gains; the position gain is searched as a share of the rate gain."""
    gains = dict(zip(SPACES[baseline], (round(float(value), 4) for value in point), strict=True))
    gains["position_gain"] = round(gains["rate_gain"] * gains.pop("position_share"), 4)
    return gains


def cost(point: np.ndarray, config: Config, seed: int) -> float:
    """Return the negative mean return over the feasible episodes."""
    history = rollout(
        config.scenario, BaselineContestant(config.baseline, **gains_of(config.baseline, point)), seed=seed,
        count=config.episodes,
    )  # fmt: skip
    return -float(history.metrics()["return"][history.episodes.feasible].mean())


def main(config: Config) -> None:
    """Search, and report."""
    for name, value, known in (
        ("baseline", config.baseline, sorted(SPACES)),
        ("scenario", config.scenario, scenarios.names()),
    ):
        if value not in known:
            raise SystemExit(f"--{name} must be one of {known}, got {value!r}")
    bounds: Any = list(SPACES[config.baseline].values())
    bar = tqdm(total=config.generations, desc=f"tuning {config.baseline}")

    def progress(intermediate_result: Any) -> None:
        bar.set_postfix(mean_return=f"{-intermediate_result.fun:.3f}")
        bar.update()

    with ProcessPoolExecutor(config.workers) as pool:
        result = differential_evolution(
            partial(cost, config=config, seed=config.seed), bounds,
            popsize=config.population, maxiter=config.generations, workers=pool.map, updating="deferred", rng=0,
            polish=False, tol=0.0, callback=progress,
        )  # fmt: skip
    bar.close()
    gains = gains_of(config.baseline, result.x)
    print(f"evaluated {result.nfev} candidates on {config.episodes} episodes")
    print(f"gains: {json.dumps(gains)}")
    for name, contestant in (
        ("tuned", BaselineContestant(config.baseline, **gains)),
        ("default", BaselineContestant(config.baseline)),
    ):
        history = rollout(config.scenario, contestant, seed=config.seed + 1, count=config.episodes)
        summary = summarize({key: value[history.episodes.feasible] for key, value in history.metrics().items()})
        print(f"{name} on fresh episodes: " + ", ".join(f"{key} {value:.4g}" for key, value in summary.items()))


if __name__ == "__main__":
    main(tyro.cli(Config, description=__doc__))
