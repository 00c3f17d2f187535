"""The agents that come with the package: they load, they fly, and they are worth having."""

import json

import numpy as np
import pytest

from ftac_gym import scenarios
from ftac_gym.evaluation import rollout
from ftac_gym.evaluation.agent import CARD_FILE, SHIPPED, Agent

EPISODES = 20_000  # a seed that neither training nor tuning nor the reported tests use
every = pytest.mark.parametrize("name", ["flagship", "flexible"])


def folder(name):
    return SHIPPED / f"{name}_residual"


def flown(name, count):
    """Return the metrics of the agent and of its base in feasible episodes, which of them are meant being the third."""
    episodes = scenarios.get(name).draw(EPISODES, count)
    policies = (Agent.load(folder(name)), "pd_dob")
    return *(rollout(name, policy, episodes).metrics() for policy in policies), episodes.feasible


@every
def test_the_card_tells_how_it_was_made(name):
    card = json.loads((folder(name) / CARD_FILE).read_text())
    assert card["command"].startswith("python train/train.py")
    assert " /" not in card["command"]  # no path of the machine
    assert len(card["commit"]) >= 12
    assert "dirty" not in card["commit"]
    base = card["interface"]["wrappers"][0][1]
    assert base.keys() >= {"base", "position_gain"}, "the gains of the base are written down"


@every
def test_it_is_small(name):
    assert sum(path.stat().st_size for path in folder(name).iterdir()) < 1_000_000


def test_the_flagship_s_beats_its_base_on_fresh_episodes():
    agent, base, feasible = flown("flagship", 200)
    assert np.mean((agent["integrated_error"] - base["integrated_error"])[feasible]) < 0.0
    assert np.mean((agent["success"] - base["success"])[feasible]) > -0.02


def test_the_flexible_craft_s_leaves_less_vibration_than_its_base_on_fresh_episodes():
    agent, base, feasible = flown("flexible", 200)
    change = sum(
        (agent[metric] - base[metric])[feasible] / base[metric][feasible].mean()
        for metric in ("integrated_error", "modal_energy")
    )
    assert np.mean(change) + 2.0 * np.std(change) / np.sqrt(len(change)) < 0.0
    assert np.mean((agent["success"] - base["success"])[feasible]) > -0.02
