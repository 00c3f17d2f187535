"""Frozen episodes of the flagship's splits, the same for every policy: a validation and a test list for each split.

Validation lists are for every choice: gains, checkpoints, designs. Test lists are for the last table alone. For each of
them ``frozen.json`` holds the seed, the number of episodes drawn from it, the number of feasible ones among them, and
their digest. ``python -m ftac_gym.scenarios.frozen`` writes the file anew, which makes earlier results incomparable.
"""

import json
from importlib import resources
from pathlib import Path
from typing import Any, Literal

import numpy as np

from ftac_gym import scenarios
from ftac_gym.task import Episodes, Scenario
from ftac_gym.utils.files import reading, write_text
from ftac_gym.utils.parameters import require, whole
from ftac_gym.utils.serialization import parse_json

FEASIBLE = 500
"""Feasible episodes of each list."""

Kind = Literal["validation", "test"]
"""Kind of a list."""

FIRST_SEED: dict[Kind, int] = {"validation": 20_000, "test": 10_000}
"""Seed of the flagship's list of each kind; each split that follows has the next thousand."""

RESERVED = range(10_000, 30_000)
"""Seeds that no training and no tuning may use: those of all lists, with room for further splits."""

_FILE = "frozen.json"


def seeds(kind: Kind = "test") -> dict[str, int]:
    """Return the seed of each split's list of a kind, by the name of the split."""
    _check_kind(kind)
    return {split: FIRST_SEED[kind] + 1_000 * number for number, split in enumerate(scenarios.SPLITS)}


def seed_of(name: str, kind: Kind = "test") -> int:
    """Return the seed of a scenario's episodes of a kind: that of its list, or for other scenarios the flagship's."""
    return seeds(kind).get(name, FIRST_SEED[kind])


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


def load(split: str, feasible: int = FEASIBLE, kind: Kind = "test") -> Episodes:
    """Return frozen episodes of a split.

    Parameters
    ----------
    split
        One of :data:`~ftac_gym.scenarios.splits.SPLITS`.
    feasible
        Number of feasible episodes. The list ends with the last of them and includes the infeasible ones before it.
    kind
        ``"validation"`` to choose by, ``"test"`` for the last table.

    Raises
    ------
    ValueError
        If split or kind is unknown, the list has fewer feasible episodes, or the episodes drawn are not the frozen
        ones.
    """
    known = _lists()
    require(split in list(known), "split", f"must be one of {list(known)}", split)
    _check_kind(kind)
    entry = known[split][kind]
    require(
        1 <= whole(feasible, 1, "feasible") <= entry["feasible"],
        "feasible",
        f"must be within [1, {entry['feasible']}]",
        feasible,
    )
    episodes = scenarios.get(split).draw(entry["seed"], entry["count"])
    name = f"the frozen {kind} episodes of {split}"
    rule = f"must be {name}, digest {entry['digest']}; scenario or drawing has changed, digest"
    digest = episodes.digest()
    require(digest == entry["digest"], "episodes", rule, digest)
    return first_feasible(episodes, feasible)


def check_free(seed: int, name: str = "seed") -> None:
    """Raise a ValueError that names a seed which is reserved for frozen episodes."""
    rule = f"must not be within [{RESERVED[0]}, {RESERVED[-1]}], the seeds of frozen validation and test episodes"
    require(seed not in RESERVED, name, rule, seed)


def _check_kind(kind: str) -> None:
    require(kind in list(FIRST_SEED), "kind", f"must be one of {list(FIRST_SEED)}", kind)


def _lists() -> dict[str, Any]:
    """Return the content of the file, by split and kind."""
    path = resources.files(scenarios).joinpath(_FILE)
    with reading(Path(str(path)), "install the package again"):
        known = parse_json(path.read_bytes())
        for split in scenarios.SPLITS:
            for kind in FIRST_SEED:
                for part, of_type in (("seed", int), ("count", int), ("feasible", int), ("digest", str)):
                    value, name = known[split][kind][part], f"{part} of the {kind} list of {split}"
                    require(type(value) is of_type, name, f"must be of type {of_type.__name__}", value)
        return dict(known)


def freeze(path: Path) -> None:
    """Draw the lists of all splits and write them to a file."""
    lists: dict[str, dict[str, Any]] = {split: {} for split in scenarios.SPLITS}
    for kind in FIRST_SEED:
        for split, seed in seeds(kind).items():
            episodes = draw_feasible(scenarios.get(split), seed, FEASIBLE)
            entry = {"seed": seed, "count": len(episodes), "feasible": FEASIBLE, "digest": episodes.digest()}
            lists[split][kind] = entry
    write_text(path, json.dumps(lists, indent=2) + "\n")


if __name__ == "__main__":
    freeze(Path(str(resources.files(scenarios).joinpath(_FILE))))
