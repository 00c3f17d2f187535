"""Every way in which a user names a policy."""

import shutil

import gymnasium as gym
import numpy as np
import pytest
from helpers.custom_baseline import CustomBaseline
from stable_baselines3 import PPO
from stable_baselines3.common.vec_env import DummyVecEnv, VecNormalize

from ftac_gym import baselines, scenarios
from ftac_gym.agents.agent import Agent
from ftac_gym.agents.shipped import SHIPPED, best_agent, seeds
from ftac_gym.evaluation import evaluate, rollout
from ftac_gym.policies import DeferredBaseline, PolicyRunner, resolve

SHORT = scenarios.get("flagship").replace(duration=3.0)
GAINS = np.array([[-1.0, 0.2, 0.1], [0.3, 1.0, 0.2], [0.1, 0.0, -0.9], [0.2, 0.2, 0.2]])


def function(observation):
    return np.tanh(GAINS @ observation[:3])


class Predictor:
    """The same on many observations, with Stable-Baselines3's signature."""

    def __init__(self):
        self.starts = []

    def predict(self, observation, state=None, episode_start=None, deterministic=False):
        assert deterministic
        self.starts.append((state, episode_start.tolist()))
        return np.tanh(observation[:, :3] @ GAINS.T), (state or 0) + 1


@pytest.mark.parametrize(
    ("named", "law", "gains"),
    [
        ("pd", "pd", "default"),
        ("pd tuned", "pd", "tuned"),
        ("helpers.custom_baseline:CustomBaseline", "helpers.custom_baseline:CustomBaseline", "default"),
        (CustomBaseline, CustomBaseline, "default"),
    ],
)
def test_baselines(named, law, gains):
    policy = resolve(named)
    assert isinstance(policy, DeferredBaseline)
    assert (policy.name, policy.gains, policy.tier) == (law, gains, "attitude")
    assert resolve(policy) is policy


def test_the_gains_of_baselines_that_do_not_name_theirs():
    assert resolve("pd", gains="tuned").fingerprint == resolve("pd tuned").fingerprint != resolve("pd").fingerprint


def test_a_baseline_is_built_when_it_is_attached():
    runner = PolicyRunner(SHORT, resolve("pd_dob"), num_spacecraft=3)
    built = runner.policy.baseline
    assert isinstance(built, baselines.baseline_class("pd_dob")) and built.num_spacecraft == 3


def test_a_baseline_that_flies_twice_at_once_is_two():
    policy = resolve("pd_dob")
    runners = [PolicyRunner(SHORT, policy) for _ in range(2)]
    for seed, runner in enumerate(runners):
        runner.reset(SHORT.draw(seed, 1))
    together = [[runner.step() for runner in runners] for _ in range(5)]
    for seed in range(2):
        runner = PolicyRunner(SHORT, policy)
        runner.reset(SHORT.draw(seed, 1))
        for rewards in together:
            np.testing.assert_array_equal(runner.step(), rewards[seed])


@pytest.mark.parametrize(
    ("name", "scenario", "design"),
    [
        ("agent", "flagship_severe", "flagship_residual"),
        ("agent", "flexible", "flexible_residual"),
        ("flagship_direct", "flexible", "flagship_direct"),
    ],
)
def test_shipped_agents(name, scenario, design):
    assert resolve(name, scenario).fingerprint == Agent.load(best_agent(SHIPPED / design)).fingerprint


def test_paths_of_agents(tmp_path):
    seed = seeds(SHIPPED / "flagship_residual")[0]
    expected = Agent.load(seed).fingerprint
    shutil.copytree(seed, tmp_path / "run" / "agent")
    for path in (seed, str(seed), tmp_path / "run", tmp_path / "run" / "agent"):
        assert resolve(path).fingerprint == expected
    best = resolve(SHIPPED / "flagship_residual")
    assert best.fingerprint == resolve("agent").fingerprint


def test_functions_and_objects_with_predict_fly_alike():
    predictor = Predictor()
    one, other = (rollout(SHORT, policy, seed=2, count=3) for policy in (function, predictor))
    np.testing.assert_allclose(one.command, other.command, rtol=1e-6)
    assert predictor.starts[:2] == [(None, [True] * 3), (1, [False] * 3)] and len(predictor.starts) == SHORT.horizon
    assert evaluate(SHORT, function, SHORT.draw(2, 3), name="mine").policy == "mine"


def test_an_object_with_predict_may_name_its_tier():
    class Telemetry(Predictor):
        tier = "telemetry"

        def predict(self, observation, **rest):
            assert observation.shape == (
                2,
                gym.make("SpacecraftFTC-v0", observation="telemetry").observation_space.shape[0],
            )
            return super().predict(observation, **rest)

    rollout(SHORT.replace(duration=0.3), Telemetry(), count=2)


def test_a_live_model_flies_with_its_normaliser(tmp_path):
    env = VecNormalize(DummyVecEnv([lambda: gym.make("SpacecraftFTC-v0", duration=3.0)]))
    model = PPO("MlpPolicy", env, n_steps=16, batch_size=16, n_epochs=1, seed=0, device="cpu").learn(32)
    Agent.of(model).save(tmp_path)
    live, stored = (rollout(SHORT, policy, seed=1, count=2) for policy in (model, tmp_path))
    np.testing.assert_array_equal(live.command, stored.command)
    with pytest.raises(ValueError, match="agent must have been trained on observations of"):
        rollout("flexible", PPO("MlpPolicy", "Pendulum-v1", device="cpu"))


@pytest.mark.parametrize(
    ("policy", "message"),
    [
        ("nobody", r"policy must be 'agent', a shipped agent \(flagship_direct, .*\), one of .*names\(\), .*'nobody'"),
        ("nobody tuned", r"policy must be 'agent', .*got 'nobody tuned'"),
        ("chen_m2 tuned", "gains must be tuned first"),
        (3, r"policy must be a name, a path, .* or a function"),
        (dict, r"policy must be a name, .*got <class 'dict'>"),
    ],
)  # fmt: skip
def test_what_is_refused(policy, message):
    with pytest.raises(ValueError, match=message):
        resolve(policy)


def test_baselines_that_are_built_are_refused():
    built = baselines.make("pd", SHORT)
    with pytest.raises(ValueError, match=r"a Baseline class \(not an instance\)"):
        resolve(built)
    with pytest.raises(ValueError, match=r"policy must be .*BaselinePolicy"):
        resolve(built.as_policy(gym.make("SpacecraftFTC-v0")))


@pytest.mark.parametrize("name", ["pd_dobb", "nobody", "x" * 5000])
def test_an_unknown_name_is_one_short_message_that_says_where_all_names_are(name):
    for use in (resolve, lambda text: baselines.make(text, SHORT)):
        with pytest.raises(ValueError, match=r"ftac_gym\.baselines\.names\(\), such as ") as caught:
            use(name)
        assert len(str(caught.value)) <= 500
    if name == "pd_dobb":
        assert "such as pd_dob," in str(caught.value)
