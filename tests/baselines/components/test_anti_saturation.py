"""The auxiliary system: |xi| can only fall, whatever the saturation, unless the integrator is too coarse."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ftac_gym.baselines.components.anti_saturation import AntiSaturation
from ftac_gym.baselines.memory import Memory
from ftac_gym.spacecraft.layouts import orthogonal_and_skew

INVERSE = np.linalg.inv([[30.0, 5.3, 6.4], [5.3, 27.0, 10.0], [6.4, 10.0, 19.0]])
TO_ACCELERATION = INVERSE @ np.array(orthogonal_and_skew())
SMALLEST, PERIOD = 0.05, 0.01


def build(count, substeps, **changes):
    memory = Memory(count)
    return AntiSaturation(memory, PERIOD, TO_ACCELERATION, substeps=substeps, **changes), memory


def excess(random, count, size):
    directions = random.normal(size=(count, 4))
    return size * directions / np.linalg.norm(directions, axis=1, keepdims=True)


@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), size=st.floats(0.0, 20.0))
def test_with_fine_steps_it_only_falls(seed, size):
    """h = |H| |Theta| up to 1.8 rad/s^2; a step resolves the decay (h / dk)^2 + L2."""
    random, (auxiliary, memory) = np.random.default_rng(seed), build(16, 400, smallest=SMALLEST)
    memory["anti_saturation"] = random.normal(size=(16, 3))
    lengths = [np.linalg.norm(auxiliary.variable, axis=1)]
    for _ in range(4):
        auxiliary.update(excess(random, 16, size), random.uniform(0.05, 1.0, (16, 4)))
        lengths.append(np.linalg.norm(auxiliary.variable, axis=1))
    before, after = np.array(lengths[:-1]), np.array(lengths[1:])
    assert (after <= before + 1e-15).all()
    assert (after[before >= SMALLEST] < before[before >= SMALLEST]).all()
    np.testing.assert_array_equal(after[before < SMALLEST], before[before < SMALLEST])  # at rest for good


@pytest.mark.parametrize(("size", "substeps", "periods"), [(0.5, 20, 150), (5.0, 100, 30), (50.0, 8000, 1)])
def test_it_ends_at_the_smallest_value_soon(size, substeps, periods):
    """The stronger the saturation, the sooner: within |xi|^2 / h^2, and at once for good."""
    random, (auxiliary, _) = np.random.default_rng(0), build(8, substeps, smallest=0.02)
    theta = excess(random, 8, size)
    for _ in range(periods):
        auxiliary.update(theta, None)
    length = np.linalg.norm(auxiliary.variable, axis=1)
    assert (length < 0.02).all() and (length > 0.018).all()
    stays = auxiliary.variable.copy()
    auxiliary.update(theta, None)
    np.testing.assert_array_equal(auxiliary.variable, stays)


def test_coarse_steps_blow_up():
    """An explicit step of 10 ms gives noise of the integrator instead, far above the initial value."""
    random, largest = np.random.default_rng(0), {}
    theta = excess(random, 8, 100.0)
    for substeps in (1, 4000):
        auxiliary, _ = build(8, substeps, smallest=1e-2)
        start = np.linalg.norm(auxiliary.variable, axis=1)
        lengths = []
        for _ in range(3):
            auxiliary.update(theta, None)
            lengths.append(np.linalg.norm(auxiliary.variable, axis=1))
        largest[substeps] = np.max(lengths / start)
    assert largest[1] > 10.0
    assert largest[4000] < 1.0


def test_one_step_is_the_equation():
    random, (auxiliary, _) = np.random.default_rng(0), build(5, 1, gain=0.7, decay=3.0)
    theta, weak, xi = excess(random, 5, 0.3), random.uniform(0.1, 1.0, (5, 4)), np.full(3, 0.1)
    auxiliary.update(theta, weak)
    for row in range(5):
        matrix = TO_ACCELERATION @ np.diag(weak[row])
        h = np.linalg.svd(matrix)[1][0] * np.linalg.norm(theta[row])
        change = -3.0 * xi - h**2 / (xi @ xi) * xi - matrix @ theta[row]
        np.testing.assert_allclose(auxiliary.variable[row], xi + PERIOD * change, rtol=1e-12)
    np.testing.assert_allclose(auxiliary.correction, 0.7 * auxiliary.variable)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"gain": 0.0}, "gain must be positive, got 0.0"),
        ({"decay": 1.0}, r"decay must exceed L1\^2/2 \+ 1/2 .*, got 1.0"),
        ({"gain": 3.0}, r"decay must exceed L1\^2/2 \+ 1/2 .*, got 2.0"),
        ({"smallest": 0.0}, "smallest must be positive, got 0.0"),
        ({"substeps": 0}, "substeps must be a whole number, 1 or more, got 0"),
        ({"substeps": 1.5}, "substeps must be a whole number, 1 or more, got 1.5"),
    ],
)
def test_bad_parameters(changes, message):
    with pytest.raises(ValueError, match=message):
        build(1, **{"substeps": 1, **changes})
