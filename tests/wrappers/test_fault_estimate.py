"""Estimates of the faults as entries of the observation."""

import numpy as np
import pytest
from gymnasium.vector import AutoresetMode

from ftac_gym import baselines
from ftac_gym.baselines import observers
from ftac_gym.baselines.memory import Memory
from ftac_gym.envs import SpacecraftFTCEnv, SpacecraftFTCVectorEnv
from ftac_gym.envs.observation import BOUND
from ftac_gym.faults import Bias, CommandDelay, FaultSchedule, GyroBiasStep, LossOfEffectiveness
from ftac_gym.task.disturbances import Disturbance
from ftac_gym.wrappers import FaultEstimateObservation

COUNT, WHEELS, LIMIT = 4, 4, 0.2
SETTINGS = {"duration": 2.0, "tumble_rate": 0.016}  # s, rad/s
ONSET = 0.5  # s
# Of each kind something that the truth tells.
FAULTS = FaultSchedule((
    LossOfEffectiveness(wheel=0, onset=ONSET, effectiveness=0.4), Bias(wheel=1, onset=ONSET, constant=0.1),
    CommandDelay(wheel=2, onset=ONSET, periods=3.0), GyroBiasStep(onset=ONSET, size=1e-3),
))  # fmt: skip
MODES = [mode.value for mode in AutoresetMode]
LENGTHS = {"dob": 3, "asmo": 15, "asmo_printed": 15, "lo_corrected": 11}
makers = pytest.mark.parametrize("make", [SpacecraftFTCEnv, lambda **a: SpacecraftFTCVectorEnv(2, **a)])


def native(mode, **arguments):
    return SpacecraftFTCVectorEnv(COUNT, autoreset_mode=mode, **{**SETTINGS, **arguments})


def flown(env, twin, steps=70):
    """Step two vector environments alike and yield what each gives."""
    random = np.random.default_rng(0)
    yield env.reset(seed=3)[0], twin.reset(seed=3)[0], {}, {}
    for _ in range(steps):
        action = random.uniform(-1.0, 1.0, (COUNT, WHEELS))
        observation, _, terminated, truncated, infos = env.step(action)
        other, *_, other_infos = twin.step(action)
        yield observation, other, infos, other_infos
        done = terminated | truncated
        if env.metadata["autoreset_mode"] is AutoresetMode.DISABLED and done.any():
            yield *(item.reset(options={"reset_mask": done})[0] for item in (env, twin)), {}, {}


@makers
@pytest.mark.parametrize("source", [None, "none"])
def test_nothing(make, source):
    plain, env = make(), FaultEstimateObservation(make(), source)
    assert env.observation_space == plain.observation_space
    np.testing.assert_array_equal(env.reset(seed=1)[0], plain.reset(seed=1)[0])
    action = np.full(env.action_space.shape, 0.3)
    np.testing.assert_array_equal(env.step(action)[0], plain.step(action)[0])
    assert env.information == "attitude"


@pytest.mark.parametrize("mode", MODES)
def test_the_truth_is_what_the_oracle_tier_tells(mode):
    told = FaultEstimateObservation(native(mode, faults=FAULTS), "truth")
    oracle = native(mode, observation="oracle", faults=FAULTS)
    assert told.information == "oracle"
    size = told.single_observation_space.shape[0]
    faults = slice(size - 18, None)
    seen, finals = [], 0
    for observation, other, infos, other_infos in flown(told, oracle):
        np.testing.assert_array_equal(observation[:, faults], other[:, -18:])
        seen.append(observation[:, faults])
        for spacecraft in np.flatnonzero(infos.get("_final_obs", [])):
            last = infos["final_obs"][spacecraft]
            np.testing.assert_array_equal(last[faults], other_infos["final_obs"][spacecraft][-18:])
            # Of the episode that has ended, not of the next.
            assert (last[faults][[5, 10]] > 0.0).all() == (infos["final_info"]["time"][spacecraft] >= ONSET)
            assert told.single_observation_space.contains(last)
            finals += 1
    assert (np.ptp(np.concatenate(seen), axis=0)[[0, 5, 10, 12, 13, 14]] > 0.0).all()
    assert finals >= 8 or mode != "SameStep"
    bounds = told.single_observation_space.high[faults]
    np.testing.assert_array_equal(bounds, oracle.single_observation_space.high[-18:])


@pytest.mark.parametrize("source", [*LENGTHS, "tachometer"])
def test_an_observer_has_the_inputs_of_that_in_a_baseline(source):
    env = FaultEstimateObservation(SpacecraftFTCEnv(**SETTINGS), source)
    scenario, random = env.unwrapped.scenario, np.random.default_rng(1)
    size = env.unwrapped.observation_space.shape[0]
    for episode in range(3):
        memory, law = Memory(1), baselines.make("pd_dob", scenario, isolation="none", filter="none", prediction=False)
        observer = None if source == "dob" else observers.make(source, scenario, memory)
        observation, done = env.reset(seed=2 if episode == 0 else None)[0], False
        while True:
            measurement = env.unwrapped.measurement()
            if observer is None:
                law.act(measurement)
                estimate = law.estimate
            else:
                estimate = observer.update(measurement, measurement.command_in_effect, scenario.control_period)
            scaled = [
                (estimate.disturbance, LIMIT), (estimate.effectiveness, 1.0), (estimate.bias, LIMIT),
                (estimate.identifiable, 1.0), (estimate.vibration, LIMIT),
            ]  # fmt: skip
            parts = [np.clip(values[0] / scale, -BOUND, BOUND) for values, scale in scaled if values is not None]
            np.testing.assert_allclose(observation[size:], np.concatenate(parts), rtol=1e-6, atol=1e-9)
            assert env.observation_space.contains(observation)
            if done:
                break
            observation, _, terminated, truncated, _ = env.step(random.uniform(-1.0, 1.0, WHEELS))
            done = terminated or truncated


