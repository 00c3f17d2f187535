"""All ids against Gymnasium's and Stable-Baselines3's checkers, their specs, and what they refuse."""

import copy
import pickle

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec
from gymnasium.utils.env_checker import check_env
from stable_baselines3.common.env_checker import check_env as sb3_check_env

import ftac_gym  # noqa: F401  registers the environments
from ftac_gym import scenarios
from ftac_gym.envs import SpacecraftFTCEnv, SpacecraftFTCVectorEnv
from ftac_gym.faults import KINDS, AttitudeSpike, FaultDistribution, FaultSchedule, Outage, WheelFault
from ftac_gym.spacecraft.friction import Friction
from ftac_gym.spacecraft.spacecraft import Spacecraft
from ftac_gym.spacecraft.wheel_array import WheelArray
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.low_orbit import LowOrbitTorque
from ftac_gym.task.scenario import RewardWeights
from ftac_gym.task.sensors import SensorErrors
from ftac_gym.utils.serialization import to_plain
from ftac_gym.wrappers import ResidualPolicy
from ftac_gym.wrappers.residual import Residual

WHEELS = {
    "SpacecraftFTCEasy-v0": 4,
    "SpacecraftFTC-v0": 4,
    "SpacecraftFTCTracking-v0": 4,
    "SpacecraftFTCZhangZhou2019-v0": 4,
    "SpacecraftFTCCao2022-v0": 3,
    "SpacecraftFTCMa2023-v0": 3,
    "SpacecraftFTCChen2018-v0": 3,
    "SpacecraftFTCFlexible-v0": 4,
    "SpacecraftFTCLi2023-v0": 3,
}
IDS = tuple(WHEELS)
TIERS = ("attitude", "telemetry", "oracle")
RUBBING = Spacecraft(
    scenarios.get("flagship").spacecraft.inertia,
    WheelArray(
        scenarios.get("flagship").spacecraft.wheels.axes, 0.2, 12.0, spin_inertia=0.02, lag=0.03,
        friction=(Friction(0.01), None, Friction(0.01, 0.02, viscous=1e-4), Friction(0.02)),
    ),
)  # fmt: skip
EVERY_FAULT = FaultSchedule(
    tuple(
        kind(onset=(0.5, 2.0), **({"wheel": 2 * (index % 2)} if issubclass(kind, WheelFault) else {}))
        for index, kind in enumerate(KINDS)
    )
)
UNLIMITED = Spacecraft(
    ((10.0, 0.0, 0.0), (0.0, 12.0, 0.0), (0.0, 0.0, 15.0)), WheelArray(np.eye(3).tolist(), torque_limit=None)
)


def fly(env, seed, steps=15):
    """Return everything that an environment gives for random actions."""
    random = np.random.default_rng(0)
    history = [env.reset(seed=seed)]
    for _ in range(steps):
        history.append(env.step(random.uniform(-1.0, 1.0, env.action_space.shape)))
    return history


def assert_same(first, second):
    """Assert that nested data are exactly equal, types included."""
    assert type(first) is type(second)
    if isinstance(first, dict):
        assert list(first) == list(second)
        assert_same(list(first.values()), list(second.values()))
    elif isinstance(first, (list, tuple)) or (isinstance(first, np.ndarray) and first.dtype == object):
        assert len(first) == len(second)
        for one, other in zip(first, second, strict=True):
            assert_same(one, other)
    else:
        np.testing.assert_array_equal(first, second, strict=True)


# ---------------------------------------------------------------------------------------------------------- checkers


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("tier", TIERS)
@pytest.mark.parametrize("environment_id", IDS)
def test_checkers_pass_without_a_warning(environment_id, tier):
    env = gym.make(environment_id, observation=tier, duration=2.0)
    check_env(env.unwrapped)
    sb3_check_env(env.unwrapped, warn=True)
    sb3_check_env(env, warn=True)


# A wrapper is what is checked here; everything else is an error.
@pytest.mark.filterwarnings("error", "ignore:.*different from the unwrapped version")
@pytest.mark.parametrize("tier", TIERS)
@pytest.mark.parametrize("environment_id", IDS)
def test_checkers_pass_for_residual_policies(environment_id, tier):
    env = ResidualPolicy(gym.make(environment_id, observation=tier, duration=2.0))
    check_env(env)
    sb3_check_env(env, warn=True)


@pytest.mark.parametrize("environment_id", IDS)
def test_spaces(environment_id):
    env, wheels = gym.make(environment_id), WHEELS[environment_id]
    assert env.action_space == gym.spaces.Box(-1.0, 1.0, (wheels,), np.float32)
    assert env.observation_space.dtype == np.float32
    assert env.observation_space.is_bounded("both")
    vector = gym.make_vec(environment_id, num_envs=3)
    assert vector.single_observation_space == env.observation_space
    assert vector.observation_space.shape == (3, *env.observation_space.shape)
    assert vector.action_space.shape == (3, wheels)


