"""The single environment: episodes, seeds, replay, clipping, ends and info."""

import gymnasium as gym
import numpy as np
import pytest

import ftac_gym  # noqa: F401  registers the environments
from ftac_gym import scenarios
from ftac_gym.attitude import angle_between
from ftac_gym.envs import SpacecraftFTCEnv
from ftac_gym.envs.reward import TERMS
from ftac_gym.task.initial_state import InitialState

SHORT = {"duration": 1.0}


def assert_same(first, second):
    np.testing.assert_equal(first, second)


def assert_flies(env, episode):
    """The episode that the environment is in is the given one, number by number."""
    current = env.unwrapped.batch.simulator.episodes
    for name, array in episode.arrays().items():
        np.testing.assert_array_equal(current.arrays()[name], array, err_msg=name)


@pytest.mark.parametrize("seed", [0, 7, 2**40])
def test_episode_k_of_a_seed_is_that_of_the_scenario(seed):
    env = SpacecraftFTCEnv(**SHORT)
    drawn = env.scenario.draw(seed, 4)
    for k in range(4):
        observation, _ = env.reset(seed=seed if k == 0 else None)
        assert_flies(env, drawn[k])
        np.testing.assert_array_equal(env.batch.simulator.state.attitude[0], drawn.initial["attitude"][k])
        assert env.observation_space.contains(observation)


def test_episodes_do_not_depend_on_what_was_flown():
    env = SpacecraftFTCEnv(**SHORT)
    env.reset(seed=1)
    for _ in range(6):
        env.step(np.ones(4))
    env.reset()
    assert_flies(env, env.scenario.draw(1, 2)[1])


def test_reset_after_a_seed_is_deterministic():
    first, second = SpacecraftFTCEnv(**SHORT), SpacecraftFTCEnv(**SHORT)
    second.reset(seed=99)
    for env in (first, second):
        env.reset(seed=12)
    for _ in range(3):
        assert_same(first.reset(), second.reset())
    one, other = first.reset(), first.reset()
    assert not np.array_equal(one[0], other[0])


def test_resets_without_a_seed_differ_between_environments():
    starts = [SpacecraftFTCEnv(**SHORT).reset()[0] for _ in range(3)]
    assert not np.array_equal(starts[0], starts[1]) and not np.array_equal(starts[1], starts[2])


def test_seeding_starts_over():
    env = SpacecraftFTCEnv(**SHORT)
    first = env.reset(seed=3)
    env.reset()
    assert_same(env.reset(seed=3), first)


def test_seeds_and_episodes_differ():
    env = SpacecraftFTCEnv(**SHORT)
    observations = [env.reset(seed=seed)[0] for seed in range(4)]
    assert len({tuple(item) for item in observations}) == 4


@pytest.mark.parametrize("seed", [-1, -(2**40)])
def test_negative_seed(seed):
    with pytest.raises((ValueError, gym.error.Error), match=r"(?i)seed.*(non-negative|not be negative|greater)"):
        SpacecraftFTCEnv().reset(seed=seed)


def test_replay_of_episodes():
    env = gym.make("SpacecraftFTC-v0", **SHORT)
    drawn = env.unwrapped.scenario.draw(5, 3)
    env.reset(seed=5)
    actions = np.random.default_rng(2).uniform(-1.0, 1.0, (10, 4))
    original = [env.step(action) for action in actions]
    env.reset(seed=8)
    env.reset(options={"episodes": drawn[2]})
    assert_flies(env, drawn[2])
    env.reset(options={"episodes": drawn[0]})
    for action, expected in zip(actions, original, strict=True):
        assert_same(env.step(action), expected)
    # A replay does not use up an episode of the seed.
    env.reset()
    assert_flies(env, env.unwrapped.scenario.draw(8, 2)[1])


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda scenario: scenario.draw(0, 2), "episodes must be 1, one per spacecraft reset, got 2"),
        (lambda scenario: "first", r'options\["episodes"\] must be an Episodes object'),
        (lambda scenario: {"faults": None}, r'options\["episodes"\] must be an Episodes object'),
    ],
)
def test_bad_replay(make, message):
    env = SpacecraftFTCEnv(**SHORT)
    with pytest.raises(ValueError, match=message):
        env.reset(seed=0, options={"episodes": make(env.scenario)})


