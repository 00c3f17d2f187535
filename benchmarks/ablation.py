"""Ablation of the estimators: what each component in front of a controller adds, split by split.

    python benchmarks/ablation.py                                   # docs/ablation.inc and docs/ablation.csv
    python benchmarks/ablation.py --laws pd_dob --episodes 200 --output results

All fly the same validation episodes of the flagship and its splits, of which the feasible ones count. One column more
is the flagship with momentum stored in the wheels. The components are added one by one to the law of version 0.1, with
its gains. Then the gains become those that are tuned with all components, and each component is left out of that set.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from tqdm import tqdm

from ftac_gym import baselines, scenarios
from ftac_gym.baselines import tuned
from ftac_gym.evaluation import estimate, paired_difference, rollout
from ftac_gym.evaluation.episodes import judging_episodes
from ftac_gym.evaluation.files import write_rows
from ftac_gym.evaluation.rows import statistic_of
from ftac_gym.evaluation.statistics import Estimate
from ftac_gym.evaluation.tables import judgement, markdown
from ftac_gym.policies import DeferredBaseline
from ftac_gym.task import Scenario
from ftac_gym.utils.console import run_program
from ftac_gym.utils.files import write_text
from ftac_gym.utils.parameters import FloatArray, require

METRICS = ("success", "availability")
"""Metrics of the tables."""
DIGITS = {"success": 2, "availability": 3}
"""Digits behind the point."""

Gains = Mapping[str, Any]

BEFORE: Mapping[str, Gains] = {
    "pd_dob": {
        "attitude_filter_time": 3.008, "braking_share": 0.7066, "rate_limit": 1.485452, "rate_gain": 1.2324,
        "position_gain": 0.4968, "bandwidth": 0.07794,
    },
    "nftsm_isolation": {
        "attitude_filter_time": 3.987, "linear": 0.1037, "terminal": 2.575, "exponent": 0.5463,
        "terminal_slope": 2.753, "reaching_switching": 1.31, "rate_gain": 0.62, "reaching_linear": 0.3764,
    },
}  # fmt: skip
"""Gains of version 0.1, tuned without estimators, in today's units: those that the steps have in common.

Gains that are tuned with all components cannot measure a part of them. Behind the prediction they are so high that the
loop is unstable without it.
"""

STEPS: Mapping[str, Gains] = {
    "fixed-gain filter": {"filter": "none", "prediction": False, "isolation": "none"},
    "+ Kalman filter": {"filter": "kalman", "gate": 1.0, "prediction": False, "isolation": "none"},
    "+ gate": {"filter": "kalman", "prediction": False, "isolation": "none"},
    "+ prediction": {"filter": "kalman", "isolation": "none"},
    "+ isolation": {"filter": "kalman", "isolation": "rate", "plant_braking": False},
    "+ braking": {"filter": "kalman", "isolation": "rate"},
}
"""Gains of the steps from the law of version 0.1 to all components.

