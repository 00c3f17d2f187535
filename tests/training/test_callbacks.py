"""Schedules of runs, and resumed off-policy agents."""

import numpy as np
import pytest
from stable_baselines3 import PPO, SAC

from ftac_gym.training.algorithms import resumed_kind
from ftac_gym.training.callbacks import Schedule

GOOD = {
    "evaluate_every": 1,
    "checkpoint_every": 1,
    "evaluation_episodes": 1,
    "evaluation_seed": 900_000,
    "critic_warmup": 0,
}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"evaluate_every": 0}, "evaluate_every must be a positive integer, got 0"),
        ({"checkpoint_every": -1}, "checkpoint_every must be a positive integer, got -1"),
        ({"evaluation_episodes": 0}, "evaluation_episodes must be a positive integer, got 0"),
        ({"severity_start": 2.0}, "severity_start must"),
        ({"evaluation_seed": 10_000}, "evaluation_seed must not be of the frozen test episodes"),
    ],
)
def test_bad_schedules(changes, message):
    with pytest.raises(ValueError, match=message):
        Schedule(**{**GOOD, **changes})


def test_a_resumed_off_policy_agent_acts_by_its_policy_at_once():
    settings = {"learning_starts": 100, "buffer_size": 10, "policy_kwargs": {"net_arch": [4]}}
    model = resumed_kind(SAC)("MlpPolicy", "Pendulum-v1", **settings)
    model._setup_learn(1)
    model.predict = lambda *_, **__: (np.full((1, 1), 0.5, dtype=np.float32), None)
    action, _ = model._sample_action(100, None, 1)
    assert action.item() == 0.5 and type(model).__name__ == "SAC"
    assert resumed_kind(PPO) is PPO
