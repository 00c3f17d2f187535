"""Wrappers around each other: single against vector, checkers, specs, copies, and the adapter on top."""

import copy
import itertools
import pickle
import warnings

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode
from stable_baselines3 import PPO
from stable_baselines3.common.env_checker import check_env as check_env_of_stable_baselines

from ftac_gym.envs import SpacecraftFTCEnv, SpacecraftFTCVectorEnv
from ftac_gym.wrappers import (
    ActionHold,
    FaultEstimateObservation,
    GainScheduling,
    ObservationHistory,
    ResidualPolicy,
    SB3VecEnv,
)

COUNT = 4
SETTINGS = {"duration": 2.0, "tumble_rate": 0.016}  # s, rad/s
MODES = [mode.value for mode in AutoresetMode]
RESIDUAL = (
    ResidualPolicy,
    {"authority": 0.4, "authority_angle": 2.0, "authority_floor": 0.1, "torque_threshold": 0.05},
)
GAINS = (GainScheduling, {"base": "pd_dob", "ranges": {"braking_share": [0.4, 1.0], "bandwidth": [0.04, 1.0]}})
OBSERVER = (FaultEstimateObservation, {"source": "asmo"})
TRUTH = (FaultEstimateObservation, {"source": "truth"})
HISTORY = (ObservationHistory, {"steps": 3, "stride": 4})
STACKS = [
    *(order for acting in (RESIDUAL, GAINS) for order in itertools.permutations((acting, OBSERVER, HISTORY))),
    (HISTORY, TRUTH, HISTORY, OBSERVER, RESIDUAL, TRUTH),
    (GAINS, (FaultEstimateObservation, {"source": "dob"}), (ObservationHistory, {"steps": 4}), TRUTH),
]
SHORT = [STACKS[0], STACKS[9], *STACKS[-2:]]


def ids(stack):
    letters = {ResidualPolicy: "R", GainScheduling: "G", FaultEstimateObservation: "F", ObservationHistory: "H"}
    return "".join(letters[wrapper] for wrapper, _ in stack)


every = pytest.mark.parametrize("stack", STACKS, ids=ids)
some = pytest.mark.parametrize("stack", SHORT, ids=ids)


def wrapped(env, stack):
    for wrapper, arguments in stack:
        env = wrapper(env, **arguments)
    return env


def native(mode, stack):
    return wrapped(SpacecraftFTCVectorEnv(COUNT, autoreset_mode=mode, **SETTINGS), stack)


def close(got, expected):
    np.testing.assert_allclose(got, expected, rtol=2e-6, atol=2e-6)


@every
@pytest.mark.parametrize("mode", MODES)
def test_a_vector_equals_single_environments(mode, stack):
    vector, singles = native(mode, stack), [wrapped(SpacecraftFTCEnv(**SETTINGS), stack) for _ in range(COUNT)]
    assert vector.single_observation_space == singles[0].observation_space
    assert vector.single_action_space == singles[0].action_space
    random = np.random.default_rng(0)
    rows = [env.reset(seed=9 + spacecraft)[0] for spacecraft, env in enumerate(singles)]
    observation, _ = vector.reset(seed=9)
    waiting, ends, single_end = np.zeros(COUNT, dtype=bool), np.zeros(COUNT, dtype=int), False
    for _ in range(65):
        close(observation, rows)
        assert vector.observation_space.contains(observation)
        actions = random.uniform(-1.0, 1.0, vector.action_space.shape)
        observation, reward, terminated, truncated, infos = vector.step(actions)
        done = terminated | truncated
        assert ("final_obs" in infos) == bool(mode == "SameStep" and done.any())
        for spacecraft, env in enumerate(singles):
            if waiting[spacecraft]:
                rows[spacecraft], _ = env.reset()
                continue
            rows[spacecraft], single_reward, *ended, _ = env.step(actions[spacecraft])
            assert single_reward == pytest.approx(reward[spacecraft], rel=1e-9, abs=1e-9)
            assert [terminated[spacecraft], truncated[spacecraft]] == ended
            if done[spacecraft] and mode == "SameStep":
                close(infos["final_obs"][spacecraft], rows[spacecraft])
                assert vector.single_observation_space.contains(infos["final_obs"][spacecraft])
            if done[spacecraft] and mode != "NextStep":
                rows[spacecraft], _ = env.reset()
        waiting = done & (mode == "NextStep")
        ends += done
        single_end |= bool(done.any() and not done.all())
        if mode == "Disabled" and done.any():
            before = observation
            observation, _ = vector.reset(options={"reset_mask": done})
            np.testing.assert_array_equal(observation[~done], before[~done])
    assert ends.min() >= 2 and single_end


