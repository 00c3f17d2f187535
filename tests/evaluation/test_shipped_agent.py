"""The agent that comes with the package: it loads, it flies, and it is worth having."""

import json

import numpy as np

from ftac_gym import scenarios
from ftac_gym.evaluation import rollout
from ftac_gym.evaluation.agent import CARD_FILE, SHIPPED, Agent

FOLDER = SHIPPED / "flagship_residual"


def test_the_card_tells_how_it_was_made():
    card = json.loads((FOLDER / CARD_FILE).read_text())
    assert card["command"].startswith("python train/train.py")
    assert len(card["commit"]) >= 12
    assert "dirty" not in card["commit"]
    assert card["interface"]["gains"], "the gains of the base are written down"


def test_it_is_small():
    assert sum(path.stat().st_size for path in FOLDER.iterdir()) < 1_000_000


def test_it_beats_its_base_on_fresh_episodes():
    agent = Agent.load(FOLDER)
    episodes = scenarios.get("flagship").draw(20_000, 200)
    feasible = episodes.feasible
    flown = rollout("flagship", agent, episodes).metrics()
    base = rollout("flagship", "pd_dob", episodes).metrics()
    assert np.mean((flown["integrated_error"] - base["integrated_error"])[feasible]) < 0.0
    assert np.mean((flown["success"] - base["success"])[feasible]) > -0.02
