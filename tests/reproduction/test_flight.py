"""Flights that are recorded whole, and what is read off them."""

from dataclasses import replace

import numpy as np
import pytest

from ftac_gym import scenarios
from ftac_gym.attitude import angle_between, quaternion_from_mrp
from ftac_gym.evaluation import rollout
from ftac_gym.reproduction.flight import Plan, fly
from ftac_gym.reproduction.variations import sampled, settled, with_limit

CAO = sampled(scenarios.get("cao_2022"), 0.05, 12.0)


@pytest.fixture(scope="module")
def flight():
    return fly(Plan(CAO, "ptc", {"layer": 0.1}))


def test_a_flight_is_the_rollout_of_the_same_policy(flight):
    history = rollout(CAO, "tsmc_class", seed=0, count=1)
    other = fly(Plan(CAO, "tsmc_class"))
    assert np.allclose(other.error, np.degrees(history.attitude_error), atol=1e-9)
    assert np.allclose(other.command, history.command, atol=1e-9)
    assert np.allclose(other.rate, history.rate, atol=1e-12)


def test_errors_are_the_angle_between_attitude_and_reference(flight):
    angle = angle_between(quaternion_from_mrp(flight.attitude), quaternion_from_mrp(flight.reference))
    assert np.allclose(flight.error, np.degrees(angle), atol=1e-6)


def test_the_truth_is_that_of_the_scenario(flight):
    time = flight.time[:-1]
    third = np.where(time >= 10.0 - 1e-9, 0.4 + 0.05 * np.cos(0.25 * time), 1.0)
    assert np.allclose(flight.true_effectiveness[:, 0, 2], third)
    assert np.allclose(flight.true_effectiveness[:, 0, 0], np.where(time >= 5.0 - 1e-9, 0.8, 1.0))
    assert not flight.true_bias.any()


def test_settling_is_the_last_time_outside(flight):
    made = replace(flight, error=np.where(flight.time < 7.0, 3.0, 0.01)[:, None])
    assert made.settling(0.1) == pytest.approx(7.0)
    assert settled(made) == "7.0 s"
    assert made.settling(5.0) == 0.0
    assert made.settling(0.001) == np.inf
    assert settled(made, 0.001) == "never"
    assert made.steady(2.0) == pytest.approx(0.01)
    assert made.steady(6.0) == pytest.approx(3.0)


def test_an_error_that_is_not_a_number_never_settles(flight):
    assert replace(flight, error=np.full_like(flight.error, np.nan)).settling(0.1) == np.inf


def test_estimates_of_an_observer_and_of_none(flight):
    assert flight.effectiveness.shape == flight.command.shape
    assert flight.bias is None
    assert (flight.estimate_error(1.0) <= 1.0).all()
    with pytest.raises(ValueError, match="effectiveness must have been estimated"):
        fly(Plan(sampled(CAO, 0.05, 1.0), "ptc_no_observer")).estimate_error()


def test_an_oracle_knows_the_truth():
    known = fly(Plan(sampled(CAO, 0.05, 6.0), "ptc_oracle"))
    assert np.array_equal(known.effectiveness, known.true_effectiveness)


def test_variations_change_what_they_say():
    strong = with_limit(CAO, 3.0)
    assert strong.spacecraft.wheels.torque_limits.tolist() == [3.0, 3.0, 3.0]
    slow = sampled(CAO, 0.2, 4.0)
    assert (slow.control_period, slow.physics_step, slow.duration) == (0.2, 0.01, 4.0)
    assert fly(Plan(with_limit(sampled(CAO, 0.05, 1.0), 0.5), "ptc")).saturated() > 0.5


def test_energy_is_that_of_the_torques_the_wheels_apply(flight):
    applied = flight.true_effectiveness[:, 0] * flight.command[:, 0]
    each = (applied**2).sum(axis=1) * CAO.control_period
    spent = flight.spent()
    assert spent.shape == flight.time.shape and spent[0] == 0.0
    assert flight.energy() == spent[-1] == pytest.approx(each.sum())
    assert flight.energy(6.0) == pytest.approx(each[flight.time[:-1] < 6.0 - 1e-9].sum())
    assert flight.energy(0.0) == 0.0


def test_speed_is_the_rate_in_degrees(flight):
    assert np.allclose(flight.speed(), np.degrees(np.sqrt((flight.rate[:, 0] ** 2).sum(axis=1))))


def test_a_plan_keeps_what_it_asks_for_of_the_laws_memory():
    """Gamma at the start, and what the law has at the end; nothing else is kept."""
    task = sampled(scenarios.get("ma_2023_faulty"), 0.05, 2.0)
    kept = fly(Plan(task, "hsfc", craft=2, kept=("gamma",)))
    gamma = kept.memory["gamma"]
    assert set(kept.memory) == {"gamma"} and gamma.shape == (41, 2, 1)
    assert (gamma[0] == 2.5).all() and (np.diff(gamma[:, 0, 0]) != 0.0).all()
    shorter = fly(Plan(sampled(task, 0.05, 1.0), "hsfc", craft=2, kept=("gamma",)))
    assert np.array_equal(shorter.memory["gamma"], gamma[:21])
    assert not fly(Plan(sampled(task, 0.05, 0.1), "hsfc")).memory
