"""Diagnosis of faults on the command line."""

from collections.abc import Mapping
from functools import partial

from rich.console import Console

from ftac_gym.evaluation import diagnose
from ftac_gym.evaluation.diagnosis import (
    check_estimates,
    detection_rows,
    diagnosis_rows,
    diagnosis_table,
    kinds_table,
)
from ftac_gym.evaluation.files import CsvRows
from ftac_gym.evaluation.tables import Cells
from ftac_gym.policies import Policy
from ftac_gym.task.episodes import Episodes
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.console import one_line_warnings, print_line, progress_bar


def estimating(policies: Mapping[str, Policy], scenario: Scenario) -> tuple[dict[str, Policy], list[str]]:
    """Return the policies with estimates that a diagnosis judges, and a line about each other one.

    Raises
    ------
    SystemExit
        If there is none.
    """
    found, lines = {}, []
    for name, policy in policies.items():
        try:
            check_estimates(policy, scenario, name)
            found[name] = policy
        except ValueError as error:
            lines.append(f"no diagnosis: {error}")
    if not found:
        raise SystemExit("\n".join(["--diagnosis: none of the policies has estimates to judge", *lines]))
    return found, lines


def diagnosed(
    policies: Mapping[str, Policy], scenario: Scenario, episodes: Episodes, console: Console
) -> tuple[dict[str, Cells], dict[str, CsvRows]]:
    """Judge the estimates of policies with progress.

    Returns
    -------
    Tables by title and rows of CSV files by name; none without policies.
    """
    if not policies:
        return {}, {}
    found = []
    with progress_bar(console) as progress, one_line_warnings(partial(print_line, progress.console)):
        bar = progress.add_task("diagnosis", total=len(episodes) * len(policies))
        for name, policy in policies.items():
            found.append(diagnose(scenario, policy, episodes, name=name, progress=partial(progress.advance, bar)))
    title = f"diagnosis of faults, all {len(episodes)} episodes"
    cells = {f"{title}: 95 % intervals": diagnosis_table(found), f"{title}: by kind of fault": kinds_table(found)}
    return cells, {"diagnosis": diagnosis_rows(found), "diagnosed_faults": detection_rows(found)}
