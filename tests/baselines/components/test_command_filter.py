"""The command filter: a differentiator if its steps are short, and not if they are long."""

import numpy as np
import pytest

from ftac_gym.baselines.components.command_filter import LevantFilter
from ftac_gym.baselines.memory import Memory

FREQUENCY = np.array([0.5, 0.8, 1.1])  # rad/s
SIZE = np.array([[0.5, 0.3, 0.2], [0.1, 0.4, 0.6]])
"""|a''| is at most 0.73, well below b2 = 4."""


def wave(time):
    """The input and its derivative (2, 3); it starts away from zero."""
    angle = FREQUENCY * time + 0.7
    return SIZE * np.sin(angle), SIZE * FREQUENCY * np.cos(angle)


def follow(period, substeps, duration=6.0, **changes):
    """Return the errors of f1 and f1' (T, 2, 3) and the times, for a wave that is held over each period."""
    follower = LevantFilter(Memory(2), 3.0, 4.0, period, substeps, **changes)
    times = np.arange(round(duration / period)) * period
    values, rates = [], []
    for time in times:
        command, slope = wave(time)
        values.append(follower.output(command) - command)
        rates.append(follower.rate(command) - slope)
        for _ in range(substeps):
            follower.advance(command)
    return np.array(values), np.array(rates), times


def test_converges_to_the_input_and_its_derivative_in_finite_time():
    """After 2 s it is there and stays, with errors in proportion to the square of the step and to the step."""
    largest = {}
    for period in (4e-3, 1e-3):
        values, rates, times = follow(period, 1)
        settled = times > 2.0
        assert np.abs(values[0]).max() > 0.1 and np.abs(rates[0]).max() > 0.1
        largest[period] = np.abs(values[settled]).max(), np.abs(rates[settled]).max()
    assert largest[1e-3][0] < 2e-5 and largest[1e-3][1] < 0.02
    assert largest[1e-3][0] < largest[4e-3][0] / 10.0 and largest[1e-3][1] < largest[4e-3][1] / 3.0


def test_one_step_of_a_tenth_of_a_second_does_not():
    """It chatters: its derivative is wrong by as much as the derivative is large."""
    values, rates, times = follow(0.1, 1)
    settled = times > 2.0
    assert np.abs(rates[settled]).max() > 0.6 * np.abs(SIZE * FREQUENCY).max()
    assert np.abs(values[settled]).max() > 0.03


def test_substeps_follow_a_held_input():
    """To the square of the sub-step, however long the hold; what changes between two holds is a lag of one."""
    left = {}
    for substeps in (1, 10, 100):
        follower, command = LevantFilter(Memory(2), 3.0, 4.0, 0.1, substeps), SIZE
        for _ in range(100):
            for _ in range(substeps):
                follower.advance(command)
        seen = []
        for _ in range(3 * substeps):
            follower.advance(command)
            seen.append(np.abs(follower.output(command) - command).max())
        left[substeps] = max(seen)
    assert left[1] > 0.01 and left[10] < left[1] / 30.0 and left[100] < left[10] / 30.0
    values, _, times = follow(0.1, 100)
    assert np.abs(values[times > 2.0]).max() < 0.1 * np.abs(SIZE * FREQUENCY).max()


def test_follows_the_equations():
    """f1' = -b1 |f1 - a|^(1/2) sgn(f1 - a) + f2, f2' = -b2 sgn(f1 - a), by Euler steps of the period's share."""
    random, follower = np.random.default_rng(0), LevantFilter(Memory(2), 3.0, 4.0, 0.05, 5)
    first, second = np.zeros((2, 3)), np.zeros((2, 3))
    for _ in range(20):
        command = random.normal(size=(2, 3))
        for _ in range(5):
            slope = -3.0 * np.sqrt(np.abs(first - command)) * np.sign(first - command) + second
            np.testing.assert_allclose(follower.output(command), first, atol=1e-12)
            np.testing.assert_allclose(follower.rate(command), slope, atol=1e-12)
            second = second - 0.01 * 4.0 * np.sign(first - command)
            first = first + 0.01 * slope
            follower.advance(command)


def test_starts():
    """At zero, or at the first input, from which it need not come."""
    command = np.array([[0.4, -0.2, 0.1], [0.0, 0.3, -0.7]])
    at_zero, at_input = (LevantFilter(Memory(2), 3.0, 4.0, 0.01, 1, at_input=at_input) for at_input in (False, True))
    np.testing.assert_array_equal(at_zero.output(command), 0.0)
    np.testing.assert_allclose(at_zero.rate(command), 3.0 * np.sqrt(np.abs(command)) * np.sign(command), rtol=1e-15)
    for _ in range(3):
        np.testing.assert_array_equal(at_input.output(command), command)
        np.testing.assert_array_equal(at_input.rate(command), 0.0)
        at_input.advance(command)
    # Once started it is not taken along with the input any more.
    np.testing.assert_array_equal(at_input.output(2.0 * command), command)


def test_looking_does_not_start_it():
    follower = LevantFilter(Memory(1), 3.0, 4.0, 0.01, 1, at_input=True)
    first, second = np.full((1, 3), 0.5), np.full((1, 3), -0.2)
    np.testing.assert_array_equal(follower.output(first), first)
    np.testing.assert_array_equal(follower.output(second), second)


@pytest.mark.parametrize("at_input", [False, True])
def test_a_reset_starts_the_chosen_craft_again(at_input):
    memory, command = Memory(2), np.full((2, 3), 0.5)
    follower = LevantFilter(memory, 3.0, 4.0, 0.01, 1, at_input)
    for _ in range(10):
        follower.advance(command)
    kept = follower.output(-command)[1]
    memory.reset(np.array([True, False]))
    output = follower.output(-command)
    np.testing.assert_array_equal(output[0], -command[0] if at_input else 0.0)
    np.testing.assert_array_equal(output[1], kept)
    assert (kept > 0.1).all()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"first": 0.0}, r"^first must be positive, got 0\.0"),
        ({"second": np.inf}, "^second must be finite, got inf"),
        ({"substeps": 0}, "^substeps must be a whole number, 1 or more, got 0"),
        ({"substeps": -1}, "^substeps must be a whole number, 1 or more, got -1"),
        ({"substeps": 2.0}, r"^substeps must be a whole number, 1 or more, got 2\.0"),
        ({"substeps": True}, "^substeps must be a whole number, 1 or more, got True"),
    ],
)
def test_bad_parameters(changes, message):
    with pytest.raises(ValueError, match=message):
        LevantFilter(Memory(1), **{"first": 3.0, "second": 4.0, "period": 0.1, "substeps": 1, **changes})
