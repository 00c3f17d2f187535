"""The agents that come with the package: they load, they fly, and they are worth having."""

from functools import lru_cache

import numpy as np
import pytest

from ftac_gym import baselines, scenarios
from ftac_gym.agents.agent import Agent
from ftac_gym.agents.shipped import SHIPPED, agent_folders, best_agent, designs, evaluations, seeds
from ftac_gym.agents.storage import read_card
from ftac_gym.evaluation import rollout
from ftac_gym.policies.policy import DeferredBaseline
from ftac_gym.policies.resolve import agent_path

EPISODES = 20_000  # a seed that neither training nor tuning nor the reported tests use
ALL = [pytest.param(seed, id=f"{name}/{seed.name}") for name in designs() for seed in seeds(SHIPPED / name)]


def flight(policy, scenario, count):
    """Return the metrics in feasible episodes."""
    episodes = scenarios.get(scenario).draw(EPISODES, count)
    metrics = rollout(scenario, policy, episodes).metrics()
    return {name: values[episodes.feasible] for name, values in metrics.items()}


@lru_cache
def flown(design, scenario, count):
    """Return the metrics of the best agent and of its base, with the gains of its card, in feasible episodes."""
    folder = best_agent(SHIPPED / design)
    wrapped = dict(read_card(folder)["interface"]["wrappers"]).get("ResidualPolicy", {"base": "pd_dob"})
    own = {name: value for name, value in wrapped.items() if name in baselines.defaults(wrapped["base"])}
    return flight(folder, scenario, count), flight(DeferredBaseline(wrapped["base"], **own), scenario, count)


def test_what_is_shipped():
    assert designs() == ["flagship_direct", "flagship_residual", "flagship_telemetry", "flexible_residual"]
    assert len(seeds(SHIPPED / "flagship_residual")) == 2
    with pytest.raises(ValueError, match=r"policy must be .* a shipped agent \(flagship_direct, .*got 'nobody'"):
        agent_path("nobody")


@pytest.mark.parametrize("folder", ALL)
def test_the_card_tells_how_it_was_made(folder):
    card = read_card(folder)
    assert card["command"].startswith(("ftac-train ", "python train/train.py "))
    assert " /" not in card["command"]  # no path of the machine
    assert len(card["commit"]) >= 12
    assert "dirty" not in card["commit"]
    assert str(card["seed"]) == folder.name.removeprefix("seed_")
    for name, arguments in card["interface"]["wrappers"]:
        assert name != "ResidualPolicy" or arguments.keys() >= {"base", "position_gain"}, "the gains are written down"
    assert Agent.load(folder).information in ("attitude", "telemetry")


@pytest.mark.parametrize("folder", ALL)
def test_it_is_small(folder):
    assert sum(path.stat().st_size for path in folder.iterdir()) < 1_000_000


@pytest.mark.parametrize("design", designs())
def test_of_several_seeds_the_best_in_its_own_evaluations_is_chosen(design):
    """By the mean availability, which older runs did not record, and by the mean return in a tie."""
    found = {
        path: max(
            ((row.get("availability", -np.inf), row["mean_return"]) for row in evaluations(path)), default=(0.0, 0.0)
        )
        for path in seeds(SHIPPED / design)
    }
    assert found[best_agent(SHIPPED / design)] == max(found.values())
    assert (SHIPPED / design / "README.md").read_text().startswith(f"# {design}")


@pytest.mark.parametrize("design", ["flagship_residual", "flagship_telemetry"])
def test_the_flagship_s_fly_as_well_as_their_base_on_fresh_episodes(design):
    agent, base = flown(design, "flagship", 300)
    assert np.mean(agent["availability"] - base["availability"]) > -0.005
    assert np.mean(agent["success"] - base["success"]) > -0.02
    assert np.mean(agent["settling_time"] - base["settling_time"]) < 0.5
    assert agent["chatter"].mean() < 1.5 * base["chatter"].mean()
    assert agent["energy"].mean() < 1.2 * base["energy"].mean()


def test_the_direct_one_slews_and_points():
    agent, _ = flown("flagship_direct", "flagship", 100)
    assert np.median(agent["final_error"]) < 0.1


def test_the_agent_of_flexible_spacecraft_flies_as_well_as_its_base():
    agent, base = flown("flexible_residual", "flexible", 200)
    change = sum(
        (agent[metric] - base[metric]) / base[metric].mean() for metric in ("integrated_error", "modal_energy")
    )
    assert np.mean(change) < 0.1
    assert np.mean(agent["availability"] - base["availability"]) > -0.01
    assert np.mean(agent["success"] - base["success"]) > -0.02


def test_copies_beside_the_seeds_are_no_seeds(tmp_path):
    for name in ("seed_10", "seed_0_backup", "seed_2", "seed_", "seed_0", "seed_02", "seed_-1", "seed_1.old", "other"):
        (tmp_path / name / "agent").mkdir(parents=True)
    assert [path.name for path in seeds(tmp_path)] == ["seed_0", "seed_2", "seed_10"]
    assert agent_folders(tmp_path) == [tmp_path / name / "agent" for name in ("seed_0", "seed_2", "seed_10")]
