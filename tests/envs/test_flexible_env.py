"""Environments of flexible spacecraft: checkers, the modal entries of the observation, and the reward for vibration."""

import copy
from dataclasses import replace

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec
from helpers.flexible_env import IDS, MODAL, SHORT, TIERS, shaken
from helpers.flexible_spacecraft import flexible_scenario

import ftac_gym  # noqa: F401  registers the environments
from ftac_gym import scenarios
from ftac_gym.envs import SpacecraftFTCEnv, SpacecraftFTCVectorEnv
from ftac_gym.envs.observation import observation_layout
from ftac_gym.spacecraft.appendages import FlexibleAppendages
from ftac_gym.task.objective import RewardWeights

# ------------------------------------------------------------------------------------------------------------- spaces


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("tier", TIERS)
@pytest.mark.parametrize("environment_id", IDS)
def test_random_flights_stay_within_the_spaces(environment_id, tier):
    vector = gym.make_vec(environment_id, num_envs=4, observation=tier, duration=5.0, autoreset_mode="SameStep")
    observations, _ = vector.reset(seed=0)
    vector.action_space.seed(0)
    for _ in range(110):
        assert vector.observation_space.contains(observations)
        observations, rewards, *_ = vector.step(vector.action_space.sample())
        assert np.isfinite(rewards).all()
    vector.close()


@pytest.mark.parametrize(("environment_id", "name"), IDS.items())
def test_an_id_stands_for_its_scenario_and_is_made_again_from_its_spec(environment_id, name):
    env = gym.make(environment_id, observation="telemetry", duration=3.0)
    assert env.unwrapped.scenario == scenarios.get(name).replace(duration=3.0)
    again = gym.make(EnvSpec.from_json(env.spec.to_json()))
    assert again.unwrapped.scenario == env.unwrapped.scenario
    twin = None
    np.testing.assert_array_equal(env.reset(seed=5)[0], again.reset(seed=5)[0])
    for step in range(20):
        action = np.full(env.action_space.shape, 0.05 * step - 0.4, np.float32)
        if step == 7:
            twin = copy.deepcopy(env)
        first, second = env.step(action), again.step(action)
        np.testing.assert_array_equal(first[0], second[0])
        assert first[1:3] == second[1:3]
        if twin is not None:
            np.testing.assert_array_equal(twin.step(action)[0], first[0])
    assert gym.make_vec(environment_id, num_envs=2).unwrapped.scenario == scenarios.get(name)


def test_one_craft_and_many_see_the_same():
    scenario = shaken(SHORT)
    vector = SpacecraftFTCVectorEnv(3, scenario=scenario, observation="telemetry")
    observations, _ = vector.reset(seed=[4, 5, 6])
    singles = [SpacecraftFTCEnv(scenario=scenario, observation="telemetry") for _ in range(3)]
    for seed, single, row in zip((4, 5, 6), singles, observations, strict=True):
        np.testing.assert_array_equal(single.reset(seed=seed)[0], row)
    actions = np.random.default_rng(0).uniform(-1.0, 1.0, (25, 3, 4))
    for action in actions:
        observations, rewards, *_ = vector.step(action)
        for craft, single in enumerate(singles):
            seen, reward, *_ = single.step(action[craft])
            np.testing.assert_array_equal(seen, observations[craft])
            assert reward == rewards[craft]


# -------------------------------------------------------------------------------------------------------- observation


@pytest.mark.parametrize("name", ["flexible", "li_2023"])
def test_only_telemetry_and_oracle_have_modal_entries(name):
    scenario = scenarios.get(name)
    layouts = {tier: observation_layout(scenario, tier) for tier in TIERS}
    rigid = {
        tier: observation_layout(
            scenario.replace(spacecraft=replace(scenario.spacecraft, appendages=None), appendage_uncertainty=None), tier
        )
        for tier in TIERS
    }
    assert layouts["attitude"].slices == rigid["attitude"].slices
    for tier in ("telemetry", "oracle"):
        slices = layouts[tier].slices
        assert set(slices) - set(rigid[tier].slices) == set(MODAL)
        assert [slices[part].stop - slices[part].start for part in MODAL] == [4, 4]
        assert layouts[tier].size == rigid[tier].size + 8
        # The entries of a rigid spacecraft of the tier come first, except those of the oracle.
        for part in rigid["telemetry"].slices:
            assert slices[part] == rigid[tier].slices[part]
        assert list(slices)[len(rigid["telemetry"].slices) :][:2] == list(MODAL)
        for part in MODAL:
            np.testing.assert_array_equal(layouts[tier].high[slices[part]], 10.0)


def test_the_modal_entries_have_the_documented_scale():
    """One is what the full torque of one wheel holds: eta = -K^-1 delta w' at w' = J^-1 (axis limit)."""
    scenario = shaken(SHORT)
    craft = scenario.spacecraft
    delta, frequency = np.array(craft.appendages.coupling), np.array(craft.appendages.frequencies)
    pushes = [
        np.linalg.norm(np.linalg.solve(craft.inertia_matrix, axis * limit))
        for axis, limit in zip(craft.wheels.axis_matrix.T, craft.wheels.torque_limits, strict=True)
    ]
    held = np.linalg.norm(delta, axis=1) * max(pushes) / frequency**2
    env = SpacecraftFTCEnv(scenario=scenario, observation="telemetry")
    slices = env.observation_slices
    for seed in range(4):
        observation, _ = env.reset(seed=seed)
        for _ in range(10):
            state = env.batch.simulator.state
            for part, values, scale in zip(
                MODAL, (state.modal_displacement[0], state.modal_rate[0]), (held, held * frequency), strict=True
            ):
                expected = np.clip(values / scale, -10.0, 10.0)
                np.testing.assert_allclose(observation[slices[part]], expected, rtol=1e-6, atol=1e-7)
            assert env.observation_space.contains(observation)
            observation, *_ = env.step(np.array([1.0, -1.0, 0.5, 0.0]))


