"""The prediction over the loop delay, against the simulator one delay later."""

import numpy as np
import pytest

from ftac_gym import baselines, scenarios
from ftac_gym.attitude import angle_between, rotate_to_body
from ftac_gym.baselines.estimators.navigator import NavigationGains, Navigator
from ftac_gym.baselines.estimators.prediction import DelayPrediction
from ftac_gym.baselines.memory import Memory
from ftac_gym.dynamics import Simulator
from ftac_gym.faults import FaultSchedule, HardOver
from ftac_gym.task import Disturbance, InitialState

TORQUE = (4e-3, -3e-3, 5e-3)  # N m
COUNT = 12
CLEAN = scenarios.get("flagship").replace(
    faults=None, sensors=None, inertia_uncertainty=None, disturbance=Disturbance(TORQUE), physics_step=0.01,
    initial_state=InitialState(max_rate=0.08, wheel_momentum=(-4.0, 4.0)),
)  # fmt: skip
"""A rotating spacecraft with momentum stored in its wheels, measured without errors."""


def at(delay, period=0.1):
    step = period / 10.0
    return CLEAN.replace(loop_delay=round(delay / step) * step, control_period=period, physics_step=step)


def total_momentum(simulator):
    """Return the angular momentum (N, 3) of body and wheels, in body axes [N m s]."""
    spacecraft, state = simulator.scenario.spacecraft, simulator.state
    return state.rate @ spacecraft.inertia_matrix + state.wheel_momentum @ spacecraft.wheels.axis_matrix.T


def flown(scenario, steps, predicted, amplitude=0.15):
    """Fly random commands; return the errors of attitude (T, N) [rad] and rate (T, N, 3) [rad/s] after the delay.

    ``predicted(simulator, measurement)`` gives attitude and rate after the delay, which the physics steps hit.
    """
    simulator = Simulator(scenario, COUNT)
    simulator.reset(scenario.draw(3, COUNT))
    # A second flight of the same commands shows the state between two control periods.
    substeps, random = scenario.delay_steps, np.random.default_rng(1)
    per_period = scenario.substeps
    fine = Simulator(scenario.replace(control_period=scenario.physics_step), COUNT)
    fine.reset(scenario.replace(control_period=scenario.physics_step).draw(3, COUNT))
    for name in ("attitude", "rate", "wheel_momentum"):
        np.testing.assert_array_equal(getattr(fine.state, name), getattr(simulator.state, name))
    truth, guesses = [], []
    for _ in range(steps):
        guesses.append(predicted(simulator, simulator.measurement()))
        command = random.uniform(-amplitude, amplitude, (COUNT, 4))
        simulator.step(command)
        for _ in range(per_period):
            truth.append((fine.state.attitude.copy(), fine.state.rate.copy()))
            fine.step(command)
    after = range(substeps, len(truth), per_period)
    pairs = [(guess, truth[k]) for guess, k in zip(guesses, after, strict=False)]
    angles = np.array([angle_between(guess[0], true[0]) for guess, true in pairs])
    return angles, np.array([guess[1] - true[1] for guess, true in pairs])


def exact(scenario):
    """Return a prediction that has the true plant."""
    memory = Memory(COUNT)
    prediction = DelayPrediction(scenario, memory)
    inertia = np.repeat(scenario.spacecraft.inertia_matrix[None], COUNT, axis=0)
    torque = np.tile(TORQUE, (COUNT, 1))

    def predicted(simulator, measurement):
        state, momentum = simulator.state, total_momentum(simulator)
        return prediction.ahead(measurement, state.attitude, state.rate, inertia, momentum, torque, **HEALTHY)[:2]

    return predicted


HEALTHY = {
    "response": np.ones((COUNT, 4)), "level": np.zeros((COUNT, 4)), "late": np.zeros(COUNT, dtype=np.int64)
}  # fmt: skip
DELAYS = [0.02, 0.05, 0.1, 0.13, 0.2, 0.37, 0.5]


@pytest.mark.parametrize("delay", DELAYS)
def test_the_true_plant_gives_the_state_one_delay_later(delay):
    scenario = at(delay)
    angles, rates = flown(scenario, 40, exact(scenario))
    assert scenario.loop_delay == pytest.approx(delay) and len(angles) > 30
    # The body moves by up to 0.08 rad/s times the delay, and its rate by 0.03 rad/s^2 times the delay.
    assert angles.max() < 2e-5 * delay and np.abs(rates).max() < 1e-4 * delay


