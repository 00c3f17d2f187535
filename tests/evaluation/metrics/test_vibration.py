"""Metrics of vibration against histories with closed forms, what rigid spacecraft have of them, and the tables."""

import dataclasses

import numpy as np
import pytest

from ftac_gym import scenarios
from ftac_gym.attitude import quaternion_from_rotation_vector, quaternion_product
from ftac_gym.evaluation import episode_metrics, evaluate, rollout, summarize, tabulate
from ftac_gym.evaluation.metrics import HIGHER_IS_BETTER, SHARES, UNITS, Rollout
from ftac_gym.evaluation.rows import TABLE_METRICS
from ftac_gym.evaluation.tables import metric_tables
from ftac_gym.task.scenario import SuccessCriterion

STEPS, PERIOD, LAST = 400, 0.1, 100
DEGREE = np.pi / 180.0
VIBRATION = ("jitter", "modal_energy", "residual_energy", "vibration_torque")
OF_MODES = VIBRATION[1:]
FLEXIBLE = scenarios.get("flexible").replace(
    duration=STEPS * PERIOD, success=SuccessCriterion(angle=DEGREE, rate=0.01, hold=LAST * PERIOD)
)
RIGID = scenarios.get("flagship").replace(duration=STEPS * PERIOD, success=FLEXIBLE.success)
TIME = np.arange(STEPS + 1) * PERIOD
REFERENCE = quaternion_from_rotation_vector(np.array([0.4, -1.2, 0.8]))


def history(scenario=FLEXIBLE, turn=None, eta=None, swing=None, rate=None, count=2):
    """Return a rollout of spacecraft at rest, apart from the arrays given: (T + 1, N, .), or broadcast to them."""
    modes = scenario.spacecraft.modes

    def table(values, width):
        filled = np.zeros((STEPS + 1, count, width))
        filled[:] = 0.0 if values is None else values
        return filled

    reference = np.tile(REFERENCE, (STEPS + 1, count, 1))
    error = quaternion_from_rotation_vector(table(turn, 3))
    return Rollout(
        scenario=scenario,
        episodes=scenario.draw(0, count),
        time=TIME,
        attitude_error=np.linalg.norm(table(turn, 3), axis=2),
        rate_error=np.zeros((STEPS + 1, count)),
        attitude=quaternion_product(reference, error),
        reference_attitude=reference,
        rate=table(rate, 3),
        wheel_momentum=np.zeros((STEPS + 1, count, 4)),
        command=np.zeros((STEPS, count, 4)),
        applied_torque=np.zeros((STEPS, count, 4)),
        reward=np.zeros((STEPS, count)),
        modal_displacement=table(eta, modes),
        modal_rate=table(swing, modes),
    )


def metric(name, **arguments):
    return episode_metrics(history(**arguments))[name]


# ------------------------------------------------------------------------------------------------------------- jitter


@pytest.mark.parametrize("scenario", [FLEXIBLE, RIGID], ids=["flexible", "rigid"])
def test_jitter_of_a_sine_is_its_root_mean_square(scenario):
    """Two whole turns within the last ten seconds, about an offset that is no jitter."""
    axis, size = np.array([0.6, 0.0, -0.8]), 0.02 * DEGREE
    swing = size * np.sin(2.0 * np.pi * TIME / 5.0)[:, None, None] * axis
    for offset in (0.0, 0.5 * DEGREE):
        turn = swing + offset * np.array([0.6, 0.0, -0.8])
        np.testing.assert_allclose(metric("jitter", scenario=scenario, turn=turn), 0.02 / np.sqrt(2.0), rtol=1e-9)


