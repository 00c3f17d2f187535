"""Tune the gains of a baseline with CMA-ES on the training split, for availability, success or return.

The objective is the mean of a metric over all episodes, infeasible ones included. Availability is the share of control
periods on target. The search covers the ranges that the baseline declares for its gains. A study lies in a folder and
continues where it stopped if the same command is given again; a larger number of trials extends it. The program prints
the best gains, and their results on validation episodes, which the search does not use. It writes them to gains.json in
the folder, which is a set of gains for every program: ftac-evaluate --policies "pd_dob runs/tuning/pd_dob/gains.json".
With --store, in a checkout, they become the baseline's tuned gains.

For example:

    ftac-tune --baseline pd_dob --trials 400
    ftac-tune --baseline pd_dob --trials 400 --store
    ftac-tune --baseline pd_dob --scenario my_satellite.json --folder runs/tuning/my_satellite
"""

from __future__ import annotations

import dataclasses
import json
import sys
from concurrent.futures import BrokenExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from tqdm import tqdm

from ftac_gym import baselines
from ftac_gym.cli.tasks import scenario_of, short_name
from ftac_gym.evaluation.metrics import described
from ftac_gym.evaluation.tuning import store, tune
from ftac_gym.evaluation.tuning_objective import Search, fly
from ftac_gym.utils.console import check_store, command_line, commit, exit_on, one_line_warnings
from ftac_gym.utils.parameters import require

GAINS_FILE = "gains.json"
"""File of the best gains in the folder of a study."""


@dataclass(frozen=True)
class Config:
    """A search."""

    baseline: str = "pd_dob"
    """Baseline to tune."""
    scenario: str = "flagship"
    """Scenario whose episodes are drawn: NAME, FILE.json or module:function."""
    objective: Literal["availability", "success", "return"] = "availability"
    """Metric whose mean is to be as large as possible."""
    trials: int = 300
    """Budget: number of gains that are flown in all, those of an earlier call included."""
    episodes: int = 300
    """Episodes that all of them fly."""
    seed: int = 800_000
    """Seed of those episodes."""
    sampler_seed: int = 0
    """Seed of CMA-ES."""
    first: Literal["default", "tuned"] = "default"
    """Gains of the first trial. With those that the package has tuned the search begins there, else in the middle."""
    workers: int = 2
    """Processes; they do not change the result."""
    folder: Path | None = None
    """Folder of the study; by default runs/tuning/BASELINE, or runs/tuning/SCENARIO/BASELINE if that is another one."""
    store: bool = False
    """Write the gains and their provenance into the package of a checkout too, for gains="tuned"."""


def command(config: Config) -> str:
    """Return the command line that finds the same gains; it states the budget even if it is the usual one."""
    return command_line("ftac-tune", config, always=("baseline", "trials"), never=("workers", "folder"))


def search_of(config: Config) -> Search:
    """Return the search; raise a ValueError that names an argument which does not fit."""
    known = baselines.names()
    require(config.baseline in known, "baseline", f"must be one of {known}", config.baseline)
    for name in ("trials", "workers"):
        require(getattr(config, name) > 0, name, "must be positive", getattr(config, name))
    scenario = scenario_of(config.scenario)
    return Search(
        config.baseline, scenario, config.episodes, config.seed, config.sampler_seed, config.objective, config.first
    )


def folder_of(config: Config) -> Path:
    """Return the folder of the study."""
    if config.folder is not None:
        return config.folder
    task = "" if config.scenario == Config.scenario else short_name(config.scenario)
    return Path("runs/tuning") / task / config.baseline


def written(line: str) -> None:
    """Print a line above the bar."""
    tqdm.write(line, file=sys.stderr)


def main(config: Config) -> None:
    """Search and report."""
    # Read at the start: the working tree may change while the search runs.
    check_store(config.store)
    commit_id = commit()
    with exit_on(ValueError), exit_on(BrokenExecutor, prefix="not finished: "), one_line_warnings(written):
        search, folder = search_of(config), folder_of(config)
        with tqdm(total=config.trials, desc=f"tuning {config.baseline}", unit="trial") as bar:

            def progress(done: int, best: float) -> None:
                if not bar.n:  # Those of an earlier call tell nothing about the speed.
                    bar.initial = bar.n = done
                bar.set_postfix({config.objective: f"{best:.4f}"}, refresh=False)
                bar.update(done - bar.n)

            result = tune(search, folder, config.trials, config.workers, progress)
    if result.trials > config.trials:
        print(f"{folder} holds more than {config.trials} trials: all of them count")
    print(f"flew {result.trials} trials on {config.episodes} episodes; {result.failed} could not be flown")
    print(f"gains: {json.dumps(result.gains)}")
    print(f"mean {config.objective}: {result.value:.5g}")
    validation: dict[str, float] = {}
    episodes = search.validation()
    for label, gains in (("tuned", result.gains), ("default", {})):
        metrics = fly(search, gains, episodes)
        validation[label] = float(metrics[config.objective].mean())
        value = f"mean {config.objective} {validation[label]:.4g}; {described(metrics)}"
        print(f"{label} on {len(metrics['return'])} validation episodes: {value}")
    counted = dataclasses.replace(config, trials=result.trials)
    for path in (folder / GAINS_FILE, *([None] if config.store else [])):
        with exit_on(ValueError, prefix="not stored: "):
            print(f"stored {store(result, command(counted), commit_id, validation, path)}")
