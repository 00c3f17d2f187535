"""Laws on the rotation between body and reference: frame, branch, gains at zero, limits and precision."""

import numpy as np
import pytest
from helpers.observed import task
from helpers.units import NFTSM, PREDEFINED_TIME, in_units

from ftac_gym import baselines, scenarios
from ftac_gym.attitude import angle_between, quaternion_product, random_quaternion_from_uniforms
from ftac_gym.dynamics import Simulator
from ftac_gym.faults import Bias, FaultSchedule, LossOfEffectiveness
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.references import MRPSinusoid

NAMES = ("tsmc_class", "nftsm", "predefined_time")
FLAGSHIP, TRACKING = scenarios.get("flagship"), scenarios.get("flagship_tracking")
QUIET = {"faults": None, "sensors": None, "disturbance": None, "inertia_uncertainty": None}
TASK = task(4, 0.05, None)
INERTIA, AXES = TASK.spacecraft.inertia_matrix, TASK.spacecraft.wheels.axis_matrix


def fly(scenario, name, count=4, duration=60.0, **gains):
    """Return errors [deg] (steps, N) and commands (steps, N, m)."""
    simulator, law = Simulator(scenario, count), baselines.make(name, scenario, count, **gains)
    simulator.reset(scenario.draw(0, count))
    errors, commands = [], []
    for _ in range(round(duration / scenario.control_period)):
        command = law.act(simulator.measurement(truth=law.information == "oracle"))
        simulator.step(command)
        errors.append(np.degrees(angle_between(simulator.state.attitude, simulator.reference_attitude)))
        commands.append(command)
    return np.array(errors), np.array(commands)


def states(count, size=1.0):
    """Return a measurement of random attitudes, rates and moving references."""
    random = np.random.default_rng(0)
    attitude, reference = (random_quaternion_from_uniforms(random.random((count, 3))) for _ in range(2))
    rates = [size * random.normal(size=(count, 3)) for _ in range(3)]
    four = np.zeros((count, 4))
    return Measurement(np.zeros(count), attitude, rates[0], four, four, np.ones(count, bool), reference, *rates[1:])


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("scenario", [FLAGSHIP, TRACKING], ids=lambda scenario: scenario.name)
def test_brings_healthy_craft_to_the_target(name, scenario):
    errors, _ = fly(scenario.replace(**QUIET), name, duration=90.0)
    assert errors[-50:].max() < 0.1


@pytest.mark.parametrize("name", [*NAMES, "shen_class"])
def test_neither_the_inertial_frame_nor_the_sign_of_a_quaternion_matters(name):
    moving = TASK.replace(reference=MRPSinusoid((0.1, 0.1, 0.1), (1.0, 1.0, 1.0)))
    measurement, turn = states(6, 0.1), np.array([0.5, -0.5, 0.5, 0.5])
    turned = Measurement(**{
        **vars(measurement), "attitude": quaternion_product(turn, measurement.attitude),
        "reference_attitude": -quaternion_product(turn, measurement.reference_attitude),
    })  # fmt: skip
    laws = [baselines.make(name, moving, 6) for _ in range(2)]
    np.testing.assert_allclose(laws[0].act(measurement), laws[1].act(turned), atol=1e-10)
    np.testing.assert_allclose(laws[0].sliding_variable(measurement), laws[1].sliding_variable(turned), atol=1e-10)


@pytest.mark.parametrize("name", NAMES)
def test_a_body_that_follows_exactly_gets_the_feed_forward_alone(name):
    moving = TASK.replace(reference=MRPSinusoid((0.1, 0.1, 0.1), (1.0, 1.0, 1.0)))
    measurement = states(6, 0.05)
    following = Measurement(
        **{**vars(measurement), "attitude": measurement.reference_attitude, "rate": measurement.reference_rate}
    )
    command = baselines.make(name, moving, 6).act(following)
    rate, acceleration = following.rate, following.reference_acceleration
    expected = acceleration @ INERTIA + np.cross(rate, rate @ INERTIA)
    assert np.abs(command).max() < 4.9  # within the limits
    np.testing.assert_allclose(command @ AXES.T, expected, atol=1e-6)


SOFT = {**PREDEFINED_TIME, "position_gain": 0.5, "rate_gain": 3.0}


