"""Render modes of the environments."""

import copy
import pickle
import warnings

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.wrappers import RecordVideo

import ftac_gym  # noqa: F401  registers the ids

IDS = [name for name in gym.registry if name.startswith("SpacecraftFTC")]


@pytest.fixture(autouse=True)
def no_screen(monkeypatch):
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")


@pytest.mark.parametrize("name", IDS)
def test_every_id_renders_in_both_modes(name):
    env = gym.make(name, render_mode="rgb_array", width=480, height=360)
    env.reset(seed=0)
    first = env.render()
    for _ in range(20):
        env.step(env.action_space.sample())
    assert first.shape == (360, 480, 3) and (env.render() != first).any()
    period = env.unwrapped.scenario.control_period
    assert env.metadata["render_fps"] == pytest.approx(1.0 / period)
    env.close()
    env.close()
    human = gym.make(name, render_mode="human")
    human.reset(seed=0)
    human.step(human.action_space.sample())
    assert human.render() is None
    human.close()
    human.close()


def test_gymnasium_checks_the_render_modes():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(gym.make("SpacecraftFTC-v0").unwrapped)


def test_vector_environments_give_a_frame_of_each_craft():
    env = gym.make_vec("SpacecraftFTC-v0", num_envs=3, render_mode="rgb_array")
    env.reset(seed=4)
    frames = env.render()
    assert isinstance(frames, tuple) and [frame.shape for frame in frames] == [(480, 640, 3)] * 3
    single = gym.make("SpacecraftFTC-v0", render_mode="rgb_array")
    single.reset(seed=5)
    np.testing.assert_array_equal(frames[1], single.render())
    assert (frames[0] != frames[1]).any()
    env.close()
    env.close()
    tiles = gym.make_vec("SpacecraftFTC-v0", num_envs=3, render_mode="human")
    tiles.reset(seed=4)
    assert tiles.render() is None
    tiles.close()


def test_the_name_of_the_policy_is_shown():
    env = gym.make("SpacecraftFTC-v0", render_mode="rgb_array")
    env.reset(seed=0)
    nameless = env.render()
    env.unwrapped.policy_name = "ppo"
    assert (env.render() != nameless).any()


def test_looking_changes_nothing():
    seen, unseen = gym.make("SpacecraftFTC-v0", render_mode="rgb_array"), gym.make("SpacecraftFTC-v0")
    for env in (seen, unseen):
        env.action_space.seed(0)
        env.reset(seed=2)
    for _ in range(30):
        seen.render()
        ours, theirs = seen.step(seen.action_space.sample()), unseen.step(unseen.action_space.sample())
        np.testing.assert_array_equal(ours[0], theirs[0])


def test_copies_render_for_themselves():
    env = gym.make("SpacecraftFTC-v0", render_mode="rgb_array").unwrapped
    env.reset(seed=0)
    frame = env.render()
    for other in (copy.deepcopy(env), pickle.loads(pickle.dumps(env))):
        np.testing.assert_array_equal(other.render(), frame)


def test_without_a_mode_there_is_a_warning_and_nothing_else():
    env = gym.make("SpacecraftFTC-v0").unwrapped
    env.reset(seed=0)
    with pytest.warns(UserWarning, match='render_mode="rgb_array"'):
        assert env.render() is None


@pytest.mark.filterwarnings("ignore")
def test_gymnasium_records_a_film(tmp_path):
    env = RecordVideo(gym.make("SpacecraftFTC-v0", render_mode="rgb_array", duration=25.0), str(tmp_path))
    env.reset(seed=0)
    done = False
    while not done:
        *_, terminated, truncated, _ = env.step(env.action_space.sample())
        done = terminated or truncated
    env.close()
    films = list(tmp_path.glob("*.mp4"))
    assert len(films) == 1 and films[0].read_bytes()[4:8] == b"ftyp"
