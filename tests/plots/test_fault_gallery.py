"""The gallery of fault kinds: every kind is in it, and every episode in it shows its fault."""

from dataclasses import replace

import numpy as np
import pytest

from ftac_gym import scenarios
from ftac_gym.evaluation import rollout
from ftac_gym.faults import KINDS, Bias, SensorFault
from ftac_gym.plots.fault_gallery import ONSET, examples, fault_gallery, sensor_error, with_fault

SCENARIO = scenarios.get("flagship").replace(duration=40.0)
FAULTS = examples()


@pytest.fixture(scope="module")
def healthy():
    return rollout(with_fault(SCENARIO, None), "pd_dob", seed=0)


def test_every_kind_is_shown():
    assert set(FAULTS) == {kind.kind for kind in KINDS}


@pytest.mark.parametrize("kind", FAULTS, ids=lambda kind: kind.label)
def test_the_fault_changes_the_flight_from_its_onset_on(kind, healthy):
    history = rollout(with_fault(SCENARIO, FAULTS[kind]), "pd_dob", seed=0)
    before = history.time <= ONSET
    if not isinstance(FAULTS[kind], SensorFault):
        np.testing.assert_array_equal(history.attitude[before], healthy.attitude[before])
    np.testing.assert_array_equal(history.attitude[before][:-1], healthy.attitude[before][:-1])
    change = np.abs(history.applied_torque - healthy.applied_torque).max()
    assert change > 1e-3  # N m


def test_a_bias_is_no_larger_than_a_small_wheel_could_give():
    bias = next(fault for fault in FAULTS.values() if isinstance(fault, Bias))
    assert with_fault(SCENARIO, bias).faults.faults == (bias,)
    small = replace(SCENARIO.spacecraft.wheels, torque_limit=0.004)
    scenario = SCENARIO.replace(spacecraft=replace(SCENARIO.spacecraft, wheels=small))
    assert with_fault(scenario, bias).faults.faults[0].amplitude == pytest.approx(0.0016)


def test_sensor_errors_are_those_of_the_fault(healthy):
    usual, _ = sensor_error(healthy)
    spiked = rollout(with_fault(SCENARIO, next(f for f in FAULTS.values() if "Spike" in type(f).__name__)), "pd_dob")
    attitude, _ = sensor_error(spiked)
    assert usual.max() < 0.05 and attitude.max() == pytest.approx(2.0, abs=0.05)
    stepped = rollout(with_fault(SCENARIO, next(f for f in FAULTS.values() if "Step" in type(f).__name__)), "pd_dob")
    _, rate = sensor_error(stepped)
    after = stepped.time > ONSET - 1e-9
    assert rate[after].mean() == pytest.approx(0.05, abs=0.001) and rate[~after].max() < 0.01


def test_the_figure_has_two_panels_for_each_kind(tmp_path):
    figure = fault_gallery(SCENARIO, "pd_dob")
    titles = [axes.get_title() for part in figure.subfigs for axes in part.axes if axes.get_title()]
    assert titles == [kind.label for kind in FAULTS]
    assert sum(len(part.axes) for part in figure.subfigs) == 2 * len(FAULTS)
    figure.savefig(tmp_path / "gallery.png", dpi=30)
    assert (tmp_path / "gallery.png").stat().st_size > 10_000
