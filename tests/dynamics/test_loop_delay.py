"""The loop delay: when a command takes effect, what is known of it on board, and its sum with late wheels."""

import copy
import dataclasses

import numpy as np
import pytest
from helpers.late_commands import INERTIA, PERIOD, STEP, commands, start, task
from hypothesis import given, settings
from hypothesis import strategies as st

from ftac_gym import baselines, scenarios
from ftac_gym.dynamics import Simulator
from ftac_gym.envs import SpacecraftFTCEnv, SpacecraftFTCVectorEnv
from ftac_gym.evaluation import rollout
from ftac_gym.faults import CommandDelay, Outage
from ftac_gym.task import Episodes, InitialState, Scenario

SUBSTEPS = 5
STATE = ("attitude", "rate", "wheel_momentum", "wheel_torque")


def in_effect(orders, steps):
    """Mean over each period of the command that is ``steps`` physics steps old, by hand (T, N, m)."""
    fine = np.repeat(orders, SUBSTEPS, axis=0)
    late = np.concatenate([np.zeros((steps, *orders.shape[1:])), fine])[: len(fine)]
    return late.reshape(len(orders), SUBSTEPS, *orders.shape[1:]).mean(axis=1)


def impulses(simulator, orders):
    """Mean torque of each wheel in each period, and what the measurement calls the command in effect, (T, N, m)."""
    before, torques, known = simulator.state.wheel_momentum.copy(), [], []
    for order in orders:
        simulator.step(order)
        torques.append((before - simulator.state.wheel_momentum) / PERIOD)
        known.append(simulator.measurement().command_in_effect)
        before = simulator.state.wheel_momentum.copy()
    return np.array(torques), np.array(known)


def assert_same_state(one, other, tolerance=0.0):
    for name in STATE:
        np.testing.assert_allclose(getattr(one.state, name), getattr(other.state, name), rtol=0.0, atol=tolerance)


# ------------------------------------------------------------------------------------------------------- which command


