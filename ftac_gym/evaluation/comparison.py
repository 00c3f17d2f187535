"""Comparison of policies by name: flown on identical episodes, in one table."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ftac_gym import scenarios
from ftac_gym.evaluation.batches import Evaluation, evaluate
from ftac_gym.evaluation.entries import check_fit
from ftac_gym.evaluation.episodes import FEASIBLE, judging_episodes
from ftac_gym.evaluation.rows import Row, tabulate
from ftac_gym.evaluation.tables import Cells, markdown, metric_tables
from ftac_gym.policies import policy_label, resolve
from ftac_gym.scenarios import ScenarioLike
from ftac_gym.task.episodes import Episodes
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import require


@dataclass(frozen=True, eq=False)
class Comparison:
    """Results of several policies on the same episodes; a notebook shows them as tables, and so does ``print``.

    Attributes
    ----------
    scenario, episodes
        Task and episodes.
    evaluations
        One for each policy, in order.
    reference
        Name of the policy that the others are compared with.
    rows
        Estimates and paired differences to the reference, one for each policy.
    """

    scenario: Scenario
    episodes: Episodes
    evaluations: tuple[Evaluation, ...]
    reference: str
    rows: tuple[Row, ...]

    @property
    def estimates(self) -> Cells:
        """Table of estimates with their intervals: metrics down, policies across."""
        return metric_tables(self.rows, self.reference)[0]

    @property
    def differences(self) -> Cells:
        """Table of paired differences to the reference, with better or worse where the interval excludes zero."""
        return metric_tables(self.rows, self.reference)[1]

    def _repr_markdown_(self) -> str:
        tables = [self.estimates, *([self.differences] if len(self.rows) > 1 else [])]
        return "\n\n".join(markdown(cells) for cells in tables)

    def __str__(self) -> str:
        """Return the tables as Markdown."""
        return self._repr_markdown_()


def compare(
    policies: Mapping[str, Any] | Sequence[Any],
    scenario: ScenarioLike = "flagship",
    reference: str | None = None,
    episodes: Episodes | int = FEASIBLE,
    count_infeasible: bool = False,
    folder: Path | None = None,
    progress: Callable[[str, int], None] | None = None,
) -> Comparison:
    """Fly policies through the same episodes and tabulate them.

    Parameters
    ----------
    policies
        Policies by the names that they have in the tables; or a list of them, each with its own name. See
        :func:`~ftac_gym.policies.resolve` for what a policy can be.
    scenario
        The task; see :func:`ftac_gym.scenarios.resolve`.
    reference
        Name of the policy that the others are compared with, episode by episode; the first by default.
    episodes
        Episodes, or the number of feasible ones: see :func:`~ftac_gym.evaluation.episodes.judging_episodes`.
    count_infeasible
        Whether the tables count episodes too in which the remaining wheels cannot do the task.
    folder
        Folder of stored results, as of :func:`~ftac_gym.evaluation.evaluate`. None stores nothing.
    progress
        Called with the name of the policy and the number of episodes of each finished batch.

    Raises
    ------
    FlightError
        If a policy fails in flight; the message names policy, scenario and episode.
    ValueError
        If there is no list of policies, two have one name, or the reference is not among them. If a policy does not fit
        the scenario: its name stands first.
    """
    listed = isinstance(policies, (list, tuple, Mapping))
    require(listed, "policies", "must be a list of policies, or a dict of them by name", policies)
    pairs = policies.items() if isinstance(policies, Mapping) else [(policy_label(item), item) for item in policies]
    named = dict(pairs)
    require(
        0 < len(named) == len(pairs), "policies", "must be given, with names that differ", [name for name, _ in pairs]
    )
    chosen = next(iter(named)) if reference is None else reference
    require(chosen in named, "reference", f"must be one of {list(named)}", chosen)
    task = scenarios.resolve(scenario)
    flown = {}
    for name, policy in named.items():
        try:
            flown[name] = resolve(policy, task.name)
            check_fit(flown[name], [task])
        except ValueError as error:
            raise ValueError(f"{name}: {error}") from None
    drawn = judging_episodes(task, episodes)

    def report(name: str) -> Callable[[int], None] | None:
        return None if progress is None else lambda count: progress(name, count)

    found = [evaluate(task, policy, drawn, name, folder, report(name)) for name, policy in flown.items()]
    counted = np.ones(len(drawn), dtype=np.bool_) if count_infeasible else drawn.feasible
    return Comparison(task, drawn, tuple(found), chosen, tuple(tabulate(found, chosen, counted)))
