"""Tune the gains of a baseline with CMA-ES for the agents' objective, the mean return, on the training split.

The search covers the ranges that the baseline declares for its gains. A study lies in a folder and continues where it
stopped if the same command is given again; a larger number of trials extends it. The script prints the best gains, and
their results on episodes that the search did not use. With --store they become the baseline's tuned gains.

For example:

    python train/tune.py --baseline pd_dob --trials 400
    python train/tune.py --baseline pd_dob --trials 400 --store
"""

from __future__ import annotations

import dataclasses
import json
import sys
from concurrent.futures import BrokenExecutor
from dataclasses import dataclass
from pathlib import Path

from tqdm import tqdm

from ftac_gym import baselines, scenarios
from ftac_gym.evaluation.metrics import described
from ftac_gym.evaluation.tuning import store, tune
from ftac_gym.evaluation.tuning_objective import Search, fly
from ftac_gym.utils.console import command_line, commit, exit_on, one_line_warnings
from ftac_gym.utils.parameters import require


@dataclass(frozen=True)
class Config:
    """A search."""

    baseline: str = "pd_dob"
    """Baseline to tune."""
    scenario: str = "flagship"
    """Scenario whose episodes are drawn."""
    trials: int = 300
    """Budget: number of gains that are flown in all, those of an earlier call included."""
    episodes: int = 300
    """Episodes that all of them fly, of which the feasible ones count."""
    seed: int = 800_000
    """Seed of those episodes; the next seed checks the result."""
    sampler_seed: int = 0
    """Seed of CMA-ES."""
    workers: int = 2
    """Processes; they do not change the result."""
    folder: Path | None = None
    """Folder of the study; by default runs/tuning/BASELINE."""
    store: bool = False
    """Write the gains and their provenance into the package, for gains="tuned"."""


def command(config: Config) -> str:
    """Return the command line that finds the same gains; it states the budget even if it is the usual one."""
    stored = dataclasses.replace(config, store=True)
    return command_line("train/tune.py", stored, always=("baseline", "trials"), never=("workers", "folder"))


def search_of(config: Config) -> Search:
    """Return the search; raise a ValueError that names an argument which does not fit."""
    for name, known in (("baseline", baselines.names()), ("scenario", scenarios.names())):
        require(getattr(config, name) in known, name, f"must be one of {known}", getattr(config, name))
    for name in ("trials", "workers"):
        require(getattr(config, name) > 0, name, "must be positive", getattr(config, name))
    scenario = scenarios.get(config.scenario)
    return Search(config.baseline, scenario, config.episodes, config.seed, config.sampler_seed)


def written(line: str) -> None:
    """Print a line above the bar."""
    tqdm.write(line, file=sys.stderr)


def main(config: Config) -> None:
    """Search and report."""
    # Read at the start: the working tree may change while the search runs.
    commit_id = commit(Path(__file__).parent)
    folder = config.folder if config.folder is not None else Path("runs/tuning") / config.baseline
    with exit_on(ValueError), exit_on(BrokenExecutor, prefix="not finished: "), one_line_warnings(written):
        search = search_of(config)
        with tqdm(total=config.trials, desc=f"tuning {config.baseline}", unit="trial") as bar:

            def progress(done: int, best: float) -> None:
                if not bar.n:  # Those of an earlier call tell nothing about the speed.
                    bar.initial = bar.n = done
                bar.set_postfix(mean_return=f"{best:.3f}", refresh=False)
                bar.update(done - bar.n)

            result = tune(search, folder, config.trials, config.workers, progress)
    if result.trials > config.trials:
        print(f"{folder} holds more than {config.trials} trials: all of them count")
    print(f"flew {result.trials} trials on {config.episodes} episodes; {result.failed} could not be flown")
    print(f"gains: {json.dumps(result.gains)}")
    print(f"mean return: {result.mean_return:.5g}")
    fresh = {}
    for label, gains in (("tuned", result.gains), ("default", {})):
        metrics = fly(search, gains, config.seed + 1)
        fresh[label] = float(metrics["return"].mean())
        print(f"{label} on fresh episodes: {described(metrics)}, mean return {fresh[label]:.4g}")
    if config.store:
        counted = dataclasses.replace(config, trials=result.trials)
        with exit_on(ValueError, prefix="not stored: "):
            print(f"stored {store(result, command(counted), commit_id, fresh)}")