@some
@pytest.mark.parametrize("hold", [1, 3])
def test_the_adapter_on_top(stack, hold):
    env = SB3VecEnv(native("SameStep", stack), hold)
    singles = [ActionHold(wrapped(SpacecraftFTCEnv(**SETTINGS), stack), hold) for _ in range(COUNT)]
    env.seed(40)
    close(env.reset(), [single.reset(seed=40 + spacecraft)[0] for spacecraft, single in enumerate(singles)])
    random, ends = np.random.default_rng(0), 0
    fresh = np.ones(COUNT, dtype=bool)  # with a hold, the adapter's spacecraft fly on from a reset to the end of it
    for _ in range(60 // hold):
        actions = random.uniform(-1.0, 1.0, (COUNT, *env.action_space.shape)).astype(np.float32)
        observation, reward, done, infos = env.step(actions)
        for spacecraft, single in enumerate(singles):
            if not fresh[spacecraft]:
                continue
            row, single_reward, *ended, info = single.step(actions[spacecraft])
            assert reward[spacecraft] == pytest.approx(single_reward, rel=1e-5, abs=1e-6)
            assert done[spacecraft] == any(ended)
            close(infos[spacecraft]["terminal_observation"] if done[spacecraft] else observation[spacecraft], row)
            if done[spacecraft]:
                ends += 1
                assert infos[spacecraft]["time"] == pytest.approx(info["time"])
                fresh[spacecraft] = hold == 1
                if fresh[spacecraft]:
                    close(observation[spacecraft], single.reset()[0])
    assert ends >= COUNT


def test_training():
    env = SB3VecEnv(native("SameStep", (GAINS, OBSERVER, HISTORY)))
    model = PPO("MlpPolicy", env, n_steps=16, batch_size=32, n_epochs=1, seed=0, device="cpu").learn(128)
    assert model.num_timesteps == 128


@some
def test_checkers(stack):
    with warnings.catch_warnings():
        # Gymnasium warns of any wrapper around the environment that it checks.
        warnings.filterwarnings("ignore", ".*different from the unwrapped version.*")
        env = wrapped(gym.make("SpacecraftFTC-v0", duration=2.0), stack)
        check_env(env, skip_render_check=True)
        check_env_of_stable_baselines(env)
        held = ActionHold(env, 2)
        check_env(held, skip_render_check=True)
        check_env_of_stable_baselines(held)


@some
def test_specs(stack):
    env = ActionHold(wrapped(gym.make("SpacecraftFTC-v0", observation="telemetry", duration=2.0), stack), 2)
    spec = gym.envs.registration.EnvSpec.from_json(env.spec.to_json())
    again = gym.make(spec)
    assert again.observation_space == env.observation_space and again.action_space == env.action_space
    # Gymnasium adds the limit of the specification, which is the episode's own length.
    assert str(again).replace("<TimeLimit", "")[:-1] == str(env)
    np.testing.assert_array_equal(again.reset(seed=3)[0], env.reset(seed=3)[0])
    for action in np.random.default_rng(0).uniform(-1.0, 1.0, (4, *env.action_space.shape)):
        np.testing.assert_array_equal(again.step(action)[0], env.step(action)[0])


@some
@pytest.mark.parametrize("duplicate", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))])
@pytest.mark.parametrize("make", [lambda stack: wrapped(SpacecraftFTCEnv(**SETTINGS), stack),
                                  lambda stack: native("SameStep", stack)])  # fmt: skip
def test_copies_fly_on_alone(make, duplicate, stack):
    env, random = make(stack), np.random.default_rng(0)
    env.reset(seed=1)
    actions = random.uniform(-1.0, 1.0, (8, *env.action_space.shape))
    for action in actions[:4]:
        env.step(action)
    twin = duplicate(env)
    expected = [env.step(action)[0] for action in actions[4:]]
    for action, observation in zip(actions[4:], expected, strict=True):
        np.testing.assert_array_equal(twin.step(action)[0], observation)


@pytest.mark.parametrize("make", [SpacecraftFTCEnv, lambda: SpacecraftFTCVectorEnv(2)], ids=["single", "vector"])
def test_the_environment_is_reached_through_the_wrappers(make):
    inner = make()
    env = wrapped(inner, STACKS[-2])
    env.reset(seed=0)
    assert env.unwrapped is inner
    assert env.unwrapped.measurement().time.tolist() == [0.0] * env.transform.num_spacecraft
    assert env.information == "oracle" and env.env.information == "attitude"


@pytest.mark.parametrize("wrapper", [FaultEstimateObservation, GainScheduling, ObservationHistory])
@pytest.mark.parametrize("env", [gym.make("Pendulum-v1"), gym.make_vec("Pendulum-v1", num_envs=2)])
def test_foreign_environments(wrapper, env):
    with pytest.raises(ValueError, match="env must be an environment of ftac_gym"):
        wrapper(env)


@pytest.mark.parametrize("wrapper", [FaultEstimateObservation, GainScheduling, ObservationHistory, ResidualPolicy])
def test_observations_must_be_flat(wrapper):
    stacked = gym.wrappers.FrameStackObservation(SpacecraftFTCEnv(), 2)
    with pytest.raises(ValueError, match="env must have a Box observation space with one axis"):
        wrapper(stacked)
