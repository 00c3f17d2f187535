"""The estimator of faulty wheels with wheels that have a lag or a dead band by their nominal parameters."""

import numpy as np
import pytest

from ftac_gym import baselines, scenarios
from ftac_gym.attitude import angle_between
from ftac_gym.dynamics import Simulator
from ftac_gym.faults import FaultSchedule, Outage

COUNT = 4
FLAGSHIP = scenarios.get("flagship").replace(faults=None)


def flown(wheels, name, periods=800, **changes):
    """Return baseline and simulator after a flight, and whether each wheel had an alarm (T, N, m)."""
    scenario = FLAGSHIP.replace(spacecraft={"wheels": wheels}, **changes)
    simulator, baseline = Simulator(scenario, COUNT), baselines.make(name, scenario, COUNT)
    simulator.reset(scenario.draw(1, COUNT))
    alarms = []
    for _ in range(periods):
        simulator.step(baseline.act(simulator.measurement()))
        alarms.append(baseline.estimate.alarm)
    return baseline, simulator, np.array(alarms)


@pytest.mark.parametrize("name", ["pd_dob", "nftsm_isolation"])
@pytest.mark.parametrize("lag", [(0.05, 0.3, 0.1, 0.2), (1e-3, 1e-3, 1e-3, 0.5)], ids=str)
def test_wheels_of_different_lags_are_no_faulty_wheels_and_no_late_loop(lag, name):
    """One lag for all, the largest, had every quick wheel isolated."""
    baseline, simulator, alarms = flown({"lag": lag}, name)
    assert not alarms.any()
    assert (baseline.memory["plant"]["late"] == 0).all()
    assert angle_between(simulator.state.attitude, simulator.reference_attitude).max() < FLAGSHIP.success.angle


@pytest.mark.parametrize("band", [0.002, 0.01])
def test_a_dead_band_is_no_fault(band):
    """The wheels of a spacecraft on target are within their dead band most of the time."""
    _, simulator, alarms = flown({"dead_band": band}, "pd_dob")
    assert not alarms.any()
    assert angle_between(simulator.state.attitude, simulator.reference_attitude).max() < FLAGSHIP.success.angle


@pytest.mark.parametrize("wheels", [{"lag": (0.05, 0.3, 0.1, 0.2)}, {"dead_band": 0.002}], ids=str)
def test_a_faulty_one_among_real_wheels_is_found_as_among_ideal_ones(wheels):
    fault = FaultSchedule((Outage(wheel=1, onset=3.0),))
    real, ideal = (flown(given, "pd_dob", faults=fault)[2] for given in (wheels, {}))
    assert real[100:, :, 1].all()
    np.testing.assert_allclose(real.mean(axis=0), ideal.mean(axis=0), atol=0.05)
