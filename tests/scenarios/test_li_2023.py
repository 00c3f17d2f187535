"""Li, Xu and Chang 2023: the published numbers reach the plant."""

import math

import gymnasium as gym
import numpy as np
import pytest
from helpers.flexible_spacecraft import flown, integrated

import ftac_gym  # noqa: F401  (registers the environments)
from ftac_gym import scenarios
from ftac_gym.attitude import angle_between
from ftac_gym.dynamics import Simulator
from ftac_gym.faults import fault_effect
from ftac_gym.task import InitialState, Scenario

SHARES = {"li_2023": 1.0, "li_2023_weak": 0.2, "li_2023_printed_start": 1.0}
INERTIA = np.array([[350.0, 3.0, 4.0], [3.0, 270.0, 10.0], [4.0, 10.0, 190.0]])
DELTA = np.array(
    [
        [6.45637, 1.27814, 2.15629],
        [-1.25819, 0.91756, -1.67264],
        [1.11687, 2.48901, -0.83674],  # printed with the other sign
        [1.23637, -2.65810, -1.12530],
    ]
)
FREQUENCIES, RATIOS = (1.5362, 2.2076, 3.7466, 3.7466), (0.0056, 0.0086, 0.013, 0.013)
FIRST, SECOND, BEFORE = (0.3, 0.2, -0.4), (0.2, -0.1, -0.1), (0.1, -0.1, 0.1)
TIMES = (0.0, 1.0, 39.95, 40.05, 41.0, 55.7, 69.95, 70.05, 80.0, 99.95, 100.05, 123.4, 180.0, 199.95)


def torque(time):
    """u_d of the paper [N m]."""
    slow, fast = 0.2 * math.pi * time, 0.4 * math.pi * time
    return 1e-4 * np.array(
        [
            -3.0 + 4.0 * math.cos(slow) - math.cos(fast),
            4.0 + 3.0 * math.sin(slow) - 2.0 * math.cos(fast),
            -3.0 + 4.0 * math.sin(slow) - 3.0 * math.sin(fast),
        ]
    )


def fault(time, probe=None):
    """f of eq. (66) [N m]; ``probe`` is a time that is no event and decides which part holds."""
    probe = time if probe is None else probe
    first = 0.5 * max(time - 40.0, 0.0) ** 0.2 * math.sin(0.2 * (time - 40.0)) if probe > 40.0 else 0.0
    second = 1.0 if 40.0 < probe <= 70.0 else 1.5 if probe > 100.0 else 0.0
    return np.array([first, second, 0.0])


def misalignment():
    """Delta Gamma of the paper, its degrees taken as degrees."""
    a, b = np.radians([0.2, 0.1, 0.1]), np.radians([0.15, 0.1, 0.1])
    first, second, third = a * np.cos(b)
    return np.array([[0.0, second, third], [first, 0.0, third], [first, second, 0.0]])


def quaternion(vector):
    return np.array([math.sqrt(1.0 - np.dot(vector, vector)), *vector])


@pytest.mark.parametrize("name", SHARES)
def test_the_spacecraft(name):
    spacecraft = scenarios.get(name).spacecraft
    np.testing.assert_array_equal(spacecraft.inertia_matrix, INERTIA)
    np.testing.assert_array_equal(spacecraft.wheels.axis_matrix, np.eye(3))
    np.testing.assert_array_equal(spacecraft.wheels.torque_limits, 5.0)
    assert np.all(np.isinf(spacecraft.wheels.momentum_limits)) and not spacecraft.wheels.momentum_coupling
    np.testing.assert_array_equal(spacecraft.appendages.coupling, DELTA)
    assert spacecraft.appendages.coupling[2][2] == -0.83674
    assert spacecraft.appendages.frequencies == FREQUENCIES and spacecraft.appendages.damping_ratios == RATIOS
    np.testing.assert_allclose(np.linalg.eigvalsh(spacecraft.quick_inertia), [179.07, 254.68, 305.06], atol=0.005)
    np.testing.assert_allclose(spacecraft.quick_inertia, INERTIA - DELTA.T @ DELTA, atol=1e-12)
    assert not spacecraft.allow_unphysical_inertia
    np.testing.assert_allclose(
        spacecraft.appendages.stiffness, [2.35991044, 4.87349776, 14.03701156, 14.03701156], rtol=1e-12
    )
    np.testing.assert_allclose(
        spacecraft.appendages.damping, 2.0 * np.array(RATIOS) * np.array(FREQUENCIES), rtol=1e-14
    )  # fmt: skip


