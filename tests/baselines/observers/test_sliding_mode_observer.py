"""The sliding-mode fault observer: its two phases, what it converges to, and what it never does."""

import numpy as np
import pytest
from helpers.observed import random_walk, seen, sustained, task, watch

from ftac_gym import scenarios
from ftac_gym.baselines import observers
from ftac_gym.baselines.memory import Memory
from ftac_gym.faults import Bias, FaultSchedule
from ftac_gym.task.disturbances import Disturbance, Harmonic
from ftac_gym.task.initial_state import InitialState

HEALTHY = task(4, 0.02, faults=None)
PUSHED = Disturbance((0.1, 0.1, 0.1), (Harmonic((0.1, 0.3, 0.5), 1.0),))


@pytest.mark.parametrize(("wheels", "gain"), [(3, 2000.0), (4, 4000.0)])
def test_sustained_torque_shows_the_true_effectiveness(wheels, gain):
    """To 0.01 in 20 s from errors of up to 0.7; every wheel counts as identifiable much of the time."""
    errors, flags = [], []
    for simulator, _, estimate in watch(
        "asmo", task(wheels, 0.05), 6, 400, lambda time: sustained(time, wheels), effectiveness_gain=gain, bias_gain=0.0
    ):
        errors.append(np.abs(estimate.effectiveness - simulator.truth().effectiveness).max())
        flags.append(estimate.identifiable)
    assert errors[0] > 0.5
    assert max(errors[-20:]) < 0.01
    assert (np.mean(flags, axis=0) > 0.5).all()


def test_the_printed_gains_learn_next_to_nothing():
    """g1 = 0.5 in the same 20 s."""
    *_, (simulator, _, estimate) = watch("asmo_printed", task(4, 0.05), 6, 400, lambda time: sustained(time, 4))
    assert (1.0 - estimate.effectiveness < 0.05 * (1.0 - simulator.truth().effectiveness) + 1e-3).all()


def test_biases_are_seen_modulo_the_null_space():
    bias = np.array([0.06, -0.04, 0.0, 0.03])
    scenario = task(4, 0.05, FaultSchedule(tuple(Bias(wheel=w, constant=b) for w, b in enumerate(bias) if b)))
    *_, (_, _, estimate) = watch("asmo", scenario, 1, 600, lambda _: np.zeros(4), bias_gain=3000.0)
    axes = scenario.spacecraft.wheels.axis_matrix
    np.testing.assert_allclose(axes @ estimate.bias[0], axes @ bias, atol=2e-3)
    np.testing.assert_allclose(estimate.bias[0], np.linalg.pinv(axes) @ axes @ bias, atol=2e-3)
    np.testing.assert_array_equal(estimate.effectiveness, 1.0)  # no command, no news
    assert not estimate.identifiable.any()


@pytest.mark.parametrize("name", ["asmo", "asmo_printed"])
def test_without_faults_nothing_is_found(name):
    for _, memory, estimate in watch(name, HEALTHY, 2, 50, lambda _: np.zeros(4)):
        np.testing.assert_array_equal(estimate.effectiveness, 1.0)
        np.testing.assert_array_equal(estimate.bias, 0.0)
        np.testing.assert_array_equal(estimate.disturbance, 0.0)
        np.testing.assert_array_equal(memory["rate_mismatch"], 0.0)
    for _, _, estimate in watch(name, HEALTHY, 2, 500, lambda time: sustained(time, 4)):
        assert estimate.effectiveness.min() > 0.97
        assert np.abs(estimate.bias).max() < 0.03


def test_phases_of_the_switching_gain():
    """From a wrong rate K_a grows, by (17), until |w~|_1 is below the barrier; then (18) holds it there."""
    barrier, period, growth = 0.05, 1e-3, 0.1
    scenario = task(4, period, faults=None, disturbance=PUSHED, initial_state=InitialState.fixed(rate=(0.5, -0.6, 0.4)))
    inverse_norm = np.linalg.norm(np.linalg.inv(scenario.spacecraft.inertia_matrix), 2)
    sizes, gains, inside = [], [], []
    for _, memory, _ in watch(
        "asmo", scenario, 1, 4000, lambda _: np.zeros(4), know_rate=False, switching_gain=growth, layer=1e-3
    ):
        sizes.append(np.abs(memory["rate_mismatch"]).sum())
        gains.append(memory["adaptive_switching"][0, 0])
        inside.append(bool(memory["inside_barrier"][0, 0]))
    sizes, gains = np.array(sizes), np.array(gains)
    entry = inside.index(True)
    assert sizes[0] == pytest.approx(1.5) and 100 < entry < 3000
    assert not any(inside[:entry]) and all(inside[entry:])
    assert (sizes[:entry] >= barrier).all() and (sizes[entry:] < barrier).all()
    np.testing.assert_allclose(np.diff(gains[:entry]), period * growth * inverse_norm * sizes[1:entry], rtol=1e-9)
    assert (gains[entry:] == gains[entry]).all()  # K_a is done


@pytest.mark.parametrize("printed", [False, True])
def test_the_barrier_is_none_as_printed(printed):
    """A push of 1 N m, ten times what (18) with w~'w~ can hold at the barrier; without other help."""
    push = Disturbance((1.0, 1.0, 1.0))
    scenario = task(4, 1e-3, faults=None, disturbance=push)
    sizes = [
        np.abs(memory["rate_mismatch"]).sum()
        for _, memory, _ in watch(
            "asmo", scenario, 1, 3000, lambda _: np.zeros(4), rate_gain=0.01, effectiveness_gain=0.0, bias_gain=0.0,
            printed_barrier=printed, layer=1e-3,
        )
    ]  # fmt: skip
    assert (max(sizes) < 0.05) != printed


