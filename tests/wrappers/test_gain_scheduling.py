"""Gain scheduling: zero is the base bit for bit, the ends are the ends, and every spacecraft has its own gains."""

import itertools

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import data_equivalence
from gymnasium.vector import AutoresetMode

from ftac_gym import baselines, scenarios
from ftac_gym.baselines.gains import scheduled_share
from ftac_gym.envs import SpacecraftFTCEnv, SpacecraftFTCVectorEnv
from ftac_gym.task.initial_state import InitialState
from ftac_gym.wrappers import GainScheduling, ObservationHistory, ResidualPolicy, schedulable_bases

COUNT, WHEELS = 4, 4
RATE_GAIN = baselines.defaults("pd_dob")["rate_gain"]
SETTINGS = {"duration": 2.0, "tumble_rate": 0.016}  # s, rad/s
MODES = [mode.value for mode in AutoresetMode]
BASES = [name for name in schedulable_bases() if name != "pd_shaped"]
makers = pytest.mark.parametrize("make", [SpacecraftFTCEnv, lambda **a: SpacecraftFTCVectorEnv(2, **a)])


def native(mode, **arguments):
    return SpacecraftFTCVectorEnv(COUNT, autoreset_mode=mode, **{**SETTINGS, **arguments})


def test_names():
    assert {"pd", "pd_dob", "nftsm", "nftsm_observer", "pd_shaped"} <= set(schedulable_bases())
    assert "nftsm_oracle" not in schedulable_bases() and "hsfc" not in schedulable_bases()


@pytest.mark.parametrize("gains", ["default", "tuned"])
@pytest.mark.parametrize("name", ["pd", "pd_dob", "nftsm", "nftsm_observer"])
def test_zero_is_the_base_in_a_single_environment(name, gains):
    plain, env = (SpacecraftFTCEnv(**SETTINGS) for _ in range(2))
    env = GainScheduling(env, name, gains=gains)
    policy = baselines.make(name, plain.scenario, gains=gains).as_policy(plain)
    ends, zero = 0, np.zeros(env.action_space.shape, dtype=np.float32)
    result, expected = env.reset(seed=3), plain.reset(seed=3)
    for _ in range(60):
        np.testing.assert_array_equal(result[0], expected[0])
        action, _ = policy.predict(expected[0])
        result, expected = env.step(zero), plain.step(action)
        assert data_equivalence(result[1:], expected[1:])
        if expected[2] or expected[3]:
            ends += 1
            result, expected = env.reset(), plain.reset()
    assert ends >= 3


@pytest.mark.parametrize("name", BASES)
@pytest.mark.parametrize("mode", MODES)
def test_zero_is_the_base_in_a_vector_environment(mode, name):
    plain, env = native(mode), GainScheduling(native(mode), name)
    policy = baselines.make(name, plain.scenario, COUNT).as_policy(plain)
    zero, ends = np.zeros(env.action_space.shape), 0
    (observation, _), (result, _) = plain.reset(seed=3), env.reset(seed=3)
    for _ in range(60):
        action, _ = policy.predict(observation)
        observation, reward, terminated, truncated, infos = plain.step(action)
        result, *others, got = env.step(zero)
        np.testing.assert_array_equal(result, observation)
        for mine, wanted in zip(others, (reward, terminated, truncated), strict=True):
            np.testing.assert_array_equal(mine, wanted)
        done = terminated | truncated
        ends += done.sum()
        for spacecraft in np.flatnonzero(infos.get("_final_obs", [])):
            np.testing.assert_array_equal(got["final_obs"][spacecraft], infos["final_obs"][spacecraft])
        if mode == "Disabled" and done.any():  # the others have not acted on this measurement yet
            some = {"reset_mask": done}
            (observation, _), (result, _) = plain.reset(options=some), env.reset(options=some)
            np.testing.assert_array_equal(result, observation)
    assert ends >= 8


def test_the_baseline_for_flexible_spacecraft():
    plain, env = SpacecraftFTCEnv("flexible"), GainScheduling(SpacecraftFTCEnv("flexible"), "pd_shaped", gains="tuned")
    policy = baselines.make("pd_shaped", plain.scenario, gains="tuned").as_policy(plain)
    result, expected = env.reset(seed=0), plain.reset(seed=0)
    for _ in range(20):
        np.testing.assert_array_equal(result[0], expected[0])
        action, _ = policy.predict(expected[0])
        result, expected = env.step(np.zeros(env.action_space.shape)), plain.step(action)
    assert np.isfinite(env.step(np.ones(env.action_space.shape))[0]).all()
    assert "rate_limit" not in env.transform.gains


