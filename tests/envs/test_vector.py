"""The native vector environment against Gymnasium's own over single environments, element by element."""

from functools import partial

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode, SyncVectorEnv

import ftac_gym  # noqa: F401  registers the environments
from ftac_gym import scenarios
from ftac_gym.dynamics import simulator
from ftac_gym.envs import SpacecraftFTCEnv, SpacecraftFTCVectorEnv

CRAFT = 5
# Spacecraft tumble at different times, some are truncated, and some steps end several at once.
SETTINGS = {"duration": 2.4, "tumble_rate": 0.02}  # s, rad/s
MODES = [mode.value for mode in AutoresetMode]


def assert_same(first, second, where=""):
    """Assert that nested infos, observations and so on are exactly equal, in keys, types and values."""
    assert type(first) is type(second), where
    if isinstance(first, dict):
        assert sorted(first) == sorted(second), where
        for key in first:
            assert_same(first[key], second[key], f"{where}/{key}")
    elif isinstance(first, (list, tuple)) or (isinstance(first, np.ndarray) and first.dtype == object):
        assert len(first) == len(second), where
        for index, (one, other) in enumerate(zip(first, second, strict=True)):
            assert_same(one, other, f"{where}/{index}")
    else:
        np.testing.assert_array_equal(first, second, err_msg=where, strict=True)


def pair(mode, **arguments):
    """Return the native environment and the reference over single environments."""
    singles = [partial(SpacecraftFTCEnv, **arguments)] * CRAFT
    return SpacecraftFTCVectorEnv(CRAFT, autoreset_mode=mode, **arguments), SyncVectorEnv(singles, autoreset_mode=mode)


@pytest.mark.parametrize(
    ("name", "tier"),
    [*((name, "attitude") for name in scenarios.names()), *((name, "oracle") for name in ("flagship", "flexible"))],
)
@pytest.mark.parametrize("mode", MODES)
def test_equals_single_environments(mode, name, tier):
    native, reference = pair(mode, scenario=name, observation=tier, **SETTINGS)
    assert_same(native.reset(seed=11), reference.reset(seed=11))
    random = np.random.default_rng(3)
    ends, kinds, lonely = np.zeros(CRAFT, dtype=int), set(), False
    steps = 0
    # Episodes of many periods, all from one start: one end of each spacecraft will do.
    wanted = 4 if native.scenario.horizon < 300 else 1
    while ends.min() < wanted:
        actions = random.uniform(-1.2, 1.2, native.action_space.shape)
        result, expected = native.step(actions), reference.step(actions)
        assert_same(result, expected)
        _, _, terminated, truncated, _ = result
        done = terminated | truncated
        ends += done
        lonely |= bool(done.any() and not done.all())
        kinds |= {"terminated"} if terminated.any() else set()
        kinds |= {"truncated"} if truncated.any() else set()
        if mode == "Disabled" and done.any():
            # Gymnasium's environment takes the mask out of the options.
            assert_same(
                native.reset(options={"reset_mask": done}), reference.reset(options={"reset_mask": done.copy()})
            )
        steps += 1
        assert steps < 500
    # From one start, or on target at rest, all episodes end alike.
    if native.scenario.initial_state.attitude is None and name != "flagship_pointing":
        assert lonely and kinds == {"terminated", "truncated"}


@pytest.mark.parametrize("mode", MODES)
def test_equals_single_environments_when_reseeded_in_the_middle(mode):
    native, reference = pair(mode, **SETTINGS)
    seeds = [4, 9, None, 4, None]
    native.reset(seed=1)
    reference.reset(seed=1)
    for seed in (None, seeds, 3):
        assert_same(native.reset(seed=seed), reference.reset(seed=seed))
        for _ in range(9):
            assert_same(native.step(np.full((CRAFT, 4), 0.9)), reference.step(np.full((CRAFT, 4), 0.9)))
            if mode == "Disabled":
                break


def test_partial_resets_with_seeds():
    native, reference = pair("Disabled", **SETTINGS)
    mask = np.array([True, False, True, True, False])
    for env in (native, reference):
        env.reset(seed=1)
        env.step(np.full((CRAFT, 4), 0.5))
    for seed in (8, [3, 4, None, 6, 7], None):
        first = native.reset(seed=seed, options={"reset_mask": mask})
        assert_same(first, reference.reset(seed=seed, options={"reset_mask": mask.copy()}))
        assert_same(native.step(np.full((CRAFT, 4), 0.5)), reference.step(np.full((CRAFT, 4), 0.5)))


