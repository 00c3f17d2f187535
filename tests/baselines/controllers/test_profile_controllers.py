"""The laws along the slew profile: each settles, follows, brakes, learns a constant torque, and suits any scale."""

import numpy as np
import pytest

from ftac_gym import baselines, scenarios
from ftac_gym.attitude import angle_between
from ftac_gym.baselines.components.slew_profile import PlantEstimate
from ftac_gym.dynamics import Simulator
from ftac_gym.faults import Bias, FaultSchedule
from ftac_gym.spacecraft.spacecraft import Spacecraft
from ftac_gym.spacecraft.wheel_array import WheelArray
from ftac_gym.task.initial_state import InitialState

NAMES = ("lqr", "indi", "super_twisting")
FLAGSHIP, TRACKING = scenarios.get("flagship"), scenarios.get("flagship_tracking")
QUIET = {"faults": None, "sensors": None, "disturbance": None, "inertia_uncertainty": None}
CALM = FLAGSHIP.replace(**QUIET)
BIASED = CALM.replace(faults=FaultSchedule((Bias(wheel=1, constant=0.04),)))
BIAS_TORQUE = 0.04 * FLAGSHIP.spacecraft.wheels.axis_matrix[:, 1]
every = pytest.mark.parametrize("name", NAMES)


def fly(scenario, name, count=8, seed=0, duration=120.0, plant=None, **gains):
    """Return the errors [deg], rates [rad/s] and commands [N m], (steps, N, ...), and the baseline."""
    simulator, law = Simulator(scenario, count), baselines.make(name, scenario, count, **gains)
    simulator.reset(scenario.draw(seed, count))
    law.plant = plant
    errors, rates, commands = [], [], []
    for _ in range(round(duration / scenario.control_period)):
        command = law.act(simulator.measurement())
        simulator.step(command)
        errors.append(np.degrees(angle_between(simulator.state.attitude, simulator.reference_attitude)))
        rates.append(simulator.state.rate.copy())
        commands.append(command)
    return np.array(errors), np.array(rates), np.array(commands), law


@every
@pytest.mark.parametrize("loop_delay", [0.0, 0.1, 0.2])
def test_settles_a_healthy_spacecraft(name, loop_delay):
    errors, rates, _, _ = fly(CALM.replace(loop_delay=loop_delay), name)
    assert (errors[0] > 1.0).all()
    assert errors[-1].max() < 0.01
    assert np.abs(rates[-1]).max() < 1e-4


@every
def test_follows_a_moving_reference(name):
    errors, rates, _, _ = fly(TRACKING.replace(**QUIET), name)
    assert np.abs(rates[-300:]).max() > 1e-3
    assert errors[-300:].max() < 0.1


@every
def test_a_constant_torque_leaves_no_error_and_is_the_estimate(name):
    errors, _, _, law = fly(BIASED, name, count=2, isolation="none")
    assert errors[-1].max() < 2e-3
    np.testing.assert_allclose(law.estimate.disturbance, np.tile(BIAS_TORQUE, (2, 1)), rtol=0.03, atol=2e-4)
    assert law.estimate.effectiveness is None and law.estimate.bias is None


@every
def test_saturated_wheels_wind_nothing_up(name):
    """A far slew at full torque, from a rate: no overshoot of more than a degree, though the wheels saturate long."""
    start = InitialState(angle=(2.8, 3.1), max_rate=0.1)
    errors, _, commands, _ = fly(CALM.replace(initial_state=start), name, count=16)
    share = np.abs(commands) / FLAGSHIP.spacecraft.wheels.torque_limits
    assert (share.max(axis=2) > 0.999).sum(axis=0).min() > 20
    near = np.argmax(errors < 0.5, axis=0)
    assert (near > 0).all()
    assert all(errors[step:, row].max() < 1.0 for row, step in enumerate(near))


@every
@pytest.mark.parametrize("scenario", [FLAGSHIP, TRACKING], ids=lambda scenario: scenario.name)
def test_commands_never_exceed_the_limits(name, scenario):
    wheels = WheelArray(scenario.spacecraft.wheels.axes, (0.05, 0.1, 0.2, 0.3), 12.0)
    spacecraft = Spacecraft(scenario.spacecraft.inertia, wheels)
    scenario = scenario.replace(spacecraft=spacecraft, initial_state=InitialState(max_rate=0.2))
    _, _, commands, _ = fly(scenario, name, count=16, duration=40.0)
    share = np.abs(commands) / wheels.torque_limits
    assert share.max() == pytest.approx(1.0) and share.max() <= 1.0 + 1e-12


@every
def test_the_rate_limit_is_kept(name):
    scenario = CALM.replace(initial_state=InitialState(angle=(2.5, 3.0)))
    _, slow, _, _ = fly(scenario, name, rate_limit=0.25, duration=60.0)
    speed = np.linalg.norm(slow, axis=2).max(axis=0)
    limit = 0.25 * baselines.make(name, scenario).scales.speed
    assert (speed > 0.9 * limit).all() and (speed < 1.15 * limit).all()


