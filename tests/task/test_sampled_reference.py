"""Trajectories from samples, against motions in closed form."""

import math

import numpy as np
import pytest

from ftac_gym import attitude as att
from ftac_gym import scenarios
from ftac_gym.dynamics import Simulator
from ftac_gym.evaluation import rollout
from ftac_gym.policies import DeferredBaseline
from ftac_gym.reproduction.inverse_dynamics import reference_motion
from ftac_gym.task import MRPSinusoid, SampledReference, Scenario

TASK = scenarios.get("flagship").replace(
    faults=None, sensors=None, disturbance=None, inertia_uncertainty=None, duration=40.0,
    initial_state={"angle": 0.0, "max_rate": 0.0, "wheel_momentum": 0.0},
)  # fmt: skip
SINUSOID = MRPSinusoid((0.12, -0.08, 0.1), (0.06, 0.05, 0.04), phase=(0.0, 1.0, 2.0))


def spin(time, rate=(0.02, -0.03, 0.01)):
    """Return the quaternions of a constant rate."""
    return att.quaternion_from_rotation_vector(np.asarray(time)[:, None] * np.array(rate))


def flown(reference, steps=400):
    """Return time, attitude, rate and acceleration of the reference that a simulator of two spacecraft has."""
    task = TASK.replace(reference=reference)
    simulator = Simulator(task, 2)
    simulator.reset(task.draw(0, 2))
    history = []
    for step in range(steps + 1):
        if step:
            simulator.step(np.zeros((2, 4)))
        seen = simulator.measurement()
        history.append((seen.reference_attitude[1], seen.reference_rate[1], seen.reference_acceleration[1]))
    return np.arange(steps + 1) * task.control_period, *map(np.array, zip(*history, strict=True))


def test_a_constant_spin_is_exact():
    times = np.array([0.0, 3.0, 7.0, 20.0, 40.0])
    samples = spin(times) * np.array([1.0, -1.0, 1.0, -1.0, 1.0])[:, None]  # Signs are free.
    time, attitude, rate, acceleration = flown(SampledReference.from_arrays(times + 100.0, samples))
    assert np.max(att.angle_between(attitude, spin(time))) < 1e-7
    np.testing.assert_allclose(rate, np.tile([0.02, -0.03, 0.01], (len(time), 1)), atol=1e-12)
    np.testing.assert_allclose(acceleration, 0.0, atol=1e-12)
    assert np.all(np.sum(attitude[1:] * attitude[:-1], axis=1) > 0.99)


def test_samples_of_a_sinusoid_give_back_its_rate_and_acceleration():
    time, exact, rate, acceleration = flown(SINUSOID)
    sampled = SampledReference.from_arrays(time[::10], exact[::10])
    same, attitude, own_rate, own_acceleration = flown(sampled)
    np.testing.assert_array_equal(same, time)
    inside = (time > 5.0) & (time < 35.0)  # At the ends the spline has no acceleration.
    off = att.angle_between(attitude, exact)
    assert off.max() < 2e-4 and off[inside].max() < 1e-6
    np.testing.assert_allclose(own_rate[inside], rate[inside], atol=1e-6)
    np.testing.assert_allclose(own_acceleration[inside], acceleration[inside], atol=2e-5)
    assert 0.9 < sampled.largest_rate / np.linalg.norm(rate, axis=1).max() < 1.1


def test_rate_and_acceleration_are_the_derivatives_of_the_attitude():
    random = np.random.default_rng(3)
    times = np.cumsum(random.uniform(0.5, 2.0, 30)) - 0.5
    turns = np.cumsum(random.normal(scale=0.2, size=(30, 3)), axis=0)
    sampled = SampledReference.from_arrays(times, att.quaternion_from_rotation_vector(turns))
    step, middle = 1e-4, np.linspace(0.3, 25.0, 500)
    (before, rate_before, _), (after, rate_after, _) = (sampled.motion(middle + shift) for shift in (-step, step))
    attitude, rate, acceleration = sampled.motion(middle)
    sign = np.sign(np.sum(before * after, axis=1, keepdims=True))
    slope = (sign * after - before) / (2.0 * step) * np.sign(np.sum(before * attitude, axis=1, keepdims=True))
    np.testing.assert_allclose(slope, att.quaternion_derivative(attitude, rate), atol=1e-7)
    # The acceleration has a corner at each sample.
    near = np.min(np.abs(middle[:, None] - (times - times[0])), axis=1) < 2.0 * step
    change = (rate_after - rate_before) / (2.0 * step)
    np.testing.assert_allclose(change[~near], acceleration[~near], atol=1e-6)
    assert np.max(np.abs(acceleration)) > 0.1


