"""PPO with the package's hyperparameters learns the easy task within seconds, from scratch."""

from stable_baselines3.common.vec_env import VecNormalize

from ftac_gym import scenarios
from ftac_gym.agents.agent import Agent
from ftac_gym.evaluation import rollout
from ftac_gym.training.algorithms import build
from ftac_gym.training.environments import training_environment
from ftac_gym.training.hyperparameters import CONFIGS, read_hyperparameters

ID = "SpacecraftFTCEasy-v0"


def success_of(model, interface):
    return rollout("easy", Agent.of(model, interface), seed=1, count=100).metrics()["success"].mean()


def test_a_direct_agent_learns_the_easy_task():
    """The file's run is three times as long; the deterministic agent succeeds long before its end."""
    parameters = read_hyperparameters(CONFIGS / "ppo.yml", ID)
    assert parameters.interface.wrappers == () and parameters.normalize
    task = scenarios.get("easy")
    env, size = training_environment(ID, task, parameters.interface, parameters.n_envs, task)
    around = VecNormalize(env, gamma=parameters.settings["gamma"])
    around.seed(1000)
    model = build("ppo", parameters, around, size, seed=0)
    assert success_of(model, parameters.interface) < 0.05
    model.learn(170_000)
    assert success_of(model, parameters.interface) >= 0.95
