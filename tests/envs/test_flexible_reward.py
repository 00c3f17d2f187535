"""The vibration term of the reward, and episodes of other spacecraft."""

import numpy as np
import pytest
from helpers.flexible_env import SHORT, shaken
from helpers.flexible_spacecraft import flexible_scenario, random_appendages

import ftac_gym  # noqa: F401  registers the environments
from ftac_gym import scenarios
from ftac_gym.dynamics import Simulator
from ftac_gym.envs import SpacecraftFTCEnv, SpacecraftFTCVectorEnv
from ftac_gym.envs.reward import TERMS, Reward
from ftac_gym.task.objective import RewardWeights

# ------------------------------------------------------------------------------------------------------------- reward


@pytest.mark.parametrize("weight", [0.0, 0.05, 0.2])
def test_the_vibration_term_is_a_share_that_grows_with_the_true_energy(weight):
    scenario = shaken(SHORT).replace(reward=RewardWeights(vibration=weight))
    env = SpacecraftFTCEnv(scenario=scenario)
    env.reset(seed=1)
    simulator = env.batch.simulator
    stiffness = simulator.episodes.modes["stiffness"][0]
    assert np.abs(stiffness / scenario.spacecraft.appendages.stiffness - 1.0).max() > 0.05  # not the nominal one
    for _ in range(30):
        _, reward, _, _, info = env.step(np.array([0.5, -0.5, 1.0, 0.2]))
        swing, eta = simulator.state.modal_rate[0], simulator.state.modal_displacement[0]
        energy = 0.5 * np.sum(swing**2 + stiffness * eta**2)
        assert energy > 0.0
        assert info["reward/vibration"] == pytest.approx(
            -weight * info["reward/pointing"] * energy / (1e-3 + energy), rel=1e-12
        )
        assert reward == pytest.approx(sum(info[f"reward/{term}"] for term in TERMS), rel=1e-12)


def test_weights_of_zero_leave_no_term():
    nothing = RewardWeights(*(0.0,) * 7)
    env = SpacecraftFTCVectorEnv(3, scenario=shaken(SHORT).replace(reward=nothing))
    env.reset(seed=0)
    for _ in range(5):
        _, rewards, _, _, infos = env.step(np.full((3, 4), 0.7))
        assert not rewards.any() and not infos["reward/vibration"].any()


def test_a_rigid_craft_has_no_term_whatever_the_weight():
    env = SpacecraftFTCEnv(scenario="flagship", reward=RewardWeights(vibration=0.2))
    env.reset(seed=0)
    assert env.step(np.full(4, 0.5))[4]["reward/vibration"] == 0.0


def test_other_weights_do_not_move_the_craft_or_other_terms():
    histories = []
    for weight in (0.0, 0.2):
        env = SpacecraftFTCEnv(scenario=shaken(SHORT).replace(reward=RewardWeights(vibration=weight)))
        env.reset(seed=1)
        infos = [env.step(np.full(4, 0.3))[4] for _ in range(20)]
        for info in infos:
            del info["reward/vibration"]
        histories.append([{name: np.asarray(value).tolist() for name, value in info.items()} for info in infos])
    assert histories[0] == histories[1]


def test_no_term_at_the_start_of_an_episode_after_autoreset():
    env = SpacecraftFTCVectorEnv(2, scenario=shaken(SHORT).replace(duration=1.0), autoreset_mode="NextStep")
    env.reset(seed=0)
    for _ in range(env.batch.horizon):
        _, _, _, truncated, _ = env.step(np.zeros((2, 4)))
    assert truncated.all()
    _, rewards, *_ = env.step(np.zeros((2, 4)))
    assert not rewards.any()
    _, _, _, _, infos = env.step(np.zeros((2, 4)))
    assert (infos["reward/vibration"] < 0.0).all()


def test_the_start_of_an_episode_is_not_rewarded():
    """Of two spacecraft one is stirred and at its start, the other in flight."""
    scenario = shaken(SHORT)
    simulator = Simulator(scenario, 2)
    simulator.reset(scenario.draw(0, 2))
    reward, both = Reward(simulator), np.arange(2)
    assert not reward.update(both)[0].any()
    simulator.step(np.zeros((2, 4)))
    simulator.reset(scenario.draw(1, 1), np.array([False, True]))
    terms = dict(zip(TERMS, reward.update(both)[0], strict=True))
    energy, weight = simulator.modal_energy[0], scenario.reward.vibration
    assert terms["vibration"][0] == pytest.approx(-weight * terms["pointing"][0] * energy / (1e-3 + energy))
    assert terms["vibration"][0] < 0.0 and terms["vibration"][1] == 0.0


# ------------------------------------------------------------------------------------------------------ other episodes


@pytest.mark.parametrize(("task", "source"), [("flagship", "flexible"), ("flexible", "flagship")])
@pytest.mark.parametrize("kind", ["simulator", "environment"])
def test_episodes_of_another_kind_of_craft_are_refused_at_the_first_reset(kind, task, source):
    """A ValueError that says why, and nothing is kept of them: the compiled plant does not check its arrays."""
    foreign, own = scenarios.get(source).draw(0, 1), scenarios.get(task).draw(0, 1)
    if kind == "simulator":
        simulator = Simulator(scenarios.get(task), 1)
        with pytest.raises(ValueError, match="episodes must"):
            simulator.reset(foreign)
        simulator.reset(own)
    else:
        env = SpacecraftFTCEnv(scenario=task)
        with pytest.raises(ValueError, match="episodes must"):
            env.reset(options={"episodes": foreign})
        env.reset(options={"episodes": own})
        simulator = env.batch.simulator
    simulator.step(np.zeros((1, 4)))
    assert np.isfinite(simulator.state.rate).all()


@pytest.mark.parametrize("count", [1, 3, 5])
def test_episodes_of_a_craft_with_other_modes_are_refused(count):
    scenario = flexible_scenario(random_appendages(4))
    with pytest.raises(ValueError, match="episodes must"):
        Simulator(scenario, 2).reset(flexible_scenario(random_appendages(count)).draw(0, 2))
