"""Synthetic benchmarks."""

import csv
from dataclasses import replace

import numpy as np
from helpers.evaluations import evaluation as made

from ftac_gym import scenarios
from ftac_gym.evaluation.benchmark import Benchmark, Entry
from ftac_gym.evaluation.metrics import UNITS
from ftac_gym.policies import DeferredBaseline
from ftac_gym.scenarios import frozen

SPLITS = ("flagship", "flagship_double")
EPISODES = {split: frozen.load(split, 25) for split in SPLITS}
DURATION = scenarios.get("flagship").duration


def evaluation(name, episodes, random, pace):
    """Return an evaluation with random metrics, some of them unknown in some episodes."""
    count = len(episodes)
    settling = np.minimum(random.gamma(9.0, pace / 9.0, count), DURATION)
    metrics = {metric: random.gamma(4.0, 0.25 * pace, count) for metric in UNITS}
    metrics |= {"settling_time": settling, "success": (random.random(count) > 0.01 * pace).astype(float)}
    metrics |= {"availability": np.clip(1.0 - settling / 120.0, 0.0, 1.0), "bound_kept": np.full(count, np.nan)}
    metrics["peak_after_fault"] = np.where(random.random(count) < 0.6, np.nan, metrics["peak_after_fault"])
    times = np.where(random.random(count) < 0.6, np.nan, random.gamma(4.0, 0.05 * pace, count))
    metrics["jitter"] = np.full(count, np.nan)
    return made(name, metrics, np.zeros((1, count)), times)


def agent(name, seeds=3, tier="attitude", **changes):
    card = {"command": "python train/train.py", "steps": 1_000_000, "training_seconds": 60.0}
    cards = {"cards": [{**card, "seed": k} for k in range(seeds)]}
    curves = tuple(
        tuple({"steps": 1e5 * (row + 1), "success": 0.1 * row + 0.01 * k, "mean_return": 5.0 * row} for row in range(4))
        for k in range(seeds)
    )
    policies = tuple("nowhere/agent" for _ in range(seeds))
    return replace(Entry(name, policies, tier, "agent", "", cards, curves), **changes)


def baseline(law, gains="default", **changes):
    name = f"{law} tuned" if gains == "tuned" else law
    tier = "oracle" if "oracle" in law else "attitude"
    command = f"python train/tune.py --baseline {law} --store"
    provenance = {"trials": 250, "episodes": 200, "command": command} if gains == "tuned" else {}
    return replace(Entry(name, (DeferredBaseline(law, gains),), tier, "baseline", gains, provenance), **changes)


PACES = {"swift": 22.0, "pd_dob tuned": 30.0, "pd": 60.0, "nftsm_oracle": 30.0}


def benchmark(entries, episodes=None, reference=None):
    episodes = EPISODES if episodes is None else episodes
    random = np.random.default_rng(0)
    evaluations = {
        split: {
            entry.name: tuple(
                evaluation(entry.name, drawn, random, PACES.get(entry.name, 40.0)) for _ in entry.policies
            )
            for entry in entries
        }
        for split, drawn in episodes.items()
    }
    costs = {entry.name: 12.5 for entry in entries}
    return Benchmark(tuple(entries), episodes, evaluations, reference or entries[0].name, costs, 1000, 10.0)


ENTRIES = (
    baseline("pd_dob", "tuned"),
    baseline("pd"),
    agent("swift"),
    agent("other", tier="telemetry"),
    baseline("nftsm_oracle"),
)


def read(path):
    """Return the rows of a CSV file."""
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def feasible(flown, split, name, metric):
    """Return a metric over feasible episodes, (seeds, N)."""
    chosen = flown.episodes[split].feasible
    return np.array([item.metrics[metric][chosen] for item in flown.evaluations[split][name]])
