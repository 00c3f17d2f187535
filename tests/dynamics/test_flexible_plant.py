"""Physics of flexible spacecraft: the printed equations, conserved quantities, known limits, and independence."""

from itertools import pairwise

import numpy as np
import pytest
from helpers.flexible_spacecraft import (
    INERTIA,
    PYRAMID,
    flexible_scenario,
    flown,
    integrated,
    random_appendages,
)
from helpers.free_flexible_body import (
    DISTURBANCE,
    LEAN,
    MOMENTUM,
    VARYING,
    external,
    inertia,
    inertia_rate,
    inertial_momentum,
    shaken,
    simpson,
    split,
    total_energy,
    undamped,
)
from hypothesis import given, settings
from hypothesis import strategies as st

from ftac_gym import scenarios
from ftac_gym.spacecraft.spacecraft import Spacecraft
from ftac_gym.task.inertia import InertiaUncertainty

# ------------------------------------------------------------------------------------------------ the printed equations


@pytest.mark.parametrize(
    ("modes", "coupled", "varying", "rate_torque", "lean"),
    [
        (1, True, False, False, False),
        (3, True, True, True, True),
        (3, False, True, False, True),
        (4, True, False, False, True),
        (4, False, False, False, False),
        (7, True, True, True, False),
        (7, False, False, False, True),
    ],
)
def test_the_plant_agrees_with_the_mass_matrix_form(modes, coupled, varying, rate_torque, lean):
    """Disturbance that grows with the rate, a new command every period, stirred modes; beyond three modes too."""
    appendages = random_appendages(modes, seed=modes)
    scenario = flexible_scenario(
        appendages,
        momentum=MOMENTUM,
        coupling=coupled,
        **shaken(modes),
        disturbance=DISTURBANCE,
        inertia_uncertainty=InertiaUncertainty(**VARYING, rate_torque=rate_torque) if varying else None,
        misalignment=LEAN if lean else None,
        control_period=0.5,
        physics_step=0.001,
        duration=20.0,
    )
    commands = np.random.default_rng(0).uniform(-0.2, 0.2, (scenario.horizon, 4))
    seen = flown(scenario, commands)
    expected = integrated(
        seen[0], commands, 0.5, appendages, PYRAMID + LEAN if lean else PYRAMID, coupled,
        inertia if varying else None, inertia_rate if rate_torque else None, external,
    )  # fmt: skip
    np.testing.assert_allclose(seen, expected, rtol=0.0, atol=1e-9)
    rate, eta, _ = split(expected, modes)
    assert np.abs(rate).max() > 0.05 and np.abs(eta).max() > 0.01


def test_every_part_of_the_comparison_matters():
    """Leaving out the modes' momentum, the misalignment or the damping is seen from afar."""
    appendages = random_appendages(3, seed=3)
    scenario = flexible_scenario(appendages, momentum=MOMENTUM, **shaken(3), physics_step=0.01, duration=20.0)
    commands = np.random.default_rng(0).uniform(-0.2, 0.2, (scenario.horizon, 4))
    plain = flown(scenario, commands)
    craft = scenario.spacecraft
    others = {
        "damping": scenario.replace(spacecraft=Spacecraft(INERTIA, craft.wheels, appendages=undamped(appendages))),
        "misalignment": scenario.replace(misalignment=LEAN),
        "rigid": flexible_scenario(None, momentum=MOMENTUM, physics_step=0.01, duration=20.0),
    }  # fmt: skip
    for name, other in others.items():
        assert np.abs(flown(other, commands)[:, 4:7] - plain[:, 4:7]).max() > 1e-4, name


def test_the_plant_of_li_2023_over_a_minute():
    """The published spacecraft under the published disturbance, to within its own step."""
    scenario = scenarios.get("li_2023").replace(faults=None, control_period=0.5, duration=60.0, physics_step=0.0025)
    appendages, wheels = scenario.spacecraft.appendages, scenario.spacecraft.wheels
    commands = np.random.default_rng(0).uniform(-3.0, 3.0, (scenario.horizon, 3))
    seen = flown(scenario, commands)
    slow = 0.2 * np.pi

    def torque(time, rate):
        return 1e-4 * np.array(
            [
                -3.0 + 4.0 * np.cos(slow * time) - np.cos(2.0 * slow * time),
                4.0 + 3.0 * np.sin(slow * time) - 2.0 * np.cos(2.0 * slow * time),
                -3.0 + 4.0 * np.sin(slow * time) - 3.0 * np.sin(2.0 * slow * time),
            ]
        )

    total = scenario.spacecraft.inertia_matrix
    axes = wheels.axis_matrix + np.array(scenario.misalignment)
    expected = integrated(seen[0], commands, 0.5, appendages, axes, False, lambda time: total, None, torque)
    np.testing.assert_allclose(seen, expected, rtol=0.0, atol=1e-9)


# ---------------------------------------------------------------------------------------------------- what is conserved


