"""Tests of `ftac_gym.task.vibration`: how the true modes are drawn, and what they amount to."""

import numpy as np
import pytest
from helpers.flexible_spacecraft import flexible_scenario, flown, random_appendages
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from ftac_gym import scenarios
from ftac_gym.dynamics import Simulator
from ftac_gym.spacecraft import FlexibleAppendages
from ftac_gym.task import AppendageUncertainty, InertiaUncertainty
from ftac_gym.task.vibration import MODE, exact_modes, modal_energy, vibration_torque

NOMINAL = FlexibleAppendages((1.0, 2.5, 4.0), (0.01, 0.0, 0.05), ((1.0, 0.2, 0.0), (0.0, -1.5, 0.3), (0.4, 0.0, 0.0)))
WIDE = AppendageUncertainty(frequency=(0.5, 1.5), damping=(0.0, 3.0), coupling=(0.7, 1.1))
COUNT = 4000
PROPERTY = settings(max_examples=60, deadline=None, derandomize=True)


def factors(table, nominal=NOMINAL):
    """Factors (N, k) on frequency, damping ratio and coupling that the records of MODE tell of."""
    frequency = np.sqrt(table["stiffness"]) / nominal.frequencies
    with np.errstate(invalid="ignore"):
        damping = table["damping"] / (2.0 * np.sqrt(table["stiffness"])) / nominal.damping_ratios
    delta = nominal.coupling_matrix
    coupling = np.einsum("nki,ki->nk", table["coupling"], delta) / (delta**2).sum(axis=1)
    return frequency, damping, coupling


def drawn(uncertainty=WIDE, count=COUNT, nominal=NOMINAL, seed=0):
    uniform = np.random.default_rng(seed).random((count, uncertainty.uniform_count(nominal.count)))
    return uncertainty.draw(nominal, uniform)


# -------------------------------------------------------------------------------------------------------------- rules


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"frequency": 0.0}, "frequency must be positive, got 0.0"),
        ({"frequency": (0.0, 1.0)}, r"frequency must be positive, got \(0.0, 1.0\)"),
        ({"frequency": -1.0}, "frequency must not be negative"),
        ({"damping": (-0.1, 1.0)}, "damping must not be negative"),
        ({"coupling": -0.5}, "coupling must not be negative"),
        ({"coupling": (1.2, 0.8)}, "coupling must have low <= high"),
        ({"frequency": (0.8, 1.0, 1.2)}, "frequency must be a number or a pair"),
        ({"damping": float("inf")}, "damping must be finite"),
        ({"damping": "much"}, "damping must be a number"),
    ],
)
def test_rules(fields, message):
    with pytest.raises(ValueError, match=message):
        AppendageUncertainty(**fields)


@pytest.mark.parametrize(
    "fields", [{}, {"frequency": 1.0}, {"damping": 0.0}, {"coupling": 0.0}, {"frequency": [0.9, 1.1]}]
)
def test_what_is_allowed(fields):
    AppendageUncertainty(**fields)


# ------------------------------------------------------------------------------------------------------------ drawing


def test_factors_are_uniform_in_their_ranges_and_independent():
    """Of three modes each: nine columns, none like another."""
    columns = np.column_stack(factors(drawn()))
    columns = np.delete(columns, 4, axis=1)  # the mode without damping has no factor on it
    ranges = [(0.5, 1.5)] * 3 + [(0.0, 3.0)] * 2 + [(0.7, 1.1)] * 3
    for column, (low, high) in zip(columns.T, ranges, strict=True):
        assert low <= column.min() and column.max() <= high * (1.0 + 1e-12)
        assert stats.kstest(column, "uniform", (low, high - low)).pvalue > 1e-3
    assert np.abs(np.corrcoef(columns.T) - np.eye(8)).max() < 0.06


def test_the_factor_on_the_coupling_is_one_for_the_three_axes():
    table = drawn()
    _, _, factor = factors(table)
    np.testing.assert_allclose(table["coupling"], factor[:, :, None] * NOMINAL.coupling_matrix, atol=1e-14)
    assert not table["damping"][:, 1].any()


def test_frequency_changes_stiffness_and_damping_together():
    """The damping ratio, not the damping constant, stays where only the frequency is drawn."""
    table = drawn(AppendageUncertainty(frequency=2.0))
    np.testing.assert_allclose(table["stiffness"], np.tile(4.0 * NOMINAL.stiffness, (COUNT, 1)), rtol=1e-14)
    np.testing.assert_allclose(table["damping"], np.tile(2.0 * NOMINAL.damping, (COUNT, 1)), rtol=1e-14)
    np.testing.assert_array_equal(table["coupling"], exact_modes(NOMINAL, COUNT)["coupling"])


