"""Late commands: the command in force at each moment, and independence of successive episodes."""

import copy
import dataclasses
import pickle

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.vector import SyncVectorEnv
from helpers.late_commands import PERIOD, commands, start, task
from helpers.snapshots import history, snapshot

import ftac_gym  # noqa: F401  registers the environments
from ftac_gym import scenarios
from ftac_gym.dynamics import Simulator
from ftac_gym.envs import SpacecraftFTCEnv, SpacecraftFTCVectorEnv
from ftac_gym.faults import Bias, CommandDelay, FaultDistribution, FaultSchedule, LossOfEffectiveness, Outage
from ftac_gym.task.episodes import Episodes
from ftac_gym.utils.serialization import to_plain


def momenta(simulator, orders):
    """Wheel momenta (T + 1, N, m)."""
    rows = [simulator.state.wheel_momentum.copy()]
    for order in orders:
        simulator.step(order)
        rows.append(simulator.state.wheel_momentum.copy())
    return np.array(rows)


def impulses(simulator, orders):
    """Mean torque of each wheel in each period (T, N, m) [N m]."""
    return -np.diff(momenta(simulator, orders), axis=0) / PERIOD


def late(orders, delay):
    return np.concatenate([np.zeros((delay, *orders.shape[1:])), orders[: len(orders) - delay]])


# ------------------------------------------------------------------------------------------------------- which command


@pytest.mark.parametrize("delay", [1, 2, 3, 4, 5])
def test_the_first_commands_after_a_reset_are_zero(delay):
    simulator, orders = start(task(CommandDelay(wheel=1, periods=delay)), 3), commands(20, 3)
    given = impulses(simulator, orders)
    expected = orders.copy()
    expected[:, :, 1] = late(orders, delay)[:, :, 1]
    np.testing.assert_allclose(given, expected, rtol=0.0, atol=1e-13)
    assert np.all(given[:delay, :, 1] == 0.0)


def test_a_craft_with_late_wheels_flies_like_one_that_is_commanded_late():
    scenario, orders = task(*(CommandDelay(wheel=wheel, periods=3) for wheel in range(4))), commands(100, 2)
    delayed, punctual = start(scenario, 2), start(task(), 2)
    for order, before in zip(orders, late(orders, 3), strict=True):
        delayed.step(order)
        punctual.step(before)
        for name in ("attitude", "rate", "wheel_momentum", "wheel_torque"):
            one, other = getattr(delayed.state, name), getattr(punctual.state, name)
            np.testing.assert_allclose(one, other, rtol=0.0, atol=1e-12)
        np.testing.assert_array_equal(delayed.measurement().last_command, order)  # it reports what it was told


def test_a_delay_begins_and_ends_with_the_fault():
    fault = CommandDelay(wheel=0, onset=1.0, recovery=2.0, periods=4)
    orders = commands(40)
    given, old = impulses(start(task(fault)), orders)[:, 0, 0], late(orders, 4)[:, 0, 0]
    at_work = np.arange(40) // 10 == 1
    np.testing.assert_allclose(given, np.where(at_work, old, orders[:, 0, 0]), rtol=0.0, atol=1e-13)


def test_a_delay_may_begin_within_a_control_period():
    orders = commands(12)
    given = impulses(start(task(CommandDelay(wheel=0, onset=1.04, periods=2))), orders)[:, 0, 0]
    now, old = orders[:, 0, 0], late(orders, 2)[:, 0, 0]
    assert given[9] == pytest.approx(now[9], abs=1e-13)
    assert given[10] == pytest.approx(0.4 * now[10] + 0.6 * old[10], abs=1e-13)
    assert given[11] == pytest.approx(old[11], abs=1e-13)