def test_the_rate_is_known_from_the_start_unless_told_otherwise():
    scenario = task(4, 0.02, faults=None, initial_state=InitialState.fixed(rate=(0.5, -0.6, 0.4)))
    for know in (True, False):
        _, memory, _ = next(watch("asmo", scenario, 1, 1, lambda _: np.zeros(4), know_rate=know))
        np.testing.assert_array_equal(memory["rate_estimate"][0], (0.5, -0.6, 0.4) if know else 0.0)


@pytest.mark.parametrize("name", ["asmo", "asmo_printed"])
def test_estimates_stay_within_their_bounds_whatever_happens(name):
    memory = Memory(4)
    observer = observers.make(name, HEALTHY, memory, smallest=0.2, effectiveness_gain=1e4)
    reached = []
    for measurement in random_walk(HEALTHY, 4, 200):
        estimate = observer.update(measurement, measurement.last_command, 0.02)
        assert (estimate.effectiveness >= 0.2).all() and (estimate.effectiveness <= 1.0).all()
        assert np.isfinite(estimate.bias).all() and np.isfinite(estimate.disturbance).all()
        reached.append(estimate.effectiveness)
    assert np.min(reached) == 0.2 and np.max(reached[10:]) == 1.0


@pytest.mark.parametrize(
    ("command", "expected"),
    [
        (lambda time: np.array([1.0, 0.2, -1.0, 0.0]), (True, False, True, False)),
        (lambda time: np.array([5.0, -5.0, 5.0, 5.0]) * (-1.0) ** round(time / 0.02), (False,) * 4),
    ],
    ids=["sustained", "chatter"],
)
def test_identifiable_are_wheels_with_sustained_torque(command, expected):
    """Above 5 % of 5 N m for some two seconds."""
    flags = [estimate.identifiable[0] for _, _, estimate in watch("asmo", HEALTHY, 1, 500, command)]
    np.testing.assert_array_equal(flags[0], False)
    np.testing.assert_array_equal(flags[-1], expected)
    first = np.argmax(np.array(flags)[:, 0]) * 0.02 if expected[0] else None
    assert first is None or first == pytest.approx(-2.0 * np.log(1.0 - 0.25), abs=0.03)


@pytest.mark.parametrize("name", observers.names())
def test_a_batch_equals_single_observers_and_resets_by_mask(name):
    scenario = task(3, 0.02, faults=None)
    if name == "fafeo":  # needs something that bends
        scenario = scenarios.get("li_2023").replace(faults=None, control_period=0.02, physics_step=0.02)
    together, alone = Memory(3), [Memory(1) for _ in range(3)]
    batch = observers.make(name, scenario, together)
    singles = [observers.make(name, scenario, memory) for memory in alone]
    for step, measurement in enumerate(random_walk(scenario, 3, 60, size=0.01)):
        if step == 30:
            together.reset(np.array([False, True, False]))
            alone[1].reset(np.array([True]))
        estimate = batch.update(measurement, measurement.last_command, 0.02)
        for index, single in enumerate(singles):
            row = seen(measurement.rate[[index]], measurement.last_command[[index]])
            other = single.update(row, row.last_command, 0.02)
            for part in ("effectiveness", "bias", "disturbance", "vibration", "identifiable"):
                if getattr(estimate, part) is not None:
                    np.testing.assert_allclose(getattr(estimate, part)[index], getattr(other, part)[0], atol=1e-12)
        if step == 30 and estimate.effectiveness is not None:
            np.testing.assert_array_equal(estimate.effectiveness[1], 1.0)


@pytest.mark.parametrize(
    ("gains", "message"),
    [
        ({"rate_gain": 0.0}, "rate_gain must be positive, got 0.0"),
        ({"effectiveness_gain": -1.0}, "effectiveness_gain must not be negative, got -1.0"),
        ({"bias_gain": np.nan}, "bias_gain must be finite, got nan"),
        ({"switching_gain": -0.1}, "switching_gain must not be negative, got -0.1"),
        ({"barrier": 0.0}, "barrier must be positive, got 0.0"),
        ({"barrier_torque": -1.0}, "barrier_torque must not be negative, got -1.0"),
        ({"largest_switching": -1.0}, "largest_switching must not be negative, got -1.0"),
        ({"smallest": 0.0}, r"smallest must lie within \(0, 1\), got 0.0"),
        ({"layer": -0.1}, "layer must not be negative, got -0.1"),
        ({"excitation_time": 0.0}, "excitation_time must be positive, got 0.0"),
        ({"excitation_threshold": 0.0}, "excitation_threshold must be positive, got 0.0"),
    ],
)
def test_bad_gains(gains, message):
    with pytest.raises(ValueError, match=message):
        observers.make("asmo", HEALTHY, Memory(1), **gains)


def test_an_unknown_gain_is_a_type_error():
    with pytest.raises(
        TypeError, match=r"observers\.make\(\) got an unexpected keyword argument 'beauty'; gains of asmo"
    ):
        observers.make("asmo", HEALTHY, Memory(1), beauty=1.0)


def test_unknown_observer():
    with pytest.raises(ValueError, match=r"observer must be one of \['asmo', .*\], got 'kalman'"):
        observers.make("kalman", HEALTHY, Memory(1))
    with pytest.raises(ValueError, match=r"observer must be one of \['asmo', .*\], got 'kalman'"):
        observers.search_space("kalman")