def test_jitter_adds_the_axes_and_counts_the_last_seconds_only():
    turn = np.zeros((STEPS + 1, 2, 3))
    turn[: STEPS + 1 - LAST] = 0.3  # the slew before
    phase = 2.0 * np.pi * TIME / 5.0
    turn[-LAST:, 0, 0] = 3e-4 * np.sin(phase[-LAST:])
    turn[-LAST:, 0, 1] = 4e-4 * np.cos(phase[-LAST:])
    expected = np.degrees(np.sqrt((9e-8 + 16e-8) / 2.0))
    np.testing.assert_allclose(metric("jitter", turn=turn), [expected, 0.0], rtol=1e-6, atol=1e-12)


def test_a_steady_error_is_no_jitter_and_the_sign_of_the_quaternion_is_none():
    assert metric("jitter", turn=(0.01, -0.02, 0.005)) == pytest.approx([0.0, 0.0], abs=1e-10)
    rolled = history(turn=(0.01, -0.02, 0.005))
    flipped = rolled.attitude * np.where(np.arange(STEPS + 1) % 2, 1.0, -1.0)[:, None, None]
    flipped = dataclasses.replace(rolled, attitude=flipped)
    assert episode_metrics(flipped)["jitter"] == pytest.approx([0.0, 0.0], abs=1e-10)


# ------------------------------------------------------------------------------------------------------------- energy


def test_energies_of_an_undamped_swing_are_constant():
    """eta = A sin(f t), eta' = A f cos(f t): energy A^2 f^2 / 2 at any time, with the true f of each spacecraft."""
    blank = history()
    frequency = np.sqrt(blank.episodes.modes["stiffness"])
    assert np.abs(frequency / FLEXIBLE.spacecraft.appendages.frequencies - 1.0).max() > 0.02
    size = np.array([[0.1, 0.2, 0.0, 0.05], [0.3, 0.0, 0.1, 0.0]])
    phase = frequency * TIME[:, None, None]
    eta, swing = size * np.sin(phase), size * frequency * np.cos(phase)
    metrics = episode_metrics(history(eta=eta, swing=swing))
    energy = 0.5 * (size**2 * frequency**2).sum(axis=1)
    np.testing.assert_allclose(metrics["residual_energy"], energy, rtol=1e-12)
    np.testing.assert_allclose(metrics["modal_energy"], energy * STEPS * PERIOD, rtol=1e-12)


def test_energy_that_decays():
    decay, energy = 0.1, np.exp(-0.1 * TIME)
    swing = np.zeros((STEPS + 1, 2, 4))
    swing[:, 0, 2] = np.sqrt(2.0 * energy)
    metrics = episode_metrics(history(swing=swing))
    total, late = (1.0 - np.exp(-decay * 40.0)) / decay, (np.exp(-decay * 30.0) - np.exp(-decay * 40.0)) / decay / 10.0
    np.testing.assert_allclose(metrics["modal_energy"], [total, 0.0], rtol=0.01)
    np.testing.assert_allclose(metrics["residual_energy"], [late, 0.0], rtol=0.01)


def test_residual_energy_is_that_of_the_last_seconds():
    swing = np.zeros((STEPS + 1, 2, 4))
    swing[: STEPS + 1 - LAST, :, 0] = 5.0
    swing[-LAST:, 1, 0] = 2.0
    metrics = episode_metrics(history(swing=swing))
    np.testing.assert_allclose(metrics["residual_energy"], [0.0, 2.0], rtol=1e-14)
    np.testing.assert_allclose(metrics["modal_energy"], np.array([0.0, 20.0]) + 12.5 * 30.0, rtol=1e-12)


# ------------------------------------------------------------------------------------------------------------- torque


def test_vibration_torque_of_a_swing():
    """Of one mode of a spacecraft at rest: |delta| times the root mean square of C eta' + K eta."""
    blank = history()
    modes = blank.episodes.modes
    beat, size = 2.0 * np.pi / 5.0, 0.1
    eta, swing = np.zeros((2, STEPS + 1, 2, 4))
    eta[:, :, 1], swing[:, :, 1] = size * np.sin(beat * TIME)[:, None], size * beat * np.cos(beat * TIME)[:, None]
    force = size * np.hypot(modes["stiffness"][:, 1], modes["damping"][:, 1] * beat) / np.sqrt(2.0)
    expected = force * np.linalg.norm(modes["coupling"][:, 1], axis=1)
    np.testing.assert_allclose(metric("vibration_torque", eta=eta, swing=swing), expected, rtol=1e-9)


