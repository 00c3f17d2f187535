"""Source of the fault estimate of a controller: none, an observer, or the truth."""

import numpy as np
import pytest
from helpers.observed import sustained, task

from ftac_gym import baselines, scenarios
from ftac_gym.baselines import observers
from ftac_gym.baselines.fault_source import FaultSource
from ftac_gym.baselines.memory import Memory
from ftac_gym.dynamics import Simulator
from ftac_gym.faults import Bias, FaultSchedule, LossOfEffectiveness, Outage

FAULTS = FaultSchedule((
    LossOfEffectiveness(wheel=0, effectiveness=0.4), Bias(wheel=1, constant=0.05), Outage(wheel=3, onset=0.1),
))  # fmt: skip
WEAK = task(4, 0.05, FAULTS)


def flown(scenario, count, steps):
    simulator = Simulator(scenario, count)
    simulator.reset(scenario.draw(0, count))
    for step in range(steps):
        yield simulator
        simulator.step(np.broadcast_to(sustained(step * scenario.control_period, 4), (count, 4)))


def test_none_believes_in_healthy_wheels():
    source = FaultSource(WEAK, Memory(2), "none")
    assert source.information == "attitude"
    for simulator in flown(WEAK, 2, 5):
        assert source.update(simulator.measurement(truth=True)) is None
    assert source.estimate is None


def test_the_oracle_knows_the_truth():
    source = FaultSource(WEAK, Memory(2), "oracle")
    assert source.information == "oracle"
    for simulator in flown(WEAK, 2, 5):
        estimate = source.update(simulator.measurement(truth=True))
        np.testing.assert_array_equal(estimate.effectiveness, simulator.truth().effectiveness)
        np.testing.assert_array_equal(estimate.bias, simulator.truth().bias)
        assert estimate.identifiable.all() and source.estimate.bias is estimate.bias
    np.testing.assert_array_equal(estimate.effectiveness, [[0.4, 1.0, 1.0, 0.0]] * 2)
    np.testing.assert_allclose(estimate.bias, [[0.0, 0.05, 0.0, 0.0]] * 2)


def test_an_oracle_without_the_truth_says_so():
    simulator = next(flown(WEAK, 1, 1))
    with pytest.raises(ValueError, match=r"measurement must hold the truth for an oracle: measurement\(truth=True\)"):
        FaultSource(WEAK, Memory(1), "oracle").update(simulator.measurement())
    law = baselines.make("ptc_oracle", WEAK)
    with pytest.raises(ValueError, match="measurement must hold the truth"):
        law.act(simulator.measurement())


WITHOUT_EXCITATION = {"multiple_model", "multiple_model_telemetry"}


@pytest.mark.parametrize(
    "kind", sorted(set(observers.names()) - {"lo", "fafeo", "ilo_class", "tachometer", *WITHOUT_EXCITATION})
)
def test_an_observer_by_name_sees_what_it_would_alone(kind):
    source, memory = FaultSource(WEAK, Memory(2), kind, {"excitation_time": 1.0}), Memory(2)
    alone = observers.make(kind, WEAK, memory, excitation_time=1.0)
    assert source.information == "attitude"
    for simulator in flown(WEAK, 2, 30):
        measurement = simulator.measurement()
        first, second = source.update(measurement), alone.update(measurement, measurement.command_in_effect, 0.05)
        np.testing.assert_array_equal(first.effectiveness, second.effectiveness)
        np.testing.assert_array_equal(first.identifiable, second.identifiable)
    assert source.estimate.effectiveness is first.effectiveness


@pytest.mark.parametrize("kind", ["fafeo", "ilo_class"])
def test_an_observer_of_torques_by_name_sees_what_it_would_alone(kind):
    bending = scenarios.get("flexible")
    source, memory = FaultSource(bending, Memory(2), kind), Memory(2)
    alone = observers.make(kind, bending, memory)
    for simulator in flown(bending, 2, 30):
        measurement = simulator.measurement()
        first, second = source.update(measurement), alone.update(measurement, measurement.command_in_effect, 0.1)
        np.testing.assert_array_equal(first.disturbance, second.disturbance)
        assert first.effectiveness is None and (first.vibration is None) == (kind == "ilo_class")
    assert source.estimate.disturbance is first.disturbance


@pytest.mark.parametrize(
    ("kind", "gains", "message"),
    [
        ("guess", None, r"faults must be one of \['none', 'oracle', 'asmo', .*\], got 'guess'"),
        ("none", {"layer": 0.1}, "observer must not have gains where faults = 'none', got {'layer': 0.1}"),
        ("oracle", {"layer": 0.1}, "observer must not have gains where faults = 'oracle'"),
        ("asmo", {"barrier": 0.0}, "barrier must be positive, got 0.0"),
        ("lo", None, "first must have one row for each of the 4 wheels"),
    ],
)
def test_bad_sources(kind, gains, message):
    with pytest.raises(ValueError, match=message):
        FaultSource(WEAK, Memory(1), kind, gains)
