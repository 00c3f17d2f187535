"""Recordings of recordings, and the measures of them."""

from dataclasses import replace

import numpy as np
import pytest

from ftac_gym import scenarios
from ftac_gym.attitude import angle_between, quaternion_from_mrp
from ftac_gym.evaluation import rollout
from ftac_gym.reproduction.recorder import record
from ftac_gym.reproduction.recordings import Plan
from ftac_gym.reproduction.variations import sampled, with_limit
from ftac_gym.reproduction.wording import settled

CAO = sampled(scenarios.get("cao_2022"), 0.05, 12.0)


@pytest.fixture(scope="module")
def recording():
    return record(Plan(CAO, "ptc", {"layer": 0.1}))


def test_a_recording_is_the_rollout_of_the_same_policy(recording):
    history = rollout(CAO, "tsmc_class", seed=0, count=1)
    other = record(Plan(CAO, "tsmc_class"))
    assert np.allclose(other.error, np.degrees(history.attitude_error), atol=1e-9)
    assert np.allclose(other.command, history.command, atol=1e-9)
    assert np.allclose(other.rate, history.rate, atol=1e-12)


def test_errors_are_the_angle_between_attitude_and_reference(recording):
    angle = angle_between(quaternion_from_mrp(recording.attitude), quaternion_from_mrp(recording.reference))
    assert np.allclose(recording.error, np.degrees(angle), atol=1e-6)


def test_the_truth_is_that_of_the_scenario(recording):
    time = recording.time[:-1]
    third = np.where(time >= 10.0 - 1e-9, 0.4 + 0.05 * np.cos(0.25 * time), 1.0)
    assert np.allclose(recording.true_effectiveness[:, 0, 2], third)
    assert np.allclose(recording.true_effectiveness[:, 0, 0], np.where(time >= 5.0 - 1e-9, 0.8, 1.0))
    assert not recording.true_bias.any()


def test_settling_is_the_last_time_outside(recording):
    made = replace(recording, error=np.where(recording.time < 7.0, 3.0, 0.01)[:, None])
    assert made.settling(0.1) == pytest.approx(7.0)
    assert settled(made) == "7.0 s"
    assert made.settling(5.0) == 0.0
    assert made.settling(0.001) == np.inf
    assert settled(made, 0.001) == "never"
    assert made.steady(2.0) == pytest.approx(0.01)
    assert made.steady(6.0) == pytest.approx(3.0)


def test_an_error_that_is_not_a_number_never_settles(recording):
    assert replace(recording, error=np.full_like(recording.error, np.nan)).settling(0.1) == np.inf


def test_estimates_of_an_observer_and_of_none(recording):
    assert recording.effectiveness.shape == recording.command.shape
    assert recording.bias is None
    assert (recording.estimate_error(1.0) <= 1.0).all()
    with pytest.raises(ValueError, match="effectiveness must have been estimated"):
        record(Plan(sampled(CAO, 0.05, 1.0), "ptc_no_observer")).estimate_error()


def test_an_oracle_estimates_the_truth():
    exact = record(Plan(sampled(CAO, 0.05, 6.0), "ptc_oracle"))
    assert np.array_equal(exact.effectiveness, exact.true_effectiveness)


def test_variations_change_what_they_say():
    strong = with_limit(CAO, 3.0)
    assert strong.spacecraft.wheels.torque_limits.tolist() == [3.0, 3.0, 3.0]
    slow = sampled(CAO, 0.2, 4.0)
    assert (slow.control_period, slow.physics_step, slow.duration) == (0.2, 0.01, 4.0)
    assert record(Plan(with_limit(sampled(CAO, 0.05, 1.0), 0.5), "ptc")).saturated() > 0.5


def test_energy_is_that_of_the_torques_the_wheels_apply(recording):
    applied = recording.true_effectiveness[:, 0] * recording.command[:, 0]
    each = (applied**2).sum(axis=1) * CAO.control_period
    spent = recording.spent()
    assert spent.shape == recording.time.shape and spent[0] == 0.0
    assert recording.energy() == spent[-1] == pytest.approx(each.sum())
    assert recording.energy(6.0) == pytest.approx(each[recording.time[:-1] < 6.0 - 1e-9].sum())
    assert recording.energy(0.0) == 0.0


def test_speed_is_the_rate_in_degrees(recording):
    assert np.allclose(recording.speed(), np.degrees(np.sqrt((recording.rate[:, 0] ** 2).sum(axis=1))))


def test_a_plan_names_the_memory_that_is_recorded():
    """Gamma from the start to the end, and nothing else."""
    task = sampled(scenarios.get("ma_2023_faulty"), 0.05, 2.0)
    recorded = record(Plan(task, "hsfc", num_spacecraft=2, recorded=("gamma",)))
    gamma = recorded.memory["gamma"]
    assert set(recorded.memory) == {"gamma"} and gamma.shape == (41, 2, 1)
    assert (gamma[0] == 2.5).all() and (np.diff(gamma[:, 0, 0]) != 0.0).all()
    shorter = record(Plan(sampled(task, 0.05, 1.0), "hsfc", num_spacecraft=2, recorded=("gamma",)))
    assert np.array_equal(shorter.memory["gamma"], gamma[:21])
    assert not record(Plan(sampled(task, 0.05, 0.1), "hsfc")).memory