def test_vibration_torque_of_a_turning_spacecraft_has_a_gyroscopic_part():
    blank = history()
    modes, rate, swing = blank.episodes.modes, np.array([0.3, -0.1, 0.2]), np.array([0.1, 0.2, -0.3, 0.4])
    for spacecraft, torque in enumerate(metric("vibration_torque", swing=swing, rate=rate)):
        delta, damping = modes["coupling"][spacecraft], np.diag(modes["damping"][spacecraft])
        expected = delta.T @ damping @ swing - np.cross(rate, delta.T @ swing)
        assert torque == pytest.approx(np.linalg.norm(expected), rel=1e-12)


# ----------------------------------------------------------------------------------------------------- rigid spacecraft


def test_rigid_spacecraft_have_jitter_and_no_modes():
    metrics = episode_metrics(history(RIGID, turn=(0.01, 0.0, 0.0)))
    for name in OF_MODES:
        assert metrics[name].shape == (2,) and np.isnan(metrics[name]).all()
    assert metrics["jitter"] == pytest.approx([0.0, 0.0], abs=1e-10)
    summary = summarize(metrics)
    assert all(np.isnan(summary[name]) for name in OF_MODES)


def test_names_and_units():
    assert [UNITS[name] for name in VIBRATION] == ["deg", "J s", "J", "N m"]
    assert list(episode_metrics(history())) == list(UNITS)
    assert set(VIBRATION) <= set(TABLE_METRICS)
    assert not set(VIBRATION) & (HIGHER_IS_BETTER | SHARES)


# ------------------------------------------------------------------------------------------------- flights and tables


@pytest.fixture(scope="module")
def evaluations():
    found = {}
    for scenario in (FLEXIBLE, RIGID):
        episodes = scenario.draw(1, 6)
        found[scenario.name] = [evaluate(scenario, law, episodes) for law in ("pd", "ptc")], episodes
    return found


def test_tables_show_vibration_for_flexible_spacecraft_only(evaluations):
    for name, (results, _) in evaluations.items():
        rows = tabulate(results, "pd", np.ones(6, dtype=bool))
        shown = [metric for metric in rows[0].estimates if metric in VIBRATION]
        assert shown == (list(VIBRATION) if name == FLEXIBLE.name else [])
        assert [list(row.estimates) for row in rows[1:]] == [list(rows[0].estimates)]
        estimates, _ = metric_tables(rows, "pd")
        text = str(estimates)
        assert ("vibration" in text) == ("jitter" in text) == (name == FLEXIBLE.name)


def test_a_flight_keeps_the_modes(evaluations):
    results, episodes = evaluations[FLEXIBLE.name]
    flown = rollout(FLEXIBLE, "pd", episodes)
    assert flown.modal_displacement.shape == flown.modal_rate.shape == (STEPS + 1, 6, 4)
    assert not flown.modal_displacement[0].any() and np.abs(flown.modal_displacement[-1]).min() > 0.0
    assert flown.modal_energy.shape == (STEPS + 1, 6) and flown.vibration_torque.shape == (STEPS + 1, 6, 3)
    metrics = flown.metrics()
    for name in VIBRATION:
        np.testing.assert_array_equal(metrics[name], results[0].metrics[name])
        assert np.all(metrics[name] > 0.0)
    # A slice of the episodes flies the same.
    again = rollout(FLEXIBLE, "pd", episodes[2:4])
    np.testing.assert_array_equal(again.modal_rate, flown.modal_rate[:, 2:4])