def test_craft_without_a_seed_at_the_first_reset_are_random():
    observation, _ = SpacecraftFTCVectorEnv(4, **SETTINGS).reset(seed=[5, None, None, None])
    again, _ = SpacecraftFTCVectorEnv(4, **SETTINGS).reset(seed=[5, None, None, None])
    np.testing.assert_array_equal(observation[0], again[0])
    assert len({tuple(row) for row in np.vstack([observation, again])}) == 7


def test_craft_are_random_without_a_seed():
    observation, _ = SpacecraftFTCVectorEnv(4, **SETTINGS).reset()
    again, _ = SpacecraftFTCVectorEnv(4, **SETTINGS).reset()
    assert len({tuple(row) for row in np.vstack([observation, again])}) == 8


def test_craft_are_random_after_a_refused_first_reset():
    env = SpacecraftFTCVectorEnv(3, **SETTINGS)
    with pytest.raises(ValueError, match="must cover all spacecraft at the first reset"):
        env.reset(options={"reset_mask": np.array([True, False, False])})
    observation, _ = env.reset()
    assert len({tuple(row) for row in observation}) == 3


@pytest.mark.parametrize("mode", MODES)
def test_returned_arrays_are_the_callers(mode):
    def vandalise(data):
        if isinstance(data, dict):
            data = list(data.values())
        if isinstance(data, (list, tuple)) or (isinstance(data, np.ndarray) and data.dtype == object):
            for item in data:
                vandalise(item)
        elif isinstance(data, np.ndarray):
            data[...] = True if data.dtype == np.bool_ else 77.0

    env, twin = (SpacecraftFTCVectorEnv(CRAFT, autoreset_mode=mode, **SETTINGS) for _ in range(2))
    result, expected = env.reset(seed=2), twin.reset(seed=2)
    for _ in range(60):
        vandalise(result)
        vandalise(env.measurement().__dict__)
        action = np.full((CRAFT, 4), 0.8)
        result, expected = env.step(action), twin.step(action)
        assert_same(result, expected)
        done = expected[2] | expected[3]
        if mode == "Disabled" and done.any():
            vandalise(result)
            options = {"reset_mask": done}
            result, expected = env.reset(options=options), twin.reset(options=options)
            assert_same(result, expected)


def test_disabled_mode_asks_for_a_reset():
    env = SpacecraftFTCVectorEnv(3, autoreset_mode="Disabled", duration=0.3, tumble_rate=None)
    env.reset(seed=0)
    for _ in range(3):
        *_, truncated, _ = env.step(np.zeros((3, 4)))
    assert truncated.all()
    with pytest.raises(gym.error.ResetNeeded, match=r"craft \[0, 1, 2\] have ended"):
        env.step(np.zeros((3, 4)))
    env.reset(options={"reset_mask": np.array([True, False, True])})
    with pytest.raises(gym.error.ResetNeeded, match=r"spacecraft \[1\] have ended; reset them.*reset_mask"):
        env.step(np.zeros((3, 4)))
    env.reset(options={"reset_mask": np.array([False, True, False])})
    assert not env.step(np.zeros((3, 4)))[3].any()


@pytest.mark.parametrize("mode", MODES)
def test_max_episode_steps(mode):
    limit = 4
    native = gym.make_vec("SpacecraftFTC-v0", num_envs=3, max_episode_steps=limit, autoreset_mode=mode, **SETTINGS)
    assert isinstance(native, SpacecraftFTCVectorEnv)
    singles = [partial(gym.make, "SpacecraftFTC-v0", max_episode_steps=limit, **SETTINGS)] * 3
    reference = SyncVectorEnv(singles, autoreset_mode=mode)
    assert_same(native.reset(seed=0), reference.reset(seed=0))
    for step in range(1, 14):
        result, expected = native.step(np.full((3, 4), 0.2)), reference.step(np.full((3, 4), 0.2))
        assert_same(result, expected)
        if mode == "Disabled" and step % limit == 0:
            assert result[3].all()
            mask = np.ones(3, dtype=bool)
            native.reset(options={"reset_mask": mask})
            reference.reset(options={"reset_mask": mask.copy()})


def test_max_episode_steps_does_not_lengthen_an_episode():
    env = SpacecraftFTCVectorEnv(1, max_episode_steps=100, duration=0.3, tumble_rate=None)
    env.reset(seed=0)
    assert [bool(env.step(np.zeros((1, 4)))[3][0]) for _ in range(3)] == [False, False, True]


