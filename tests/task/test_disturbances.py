"""Tests of `ftac_gym.task.disturbances`: the drawn torque as a function of time, its ranges and its rules."""

import numpy as np
import pytest
from scipy import stats

from ftac_gym.task import Disturbance, Harmonic

AXES = ((0.1, 0.2), (-0.3, 0.3), 0.5)


def deviates(disturbance, count=2000, seed=0):
    return np.random.default_rng(seed).random((count, disturbance.uniform_count))


def torque(steady, harmonics, time):
    """Evaluate drawn records (N,), (N, K) at a time: (N, 3)."""
    angle = harmonics["frequency"][..., None] * time
    return steady["constant"] + (harmonics["sine"] * np.sin(angle) + harmonics["cosine"] * np.cos(angle)).sum(axis=1)


def test_fixed_disturbance_is_the_documented_function_of_time():
    disturbance = Disturbance(
        constant=(0.01, -0.02, 0.03),
        harmonics=(
            Harmonic((0.1, 0.2, 0.3), frequency=0.7, phase=(0.0, 1.0, -2.0)),
            Harmonic((0.05, -0.04, 0.0), frequency=3.0, phase=(0.5, 0.6, 0.7)),
        ),
    )
    steady, harmonics = disturbance.draw(deviates(disturbance, 3))
    assert steady.shape == (3,) and harmonics.shape == (3, 2)
    for time in (0.0, 1.3, 77.7):
        expected = (
            np.array([0.01, -0.02, 0.03])
            + np.array([0.1, 0.2, 0.3]) * np.sin(0.7 * time + np.array([0.0, 1.0, -2.0]))
            + np.array([0.05, -0.04, 0.0]) * np.sin(3.0 * time + np.array([0.5, 0.6, 0.7]))
        )
        np.testing.assert_allclose(torque(steady, harmonics, time), np.tile(expected, (3, 1)), atol=1e-15)


def test_constant_torque_is_uniform_in_its_intervals():
    disturbance = Disturbance(AXES)
    constant = disturbance.draw(deviates(disturbance))[0]["constant"]
    assert stats.kstest(constant[:, 0], "uniform", (0.1, 0.1)).pvalue > 1e-3
    assert stats.kstest(constant[:, 1], "uniform", (-0.3, 0.6)).pvalue > 1e-3
    assert np.all(constant[:, 2] == 0.5)


def test_harmonics_draw_amplitude_frequency_and_phase_independently():
    turn = (0.0, 2.0 * np.pi)
    harmonic = Harmonic(((0.1, 0.2),) * 3, frequency=(0.5, 1.5), phase=(turn,) * 3)
    disturbance = Disturbance(harmonics=(harmonic, harmonic))
    table = disturbance.draw(deviates(disturbance))[1]
    amplitude = np.hypot(table["sine"], table["cosine"])
    phase = np.arctan2(table["cosine"], table["sine"]) % (2.0 * np.pi)
    drawn = np.concatenate([amplitude.reshape(2000, -1), phase.reshape(2000, -1), table["frequency"]], axis=1)
    ranges = [(0.1, 0.1)] * 6 + [(0.0, 2.0 * np.pi)] * 6 + [(0.5, 1.0)] * 2
    for column, (low, width) in zip(drawn.T, ranges, strict=True):
        assert stats.kstest(column, "uniform", (low, width)).pvalue > 1e-3
    correlation = np.corrcoef(drawn.T) - np.eye(14)
    assert np.abs(correlation).max() < 0.1


def test_no_harmonics_make_an_empty_table():
    disturbance = Disturbance((0.1, 0.1, 0.1))
    assert disturbance.draw(deviates(disturbance, 4))[1].shape == (4, 0)


def test_scaling_with_the_rate_is_recorded_even_for_a_zero_offset():
    for offset, flag in ((None, 0.0), (0.0, 1.0), (0.3, 1.0)):
        disturbance = Disturbance(AXES, rate_offset=offset)
        steady = disturbance.draw(deviates(disturbance, 2))[0]
        assert np.all(steady["rate_scaled"] == flag)
        assert np.all(steady["rate_offset"] == (offset or 0.0))


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: Disturbance(constant=(0.1, 0.2)), "constant must have three entries"),
        (lambda: Disturbance(constant=0.1), "constant must have three entries"),
        (lambda: Disturbance(constant=(0.1, (0.2, 0.1), 0.0)), r"constant\[1\] must have low <= high"),
        (lambda: Disturbance(constant=(0.1, (0.1, 0.2, 0.3), 0.0)), r"constant\[1\] must be a number or a pair"),
        (lambda: Disturbance(constant=(0.1, 0.1, float("nan"))), r"constant\[2\] must be finite"),
        (lambda: Disturbance(constant=(0.1, 0.1, "x")), r"constant\[2\] must be a number"),
        (lambda: Disturbance(rate_offset=-0.1), "rate_offset must not be negative"),
        (lambda: Disturbance(harmonics=(1.0,)), "harmonics must"),
        (lambda: Harmonic((0.1, 0.1), 1.0), "amplitude must have three entries"),
        (lambda: Harmonic((0.1,) * 3, (2.0, 1.0)), "frequency must have low <= high"),
        (lambda: Harmonic((0.1,) * 3, float("inf")), "frequency must be finite"),
        (lambda: Harmonic((0.1,) * 3, 1.0, 0.0), "phase must have three entries"),
        (lambda: Harmonic(None, 1.0), "amplitude must have three entries"),
    ],
)
def test_rules(build, message):
    with pytest.raises(ValueError, match=message):
        build()