def test_the_action_is_geometric_within_the_range():
    ranges = {"rate_limit": [1.0, 3.0], "rate_gain": (0.6, 1.9)}
    env = GainScheduling(SpacecraftFTCEnv(), "pd", ranges, rate_limit=2.0)
    own = baselines.defaults("pd")["rate_gain"]
    assert env.transform.gains == ("rate_limit", "rate_gain") and env.action_space.shape == (2,)
    for action, expected in (
        ((0.0, 0.0), (2.0, own)),
        ((1.0, -1.0), (3.0, 0.6)),
        ((-1.0, 1.0), (1.0, 1.9)),
        ((0.5, -0.5), (np.sqrt(2.0 * 3.0), np.sqrt(own * 0.6))),
        ((7.0, -7.0), (3.0, 0.6)),  # beyond the space
    ):
        np.testing.assert_allclose(env.transform.values(np.array([action]))[0], expected, rtol=1e-14)


@pytest.mark.parametrize("name", BASES)
def test_scheduled_gains_are_those_of_a_baseline_built_with_them(name):
    """Random gains for each spacecraft, in flight, and all corners: the baseline refuses no combination."""
    near = InitialState.fixed((np.cos(0.05), 0.0, np.sin(0.05), 0.0), (0.0, 0.0, 0.005))  # wheels below their limits
    env = GainScheduling(native("NextStep", duration=10.0, tumble_rate=None, initial_state=near), name)
    env.reset(seed=1)
    law, scenario, random = baselines.baseline_class(name), env.unwrapped.scenario, np.random.default_rng(0)
    count = len(env.transform.gains)
    corners = np.array(list(itertools.product((-1.0, 1.0), repeat=count)))
    rows = np.concatenate([corners, random.uniform(-1.0, 1.0, (COUNT, count))])
    rows = rows[: len(rows) // COUNT * COUNT].reshape(-1, COUNT, count)
    all_of_them, spread = np.ones(COUNT, dtype=bool), []
    for actions in rows:
        measurement, values = env.unwrapped.measurement(), env.transform.values(actions)
        memory = env.transform.baseline.memory.copy()
        env.step(actions)
        sent = env.unwrapped.measurement().last_command
        for spacecraft in range(COUNT):
            point = dict(zip(env.transform.gains, values[spacecraft].tolist(), strict=True))
            built = baselines.make(name, scenario, COUNT, **law.gains_at(point))
            built.memory.restore(memory, all_of_them)
            expected = built.act(measurement)
            np.testing.assert_allclose(sent[spacecraft], expected[spacecraft], rtol=1e-9, atol=1e-12)
            spread.append(np.abs(sent - expected).max())
    # This near to the target, the observer's bandwidth alone matters to lqr.
    assert np.median(spread) > (1e-5 if name == "lqr" else 1e-3), "the gains of another spacecraft are another thing"


@pytest.mark.parametrize("mode", MODES)
def test_a_vector_equals_single_environments(mode):
    """For a law with an observer; see test_stacks.py for pd_dob."""
    name = "nftsm_observer"
    vector = GainScheduling(native(mode), name)
    singles = [GainScheduling(SpacecraftFTCEnv(**SETTINGS), name) for _ in range(COUNT)]
    random = np.random.default_rng(0)
    rows = [env.reset(seed=9 + spacecraft)[0] for spacecraft, env in enumerate(singles)]
    observation, _ = vector.reset(seed=9)
    waiting, ends = np.zeros(COUNT, dtype=bool), 0
    for _ in range(60):
        np.testing.assert_allclose(observation, rows, rtol=1e-6, atol=1e-6)
        actions = random.uniform(-1.0, 1.0, vector.action_space.shape)
        observation, reward, terminated, truncated, infos = vector.step(actions)
        done = terminated | truncated
        for spacecraft, env in enumerate(singles):
            if waiting[spacecraft]:
                rows[spacecraft], _ = env.reset()
                continue
            rows[spacecraft], single_reward, *ended, _ = env.step(actions[spacecraft])
            assert single_reward == pytest.approx(reward[spacecraft], rel=1e-9, abs=1e-9)
            assert [terminated[spacecraft], truncated[spacecraft]] == ended
            if done[spacecraft] and mode != "NextStep":
                if mode == "SameStep":
                    np.testing.assert_allclose(infos["final_obs"][spacecraft], rows[spacecraft], rtol=1e-6, atol=1e-6)
                rows[spacecraft], _ = env.reset()
        waiting = done & (mode == "NextStep")
        ends += done.sum()
        if mode == "Disabled" and done.any():
            observation, _ = vector.reset(options={"reset_mask": done})
    assert ends >= 8


@makers
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"base": "lqg"}, "baseline must be one of .*'lqg'"),
        ({"base": "hsfc"}, r"base must have gains to schedule, as \[.*'nftsm', .*'pd_dob'.*\] have, got 'hsfc'"),
        ({"base": "nftsm_oracle"}, "base must not be an oracle"),
        ({"ranges": {"beauty": (1.0, 2.0)}}, r"ranges must be of gains among \['bandwidth', .*\], got 'beauty'"),
        ({"ranges": {"attitude_filter_time": (1.0, 2.0)}}, "ranges must be of gains among"),
        ({"base": "pd", "ranges": {"bandwidth": (1.0, 9.0)}}, "ranges must be of gains among"),
        ({"ranges": {}}, "ranges must map at least one gain to a pair"),
        ({"ranges": ["rate_gain"]}, "ranges must map at least one gain to a pair"),
        ({"ranges": {"rate_gain": 3.0}}, r"ranges\['rate_gain'\] must be a pair \(low, high\), got 3.0"),
        ({"ranges": {"rate_gain": (3.0, 8.0, 9.0)}}, r"ranges\['rate_gain'\] must be a pair"),
        ({"ranges": {"rate_gain": (3.0, "high")}}, r"ranges\['rate_gain'\] must be a number, got 'high'"),
        (
            {"ranges": {"rate_gain": (8.0, 9.0)}},
            rf"rate_gain of pd_dob must lie strictly inside its range \(8, 9\), got {RATE_GAIN:g}",
        ),
        ({"ranges": {"rate_gain": (9.0, 3.0)}}, "rate_gain of pd_dob must lie strictly inside its range"),
        ({"ranges": {"rate_gain": (0.0, 9.0)}}, r"ranges\['rate_gain'\] must start above zero, got 0.0"),
        ({"rate_limit": 2.6}, r"rate_limit of pd_dob must lie strictly inside its range \(0.5, 2.6\), got 2.6"),
        (
            {"ranges": {"braking_share": (0.4, 1.1)}},
            r"ranges\['braking_share'\] of pd_dob: braking_share must not exceed",
        ),
        ({"ranges": {"position_share": (0.4, 1.1)}}, r"ranges\['position_share'\] of pd_dob: .* below rate_gain"),
    ],
)
def test_bad_arguments(make, arguments, message):
    with pytest.raises(ValueError, match=message):
        GainScheduling(make(), **arguments)


