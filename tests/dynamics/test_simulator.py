"""The simulator: the history of a spacecraft depends on its episode and commands alone, and replays."""

import copy
import dataclasses
import pickle

import numba
import numpy as np
import pytest
from helpers.snapshots import history, snapshot

from ftac_gym import scenarios
from ftac_gym.dynamics import Simulator
from ftac_gym.spacecraft.wheel_array import WheelArray
from ftac_gym.task.episodes import Episodes
from ftac_gym.task.measurement import Measurement

FLAGSHIP = scenarios.get("flagship")
NAMES = scenarios.names()
MEASURED = [field.name for field in dataclasses.fields(Measurement) if field.name != "truth"]


def test_without_the_compiler_the_simulation_is_refused_in_a_line(monkeypatch):
    monkeypatch.setattr(numba.config, "DISABLE_JIT", 1)
    with pytest.raises(ValueError, match=r"NUMBA_DISABLE_JIT must be unset or 0: .*, got 1"):
        Simulator(FLAGSHIP, 1)


def commands(steps, craft, wheels=4):
    return np.random.default_rng(0).uniform(-0.25, 0.25, (steps, craft, wheels))


def start(scenario, episodes, threads=1):
    simulator = Simulator(scenario, len(episodes), threads)
    simulator.reset(episodes)
    return simulator


# ----------------------------------------------------------------------------------------------------- independence


@pytest.mark.parametrize("name", NAMES)
def test_a_craft_alone_does_what_it_does_among_a_hundred(name):
    scenario = scenarios.get(name)
    episodes, orders = scenario.draw(5, 100), commands(200, 100, scenario.spacecraft.wheels.count)
    together = history(start(scenario, episodes), orders)
    for k in (0, 17, 99):
        alone = history(start(scenario, episodes[k]), orders[:, k : k + 1])
        np.testing.assert_array_equal(alone[:, 0], together[:, k])
    backwards = history(start(scenario, episodes[::-1]), orders[:50, ::-1])
    np.testing.assert_array_equal(backwards[:, ::-1], together[:51])


def test_the_number_of_threads_does_not_matter():
    episodes, orders = FLAGSHIP.draw(0, 1536), commands(40, 1536)
    single = history(start(FLAGSHIP, episodes), orders)
    for threads in (2, 3, 8):
        np.testing.assert_array_equal(history(start(FLAGSHIP, episodes, threads), orders[:40]), single)


@pytest.mark.parametrize("name", NAMES)
def test_resetting_some_craft_leaves_the_others_alone(name):
    scenario = scenarios.get(name)
    first, second = scenario.draw(0, 6), scenario.draw(1, 2)
    orders = commands(60, 6, scenario.spacecraft.wheels.count)
    undisturbed = history(start(scenario, first), orders)
    simulator = start(scenario, first)
    history(simulator, orders[:30])
    mask = np.array([False, True, False, False, True, False])
    simulator.reset(second, mask)
    np.testing.assert_array_equal(snapshot(simulator)[~mask], undisturbed[30][~mask])
    later = history(simulator, orders[30:])
    np.testing.assert_array_equal(later[1:, ~mask], undisturbed[31:, ~mask])
    np.testing.assert_array_equal(later[:, mask], history(start(scenario, second), orders[30:, mask]))
    np.testing.assert_array_equal(simulator.time, np.where(mask, 30, 60) * scenario.control_period)


# ----------------------------------------------------------------------------------------------------------- replay


@pytest.mark.parametrize("name", NAMES)
def test_replay_of_saved_episodes_is_bit_for_bit(name, tmp_path):
    scenario = scenarios.get(name)
    episodes, orders = scenario.draw(2, 8), commands(200, 8, scenario.spacecraft.wheels.count)
    original = history(start(scenario, episodes), orders)
    episodes.save(tmp_path / "episodes.npz")
    loaded = Episodes.load(tmp_path / "episodes.npz")
    np.testing.assert_array_equal(history(start(scenario, loaded), orders), original)
    recorded = start(scenario, episodes)
    history(recorded, orders[:7])
    assert recorded.episodes.digest() == episodes.digest()
    np.testing.assert_array_equal(history(start(scenario, recorded.episodes[3]), orders[:, 3:4])[:, 0], original[:, 3])