# ------------------------------------------------------------------------------------------------------------- specs


@pytest.mark.parametrize(
    ("environment_id", "arguments"),
    [
        (IDS[0], {}),
        (IDS[1], {"observation": "oracle"}),
        (IDS[0], {"duration": 10.0, "observation": "telemetry"}),
        (IDS[0], {"scenario": "flagship_tracking"}),
        (IDS[0], {"faults": None, "sensors": None}),
        (IDS[0], {"reward": to_plain(RewardWeights(progress=3.0)), "control_period": 0.2}),
        (IDS[0], {"initial_state": to_plain(InitialState(angle=(0.1, 0.2)))}),
        (IDS[0], {"scenario": scenarios.get("flagship").replace(duration=5.0, disturbance=None).to_dict()}),
        (IDS[0], {"scenario": scenarios.get("flagship").replace(duration=5.0).to_json()}),
        (IDS[0], {"spacecraft": to_plain(RUBBING), "faults": to_plain(EVERY_FAULT), "observation": "oracle"}),
        (IDS[0], {"faults": to_plain(FaultDistribution((Outage(), AttitudeSpike()), severity=0.4)), "duration": 5.0}),
        (IDS[1], {"disturbance": to_plain(LowOrbitTorque()), "duration": 5.0}),
        (IDS[1], {"sensors": to_plain(SensorErrors(gyro_misalignment=(0.01, 0.02))), "duration": 5.0}),
        (IDS[0], {"spacecraft": RUBBING, "faults": EVERY_FAULT, "disturbance": LowOrbitTorque(), "duration": 5.0}),
        (IDS[2], {}),
        (IDS[2], {"observation": "oracle", "duration": 10.0}),
        (IDS[3], {}),
        (IDS[3], {"observation": "oracle", "duration": 10.0}),
    ],
)
def test_spec_remakes_the_same_environment(environment_id, arguments):
    env = gym.make(environment_id, **arguments)
    again = gym.make(EnvSpec.from_json(env.spec.to_json()))
    assert again.unwrapped.scenario == env.unwrapped.scenario
    assert again.observation_space == env.observation_space
    assert_same(fly(again, seed=3), fly(env, seed=3))


def test_spec_remakes_a_residual_policy():
    env = ResidualPolicy(gym.make(IDS[0], duration=10.0), base="pd", authority=0.3, braking_share=0.31)
    again = gym.make(EnvSpec.from_json(env.spec.to_json()))
    assert isinstance(again.transform, Residual)
    assert_same(fly(again, seed=3), fly(env, seed=3))


def test_vector_spec_remakes_the_same_environment():
    env = gym.make_vec(IDS[1], num_envs=2, duration=1.0, autoreset_mode="SameStep", observation="oracle")
    again = gym.make_vec(EnvSpec.from_json(env.spec.to_json()))
    assert again.num_envs == 2 and again.metadata["autoreset_mode"] is env.metadata["autoreset_mode"]
    assert_same(fly(again, seed=3), fly(env, seed=3))


def test_the_changes_arrive():
    env = gym.make(IDS[0], duration=10.0, reward=to_plain(RewardWeights(progress=3.0)), scenario="flagship_tracking")
    wanted = scenarios.get("flagship_tracking").replace(duration=10.0, reward=RewardWeights(progress=3.0))
    assert env.unwrapped.scenario == wanted
    for name, own in {"": "flagship", "Easy": "easy", "Tracking": "flagship_tracking", "Cao2022": "cao_2022"}.items():
        assert gym.make(f"SpacecraftFTC{name}-v0").unwrapped.scenario == scenarios.get(own)


@pytest.mark.parametrize("clone", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))], ids=["copy", "pickle"])
@pytest.mark.parametrize("kind", ["single", "vector", "residual", "vector residual", "threads"])
def test_clones_continue_identically(clone, kind):
    if kind in ("single", "residual"):
        env = gym.make(IDS[1], observation="oracle", duration=2.0)
    else:
        env = gym.make_vec(
            IDS[1], num_envs=3, observation="oracle", duration=2.0, autoreset_mode="SameStep",
            threads=2 if kind == "threads" else 1,
        )  # fmt: skip
    if "residual" in kind:
        env = ResidualPolicy(env)
    random = np.random.default_rng(1)
    actions = random.uniform(-1.0, 1.0, (60, *env.action_space.shape))
    env.reset(seed=5)
    for action in actions[:7]:
        env.step(action)
    twin = clone(env)
    for action in actions[7:]:
        expected, result = env.step(action), twin.step(action)
        assert_same(result, expected)
        if kind in ("single", "residual") and expected[3]:
            assert_same(twin.reset(), env.reset())


# ----------------------------------------------------------------------------------------------------------- refusals


