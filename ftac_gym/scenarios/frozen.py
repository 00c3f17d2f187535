"""Frozen test episodes of the flagship's splits, the same for every policy.

For each split ``frozen.json`` holds the seed, the number of episodes drawn from it, the number of feasible ones among
them, and their digest. ``python -m ftac_gym.scenarios.frozen`` writes the file anew, which makes earlier results
incomparable.
"""

import json
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

from ftac_gym import scenarios
from ftac_gym.task import Episodes, Scenario
from ftac_gym.utils.files import reading, write_text
from ftac_gym.utils.parameters import require
from ftac_gym.utils.serialization import parse_json

FEASIBLE = 500
"""Feasible episodes of each list."""

FIRST_SEED = 10_000
"""Seed of the flagship's list; each split that follows has the next thousand. No training or tuning may use them."""

_FILE = "frozen.json"


def seeds() -> dict[str, int]:
    """Return the seed of each split's list, by its name."""
    return {split: FIRST_SEED + 1_000 * number for number, split in enumerate(scenarios.SPLITS)}


def draw_feasible(scenario: Scenario, seed: int, feasible: int) -> Episodes:
    """Draw episodes of a seed, from the first on, until a number of them are feasible.

    Raises
    ------
    ValueError
        If fewer than about one in twenty episodes of the scenario is feasible.
    """
    count = feasible
    while True:
        episodes = scenario.draw(seed, count)
        missing = feasible - int(episodes.feasible.sum())
        if missing <= 0:
            return first_feasible(episodes, feasible)
        rule = f"must have more feasible episodes: {feasible - missing} of {count} drawn are"
        require(count <= 20 * feasible, "scenario", rule, scenario.name)
        count += missing


def first_feasible(episodes: Episodes, feasible: int) -> Episodes:
    """Return the first episodes, up to and including the feasible one of that number."""
    return episodes[: int(np.flatnonzero(episodes.feasible)[feasible - 1]) + 1]


def load(split: str, feasible: int = FEASIBLE) -> Episodes:
    """Return the frozen episodes of a split.

    Parameters
    ----------
    split
        One of :data:`~ftac_gym.scenarios.splits.SPLITS`.
    feasible
        Number of feasible episodes. The list ends with the last of them and includes the infeasible ones before it.

    Raises
    ------
    ValueError
        If the split is unknown, the list has fewer feasible episodes, or the episodes drawn are not the frozen ones.
    """
    known = _lists()
    require(split in known, "split", f"must be one of {list(known)}", split)
    entry = known[split]
    require(1 <= feasible <= entry["feasible"], "feasible", f"must be within [1, {entry['feasible']}]", feasible)
    episodes = scenarios.get(split).draw(entry["seed"], entry["count"])
    rule = f"must be the frozen episodes of {split}, digest {entry['digest']}; scenario or drawing has changed, digest"
    digest = episodes.digest()
    require(digest == entry["digest"], "episodes", rule, digest)
    return first_feasible(episodes, feasible)


def _lists() -> dict[str, Any]:
    """Return the content of the file, by split."""
    path = resources.files(scenarios).joinpath(_FILE)
    with reading(Path(str(path)), "install the package again"):
        known = parse_json(path.read_bytes())
        for split in scenarios.SPLITS:
            for part, kind in (("seed", int), ("count", int), ("feasible", int), ("digest", str)):
                value = known[split][part]
                require(type(value) is kind, f"{part} of {split}", f"must be of type {kind.__name__}", value)
        return dict(known)


def freeze(path: Path) -> None:
    """Draw the lists of all splits and write them to a file."""
    lists = {}
    for split, seed in seeds().items():
        episodes = draw_feasible(scenarios.get(split), seed, FEASIBLE)
        lists[split] = {"seed": seed, "count": len(episodes), "feasible": FEASIBLE, "digest": episodes.digest()}
    write_text(path, json.dumps(lists, indent=2) + "\n")


if __name__ == "__main__":
    freeze(Path(str(resources.files(scenarios).joinpath(_FILE))))
