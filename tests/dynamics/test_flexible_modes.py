"""Modes of flexible spacecraft: known limits, free frequencies, and independence of spacecraft side by side."""

from itertools import pairwise

import numpy as np
import pytest
from helpers.flexible_spacecraft import (
    INERTIA,
    PYRAMID,
    flexible_scenario,
    flown,
    random_appendages,
    started,
    state_vector,
)
from helpers.free_flexible_body import DISTURBANCE, LEAN, MOMENTUM, VARYING, shaken, split, undamped
from scipy.linalg import eigh

from ftac_gym import scenarios
from ftac_gym.dynamics import Simulator
from ftac_gym.spacecraft.appendages import FlexibleAppendages
from ftac_gym.task.inertia import InertiaUncertainty

# ------------------------------------------------------------------------------------------------------- known limits


@pytest.mark.parametrize("coupled", [True, False])
def test_without_coupling_the_body_is_rigid_and_the_modes_ring_alone(coupled):
    frequency, ratio = np.array([0.7, 1.9, 3.1]), np.array([0.0, 0.05, 0.2])
    appendages = FlexibleAppendages(tuple(frequency), tuple(ratio), np.zeros((3, 3)))
    start = shaken(3)
    parts = {
        "momentum": MOMENTUM,
        "coupling": coupled,
        "disturbance": DISTURBANCE,
        "inertia_uncertainty": InertiaUncertainty(**VARYING, rate_torque=True),
        "misalignment": LEAN,
        "physics_step": 0.01,
        "duration": 30.0,
    }
    flexible, rigid = flexible_scenario(appendages, **start, **parts), flexible_scenario(None, **parts)
    commands = np.random.default_rng(0).uniform(-0.25, 0.25, (flexible.horizon, 4))
    seen = flown(flexible, commands)
    np.testing.assert_array_equal(seen[:, :11], flown(rigid, commands))

    time = 0.1 * np.arange(flexible.horizon + 1)[:, None]
    decay, beat = ratio * frequency, frequency * np.sqrt(1.0 - ratio**2)
    sine = (start["swing"] + decay * start["displacement"]) / beat
    eta = np.exp(-decay * time) * (start["displacement"] * np.cos(beat * time) + sine * np.sin(beat * time))
    np.testing.assert_allclose(split(seen, 3)[1], eta, atol=1e-7)


def test_stiff_modes_make_a_rigid_body_of_the_whole_inertia():
    """The difference falls with the square of the frequency; a body without what the modes hold is far off."""
    command = np.array([0.05, -0.02, 0.01, 0.03])
    start = {"momentum": MOMENTUM, "control_period": 0.05, "physics_step": 0.001, "duration": 20.0}
    rigid = flown(flexible_scenario(None, **start), np.tile(command, (400, 1)))[:, 4:7]
    soft = random_appendages(4)
    left = INERTIA - soft.carried_inertia
    hub = flown(flexible_scenario(None, inertia=left, **start), np.tile(command, (400, 1)))[:, 4:7]
    errors = []
    for stiffness in (30.0, 60.0, 120.0):
        stiff = FlexibleAppendages((stiffness, 1.3 * stiffness, 1.7 * stiffness, 2.0 * stiffness), 0.1, soft.coupling)
        seen = flown(flexible_scenario(stiff, **start), np.tile(command, (400, 1)))[:, 4:7]
        errors.append(np.abs(seen - rigid)[200:].max())
    assert errors[-1] < 1e-5 and np.abs(hub - rigid)[200:].max() > 1e-3
    for coarse, fine in pairwise(errors):
        assert coarse / fine > 3.0


def test_soft_modes_leave_a_body_of_what_is_not_theirs():
    soft = random_appendages(4, frequencies=(1e-6, 1e-5))
    command = np.array([0.05, -0.02, 0.01, 0.03])

    left = INERTIA - soft.carried_inertia
    parts = {"rate": (0.0, 0.0, 0.0), "momentum": MOMENTUM, "physics_step": 0.01, "duration": 3.0}
    seen = flown(flexible_scenario(soft, **parts), np.tile(command, (30, 1)))
    hub = flown(flexible_scenario(None, inertia=left, **parts), np.tile(command, (30, 1)))
    whole = flown(flexible_scenario(None, **parts), np.tile(command, (30, 1)))
    np.testing.assert_allclose(seen[:, 4:7], hub[:, 4:7], atol=1e-7)
    assert np.abs(seen[:, 4:7] - whole[:, 4:7]).max() > 1e-3