@pytest.mark.parametrize("name", SHARES)
def test_start_and_set_points(name):
    scenario = scenarios.get(name)
    simulator = Simulator(scenario, 1)
    simulator.reset(scenario.draw(0, 1))
    begin = FIRST if name == "li_2023_printed_start" else BEFORE
    np.testing.assert_allclose(simulator.state.attitude[0], quaternion(begin), atol=1e-15)
    np.testing.assert_array_equal(simulator.state.rate[0], [0.02, -0.03, 0.01])
    assert not simulator.state.modal_displacement.any() and not simulator.state.modal_rate.any()
    assert not simulator.state.wheel_momentum.any()
    assert scenario.duration == 200.0 and scenario.control_period == 0.05 and scenario.physics_step == 0.01
    assert scenario.sensors is None and scenario.inertia_uncertainty is None and scenario.tumble_rate is None
    assert scenario.appendage_uncertainty is None
    seen = []
    for _ in range(scenario.horizon):
        seen.append((simulator.time[0], *simulator.reference_attitude[0]))
        simulator.step(np.zeros((1, 3)))
    seen = np.array(seen)
    early = seen[:, 0] < 80.0 - 1e-9
    np.testing.assert_allclose(seen[early, 1:], np.tile(quaternion(FIRST), (early.sum(), 1)), atol=1e-15)
    np.testing.assert_allclose(seen[~early, 1:], np.tile(quaternion(SECOND), ((~early).sum(), 1)), atol=1e-15)
    assert early.sum() == 1600
    turned = np.degrees(angle_between(quaternion(BEFORE), quaternion(FIRST)))
    assert turned > 50.0 and np.degrees(angle_between(quaternion(FIRST), quaternion(SECOND))) > 40.0


@pytest.mark.parametrize("time", TIMES)
def test_the_external_torque(time):
    episodes = scenarios.get("li_2023").draw(0, 1)
    steady, harmonics = episodes.disturbance[0], episodes.harmonics[0]
    waves = sum(
        part["sine"] * np.sin(part["frequency"] * time) + part["cosine"] * np.cos(part["frequency"] * time)
        for part in harmonics
    )
    assert steady["rate_scaled"] == 0.0
    np.testing.assert_allclose(steady["constant"] + waves, torque(time), atol=1e-17)


@pytest.mark.parametrize(("name", "share"), SHARES.items())
@pytest.mark.parametrize("time", TIMES)
def test_the_faults(name, share, time):
    scenario = scenarios.get(name)
    effect = fault_effect(
        scenario.draw(0, 1).drawn_faults, np.array([time]), scenario.spacecraft.wheels, np.zeros((1, 3)),
        np.zeros((1, 3)),
    )  # fmt: skip
    np.testing.assert_allclose(effect.bias[0], share * fault(time), atol=1e-13)
    np.testing.assert_array_equal(effect.effectiveness[0], 1.0)
    assert not effect.delay.any() and not effect.rate_bias.any() and not effect.attitude_turn.any()


@pytest.mark.parametrize(("name", "share"), SHARES.items())
def test_the_wheels_give_what_the_faults_add(name, share):
    """Without a command, and with one beyond the limit: the fault comes after the limiter."""
    scenario = scenarios.get(name)
    for command, limited in ((0.0, 0.0), (9.0, 5.0)):
        simulator = Simulator(scenario, 1)
        simulator.reset(scenario.draw(0, 1))
        for _ in range(3000):
            before = simulator.state.wheel_momentum[0].copy()
            simulator.step(np.full((1, 3), command))
            middle = simulator.time[0] - 0.025
            mean = -(simulator.state.wheel_momentum[0] - before) / 0.05
            # The mean of the sharp rise at 40 s is not its middle.
            tolerance = 0.05 if 39.9 < middle < 40.1 else 1e-3 if 40.0 < middle < 42.0 else 1e-5
            np.testing.assert_allclose(mean, limited + share * fault(middle), atol=tolerance)