@pytest.mark.parametrize(
    ("name", "gains", "expected"),
    [
        ("nftsm", {"linear": 0.1, "terminal": 0.0, "rate_gain": 3.0, "reaching_linear": 1.0}, 3.0 + 0.1 / 4.0),
        ("predefined_time", SOFT, 0.5 + 3.0 + 0.3),
        ("predefined_time", {**SOFT, "switching_gain": 0.0}, 0.5 + 3.0),
    ],
)
def test_the_rate_gain_at_zero_is_the_one_given(name, gains, expected):
    """Gain that sampling limits: for small rates on target the torque is -J k w."""
    rate = 1e-9 * np.random.default_rng(0).normal(size=(6, 3))
    four, three, identity = np.zeros((6, 4)), np.zeros((6, 3)), np.tile([1.0, 0, 0, 0], (6, 1))
    still = Measurement(np.zeros(6), identity, rate, four, four, np.ones(6, bool), identity, three, three)
    command = baselines.make(name, TASK, 6, **in_units(name, TASK, **gains)).act(still)
    np.testing.assert_allclose(command @ AXES.T, -expected * rate @ INERTIA, rtol=2e-3)


@pytest.mark.parametrize("name", NAMES)
def test_saturated_torque_keeps_its_direction(name):
    """All wheels are scaled together; with wide limits the same law asks for a multiple."""
    measurement = states(6, 0.5)
    wide = TASK.replace(spacecraft=task(4, 0.05, None).spacecraft)
    wheels = type(TASK.spacecraft.wheels)(AXES.tolist(), 1e6, momentum_coupling=False)
    wide = TASK.replace(spacecraft=type(TASK.spacecraft)(INERTIA.tolist(), wheels, allow_unphysical_inertia=True))
    known = {"nftsm": NFTSM, "predefined_time": PREDEFINED_TIME}.get(name, {})
    limited, free = (
        baselines.make(name, scenario, 6, **in_units(name, scenario, **known)).act(measurement)
        for scenario in (TASK, wide)
    )
    share = np.abs(free).max(axis=1, keepdims=True) / 5.0
    assert (share > 1.0).any()
    np.testing.assert_allclose(limited * np.maximum(share, 1.0), free, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("name", ["nftsm", "predefined_time"])
def test_knowing_the_faults_helps(name):
    """A bias and a weak wheel: the law alone is left with an error, its oracle with none, the observer in between."""
    faults = FaultSchedule((LossOfEffectiveness(wheel=0, effectiveness=0.4), Bias(wheel=1, constant=0.04)))
    scenario = FLAGSHIP.replace(**{**QUIET, "faults": faults, "initial_state": InitialState(angle=0.5)})
    variants = (name, f"{name}_observer", f"{name}_oracle")
    blind, watching, knowing = (fly(scenario, variant, 3)[0][-20:].max(axis=0) for variant in variants)
    assert (blind > 0.02).all()  # deg
    assert (watching < 0.3 * blind).all()
    assert (knowing < 0.05 * blind).all()


@pytest.mark.parametrize(
    ("name", "gains", "message"),
    [
        ("tsmc_class", {"linear": -1.0}, "linear must not be negative"),
        ("tsmc_class", {"guard": 0.0}, "guard must be positive"),
        ("tsmc_class", {"reaching_linear": -1.0}, "linear must not be negative"),
        ("tsmc_class", {"reaching_power_gain": -1.0}, "reaching_power_gain must not be negative"),
        ("tsmc_class", {"reaching_exponent": 1.0}, r"exponent must lie within \(0, 1\)"),
        ("tsmc_class", {"attitude_filter_time": -1.0}, "attitude_filter_time must not be negative"),
        ("nftsm", {"terminal": -1.0}, "terminal must not be negative"),
        ("nftsm", {"exponent": 1.0}, r"exponent must lie within \(0, 1\)"),
        ("nftsm", {"terminal_slope": 0.0}, "terminal_slope must be positive"),
        ("nftsm", {"reaching_switching": 0.0}, "reaching_switching must be positive"),
        ("nftsm", {"rate_gain": 0.2}, r"reaching_linear must be below rate_gain = 0\.2, got 0\.2"),
        ("predefined_time", {"position_gain": 0.8}, r"position_gain must be below rate_gain = 0\.8, got 0\.8"),
        ("predefined_time", {"position_gain": 0.0}, "position_gain must be positive"),
        ("predefined_time", {"rate_time": 0.0}, "rate_time must be positive"),
        ("predefined_time", {"rate_time": -1.0, "rate_exponent": 0.3}, "rate_time must be positive"),
        ("predefined_time", {"switching_gain": -1.0}, "switching_gain must not be negative"),
        ("predefined_time", {"position_exponent": 1.5}, r"exponent must lie within \(0, 1\)"),
    ],
)  # fmt: skip
def test_bad_gains(name, gains, message):
    with pytest.raises(ValueError, match=f"^{name}: .*{message}"):
        baselines.make(name, TASK, **gains)
