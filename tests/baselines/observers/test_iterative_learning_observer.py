"""The iterative learning observer: its share of a constant torque, its matrix, its limits."""

import numpy as np
import pytest
from helpers.flexible_cases import FLEXIBLE, drawn

from ftac_gym.baselines.memory import Memory
from ftac_gym.baselines.observers import make as make_observer

# -------------------------------------------------------------------------------------- iterative learning observer


def learned(scenario, commands, **gains):
    """w~ and f^ (T, 6) of a spacecraft that stays at rest under commands (T, m)."""
    memory = Memory(1)
    observer = make_observer("ilo_class", scenario, memory, **gains)
    results = []
    for command in commands:
        measurement = drawn(scenario, 0, 1, rate=0.0)
        estimate = observer.update(measurement, command[None], scenario.control_period)
        results.append(np.append(memory["rate_mismatch"][0], estimate.disturbance[0]))
    return np.array(results)


@pytest.mark.parametrize(
    ("rate_gain", "learning_gain", "forgetting"), [(8.0, 4.0, 1.0), (8.0, 4.0, 0.9), (2.0, 1.0, 0.5)]
)
def test_learning_finds_a_share_of_a_lasting_torque(rate_gain, learning_gain, forgetting):
    """f = K1 f + K2 w~ and f + L w~ = torque at rest, hence f = torque / (1 + (1 - K1) rate_gain / learning_gain)."""
    axes, torque = FLEXIBLE.spacecraft.wheels.axis_matrix, np.array([0.03, -0.02, 0.05])
    commands = np.tile(-np.linalg.pinv(axes) @ torque, (2000, 1))
    gains = {"rate_gain": rate_gain, "learning_gain": learning_gain, "forgetting": forgetting}
    found = learned(FLEXIBLE, commands, **gains)[-1, 3:]
    share = 1.0 / (1.0 + (1.0 - forgetting) * rate_gain / learning_gain)
    np.testing.assert_allclose(found, share * torque, rtol=1e-9)
    assert (share == 1.0) == (forgetting == 1.0)


@pytest.mark.parametrize(
    ("rate_gain", "learning_gain", "forgetting"), [(8.0, 4.0, 1.0), (3.0, 6.0, 0.9), (15.0, 2.0, 1.0)]
)
def test_learning_moves_as_its_matrix_says(rate_gain, learning_gain, forgetting):
    """w~' and J^-1 f' from those of one period before, identified from a flight that decays."""
    gains = {"rate_gain": rate_gain, "learning_gain": learning_gain, "forgetting": forgetting}
    commands = np.zeros((14, 4))
    commands[1] = (0.1, 0.0, 0.05, 0.0)
    path = learned(FLEXIBLE, commands, **gains)[1:]
    inverse = np.linalg.inv(FLEXIBLE.spacecraft.inertia_matrix)
    pairs = np.stack([path[:, 0], (path[:, 3:] @ inverse)[:, 0]])
    matrix = pairs[:, 1:] @ np.linalg.pinv(pairs[:, :-1])
    period, decay = FLEXIBLE.control_period, 1.0 - FLEXIBLE.control_period * rate_gain
    expected = [[decay, -period], [learning_gain * decay, forgetting - learning_gain * period]]
    np.testing.assert_allclose(matrix, expected, rtol=0.0, atol=1e-8)


@pytest.mark.parametrize("rate_gain", [1.0, 8.0, 15.0])
def test_learning_that_is_not_stable_is_refused(rate_gain):
    """At the bound of refusal a pole of z^2 - trace z + det is at -1: 1 + trace + det = 0 for K1 = 1."""
    period = FLEXIBLE.control_period
    decay = 1.0 - period * rate_gain
    # trace = decay + 1 - T k, det = decay; 1 + trace + det = 0.
    edge = (2.0 + 2.0 * decay) / period
    make_observer("ilo_class", FLEXIBLE, Memory(1), rate_gain=rate_gain, learning_gain=0.999 * edge)
    with pytest.raises(ValueError, match=r"learning_gain with rate_gain = .* must be stable"):
        make_observer("ilo_class", FLEXIBLE, Memory(1), rate_gain=rate_gain, learning_gain=1.001 * edge)


@pytest.mark.parametrize(
    ("gains", "message"),
    [
        ({"rate_gain": 25.0}, "must be stable"),
        ({"rate_gain": 0.0}, "rate_gain must be positive"),
        ({"learning_gain": -1.0}, "learning_gain must be positive"),
        ({"forgetting": 0.0}, r"forgetting must lie within \(0, 1\]"),
        ({"forgetting": 1.1}, r"forgetting must lie within \(0, 1\]"),
    ],
)
def test_gains_of_the_learning_observer_are_checked(gains, message):
    with pytest.raises(ValueError, match=message):
        make_observer("ilo_class", FLEXIBLE, Memory(1), **gains)