@given(st.integers(0, 23), st.integers(0, 100))
@settings(max_examples=30)
def test_a_command_takes_effect_after_the_delay_and_the_measurement_says_so(steps, seed):
    orders = commands(12, 2, seed)
    torques, known = impulses(start(task(loop_delay=steps * STEP), 2, seed), orders)
    np.testing.assert_allclose(torques, in_effect(orders, steps), rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(known, torques, rtol=0.0, atol=1e-12)


def test_the_last_command_is_the_one_given_last():
    simulator = start(task(loop_delay=0.26))
    for order in commands(6):
        simulator.step(order)
        np.testing.assert_array_equal(simulator.measurement().last_command, order)


@pytest.mark.parametrize("periods", [1, 3])
def test_a_delay_of_whole_periods_is_a_shift_of_the_commands_to_the_bit(periods):
    orders = commands(60, 3)
    late = np.concatenate([np.zeros((periods, 3, 4)), orders[:-periods]])
    delayed, punctual = start(task(loop_delay=periods * PERIOD), 3), start(task(), 3)
    for order, before in zip(orders, late, strict=True):
        delayed.step(order)
        punctual.step(before)
        assert_same_state(delayed, punctual)


@pytest.mark.parametrize("steps", [2, 8])
def test_a_part_of_a_period_is_a_loop_that_runs_at_the_physics_step(steps):
    orders = commands(40, 2)
    delayed = start(task(loop_delay=steps * STEP), 2)
    fast = start(task(control_period=STEP), 2)
    fine = np.concatenate([np.zeros((steps, 2, 4)), np.repeat(orders, SUBSTEPS, axis=0)])
    for period, order in enumerate(orders):
        delayed.step(order)
        for row in fine[period * SUBSTEPS : (period + 1) * SUBSTEPS]:
            fast.step(row)
        assert_same_state(delayed, fast, 1e-12)


def test_late_wheels_come_on_top():
    orders = commands(20)
    torques, known = impulses(start(task(CommandDelay(wheel=1, periods=2), loop_delay=0.14)), orders)
    np.testing.assert_allclose(torques[:, :, 1], in_effect(orders, 7 + 10)[:, :, 1], rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(known, in_effect(orders, 7), rtol=0.0, atol=1e-12)


def test_faults_switch_at_their_own_time_whatever_the_delay():
    orders = np.full((40, 1, 4), 0.1)
    for delay in (0.0, 0.1, 0.36):
        torques, _ = impulses(start(task(Outage(wheel=2, onset=2.04), loop_delay=delay)), orders)
        np.testing.assert_allclose(torques[19:22, 0, 2], [0.1, 0.04, 0.0], rtol=0.0, atol=1e-12)


def test_momentum_is_conserved_under_any_delay():
    simulator = start(task(loop_delay=0.14), 4)
    axes = simulator.scenario.spacecraft.wheels.axis_matrix

    def momentum():
        state = simulator.state
        body = state.rate @ np.array(INERTIA) + state.wheel_momentum @ axes.T
        w, v = state.attitude[:, :1], state.attitude[:, 1:]
        return body + 2.0 * np.cross(v, np.cross(v, body) + w * body)

    before = momentum()
    for order in commands(100, 4):
        simulator.step(order)
    np.testing.assert_allclose(momentum(), before, rtol=0.0, atol=1e-8)


# -------------------------------------------------------------------------------------------------------- extra delay


def test_extra_delay_is_drawn_in_whole_periods_with_equal_shares():
    drawn = task(extra_delay=(1, 4)).draw(5, 4000).extra_delay
    values, counts = np.unique(drawn, return_counts=True)
    assert values.tolist() == [1, 2, 3, 4]
    np.testing.assert_allclose(counts / 4000, 0.25, atol=0.03)
    assert task(extra_delay=3).draw(0, 5).extra_delay.tolist() == [3] * 5
    assert not task().draw(0, 5).extra_delay.any()


def test_extra_delay_acts_like_nominal_delay_but_nobody_is_told():
    orders = commands(40, 3)
    untold, told = start(task(loop_delay=0.1, extra_delay=2), 3), start(task(loop_delay=0.3), 3)
    punctual = start(task(loop_delay=0.1), 3)
    for order in orders:
        for simulator in (untold, told, punctual):
            simulator.step(order)
        assert_same_state(untold, told)
        known = untold.measurement().command_in_effect
        np.testing.assert_array_equal(known, punctual.measurement().command_in_effect)


def test_each_spacecraft_has_its_own_extra_delay():
    scenario, orders = task(loop_delay=0.04, extra_delay=(0, 4)), commands(30, 6)
    episodes = scenario.draw(1, 6)
    together = Simulator(scenario, 6)
    together.reset(episodes)
    torques, _ = impulses(together, orders)
    for row in range(6):
        steps = 2 + SUBSTEPS * int(episodes.extra_delay[row])
        np.testing.assert_allclose(torques[:, row], in_effect(orders, steps)[:, row], rtol=0.0, atol=1e-12)


def test_a_reset_by_mask_clears_the_commands_of_its_spacecraft_alone():
    scenario, orders = task(loop_delay=0.16, extra_delay=(0, 4)), commands(20, 3)
    simulator, untouched = start(scenario, 3), start(scenario, 3)
    for order in orders[:8]:
        simulator.step(order)
        untouched.step(order)
    simulator.reset(scenario.draw(9, 1), np.array([False, True, False]))
    fresh = Simulator(scenario, 1)
    fresh.reset(scenario.draw(9, 1))
    for order in orders[8:]:
        for one, row in ((simulator, order), (untouched, order), (fresh, order[1:2])):
            one.step(row)
        np.testing.assert_array_equal(simulator.state.rate[[0, 2]], untouched.state.rate[[0, 2]])
        np.testing.assert_array_equal(simulator.state.rate[1], fresh.state.rate[0])


def test_copies_threads_and_files_keep_the_commands_on_their_way(tmp_path):
    scenario, orders = task(loop_delay=0.14, extra_delay=(0, 3)), commands(12, 1100)
    one, two = start(scenario, 1100), Simulator(scenario, 1100, threads=2)
    path = tmp_path / "episodes.npz"
    scenario.draw(0, 1100).save(path)
    two.reset(Episodes.load(path))
    for order in orders[:6]:
        one.step(order)
        two.step(order)
    copied = copy.deepcopy(one)
    for order in orders[6:]:
        for simulator in (one, two, copied):
            simulator.step(order)
    assert_same_state(one, two)
    assert_same_state(one, copied)


def test_a_fault_set_in_flight_delays_the_commands_on_their_way_too():
    fault, orders = CommandDelay(wheel=1, periods=3), commands(20)
    late = task(fault, loop_delay=0.1)
    known, changed = start(late), start(task(loop_delay=0.1))
    assert known.faults.wheels.shape[0] == 1
    for order in orders[:6]:
        changed.step(order)
    changed.set_faults(known.faults.copy())
    torques, _ = impulses(changed, orders[6:])
    # From the fourth period on, every command that the wheel gets was stored after the fault came.
    np.testing.assert_allclose(torques[4:, 0, 1], orders[6:-4, 0, 1], rtol=0.0, atol=1e-12)


def test_the_vector_environment_equals_single_ones_under_delay():
    scenario = scenarios.get("flagship").replace(loop_delay=0.14, extra_delay=(0, 3))
    vector = SpacecraftFTCVectorEnv(num_envs=3, scenario=scenario)
    singles = [SpacecraftFTCEnv(scenario=scenario) for _ in range(3)]
    seen, _ = vector.reset(seed=4)
    first = [env.reset(seed=4 + number)[0] for number, env in enumerate(singles)]
    np.testing.assert_array_equal(seen, np.array(first))
    random = np.random.default_rng(0)
    for _ in range(30):
        action = random.uniform(-1.0, 1.0, (3, 4))
        seen, rewards, *_ = vector.step(action)
        for row, env in enumerate(singles):
            observation, reward, *_ = env.step(action[row])
            np.testing.assert_array_equal(seen[row], observation)
            assert rewards[row] == reward


def test_an_observer_that_uses_the_command_in_effect_sees_no_torque_on_a_healthy_spacecraft():
    quiet = scenarios.get("flagship").replace(
        faults=None, sensors=None, disturbance=None, inertia_uncertainty=None, loop_delay=0.1, duration=20.0,
        initial_state=InitialState(angle=(0.05, 0.1)),
    )  # fmt: skip
    largest = {}
    alone = {"filter": "none", "prediction": False, "isolation": "none"}
    for known in (True, False):
        baseline, simulator = baselines.make("pd_dob", quiet, 5, bandwidth=0.9, **alone), start(quiet, 5)
        largest[known] = 0.0
        for _ in range(60):
            measured = simulator.measurement()
            if not known:
                measured = dataclasses.replace(measured, command_in_effect=measured.last_command)
            simulator.step(baseline.act(measured))
            largest[known] = max(largest[known], float(np.abs(baseline.estimate.disturbance).max()))
    assert largest[True] < 0.02 < 0.1 < largest[False]


def test_papers_have_no_delay():
    for name in scenarios.names():
        if not name.startswith("flagship") and "easy" not in name and "flexible" not in name:
            assert scenarios.get(name).loop_delay == 0.0, name
    assert rollout("li_2023", "zero", count=1).metrics()  # It flies.


# ---------------------------------------------------------------------------------------------------------- bad input


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"loop_delay": 0.03}, "loop_delay must be a multiple of physics_step = 0.02 s, got 0.03"),
        ({"loop_delay": -0.1}, "loop_delay must not be negative, got -0.1"),
        ({"loop_delay": float("nan")}, "loop_delay must be"),
        ({"loop_delay": 20.0}, "loop_delay must be below the duration"),
        ({"extra_delay": 0.5}, "extra_delay must be whole numbers of control periods, got 0.5"),
        ({"extra_delay": (0, 21)}, "extra_delay must stay within"),
        ({"extra_delay": (3, 1)}, "extra_delay must have low <= high"),
        ({"extra_delay": -1}, "extra_delay must"),
    ],
)
def test_bad_delays_are_refused_by_name(changes, message):
    with pytest.raises(ValueError, match=f"(?s){message[:40]}") as caught:
        task(**changes)
    assert str(caught.value).startswith(message)


def test_episodes_from_elsewhere_with_a_wrong_delay_are_refused():
    scenario = task(loop_delay=0.1)
    episodes = scenario.draw(0, 2)
    episodes.extra_delay[1] = 1000
    with pytest.raises(ValueError, match=r"episodes.extra_delay must be within \[0, 20\]"):
        Simulator(scenario, 2).reset(episodes)


def test_json_keeps_the_delay_and_leaves_out_its_absence():
    delayed = task(loop_delay=0.14, extra_delay=(1, 4))
    assert Scenario.from_json(delayed.to_json()) == delayed
    assert "delay" not in task().to_json()
