"""Fly the baselines for their pages, and draw what happened."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np
from baseline_facts import Flown, about
from baseline_figures import draw, rows_of

import ftac_gym
from ftac_gym import baselines, scenarios
from ftac_gym.baselines import tuned
from ftac_gym.evaluation import Rollout, rollout
from ftac_gym.evaluation.metrics import episode_metrics
from ftac_gym.plots import EstimateHistory, estimates_along, faults_in_words
from ftac_gym.plots.recording import flown_again
from ftac_gym.policies import DeferredBaseline
from ftac_gym.task.scenario import Scenario, success_steps

SEED = 3
"""Of every flight: on the flagship a wheel gets a bias when a good law has long been on target."""
KEPT = ("success", "settling_time", "final_error", "saturation", "chatter")
"""Metrics that the pages show."""


@dataclass(frozen=True)
class Result:
    """What a page says of one flight.

    Parameters
    ----------
    gains
        ``"default"`` or ``"tuned"``.
    scenario
        Name of the scenario.
    duration
        How long was flown [s].
    angle, rate
        What counts as on target [deg, deg/s].
    hold
        Length of the last part, by which the flight is judged [s].
    faults
        What was wrong, in words.
    metrics
        Those of :data:`KEPT`, by name.
    error, rate_error
        The largest errors of the last part [deg, deg/s].
    """

    gains: str
    scenario: str
    duration: float
    angle: float
    rate: float
    hold: float
    faults: str
    metrics: dict[str, float]
    error: float
    rate_error: float


def task(flown: Flown) -> Scenario:
    """Return the scenario of a flight, as long as the flight."""
    scenario = scenarios.get(flown.scenario)
    success = scenario.success if flown.hold is None else replace(scenario.success, hold=flown.hold)
    return scenario.replace(duration=flown.duration or scenario.duration, success=success)


def fly(scenario: Scenario, name: str, gains: str = "default", seed: int = SEED) -> tuple[Rollout, EstimateHistory]:
    """Fly one episode, and return what the law's observer believes on the way too: nothing, if it has none.

    Parameters
    ----------
    scenario
        The task.
    name, gains
        The baseline.
    seed
        Seed of the episode.
    """
    history = rollout(scenario, DeferredBaseline(name, gains), seed=seed)
    law, start = baselines.make(name, scenario, 1, gains), next(flown_again(history))
    law.act(start.measurement(truth=law.information == "oracle"))
    if law.estimate is None:
        return history, EstimateHistory(history, None, None, None, None, None)
    return history, estimates_along(history, name, gains)


def evaluate(name: str, folder: Path) -> list[Result]:
    """Fly a baseline with all its gains, draw its figures into a folder, and return the results.

    With default gains it flies the scenario that it is made for. Tuned gains fly the one that they were tuned on,
    beside the default ones: a figure of its own where the two scenarios differ.
    """
    first = about(name).flown
    groups = {first: ["default"]}
    if name in tuned.names():
        scenario_tuned = tuned.record(name)["provenance"]["scenario"]
        second = first if scenario_tuned == first.scenario else Flown(scenario_tuned)
        groups.setdefault(second, ["default"]).append("tuned")
    results = []
    for flown, gains in groups.items():
        scenario = task(flown)
        flights = {choice: fly(scenario, name, choice) for choice in gains}
        results += [result_of(flown.scenario, choice, history) for choice, (history, _) in flights.items()]
        law = baselines.make(name, scenario)
        # An oracle believes what is true.
        observed = law.information != "oracle"
        rows = rows_of(flights["default"][1], getattr(law, "takes_torques", True)) if observed else []
        figure = draw(flights, rows)
        folder.mkdir(parents=True, exist_ok=True)
        figure.savefig(folder / picture(name, flown.scenario), dpi=110, metadata={"Software": None})
    return results


def picture(name: str, scenario: str) -> str:
    """Return the name of the file of a figure."""
    return f"{name}-{scenario}.png"


def result_of(scenario: str, gains: str, history: Rollout) -> Result:
    """Return what a page says of a flight."""
    metrics = episode_metrics(history)
    kept = {part: float(metrics[part][0]) for part in KEPT}
    success, faults = history.scenario.success, faults_in_words(history.episodes, 0)
    last = success_steps(history.scenario)
    return Result(
        gains=gains,
        scenario=scenario,
        duration=history.scenario.duration,
        angle=float(np.degrees(success.angle)),
        rate=float(np.degrees(success.rate)),
        hold=success.hold,
        faults=faults,
        metrics=kept,
        error=float(np.degrees(history.attitude_error[-last:].max())),
        rate_error=float(np.degrees(history.rate_error[-last:].max())),
    )


def digest() -> str:
    """Return a digest of the code and the gains that the flights follow from."""
    package, scripts = Path(ftac_gym.__file__).parent, Path(__file__).parent
    parts = ("baselines", "dynamics", "faults", "scenarios", "task", "spacecraft", "plots")
    files = [path for part in parts for path in (package / part).rglob("*") if path.suffix in (".py", ".json")]
    files += [*package.glob("*.py"), *(package / "evaluation").glob("*.py"), *scripts.glob("baseline_f*.py")]
    found = hashlib.sha256()
    for path in sorted(files):
        found.update(path.read_bytes())
    return found.hexdigest()


def results(folder: Path, kept: Path) -> dict[str, list[Result]]:
    """Return the flights of all baselines by name; nothing is flown twice while the code stays as it is.

    Parameters
    ----------
    folder
        Where the figures go.
    kept
        File that keeps the results.
    """
    key = digest()
    known = json.loads(kept.read_text(encoding="utf-8")) if kept.exists() else {}
    if known.get("digest") != key:
        known = {"digest": key, "flights": {}}
    found = {}
    for name in baselines.names():
        flown = [Result(**item) for item in known["flights"].get(name, [])]
        if not flown or not all((folder / picture(name, item.scenario)).exists() for item in flown):
            flown = evaluate(name, folder)
            known["flights"][name] = [asdict(item) for item in flown]
            kept.parent.mkdir(parents=True, exist_ok=True)
            kept.write_text(json.dumps(known), encoding="utf-8")
        found[name] = flown
    return found
