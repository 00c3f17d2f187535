"""Flights of policies: what an environment for learners refuses, and a flight does not."""

import numpy as np
import pytest

import ftac_gym
from ftac_gym import scenarios
from ftac_gym.evaluation import rollout
from ftac_gym.reproduction.variations import with_limit


def test_a_law_flies_wheels_whose_full_torque_no_learner_may_try():
    strong = with_limit(scenarios.get("flagship").replace(duration=2.0, faults=None), 1e6)
    with pytest.raises(ValueError, match="the rate could reach"):
        ftac_gym.make("SpacecraftFTC-v0", scenario=strong)
    flight = rollout(strong, "pd")
    assert np.isfinite(flight.rate).all() and flight.command.any()