def test_actions_are_fractions_of_the_torque_limits_and_are_clipped():
    env = SpacecraftFTCEnv(**SHORT)
    limits = env.scenario.spacecraft.wheels.torque_limits
    env.reset(seed=0)
    env.step([0.25, -0.5, 3.0, -7.0])
    np.testing.assert_allclose(env.measurement().last_command[0], np.array([0.25, -0.5, 1.0, -1.0]) * limits)
    twin = SpacecraftFTCEnv(**SHORT)
    twin.reset(seed=0)
    twin.step([0.25, -0.5, 1.0, -1.0])
    assert_same(env.step(np.zeros(4)), twin.step(np.zeros(4)))


def test_single_and_double_precision_actions_agree_where_they_are_equal():
    results = []
    for dtype in (np.float32, np.float64):
        env = SpacecraftFTCEnv(**SHORT)
        env.reset(seed=0)
        results.append(env.step(np.array([0.5, -0.25, 0.125, 1.0], dtype=dtype)))
    assert_same(*results)


def test_truncated_exactly_after_the_duration():
    env = SpacecraftFTCEnv(duration=0.7, tumble_rate=None)
    for _ in range(2):
        env.reset()
        ends = [env.step(np.ones(4))[2:4] for _ in range(7)]
        assert ends == [(False, False)] * 6 + [(False, True)]


def test_terminated_when_it_tumbles_and_only_then():
    calm = 0.05  # rad/s
    env = SpacecraftFTCEnv(initial_state=InitialState.fixed(rate=(0.049, 0.0, 0.0)), tumble_rate=calm, faults=None)
    env.reset(seed=0)
    for _ in range(200):
        _, _, terminated, truncated, _ = env.step([1.0, -1.0, -1.0, 1.0])
        fast = np.linalg.norm(env.batch.simulator.state.rate[0]) > calm
        assert terminated == fast and not truncated
        if terminated:
            break
    assert fast


@pytest.mark.parametrize("name", scenarios.names())
def test_info(name):
    env = SpacecraftFTCEnv(scenario=name, duration=2.0)
    observation, info = env.reset(seed=6)
    names = {"time", "attitude_error", "rate_error", "is_success", "availability", "cost", "feasible"}
    names |= {f"fault/{part}" for part in ("kind", "wheel", "onset", "active")}
    assert set(info) == names and info["time"] == 0.0
    assert info["feasible"] == bool(env.scenario.draw(6, 1).feasible[0])
    for step in range(1, 6):
        _, reward, *_, info = env.step(np.full(env.action_space.shape, 0.3))
        assert set(info) == names | {f"reward/{term}" for term in TERMS}
        assert info["time"] == pytest.approx(step * env.scenario.control_period)
        simulator = env.batch.simulator
        angle = angle_between(simulator.state.attitude, simulator.reference_attitude)[0]
        assert info["attitude_error"] == pytest.approx(np.degrees(angle), abs=1e-9)
        assert type(reward) is float and type(info["is_success"]) is bool and type(info["feasible"]) is bool
    assert observation.dtype == np.float32


def test_measurement_has_a_leading_axis_and_is_a_copy():
    env = SpacecraftFTCEnv(**SHORT)
    env.reset(seed=0)
    measurement = env.measurement()
    assert len(measurement) == 1 and measurement.attitude.shape == (1, 4)
    twin = SpacecraftFTCEnv(**SHORT)
    twin.reset(seed=0)
    for name, array in vars(measurement).items():
        if name != "truth":
            array[:] = 17.0
    assert_same(env.step(np.ones(4)), twin.step(np.ones(4)))


def test_returned_observations_are_the_callers():
    env, twin = SpacecraftFTCEnv(**SHORT), SpacecraftFTCEnv(**SHORT)
    observation, _ = env.reset(seed=0)
    twin.reset(seed=0)
    for _ in range(4):
        observation[:] = 9.0
        env.observation_slices.clear()
        result, expected = env.step(np.ones(4)), twin.step(np.ones(4))
        assert_same(result, expected)
        observation = result[0]
