"""The residual policy: a zero residual is the base bit for bit, and every observation carries the base action."""

import itertools

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import data_equivalence
from gymnasium.vector import AutoresetMode, VectorEnv
from helpers.custom_baseline import CustomBaseline, CustomOracle
from helpers.names import fitting

from ftac_gym import baselines, scenarios
from ftac_gym.envs import SpacecraftFTCEnv, SpacecraftFTCVectorEnv
from ftac_gym.task.initial_state import InitialState
from ftac_gym.wrappers import ResidualPolicy
from ftac_gym.wrappers.residual import Residual

COUNT, WHEELS = 4, 4
# Spacecraft tumble at different times, under the base too, because their rates are large and random.
SETTINGS = {"duration": 2.0, "tumble_rate": 0.016}  # s, rad/s
MODES = [mode.value for mode in AutoresetMode]
OTHER_MODES = [mode for mode in MODES if mode != "SameStep"]
SEVERAL = ("pd", "pd_dob", "nftsm_observer", "hsfc", "afntsmc")
NAMES = {
    "SpacecraftFTC-v0": fitting(scenarios.get("flagship"), oracles=False),
    "SpacecraftFTCTracking-v0": fitting(scenarios.get("flagship_tracking"), oracles=False),
}


def native(mode, **arguments):
    return SpacecraftFTCVectorEnv(COUNT, autoreset_mode=mode, **{**SETTINGS, **arguments})


@pytest.mark.parametrize(
    ("environment_id", "name"), [(environment_id, name) for environment_id in NAMES for name in NAMES[environment_id]]
)
def test_zero_residual_is_the_base_in_a_single_environment(environment_id, name):
    plain = gym.make(environment_id, **SETTINGS)
    wrapped = ResidualPolicy(gym.make(environment_id, **SETTINGS), base=name)
    policy = baselines.make(name, plain.unwrapped.scenario).as_policy(plain)
    ends = 0
    result, expected = wrapped.reset(seed=3), plain.reset(seed=3)
    for _ in range(100):
        action, _ = policy.predict(expected[0])
        np.testing.assert_array_equal(result[0][:-WHEELS], expected[0])
        np.testing.assert_array_equal(result[0][-WHEELS:], action.astype(np.float32))
        result, expected = wrapped.step(np.zeros(WHEELS, dtype=np.float32)), plain.step(action)
        assert data_equivalence(result[1:], expected[1:])
        if expected[2] or expected[3]:
            ends += 1
            result, expected = wrapped.reset(), plain.reset()
    assert ends >= 4


@pytest.mark.parametrize(
    ("mode", "name"),
    [*(("SameStep", name) for name in NAMES["SpacecraftFTC-v0"]), *itertools.product(OTHER_MODES, SEVERAL)],
)
def test_zero_residual_is_the_base_in_a_vector_environment(mode, name):
    """Every base in one mode, and bases with and without memory and observer in the others."""
    plain, wrapped = native(mode), ResidualPolicy(native(mode), base=name)
    policy = baselines.make(name, plain.scenario, COUNT).as_policy(plain)
    ends, single_end = np.zeros(COUNT, dtype=int), False
    (observation, _), (result, _) = plain.reset(seed=3), wrapped.reset(seed=3)
    for _ in range(110):
        action, _ = policy.predict(observation)
        np.testing.assert_array_equal(result[:, :-WHEELS], observation)
        np.testing.assert_array_equal(result[:, -WHEELS:], action.astype(np.float32))
        observation, reward, terminated, truncated, _ = plain.step(action)
        result, *others, infos = wrapped.step(np.zeros((COUNT, WHEELS)))
        for got, wanted in zip(others, (reward, terminated, truncated), strict=True):
            np.testing.assert_array_equal(got, wanted)
        done = terminated | truncated
        assert ("final_obs" in infos) == bool(mode == "SameStep" and done.any())
        ends += done
        single_end |= bool(done.any() and not done.all())
        if mode == "Disabled" and done.any():  # partial resets: see test_a_vector_equals_single_environments
            all_of_them = {"reset_mask": np.ones(COUNT, dtype=bool)}
            (observation, _), (result, _) = plain.reset(options=all_of_them), wrapped.reset(options=all_of_them)
    assert ends.min() >= 3 or mode == "Disabled"
    # The law as Ma et al. print it brakes every spacecraft, so that none tumbles: all end together.
    assert ends.sum() >= 5 and single_end == (name != "hsfc")