def test_a_used_simulator_replays_like_a_new_one():
    episodes, orders = FLAGSHIP.draw(2, 8), commands(50, 8)
    simulator = start(FLAGSHIP, FLAGSHIP.draw(9, 8))
    history(simulator, orders)
    simulator.reset(episodes)
    np.testing.assert_array_equal(history(simulator, orders), history(start(FLAGSHIP, episodes), orders))


def test_drawn_episodes_are_not_touched():
    episodes = FLAGSHIP.draw(2, 8)
    digest = episodes.digest()
    simulator = start(FLAGSHIP, episodes)
    history(simulator, commands(20, 8))
    simulator.episodes.faults["onset"][...] = 0.0
    assert simulator.episodes.digest() == episodes.digest()
    simulator.reset(FLAGSHIP.draw(3, 2), np.arange(8) < 2)
    assert episodes.digest() == digest


@pytest.mark.parametrize("duplicate", [copy.deepcopy, lambda simulator: pickle.loads(pickle.dumps(simulator))])
@pytest.mark.parametrize(("craft", "threads"), [(4, 1), (1024, 2)])
def test_a_copy_continues_identically_and_apart(duplicate, craft, threads):
    orders = commands(30, craft)
    simulator = start(FLAGSHIP, FLAGSHIP.draw(0, craft), threads)
    history(simulator, orders[:15])
    twin = duplicate(simulator)
    frozen = snapshot(twin)
    original = history(simulator, orders[15:])
    np.testing.assert_array_equal(snapshot(twin), frozen)
    np.testing.assert_array_equal(history(twin, orders[15:]), original)


def test_a_simulator_that_was_never_reset_can_be_copied():
    twin = pickle.loads(pickle.dumps(Simulator(FLAGSHIP, 2)))
    twin.reset(FLAGSHIP.draw(0, 2))
    np.testing.assert_array_equal(snapshot(twin), snapshot(start(FLAGSHIP, FLAGSHIP.draw(0, 2))))


# ------------------------------------------------------------------------------------------------------ measurement


def test_measurements_are_the_callers_to_keep():
    simulator = start(FLAGSHIP, FLAGSHIP.draw(0, 3))
    measured = simulator.measurement()
    kept = {name: getattr(measured, name).copy() for name in MEASURED}
    expected = history(start(FLAGSHIP, FLAGSHIP.draw(0, 3)), commands(5, 3))
    for order in commands(5, 3):
        simulator.step(order)
    for name, values in kept.items():
        np.testing.assert_array_equal(getattr(measured, name), values)
        getattr(simulator.measurement(), name)[...] = np.nan
    np.testing.assert_array_equal(snapshot(simulator), expected[-1])


def test_measurement_has_one_row_per_craft_in_double_precision():
    measured = start(FLAGSHIP, FLAGSHIP.draw(0, 3)).measurement()
    assert len(measured) == 3
    widths = {"time": (), "attitude": (4,), "rate": (3,), "wheel_momentum": (4,), "last_command": (4,)}
    widths |= {"command_in_effect": (4,)}
    widths |= {"reference_attitude": (4,), "reference_rate": (3,), "reference_acceleration": (3,)}
    widths |= {"attitude_age": (), "modal_displacement": (0,), "modal_rate": (0,)}
    for name, width in widths.items():
        assert getattr(measured, name).shape == (3, *width) and getattr(measured, name).dtype == np.float64
    assert measured.star_tracker_valid.shape == (3,) and measured.star_tracker_valid.dtype == np.bool_
    assert {*widths, "star_tracker_valid"} == set(MEASURED) and measured.truth is None


def test_last_command_is_that_of_the_period_that_has_ended():
    simulator = start(FLAGSHIP, FLAGSHIP.draw(0, 2))
    assert np.all(simulator.measurement().last_command == 0.0)
    for order in commands(3, 2):
        simulator.step(order)
        np.testing.assert_array_equal(simulator.measurement().last_command, np.clip(order, -0.2, 0.2))
    simulator.reset(FLAGSHIP.draw(0, 1), np.array([True, False]))
    last = simulator.measurement().last_command
    assert np.all(last[0] == 0.0) and np.all(last[1] != 0.0)