def test_other_faults_of_the_wheel_work_on_the_late_command():
    faults = (
        CommandDelay(wheel=0, periods=2),
        LossOfEffectiveness(wheel=0, onset=0.5, effectiveness=0.5),
        Bias(wheel=0, onset=1.0, constant=0.03),
        CommandDelay(wheel=0, onset=1.5, periods=5),
        Outage(wheel=0, onset=2.0),
    )
    orders = commands(25)
    given = impulses(start(task(*faults)), orders)[:, 0, 0]
    two, five = late(orders, 2)[:, 0, 0], late(orders, 5)[:, 0, 0]
    expected = [two[:5], 0.5 * two[5:10], 0.5 * two[10:15] + 0.03, 0.5 * five[15:20] + 0.03, np.full(5, 0.03)]
    np.testing.assert_allclose(given, np.concatenate(expected), rtol=0.0, atol=1e-13)


def test_what_comes_late_is_within_the_limits_too():
    simulator = start(task(CommandDelay(wheel=0, periods=1)))
    given = impulses(simulator, [np.full((1, 4), 7.0), np.zeros((1, 4)), np.zeros((1, 4))])
    np.testing.assert_allclose(given[:, 0, 0], [0.0, 0.2, 0.0], atol=1e-13)


# -------------------------------------------------------------------------------------------------------------- resets


@pytest.fixture
def mixed():
    """A scenario whose episodes have a delay or another fault."""
    kinds = (CommandDelay(onset=(0.0, 0.5), periods=(3, 5)), Bias(constant=0.05))
    return task(faults=FaultDistribution(kinds, fault_counts=(0.2, 0.4, 0.4)))


def of_each_sort(scenario):
    """Return episodes with a delay, and such without."""
    episodes = scenario.draw(0, 200)
    delayed = (episodes.faults["delay"] > 0).any(axis=(1, 2))
    return episodes[delayed], episodes[~delayed]


def test_a_reset_forgets_the_commands_of_that_craft_alone():
    scenario, orders = task(CommandDelay(wheel=1, periods=5)), commands(40, 3)
    undisturbed = history(start(scenario, 3), orders)
    simulator, mask = start(scenario, 3), np.array([False, True, False])
    history(simulator, orders[:20])
    simulator.reset(scenario.draw(9, 1), mask)
    after = history(simulator, orders[20:])
    np.testing.assert_array_equal(after[1:, ~mask], undisturbed[21:, ~mask])
    alone = start(scenario)
    alone.reset(scenario.draw(9, 1))
    np.testing.assert_array_equal(after[:, 1:2], history(alone, orders[20:, 1:2]))


def test_a_second_reset_of_all_forgets_everything():
    scenario, orders = task(CommandDelay(wheel=1, periods=5)), commands(15, 3)
    simulator = start(scenario, 3)
    first = history(simulator, orders)
    simulator.reset(scenario.draw(0, 3))
    np.testing.assert_array_equal(history(simulator, orders), first)