@pytest.mark.parametrize("step", [0.02, 0.01, 0.005, 0.0025])
def test_momentum_and_energy_of_a_free_undamped_body(step):
    """Over 200 s. RK4 takes (f h)^6 / 72 of an oscillator's energy in every step, and nothing beyond that is lost."""
    appendages = undamped(random_appendages(4))
    scenario = flexible_scenario(appendages, **shaken(4), control_period=0.1, physics_step=step, duration=200.0)
    states = flown(scenario, np.zeros((scenario.horizon, 4)))
    momentum, energy = inertial_momentum(states, appendages), total_energy(states, appendages)
    assert np.linalg.norm(momentum - momentum[0], axis=1).max() < 1e-9 * np.linalg.norm(momentum[0])
    fastest = step * appendages.free_frequencies(INERTIA)[-1]
    np.testing.assert_allclose(energy, energy[0], rtol=200.0 / step * fastest**6 / 72.0)
    if step <= 0.005:
        assert np.linalg.norm(momentum - momentum[0], axis=1).max() < 1e-12 * np.linalg.norm(momentum[0])
    if step <= 0.0025:
        np.testing.assert_allclose(energy, energy[0], rtol=1e-9)
    # The modes and the body do exchange both.
    assert np.ptp(0.5 * np.einsum("ni,ij,nj->n", states[:, 4:7], INERTIA, states[:, 4:7])) > 0.1 * energy[0]


def test_momentum_is_conserved_whatever_the_wheels_do():
    appendages = random_appendages(4)
    scenario = flexible_scenario(appendages, momentum=MOMENTUM, **shaken(4), physics_step=0.01, duration=100.0)
    rng = np.random.default_rng(0)
    states = flown(scenario, rng.uniform(-0.2, 0.2, (scenario.horizon, 4)))
    momentum = inertial_momentum(states, appendages)
    assert np.linalg.norm(momentum - momentum[0], axis=1).max() < 1e-9 * np.linalg.norm(momentum[0])


def test_the_energy_changes_by_the_work_of_the_wheels_and_the_losses_of_the_modes():
    appendages, step = random_appendages(3, damping=(0.01, 0.1)), 0.01
    scenario = flexible_scenario(appendages, **shaken(3), control_period=step, physics_step=step, duration=40.0)
    command = np.array([0.05, -0.02, 0.01, 0.03])
    damping = 2.0 * np.array(appendages.damping_ratios) * appendages.frequencies
    for level in (0.0, 1.0):
        states = flown(scenario, np.tile(level * command, (scenario.horizon, 1)))
        rate, _, swing = split(states, 3)
        energy, loss = total_energy(states, appendages), (damping * swing**2).sum(axis=1)
        gained = simpson(level * rate @ PYRAMID @ command - loss, step)
        assert energy[-1] - energy[0] == pytest.approx(gained, rel=1e-7)
        if level == 0.0:
            assert np.all(np.diff(energy) <= 1e-13) and energy[-1] < 0.6 * energy[0]


@settings(max_examples=25, deadline=None, derandomize=True)
@given(
    st.integers(1, 8), st.integers(0, 10_000), st.floats(0.01, 0.95), st.floats(0.0, 0.5), st.booleans(),
    st.floats(0.0, 0.3),
)  # fmt: skip
def test_no_craft_gains_energy_or_momentum(modes, seed, share, ratio, spinning, swing):
    """However strongly coupled: a body of which the modes hold up to 95 % in one direction."""
    appendages = random_appendages(modes, seed, share, (0.3, 3.0), (0.0, ratio))
    scenario = flexible_scenario(
        appendages,
        rate=(0.3, -0.2, 0.25) if spinning else (0.0, 0.0, 0.0),
        displacement=(swing,) * modes,
        physics_step=0.005,
        duration=5.0,
    )
    states = flown(scenario, np.zeros((scenario.horizon, 4)))
    energy, momentum = total_energy(states, appendages), inertial_momentum(states, appendages)
    assert np.all(np.diff(energy) <= 1e-8 * energy[0] + 1e-300)
    assert np.linalg.norm(momentum - momentum[0], axis=1).max() <= 1e-8 * max(np.linalg.norm(momentum[0]), swing)


def test_the_integrator_converges_with_order_four():
    appendages = random_appendages(4, frequencies=(0.8, 2.5))
    scenario = flexible_scenario(
        appendages,
        rate=(0.5, -0.6, 0.4),
        momentum=(5.0, -3.0, 4.0, 1.0),
        **shaken(4),
        control_period=0.4,
        disturbance=DISTURBANCE,
        inertia_uncertainty=InertiaUncertainty(**VARYING, rate_torque=True),
        duration=800.0,
    )
    commands = np.random.default_rng(0).uniform(-0.2, 0.2, (20, 4))

    def end(step):
        return flown(scenario.replace(physics_step=step), commands)[-1]

    truth = end(0.4 / 128)
    errors = [np.linalg.norm(end(step) - truth) for step in (0.1, 0.05, 0.025)]
    assert errors[0] > 1e-7
    for coarse, fine in pairwise(errors):
        assert 13.0 < coarse / fine < 20.0