def test_the_callers_command_is_not_changed():
    simulator, order = start(FLAGSHIP, FLAGSHIP.draw(0, 2)), np.full((2, 4), 9.0)
    simulator.step(order)
    assert np.all(order == 9.0)


# ------------------------------------------------------------------------------------------------------------ rules


@pytest.mark.parametrize("field", ["num_spacecraft", "threads"])
@pytest.mark.parametrize("value", [0, -1, 1.5, "two", None])
def test_counts_must_be_positive_integers(field, value):
    with pytest.raises(ValueError, match=f"{field} must be a positive integer"):
        Simulator(FLAGSHIP, **{"num_spacecraft": 2, field: value})


@pytest.mark.parametrize(
    ("command", "message"),
    [
        (np.zeros((3, 3)), r"command must have shape \(3, 4\)"),
        (np.zeros(4), r"command must have shape \(3, 4\)"),
        (np.zeros((2, 4)), r"command must have shape \(3, 4\)"),
        (np.full((3, 4), np.nan), "command must be finite"),
        (np.where(np.eye(3, 4) > 0.0, np.inf, 0.0), "command must be finite"),
    ],
)
def test_bad_commands_are_refused_and_change_nothing(command, message):
    simulator = start(FLAGSHIP, FLAGSHIP.draw(0, 3))
    simulator.step(np.full((3, 4), 0.1))
    before = snapshot(simulator)
    with pytest.raises(ValueError, match=message):
        simulator.step(command)
    np.testing.assert_array_equal(snapshot(simulator), before)


def three_wheels():
    spacecraft = dataclasses.replace(FLAGSHIP.spacecraft, wheels=WheelArray(np.eye(3), 0.2, 12.0))
    return FLAGSHIP.replace(spacecraft=spacecraft)


@pytest.mark.parametrize(
    ("episodes", "mask", "message"),
    [
        (FLAGSHIP.draw(1, 2), None, "episodes must be 3, one per spacecraft reset"),
        (FLAGSHIP.draw(1, 2), np.array([True, False, False]), "episodes must be 1, one per spacecraft reset"),
        (FLAGSHIP.draw(1, 3), np.array([True, True]), r"mask must be a boolean array of shape \(3,\)"),
        (FLAGSHIP.draw(1, 3), np.array([1, 1, 1]), r"mask must be a boolean array of shape \(3,\)"),
        (three_wheels().draw(1, 3), None, "episodes must have 4 wheels"),
        (FLAGSHIP.replace(disturbance=None).draw(1, 3), None, "episodes must fit the scenario: harmonics"),
    ],
)
def test_bad_resets_are_refused_and_change_nothing(episodes, mask, message):
    simulator = start(FLAGSHIP, FLAGSHIP.draw(0, 3))
    simulator.step(np.full((3, 4), 0.1))
    before, digest = snapshot(simulator), simulator.episodes.digest()
    with pytest.raises(ValueError, match=message):
        simulator.reset(episodes, mask)
    np.testing.assert_array_equal(snapshot(simulator), before)
    assert simulator.episodes.digest() == digest


def test_the_first_reset_must_cover_all_craft():
    with pytest.raises(ValueError, match="mask must cover all spacecraft at the first reset"):
        Simulator(FLAGSHIP, 3).reset(FLAGSHIP.draw(0, 2), np.array([True, True, False]))


def test_an_empty_mask_resets_nothing():
    simulator = start(FLAGSHIP, FLAGSHIP.draw(0, 3))
    simulator.step(np.full((3, 4), 0.1))
    before = snapshot(simulator)
    simulator.reset(FLAGSHIP.draw(0, 1)[:0], np.zeros(3, dtype=bool))
    np.testing.assert_array_equal(snapshot(simulator), before)


@pytest.mark.parametrize("use", [lambda s: s.step(np.zeros((2, 4))), lambda s: s.faults, lambda s: s.episodes])
def test_nothing_works_before_the_first_reset(use):
    with pytest.raises(RuntimeError, match="must be reset"):
        use(Simulator(FLAGSHIP, 2))
