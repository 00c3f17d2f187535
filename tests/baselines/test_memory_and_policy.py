"""Memory of baselines by spacecraft, and their adapter to the interface of agents."""

import copy
import itertools

import gymnasium as gym
import numpy as np
import pytest
from helpers.names import fitting, is_oracle
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import DummyVecEnv, VecNormalize

from ftac_gym import baselines, scenarios
from ftac_gym.baselines import as_action, measurement_of
from ftac_gym.baselines.memory import Memory
from ftac_gym.dynamics import Simulator
from ftac_gym.envs import SpacecraftFTCEnv, SpacecraftFTCVectorEnv
from ftac_gym.faults import FaultEffect
from ftac_gym.wrappers import SB3VecEnv

FLAGSHIP = scenarios.get("flagship")
TRACKING = scenarios.get("flagship_tracking")
NAMES = fitting(FLAGSHIP)
SEVERAL = ("pd", "pd_dob", "nftsm_observer", "predefined_time_telemetry", "nftsm_oracle", "shopd_plus", "shen_class")
"""Without memory, with observers of each kind, told the truth, with memory of their own."""

COUNT, STEPS = 5, 30


def recorded(name="pd", scenario=FLAGSHIP, count=COUNT, steps=STEPS):
    """Return measurements along flights under random commands, as the baseline of that name needs them."""
    truth = is_oracle(name, scenario)
    simulator, random = Simulator(scenario, count), np.random.default_rng(0)
    simulator.reset(scenario.draw(1, count))
    measurements = [simulator.measurement(truth)]
    for _ in range(steps):
        simulator.step(random.uniform(-0.2, 0.2, (count, 4)))
        measurements.append(simulator.measurement(truth))
    return measurements


def one_of(measurement, index):
    """Return the measurement of one spacecraft."""
    parts = {name: array[index : index + 1] for name, array in vars(measurement).items() if name != "truth"}
    truth = measurement.truth and FaultEffect(*(part[index : index + 1] for part in measurement.truth))
    return type(measurement)(**parts, truth=truth)


def rows_of(one, other, mask):
    """Return the measurement with the rows of one where the mask is True, and those of another elsewhere."""
    both = [{**vars(item), **(item.truth._asdict() if item.truth else {})} for item in (one, other)]
    joined = {
        name: np.where(mask.reshape(-1, *(1,) * (array.ndim - 1)), array, both[1][name])
        for name, array in both[0].items()
        if name != "truth"
    }
    truth = one.truth and FaultEffect(*(joined.pop(name) for name in FaultEffect._fields))
    return type(one)(**joined, truth=truth)


# -------------------------------------------------------------------------------------------------------------- memory


def test_memory_resets_and_restores_by_mask():
    memory = Memory(3)
    memory.add("level", (2,), initial=4.0)
    memory.add("fresh", (1,), initial=True)
    memory["level"] = np.arange(6.0).reshape(3, 2)
    memory["fresh"] = np.zeros((3, 1), dtype=bool)
    kept = memory.copy()
    memory.reset(np.array([True, False, True]))
    np.testing.assert_array_equal(memory["level"], [[4.0, 4.0], [2.0, 3.0], [4.0, 4.0]])
    np.testing.assert_array_equal(memory["fresh"][:, 0], [True, False, True])
    memory.restore(kept, np.array([True, False, False]))
    np.testing.assert_array_equal(memory["level"], [[0.0, 1.0], [2.0, 3.0], [4.0, 4.0]])
    memory.reset(np.ones(3, dtype=bool))
    np.testing.assert_array_equal(memory["level"], 4.0)  # the initial values were not touched
    with pytest.raises(ValueError, match="memory name must be new, got 'level'"):
        memory.add("level", (1,))


@pytest.mark.parametrize(
    ("name", "scenario"),
    [(name, scenario) for scenario in (FLAGSHIP, TRACKING) for name in fitting(scenario)],
    ids=lambda value: getattr(value, "name", value),
)
def test_a_batch_equals_single_baselines(name, scenario):
    together = baselines.make(name, scenario, COUNT)
    alone = [baselines.make(name, scenario) for _ in range(COUNT)]
    for measurement in recorded(name, scenario):
        command = together.act(measurement)
        for row, single in enumerate(alone):
            np.testing.assert_allclose(command[row : row + 1], single.act(one_of(measurement, row)), atol=1e-13)