@pytest.mark.parametrize("source", LENGTHS)
def test_bounds(source):
    env = FaultEstimateObservation(SpacecraftFTCEnv(), source)
    size = env.unwrapped.observation_space.shape[0]
    assert env.observation_space.shape == (size + LENGTHS[source],)
    low, high = env.observation_space.low[size:], env.observation_space.high[size:]
    yes_or_no = slice(LENGTHS[source] - WHEELS, None) if LENGTHS[source] > 3 else slice(0, 0)
    assert (low[yes_or_no] == 0.0).all() and (high[yes_or_no] == 1.0).all()
    assert np.count_nonzero(high == BOUND) == np.count_nonzero(low == -BOUND) == len(high) - len(high[yes_or_no])


def test_observers_of_flexible_spacecraft():
    env = FaultEstimateObservation(SpacecraftFTCEnv("flexible"), "fafeo")
    plain = SpacecraftFTCEnv("flexible")
    observation, size = env.reset(seed=0)[0], plain.reset(seed=0)[0].shape[0]
    assert observation.shape == (size + 6,)  # torque of the faults, and of the modes
    for _ in range(5):
        observation, *_ = env.step(np.ones(env.action_space.shape))
    assert (observation[size:] != 0.0).all() and env.observation_space.contains(observation)


@pytest.mark.parametrize("source", ["asmo", "dob"])
def test_final_observations_and_partial_resets(source):
    """Same-step observations are those of disabled mode, and a partial reset leaves the others alone."""
    same, disabled = (FaultEstimateObservation(native(each), source) for each in ("SameStep", "Disabled"))
    same.reset(seed=3)
    before = disabled.reset(seed=3)[0]
    random, checked = np.random.default_rng(0), 0
    for _ in range(60):
        action = random.uniform(-1.0, 1.0, (COUNT, WHEELS))
        observation, _, terminated, truncated, infos = same.step(action)
        before, *_ = disabled.step(action)
        done = terminated | truncated
        for spacecraft in np.flatnonzero(done):
            np.testing.assert_array_equal(infos["final_obs"][spacecraft], before[spacecraft])
            checked += 1
        after = disabled.reset(options={"reset_mask": done})[0] if done.any() else before
        np.testing.assert_array_equal(after[~done], before[~done])
        np.testing.assert_array_equal(observation, after)
    assert checked >= 8


def test_gains_reach_the_observer():
    quick, slow = (FaultEstimateObservation(SpacecraftFTCEnv(), "dob", bandwidth=value) for value in (2.0, 0.02))
    for env in (quick, slow):
        env.reset(seed=0)
    action = np.ones(WHEELS)
    assert np.abs(quick.step(action)[0][-3:]).max() > 10.0 * np.abs(slow.step(action)[0][-3:]).max()


def test_entries_are_clipped():
    storm = Disturbance((30.0 * LIMIT, 0.0, 0.0))
    env = FaultEstimateObservation(SpacecraftFTCEnv(disturbance=storm, sensors=None), "dob", bandwidth=1.0)
    env.reset(seed=0)
    for _ in range(10):
        observation, *_ = env.step(np.zeros(WHEELS))
    assert observation[-3] == BOUND


def test_information():
    for source, tier in (("truth", "oracle"), ("tachometer", "telemetry"), ("asmo", "attitude"), ("dob", "attitude")):
        for env in (SpacecraftFTCEnv(), SpacecraftFTCVectorEnv(2)):
            assert FaultEstimateObservation(env, source).information == tier


@makers
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"source": "kalman"}, "source must be None or one of .*'truth', 'dob', 'asmo'.*, got 'kalman'"),
        ({"source": "oracle"}, "source must be None or one of .*, got 'oracle'"),
        ({"source": "dob", "bandwidth": -1.0}, "bandwidth must be positive, got -1.0"),
        ({"source": "truth", "bandwidth": 1.0}, "gains must not be given where source = 'truth'"),
        ({"bandwidth": 1.0}, "gains must not be given where source = 'none'"),
        ({"source": "fafeo"}, "appendages must be given"),
    ],
)
def test_bad_arguments(make, arguments, message):
    with pytest.raises(ValueError, match=message):
        FaultEstimateObservation(make(), **arguments)


@makers
@pytest.mark.parametrize("source", ["asmo", "dob"])
def test_an_unknown_gain_is_a_type_error(make, source):
    with pytest.raises(TypeError, match=f"got an unexpected keyword argument 'beauty'; gains of {source} are "):
        FaultEstimateObservation(make(), source=source, beauty=1.0)


def test_the_truth_of_a_vector_is_kept_only_when_asked_for():
    env = native("SameStep", duration=0.2)
    env.reset(seed=0)
    env.step(np.zeros((COUNT, WHEELS)))
    env.step(np.zeros((COUNT, WHEELS)))
    assert env.final_measurement.truth is None
