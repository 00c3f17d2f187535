"""Super-twisting: the implicit step that it solves, its limits for short and long steps, its gain, and no chatter."""

import numpy as np
import pytest

from ftac_gym import baselines, scenarios
from ftac_gym.attitude import angle_between, quaternion_from_rotation_vector
from ftac_gym.dynamics import Simulator
from ftac_gym.task.disturbances import Disturbance, Harmonic
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.measurement import Measurement

FLAGSHIP = scenarios.get("flagship")
QUIET = {"faults": None, "sensors": None, "disturbance": None, "inertia_uncertainty": None}
CALM = FLAGSHIP.replace(**QUIET)
AXES, INERTIA = CALM.spacecraft.wheels.axis_matrix, CALM.spacecraft.inertia_matrix
RAW = {"attitude_filter_time": 0.0, "isolation": "none", "prediction": False, "calm_share": 0.0}


def still(rates, time=0.0, angle=0.0):
    """Return the measurement of spacecraft with some rates (n, 3) [rad/s], an angle [rad] off about the first axis."""
    count = len(rates)
    attitude = quaternion_from_rotation_vector(np.tile([angle, 0.0, 0.0], (count, 1)))
    return Measurement(
        np.full(count, time), attitude, np.asarray(rates, dtype=float), np.zeros((count, 4)), np.zeros((count, 4)),
        np.ones(count, dtype=bool), np.tile([1.0, 0, 0, 0], (count, 1)), np.zeros((count, 3)), np.zeros((count, 3)),
    )  # fmt: skip


def acceleration(law, measurement):
    return np.linalg.solve(INERTIA, AXES @ law.act(measurement).T).T


def fly(scenario, steps=1200, count=6, **gains):
    """Return errors [deg], commands [N m], alpha and the integral, (steps, N, ...)."""
    simulator, law = Simulator(scenario, count), baselines.make("super_twisting", scenario, count, **gains)
    simulator.reset(scenario.draw(0, count))
    rows = []
    for _ in range(steps):
        command = law.act(simulator.measurement())
        simulator.step(command)
        error = np.degrees(angle_between(simulator.state.attitude, simulator.reference_attitude))
        rows.append((error, command, law.memory["alpha"], law.memory["integral"]))
    return tuple(np.array(column) for column in zip(*rows, strict=True))


@pytest.mark.parametrize("size", [1e-6, 1e-4, 5e-4])
def test_the_reaching_solves_the_implicit_step(size):
    """s+ + h alpha |s+|^(1/2) sign(s+) = s, with the acceleration (s+ - s) / h."""
    rates = size * np.random.default_rng(0).normal(size=(20, 3))
    law = baselines.make("super_twisting", CALM, 20, **RAW)
    step, alpha = law.scheduled.step, law.memory["alpha"]
    after = rates + step * acceleration(law, still(rates))
    np.testing.assert_allclose(after + step * alpha * np.sqrt(np.abs(after)) * np.sign(after), rates, rtol=1e-6)
    assert (np.abs(after) < np.abs(rates)).all() and (np.sign(after) == np.sign(rates)).all()


def test_it_is_linear_near_zero_and_a_square_root_far_from_it():
    law = baselines.make("super_twisting", CALM, 1, **RAW)
    small = acceleration(law, still([[1e-9, 0.0, 0.0]]))[0, 0]
    assert small == pytest.approx(-1e-9 / law.scheduled.step, rel=1e-3)
    fine = baselines.make("super_twisting", CALM, 1, step=1e-4, least_gain=0.1, **RAW)
    rate = 1e-3
    root = 0.1 * np.sqrt(fine.scales.acceleration / fine.scales.loop_time * rate)
    assert acceleration(fine, still([[rate, 0.0, 0.0]]))[0, 0] == pytest.approx(-root, rel=1e-3)


def test_alpha_grows_while_the_error_is_large_and_returns():
    wave = Disturbance((0.0, 0.0, 0.0), (Harmonic((0.06, 0.0, 0.0), 0.8),))
    calm, shaken = (fly(task, adaptation=0.02, least_gain=2.0)[2] for task in (CALM, CALM.replace(disturbance=wave)))
    least, largest = calm.min(), 5.0 * calm.min()
    assert (calm[-1] == least).all() and calm.max() > least
    assert (shaken[-1, :, 0] > 1.5 * least).all() and shaken.max() <= largest * (1.0 + 1e-12)
    assert (shaken >= least).all()


def test_nothing_adapts_in_saturation():
    law = baselines.make("super_twisting", CALM, 1, **RAW)
    far = still([[0.0, 0.0, 0.0]], angle=2.0)
    command = law.act(far)
    assert np.abs(command).max() == pytest.approx(0.2)
    assert (law.memory["integral"] == 0.0).all() and np.ptp(law.memory["alpha"]) == 0.0
    near = baselines.make("super_twisting", CALM, 1, **RAW)
    near.act(still([[1e-3, 0.0, 0.0]]))
    assert near.memory["integral"][0, 0] < 0.0 < near.memory["alpha"][0, 0] - near.memory["alpha"][0, 1]


def test_the_implicit_step_does_not_chatter():
    """At rest on target, with a constant torque: commands settle, where a short step reverses them for ever."""
    task = CALM.replace(disturbance=Disturbance((0.02, 0.0, 0.0)), initial_state=InitialState(angle=0.02))
    changes = []
    for gains in ({}, {"step": 0.02}):
        _, commands, _, _ = fly(task, 900, count=2, **gains)
        changes.append(np.abs(np.diff(commands[-200:], axis=0)).max() / 0.2)
    assert changes[0] < 1e-3 < 0.05 < changes[1]