@pytest.mark.parametrize("name", NAMES)
def test_reset_by_mask(name):
    measurements = recorded(name)
    touched, untouched, fresh = (baselines.make(name, FLAGSHIP, COUNT) for _ in range(3))
    for measurement in measurements[:20]:
        touched.act(measurement)
        untouched.act(measurement)
    mask = np.array([True, False, False, True, False])
    touched.reset(mask)
    for measurement in measurements[20:]:
        command = touched.act(measurement)
        np.testing.assert_array_equal(command[~mask], untouched.act(measurement)[~mask])
        np.testing.assert_array_equal(command[mask], fresh.act(measurement)[mask])
    touched.reset()
    fresh.reset()
    np.testing.assert_array_equal(touched.act(measurements[0]), fresh.act(measurements[0]))


@pytest.mark.parametrize("name", ["pd", "pd_dob", "nftsm_observer", "predefined_time_observer"])
def test_a_reset_matters(name):
    """Without it, the memory of these baselines would change what they do; the papers' laws saturate here anyway."""
    measurements = recorded(name)
    old, new = (baselines.make(name, FLAGSHIP, COUNT) for _ in range(2))
    for measurement in measurements[:20]:
        old.act(measurement)
    assert (old.act(measurements[20]) != new.act(measurements[20])).any(axis=1).all()


@pytest.mark.parametrize("name", NAMES)
def test_act_only_moves_on_the_chosen_spacecraft(name):
    measurements = recorded(name)
    partly, wholly, waiting = (baselines.make(name, FLAGSHIP, COUNT) for _ in range(3))
    mask = np.array([True, False, True, False, False])
    for measurement in measurements[:10]:
        for baseline in (partly, wholly, waiting):
            baseline.act(measurement)
    np.testing.assert_array_equal(partly.act_only(measurements[10], mask)[mask], wholly.act(measurements[10])[mask])
    for now, later in ((10, 11), (11, 12)):
        # The others are one measurement behind.
        seen = rows_of(measurements[later], measurements[now], mask)
        after = partly.act(seen)
        np.testing.assert_array_equal(after[mask], wholly.act(measurements[later])[mask])
        np.testing.assert_array_equal(after[~mask], waiting.act(measurements[now])[~mask])


@pytest.mark.parametrize("mask", [np.ones(3, dtype=bool), np.ones(COUNT, dtype=int), True])
def test_bad_mask(mask):
    with pytest.raises(ValueError, match=r"mask must be a boolean array of shape \(5,\)"):
        baselines.make("pd", FLAGSHIP, COUNT).reset(mask)


@pytest.mark.parametrize("name", NAMES)
def test_acting_changes_neither_the_measurement_nor_past_commands(name):
    baseline = baselines.make(name, FLAGSHIP, COUNT)
    past = []
    for measurement in recorded(name, steps=5):
        before = copy.deepcopy(vars(measurement))
        command = baseline.act(measurement)
        past.append((command, command.copy()))
        for key, array in before.items():
            np.testing.assert_equal(getattr(measurement, key), array)
    for command, copied in past:
        np.testing.assert_array_equal(command, copied)


# -------------------------------------------------------------------------------------------------------------- policy


def test_as_action():
    limits = np.array([0.1, 0.2, 0.4])
    action = as_action(np.array([[0.05, -0.1, 0.4], [0.2, -0.5, 0.0]]), limits)
    np.testing.assert_array_equal(action, [[0.5, -0.5, 1.0], [1.0, -1.0, 0.0]])


SHORT = {"duration": 6.0}


def single_trajectory(name, seed, steps):
    """Return observations of one spacecraft whose baseline is reset at every start and acts on the measurement."""
    env = SpacecraftFTCEnv(**SHORT)
    baseline, truth = baselines.make(name, env.scenario), is_oracle(name, env.scenario)
    limits = env.scenario.spacecraft.wheels.torque_limits
    observations = [env.reset(seed=seed)[0]]
    for _ in range(steps):
        observation, _, terminated, truncated, _ = env.step(baseline.act(env.measurement(truth))[0] / limits)
        if terminated or truncated:
            observation, _ = env.reset()
            baseline.reset()
        observations.append(observation)
    return np.array(observations)


