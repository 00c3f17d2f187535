"""Tune the gains of a baseline on the training split, for the agents' objective: the mean return.

CMA-ES searches where the baseline says that its gains may lie. The study lies in a folder and goes on where it stopped
if the same command is given again; a larger number of trials goes on further. Prints the best gains found, and how far
they got on episodes that the search did not see; --store makes them the baseline's tuned gains.

Examples
--------
    python train/tune.py --baseline pd_dob --trials 400
    python train/tune.py --baseline pd_dob --trials 400 --store
"""

from __future__ import annotations

import dataclasses
import json
import subprocess
from dataclasses import dataclass
from pathlib import Path

import tyro
from tqdm import tqdm

from ftac_gym import baselines, scenarios
from ftac_gym.evaluation.metrics import summarize
from ftac_gym.evaluation.tuning import open_study, store, tune
from ftac_gym.evaluation.tuning_objective import Search, fly


@dataclass(frozen=True)
class Config:
    """A search."""

    baseline: str = "pd_dob"
    """Baseline to tune."""
    scenario: str = "flagship"
    """Scenario whose episodes are drawn."""
    trials: int = 300
    """Budget: how many gains are flown in all, those of an earlier call among them."""
    episodes: int = 300
    """Episodes that all of them fly, of which the feasible ones count."""
    seed: int = 800_000
    """Seed of those episodes; the next seed checks the result."""
    sampler_seed: int = 0
    """Seed of CMA-ES."""
    workers: int = 2
    """Processes; they do not change the result."""
    folder: Path | None = None
    """Where the study lies; by default runs/tuning/BASELINE."""
    store: bool = False
    """Write the gains and their provenance into the package, for gains="tuned"."""


def command(config: Config) -> str:
    """Return the command line that finds the same gains."""
    words = [f"python train/tune.py --baseline {config.baseline}"]
    default = Config()
    for name in ("scenario", "trials", "episodes", "seed", "sampler_seed"):
        # The budget is stated even if it is the usual one.
        if name == "trials" or getattr(config, name) != getattr(default, name):
            words.append(f"--{name.replace('_', '-')} {getattr(config, name)}")
    return " ".join([*words, "--store"])


def commit() -> str | None:
    """Return the git commit of the code, marked if the code differs from it; None outside a checkout."""

    def git(*words: str) -> str:
        folder = Path(__file__).parents[1]
        return subprocess.run(["git", *words], capture_output=True, text=True, check=True, cwd=folder).stdout.strip()

    try:
        changed = git("status", "--porcelain", "--", "ftac_gym", ":!ftac_gym/baselines/tuned_gains")
        return git("rev-parse", "HEAD") + ("-dirty" if changed else "")
    except (OSError, subprocess.CalledProcessError):
        return None


def main(config: Config) -> None:
    """Search, and report."""
    for name, value, known in (
        ("baseline", config.baseline, baselines.names()),
        ("scenario", config.scenario, scenarios.names()),
    ):
        if value not in known:
            raise SystemExit(f"--{name} must be one of {known}, got {value!r}")
    for name in ("trials", "workers"):
        if getattr(config, name) < 1:
            raise SystemExit(f"--{name} must be positive, got {getattr(config, name)}")
    # The tree may move on while it searches.
    made_by = commit()
    folder = config.folder if config.folder is not None else Path("runs/tuning") / config.baseline
    try:
        search = Search(
            config.baseline, scenarios.get(config.scenario), config.episodes, config.seed, config.sampler_seed
        )
        open_study(search, folder)
    except ValueError as error:
        raise SystemExit(f"--{error}") from None
    with tqdm(total=config.trials, desc=f"tuning {config.baseline}", unit="trial") as bar:

        def progress(done: int, best: float) -> None:
            # What lay on disk took no time.
            bar.initial = bar.initial if bar.n else done
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
        values = {**summarize(metrics), "mean return": fresh[label]}
        values["median return"] = values.pop("return")
        print(f"{label} on fresh episodes: " + ", ".join(f"{key} {value:.4g}" for key, value in values.items()))
    if config.store:
        counted = dataclasses.replace(config, trials=result.trials)
        try:
            print(f"stored {store(result, command(counted), made_by, fresh)}")
        except ValueError as error:
            raise SystemExit(f"not stored: {error}") from None


if __name__ == "__main__":
    main(tyro.cli(Config, description=__doc__))