@makers
@pytest.mark.parametrize(
    ("outer", "inner"), [(GainScheduling, ResidualPolicy), (ResidualPolicy, GainScheduling), (GainScheduling,) * 2]
)
def test_one_wrapper_acts_on_the_wheels(make, outer, inner):
    with pytest.raises(ValueError, match="env must take commands to the wheels: one wrapper can act on them"):
        outer(ObservationHistory(inner(make())))


@makers
def test_bad_actions(make):
    env = GainScheduling(make())
    env.reset(seed=0)
    with pytest.raises(ValueError, match=r"actions? must have shape \((2, )?5,?\), got \(4,\)"):
        env.step(np.zeros(4))
    with pytest.raises(ValueError, match="action must be finite"):
        env.step(np.full(env.action_space.shape, np.nan))


def test_foreign_environments():
    with pytest.raises(ValueError, match="env must be an environment of ftac_gym"):
        GainScheduling(gym.make("Pendulum-v1"))


@pytest.mark.parametrize("name", BASES)
def test_schedule_of_a_baseline(name):
    scenario = scenarios.get("flagship")
    law, own = baselines.make(name, scenario, 2), baselines.make(name, scenario, 2)
    env = SpacecraftFTCVectorEnv(2)
    env.reset(seed=0)
    measurement, gain = env.measurement(), "rate_gain" if "rate_gain" in law.schedulable else "rate_limit"
    expected = own.act(measurement)
    law.schedule({gain: np.array([3.0, 9.0])})
    law.reset()
    assert (law.act(measurement) != expected).any(axis=1).all(), "a reset keeps the gains"
    law.reset()
    law.schedule({})
    np.testing.assert_array_equal(law.act(measurement), expected)
    for values in ([3.0], [3.0, 0.0], [3.0, np.nan], [3.0, np.inf], 3.0):
        with pytest.raises(ValueError, match=f"{gain} must be 2 positive numbers"):
            law.schedule({gain: np.array(values)})
    with pytest.raises(
        ValueError, match=f"scheduled gain of {type(law).__name__} must be among .*'{gain}'.*got 'mood'"
    ):
        law.schedule({"mood": np.ones(2)})


def test_the_default_share_gives_the_default_gain_to_the_bit():
    random = np.random.default_rng(0)
    limit, own = random.uniform(1.0, 9.0, 1000), random.uniform(0.1, 0.9, 1000)
    assert (own / limit * limit != own).any()  # not of itself
    found = [scheduled_share(*pair, np.array([pair[0] / pair[1]]), pair[1])[0] for pair in zip(own, limit, strict=True)]
    np.testing.assert_array_equal(found, own)
    np.testing.assert_allclose(scheduled_share(3.0, 6.0, np.array([0.5, 0.25]), np.array([8.0, 4.0])), [4.0, 1.0])


def test_a_baseline_without_schedulable_gains():
    law = baselines.make("hsfc", scenarios.get("flagship"))
    law.schedule({})
    with pytest.raises(ValueError, match=r"scheduled gain of HSFC must be among \[\], got 'rate_gain'"):
        law.schedule({"rate_gain": np.ones(1)})
