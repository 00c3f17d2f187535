"""Episodes on which policies are judged: a frozen list of a split, or episodes drawn from the seed of such lists."""

from ftac_gym import scenarios
from ftac_gym.scenarios import SPLITS, frozen
from ftac_gym.task.episodes import Episodes
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import whole

FEASIBLE = 100
"""Feasible episodes of an evaluation that names none."""


def judging_episodes(scenario: Scenario, episodes: Episodes | int = FEASIBLE, kind: frozen.Kind = "test") -> Episodes:
    """Return the episodes on which policies are judged.

    Parameters
    ----------
    scenario
        The task.
    episodes
        Episodes, which are returned; or the number of feasible ones. A split of the flagship, as it is in the library,
        has those of its frozen list. Other scenarios have those drawn from the seed of the flagship's list, 10000 for
        the test and 20000 for validation. The infeasible ones between them are returned too.
    kind
        ``"validation"`` to choose by, ``"test"`` for the last table.

    Raises
    ------
    ValueError
        If the number is not a positive integer, the frozen list is shorter, too few episodes of the scenario are
        feasible, or the kind is unknown.
    """
    if isinstance(episodes, Episodes):
        return episodes
    feasible = whole(episodes, 1, "episodes")
    if is_split(scenario):
        return frozen.load(scenario.name, feasible, kind)
    try:
        return frozen.draw_feasible(scenario, frozen.seed_of("flagship", kind), feasible)
    except ValueError as error:
        raise ValueError(f"{error}; give episodes, for example scenario.draw(0, {feasible})") from None


def is_split(scenario: Scenario) -> bool:
    """Tell whether a scenario is a split of the flagship as it is in the library, so that frozen lists are its own."""
    return scenario.name in SPLITS and scenarios.get(scenario.name).to_json() == scenario.to_json()
