"""`set_severity`, the hook for curricula: it changes the coming episodes, and no others, of every environment."""

import copy
import dataclasses

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec
from stable_baselines3.common.vec_env import DummyVecEnv

import ftac_gym  # noqa: F401  registers the environments
from ftac_gym import scenarios
from ftac_gym.envs import SpacecraftFTCEnv, SpacecraftFTCVectorEnv
from ftac_gym.faults import (
    AttitudeSpike,
    Bias,
    FaultDistribution,
    FaultSchedule,
    IntermittentShutdown,
    LockInPlace,
    Outage,
)
from ftac_gym.utils.serialization import to_plain
from ftac_gym.wrappers import ResidualPolicy, SB3VecEnv

ID = "SpacecraftFTC-v0"
FAULTS = FaultDistribution(
    (Bias(constant=0.1), LockInPlace(onset=0.3), IntermittentShutdown(onset=0.2), AttitudeSpike(angle=0.1)),
    fault_counts=(0.0, 0.0, 1.0),
)
CHANGES = {"faults": to_plain(FAULTS), "duration": 1.0}
BASE = scenarios.get("flagship").replace(duration=1.0, faults=FAULTS)


def scenario_of(severity):
    return BASE.replace(faults=dataclasses.replace(FAULTS, severity=severity))


def assert_flies(batch, episodes):
    """The episodes that the spacecraft of an environment are in are the given ones, number by number."""
    current = batch.simulator.episodes
    for name, array in episodes.arrays().items():
        np.testing.assert_array_equal(current.arrays()[name], array, err_msg=name)


def act(env):
    return env.step(np.full(env.action_space.shape, 0.3))


@pytest.mark.parametrize("make", [lambda: gym.make(ID, **CHANGES), lambda: ResidualPolicy(gym.make(ID, **CHANGES))])
def test_single_environment(make):
    env = make()
    env.reset(seed=4)
    for k, severity in enumerate((0.0, 0.5, 1.0, 0.25), start=1):
        env.unwrapped.set_severity(severity)
        env.reset()
        assert_flies(env.unwrapped.batch, scenario_of(severity).draw(4, k + 1)[k])
    assert env.unwrapped.scenario == scenario_of(0.25)
    env.reset(seed=9)  # it stays until it is set again, whatever the seed
    assert_flies(env.unwrapped.batch, scenario_of(0.25).draw(9, 1))


@pytest.mark.parametrize("mode", ["NextStep", "SameStep", "Disabled"])
def test_vector_environment(mode):
    env = gym.make_vec(ID, num_envs=3, autoreset_mode=mode, **CHANGES)
    env.reset(seed=4)
    env.unwrapped.set_severity(0.3)
    for _ in range(10):
        assert_flies(env.unwrapped.batch, concatenated([BASE.draw(4 + craft, 1) for craft in range(3)]))
        act(env)
    if mode == "NextStep":
        act(env)
    elif mode == "Disabled":
        env.reset(options={"reset_mask": np.ones(3, dtype=bool)})
    assert_flies(env.unwrapped.batch, concatenated([scenario_of(0.3).draw(4 + craft, 2)[1] for craft in range(3)]))


def concatenated(parts):
    joined = {name: np.concatenate([part.arrays()[name] for part in parts]) for name in parts[0].arrays()}
    return dataclasses.replace(parts[0], **joined)


def test_craft_of_different_severities_side_by_side():
    """A masked reset after the change: the others go on with what they have."""
    env, twin = (gym.make_vec(ID, num_envs=3, autoreset_mode="Disabled", **CHANGES) for _ in range(2))
    for item in (env, twin):
        item.reset(seed=4)
        act(item)
    mask = np.array([False, True, False])
    env.unwrapped.set_severity(0.0)
    env.reset(options={"reset_mask": mask})
    drawn = [BASE.draw(4, 1), scenario_of(0.0).draw(5, 2)[1], BASE.draw(6, 1)]
    assert_flies(env.unwrapped.batch, concatenated(drawn))
    for _ in range(5):
        np.testing.assert_array_equal(act(env)[0][~mask], act(twin)[0][~mask])


