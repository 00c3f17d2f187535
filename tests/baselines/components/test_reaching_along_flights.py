"""Along simulated flights the sliding variable changes as the equations of each law say, without faults."""

import numpy as np
import pytest
from helpers import controllers
from helpers.laws import NominalModel, Target
from helpers.units import NFTSM, PREDEFINED_TIME, in_units

from ftac_gym import baselines
from ftac_gym.dynamics import Simulator
from ftac_gym.spacecraft.layouts import orthogonal_and_skew
from ftac_gym.spacecraft.spacecraft import Spacecraft
from ftac_gym.spacecraft.wheel_array import WheelArray
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.references import MRPSinusoid, SetPoints
from ftac_gym.task.scenario import Scenario

INERTIA = ((30.0, 5.3, 6.4), (5.3, 27.0, 10.0), (6.4, 10.0, 19.0))  # kg m^2, Zhang and Zhou 2019
COUNT, MOMENTS, INSTANT = 4, (0, 30, 100), 1e-6
WAVE = {"amplitude": (0.3, -0.2, 0.25), "frequency": (0.2, 0.31, 0.17), "phase": (0.1, 0.5, -0.4)}

LAWS = {
    "zhang_zhou_stabilisation": ("zhang_zhou_stabilisation_no_observer", controllers.Stabilisation, {}),
    "stabilisation, sign": ("zhang_zhou_stabilisation_no_observer", controllers.Stabilisation, {"layer": 0.0}),
    "zhang_zhou_tracking": ("zhang_zhou_tracking_no_observer", controllers.Tracking, {}),
    "tracking, feed-forward": ("zhang_zhou_tracking_no_observer", controllers.Tracking, {"feed_forward": True}),
    "ptc": ("ptc_no_observer", controllers.PTC, {}),
    "ptc, layer": ("ptc_no_observer", controllers.PTC, {"layer": 0.1}),
    "ptc, acceleration": (
        "ptc_no_observer", controllers.PTC, {"switching_form": "acceleration", "switching_gain": 0.2},
    ),
    "ptc, h1 = .15": ("ptc_no_observer", controllers.PTC, {"position_exponent": 0.15, "rate_exponent": 0.45}),
    "tsmc_class": ("tsmc_class", controllers.TSMC, {}),
    "tsmc_class, wide guard": ("tsmc_class", controllers.TSMC, {"guard": 0.3}),
    "nftsm": ("nftsm", controllers.NFTSM, NFTSM),
    "nftsm, parabola": ("nftsm", controllers.NFTSM, {**NFTSM, "bound": 0.5}),
    "predefined_time": ("predefined_time", controllers.PredefinedTime, PREDEFINED_TIME),
    "predefined_time, fast": (
        "predefined_time", controllers.PredefinedTime, {**PREDEFINED_TIME, "position_time": 5.0, "rate_time": 2.0},
    ),
}  # fmt: skip
ADAPTED = {
    "rate_bound": "chi", "fault_bound": "rho", "bound": "omega", "eta": "eta", "network_weights": "weights",
}  # fmt: skip


def scenario(reference, period):
    wheels = WheelArray(orthogonal_and_skew(), 1e6, momentum_coupling=False)
    return Scenario(
        name="nominal",
        spacecraft=Spacecraft(INERTIA, wheels, allow_unphysical_inertia=True),
        initial_state=InitialState(angle=(0.4, 2.6), max_rate=0.4),
        reference=reference,
        control_period=period,
        physics_step=period,
        duration=10.0 if period > 1e-3 else 10.0 * period,
    )


def moments(name, reference, **gains):
    """Return time, attitude, rate and memory at some moments of a flight of some spacecraft."""
    task = scenario(reference, 0.01)
    simulator, law = Simulator(task, COUNT), baselines.make(name, task, COUNT, **in_units(name, task, **gains))
    simulator.reset(task.draw(3, COUNT))
    kept = []
    for step in range(max(MOMENTS) + 1):
        if step in MOMENTS:
            state = simulator.state
            kept.append((step * 0.01, state.attitude.copy(), state.rate.copy(), law.memory.copy()))
        simulator.step(law.act(simulator.measurement()))
    return kept


def measured(name, moving, moment, gains):
    """Return s and its derivative (N, 3) at a moment, by one-sided differences of second order."""
    time, attitude, rate, memory = moment
    reference = SetPoints()
    if moving:
        phase = tuple(f * time + p for f, p in zip(WAVE["frequency"], WAVE["phase"], strict=True))
        reference = MRPSinusoid(**{**WAVE, "phase": phase})
    task = scenario(reference, INSTANT)
    episodes = task.draw(0, COUNT)
    episodes.initial["attitude"], episodes.initial["rate"] = attitude, rate
    simulator, law = Simulator(task, COUNT), baselines.make(name, task, COUNT, **in_units(name, task, **gains))
    simulator.reset(episodes)
    own = {**memory, "called_at": np.full(COUNT, np.nan)}  # times of the other flight
    law.memory.restore(own, np.ones(COUNT, dtype=bool))
    command, variables = law.act(simulator.measurement()), []
    for _ in range(3):
        variables.append(law.sliding_variable(simulator.measurement()))
        simulator.step(command)
    first, second, third = variables
    return first, (4.0 * second - 3.0 * first - third) / (2.0 * INSTANT)


CASES = [(case, moving) for case in LAWS for moving in (False, True) if not (moving and "stabilisation" in case)]


@pytest.mark.parametrize(("case", "moving"), CASES, ids=[f"{c}, {'moving' if m else 'at rest'}" for c, m in CASES])
def test_the_sliding_variable_changes_as_designed(case, moving):
    name, controller, gains = LAWS[case]
    # The attitude filter is an observer, not a part of the law.
    parts = {**gains, "attitude_filter_time": 0.0} if issubclass(controller, controllers.Relative) else gains
    largest = 0.0
    for moment in moments(name, MRPSinusoid(**WAVE) if moving else SetPoints(), **parts):
        variable, change = measured(name, moving, moment, parts)
        time, attitude, rate, memory = moment
        for row in range(COUNT):
            law = controller(NominalModel(scenario(SetPoints(), 0.01), Target(**WAVE) if moving else None), **gains)
            for theirs, ours in ADAPTED.items():
                if theirs in memory:
                    setattr(law, ours, memory[theirs][row] if theirs == "network_weights" else memory[theirs][row, 0])
            expected_variable, expected, _ = law.state(time, attitude[row], rate[row])
            np.testing.assert_allclose(variable[row], expected_variable, atol=1e-12)
            np.testing.assert_allclose(change[row], expected, rtol=1e-6, atol=1e-6)
            largest = max(largest, np.abs(expected).max())
    assert largest > 0.1  # rad/s^2: there is something to compare