def test_the_error_has_the_order_of_the_integrator():
    """One midpoint step of the delay: the error falls with the third power of its length."""
    sizes = []
    for period in (0.4, 0.2):
        scenario = at(period, period)
        angles, rates = flown(scenario, 12, exact(scenario))
        # After the same commands: the first is flown from the start.
        sizes.append((np.sqrt(np.mean(angles[1:] ** 2)), np.sqrt(np.mean(rates[1:] ** 2))))
    assert sizes[0][0] / sizes[1][0] > 5.0 and sizes[0][1] / sizes[1][1] > 5.0


def test_the_momentum_is_carried_on():
    """It is constant in inertial axes, so that a second prediction can start where the first ends."""
    scenario = at(0.3).replace(disturbance=Disturbance())
    simulator, memory = Simulator(scenario, COUNT), Memory(COUNT)
    simulator.reset(scenario.draw(3, COUNT))
    prediction = DelayPrediction(scenario, memory)
    inertia = np.repeat(scenario.spacecraft.inertia_matrix[None], COUNT, axis=0)
    state, momentum = simulator.state, total_momentum(simulator)
    attitude, _, delay = prediction.ahead(
        simulator.measurement(), state.attitude, state.rate, inertia, momentum, np.zeros((COUNT, 3)), **HEALTHY
    )
    np.testing.assert_allclose(delay, scenario.loop_delay)
    for _ in range(3):
        simulator.step(np.zeros((COUNT, 4)))
    np.testing.assert_allclose(momentum, total_momentum(simulator), atol=1e-5)
    assert np.abs(attitude - state.attitude).max() < 1e-6


def test_a_wheel_that_ignores_its_command_is_predicted_so():
    scenario = at(0.2).replace(
        faults=FaultSchedule((HardOver(wheel=1, onset=0.0, fraction=0.4, random_sign=False),)),
    )  # fmt: skip
    memory = Memory(COUNT)
    prediction = DelayPrediction(scenario, memory)
    inertia = np.repeat(scenario.spacecraft.inertia_matrix[None], COUNT, axis=0)
    response, level = np.ones((COUNT, 4)), np.zeros((COUNT, 4))
    response[:, 1], level[:, 1] = 0.0, 0.4 * 0.2

    def predicted(simulator, measurement, **wheels):
        state, momentum, torque = simulator.state, total_momentum(simulator), np.tile(TORQUE, (COUNT, 1))
        parts = {**HEALTHY, **wheels}
        return prediction.ahead(measurement, state.attitude, state.rate, inertia, momentum, torque, **parts)[:2]

    told = flown(scenario, 30, lambda *seen: predicted(*seen, response=response, level=level))
    untold = flown(scenario, 30, predicted)
    assert np.abs(told[1]).max() < 2e-5 and np.abs(untold[1]).max() > 50.0 * np.abs(told[1]).max()


# -------------------------------------------------------------------------------------------- by the nominal spacecraft


@pytest.mark.parametrize("delay", [0.1, 0.13, 0.3])
def test_a_constant_torque_is_not_left_out(delay):
    """At rest, the nominal prediction errs by half the angle that the torque gives at first, and by nothing later."""
    scenario = at(delay).replace(initial_state=InitialState.fixed())
    memory = Memory(COUNT)
    prediction = DelayPrediction(scenario, memory)

    def predicted(simulator, measurement):
        return prediction.nominal(measurement, measurement.attitude, measurement.rate)

    angles, rates = flown(scenario, 60, predicted, amplitude=0.0)
    acceleration = np.linalg.norm(np.linalg.solve(scenario.spacecraft.inertia_matrix, TORQUE))
    assert np.linalg.norm(rates[0, 0]) == pytest.approx(acceleration * delay, rel=0.02)
    assert angles[0, 0] == pytest.approx(0.5 * acceleration * delay**2, rel=0.02)
    assert angles[30:].max() < 1e-3 * angles[0, 0] + 1e-8
    assert np.abs(rates[30:]).max() < 1e-3 * acceleration * delay