def test_a_tuned_law_follows_it_as_the_sinusoid_itself():
    time, exact, _, _ = flown(SINUSOID)
    errors = {}
    for name, reference in {
        "exact": SINUSOID,
        "samples": SampledReference.from_arrays(time[::10], exact[::10]),
    }.items():
        law = DeferredBaseline("pd_dob", rate_gain=0.77, position_gain=0.39, bandwidth=0.45)
        flight = rollout(TASK.replace(reference=reference, loop_delay=0.0), law, count=2)
        errors[name] = np.degrees(flight.attitude_error[-100:]).max()
    assert errors["samples"] < 1.2 * errors["exact"] + 1e-3


def test_the_scenario_keeps_the_numbers_and_not_the_file(tmp_path):
    times = np.linspace(0.0, 40.0, 9)
    rows = [f"{time},{','.join(map(repr, map(float, q)))}" for time, q in zip(times + 2.0, spin(times), strict=True)]
    text = "\n".join(["# a comment", "time,q0,q1,q2,q3", *rows, ""])
    (tmp_path / "turn.csv").write_text(text)
    reference = SampledReference.from_csv(tmp_path / "turn.csv")
    assert reference == SampledReference.from_arrays(times, spin(times))
    (tmp_path / "turn.csv").write_text("\n".join(rows))
    assert SampledReference.from_csv(tmp_path / "turn.csv") == reference
    task = TASK.replace(reference=reference)
    again = Scenario.from_json(task.to_json())
    assert again == task and again.draw(0, 2).digest() == task.draw(0, 2).digest() and "csv" not in task.to_json()
    motion = reference_motion(task.draw(0, 1), np.array([1.0, 2.0]))
    np.testing.assert_allclose(motion.rate, np.tile([0.02, -0.03, 0.01], (2, 1)), atol=1e-12)


def test_after_the_last_sample_the_reference_rests():
    times = np.array([0.0, 20.0, 40.0])
    _, attitude, rate, acceleration = flown(SampledReference.from_arrays(times, spin(times)), 403)
    np.testing.assert_array_equal(attitude[401:], np.tile(attitude[400], (3, 1)))
    assert np.all(rate[401:] == 0.0) and np.all(acceleration[401:] == 0.0) and np.all(rate[400] != 0.0)


ONE, TURNED = (1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("times", "attitudes", "message"),
    [
        ((0.0,), (ONE,), "times must have 2 to 20000 samples, got 1"),
        ((1.0, 2.0), (ONE, ONE), "times must start at 0, got 1.0"),
        ((0.0, 2.0, 2.0), (ONE,) * 3, r"times\[2\] must be later than 2 s before it, got 2.0"),
        ((0.0, math.nan), (ONE, ONE), "times must be finite"),
        ((0.0, 1.0), (ONE,), "attitudes must match the 2 times, got 1"),
        ((0.0, 1.0), (ONE, (2.0, 0.0, 0.0, 0.0)), r"attitudes\[1\] must be a unit quaternion, scalar first"),
        ((0.0, 1.0), (ONE, TURNED), r"attitudes\[1\] must be within a quarter turn .*give more samples, got 180.0"),
        ((0.0, 1.0), 3, "attitudes must be a list of quaternions, got 3"),
    ],
)
def test_what_is_refused(times, attitudes, message):
    with pytest.raises(ValueError, match=message):
        SampledReference(times, attitudes)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (None, "No such file"),
        ("", "times must have 2"),
        ("0,1,0,0\n1,1,0,0", "row 1 must have 5 columns, got 4"),
        ("time,qx,qy,qz,qw\n0,0,0,0,1\n1,0,0,0,1", "line of names must be 'time, q0, q1, q2, q3', got 'time, qx, qy"),
        ("Time, Q0, Q1, Q2, Q3\n0,1,0,0,0\n1,one,0,0,0", "row 2 must consist of numbers, got '1,one,0,0,0'"),
        ("0,1,0,0,0\n0,1,0,0,0", r"times\[1\] must be later"),
    ],
)
def test_files_that_are_refused(tmp_path, text, message):
    path = tmp_path / "turn.csv"
    if text is not None:
        path.write_text(text)
    with pytest.raises(ValueError, match=rf"turn\.csv.*{message}") as error:
        SampledReference.from_csv(path)
    assert "\n" not in str(error.value)


def test_the_trajectory_lasts_as_long_as_the_episode_and_no_faster_than_the_step():
    short = SampledReference((0.0, 30.0), (ONE, ONE))
    with pytest.raises(ValueError, match="duration must not exceed the time of the last sample of the reference, 30 s"):
        TASK.replace(reference=short)
    times = 0.005 * np.arange(8001)
    quick = SampledReference.from_arrays(times, spin(times, (60.0, 0.0, 0.0)))
    with pytest.raises(ValueError, match="reference must turn at"):
        TASK.replace(reference=quick)