def test_fixed_factors_of_one_change_nothing():
    np.testing.assert_array_equal(drawn(AppendageUncertainty(), 5), exact_modes(NOMINAL, 5))
    assert exact_modes(None, 5).shape == (5, 0) and exact_modes(None, 5).dtype == MODE


@PROPERTY
@given(st.integers(1, 9), st.integers(0, 1000), st.floats(0.05, 1.0), st.floats(1.0, 4.0), st.floats(0.0, 2.0))
def test_draws_stay_within_their_ranges(modes, seed, low, high, most):
    nominal = random_appendages(modes, seed)
    uncertainty = AppendageUncertainty(frequency=(low, high), damping=(0.0, most), coupling=(0.0, high))
    table = drawn(uncertainty, 50, nominal, seed)
    assert table.shape == (50, modes) and uncertainty.uniform_count(modes) == 3 * modes
    frequency, damping, coupling = factors(table, nominal)
    for values, (first, last) in ((frequency, (low, high)), (damping, (0.0, most)), (coupling, (0.0, high))):
        assert values.min() >= first - 1e-9 and values.max() <= last + 1e-9


def test_the_same_episode_on_one_craft_or_a_thousand():
    scenario = scenarios.get("flexible")
    many = scenario.draw(11, 1000)
    for index in (0, 1, 517, 999):
        alone = scenario.draw_episodes([11], np.array([index]))
        np.testing.assert_array_equal(alone.modes[0], many.modes[index])
        assert alone.digest() == many[index : index + 1].digest()
    assert len(np.unique(many.modes["stiffness"])) == 4000
    assert not np.any(scenario.draw(12, 1000).modes["stiffness"] == many.modes["stiffness"])


def test_without_uncertainty_the_modes_are_the_nominal_ones():
    scenario = scenarios.get("flexible").replace(appendage_uncertainty=None)
    nominal = scenario.spacecraft.appendages
    modes = scenario.draw(11, 7).modes
    np.testing.assert_array_equal(modes["stiffness"], np.tile(nominal.stiffness, (7, 1)))
    np.testing.assert_array_equal(modes["damping"], np.tile(nominal.damping, (7, 1)))
    np.testing.assert_array_equal(modes["coupling"], np.tile(nominal.coupling_matrix, (7, 1, 1)))


def test_the_modes_have_random_numbers_of_their_own():
    """The draw of modes changes nothing else of the episodes."""
    drawn_too = scenarios.get("flexible").draw(3, 50)
    exact = scenarios.get("flexible").replace(appendage_uncertainty=None).draw(3, 50)
    rigid = scenarios.get("flagship").draw(3, 50)
    for name, array in rigid.arrays().items():
        if name in ("modes", "initial"):
            continue
        np.testing.assert_array_equal(exact.arrays()[name], array, err_msg=name)
        np.testing.assert_array_equal(drawn_too.arrays()[name], array, err_msg=name)


@pytest.mark.parametrize(
    "changes",
    [
        {"appendage_uncertainty": AppendageUncertainty(coupling=(0.5, 3.0))},
        {"inertia_uncertainty": InertiaUncertainty(offset=-7.0 * np.eye(3))},
        {"inertia_uncertainty": InertiaUncertainty(amplitude=(7.0, 0.0, 0.0), frequency=(0.1, 0.1, 0.1))},
        {
            "inertia_uncertainty": InertiaUncertainty(offset=-3.0 * np.eye(3)),
            "appendage_uncertainty": AppendageUncertainty(coupling=1.4),
        },
    ],
    ids=["coupling", "inertia", "varying inertia", "both"],
)
def test_a_craft_without_a_body_is_refused(changes):
    scenario = flexible_scenario(random_appendages(4, share=0.5))
    message = (
        "appendage_uncertainty and inertia_uncertainty must leave J - delta' delta of every spacecraft positive "
        r"definite; the smallest eigenvalue drawn \[kg m\^2\], got -"
    )
    with pytest.raises(ValueError, match=message):
        scenario.replace(**changes)


def test_every_drawn_craft_of_the_flexible_scenario_has_a_body():
    episodes = scenarios.get("flexible").draw(0, 2000)
    carried = np.einsum("nki,nkj->nij", episodes.modes["coupling"], episodes.modes["coupling"])
    left = np.linalg.eigvalsh(episodes.inertia["constant"] - carried)
    assert left.min() > 5.0