@pytest.mark.parametrize("isolation", ["none", "rate"])
@pytest.mark.parametrize("delay", [0.1, 0.3])
def test_no_steady_error_is_left_behind_a_controller(delay, isolation):
    scenario = at(delay).replace(initial_state=InitialState.fixed((1.0, 0.0, 0.005, 0.0)), duration=200.0)
    simulator = Simulator(scenario, 1)
    simulator.reset(scenario.draw(0, 1))
    baseline = baselines.make("pd_dob", scenario, isolation=isolation)
    for _ in range(1200):
        simulator.step(baseline.act(simulator.measurement()))
    # The law of pd alone would be off by torque over stiffness, some 1e-3 rad.
    assert angle_between(simulator.state.attitude, simulator.reference_attitude)[0] < 2e-6
    assert np.abs(simulator.state.rate).max() < 1e-7


def test_without_a_delay_nothing_is_added():
    prompt = CLEAN.replace(loop_delay=0.0)
    memory = Memory(COUNT)
    navigator = Navigator(prompt, memory, NavigationGains())
    assert navigator.prediction is None and memory.copy() == {}
    late = baselines.make("nftsm", CLEAN.replace(loop_delay=0.1))
    added = set(late.memory.copy()) - set(baselines.make("nftsm", prompt).memory.copy())
    assert "commands_on_their_way" in added
    simulator = Simulator(prompt, COUNT)
    simulator.reset(prompt.draw(0, COUNT))
    measurement = simulator.measurement()
    seen, plant = navigator.update(measurement)
    assert plant is None
    for name in ("time", "attitude", "rate", "reference_attitude", "command_in_effect"):
        np.testing.assert_array_equal(getattr(seen, name), getattr(measurement, name))


@pytest.mark.parametrize("name", ["flagship_tracking", "flagship"])
def test_the_reference_is_that_of_the_later_moment(name):
    scenario = scenarios.get(name).replace(faults=None, sensors=None, loop_delay=0.2)
    simulator = Simulator(scenario, COUNT)
    simulator.reset(scenario.draw(1, COUNT))
    navigator = Navigator(scenario, Memory(COUNT), NavigationGains())
    for _ in range(20):
        simulator.step(np.zeros((COUNT, 4)))
    seen, _ = navigator.update(simulator.measurement())
    for _ in range(2):
        simulator.step(np.zeros((COUNT, 4)))
    np.testing.assert_allclose(seen.time, simulator.time)
    assert angle_between(seen.reference_attitude, simulator.reference_attitude).max() < 1e-6
    np.testing.assert_allclose(seen.reference_rate, simulator.reference_rate, atol=2e-5)


def test_a_reset_forgets_the_commands_of_the_last_episode():
    scenario = at(0.3)
    memory = Memory(2)
    prediction = DelayPrediction(scenario, memory)
    simulator = Simulator(scenario, 2)
    simulator.reset(scenario.draw(0, 2))
    for _ in range(5):
        measurement = simulator.measurement()
        prediction.nominal(measurement, measurement.attitude, measurement.rate)
        simulator.step(np.full((2, 4), 0.1))
    before = memory.copy()
    memory.reset(np.array([True, False]))
    assert np.all(memory["commands_on_their_way"][0] == 0.0) and np.all(memory["commands_on_their_way"][1] != 0.0)
    assert np.isnan(memory["predicted_from"][0]).all()
    for name, array in before.items():
        np.testing.assert_array_equal(memory[name][1], array[1])


def test_momentum_in_body_axes_is_that_of_the_rotation():
    """The test's own reading of body axes is that of the package."""
    scenario = at(0.1).replace(disturbance=Disturbance())
    simulator = Simulator(scenario, COUNT)
    simulator.reset(scenario.draw(3, COUNT))
    start = total_momentum(simulator)
    q = simulator.state.attitude.copy()
    for _ in range(10):
        simulator.step(np.full((COUNT, 4), 0.1))
    back = rotate_to_body(q * np.array([1.0, -1.0, -1.0, -1.0]), start)
    np.testing.assert_allclose(rotate_to_body(simulator.state.attitude, back), total_momentum(simulator), atol=1e-6)