def test_running_episodes_are_untouched():
    for make in (lambda: gym.make(ID, **CHANGES), lambda: gym.make_vec(ID, num_envs=3, **CHANGES)):
        env, twin = make(), make()
        for item in (env, twin):
            item.reset(seed=1)
        for step in range(10):
            if step == 3:
                env.unwrapped.set_severity(0.0)
            for one, other in zip(act(env)[:4], act(twin)[:4], strict=True):
                np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize(
    "make",
    [
        lambda: gym.make(ID, **CHANGES),
        lambda: gym.make(ID, scenario="flagship_double"),
        lambda: gym.make(ID),
        lambda: ResidualPolicy(gym.make(ID, **CHANGES)),
        lambda: gym.make_vec(ID, num_envs=3, **CHANGES),
        lambda: ResidualPolicy(gym.make_vec(ID, num_envs=3)),
    ],
    ids=["single", "by name", "default", "wrapped", "vector", "wrapped vector"],
)
def test_the_specification_makes_the_same_environment_again(make):
    env = make()
    before = env.unwrapped.spec
    old = copy.deepcopy(before.kwargs)
    env.unwrapped.set_severity(0.3)
    assert before.kwargs == old, "a specification that was read before does not change"
    remake = gym.make if isinstance(env, gym.Env) else gym.make_vec
    for spec in (env.spec, EnvSpec.from_json(env.unwrapped.spec.to_json()), copy.deepcopy(env).unwrapped.spec):
        assert remake(spec).unwrapped.scenario == env.unwrapped.scenario
    env.unwrapped.set_severity(0.6)
    assert remake(env.unwrapped.spec).unwrapped.scenario == env.unwrapped.scenario
    assert env.unwrapped.scenario.faults.severity == 0.6


def test_severity_zero_gives_healthy_craft():
    env = SpacecraftFTCVectorEnv(20, **CHANGES)
    env.set_severity(0.0)
    env.reset(seed=0)
    assert np.all(env.batch.simulator.faults.wheels["kind"] == 0)
    assert np.all(env.batch.simulator.faults.sensors["kind"] == 0)
    healthy = SpacecraftFTCVectorEnv(20, faults=None, duration=1.0)
    healthy.reset(seed=0)
    for _ in range(9):
        np.testing.assert_array_equal(act(env)[0], act(healthy)[0])


def test_through_the_adapter_for_stable_baselines():
    env = SB3VecEnv(SpacecraftFTCVectorEnv(4, autoreset_mode="SameStep", **CHANGES))
    env.seed(4)
    env.reset()
    assert env.env_method("set_severity", 0.3) == [None] * 4
    assert env.get_attr("scenario") == [scenario_of(0.3)] * 4
    for _ in range(10):
        env.step(np.zeros((4, 4)))
    drawn = [scenario_of(0.3).draw(4 + craft, 2)[1] for craft in range(4)]
    assert_flies(env.env.unwrapped.batch, concatenated(drawn))
    env.env_method("set_severity", severity=0.6)
    env.seed(4)
    env.reset()
    assert_flies(env.env.unwrapped.batch, concatenated([scenario_of(0.6).draw(4 + craft, 1) for craft in range(4)]))


def test_through_the_vector_environment_of_stable_baselines():
    """Single environments, each with a scenario of its own."""
    env = DummyVecEnv([lambda: gym.make(ID, **CHANGES)] * 3)
    env.seed(4)
    env.reset()
    env.env_method("set_severity", 0.3)
    env.env_method("set_severity", 0.8, indices=[1])
    for _ in range(10):
        env.step(np.zeros((3, 4)))
    for craft, severity in enumerate((0.3, 0.8, 0.3)):
        batch = env.envs[craft].unwrapped.batch
        assert_flies(batch, scenario_of(severity).draw(4 + craft, 2)[1])


def test_copies_have_a_severity_of_their_own():
    env = gym.make(ID, **CHANGES)
    env.reset(seed=4)
    twin = copy.deepcopy(env)
    twin.unwrapped.set_severity(0.0)
    for item, severity in ((env, 1.0), (twin, 0.0)):
        item.reset()
        assert_flies(item.unwrapped.batch, scenario_of(severity).draw(4, 2)[1])


@pytest.mark.parametrize(
    ("severity", "message"),
    [
        (-0.1, r"severity must be within \[0, 1\], got -0.1"),
        (1.5, r"severity must be within \[0, 1\], got 1.5"),
        (float("nan"), "severity must be finite"),
        (None, "severity must be a number"),
        ("worst", "severity must be a number"),
    ],
)
@pytest.mark.parametrize("make", [lambda: SpacecraftFTCEnv(**CHANGES), lambda: SpacecraftFTCVectorEnv(2, **CHANGES)])
def test_a_bad_severity_is_refused_and_changes_nothing(make, severity, message):
    env = make()
    env.set_severity(0.5)
    with pytest.raises(ValueError, match=message):
        env.set_severity(severity)
    assert env.scenario == scenario_of(0.5)


@pytest.mark.parametrize("faults", [None, FaultSchedule((Outage(wheel=0),))])
def test_only_a_distribution_has_a_severity(faults):
    for env in (SpacecraftFTCEnv(faults=faults), SpacecraftFTCVectorEnv(2, faults=faults)):
        with pytest.raises(ValueError, match="faults must be a FaultDistribution to have a severity, got"):
            env.set_severity(0.5)