@pytest.mark.parametrize("mode", [*MODES, *AutoresetMode])
def test_make_vec_finds_the_native_environment(mode):
    env = gym.make_vec("SpacecraftFTC-v0", num_envs=2, autoreset_mode=mode)
    assert isinstance(env, SpacecraftFTCVectorEnv)
    assert env.metadata["autoreset_mode"] is AutoresetMode(mode)
    explicit = gym.make_vec("SpacecraftFTC-v0", num_envs=2, vectorization_mode="vector_entry_point")
    assert isinstance(explicit, SpacecraftFTCVectorEnv)
    assert explicit.metadata["autoreset_mode"] is AutoresetMode.NEXT_STEP
    assert isinstance(gym.make_vec("SpacecraftFTC-v0", num_envs=2, vectorization_mode="sync"), SyncVectorEnv)


def test_threads_do_not_change_results(monkeypatch):
    monkeypatch.setattr(simulator, "THREAD_BATCH", 2)
    one, three = (SpacecraftFTCVectorEnv(8, autoreset_mode="SameStep", threads=n, **SETTINGS) for n in (1, 3))
    assert_same(one.reset(seed=0), three.reset(seed=0))
    random = np.random.default_rng(0)
    for _ in range(40):
        actions = random.uniform(-1.0, 1.0, (8, 4))
        assert_same(one.step(actions), three.step(actions))


def test_replay_of_episodes():
    env = SpacecraftFTCVectorEnv(3, autoreset_mode="Disabled", **SETTINGS)
    drawn = env.scenario.draw(21, 5)
    observation, _ = env.reset(options={"episodes": drawn[np.array([4, 0, 2])]})
    single = SpacecraftFTCEnv(**SETTINGS)
    for craft, episode in enumerate((4, 0, 2)):
        np.testing.assert_array_equal(observation[craft], single.reset(options={"episodes": drawn[episode]})[0])
    mask = np.array([False, True, False])
    partly, infos = env.reset(options={"episodes": drawn[3], "reset_mask": mask})
    np.testing.assert_array_equal(partly[[0, 2]], observation[[0, 2]])
    np.testing.assert_array_equal(partly[1], single.reset(options={"episodes": drawn[3]})[0])
    np.testing.assert_array_equal(infos["_time"], mask)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"reset_mask": np.array([1, 0, 1])}, r'options\["reset_mask"\] must be a boolean array of shape \(3,\)'),
        ({"reset_mask": [True, False, True]}, r'options\["reset_mask"\] must be a boolean array'),
        ({"reset_mask": np.ones(2, dtype=bool)}, r'options\["reset_mask"\] must be a boolean array of shape \(3,\)'),
        ({"reset_mask": np.zeros(3, dtype=bool)}, "with at least one True"),
        ({"episodes": 3}, r'options\["episodes"\] must be an Episodes object, got 3'),
        ({"episodes": scenarios.get("flagship").draw(0, 2)}, "episodes must be 3, one per spacecraft reset, got 2"),
    ],
)
def test_bad_options(options, message):
    env = SpacecraftFTCVectorEnv(3)
    env.reset(seed=0)
    with pytest.raises(ValueError, match=message):
        env.reset(options=options)


@pytest.mark.parametrize("seeds", [[1, 2], [1, 2, 3, 4]])
def test_wrong_number_of_seeds(seeds):
    with pytest.raises(ValueError, match="seed must be an integer or 3 seeds"):
        SpacecraftFTCVectorEnv(3).reset(seed=seeds)


@pytest.mark.parametrize("seed", [-1, [1, -2, 3]])
def test_negative_seeds(seed):
    with pytest.raises((ValueError, gym.error.Error), match=r"(?i)seed|negative"):
        SpacecraftFTCVectorEnv(3).reset(seed=seed)


@pytest.mark.parametrize("seed", [[5, -1], [5, True], [5, "6"]])
def test_a_bad_seed_leaves_all_seeds_as_they_were(seed):
    env, other = (gym.make_vec("SpacecraftFTC-v0", num_envs=2, **SETTINGS) for _ in range(2))
    for one in (env, other):
        one.reset(seed=3)
    with pytest.raises(ValueError, match=r"seed\[1\] must be a non-negative integer or None, got"):
        env.reset(seed=seed)
    np.testing.assert_array_equal(env.reset()[0], other.reset()[0])