@pytest.mark.parametrize("name", SHARES)
def test_the_misalignment(name):
    """Small, in radians, and the same towards both other axes; only the true wheels have it."""
    scenario = scenarios.get(name)
    np.testing.assert_allclose(scenario.misalignment, misalignment(), atol=1e-18)
    np.testing.assert_allclose(np.max(scenario.misalignment), 0.00349065, atol=1e-8)
    assert not np.diag(scenario.misalignment).any()
    quiet = scenario.replace(
        initial_state=InitialState.fixed(), disturbance=None, faults=None, control_period=0.001, physics_step=0.001
    )
    for wheel in range(3):
        still = flown(quiet, np.zeros((1, 3)))[-1, 4:7]
        pushed = flown(quiet, np.eye(3)[[wheel]])[-1, 4:7]
        # For a millisecond a torque turns the body without what the modes hold.
        change = (INERTIA - DELTA.T @ DELTA) @ (pushed - still) / 0.001
        np.testing.assert_allclose(change, (np.eye(3) + misalignment())[:, wheel], rtol=0.0, atol=5e-6)


@pytest.mark.parametrize("name", ["li_2023", "li_2023_weak"])
def test_the_plant_is_that_of_the_paper(name):
    """Across 40 and 70 s, with commands beyond the limit, by the equations (2) as they are printed."""
    scenario = scenarios.get(name).replace(control_period=0.1, physics_step=0.005)
    share, axes = SHARES[name], np.eye(3) + misalignment()
    rng = np.random.default_rng(0)
    commands = 7.0 * np.sin(np.linspace(0.0, 40.0, 720)[:, None] * [1.0, 1.3, 0.7]) + rng.uniform(-1.0, 1.0, (720, 3))
    seen = flown(scenario, commands)
    clipped = np.clip(commands, -5.0, 5.0)
    spans = [(0, 400), (400, 700), (700, 720)]
    state, states = seen[0], [seen[0]]
    for begin, end in spans:
        probe = 0.1 * begin + 0.05

        def extra(time, rate, start=0.1 * begin, probe=probe):
            return torque(start + time) + axes @ (share * fault(start + time, probe))

        part = integrated(
            state, clipped[begin:end], 0.1, scenario.spacecraft.appendages, axes, False, lambda time: INERTIA,
            external=extra,
        )  # fmt: skip
        state = part[-1]
        states.extend(part[1:])
    expected = np.array(states)
    columns = [*range(7), *range(10, 18)]  # the wheels' momentum has the faults too
    np.testing.assert_allclose(seen[:, columns], expected[:, columns], rtol=0.0, atol=2e-9)
    np.testing.assert_allclose(seen[:401, columns], expected[:401, columns], rtol=0.0, atol=1e-9)
    assert np.abs(expected[:, 10:14]).max() > 0.01


def test_the_variants_differ_in_nothing_else():
    plain = {name: scenarios.get(name).to_dict() for name in SHARES}
    for name, data in plain.items():
        assert data.pop("name") == name
        assert Scenario.from_json(scenarios.get(name).to_json()) == scenarios.get(name)
    weak, printed = plain["li_2023_weak"], plain["li_2023_printed_start"]
    for strong, faint in zip(plain["li_2023"]["faults"]["faults"], weak["faults"]["faults"], strict=True):
        for part in ("amplitude", "constant"):
            assert faint.pop(part) == pytest.approx(0.2 * strong.pop(part))
        assert strong == faint
    rest = {name: {key: value for key, value in data.items() if key != "faults"} for name, data in plain.items()}
    assert rest["li_2023"] == rest["li_2023_weak"]
    assert printed.pop("initial_state") != plain["li_2023"].pop("initial_state")
    rest["li_2023"].pop("initial_state")
    rest["li_2023_printed_start"].pop("initial_state")
    assert rest["li_2023"] == rest["li_2023_printed_start"]


def test_nothing_is_random_and_the_task_can_be_done():
    for name in SHARES:
        episodes = scenarios.get(name).draw(7, 3)
        assert episodes.feasible.all()
        for array in (episodes.modes, episodes.initial, episodes.faults["bias"], episodes.harmonics):
            assert len(np.unique(array, axis=0)) == 1 if array.dtype.names is None else len({*map(bytes, array)}) == 1


def test_environments_can_be_made():
    env = gym.make("SpacecraftFTCLi2023-v0")
    assert env.unwrapped.scenario == scenarios.get("li_2023")
    observation, _ = env.reset(seed=0)
    assert env.observation_space.contains(observation) and env.action_space.shape == (3,)
    env.step(np.zeros(3))
    weak = gym.make("SpacecraftFTCLi2023-v0", scenario="li_2023_weak")
    assert weak.unwrapped.scenario == scenarios.get("li_2023_weak")
    vector = gym.make_vec("SpacecraftFTCLi2023-v0", num_envs=3)
    observations, _ = vector.reset(seed=0)
    assert vector.observation_space.contains(observations)
