"""Authority of a residual under unmodelled torque: only the onset of a fault near the target gives it."""

import gymnasium as gym
import numpy as np
import pytest

from ftac_gym import baselines, scenarios
from ftac_gym.envs import SpacecraftFTCVectorEnv
from ftac_gym.faults import Bias, FaultSchedule
from ftac_gym.task.initial_state import InitialState
from ftac_gym.wrappers import ResidualPolicy

ONSET, PERIOD = 2.0, 0.1
FAULTY = FaultSchedule((Bias(wheel=0, onset=ONSET, constant=0.08),))
QUIET = scenarios.get("flagship").replace(
    faults=FAULTY, sensors=None, inertia_uncertainty=None, disturbance=None, initial_state=InitialState.fixed(),
    duration=4.0,
)  # fmt: skip
OPENING = {"base": "pd_dob", "authority": 0.5, "authority_angle": 100.0, "torque_threshold": 0.02}


def differences(scenario, **changes):
    """Return by how much (T,) a residual of one changes the commands, over the torque limit."""
    plain, wrapped = gym.make("SpacecraftFTC-v0", scenario=scenario), gym.make("SpacecraftFTC-v0", scenario=scenario)
    residual = ResidualPolicy(wrapped, **{**OPENING, **changes})
    policy = baselines.make("pd_dob", scenario).as_policy(plain)
    observation, _ = plain.reset(seed=0)
    residual.reset(seed=0)
    found, done = [], False
    while not done:
        base, _ = policy.predict(observation)
        authority = residual.transform.command(np.ones(4)) - residual.transform.base_action
        np.testing.assert_allclose(residual.transform.base_action[0], base, atol=1e-12)
        found.append(np.abs(authority).max())
        observation, _, _, done, _ = plain.step(base)
        residual.step(np.zeros(4))
    return np.array(found)


def test_authority_at_the_onset_of_a_fault_and_after():
    found = differences(QUIET)
    before, onset = found[: round(ONSET / PERIOD) + 1], found[round(ONSET / PERIOD) + 1]
    assert before.max() < 1e-4
    assert onset == pytest.approx(0.5, abs=1e-6)  # 0.08 N m is far above what opens it fully
    assert found[-5:].max() < 0.02


def test_without_it_nothing_opens():
    assert differences(QUIET, torque_threshold=None).max() < 1e-4


def test_noise_hardly_opens_it():
    """Noise looks like a fraction of the torque of a fault."""
    noisy = QUIET.replace(faults=None, sensors=scenarios.get("flagship").sensors)
    assert np.median(differences(noisy, torque_threshold=0.05)) < 0.05


def test_a_slew_opens_nothing():
    """With another inertia than the model's, every acceleration leaves an unmodelled torque."""
    slew = QUIET.replace(
        faults=None, initial_state=InitialState(angle=(1.0, 2.0)),
        inertia_uncertainty=scenarios.get("flagship").inertia_uncertainty,
    )  # fmt: skip
    assert differences(slew).max() < 0.5 * 2.1 / 100.0


@pytest.mark.parametrize("mode", ["NextStep", "SameStep", "Disabled"])
def test_a_vector_equals_single_environments(mode):
    """Through resets at different times."""
    scenario = scenarios.get("flagship_pointing").replace(duration=4.0, tumble_rate=4e-4)
    vector = ResidualPolicy(SpacecraftFTCVectorEnv(3, scenario=scenario, autoreset_mode=mode), **OPENING)
    singles = [ResidualPolicy(gym.make("SpacecraftFTC-v0", scenario=scenario), **OPENING) for _ in range(3)]
    rng = np.random.default_rng(0)
    observation, _ = vector.reset(seed=7)
    rows = [env.reset(seed=7 + spacecraft)[0] for spacecraft, env in enumerate(singles)]
    waiting, ends = np.zeros(3, dtype=bool), np.zeros(3, dtype=int)
    for _ in range(90):
        np.testing.assert_allclose(observation, rows, rtol=0, atol=1e-6)
        action = rng.uniform(-1.0, 1.0, (3, 4)).astype(np.float32)
        observation, _, terminated, truncated, _ = vector.step(action)
        done = terminated | truncated
        if mode == "Disabled" and done.any():
            observation, _ = vector.reset(options={"reset_mask": done})
        for spacecraft, env in enumerate(singles):
            if mode == "NextStep" and waiting[spacecraft]:
                rows[spacecraft] = env.reset()[0]
                continue
            rows[spacecraft], _, ended, cut, _ = env.step(action[spacecraft])
            if (ended or cut) and mode != "NextStep":
                rows[spacecraft] = env.reset()[0]
        waiting, ends = done, ends + done
    assert ends.min() >= 2


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"torque_threshold": 0.0}, "torque_threshold must be positive, got 0.0"),
        (
            {"authority_angle": 0.0},
            "authority_angle must be positive where an unmodelled torque opens .*, got 0.0",
        ),
    ],
)
def test_bad_values(changes, message):
    with pytest.raises(ValueError, match=message):
        ResidualPolicy(gym.make("SpacecraftFTC-v0"), **{**OPENING, **changes})