def test_soft_modes_of_a_turning_craft_are_a_wheel_that_nobody_turns():
    """They keep delta' (eta' + delta w): the lighter body carries that as a constant momentum in body axes."""
    soft = random_appendages(4, frequencies=(1e-6, 1e-5))
    rate = np.array([0.3, -0.2, 0.25])
    stored = np.linalg.pinv(PYRAMID) @ soft.carried_inertia @ rate
    parts = {"rate": tuple(rate), "physics_step": 0.01, "duration": 10.0}
    seen = flown(flexible_scenario(soft, **parts), np.zeros((100, 4)))
    left = INERTIA - soft.carried_inertia
    hub = flown(flexible_scenario(None, inertia=left, momentum=tuple(stored), **parts), np.zeros((100, 4)))
    np.testing.assert_allclose(seen[:, :7], hub[:, :7], atol=1e-7)
    assert np.ptp(seen[:, 4:7], axis=0).max() > 0.05


@pytest.mark.parametrize("number", range(4))
def test_a_free_body_rings_in_one_of_its_own_modes(number):
    """Started along a free-free mode, everything swings with its frequency, and the body against it."""
    appendages = undamped(random_appendages(4))
    delta = np.array(appendages.coupling)
    mass = np.eye(4) - delta @ np.linalg.solve(INERTIA, delta.T)
    squares, shapes = eigh(np.diag(np.array(appendages.frequencies) ** 2), mass)
    frequency, shape = np.sqrt(squares[number]), 1e-6 * shapes[:, number]
    assert appendages.free_frequencies(INERTIA)[number] == pytest.approx(frequency, rel=1e-12)
    scenario = flexible_scenario(
        appendages, rate=(0.0, 0.0, 0.0), displacement=shape, control_period=0.05, physics_step=0.005, duration=50.0
    )
    states = flown(scenario, np.zeros((scenario.horizon, 4)))
    time = 0.05 * np.arange(scenario.horizon + 1)[:, None]
    rate, eta, _ = split(states, 4)
    np.testing.assert_allclose(eta, shape * np.cos(frequency * time), rtol=0.0, atol=1e-6 * np.abs(shape).max())
    against = np.linalg.solve(INERTIA, delta.T @ shape) * frequency * np.sin(frequency * time)
    np.testing.assert_allclose(rate, against, rtol=0.0, atol=1e-5 * np.abs(against).max())


def test_the_spectrum_of_a_free_body_has_its_free_frequencies_and_not_the_clamped_ones():
    appendages = undamped(random_appendages(3, share=0.7))
    free, clamped = appendages.free_frequencies(INERTIA), np.sort(appendages.frequencies)
    scenario = flexible_scenario(
        appendages, rate=(0.0, 0.0, 0.0), displacement=(1e-6, 2e-6, -1e-6), physics_step=0.01, duration=819.2
    )
    rate = flown(scenario, np.zeros((8191, 4)))[:, 4:7]
    power = np.abs(np.fft.rfft(rate * np.hanning(len(rate))[:, None], axis=0)).sum(axis=1)
    bins = 2.0 * np.pi * np.fft.rfftfreq(len(rate), 0.1)
    peaks = [k for k in range(1, len(power) - 1) if power[k] > power[k - 1 : k + 2].mean() and power[k] >= max(
        power[k - 1], power[k + 1]) and power[k] > 1e-3 * power.max()]  # fmt: skip
    np.testing.assert_allclose(bins[peaks], free, atol=0.6 * bins[1])
    assert np.abs(free - clamped).max() > 20.0 * bins[1]


# -------------------------------------------------------------------------------------- spacecraft beside each other