# -------------------------------------------------------------------------------------------------- energy and torque


@PROPERTY
@given(st.integers(1, 6), st.integers(1, 4), st.integers(1, 3), st.integers(0, 10_000))
def test_energy_and_torque_against_plain_formulas(modes, craft, steps, seed):
    rng = np.random.default_rng(seed)
    table = np.zeros((craft, modes), MODE)
    table["stiffness"], table["damping"] = rng.uniform(0.0, 9.0, (2, craft, modes))
    table["coupling"] = rng.normal(size=(craft, modes, 3))
    eta, swing = rng.normal(size=(2, steps, craft, modes))
    rate = rng.normal(size=(steps, craft, 3))
    energy = modal_energy(table["stiffness"], eta, swing)
    torque = vibration_torque(table, eta, swing, rate)
    assert energy.shape == (steps, craft) and torque.shape == (steps, craft, 3)
    for step in range(steps):
        for number in range(craft):
            own, delta = table[number], table["coupling"][number]
            e, s, w = eta[step, number], swing[step, number], rate[step, number]
            K, C = np.diag(own["stiffness"]), np.diag(own["damping"])
            np.testing.assert_allclose(energy[step, number], 0.5 * s @ s + 0.5 * e @ K @ e, rtol=1e-12)
            expected = delta.T @ (C @ s + K @ e) - np.cross(w, delta.T @ s)
            np.testing.assert_allclose(torque[step, number], expected, rtol=1e-11, atol=1e-12)


def test_a_rigid_craft_has_neither():
    table = exact_modes(None, 3)
    nothing = np.zeros((3, 0))
    np.testing.assert_array_equal(modal_energy(table["stiffness"], nothing, nothing), np.zeros(3))
    np.testing.assert_array_equal(vibration_torque(table, nothing, nothing, np.ones((3, 3))), np.zeros((3, 3)))
    simulator = Simulator(scenarios.get("flagship"), 3)
    simulator.reset(scenarios.get("flagship").draw(0, 3))
    simulator.step(np.full((3, 4), 0.1))
    assert not simulator.modal_energy.any() and not simulator.vibration_torque.any()


# ------------------------------------------------------------------------------------------- the true modes are true


@pytest.mark.parametrize("name", ["frequency", "damping", "coupling"])
def test_drawn_modes_and_not_the_nominal_ones_move_the_craft(name):
    """Like a spacecraft that is built so; the nominal parameters do not matter to the plant."""
    nominal = random_appendages(3, damping=(0.01, 0.05))
    parts = {"displacement": (0.05, -0.1, 0.1), "physics_step": 0.01, "duration": 20.0}
    factor = {"frequency": 1.3, "damping": 2.0, "coupling": 1.2}[name]
    scenario = flexible_scenario(nominal, **parts)
    commands = np.random.default_rng(0).uniform(-0.1, 0.1, (100, 4))
    plain = flown(scenario, commands)
    changed = flown(scenario.replace(appendage_uncertainty=AppendageUncertainty(**{name: factor})), commands)
    built = FlexibleAppendages(
        np.array(nominal.frequencies) * (factor if name == "frequency" else 1.0),
        np.array(nominal.damping_ratios) * (factor if name == "damping" else 1.0),
        np.array(nominal.coupling) * (factor if name == "coupling" else 1.0),
    )
    np.testing.assert_allclose(changed, flown(flexible_scenario(built, **parts), commands), atol=1e-12)
    assert np.abs(changed[:, 4:7] - plain[:, 4:7]).max() > 1e-5


def test_craft_of_one_batch_have_modes_of_their_own():
    scenario = flexible_scenario(random_appendages(3), displacement=(0.1, 0.1, 0.1), physics_step=0.01)
    scenario = scenario.replace(appendage_uncertainty=AppendageUncertainty(frequency=(0.8, 1.2)))
    simulator = Simulator(scenario, 20)
    simulator.reset(scenario.draw(0, 20))
    for _ in range(50):
        simulator.step(np.zeros((20, 4)))
    assert len(np.unique(simulator.state.rate[:, 0])) == 20
    energy = simulator.modal_energy
    stiffness = simulator.episodes.modes["stiffness"]
    expected = 0.5 * (simulator.state.modal_rate**2 + stiffness * simulator.state.modal_displacement**2).sum(axis=1)
    np.testing.assert_allclose(energy, expected, rtol=1e-13)
