"""The flexible spacecraft: its draws, its differences from the flagship, and a controller that does its task."""

import gymnasium as gym
import numpy as np
import pytest

import ftac_gym  # noqa: F401  (registers the environments)
from ftac_gym import scenarios
from ftac_gym.dynamics import Simulator
from ftac_gym.task import Scenario

FLEXIBLE, FLAGSHIP = scenarios.get("flexible"), scenarios.get("flagship")
NOMINAL = FLEXIBLE.spacecraft.appendages
COUNT = 2000
EPISODES = FLEXIBLE.draw(0, COUNT)


def test_everything_else_is_the_flagship():
    flexible, flagship = FLEXIBLE.to_dict(), FLAGSHIP.to_dict()
    assert flexible.pop("name") == "flexible" and flagship.pop("name") == "flagship"
    assert set(flexible) - set(flagship) == {"appendage_uncertainty"}
    assert flexible.pop("appendage_uncertainty")["type"] == "AppendageUncertainty"
    assert flexible["spacecraft"].pop("appendages")["type"] == "FlexibleAppendages"
    assert flexible["reward"].pop("vibration") > 0.0
    assert flexible == flagship
    assert FLEXIBLE.misalignment is None
    assert Scenario.from_json(FLEXIBLE.to_json()) == FLEXIBLE


def test_the_panels_are_what_the_module_says():
    """They hold an eighth to a sixth of the inertia about each axis, and the first axis is that of torsion."""
    share = np.diag(NOMINAL.carried_inertia) / np.diag(FLEXIBLE.spacecraft.inertia_matrix)
    assert np.all(share > 0.09) and np.all(share < 0.19)
    assert NOMINAL.count == 4 and NOMINAL.damping_ratios == (0.005,) * 4
    main = np.abs(NOMINAL.coupling_matrix).argmax(axis=1)
    np.testing.assert_array_equal(main, [1, 2, 0, 1])
    # A vibration outlasts the episode's settling: time constants of more than half a minute.
    assert np.all(2.0 / NOMINAL.damping > 30.0)
    # The integrator follows the quickest of them at its step, on a free body, with the stiffest draw.
    fastest = 1.2 * NOMINAL.free_frequencies(FLEXIBLE.spacecraft.inertia_matrix)[-1]
    assert fastest * FLEXIBLE.physics_step < 0.2


def test_what_is_drawn():
    modes = EPISODES.modes
    frequency = np.sqrt(modes["stiffness"])
    factor = frequency / NOMINAL.frequencies
    ratio = modes["damping"] / (2.0 * frequency) / NOMINAL.damping_ratios
    scale = modes["coupling"] / NOMINAL.coupling_matrix
    for values, low, high in ((factor, 0.8, 1.2), (ratio, 0.5, 2.0), (scale, 0.8, 1.2)):
        span = high - low
        assert values.min() >= low - 1e-12 and values.max() <= high + 1e-12
        assert np.all(values.min(axis=0) < low + 0.01 * span) and np.all(values.max(axis=0) > high - 0.01 * span)
        np.testing.assert_allclose(values.mean(axis=0), 0.5 * (low + high), atol=0.02 * span)
    np.testing.assert_allclose(scale[:, :, 0], scale[:, :, 1], rtol=1e-12)
    columns = np.column_stack([factor, ratio, scale[:, :, 0]])
    assert np.abs(np.corrcoef(columns.T) - np.eye(12)).max() < 0.09
    assert not EPISODES.initial["modal_displacement"].any() and not EPISODES.initial["modal_rate"].any()


def test_episodes_differ_in_everything_that_is_drawn():
    for array in (
        EPISODES.modes["stiffness"],
        EPISODES.modes["damping"],
        EPISODES.modes["coupling"],
        EPISODES.initial["attitude"],
        EPISODES.inertia["constant"],
    ):
        assert len(np.unique(array.reshape(COUNT, -1), axis=0)) == COUNT
    assert FLEXIBLE.draw(1, 1).digest() != FLEXIBLE.draw(2, 1).digest()
    assert FLEXIBLE.draw(1, 1).digest() == FLEXIBLE.draw(1, 1).digest()


def test_most_episodes_can_be_done_and_they_are_the_flagships():
    assert EPISODES.feasible.mean() > 0.9
    np.testing.assert_array_equal(EPISODES.feasible, FLAGSHIP.draw(0, COUNT).feasible)


def test_the_same_commands_end_differently_on_every_spacecraft():
    """Of one start and one fault-free body, only the modes differ."""
    same = FLEXIBLE.replace(faults=None, sensors=None, disturbance=None, inertia_uncertainty=None)
    episodes = same.draw(0, 30)
    for name in episodes.initial.dtype.names:
        episodes.initial[name][:] = episodes.initial[name][0]
    simulator = Simulator(same, 30)
    simulator.reset(episodes)
    for step in range(300):
        simulator.step(np.full((30, 4), [0.1, -0.1, 0.05, 0.0]) * (1.0 if step < 20 else 0.0))
    ends = simulator.state.rate
    assert len(np.unique(ends, axis=0)) == 30 and ends.std(axis=0).max() > 1e-4
    # After the push the wheels rest, and the modes still ring.
    assert simulator.modal_energy.min() > 1e-6


def test_vibration_outlasts_what_a_rigid_spacecraft_would_do():
    """A flagship controller without a model of the modes leaves them vibrating."""
    from ftac_gym.evaluation import rollout

    quiet = FLEXIBLE.replace(faults=None)
    flown = rollout(quiet, "pd", quiet.draw(0, 8))
    late = flown.modal_energy[-200:].mean(axis=0)
    assert np.all(flown.modal_energy.max(axis=0) > 1e-5) and np.all(late > 0.0)
    assert np.all(np.isfinite(flown.reward)) and np.all(flown.attitude_error[-1] < 0.1)


@pytest.mark.parametrize("tier", ["attitude", "telemetry", "oracle"])
def test_defaults_of_the_id(tier):
    env = gym.make("SpacecraftFTCFlexible-v0", observation=tier)
    assert env.unwrapped.scenario == FLEXIBLE
    assert env.action_space.shape == (4,)
    observation, info = env.reset(seed=0)
    assert env.observation_space.contains(observation) and "feasible" in info
    assert env.spec.id == "SpacecraftFTCFlexible-v0"
    default = gym.make("SpacecraftFTCFlexible-v0")
    rigid = gym.make("SpacecraftFTC-v0")
    assert default.observation_space == rigid.observation_space
    vector = gym.make_vec("SpacecraftFTCFlexible-v0", num_envs=2, observation=tier)
    assert vector.unwrapped.scenario == FLEXIBLE and vector.single_observation_space == env.observation_space
