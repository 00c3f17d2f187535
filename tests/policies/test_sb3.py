"""Saved models of Stable-Baselines3 and sb3-contrib are scored as their own prediction loop flies them."""

import sys
from types import ModuleType

import pytest
import sb3_contrib
import stable_baselines3 as sb3
from helpers.parity import EPISODES, SHORT, assert_scored_alike, flown_by_sb3, make
from stable_baselines3.common.vec_env import DummyVecEnv, VecNormalize

from ftac_gym.evaluation import rollout
from ftac_gym.evaluation.threads import one_torch_thread
from ftac_gym.policies import load_sb3


def small(**settings):
    """Return arguments of a small network; models change theirs."""
    return {"policy_kwargs": {"net_arch": [8]}, "seed": 1, "device": "cpu", **settings}


MODELS = {
    "PPO": (sb3.PPO, "MlpPolicy", {"n_steps": 32, "batch_size": 32, "n_epochs": 1, "use_sde": True}),
    "A2C": (sb3.A2C, "MlpPolicy", {}),
    "DDPG": (sb3.DDPG, "MlpPolicy", {"learning_starts": 30}),
    "TQC": (sb3_contrib.TQC, "MlpPolicy", {"learning_starts": 30}),
    "CrossQ": (sb3_contrib.CrossQ, "MlpPolicy", {"learning_starts": 30}),
    "TRPO": (sb3_contrib.TRPO, "MlpPolicy", {"n_steps": 32, "batch_size": 32}),
    "RecurrentPPO": (
        sb3_contrib.RecurrentPPO, "MlpLstmPolicy",
        {"n_steps": 32, "batch_size": 32, "n_epochs": 1, "policy_kwargs": {"lstm_hidden_size": 8}},
    ),
    "ARS": (sb3_contrib.ARS, "LinearPolicy", {"n_delta": 1, "policy_kwargs": None}),
}  # fmt: skip


@pytest.mark.parametrize("name", MODELS)
def test_every_algorithm(name, tmp_path):
    algorithm, policy, settings = MODELS[name]
    env = VecNormalize(DummyVecEnv([lambda: make("telemetry", 3)]))
    with one_torch_thread():
        model = algorithm(policy, env, **small(**settings)).learn(32)
    model.save(tmp_path / "model.zip")
    env.save(str(tmp_path / "vecnormalize.pkl"))
    fresh = VecNormalize.load(
        str(tmp_path / "vecnormalize.pkl"), DummyVecEnv([lambda: make("telemetry", 3)] * len(EPISODES))
    )
    fresh.training = fresh.norm_reward = False
    expected = flown_by_sb3(algorithm.load(tmp_path / "model.zip", device="cpu"), fresh, hold=3)
    assert_scored_alike(f"sb3:{tmp_path / 'model'} hold=3 observation=telemetry", *expected)


def test_the_normaliser_is_one_beside_the_model_or_the_given_one(tmp_path):
    env = VecNormalize(DummyVecEnv([make]))
    model = sb3.PPO("MlpPolicy", env, n_steps=32, batch_size=32, n_epochs=1, **small()).learn(32)
    model.save(tmp_path / "model.zip")
    assert load_sb3(tmp_path / "model.zip").normalizer is None
    env.save(str(tmp_path / "statistics.pkl"))
    assert load_sb3(tmp_path / "model.zip", normalizer=tmp_path / "statistics.pkl").normalizer is not None
    with pytest.raises(ValueError, match="normalizer must be a file"):
        load_sb3(tmp_path / "model.zip", normalizer=tmp_path / "absent.pkl")
    (tmp_path / "vecnormalize.pkl").write_bytes(b"torn")
    with pytest.raises(ValueError, match=r"vecnormalize\.pkl cannot be read: .*; load it with the version"):
        load_sb3(tmp_path / "model.zip")
    (tmp_path / "model.zip").write_bytes(b"torn")
    with pytest.raises(ValueError, match=r"model\.zip cannot be read: .*; load it with the versions of Python"):
        load_sb3(tmp_path / "model.zip")


def test_a_missing_library_is_named_with_its_installation(tmp_path, monkeypatch):
    policy = type("PPOPolicy", (sb3.ppo.MlpPolicy,), {"__module__": "sbx.ppo.policies"})
    with monkeypatch.context() as context:
        for name in ("sbx", "sbx.ppo", "sbx.ppo.policies"):
            context.setitem(sys.modules, name, ModuleType(name))
        sys.modules["sbx.ppo.policies"].PPOPolicy = policy
        sb3.PPO(policy, make(), n_steps=32, batch_size=32, **small()).save(tmp_path / "model.zip")
    monkeypatch.setitem(sys.modules, "sbx", None)
    with pytest.raises(ImportError, match=r"model\.zip needs sbx: pip install sbx-rl$"):
        load_sb3(tmp_path / "model.zip")


def test_a_normaliser_that_is_no_path_is_refused(tmp_path):
    sb3.PPO("MlpPolicy", make(), **small()).save(tmp_path / "model")
    with pytest.raises(ValueError, match="normalizer must be a file or None, got 3"):
        load_sb3(tmp_path / "model", normalizer=3)


def test_a_model_of_another_tier_is_refused(tmp_path):
    sb3.PPO("MlpPolicy", make("telemetry"), n_steps=32, batch_size=32, **small()).save(tmp_path / "model.zip")
    with pytest.raises(ValueError, match="agent must have been trained on observations of 22 entries"):
        rollout(SHORT, f"sb3:{tmp_path / 'model.zip'}")