def build(kind):
    """Return an environment of three spacecraft, or of one, that resets by itself."""
    if kind == "single":
        return gym.make("SpacecraftFTC-v0", **SHORT)
    if kind == "native":
        return gym.make_vec("SpacecraftFTC-v0", num_envs=3, autoreset_mode="SameStep", **SHORT)
    if kind == "wrapped native":
        env = gym.make_vec("SpacecraftFTC-v0", num_envs=3, autoreset_mode="SameStep", **SHORT)
        return gym.wrappers.vector.RecordEpisodeStatistics(env)
    if kind == "SB3VecEnv":
        return SB3VecEnv(SpacecraftFTCVectorEnv(3, autoreset_mode="SameStep", **SHORT))
    vector = DummyVecEnv([lambda: Monitor(SpacecraftFTCEnv(**SHORT))] * 3)
    return VecNormalize(vector, norm_obs=False, norm_reward=False) if kind == "VecNormalize" else vector


@pytest.mark.parametrize(
    ("kind", "name"),
    [
        *(("native", name) for name in NAMES),
        *itertools.product(("single", "wrapped native", "SB3VecEnv", "DummyVecEnv", "VecNormalize"), SEVERAL),
    ],
)
def test_as_policy_flies_as_the_baseline_does(kind, name):
    env, steps = build(kind), 70
    count = 1 if kind == "single" else 3
    expected = np.stack([single_trajectory(name, 5 + row, steps) for row in range(count)], axis=1)
    policy = baselines.make(name, FLAGSHIP.replace(**SHORT), count).as_policy(env)
    stable_baselines = hasattr(env, "step_async")
    if stable_baselines:
        env.seed(5)
    observation = env.reset() if stable_baselines else env.reset(seed=5)[0]
    for step in range(steps):
        np.testing.assert_allclose(np.atleast_2d(observation), expected[step], rtol=1e-5, atol=1e-6)
        action, state = policy.predict(observation)
        assert state is None and action.shape == (*observation.shape[:-1], 4)
        if stable_baselines:
            observation, *_ = env.step(action)
        else:
            observation, _, terminated, truncated, _ = env.step(action)
            if kind == "single" and (terminated or truncated):
                observation, _ = env.reset()


def test_next_step_mode_forgets_the_old_episode():
    env = SpacecraftFTCVectorEnv(2, duration=1.0, tumble_rate=None)
    policy = baselines.make("pd_dob", env.scenario, 2).as_policy(env)
    fresh = baselines.make("pd_dob", env.scenario, 2)
    observation, _ = env.reset(seed=0)
    for _ in range(11):
        observation, *_ = env.step(policy.predict(observation)[0])
    assert (env.measurement().time == 0.0).all()
    expected = as_action(fresh.act(env.measurement()), env.scenario.spacecraft.wheels.torque_limits)
    np.testing.assert_array_equal(policy.predict(observation)[0], expected)


def test_episode_start_decides_who_is_reset():
    env = SpacecraftFTCVectorEnv(2, autoreset_mode="Disabled")
    observation, _ = env.reset(seed=0)
    policy = baselines.make("pd_dob", env.scenario, 2).as_policy(env)
    fresh = baselines.make("pd_dob", env.scenario, 2)
    for _ in range(10):
        observation, *_ = env.step(policy.predict(observation)[0])
    kept = as_action(policy.baseline.act_only(env.measurement(), np.zeros(2, bool)), policy._torque_limits)
    expected = as_action(fresh.act(env.measurement()), policy._torque_limits)
    action, _ = policy.predict(observation, episode_start=np.array([True, False]))
    np.testing.assert_array_equal(action[0], expected[0])
    np.testing.assert_array_equal(action[1], kept[1])
    assert (action[0] != kept[0]).any()


@pytest.mark.parametrize("kind", ["SB3VecEnv", "DummyVecEnv", "VecNormalize"])
def test_evaluate_policy_of_stable_baselines(kind):
    env = build(kind)
    env.seed(5)
    policy = baselines.make("pd", FLAGSHIP.replace(**SHORT), 3).as_policy(env)
    returns, lengths = evaluate_policy(policy, env, n_eval_episodes=3, return_episode_rewards=True)
    assert lengths == [60, 60, 60]
    single = SpacecraftFTCEnv(**SHORT)
    for row in range(3):
        single.reset(seed=5 + row)
        baseline, total = baselines.make("pd", single.scenario), 0.0
        for _ in range(60):
            total += single.step(baseline.act(single.measurement())[0] / 0.2)[1]
        assert returns[row] == pytest.approx(total, rel=1e-5, abs=1e-4)


@pytest.mark.parametrize("env", [gym.make("CartPole-v1"), 3, None])
def test_an_environment_without_measurement_is_refused(env):
    with pytest.raises(ValueError, match=r"env must have a measurement\(\) method"):
        measurement_of(env)
