"""The adapter for Stable-Baselines3: what its VecEnv contract asks for, and a tiny training run."""

import gymnasium as gym
import numpy as np
import pytest
from stable_baselines3 import PPO
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import VecEnv, VecMonitor, VecNormalize

from ftac_gym import wrappers
from ftac_gym.envs import SpacecraftFTCEnv, SpacecraftFTCVectorEnv
from ftac_gym.task.scenario import RewardWeights, SuccessCriterion
from ftac_gym.wrappers import ResidualPolicy, SB3VecEnv

COUNT = 6
SETTINGS = {"duration": 1.2, "tumble_rate": 0.016}  # s, rad/s
TASK = SpacecraftFTCEnv(**SETTINGS).scenario
DRAWN, OTHER = TASK.draw(3, 2), TASK.replace(duration=2.0).draw(3, 1)


def make(residual=False, count=COUNT, **arguments):
    env = SpacecraftFTCVectorEnv(count, autoreset_mode="SameStep", **{**SETTINGS, **arguments})
    return SB3VecEnv(ResidualPolicy(env) if residual else env)


@pytest.mark.parametrize("residual", [False, True])
def test_against_single_environments(residual):
    env = make(residual)
    singles = [SpacecraftFTCEnv(**SETTINGS) for _ in range(COUNT)]
    singles = [ResidualPolicy(single) for single in singles] if residual else singles
    env.seed(40)
    observation = env.reset()
    rows = [single.reset(seed=40 + spacecraft)[0] for spacecraft, single in enumerate(singles)]
    returns, lengths = np.zeros(COUNT), np.zeros(COUNT, dtype=int)
    random = np.random.default_rng(0)
    cases = set()
    for _ in range(60):
        np.testing.assert_allclose(observation, rows, rtol=1e-6, atol=1e-6)
        actions = random.uniform(-1.0, 1.0, (COUNT, 4)).astype(np.float32)
        observation, reward, done, infos = env.step(actions)
        assert observation.dtype == reward.dtype == np.float32 and done.dtype == np.bool_
        assert len(infos) == COUNT
        for spacecraft, single in enumerate(singles):
            rows[spacecraft], single_reward, terminated, truncated, info = single.step(actions[spacecraft])
            assert reward[spacecraft] == pytest.approx(single_reward, rel=1e-5, abs=1e-6)
            assert done[spacecraft] == (terminated or truncated)
            returns[spacecraft] += single_reward
            lengths[spacecraft] += 1
            if not done[spacecraft]:
                continue
            got = infos[spacecraft]
            np.testing.assert_allclose(got["terminal_observation"], rows[spacecraft], rtol=1e-6, atol=1e-6)
            assert got["TimeLimit.truncated"] is (truncated and not terminated)
            assert got["episode"]["r"] == pytest.approx(returns[spacecraft], rel=1e-6, abs=1e-6)
            assert got["episode"]["l"] == lengths[spacecraft]
            for name, value in info.items():
                assert type(got[name]) is type(value), name
                assert got[name] == pytest.approx(value, rel=1e-6, abs=1e-9), name
            cases.add((terminated, truncated))
            returns[spacecraft], lengths[spacecraft] = 0.0, 0
            rows[spacecraft], _ = single.reset()
    assert {(True, False), (False, True)} <= cases


def test_terminated_at_the_time_limit_is_not_truncated():
    env = make(
        duration=0.1, loop_delay=0.0, tumble_rate=0.008, count=32, reward=RewardWeights(progress=1.0)
    )  # fmt: skip
    env.seed(0)
    env.reset()
    *_, done, infos = env.step(np.zeros((32, 4)))
    assert done.all()
    tumbled = np.array([info["reward/progress"] < -1e-3 for info in infos])
    assert 0 < tumbled.sum() < 32
    np.testing.assert_array_equal([info["TimeLimit.truncated"] for info in infos], ~tumbled)


def test_success_is_reported():
    easy = SuccessCriterion(angle=3.14, rate=0.0145, hold=0.5)
    env = make(success=easy, tumble_rate=None, count=32)
    env.seed(0)
    env.reset()
    for _ in range(12):
        *_, infos = env.step(np.zeros((32, 4)))
    successes = [info["is_success"] for info in infos]
    assert all(type(success) is bool for success in successes) and 0 < sum(successes) < 32


def test_seeds():
    env = make()
    env.seed(7)
    first = env.reset()
    second = env.reset()  # seeds are used once
    assert (first != second).any(axis=1).all()
    env.seed(7)
    np.testing.assert_array_equal(env.reset(), first)
    np.testing.assert_array_equal(env.reset(), second)
    single = SpacecraftFTCEnv(**SETTINGS)
    np.testing.assert_array_equal(first[3], single.reset(seed=10)[0])
    env.seed(7)
    env.reset()
    info = single.reset(seed=10)[1]
    assert env.reset_infos[3].keys() == info.keys()
    for name, value in info.items():
        np.testing.assert_array_equal(env.reset_infos[3][name], value)
    assert [type(value) for value in env.reset_infos[3].values()] == [type(value) for value in info.values()]