@every
def test_an_estimate_of_the_plant_is_used(name):
    """Half the inertia halves the torque in the linear range; nominal estimates change nothing."""
    inertia, count = FLAGSHIP.spacecraft.inertia_matrix, 4
    simulator = Simulator(CALM.replace(initial_state=InitialState(angle=1e-4, max_rate=1e-6)), count)
    simulator.reset(simulator.scenario.draw(0, count))
    measurement, commands = simulator.measurement(), []
    for plant in (
        None,
        PlantEstimate(np.tile(inertia, (count, 1, 1))),
        PlantEstimate(np.tile(inertia / 2, (count, 1, 1))),
    ):
        law = baselines.make(name, CALM, count)
        # Without estimators, which would set the plant.
        law._navigator, law.plant = None, plant
        commands.append(law.act(measurement) @ FLAGSHIP.spacecraft.wheels.axis_matrix.T)
    np.testing.assert_allclose(commands[1], commands[0], rtol=1e-9)
    np.testing.assert_allclose(commands[2], 0.5 * commands[0], rtol=1e-9)


@every
def test_braking_by_the_nominal_plant_leaves_the_estimates_out(name):
    """The demanded motion is that of no estimate, the torque that of half the inertia."""
    inertia, count = FLAGSHIP.spacecraft.inertia_matrix, 4
    error = np.tile(np.array([np.cos(0.5), *(np.sin(0.5) * np.array([0.6, 0.0, 0.8]))]), (count, 1))
    plant = PlantEstimate(np.tile(inertia / 2, (count, 1, 1)), np.tile([0.0, 10.0, 0.0], (count, 1)))
    speeds, torques = [], []
    for follows, estimate in ((False, plant), (False, None), (True, plant)):
        law = baselines.make(name, CALM, count, plant_braking=follows)
        law._navigator, law.plant = None, estimate
        speeds.append(law._slew(error, 1.0).speed)
        torques.append(law._torque(np.ones((count, 3))))
    np.testing.assert_array_equal(speeds[0], speeds[1])
    assert (speeds[2] < 0.9 * speeds[1]).all()
    np.testing.assert_allclose(torques[0], 0.5 * torques[1])


@pytest.mark.parametrize("name", ["lqr", "indi"])
def test_what_isolation_explains_is_compensated_once(name):
    """The observer learns the residual of the estimator alone; without one, all that commands do not explain."""
    estimates, commands = [], []
    for isolation in ("rate", "none"):
        _, _, command, law = fly(BIASED, name, count=4, isolation=isolation)
        estimates.append(law.memory["disturbance" if name == "lqr" else "filtered"])
        commands.append(command[-1] @ FLAGSHIP.spacecraft.wheels.axis_matrix.T)
    size = np.linalg.norm(BIAS_TORQUE)
    assert np.linalg.norm(estimates[0], axis=1).max() < 0.1 * size < 0.9 * size
    np.testing.assert_allclose(np.linalg.norm(estimates[1], axis=1), size, rtol=0.05)
    np.testing.assert_allclose(commands[0], commands[1], atol=0.02 * size)


@every
@pytest.mark.parametrize("size", [1e-3, 30.0])
def test_spacecraft_of_other_sizes_fly_the_same_motion(name, size):
    """Inertia, torques and momenta times the same number."""
    given = CALM.spacecraft
    wheels = WheelArray(given.wheels.axes, size * 0.2, size * 12.0)
    scaled = Spacecraft((size * given.inertia_matrix).tolist(), wheels)
    alike = Spacecraft(given.inertia, WheelArray(given.wheels.axes, 0.2, 12.0))
    start = InitialState(angle=(0.5, 1.5), wheel_momentum=0.0)
    errors, other = (
        fly(CALM.replace(spacecraft=body, initial_state=start), name, count=3, duration=40.0)[0]
        for body in (alike, scaled)
    )
    np.testing.assert_allclose(other, errors, rtol=1e-4, atol=1e-6)


@every
def test_at_rest_on_target_nothing_is_commanded(name):
    _, rates, commands, _ = fly(CALM.replace(initial_state=InitialState.fixed()), name, count=1, duration=5.0)
    np.testing.assert_allclose(commands, 0.0, atol=1e-12)
    np.testing.assert_allclose(rates, 0.0, atol=1e-12)


@pytest.mark.parametrize(
    ("name", "gains", "message"),
    [
        ("lqr", {"angle_weight": 0.0}, r"angle_weight must be positive, got 0\.0"),
        ("lqr", {"rate_weight": -1.0}, r"rate_weight must be positive, got -1\.0"),
        ("indi", {"filter_bandwidth": 0.0}, r"filter_bandwidth must be positive, got 0\.0"),
        ("indi", {"position_gain": 3.0}, r"position_gain must be below rate_gain = 1\.6"),
        ("super_twisting", {"step": np.nan}, "step must be finite, got nan"),
        ("super_twisting", {"largest_gain": 1.0}, r"largest_gain must be above least_gain = 4\.0, got 1\.0"),
    ],
)
def test_bad_gains(name, gains, message):
    with pytest.raises(ValueError, match=f"^{name}: {message}"):
        baselines.make(name, FLAGSHIP, **gains)