@pytest.mark.parametrize("profile", [{}, {"authority_angle": 2.5, "authority_floor": 0.2}], ids=["constant", "falling"])
@pytest.mark.parametrize("mode", MODES)
def test_a_vector_equals_single_environments(mode, profile):
    """With residuals, and in disabled mode with partial resets: every spacecraft is the single environment."""
    vector = ResidualPolicy(native(mode, observation="telemetry"), authority=0.4)
    singles = [
        ResidualPolicy(SpacecraftFTCEnv(**SETTINGS, observation="telemetry"), authority=0.4) for _ in range(COUNT)
    ]
    random = np.random.default_rng(0)
    rows = [env.reset(seed=9 + spacecraft)[0] for spacecraft, env in enumerate(singles)]
    observation, _ = vector.reset(seed=9)
    waiting, ends = np.zeros(COUNT, dtype=bool), np.zeros(COUNT, dtype=int)
    for _ in range(120):
        np.testing.assert_allclose(observation, rows, rtol=1e-6, atol=1e-6)
        residual = random.uniform(-1.0, 1.0, (COUNT, WHEELS))
        observation, reward, terminated, truncated, infos = vector.step(residual)
        for spacecraft, env in enumerate(singles):
            if waiting[spacecraft]:
                rows[spacecraft], _ = env.reset()
                waiting[spacecraft] = False
                continue
            rows[spacecraft], single_reward, *ended, _ = env.step(residual[spacecraft])
            assert single_reward == pytest.approx(reward[spacecraft], rel=1e-9, abs=1e-9)
            assert [terminated[spacecraft], truncated[spacecraft]] == ended
            if any(ended):
                ends[spacecraft] += 1
                if mode == "SameStep":
                    np.testing.assert_allclose(infos["final_obs"][spacecraft], rows[spacecraft], rtol=1e-6, atol=1e-6)
                if mode == "NextStep":
                    waiting[spacecraft] = True
                else:
                    rows[spacecraft], _ = env.reset()
        done = terminated | truncated
        if mode == "Disabled" and done.any():
            before = observation
            observation, _ = vector.reset(options={"reset_mask": done})
            np.testing.assert_array_equal(observation[~done], before[~done])  # untouched, base action and all
    assert ends.min() >= 3


def test_final_observation_carries_the_base_action_of_the_final_measurement():
    same, disabled = ResidualPolicy(native("SameStep")), ResidualPolicy(native("Disabled"))
    same.reset(seed=3)
    disabled.reset(seed=3)
    random = np.random.default_rng(0)
    checked = 0
    for _ in range(100):
        residual = random.uniform(-1.0, 1.0, (COUNT, WHEELS))
        observation, _, terminated, truncated, infos = same.step(residual)
        expected, *_ = disabled.step(residual)
        done = terminated | truncated
        for spacecraft in np.flatnonzero(done):
            assert infos["final_obs"][spacecraft].shape == same.single_observation_space.shape
            assert infos["final_obs"][spacecraft].dtype == np.float32
            np.testing.assert_array_equal(infos["final_obs"][spacecraft], expected[spacecraft])
            assert same.single_observation_space.contains(infos["final_obs"][spacecraft])
            checked += 1
        if done.any():
            expected, _ = disabled.reset(options={"reset_mask": done})
        np.testing.assert_array_equal(observation, expected)
    assert checked >= 8


@pytest.mark.parametrize("authority", [0.25, 2.0])
def test_the_action_sent_on(authority):
    wrapped, plain = (SpacecraftFTCVectorEnv(COUNT, autoreset_mode="Disabled") for _ in range(2))
    wrapped = ResidualPolicy(wrapped, base="pd", authority=authority)
    observation, _ = wrapped.reset(seed=0)
    plain.reset(seed=0)
    random = np.random.default_rng(0)
    limited = 0
    for _ in range(20):
        residual = random.uniform(-1.0, 1.0, (COUNT, WHEELS))
        action = np.clip(wrapped.transform.base_action + authority * residual, -1.0, 1.0)
        np.testing.assert_array_equal(observation[:, -WHEELS:], wrapped.transform.base_action.astype(np.float32))
        limited += (np.abs(action) == 1.0).sum()
        observation, *_ = wrapped.step(residual)
        np.testing.assert_array_equal(observation[:, :-WHEELS], plain.step(action)[0])
    assert limited > 0


@pytest.mark.parametrize(("angle", "share"), [(0.5, 1.0), (0.1, 0.5), (0.03, 0.15), (0.001, 0.05)])
def test_authority_near_the_target(angle, share):
    """Below 0.2 rad the authority shrinks with the error, down to a twentieth."""
    start = InitialState.fixed((np.cos(angle / 2.0), 0.0, np.sin(angle / 2.0), 0.0))
    scenario = {"initial_state": start, "sensors": None, "faults": None}
    gains = {"base": "pd", "authority": 0.4, "authority_angle": 0.2, "authority_floor": 0.05}
    for make in (SpacecraftFTCEnv, lambda **changes: SpacecraftFTCVectorEnv(1, **changes)):
        env = ResidualPolicy(make(**scenario), **gains)
        observation, _ = env.reset(seed=0)
        base = observation[..., -WHEELS:].ravel()
        residual = -0.5 * np.sign(base)  # away from the limits
        env.step(residual.reshape(env.action_space.shape))
        sent = env.unwrapped.measurement().last_command[0] / 0.2
        np.testing.assert_allclose(sent, base + 0.4 * share * residual, atol=1e-6)