@pytest.mark.parametrize("cls", [SpacecraftFTCEnv, SpacecraftFTCVectorEnv])
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"scenario": "no_such"}, r"scenario must be one of \[.*'flagship', .*'no_such'"),
        ({"scenario": 3}, "scenario must be a name, .* or a Scenario, got 3"),
        ({"scenario": {"type": "Spaceship"}}, "type must be one of .*'Spaceship'"),
        ({"scenario": to_plain(RewardWeights())}, "scenario must describe a Scenario, got 'RewardWeights'"),
        (
            {"observation": "everything"},
            r"observation must be one of \['attitude', 'telemetry', 'oracle'\], got 'every",
        ),
        ({"render_mode": "ascii"}, "render_mode must be None or one of .*'ascii'"),
        ({"duration": 0.25}, "duration must be a multiple of control_period"),
        ({"duration": -1.0}, "duration must be positive"),
        ({"control_period": 0.05}, "control_period must be a multiple of physics_step = 0.02"),
        ({"physics_step": 0.0}, "physics_step must be positive"),
        ({"tumble_rate": -0.5}, "tumble_rate must be positive"),
        ({"spacecraft": None}, "spacecraft must be a Spacecraft, got None"),
        ({"reward": {"type": "RewardWeights", "beauty": 1.0}}, "RewardWeights has no field 'beauty'"),
        ({"reward": {"type": "RewardWeights", "effort": -1.0}}, "effort must not be negative"),
        ({"spacecraft": UNLIMITED, "faults": None}, "torque_limit must be finite for every wheel"),
    ],
)
def test_bad_arguments(cls, arguments, message):
    with pytest.raises(ValueError, match=message):
        cls(**arguments)


@pytest.mark.parametrize("id_kwargs", [{}, {"vectorization_mode": "vector_entry_point"}])
def test_an_unknown_keyword_is_a_type_error(id_kwargs):
    # Libraries probe for arguments such as ``device`` by calling with them.
    make, name = (gym.make_vec, "SpacecraftFTCVectorEnv") if id_kwargs else (gym.make, "SpacecraftFTCEnv")
    line = rf"{name}\(\) got an unexpected keyword argument 'device'; fields of a scenario are \['name', .*\]"
    with pytest.raises(TypeError, match=line):
        make("SpacecraftFTC-v0", device="cpu", **id_kwargs)
    with pytest.raises(TypeError, match="'durations'"):
        make("SpacecraftFTC-v0", durations=3.0, scenario=3, **id_kwargs)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            {"autoreset_mode": "Sometimes"},
            r"autoreset_mode must be an AutoresetMode or one of \[.*'SameStep'.*Sometimes",
        ),
        ({"autoreset_mode": None}, "autoreset_mode must be an AutoresetMode"),
        ({"num_envs": 0}, "num_envs must be a positive integer, got 0"),
        ({"num_envs": True}, "num_envs must be a positive integer, got True"),
        ({"num_envs": 2.5}, "num_envs must be a positive integer, got 2.5"),
        ({"max_episode_steps": 0}, "max_episode_steps must be a whole number, 1 or more, got 0"),
        ({"threads": 0}, "threads must be a positive integer, got 0"),
    ],
)
def test_bad_vector_arguments(arguments, message):
    with pytest.raises(ValueError, match=message):
        SpacecraftFTCVectorEnv(**{"num_envs": 2, **arguments})


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_actions_that_are_not_finite(value):
    single, vector = SpacecraftFTCEnv(), SpacecraftFTCVectorEnv(2)
    single.reset(seed=0)
    vector.reset(seed=0)
    with pytest.raises(ValueError, match="action must be finite"):
        single.step([0.0, 0.0, value, 0.0])
    with pytest.raises(ValueError, match="action must be finite"):
        vector.step([[0.0] * 4, [0.0, 0.0, value, 0.0]])


@pytest.mark.parametrize("shape", [(), (3,), (5,), (1, 4), (4, 1)])
def test_actions_of_wrong_shape(shape):
    single, vector = SpacecraftFTCEnv(), SpacecraftFTCVectorEnv(4)
    single.reset(seed=0)
    vector.reset(seed=0)
    with pytest.raises(ValueError, match=r"action must have shape \(4,\), got"):
        single.step(np.zeros(shape))
    with pytest.raises(ValueError, match=r"action must have shape \(4, 4\), got"):
        vector.step(np.zeros(shape))


def test_a_refused_action_changes_nothing():
    env, twin = SpacecraftFTCEnv(), SpacecraftFTCEnv()
    assert_same(env.reset(seed=4), twin.reset(seed=4))
    with pytest.raises(ValueError, match="finite"):
        env.step([1.0, np.nan, 1.0, 1.0])
    for _ in range(5):
        assert_same(env.step([0.1, 0.2, 0.3, 0.4]), twin.step([0.1, 0.2, 0.3, 0.4]))