@pytest.mark.parametrize("first", ["late", "punctual"])
def test_episodes_with_and_without_delays_take_turns(mixed, first):
    late_ones, punctual = of_each_sort(mixed)
    pools = {"late": iter(late_ones), "punctual": iter(punctual)}
    random, simulator = np.random.default_rng(0), Simulator(mixed, 4)
    current = [next(pools[first]) for _ in range(4)]
    joined = {name: np.concatenate([one.arrays()[name] for one in current]) for name in current[0].arrays()}
    simulator.reset(Episodes(mixed.to_json(), **joined))
    solo = []
    for episode in current:
        solo.append(Simulator(mixed, 1))
        solo[-1].reset(episode)
    for step, order in enumerate(commands(120, 4)):
        simulator.step(order)
        for craft in range(4):
            solo[craft].step(order[craft : craft + 1])
        if step % 7 == 6:
            craft = random.integers(4)
            episode = next(pools["late" if (step // 7) % 2 else "punctual"])
            simulator.reset(episode, np.arange(4) == craft)
            solo[craft] = Simulator(mixed, 1)
            solo[craft].reset(episode)
        np.testing.assert_array_equal(snapshot(simulator), np.concatenate([snapshot(item) for item in solo]))


def test_threads_do_not_matter():
    scenario = task(faults=FaultDistribution((CommandDelay(onset=(0.0, 0.5)), Bias(constant=0.05))))
    episodes, orders = scenario.draw(0, 1100), commands(15, 1100)
    rows = []
    for threads in (1, 2):
        simulator = Simulator(scenario, 1100, threads)
        simulator.reset(episodes)
        rows.append(history(simulator, orders)[-1])
    np.testing.assert_array_equal(*rows)


@pytest.mark.parametrize("mode", ["NextStep", "SameStep"])
def test_no_command_reaches_the_next_episode_of_an_environment(mode):
    """The vector environment, whose spacecraft are reset one by one, equals single environments."""
    changes = {"faults": FaultDistribution((CommandDelay(onset=(0.0, 0.4)), Bias(constant=0.05))), "duration": 1.2}
    changes |= {"tumble_rate": 0.016, "observation": "oracle"}
    native = SpacecraftFTCVectorEnv(4, autoreset_mode=mode, **changes)
    reference = SyncVectorEnv([lambda: SpacecraftFTCEnv(**changes)] * 4, autoreset_mode=mode)
    np.testing.assert_array_equal(native.reset(seed=3)[0], reference.reset(seed=3)[0])
    random, ends, apart = np.random.default_rng(0), np.zeros(4, dtype=int), False
    for _ in range(80):
        actions = random.uniform(-1.0, 1.0, (4, 4))
        result, expected = native.step(actions), reference.step(actions)
        for one, other in zip(result[:4], expected[:4], strict=True):
            np.testing.assert_array_equal(one, other)
        done = result[2] | result[3]
        ends, apart = ends + done, apart or len(set(done)) == 2
    assert ends.min() >= 5 and apart


# -------------------------------------------------------------------------------------------------------------- copies


@pytest.mark.parametrize(
    "clone", [copy.deepcopy, lambda item: pickle.loads(pickle.dumps(item))], ids=["copy", "pickle"]
)
@pytest.mark.parametrize("kind", ["simulator", "single", "vector"])
def test_a_copy_in_the_middle_of_an_episode_continues_identically(clone, kind):
    faults = FaultSchedule((CommandDelay(wheel=0, periods=5), CommandDelay(wheel=2, onset=1.0, periods=3)))
    if kind == "simulator":
        original = start(task(*faults.faults), 3)
        orders = commands(30, 3)
        step = lambda item, order: (item.step(order), snapshot(item))[1]  # noqa: E731
    else:
        arguments = {"faults": to_plain(faults), "duration": 2.0, "observation": "oracle"}
        if kind == "single":
            original, orders = gym.make("SpacecraftFTC-v0", **arguments), commands(20)[:, 0] / 0.2
        else:
            original = gym.make_vec("SpacecraftFTC-v0", num_envs=3, autoreset_mode="SameStep", **arguments)
            orders = commands(40, 3) / 0.2
        original.reset(seed=5)
        step = lambda item, order: item.step(order)[:4]  # noqa: E731
    for order in orders[:9]:
        step(original, order)
    twin = clone(original)
    for order in orders[9:]:
        expected = [np.copy(part) for part in step(original, order)]
        for one, other in zip(step(twin, order), expected, strict=True):
            np.testing.assert_array_equal(one, other)


def test_the_copy_remembers_late_commands():
    """Without the memory of commands a copy would be another spacecraft: the test above can fail."""
    simulator = start(task(CommandDelay(wheel=0, periods=5)))
    for order in commands(9):
        simulator.step(order)
    twin, forgetful = copy.deepcopy(simulator), start(task(CommandDelay(wheel=0, periods=5)))
    for name in ("attitude", "rate", "wheel_momentum"):
        getattr(forgetful.state, name)[:] = getattr(simulator.state, name)
    for item in (twin, forgetful):
        item.step(np.zeros((1, 4)))
    assert twin.state.wheel_momentum[0, 0] != forgetful.state.wheel_momentum[0, 0]


def test_the_flagship_with_late_wheels_can_be_flown():
    faults = FaultSchedule(tuple(CommandDelay(wheel=wheel) for wheel in range(4)))
    scenario = dataclasses.replace(scenarios.get("flagship"), faults=faults)
    assert set(np.unique(scenario.draw(0, 50).faults["delay"])) == {1, 2, 3, 4, 5}
    history(start(scenario, 5), commands(20, 5))