def test_spaces():
    inner = gym.make("SpacecraftFTC-v0")
    wrapped, vector = ResidualPolicy(inner), ResidualPolicy(native("SameStep"))
    assert isinstance(vector, VectorEnv) and isinstance(vector.transform, Residual) and vector.num_envs == COUNT
    assert wrapped.action_space == inner.action_space == vector.single_action_space
    size = inner.observation_space.shape[0]
    assert wrapped.observation_space.shape == (size + WHEELS,)
    np.testing.assert_array_equal(wrapped.observation_space.high[-WHEELS:], 1.0)
    np.testing.assert_array_equal(wrapped.observation_space.low[:size], inner.observation_space.low)
    assert vector.single_observation_space == wrapped.observation_space
    assert vector.observation_space.shape == (COUNT, size + WHEELS)
    assert vector.observation_space.contains(vector.reset(seed=0)[0])


def test_gains_reach_the_base():
    soft, default = (ResidualPolicy(SpacecraftFTCEnv(), base="pd", **gains) for gains in ({"braking_share": 0.1}, {}))
    assert (soft.reset(seed=0)[0][-WHEELS:] != default.reset(seed=0)[0][-WHEELS:]).any()


@pytest.mark.parametrize("make", [SpacecraftFTCEnv, lambda: SpacecraftFTCVectorEnv(2)], ids=["single", "vector"])
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"base": "lqg"}, "baseline must be one of .*'lqg'"),
        ({"authority": 0.0}, "authority must be above 0 and at most 2, got 0.0"),
        ({"authority": 2.1}, "authority must be above 0 and at most 2"),
        ({"authority": float("nan")}, "authority must be finite, got nan"),
        ({"authority_angle": -0.1}, "authority_angle must not be negative"),
        ({"authority_angle": 0.1, "authority_floor": 1.5}, r"authority_floor must be within \[0, 1\], got 1.5"),
        ({"rate_gain": -1.0}, "rate_gain must be positive"),
    ],
)
def test_bad_arguments(make, arguments, message):
    with pytest.raises(ValueError, match=message):
        ResidualPolicy(make(), **arguments)


@pytest.mark.parametrize("make", [SpacecraftFTCEnv, lambda: SpacecraftFTCVectorEnv(2)], ids=["single", "vector"])
def test_an_unknown_gain_is_a_type_error(make):
    for gains in ({"beauty": 1.0}, {"base": "nftsm_observer", "observer": {"beauty": 1.0}}):
        with pytest.raises(TypeError, match="got an unexpected keyword argument 'beauty'; gains of "):
            ResidualPolicy(make(), **gains)


@pytest.mark.parametrize("env", [gym.make("Pendulum-v1"), gym.make_vec("Pendulum-v1", num_envs=2)])
def test_foreign_environments(env):
    with pytest.raises(ValueError, match="env must be an environment of ftac_gym"):
        ResidualPolicy(env)


@pytest.mark.parametrize("make", [SpacecraftFTCEnv, lambda: SpacecraftFTCVectorEnv(2)], ids=["single", "vector"])
def test_bad_residuals(make):
    env = ResidualPolicy(make())
    env.reset(seed=0)
    with pytest.raises(ValueError, match=r"actions? must have shape \((2, )?4,?\), got \(7,\)"):
        env.step(np.zeros(7))
    with pytest.raises(ValueError, match="action must be finite"):
        env.step(np.full(env.action_space.shape, np.nan))


@pytest.mark.parametrize("base", [CustomBaseline, "helpers.custom_baseline:CustomBaseline"])
def test_zero_residual_on_a_custom_base_is_that_base(base):
    env = native("SameStep")
    wrapped = ResidualPolicy(native("SameStep"), base=base, damping=3.0)
    policy = baselines.make(CustomBaseline, env.batch.scenario, COUNT, damping=3.0).as_policy(env)
    expected, _ = env.reset(seed=3)
    result, _ = wrapped.reset(seed=3)
    ends = 0
    for _ in range(60):
        action, _ = policy.predict(expected)
        np.testing.assert_array_equal(result[:, -WHEELS:], action.astype(np.float32))
        expected, _, terminated, truncated, _ = env.step(action)
        result, *_ = wrapped.step(np.zeros((COUNT, WHEELS)))
        np.testing.assert_array_equal(result[:, :-WHEELS], expected)
        ends += int((terminated | truncated).sum())
    assert ends > COUNT  # its memory starts anew, spacecraft by spacecraft


def test_a_custom_oracle_is_no_base():
    with pytest.raises(ValueError, match="base must not be an oracle"):
        ResidualPolicy(native("SameStep"), base=CustomOracle)
