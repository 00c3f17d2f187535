"""Errors of estimates against histories made by hand."""

from dataclasses import replace

import numpy as np
import pytest

from ftac_gym import scenarios
from ftac_gym.baselines import FaultEstimate
from ftac_gym.evaluation import rollout
from ftac_gym.evaluation.diagnosis.errors import squared_errors
from ftac_gym.faults import Bias, FaultSchedule, LossOfEffectiveness

FLAGSHIP = scenarios.get("flagship").replace(duration=6.0, loop_delay=0.0)
AXES = FLAGSHIP.spacecraft.wheels.axis_matrix


@pytest.fixture(scope="module")
def weak():
    """Return two episodes in which wheel 1 has half of its torque from 2 s on."""
    task = FLAGSHIP.replace(faults=FaultSchedule((LossOfEffectiveness(wheel=1, effectiveness=0.5, onset=2.0),)))
    return rollout(task, "nftsm_observer", count=2, estimates=True)


@pytest.fixture(scope="module")
def biased():
    task = FLAGSHIP.replace(faults=FaultSchedule((Bias(wheel=2, constant=0.04, onset=2.0),)))
    return rollout(task, "nftsm_observer", count=2, estimates=True)


def judged(history, **parts):
    """Return root mean square errors of given estimates, those of healthy wheels, and the numbers of values."""
    sums = squared_errors(replace(history, estimates=FaultEstimate(**parts)))
    return {
        name: (np.sqrt(item.estimated / item.number), np.sqrt(item.healthy / item.number), item.number)
        for name, item in sums.items()
    }


def test_effectiveness_errs_where_it_can_be_identified(weak):
    steps, healthy = len(weak.command), np.ones(weak.command.shape)
    known = np.zeros(healthy.shape, dtype=bool)
    known[10:, :, 1] = True  # 40 periods with the fault, and 10 before it
    own, without, number = judged(weak, effectiveness=healthy, identifiable=known)["effectiveness"]
    np.testing.assert_array_equal(number, steps - 10)
    np.testing.assert_allclose(own, 0.5 * np.sqrt(40 / 50))
    np.testing.assert_array_equal(own, without)
    known[10:20] = False
    own, without, _ = judged(weak, effectiveness=healthy * 0.6, identifiable=known)["effectiveness"]
    np.testing.assert_allclose((own, without), [[0.1] * 2, [0.5] * 2])


def test_biases_that_cancel_on_the_body_are_no_error(biased):
    given = np.zeros(biased.command.shape)
    given[20:, :, 2] = 0.04
    null = 0.03 * np.linalg.svd(AXES)[2][-1]
    ones = np.ones(given.shape)
    own, without, number = judged(biased, effectiveness=ones, bias=given + null)["bias"]
    np.testing.assert_allclose(own, 0.0, atol=1e-15)
    # A single wheel turns the body by three quarters of its square: D+ D projects onto three of four dimensions.
    np.testing.assert_allclose(without, 0.04 * np.sqrt(0.75 * 40 / 60 / 4))
    np.testing.assert_array_equal(number, given[:, 0].size)


def test_the_torque_on_the_body_is_that_of_all_parts(weak):
    effectiveness = np.ones(weak.command.shape)
    effectiveness[20:, :, 1] = 0.5
    own, without, number = judged(weak, effectiveness=effectiveness)["torque"]
    # The estimate at a measurement is of the period before it, which the fault meets one row later.
    late = np.zeros((len(weak.command), 2, 3))
    late[20] = -0.5 * weak.command[19, :, 1:2] * AXES[:, 1]
    np.testing.assert_allclose(own, np.sqrt((late**2).sum(axis=(0, 2)) / len(late)), atol=1e-7)
    assert (without > 5.0 * own).all() and (number == len(late)).all()
    body = (effectiveness - 1.0)[1:] * weak.command[:-1] @ AXES.T
    same = judged(weak, disturbance=np.concatenate([np.zeros((1, 2, 3)), body]))
    assert list(same) == ["torque"]
    np.testing.assert_allclose(same["torque"][0], own, atol=1e-12)


def test_flags_alone_have_no_errors(weak):
    assert judged(weak, alarm=np.zeros(weak.command.shape, dtype=bool)) == {}


def test_without_effectiveness_a_bias_is_all_that_the_command_does_not_explain(weak):
    missing = np.zeros(weak.command.shape)
    missing[21:, :, 1] = -0.5 * weak.command[20:-1, :, 1]
    own, without, _ = judged(weak, bias=missing)["bias"]
    np.testing.assert_allclose(own, 0.0, atol=1e-9)
    assert (without > 1e-3).all()
