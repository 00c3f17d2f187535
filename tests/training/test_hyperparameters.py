"""Hyperparameters: files in the format of RL Baselines3 Zoo, changes, and refusals."""

import gymnasium as gym
import pytest
from stable_baselines3.common.utils import LinearSchedule

from ftac_gym import baselines
from ftac_gym.agents.interface import Interface
from ftac_gym.baselines import observers
from ftac_gym.training.hyperparameters import (
    ALGORITHMS,
    CONFIGS,
    parse_assignments,
    read_hyperparameters,
    with_base_gains,
    wrappers_from_text,
)
from ftac_gym.wrappers.fault_estimate import source_gains

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
    hyperparameters = read_hyperparameters(path, "SpacecraftFTC-v0")
    assert hyperparameters.interface == Interface("telemetry", (("ObservationHistory", {"steps": 3}),), 4)
    assert (hyperparameters.n_timesteps, hyperparameters.n_envs, hyperparameters.normalize) == (2_000_000, 64, True)
    assert hyperparameters.settings == {"learning_rate": "lin_0.001", "gamma": 0.97}
    assert hyperparameters.env_kwargs == {"scenario": "flagship_pointing"}
    schedule = hyperparameters.arguments()["learning_rate"]
    assert isinstance(schedule, LinearSchedule) and [schedule(left) for left in (1.0, 0.25)] == [1e-3, 2.5e-4]


def test_the_default_stands_in(path):
    hyperparameters = read_hyperparameters(path, "SpacecraftFTCTracking-v0")
    assert hyperparameters.interface == Interface() and not hyperparameters.normalize and hyperparameters.n_envs == 4


def test_changes_reach_into_entries(path):
    changes = parse_assignments(["policy_kwargs.log_std_init=-2", "gamma=0.9", "learning_rate=1e-4"], "hyperparameters")
    hyperparameters = read_hyperparameters(path, "SpacecraftFTC-v0", changes)
    assert hyperparameters.policy_kwargs == {"log_std_init": -2, "net_arch": [32]}
    assert hyperparameters.settings == {"learning_rate": 1e-4, "gamma": 0.9} == hyperparameters.arguments()


def test_an_unknown_environment_is_refused(path):
    path.write_text(FILE.replace("default", "SpacecraftFTCFlexible-v0"))
    with pytest.raises(ValueError, match=r"env_id must be one of \['SpacecraftFTC-v0', 'SpacecraftFTCFlexible-v0'\]"):
        read_hyperparameters(path, "SpacecraftFTCTracking-v0")


@pytest.mark.parametrize("text", ["default: {n_envs: 4", "- default", "default: 4", "", "a: !!python/name:os.system"])
def test_a_damaged_file_is_one_line(path, text):
    path.write_text(text)
    message = rf"^{path} cannot be read: [^\n]*; correct it$"
    with pytest.raises(ValueError, match=message):
        read_hyperparameters(path, "SpacecraftFTC-v0")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"n_envs": 0}, "n_envs must be a positive integer, got 0"),
        ({"n_timesteps": 1.5}, "n_timesteps must be a positive integer, got 1.5"),
        ({"env_wrapper": ["gymnasium.wrappers.TimeAwareObservation"]}, "env_wrapper must be among .*ActionHold"),
        ({"env_wrapper": [{"ftac_gym.wrappers.ActionHold": {"steps": 0}}]}, "steps of ActionHold must be .*, got 0"),
    ],
)
def test_bad_entries_are_refused(path, changes, message):
    with pytest.raises(ValueError, match=message):
        read_hyperparameters(path, "SpacecraftFTC-v0", changes)


def test_words_of_a_command_line():
    words = ["GainScheduling base=pd ranges={braking_share: [0.5, 0.9]}", "FaultEstimateObservation source=null"]
    assert wrappers_from_text(words) == (
        ("GainScheduling", {"base": "pd", "ranges": {"braking_share": [0.5, 0.9]}}),
        ("FaultEstimateObservation", {"source": None}),
    )
    assert wrappers_from_text([]) == ()
    with pytest.raises(ValueError, match="wrappers must be words NAME=VALUE, got 'pd'"):
        wrappers_from_text(["GainScheduling pd"])
    assert wrappers_from_text(["ResidualPolicy base=pd authority=2.0 gains=tuned"]) == (
        ("ResidualPolicy", {"base": "pd", "authority": 2.0, "gains": "tuned"}),
    )


@pytest.mark.parametrize("gains", ["default", "tuned"])
def test_an_interface_is_with_base_gains_with_the_gains_of_its_base(gains):
    short = Interface(wrappers=(("ResidualPolicy", {"base": "pd", "gains": gains, "rate_limit": 0.1}),))
    ((_, arguments),) = with_base_gains(short).wrappers
    expected = {**baselines.defaults("pd"), **baselines.chosen("pd", gains, {}), "rate_limit": 0.1}
    assert arguments == {"base": "pd", **expected}
    assert with_base_gains(with_base_gains(short)) == with_base_gains(short)


@pytest.mark.parametrize("source", [*observers.names(), "dob", "truth", None])
def test_an_interface_has_the_gains_of_its_observer(source):
    short = Interface(wrappers=(("FaultEstimateObservation", {"source": source}),))
    ((_, arguments),) = with_base_gains(short).wrappers
    assert arguments.keys() == {"source", *source_gains(source)}
    assert (len(arguments) > 1) == (source not in ("truth", None))
    assert with_base_gains(with_base_gains(short)) == with_base_gains(short)
    given = Interface(wrappers=(("FaultEstimateObservation", {"source": "dob", "bandwidth": 7.0}),))
    assert with_base_gains(given) == given


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_the_files_of_the_project_can_be_read(algorithm):
    for environment_id in [key for key in gym.registry if key.startswith("SpacecraftFTC")]:
        hyperparameters = read_hyperparameters(CONFIGS / f"{algorithm}.yml", environment_id)
        env = with_base_gains(hyperparameters.interface).wrap(
            gym.make("SpacecraftFTC-v0", observation=hyperparameters.interface.observation)
        )
        assert env.action_space.shape == (4,) and hyperparameters.n_envs > 1
