"""INDI: filters in step, increments from the command in effect, and no need to be told of faults."""

from dataclasses import replace

import numpy as np

from ftac_gym import baselines, scenarios
from ftac_gym.attitude import angle_between
from ftac_gym.dynamics import Simulator
from ftac_gym.faults import FaultSchedule, LossOfEffectiveness
from ftac_gym.task.disturbances import Disturbance
from ftac_gym.task.initial_state import InitialState

FLAGSHIP = scenarios.get("flagship")
QUIET = {"faults": None, "sensors": None, "disturbance": None, "inertia_uncertainty": None}
# Body and wheels have no momentum together, so that no gyroscopic torque acts.
RESTING = InitialState(angle=(0.3, 2.5), max_rate=0.0, wheel_momentum=0.0)
CALM = FLAGSHIP.replace(**QUIET, initial_state=RESTING)
AXES, INERTIA = CALM.spacecraft.wheels.axis_matrix, CALM.spacecraft.inertia_matrix


def fly(scenario, steps, count=6, shift=False, **gains):
    """Return the unexplained torques (steps, N, 3) [N m] and the last errors [deg]; shift: with the wrong command."""
    simulator, law = Simulator(scenario, count), baselines.make("indi", scenario, count, **gains)
    simulator.reset(scenario.draw(0, count))
    estimates = []
    for _ in range(steps):
        measurement = simulator.measurement()
        command = law.act(replace(measurement, command_in_effect=measurement.last_command) if shift else measurement)
        estimates.append(law.estimate.disturbance)
        simulator.step(command)
    return np.array(estimates), np.degrees(angle_between(simulator.state.attitude, simulator.reference_attitude))


def test_synchronous_filters_explain_the_motion_while_it_changes():
    """In a slew with steps of the torque no torque is left unexplained; with a command of another period, one is."""
    alone = {"isolation": "none", "prediction": False, "rate_gain": 1.0}
    explained, _ = fly(CALM, 300, **alone)
    shifted, _ = fly(CALM, 300, shift=True, **alone)
    assert np.abs(explained).max() < 1e-5
    assert np.abs(shifted).max() > 5e-3


def test_the_increment_starts_from_the_filtered_command():
    """D u = D u0_f + J (nu - w'_f), with the nu of PD; all of it is known from the last two measurements."""
    near = CALM.replace(initial_state=InitialState(angle=2e-4, max_rate=1e-6, wheel_momentum=0.0))
    simulator = Simulator(near, 3)
    law = baselines.make("indi", near, 3, attitude_filter_time=0.0, isolation="none", prediction=False)
    shared = {name: getattr(law.gains, name) for name in baselines.defaults("pd")}
    pd = baselines.make("pd", near, 3, **shared)
    simulator.reset(near.draw(1, 3))
    filters = np.zeros((2, 2, 3, 3))  # acceleration and torque, two stages
    share = 1.0 - np.exp(-law.gains.filter_bandwidth / law.scales.loop_time * near.control_period)
    last = None
    for _ in range(15):
        measurement = simulator.measurement()
        command = law.act(measurement)
        if last is not None:
            acceleration = (measurement.rate - last) / near.control_period
            for kind, now in enumerate((acceleration, measurement.command_in_effect @ AXES.T)):
                filters[kind, 0] += share * (now - filters[kind, 0])
                filters[kind, 1] += share * (filters[kind, 0] - filters[kind, 1])
        wanted = pd.act(measurement) @ AXES.T + filters[1, 1] - filters[0, 1] @ INERTIA
        np.testing.assert_allclose(command @ AXES.T, wanted, rtol=1e-9, atol=1e-12)
        last = measurement.rate
        simulator.step(command)
    assert np.abs(filters).max() > 1e-4


def test_an_external_torque_is_the_estimate_after_the_filter():
    torque = np.array([0.02, -0.01, 0.015])
    estimates, errors = fly(CALM.replace(disturbance=Disturbance(tuple(torque))), 1200, isolation="none")
    np.testing.assert_allclose(estimates[-1], np.tile(torque, (6, 1)), atol=2e-4)
    assert errors.max() < 5e-3
    # Two equal stages of bandwidth b have (1 + b t) e^(-b t) of a step left.
    bandwidth = 0.8
    shaken, gains = CALM.replace(disturbance=Disturbance(tuple(torque))), {"filter_bandwidth": 0.2 * bandwidth}
    estimates, _ = fly(shaken, 40, isolation="none", **gains)
    time = CALM.control_period * 20
    left = (1.0 + bandwidth * time) * np.exp(-bandwidth * time)
    seen = estimates[20] @ torque / (torque @ torque)
    np.testing.assert_allclose(seen, 1.0 - left, atol=0.12)


def test_weak_wheels_need_no_model():
    faults = FaultSchedule(tuple(LossOfEffectiveness(wheel=k, effectiveness=0.5) for k in range(4)))
    _, errors = fly(CALM.replace(faults=faults), 1200)
    assert errors.max() < 5e-3


def test_a_wrong_inertia_moves_no_torque_in_balance():
    heavy = CALM.replace(disturbance=Disturbance((0.01, 0.01, -0.01)))
    simulator, law = Simulator(heavy, 2), baselines.make("indi", heavy, 2)
    law._inertia = 1.3 * law._inertia
    simulator.reset(heavy.draw(0, 2))
    for _ in range(1200):
        simulator.step(law.act(simulator.measurement()))
    assert np.degrees(angle_between(simulator.state.attitude, simulator.reference_attitude)).max() < 5e-3
