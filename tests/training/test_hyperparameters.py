"""Hyperparameters: what a file of RL-Zoo's format says, what is changed, and what is refused."""

from pathlib import Path

import gymnasium as gym
import pytest
from stable_baselines3.common.utils import LinearSchedule

from ftac_gym import baselines
from ftac_gym.agents.agent import Interface
from ftac_gym.training.hyperparameters import ALGORITHMS, parse_values, parse_words, read_recipe, written_out

CONFIGS = Path(__file__).parents[2] / "train" / "configs"

FILE = """
default:
  n_timesteps: 1000
  n_envs: 4
SpacecraftFTC-v0:
  env_wrapper:
    - ftac_gym.wrappers.ObservationHistory: {steps: 3}
    - ftac_gym.wrappers.ActionHold: {steps: 4}
  env_kwargs: {observation: telemetry, scenario: flagship_pointing}
  normalize: true
  n_timesteps: !!float 2e6
  n_envs: 64
  policy_kwargs: {log_std_init: -1.0, net_arch: [32]}
  learning_rate: lin_0.001
  gamma: 0.97
"""


@pytest.fixture
def path(tmp_path):
    file = tmp_path / "ppo.yml"
    file.write_text(FILE)
    return file


def test_what_the_file_says(path):
    recipe = read_recipe(path, "SpacecraftFTC-v0")
    assert recipe.interface == Interface("telemetry", (("ObservationHistory", {"steps": 3}),), 4)
    assert (recipe.n_timesteps, recipe.n_envs, recipe.normalize) == (2_000_000, 64, True)
    assert recipe.settings == {"learning_rate": "lin_0.001", "gamma": 0.97}
    assert recipe.env_kwargs == {"scenario": "flagship_pointing"}
    schedule = recipe.arguments()["learning_rate"]
    assert isinstance(schedule, LinearSchedule) and [schedule(left) for left in (1.0, 0.25)] == [1e-3, 2.5e-4]


def test_the_default_stands_in(path):
    recipe = read_recipe(path, "SpacecraftFTCTracking-v0")
    assert recipe.interface == Interface() and not recipe.normalize and recipe.n_envs == 4


def test_changes_reach_into_entries(path):
    changes = parse_values(["policy_kwargs.log_std_init=-2", "gamma=0.9", "learning_rate=1e-4"], "hyperparameters")
    recipe = read_recipe(path, "SpacecraftFTC-v0", changes)
    assert recipe.policy_kwargs == {"log_std_init": -2, "net_arch": [32]}
    assert recipe.settings == {"learning_rate": 1e-4, "gamma": 0.9} == recipe.arguments()


def test_an_unknown_environment_is_refused(path):
    path.write_text(FILE.replace("default", "SpacecraftFTCFlexible-v0"))
    with pytest.raises(ValueError, match=r"env_id must be one of \['SpacecraftFTC-v0', 'SpacecraftFTCFlexible-v0'\]"):
        read_recipe(path, "SpacecraftFTCTracking-v0")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"n_envs": 0}, "n_envs must be a positive integer, got 0"),
        ({"n_timesteps": 1.5}, "n_timesteps must be a positive integer, got 1.5"),
        ({"env_wrapper": ["gymnasium.wrappers.TimeAwareObservation"]}, "env_wrapper must be among .*ActionHold"),
        ({"env_wrapper": [{"ftac_gym.wrappers.ActionHold": {"steps": 0}}]}, "hold must be a positive integer, got 0"),
    ],
)
def test_bad_entries_are_refused(path, changes, message):
    with pytest.raises(ValueError, match=message):
        read_recipe(path, "SpacecraftFTC-v0", changes)


def test_words_of_a_command_line():
    words = ["GainScheduling base=pd ranges={braking_share: [0.5, 0.9]}", "FaultEstimateObservation source=null"]
    assert parse_words(words) == (
        ("GainScheduling", {"base": "pd", "ranges": {"braking_share": [0.5, 0.9]}}),
        ("FaultEstimateObservation", {"source": None}),
    )
    assert parse_words([]) == ()
    with pytest.raises(ValueError, match="wrappers must be words NAME=VALUE, got 'pd'"):
        parse_words(["GainScheduling pd"])
    assert parse_words(["ResidualPolicy base=pd authority=2.0 gains=tuned"]) == (
        ("ResidualPolicy", {"base": "pd", "authority": 2.0, "gains": "tuned"}),
    )


@pytest.mark.parametrize("gains", ["default", "tuned"])
def test_an_interface_is_written_out_with_the_gains_of_its_base(gains):
    short = Interface(wrappers=(("ResidualPolicy", {"base": "pd", "gains": gains, "rate_limit": 0.1}),))
    ((_, arguments),) = written_out(short).wrappers
    expected = {**baselines.defaults("pd"), **baselines.chosen("pd", gains, {}), "rate_limit": 0.1}
    assert arguments == {"base": "pd", **expected}
    assert written_out(written_out(short)) == written_out(short)


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_the_files_of_the_project_can_be_read(algorithm):
    for environment_id in [key for key in gym.registry if key.startswith("SpacecraftFTC")]:
        recipe = read_recipe(CONFIGS / f"{algorithm}.yml", environment_id)
        env = written_out(recipe.interface).wrap(gym.make("SpacecraftFTC-v0", observation=recipe.interface.observation))
        assert env.action_space.shape == (4,) and recipe.n_envs > 1
