"""The learning observer: the working form converges, the printed one does not."""

import numpy as np
import pytest
from helpers.observed import random_walk, sustained, task, watch

from ftac_gym.baselines import observers
from ftac_gym.baselines.memory import Memory
from ftac_gym.task.disturbances import Disturbance

HEALTHY = task(3, 0.01, faults=None)


@pytest.mark.parametrize(("wheels", "period"), [(3, 0.01), (3, 0.05), (4, 0.05)])
def test_sustained_torque_shows_the_true_effectiveness(wheels, period):
    """To 0.001 within 15 s from errors of up to 0.7, without a disturbance."""
    errors = []
    for simulator, _, estimate in watch(
        "lo_corrected", task(wheels, period), 6, round(15.0 / period), lambda time: sustained(time, wheels)
    ):
        errors.append(np.abs(estimate.effectiveness - simulator.truth().effectiveness).max())
    assert errors[0] > 0.4
    assert max(errors[-10:]) < 1e-3


def test_a_torque_that_it_does_not_know_counts_as_lost_effectiveness():
    """0.05 N m against 2 N m leave some percent of error, in the mean over the sinusoid of the command."""
    scenario = task(3, 0.05, disturbance=Disturbance((0.05, 0.05, 0.05)))
    errors = []
    for simulator, _, estimate in watch("lo_corrected", scenario, 6, 400, lambda time: sustained(time, 3)):
        errors.append(np.abs(estimate.effectiveness - simulator.truth().effectiveness))
    assert np.mean(errors[200:]) < 0.1
    assert np.max(errors[200:]) > 1e-3


def test_as_printed_it_sinks_and_reads_the_sign_of_the_command():
    """The leak l = 0.9 and the missing U: see the corrections of the paper's page."""
    low = []
    for _, _, estimate in watch("lo", task(3, 0.01), 6, 600, lambda time: sustained(time, 3)):
        low.append(estimate.effectiveness.min(axis=1))
    assert (np.array(low)[200:].mean(axis=0) < 0.05).all()
    # At rest, with nothing to learn, a healthy wheel is forgotten with a time constant of ten samples.
    *_, (_, _, estimate) = watch("lo", HEALTHY, 1, 31, lambda _: np.zeros(3))
    np.testing.assert_allclose(estimate.effectiveness, 0.9**30)
    # The mismatch of a weak wheel points against its torque: a negative command raises e^ instead of lowering it.
    for sign in (1.0, -1.0):
        *_, (simulator, _, estimate) = watch(
            "lo", task(3, 0.01), 6, 200, lambda _, sign=sign: np.full(3, 2.0 * sign), forgetting=1.0, switching=0.0
        )
        truth = simulator.truth().effectiveness
        assert (truth < 0.99).all()
        if sign > 0.0:
            np.testing.assert_allclose(estimate.effectiveness, truth, atol=0.25)  # it still swings
        else:
            np.testing.assert_array_equal(estimate.effectiveness, 1.0)


def test_the_working_form_holds_what_it_knows_at_rest():
    for _, memory, estimate in watch("lo_corrected", HEALTHY, 2, 40, lambda _: np.zeros(3)):
        np.testing.assert_array_equal(estimate.effectiveness, 1.0)
        np.testing.assert_array_equal(estimate.disturbance, 0.0)
        np.testing.assert_array_equal(memory["rate_mismatch"], 0.0)
    for _, _, estimate in watch("lo_corrected", HEALTHY, 2, 500, lambda time: sustained(time, 3)):
        assert estimate.effectiveness.min() > 0.99


def test_the_disturbance_is_what_keeps_it_on_the_rate():
    """A constant torque at rest: w~ settles where M w~ is that torque."""
    torque = (0.02, -0.03, 0.01)
    scenario = task(3, 0.05, faults=None, disturbance=Disturbance(torque))
    *_, (_, _, estimate) = watch("lo_corrected", scenario, 1, 200, lambda _: np.zeros(3))
    np.testing.assert_allclose(estimate.disturbance[0], torque, atol=5e-4)


@pytest.mark.parametrize("name", ["lo", "lo_corrected"])
def test_estimates_stay_within_their_bounds_whatever_happens(name):
    observer, reached = observers.make(name, HEALTHY, Memory(4), smallest=0.2), []
    for measurement in random_walk(HEALTHY, 4, 200):
        estimate = observer.update(measurement, measurement.last_command, 0.01)
        assert (estimate.effectiveness >= 0.2).all() and (estimate.effectiveness <= 1.0).all()
        assert np.isfinite(estimate.disturbance).all() and estimate.bias is None
        reached.append(estimate.effectiveness)
    assert np.min(reached) == 0.2 and np.max(reached[10:]) == 1.0


def test_a_number_is_a_gain_times_the_axes_or_the_inertia():
    axes, inertia = HEALTHY.spacecraft.wheels.axis_matrix, HEALTHY.spacecraft.inertia_matrix
    given = {"first": (0.7 * axes.T).tolist(), "second": (0.3 * axes.T).tolist(),
             "rate_gain": np.diag(1.5 * inertia).tolist()}  # fmt: skip
    ones = observers.make("lo_corrected", HEALTHY, Memory(2), first=0.7, second=0.3, rate_gain=1.5)
    others = observers.make("lo_corrected", HEALTHY, Memory(2), **given)
    for measurement in random_walk(HEALTHY, 2, 20, size=0.01):
        first, second = (observer.update(measurement, measurement.last_command, 0.01) for observer in (ones, others))
        np.testing.assert_allclose(first.effectiveness, second.effectiveness, rtol=1e-12)
        np.testing.assert_allclose(first.disturbance, second.disturbance, rtol=1e-12)


@pytest.mark.parametrize(
    ("gains", "message"),
    [
        ({"rate_gain": 0.0}, "rate_gain must be positive, got 0.0"),
        ({"rate_gain": (1.0, 2.0)}, "rate_gain must be a number or three"),
        ({"rate_gain": (1.0, 2.0, -1.0)}, "rate_gain must be positive, got -1.0"),
        ({"first": 0.0}, "first must be positive, got 0.0"),
        ({"first": [[1.0, 0.0, 0.0]] * 4}, "first must have one row for each of the 3 wheels, got '4 rows'"),
        ({"second": [[1.0, 0.0]] * 3}, "second must be 3 x 3"),
        ({"forgetting": 0.0}, r"forgetting must lie within \(0, 1\], got 0.0"),
        ({"forgetting": 1.1}, r"forgetting must lie within \(0, 1\], got 1.1"),
        ({"switching": -1.0}, "switching must not be negative, got -1.0"),
        ({"full_torque": 0.0}, "full_torque must be positive, got 0.0"),
        ({"smallest": 1.0}, r"smallest must lie within \(0, 1\), got 1.0"),
        ({"excitation_time": -1.0}, "excitation_time must be positive, got -1.0"),
    ],
)
def test_bad_gains(gains, message):
    with pytest.raises(ValueError, match=message):
        observers.make("lo_corrected", HEALTHY, Memory(1), **gains)


def test_the_printed_gains_are_for_three_wheels():
    with pytest.raises(ValueError, match="first must have one row for each of the 4 wheels, got '3 rows'"):
        observers.make("lo", task(4, 0.01), Memory(1))
