"""Gyroscopic motion of bodies that no mass makes, which is faster than their rate."""

from dataclasses import replace

import numpy as np
import pytest

from ftac_gym import DivergenceError, Simulator, scenarios
from ftac_gym.task import InertiaUncertainty

PAPER = scenarios.get("zhang_zhou_2019").replace(faults=None, disturbance=None, inertia_uncertainty=None, sensors=None)


def body(moment):
    inertia = PAPER.spacecraft.inertia_matrix
    inertia[0, 0] = moment
    return replace(PAPER.spacecraft, inertia=inertia)


def turn(step, count):
    """The rate after so many steps without torque."""
    coarse = {"physics_step": step, "control_period": step, "duration": 1.0}
    scenario = PAPER.replace(spacecraft=body(1000.0), **coarse)
    simulator = Simulator(scenario, 1)
    simulator.reset(scenario.draw(0, 1))
    for _ in range(count):
        simulator.step(np.zeros((1, scenario.spacecraft.wheels.count)))
    return simulator.state.rate[0]


@pytest.mark.parametrize("moment", [1000.0, 3000.0, 1e4])
def test_a_step_too_long_for_the_gyroscopic_motion_is_refused(moment):
    with pytest.raises(ValueError, match=r"must be at most .*and the body nutates [0-9.]+ times as fast.*, got"):
        PAPER.replace(spacecraft=body(moment))


def test_an_uncertainty_can_make_such_a_body():
    offset = np.diag([3000.0, 0.0, 0.0])
    with pytest.raises(ValueError, match="the body nutates"):
        PAPER.replace(inertia_uncertainty=InertiaUncertainty(offset=offset))


def test_an_accepted_step_integrates_it():
    np.testing.assert_allclose(turn(1e-3, 500), turn(5e-4, 1000), atol=1e-6)


def test_a_rate_too_fast_for_the_gyroscopic_motion_is_an_error():
    """A flight meets it only where the estimate of the reach falls short."""
    scenario = PAPER.replace(spacecraft=body(1000.0), physics_step=1e-3, control_period=1e-3, duration=1.0)
    simulator = Simulator(scenario, 1)
    simulator.reset(scenario.draw(0, 1))
    simulator.state.rate[:] = (0.0, 10.0, 10.0)
    with pytest.raises(DivergenceError, match=r"^rate must stay below 12\.65 rad/s for this physics_step"):
        simulator.step(np.zeros((1, scenario.spacecraft.wheels.count)))