def test_a_wheel_at_its_limit_holds_a_mode_at_about_one():
    """A heavily damped mode along an axis that one of three wheels turns settles at -1 in units of the scale."""
    appendages = FlexibleAppendages((2.0,), 0.7, ((1.0, 0.0, 0.0),))
    base = scenarios.get("li_2023")
    inertia = np.diag([100.0, 120.0, 140.0])
    scenario = base.replace(
        spacecraft=replace(base.spacecraft, inertia=inertia, appendages=appendages),
        initial_state=replace(base.initial_state, rate=(0.0, 0.0, 0.0)), faults=None, disturbance=None,
        misalignment=None, duration=30.0,
    )  # fmt: skip
    env = SpacecraftFTCEnv(scenario=scenario, observation="telemetry")
    env.reset(seed=0)
    for _ in range(200):
        observation, *_ = env.step(np.array([1.0, 0.0, 0.0]))
    assert observation[env.observation_slices["modal_displacement"]] == pytest.approx(-1.0, abs=1e-3)
    assert observation[env.observation_slices["modal_rate"]] == pytest.approx(0.0, abs=1e-3)


def test_modes_that_are_not_coupled_or_not_limited_are_still_finite():
    appendages = FlexibleAppendages((0.01, 2.0), 0.0, np.zeros((2, 3)))
    scenario = flexible_scenario(appendages, displacement=(1e6, 1e-9), swing=(-1e6, 0.0))
    env = SpacecraftFTCEnv(scenario=scenario, observation="telemetry")
    observation, _ = env.reset(seed=0)
    assert env.observation_space.contains(observation)
    slices = env.observation_slices
    assert observation[slices["modal_displacement"]][0] == 10.0 and observation[slices["modal_rate"]][0] == -10.0
    assert abs(observation[slices["modal_displacement"]][1]) < 1e-3


@pytest.mark.parametrize("tier", TIERS)
def test_the_observation_does_not_know_the_true_modes(tier):
    """Scales are nominal: with the same true state, spacecraft with other true modes look alike."""
    exact = shaken(SHORT).replace(appendage_uncertainty=None, sensors=None)
    unsure = shaken(SHORT).replace(sensors=None)
    first, second = (SpacecraftFTCEnv(scenario=one, observation=tier).reset(seed=3)[0] for one in (exact, unsure))
    np.testing.assert_array_equal(first, second)


def test_the_attitude_tier_sees_the_modes_only_through_the_motion():
    """Modes that shake but are not coupled change nothing of it; the telemetry tier does see them."""
    loose = FlexibleAppendages((1.0, 2.0, 3.0, 4.0), 0.01, np.zeros((4, 3)))
    still = SHORT.replace(spacecraft=replace(SHORT.spacecraft, appendages=loose), reward=RewardWeights())
    rigid = SHORT.replace(
        spacecraft=replace(SHORT.spacecraft, appendages=None), appendage_uncertainty=None, reward=RewardWeights()
    )
    seen = {}
    actions = np.random.default_rng(0).uniform(-1.0, 1.0, (40, 4))
    for tier in ("attitude", "telemetry"):
        for name, scenario in (("still", still), ("shaken", shaken(still)), ("rigid", rigid)):
            env = SpacecraftFTCEnv(scenario=scenario, observation=tier)
            history = [env.reset(seed=2)[0]]
            rewards = []
            for action in actions:
                observation, reward, *_ = env.step(action)
                history.append(observation)
                rewards.append(reward)
            seen[tier, name] = np.array(history), np.array(rewards), env.observation_slices
    for name in ("shaken", "rigid"):
        np.testing.assert_array_equal(seen["attitude", name][0], seen["attitude", "still"][0])
        np.testing.assert_array_equal(seen["attitude", name][1], seen["attitude", "still"][1])
    telemetry, slices = seen["telemetry", "shaken"][0], seen["telemetry", "shaken"][2]
    start = slices["modal_displacement"].start
    np.testing.assert_array_equal(telemetry[:, :start], seen["telemetry", "still"][0][:, :start])
    assert np.abs(telemetry[:, start:] - seen["telemetry", "still"][0][:, start:]).max() > 0.1


def test_measurements_hold_the_modes():
    env = SpacecraftFTCVectorEnv(3, scenario=shaken(SHORT))
    env.reset(seed=0)
    env.step(np.full((3, 4), 0.3))
    measured, state = env.measurement(), env.batch.simulator.state
    np.testing.assert_array_equal(measured.modal_displacement, state.modal_displacement)
    np.testing.assert_array_equal(measured.take(np.array([2, 0])).modal_rate, state.modal_rate[[2, 0]])
    assert not np.shares_memory(measured.modal_rate, state.modal_rate)