def test_craft_in_a_batch_do_not_influence_each_other():
    scenario = scenarios.get("flexible").replace(duration=10.0)
    episodes = scenario.draw(5, 6)
    commands = np.random.default_rng(0).uniform(-0.2, 0.2, (40, 6, 4))
    together = Simulator(scenario, 6)
    together.reset(episodes)
    for command in commands:
        together.step(command)
    for craft in range(6):
        alone = Simulator(scenario, 1)
        alone.reset(episodes[craft : craft + 1])
        for command in commands[:, craft : craft + 1]:
            alone.step(command)
        np.testing.assert_array_equal(state_vector(alone), state_vector(together, craft))


def test_threads_change_nothing():
    scenario = scenarios.get("flexible").replace(duration=10.0)
    episodes = scenario.draw(5, 1100)
    ends = []
    for threads in (1, 2):
        simulator = Simulator(scenario, 1100, threads)
        simulator.reset(episodes)
        for step in range(5):
            simulator.step(np.full((1100, 4), 0.01 * step))
        ends.append([state_vector(simulator, craft) for craft in range(0, 1100, 3)])
    np.testing.assert_array_equal(*ends)


def test_a_masked_reset_starts_the_modes_of_its_craft_only():
    appendages = random_appendages(3)
    scenario = flexible_scenario(appendages, **shaken(3), physics_step=0.01, duration=10.0)
    simulator = started(scenario, 3)
    for _ in range(20):
        simulator.step(np.full((3, 4), 0.05))
    before = [state_vector(simulator, craft) for craft in range(3)]
    simulator.reset(scenario.draw(9, 1), np.array([False, True, False]))
    for craft in (0, 2):
        np.testing.assert_array_equal(state_vector(simulator, craft), before[craft])
    np.testing.assert_array_equal(simulator.state.modal_displacement[1], shaken(3)["displacement"])
    np.testing.assert_array_equal(simulator.state.modal_rate[1], shaken(3)["swing"])
    fresh = started(scenario)
    for _ in range(20):
        simulator.step(np.full((3, 4), 0.05))
        fresh.step(np.full((1, 4), 0.05))
    np.testing.assert_array_equal(state_vector(simulator, 1), state_vector(fresh))


def test_energy_and_torque_of_the_simulator():
    """The torque is what a hub of J - delta' delta lacks: J w' with it in place of everything about the modes."""
    appendages = random_appendages(4, seed=2)
    delta, frequency = np.array(appendages.coupling), np.array(appendages.frequencies)
    scenario = flexible_scenario(appendages, **shaken(4), coupling=False, control_period=0.001, physics_step=0.001)
    simulator = started(scenario)
    states = [state_vector(simulator)]
    torque, energy = [simulator.vibration_torque[0]], [simulator.modal_energy[0]]
    for _ in range(40):
        simulator.step(np.zeros((1, 4)))
        states.append(state_vector(simulator))
        torque.append(simulator.vibration_torque[0])
        energy.append(simulator.modal_energy[0])
    rate, eta, swing = split(np.array(states), 4)
    np.testing.assert_allclose(energy, 0.5 * (swing**2).sum(axis=1) + 0.5 * (frequency**2 * eta**2).sum(axis=1))
    acceleration = (rate[2:] - rate[:-2]) / 0.002
    needed = acceleration @ (INERTIA - delta.T @ delta) + np.cross(rate, rate @ INERTIA)[1:-1]
    np.testing.assert_allclose(np.array(torque)[1:-1], needed, atol=1e-5)
    assert np.abs(torque).max() > 0.1


@pytest.mark.parametrize("first", ["flexible", "flagship"])
def test_episodes_of_another_kind_of_craft_are_refused(first):
    """A rigid spacecraft's episodes do not fit a flexible one's simulator, nor the other way round."""
    other = {"flexible": "flagship", "flagship": "flexible"}[first]
    scenario = scenarios.get(first)
    simulator = Simulator(scenario, 2)
    simulator.reset(scenario.draw(0, 2))
    with pytest.raises(ValueError, match="episodes must be of spacecraft with"):
        simulator.reset(scenarios.get(other).draw(0, 2))