def test_options():
    env = make()
    drawn = SpacecraftFTCEnv(**SETTINGS).scenario.draw(3, COUNT)
    env.set_options({"episodes": drawn})
    observation = env.reset()
    single = SpacecraftFTCEnv(**SETTINGS)
    for spacecraft in range(COUNT):
        np.testing.assert_array_equal(observation[spacecraft], single.reset(options={"episodes": drawn[spacecraft]})[0])
    assert (env.reset() != observation).any(axis=1).all()  # options are used once
    env.set_options([{"episodes": drawn[spacecraft]} for spacecraft in range(COUNT)])
    np.testing.assert_array_equal(env.reset(), observation)
    env.set_options()
    assert (env.reset() != observation).any(axis=1).all()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (5, "options must be a dict, or a list with one for each spacecraft, got 5"),
        ("x", "options must be a dict, or a list with one for each spacecraft, got 'x'"),
        ({"episode": 3}, r"reset option must be 'episodes': VecEnv.reset resets all, got 'episode'"),
        ([{}, {"reset_mask": np.ones(2, dtype=bool)}], "reset option must be 'episodes'.*, got 'reset_mask'"),
        ([{}], "options must be 2 dicts, got 1"),
        ({"episodes": 3}, r'options\["episodes"\] must be an Episodes object, got 3'),
        ([{"episodes": DRAWN[0]}, {}], r'options\["episodes"\] must be in all dicts or in none, got 1'),
        ([{"episodes": DRAWN}, {"episodes": DRAWN}], r'options\["episodes"\] must be 1 here, got 2'),
        ({"episodes": DRAWN[0]}, r'options\["episodes"\] must be 2 here, got 1'),
        ([{"episodes": DRAWN[0]}, {"episodes": OTHER}], r"must be drawn from one scenario, got '2 scenarios'"),
        ([3, 4], "options must be a dict, or one for each spacecraft, got 3"),
    ],
)
def test_options_that_are_refused(options, message):
    with pytest.raises(ValueError, match=message):
        make(count=2).set_options(options)


def test_attributes_and_methods():
    env = make(residual=True)
    env.seed(0)
    env.reset()
    assert isinstance(env, VecEnv) and env.num_envs == COUNT
    assert env.get_attr("scenario") == [env.env.unwrapped.scenario] * COUNT
    assert env.get_attr("scenario", indices=[0, 2]) == [env.env.unwrapped.scenario] * 2
    assert len(env.get_attr("render_mode", indices=1)) == 1
    measured = env.env_method("measurement")
    assert len(measured) == COUNT
    np.testing.assert_array_equal(measured[0].attitude, env.measurement().attitude)
    env.set_attr("note", "hello")
    assert env.get_attr("note") == ["hello"] * COUNT
    for call in (env.set_attr, env.env_method):
        with pytest.raises(ValueError, match=r"indices must be None: the spacecraft share .*, got \[1\]"):
            call("note", "bye", indices=[1])
    env.set_attr("note", "all", indices=range(COUNT))
    assert env.get_attr("note", 0) == ["all"]
    with pytest.raises(AttributeError):
        env.get_attr("no_such_attribute")
    assert env.env_is_wrapped(Monitor) == [True] * COUNT
    assert env.env_is_wrapped(gym.wrappers.TimeLimit, indices=[0]) == [False]
    env.close()


def test_the_returned_observation_is_the_callers():
    env, twin = make(), make()
    for item in (env, twin):
        item.seed(0)
    observation, expected = env.reset(), twin.reset()
    for _ in range(30):
        observation[:] = 5.0
        observation, reward, *_ = env.step(np.full((COUNT, 4), 0.5))
        expected, wanted, *_ = twin.step(np.full((COUNT, 4), 0.5))
        np.testing.assert_array_equal(observation, expected)
        np.testing.assert_array_equal(reward, wanted)


@pytest.mark.parametrize("mode", ["NextStep", "Disabled"])
def test_only_same_step_mode(mode):
    env = SpacecraftFTCVectorEnv(2, autoreset_mode=mode)
    with pytest.raises(ValueError, match="autoreset_mode must be SameStep for Stable-Baselines3"):
        SB3VecEnv(env)
    with pytest.raises(ValueError, match="autoreset_mode must be SameStep"):
        SB3VecEnv(ResidualPolicy(env))


def test_agrees_with_the_monitor_of_stable_baselines():
    plain = make()
    with pytest.warns(UserWarning, match="already wrapped with a `Monitor`"):
        monitored = VecMonitor(make())
    for env in (plain, monitored):
        env.seed(2)
        env.reset()
    seen = 0
    for _ in range(40):
        actions = np.full((COUNT, 4), 0.7, dtype=np.float32)
        *_, done, infos = plain.step(actions)
        *_, others = monitored.step(actions)
        for spacecraft in np.flatnonzero(done):
            for key in ("r", "l"):
                assert infos[spacecraft]["episode"][key] == pytest.approx(
                    others[spacecraft]["episode"][key], rel=1e-4, abs=1e-4
                )
            seen += 1
    assert seen > COUNT


@pytest.mark.parametrize("residual", [False, True])
def test_a_tiny_training_run(residual):
    env = VecNormalize(make(residual, count=8), gamma=0.99)
    model = PPO("MlpPolicy", env, n_steps=16, batch_size=64, n_epochs=1, seed=0, device="cpu")
    before = model.policy.state_dict()["action_net.weight"].clone()
    model.learn(256)
    assert model.num_timesteps == 256
    assert (model.policy.state_dict()["action_net.weight"] != before).any()
    assert len(model.ep_info_buffer) > 0 and model.ep_info_buffer[0]["l"] <= 12
    assert len(model.ep_success_buffer) > 0


def test_training_is_reproducible():
    weights = []
    for _ in range(2):
        model = PPO("MlpPolicy", make(count=4), n_steps=16, batch_size=64, n_epochs=1, seed=3, device="cpu")
        weights.append(model.learn(128).policy.state_dict()["action_net.weight"].numpy())
    np.testing.assert_array_equal(*weights)


def test_importing_the_wrappers_without_stable_baselines():
    assert wrappers.SB3VecEnv is SB3VecEnv
    with pytest.raises(AttributeError, match="no attribute 'Nothing'"):
        wrappers.Nothing  # noqa: B018