Isolation without braking has the slew profile of the nominal plant. The torque is that of the estimated plant.
"""
TUNED_STEP = "+ gains tuned with all"
"""The last step."""

LEFT_OUT: Mapping[str, Gains] = {
    "- Kalman filter": {"filter": "none"},
    "- gate": {"gate": 1.0},
    "- prediction": {"prediction": False},
    "- isolation": {"isolation": "none"},
    "- braking": {"plant_braking": False},
}
"""Changes that leave one component out of all. Without isolation no estimate of the plant is left to brake by."""


@dataclass(frozen=True)
class Config:
    """Laws and episodes."""

    laws: tuple[str, ...] = ("pd_dob", "nftsm_isolation")
    """Laws, of which the gains of version 0.1 are known."""
    episodes: int = 100
    """Feasible validation episodes of each split."""
    splits: tuple[str, ...] = (*scenarios.SPLITS, "stored_momentum")
    """Splits of the flagship."""
    output: Path = Path(__file__).parents[1] / "docs"
    """Folder of the tables."""


@dataclass(frozen=True)
class Variant:
    """A law with some of the components.

    Attributes
    ----------
    name
        Its name in the tables.
    gains
        Set of gains, as :func:`ftac_gym.baselines.make` takes it.
    changes
        Gains that differ from these.
    reference
        Name of the variant from which it differs by one component; empty for the first.
    """

    name: str
    gains: str
    changes: Gains
    reference: str


@dataclass(frozen=True)
class Result:
    """A variant of a law on a split.

    Attributes
    ----------
    law, variant, split
        Names.
    estimates
        Mean with its interval, by metric: Wilson's for the success.
    differences
        Paired difference to the reference of the variant, by metric; empty without one.
    """

    law: str
    variant: Variant
    split: str
    estimates: Mapping[str, Estimate]
    differences: Mapping[str, Estimate]


def task_of(split: str) -> Scenario:
    """Return the scenario of a column."""
    if split != "stored_momentum":
        return scenarios.get(split)
    flagship = scenarios.get("flagship")
    start = replace(flagship.initial_state, wheel_momentum=(4.0, 6.0))
    return flagship.replace(name=split, initial_state=start)


def variants(law: str) -> list[Variant]:
    """Return the variants of a law, each behind its reference.

    Raises
    ------
    ValueError
        If the gains of version 0.1 are not known, or none are tuned.
    """
    require(law in BEFORE, "laws", f"must be among {sorted(BEFORE)}", law)
    require(law in tuned.names(), "laws", f"must have tuned gains, as {tuned.names()} have", law)
    known = baselines.registry.defaults(law)
    found: list[Variant] = []
    for name, gains in STEPS.items():
        changes = {**BEFORE[law], **_offered(gains, known)}
        # A law that does not turn along the slew profile has nothing to brake by the plant.
        if not found or changes != found[-1].changes:
            found.append(Variant(name, "default", changes, found[-1].name if found else ""))
    # The gains of the isolation's variant are in its entry.
    last = {"filter": "kalman", "isolation": "rate"}
    found.append(Variant(TUNED_STEP, "tuned", last, found[-1].name))
    for name, gains in LEFT_OUT.items():
        if changes := _offered(gains, known):
            found.append(Variant(name, "tuned", {**last, **changes}, TUNED_STEP))
    return found


def _offered(gains: Gains, known: Gains) -> dict[str, Any]:
    """Return the gains that a law has."""
    return {name: value for name, value in gains.items() if name in known}


def ablate(law: str, split: str, count: int) -> Iterator[Result]:
    """Yield the results of all variants of a law on a number of feasible validation episodes of a split."""
    task = task_of(split)
    episodes = judging_episodes(task, count, "validation")
    flown: dict[str, Mapping[str, FloatArray]] = {}
    for variant in variants(law):
        policy = DeferredBaseline(law, variant.gains, **variant.changes)
        with np.errstate(all="ignore"):  # Some loops are unstable without a component.
            flown[variant.name] = rollout(task, policy, episodes).feasible_metrics()
        own = flown[variant.name]
        differences = {}
        if variant.reference:
            other = flown[variant.reference]
            differences = {name: paired_difference(own[name], other[name], statistic_of(name)) for name in METRICS}
        estimates = {name: estimate(own[name], statistic_of(name)) for name in METRICS}
        yield Result(law, variant, split, estimates, differences)


def tables(results: Sequence[Result], law: str) -> dict[str, list[list[str]]]:
    """Return the tables of a law by their titles: variants down, splits across.

    Bold differences are those whose interval excludes zero.
    """
    own = [item for item in results if item.law == law]
    splits = list(dict.fromkeys(item.split for item in own))
    heading = [split.removeprefix("flagship_").replace("_", " ") for split in splits]
    by_place = {(item.variant.name, item.split): item for item in own}
    steps = list(dict.fromkeys(item.variant.name for item in own))
    found: dict[str, list[list[str]]] = {}
    for metric in METRICS:
        values, changes = [["", *heading]], [["", *heading]]
        for step in steps:
            row = [by_place[step, split] for split in splits]
            values.append([step, *(_with_interval(metric, item.estimates[metric], "") for item in row)])
            if row[0].differences:
                changes.append([step, *(_difference(metric, item.differences[metric]) for item in row)])
        found[f"`{law}`: {metric}"] = values
        found[f"`{law}`: change of {metric}"] = changes
    return found


def _with_interval(metric: str, value: Estimate, sign: str) -> str:
    number, low, high = (f"{part:{sign}.{DIGITS[metric]}f}" for part in (value.value, value.low, value.high))
    return f"{number} [{low}, {high}]"


def _difference(metric: str, value: Estimate) -> str:
    text = _with_interval(metric, value, "+")
    return f"**{text}**" if judgement(metric, value) else text


def csv_rows(results: Sequence[Result]) -> list[list[str]]:
    """Return the results as rows with a header."""
    kinds = [f"{metric}{part}" for metric in METRICS for part in ("", "_low", "_high")]
    rows = [["law", "variant", "split", "episodes", *kinds, "reference", *(f"{kind}_change" for kind in kinds)]]
    for item in results:
        cells = [item.law, item.variant.name, item.split, str(item.estimates["success"].count)]
        cells += [*_numbers(item.estimates), item.variant.reference]
        rows.append(cells + (_numbers(item.differences) if item.differences else [""] * len(kinds)))
    return rows


def _numbers(estimates: Mapping[str, Estimate]) -> list[str]:
    parts = (estimates[metric] for metric in METRICS)
    return [f"{value:.4f}" for part in parts for value in (part.value, part.low, part.high)]


def main(config: Config) -> None:
    """Fly, print and write."""
    pairs = [(law, split) for law in config.laws for split in config.splits]
    results = [item for law, split in tqdm(pairs, unit="split") for item in ablate(law, split, config.episodes)]
    parts = [
        f"### {title[0].upper()}{title[1:]}\n\n{markdown(cells)}\n"
        for law in config.laws
        for title, cells in tables(results, law).items()
    ]
    text = "\n".join(parts)
    print(text)
    write_text(config.output / "ablation.inc", text)
    write_rows(config.output / "ablation.csv", csv_rows(results))


if __name__ == "__main__":
    run_program(main, Config, __doc__)
