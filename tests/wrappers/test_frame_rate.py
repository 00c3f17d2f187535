"""Speed of recorded videos: as many seconds as the episode has, whatever holds the actions."""

import gymnasium as gym
import numpy as np
import pytest
from imageio.v3 import immeta
from stable_baselines3.common.vec_env import DummyVecEnv, VecNormalize, VecVideoRecorder

from ftac_gym.envs import SpacecraftFTCEnv, SpacecraftFTCVectorEnv
from ftac_gym.wrappers import ActionHold, ResidualPolicy, SB3VecEnv

SETTINGS = {"control_period": 0.2, "duration": 30.0, "render_mode": "rgb_array", "width": 320, "height": 240}
SECONDS = 4.0


def duration(folder):
    """Return the length of the only video of a folder [s]."""
    (path,) = folder.glob("*.mp4")
    return immeta(path, plugin="FFMPEG")["duration"]


def adapter(hold, wrap=lambda env: env):
    return SB3VecEnv(wrap(SpacecraftFTCVectorEnv(2, autoreset_mode="SameStep", **SETTINGS)), hold)


@pytest.mark.parametrize(
    ("make", "hold"),
    [
        (lambda: adapter(1), 1),
        (lambda: adapter(5, ResidualPolicy), 5),
        (lambda: VecNormalize(adapter(5)), 5),
        (lambda: DummyVecEnv([lambda: SpacecraftFTCEnv(**SETTINGS)]), 1),
        (lambda: DummyVecEnv([lambda: ActionHold(SpacecraftFTCEnv(**SETTINGS), 5)]), 5),
    ],
    ids=["SB3VecEnv", "SB3VecEnv with hold", "VecNormalize", "DummyVecEnv", "DummyVecEnv of ActionHold"],
)
def test_videos_of_stable_baselines(make, hold, tmp_path):
    env = make()
    steps = round(SECONDS / (0.2 * hold))
    env = VecVideoRecorder(env, str(tmp_path), lambda step: step == 0, video_length=steps)
    env.reset()
    for _ in range(steps):
        env.step(np.zeros((env.num_envs, 4)))
    env.close()
    frame = 0.2 * hold
    assert duration(tmp_path) == pytest.approx(SECONDS + frame, abs=0.1 * frame)  # and the start


@pytest.mark.parametrize(("kind", "hold"), [("single", 1), ("single", 5), ("vector", 1)])
def test_videos_of_gymnasium(kind, hold, tmp_path):
    tmp_path = tmp_path / "videos"
    steps = round(SECONDS / (0.2 * hold))
    arguments = {"video_folder": str(tmp_path), "episode_trigger": lambda episode: episode == 0, "video_length": steps}
    if kind == "single":
        env = gym.wrappers.RecordVideo(ActionHold(ResidualPolicy(SpacecraftFTCEnv(**SETTINGS)), hold), **arguments)
    else:
        env = gym.wrappers.vector.RecordVideo(SpacecraftFTCVectorEnv(2, **SETTINGS), **arguments)
    env.reset(seed=0)
    for _ in range(steps):
        env.step(np.zeros(env.action_space.shape))
    env.close()
    assert duration(tmp_path) == pytest.approx(SECONDS + 0.2 * hold, abs=0.02 * hold)


def test_the_frame_rate_is_that_of_the_actions():
    for hold in (1, 4):
        assert adapter(hold).metadata["render_fps"] == pytest.approx(5.0 / hold)
        assert ActionHold(SpacecraftFTCEnv(**SETTINGS), hold).metadata["render_fps"] == pytest.approx(5.0 / hold)
    assert ActionHold(ActionHold(SpacecraftFTCEnv(**SETTINGS), 2), 3).metadata["render_fps"] == pytest.approx(5.0 / 6)
