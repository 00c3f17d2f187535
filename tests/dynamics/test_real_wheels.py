"""Real wheels in the plant: friction, coming to rest, lag, dead-band, power limit and speed limit."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from ftac_gym.dynamics import Simulator
from ftac_gym.faults import DriftingEffectiveness, FaultSchedule, FrictionRise, HardOver, LossOfEffectiveness, Outage
from ftac_gym.friction import Friction
from ftac_gym.initial_state import InitialState
from ftac_gym.scenario import Scenario
from ftac_gym.spacecraft import Spacecraft
from ftac_gym.wheels import WheelArray

LIMIT, SPIN = 0.2, 0.02  # N m, kg m^2


def start(count, *faults, momentum=0.0, step=0.02, period=0.1, torque_limit=LIMIT, **parts):
    """A craft with that many wheels about one axis; the body is of no interest."""
    axes = np.zeros((3, count))
    axes[2] = 1.0
    scenario = Scenario(
        name="wheels",
        spacecraft=Spacecraft(np.diag([10.0, 12.0, 14.0]), WheelArray(axes, torque_limit, **parts)),
        initial_state=InitialState.fixed(wheel_momentum=momentum),
        faults=FaultSchedule(faults) if faults else None,
        control_period=period,
        physics_step=step,
        duration=100.0 * period,
    )
    simulator = Simulator(scenario, 1)
    simulator.reset(scenario.draw(0, 1))
    return simulator


def run(simulator, commands):
    """Return torque on the body and momentum (T, m) after each control period."""
    torque, momentum = [], []
    for command in commands:
        simulator.step(np.broadcast_to(command, simulator.last_command.shape))
        torque.append(simulator.state.wheel_torque[0].copy())
        momentum.append(simulator.state.wheel_momentum[0].copy())
    return np.array(torque), np.array(momentum)


# -------------------------------------------------------------------------------------------------- far from rest


@pytest.mark.parametrize(("step", "period"), [(0.02, 0.1), (0.1, 0.1), (0.001, 0.1), (0.5, 0.5)])
@pytest.mark.parametrize("command", [0.0, 0.015, -0.02])
def test_a_spinning_wheel_follows_the_closed_form(step, period, command):
    viscous = 2e-3
    frictions = (
        Friction(viscous=viscous),
        Friction(coulomb=4e-3),
        Friction(coulomb=4e-3, breakaway=9e-3, viscous=viscous),
        Friction(coulomb=4e-3, breakaway=9e-3, viscous=viscous),
        None,
    )
    initial = np.array([2.0, -1.0, 3.0, -2.5, 1.0])
    simulator = start(
        5,
        FrictionRise(wheel=3, factor=3.0, rise=0.0),
        momentum=initial,
        step=step,
        period=period,
        spin_inertia=SPIN,
        friction=frictions,
    )
    torque, momentum = run(simulator, np.full((round(10.0 / period), 1), command))
    time = period * np.arange(1, len(momentum) + 1)
    push = command + np.sign(initial) * np.array([0.0, 4e-3, 4e-3, 12e-3, 0.0])
    for wheel in range(5):
        if wheel in (0, 2, 3):
            rate = viscous / SPIN
            expected = (initial[wheel] + push[wheel] / rate) * np.exp(-rate * time) - push[wheel] / rate
            drag = rate * expected
        else:
            expected = initial[wheel] - push[wheel] * time
            drag = 0.0
        assert np.abs(expected).min() > 0.02  # more than 0.75 rad/s
        np.testing.assert_allclose(momentum[:, wheel], expected, rtol=0.0, atol=2e-12)
        np.testing.assert_allclose(torque[:, wheel], push[wheel] + drag, rtol=0.0, atol=1e-12)


@pytest.mark.parametrize(("direction", "sides"), [("forward", [3.0, 1.0]), ("backward", [1.0, 3.0]), ("both", [3, 3])])
def test_friction_rises_in_its_direction_only(direction, sides):
    faults = [FrictionRise(wheel=wheel, factor=3.0, rise=4.0, onset=1.0, direction=direction) for wheel in (0, 1)]
    simulator = start(2, *faults, momentum=(1.0, -1.0), spin_inertia=SPIN, friction=Friction(coulomb=2e-3))
    torque, momentum = run(simulator, np.zeros((100, 1)))
    time = 0.1 * np.arange(1, 101)
    grown = np.clip((time - 1.0) / 4.0, 0.0, 1.0)
    impulse = np.where(time < 1.0, 0.0, 2.0 * grown**2 + np.maximum(time - 5.0, 0.0))  # of the growth of 1
    for wheel, sign in ((0, 1.0), (1, -1.0)):
        growth = sides[wheel] - 1.0
        lost = 2e-3 * (time + growth * impulse)
        np.testing.assert_allclose(momentum[:, wheel], sign * (1.0 - lost), rtol=0.0, atol=1e-12)
        # The friction of a physics step is that in its middle.
        middle = np.where(time <= 1.0, 0.0, np.clip((time - 1.01) / 4.0, 0.0, 1.0))
        np.testing.assert_allclose(torque[:, wheel], sign * 2e-3 * (1.0 + growth * middle), rtol=0.0, atol=1e-12)


def test_a_wheel_whose_friction_has_risen_stops_at_once_and_stays():
    # "Full torque while the spin rate dropped to zero": friction beyond the motor.
    fault = FrictionRise(wheel=0, factor=20.0, rise=2.0)
    friction = Friction(coulomb=2e-3, breakaway=2.5e-3)
    simulator = start(1, fault, momentum=0.1, torque_limit=0.02, spin_inertia=SPIN, friction=friction)
    _, momentum = run(simulator, np.full((100, 1), -0.02))
    stopped = np.flatnonzero(np.abs(momentum[:, 0]) < 1e-3)[0]
    assert momentum[:9, 0].min() > 0.1 and stopped < 70
    speed = momentum[stopped + 5 :, 0] / SPIN
    assert np.all(speed > 0.0) and np.all(speed < 0.01)  # it creeps where friction holds the motor


# ------------------------------------------------------------------------------------------------- coming to rest


def log_uniform(low, high):
    return st.floats(np.log10(low), np.log10(high)).map(lambda exponent: 10.0**exponent)


@st.composite
def rubbing(draw):
    """Spin inertia, friction and initial speed of a wheel, whose drag can be anything from tiny to huge."""
    coulomb = draw(log_uniform(1e-8, 1.0)) if draw(st.integers(0, 5)) else 0.0
    breakaway = coulomb + draw(st.sampled_from([0.0, 0.2, 1.0, 10.0]) if coulomb else st.just(1.0)) * (coulomb or 1e-3)
    viscous = draw(st.just(0.0) | log_uniform(1e-9, 1e-1))
    friction = Friction(coulomb, breakaway, draw(log_uniform(1e-4, 1e2)), viscous)
    return draw(log_uniform(1e-6, 1.0)), friction, draw(log_uniform(1e-4, 1e3)) * draw(st.sampled_from([-1.0, 1.0]))


WHEELS = st.lists(rubbing(), min_size=8, max_size=8)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(WHEELS, st.sampled_from([0.1, 0.02, 0.003]), st.sampled_from([1.0, 20.0]), st.integers(0, 1000))
def test_a_dead_wheel_only_slows_down(wheels, step, factor, seed):
    inertia = np.array([wheel[0] for wheel in wheels])
    friction = tuple(wheel[1] for wheel in wheels)
    initial = inertia * np.array([wheel[2] for wheel in wheels])
    faults = [Outage(wheel=wheel) for wheel in range(8)]
    faults += [FrictionRise(wheel=wheel, factor=factor, rise=0.0) for wheel in range(8)]
    simulator = start(8, *faults, momentum=initial, step=step, period=step, spin_inertia=inertia, friction=friction)
    commands = np.random.default_rng(seed).uniform(-LIMIT, LIMIT, (40, 8))
    torque, momentum = run(simulator, commands)
    sizes = np.sign(initial) * np.array([initial, *momentum])
    assert np.all(sizes >= 0.0) and np.all(np.diff(sizes, axis=0) <= 0.0)
    assert np.all(torque * momentum >= 0.0)


@st.composite
def held(draw):
    """Friction, time constant at rest in physics steps, and a share of the breakaway torque."""
    coulomb = draw(log_uniform(1e-6, 1.0))
    breakaway = coulomb * draw(st.sampled_from([1.0, 1.2, 3.0, 11.0]))
    friction = Friction(coulomb, breakaway, draw(log_uniform(1e-4, 1e2)), coulomb * draw(st.sampled_from([0.0, 1e-3])))
    return friction, draw(log_uniform(1e-8, 0.1)), draw(st.floats(0.05, 0.95))


@settings(max_examples=30, deadline=None, derandomize=True)
@given(
    st.lists(held(), min_size=8, max_size=8),
    st.sampled_from([0.1, 0.02, 0.003]),
    st.sampled_from([-1.0, 1.0]),
    st.sampled_from(["rest", "same", "opposite"]),
)
def test_a_wheel_pushed_less_than_its_friction_creeps_where_friction_holds_the_motor(wheels, step, sign, spinning):
    command, expected, inertia, initial = np.zeros((4, 8))
    for wheel, (friction, steps, share) in enumerate(wheels):
        inertia[wheel] = friction.coulomb * steps * step / friction.coulomb_speed
        fastest = friction.stribeck_speed * np.linspace(0.01, 3.0, 300)
        peak = fastest[np.argmax(friction.dry(fastest))]
        command[wheel] = sign * share * (friction.torque(peak) if spinning == "rest" else friction.coulomb)
        pushed = abs(command[wheel])
        size = brentq(lambda w, f=friction, u=pushed: f.torque(w) - u, 0.0, peak, xtol=1e-300, rtol=1e-14)
        expected[wheel] = -sign * size * inertia[wheel]
        # Fifty steps of the net torque on the spinning wheel.
        largest = min(20.0 * friction.breakaway_speed * inertia[wheel], 50.0 * step * friction.coulomb * (1.0 - share))
        initial[wheel] = {"rest": 0.0, "same": -sign, "opposite": sign}[spinning] * largest
    simulator = start(
        8, momentum=initial, step=step, period=step, torque_limit=20.0, spin_inertia=inertia,
        friction=tuple(wheel[0] for wheel in wheels),
    )  # fmt: skip
    torque, momentum = run(simulator, np.tile(command, (600, 1)))
    np.testing.assert_allclose(momentum[-1], expected, rtol=1e-9)
    np.testing.assert_allclose(momentum[-100:], np.tile(momentum[-1], (100, 1)), rtol=1e-9)
    assert np.abs(torque[-1] / command).max() < 1e-6
    if spinning != "opposite":
        assert np.all(momentum * -sign >= 0.0)


def test_static_friction_holds_a_motor_that_sliding_friction_would_not():
    friction = Friction(coulomb=5e-5, breakaway=1.5e-4)
    held = start(1, torque_limit=0.004, spin_inertia=2.4e-5, friction=friction)
    _, momentum = run(held, np.full((300, 1), 1.4e-4))
    assert np.abs(momentum).max() / 2.4e-5 < 0.1  # rad/s
    _, momentum = run(held, np.full((10, 1), 1.6e-4))  # beyond breakaway ...
    _, momentum = run(held, np.full((300, 1), 1.4e-4))  # ... it does not stop again
    assert -momentum[-1, 0] / 2.4e-5 > 50.0


def test_a_dead_wheel_comes_to_rest_entirely():
    simulator = start(1, Outage(wheel=0), momentum=0.01, spin_inertia=SPIN, friction=Friction(2e-3, 3e-3, viscous=1e-4))
    torque, momentum = run(simulator, np.full((200, 1), 0.2))
    stopped = np.flatnonzero(momentum[:, 0] == 0.0)[0]
    assert 30 < stopped < 120
    assert np.all(momentum[stopped:] == 0.0) and np.all(torque[stopped:] == 0.0)


def test_huge_spin_inertia_is_a_wheel_that_hardly_turns():
    friction = Friction(coulomb=0.1, breakaway=0.2, viscous=0.5)
    command = np.random.default_rng(0).uniform(-0.2, 0.2, (50, 1))
    torque, momentum = run(start(1, spin_inertia=1e12, friction=friction), command)
    np.testing.assert_allclose(torque, command, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(momentum, -0.1 * np.cumsum(command, axis=0), rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("viscous", [1e2, 1e5])
def test_friction_far_stiffer_than_the_step(viscous):
    torque, momentum = run(
        start(1, momentum=1.0, spin_inertia=SPIN, friction=Friction(viscous=viscous)), np.full((5, 1), 0.1)
    )
    np.testing.assert_allclose(momentum[:, 0], -0.1 * SPIN / viscous, rtol=1e-12)
    assert np.abs(torque).max() < 1e-12


# -------------------------------------------------------------------------------------------------------------- lag


@pytest.mark.parametrize(("step", "period"), [(0.02, 0.1), (0.1, 0.1), (0.001, 0.1), (0.5, 0.5)])
@pytest.mark.parametrize("lag", [0.05, 0.7, 1e-3])
def test_a_lag_answers_exponentially_whatever_the_step(lag, step, period):
    simulator = start(1, step=step, period=period, lag=lag)
    motor, stored = 0.0, 0.0
    for command in np.random.default_rng(0).uniform(-0.3, 0.3, 30):
        torque, momentum = run(simulator, [command])
        limited = np.clip(command, -LIMIT, LIMIT)
        left = np.exp(-period / lag)
        stored -= limited * period - (limited - motor) * lag * (1.0 - left)
        motor = limited - (limited - motor) * left
        assert torque[0, 0] == pytest.approx(motor, abs=1e-14)
        assert simulator.state.motor_torque[0, 0] == pytest.approx(motor, abs=1e-14)
        assert momentum[0, 0] == pytest.approx(stored, abs=1e-13)


def test_a_lag_has_unit_gain_in_the_end():
    torque, _ = run(start(2, lag=(0.05, 0.3)), np.tile([0.123, -0.05], (200, 1)))
    np.testing.assert_allclose(torque[-1], [0.123, -0.05], rtol=1e-15)


@pytest.mark.parametrize("viscous", [0.0, 4e-3])
def test_a_lag_under_varying_effectiveness(viscous):
    faults = (
        LossOfEffectiveness(wheel=0, effectiveness=0.5, amplitude=0.4, frequency=3.0, phase=0.3),
        DriftingEffectiveness(wheel=1, onset=1.0, effectiveness=0.2, rise=3.0),
    )
    lag, command = np.array([0.3, 0.5]), 0.15
    friction = Friction(viscous=viscous) if viscous else None
    simulator = start(2, *faults, momentum=1.0, step=0.01, lag=lag, spin_inertia=SPIN, friction=friction)
    torque, momentum = run(simulator, np.full((50, 1), command))

    def derivative(time, state):
        motor, stored = state[:2], state[2:]
        share = np.array([0.5 + 0.4 * np.sin(3.0 * time + 0.3), 1.0 - 0.8 * np.clip((time - 1.0) / 3.0, 0.0, 1.0)])
        return np.concatenate([(command - motor) / lag, -share * motor - viscous / SPIN * stored])

    solution = solve_ivp(
        derivative, (0.0, 5.0), [0.0, 0.0, 1.0, 1.0], "DOP853", 0.1 * np.arange(1, 51), rtol=1e-12, atol=1e-13,
        max_step=0.05,
    )  # fmt: skip
    np.testing.assert_allclose(momentum, solution.y[2:].T, rtol=0.0, atol=1e-9)
    share = np.array([0.5 + 0.4 * np.sin(15.3), 0.2])
    expected = share * solution.y[:2, -1] + viscous / SPIN * solution.y[2:, -1]
    np.testing.assert_allclose(torque[-1], expected, rtol=0.0, atol=1e-9)


# ----------------------------------------------------------------------------------------------------------- limits


def test_the_dead_band_swallows_small_commands_and_nothing_else():
    commands = np.array([0.0, 0.0099, 0.01, 0.0101, -0.0099, -0.01, -0.15, 0.5, -0.5])
    torque, _ = run(start(1, dead_band=0.01), commands)
    np.testing.assert_array_equal(torque[:, 0], [0.0, 0.0, 0.01, 0.0101, 0.0, -0.01, -0.15, 0.2, -0.2])


def test_the_torque_limit_comes_before_the_dead_band():
    torque, momentum = run(start(2, dead_band=(0.2, 0.201)), np.full((5, 1), 3.0))
    np.testing.assert_array_equal(torque, np.tile([0.2, 0.0], (5, 1)))
    np.testing.assert_array_equal(momentum[:, 1], 0.0)


def test_the_dead_band_comes_before_the_lag():
    torque, _ = run(start(1, dead_band=0.01, lag=0.2), [0.2] * 20 + [0.009] * 20)
    np.testing.assert_allclose(torque[20:, 0], torque[19, 0] * np.exp(-0.5 * np.arange(1, 21)), rtol=1e-12)


def test_the_dead_band_looks_at_the_command_not_at_the_fault():
    fault = LossOfEffectiveness(wheel=0, effectiveness=0.1)
    torque, _ = run(start(1, fault, dead_band=0.01), [0.02, 0.009])
    np.testing.assert_allclose(torque[:, 0], [0.002, 0.0])


@pytest.mark.parametrize("step", [0.1, 0.02, 0.005])
def test_constant_power(step):
    power = 1.0  # W: the limit takes over at 5 rad/s
    simulator = start(1, step=step, power_limit=power, spin_inertia=SPIN)
    torque, momentum = run(simulator, np.full((200, 1), -0.2))
    time = 0.1 * np.arange(1, 201)
    corner = power * SPIN / 0.2
    expected = np.sqrt(corner**2 + 2.0 * power * SPIN * np.maximum(time - corner / 0.2, 0.0))
    expected = np.where(0.2 * time < corner, 0.2 * time, expected)
    np.testing.assert_allclose(momentum[:, 0], expected, rtol=1e-4 * step / 0.02)
    np.testing.assert_allclose(torque[10:] * momentum[10:] / SPIN, -power, rtol=1e-12)
    # The way back is the same: the limit holds for braking too.
    torque, back = run(simulator, np.full((200, 1), 0.2))
    np.testing.assert_allclose(back[:-1, 0], momentum[-2::-1, 0], atol=2e-4 * step / 0.02)
    assert abs(back[-1, 0]) < 1e-3


def test_the_power_limit_is_never_exceeded():
    friction = Friction(coulomb=2e-3, breakaway=4e-3, viscous=1e-5)
    power = np.array([0.5, 1.0, 2.0, 5.0])
    simulator = start(
        4,
        HardOver(wheel=0, onset=2.0, recovery=20.0, random_sign=False),
        HardOver(wheel=1, onset=15.0, fraction=-0.9, random_sign=False),
        FrictionRise(wheel=2, factor=5.0, rise=10.0),
        power_limit=power,
        spin_inertia=SPIN,
        friction=friction,
        lag=0.05,
    )
    limited = np.zeros(4, dtype=int)
    for step in range(400):
        torque, momentum = run(simulator, 0.2 * np.sign(np.sin(0.02 * step + np.arange(4))))
        speed = momentum[0] / SPIN
        factor = np.array([1.0, 1.0, 1.0 + 4.0 * np.clip((0.1 * (step + 1) - 0.01) / 10.0, 0.0, 1.0), 1.0])
        drag = factor * friction.dry(speed) + 1e-5 * speed
        used = np.abs((torque[0] - drag) * speed)
        assert np.all(used <= power * (1.0 + 1e-9))
        limited += used > 0.999 * power
    assert np.all(limited > 50)


def test_the_speed_limit_blocks_what_accelerates_and_nothing_else():
    friction = Friction(coulomb=2e-3)
    simulator = start(2, momentum=(0.9, -0.9), spin_inertia=SPIN, speed_limit=50.0, friction=friction, lag=0.05)
    torque, momentum = run(simulator, np.tile([-0.2, 0.2], (30, 1)))
    assert np.abs(momentum).max() <= 1.0  # N m s
    np.testing.assert_array_equal(momentum[-1], [1.0, -1.0])
    np.testing.assert_array_equal(torque[-1], 0.0)
    # With no command, friction slows it as soon as the motor has died down below it.
    torque, momentum = run(simulator, np.zeros((20, 1)))
    np.testing.assert_allclose(torque[-1], [2e-3, -2e-3], rtol=1e-9)
    assert np.all(np.abs(momentum[-1]) < 1.0)
    # It may be braked at once.
    simulator = start(2, momentum=(1.0, -1.0), spin_inertia=SPIN, speed_limit=50.0, friction=friction)
    torque, momentum = run(simulator, [[0.1, -0.1]])
    np.testing.assert_allclose(torque[0], [0.102, -0.102], rtol=1e-14)
    np.testing.assert_allclose(momentum[0], [0.9898, -0.9898], rtol=1e-14)


def test_speed_and_momentum_limit_hold_together():
    simulator = start(2, spin_inertia=(0.02, 0.01), speed_limit=(50.0, 30.0), momentum_limit=(0.8, 0.8))
    _, momentum = run(simulator, np.full((60, 1), 0.2))
    np.testing.assert_array_equal(momentum[-1], [-0.8, -0.3])


# --------------------------------------------------------------------------------------------------- wheel by wheel


def test_wheels_of_one_array_may_differ():
    friction = Friction(coulomb=2e-3, breakaway=4e-3, viscous=1e-4)
    common = {"lag": (1e-9, 1e-9, 0.3), "spin_inertia": (0.02, 0.03, 0.04), "dead_band": (1e-9, 1e-9, 0.05)}
    commands = np.random.default_rng(0).uniform(-0.2, 0.2, (60, 3))
    together = run(start(3, momentum=(0.1, 0.2, 0.3), friction=(None, friction, None), **common), commands)
    alone = (
        run(start(1, momentum=0.1), commands[:, :1]),
        run(start(1, momentum=0.2, friction=friction, spin_inertia=0.03), commands[:, 1:2]),
        run(start(1, momentum=0.3, lag=0.3, dead_band=0.05), commands[:, 2:]),
    )
    for wheel, single in enumerate(alone):
        for of_three, of_one in zip(together, single, strict=True):
            np.testing.assert_allclose(of_three[:, wheel], of_one[:, 0], rtol=0.0, atol=1e-14)


def test_without_effects_a_wheel_is_ideal_bit_for_bit():
    commands = np.random.default_rng(0).uniform(-0.3, 0.3, (60, 3))
    faults = (HardOver(wheel=0, onset=1.03, recovery=3.0), LossOfEffectiveness(wheel=1, onset=0.51, amplitude=0.3))
    ideal = run(start(3, *faults, momentum=0.1, momentum_limit=0.4), commands)
    bare = {"momentum_limit": 0.4, "spin_inertia": 0.02, "speed_limit": 30.0, "friction": (None, None, None)}
    for first, second in zip(ideal, run(start(3, *faults, momentum=0.1, **bare), commands), strict=True):
        np.testing.assert_array_equal(first, second)
    # Effects that are there but never bite are the same to rounding.
    mild = {**bare, "friction": Friction(), "lag": 1e-9, "dead_band": 1e-300, "power_limit": 1e9}
    for first, second in zip(ideal, run(start(3, *faults, momentum=0.1, **mild), commands), strict=True):
        np.testing.assert_allclose(first, second, rtol=0.0, atol=1e-14)
