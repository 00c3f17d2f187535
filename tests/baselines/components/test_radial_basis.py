"""The network: Gaussian nodes on the diagonal, trained against the sliding variable."""

import numpy as np
import pytest

from ftac_gym.baselines.components.radial_basis import RadialBasisNetwork
from ftac_gym.baselines.memory import Memory

INVERSE = np.linalg.inv([[30.0, 5.3, 6.4], [5.3, 27.0, 10.0], [6.4, 10.0, 19.0]])
CENTRES = np.array([-1.0, -0.5, 0.0, 0.5, 1.0])[:, None] * np.ones(3)


def basis(rate):
    return np.exp(-((rate[:, None, :] - CENTRES) ** 2).sum(axis=2))


def test_torque_and_training_follow_the_equations():
    random, memory = np.random.default_rng(0), Memory(4)
    network = RadialBasisNetwork(memory, 2.0, INVERSE, 0.1)
    weights = np.zeros((4, 5, 3))
    for _ in range(6):
        rate, variable = random.normal(size=(4, 3)), random.normal(size=(4, 3))
        nodes = basis(rate)
        np.testing.assert_allclose(network.torque(rate, variable), np.einsum("nk,nki->ni", nodes, weights), atol=1e-14)
        weights += 0.2 * np.einsum("nk,ni->nki", nodes, variable @ INVERSE)


def test_learns_a_constant_torque_that_holds_the_variable():
    """s' = J^-1 (d - d^) - s: the equilibrium is d^ = d."""
    memory, torque = Memory(1), np.array([[0.2, -0.1, 0.3]])
    network = RadialBasisNetwork(memory, 1e3, INVERSE, 0.01)
    variable, rate = np.zeros((1, 3)), np.array([[0.1, -0.2, 0.05]])
    for _ in range(4000):
        seen = network.torque(rate, variable)
        variable = variable + 0.01 * ((torque - seen) @ INVERSE - variable)
    np.testing.assert_allclose(seen, torque, atol=1e-4)


def test_gain_zero_switches_it_off():
    memory = Memory(2)
    network = RadialBasisNetwork(memory, 0.0, INVERSE, 0.1)
    for _ in range(3):
        np.testing.assert_array_equal(network.torque(np.ones((2, 3)), np.ones((2, 3))), 0.0)


def test_reset_forgets_the_chosen_craft_only():
    memory, ones = Memory(2), np.ones((2, 3))
    network = RadialBasisNetwork(memory, 1.0, INVERSE, 0.1)
    network.torque(ones, ones)
    memory.reset(np.array([True, False]))
    torque = network.torque(ones, ones)
    np.testing.assert_array_equal(torque[0], 0.0)
    assert (torque[1] != 0.0).any()


def test_bad_gain():
    with pytest.raises(ValueError, match=r"network_gain must not be negative, got -1\.0"):
        RadialBasisNetwork(Memory(1), -1.0, INVERSE, 0.1)
    with pytest.raises(ValueError, match=r"width must be positive, got 0\.0"):
        RadialBasisNetwork(Memory(1), 1.0, INVERSE, 0.1, width=0.0)
