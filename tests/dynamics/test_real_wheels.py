"""Friction of real wheels in the plant: closed forms far from rest, coming to rest, and what holds a wheel there."""

import numpy as np
import pytest
from helpers.wheels import LIMIT, SPIN, run
from helpers.wheels import one_axis as start
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import njit
from scipy.optimize import brentq

from ftac_gym.dynamics import stiff_wheel as kernel
from ftac_gym.dynamics.wheel_table import wheel_table
from ftac_gym.faults import FrictionRise, Outage
from ftac_gym.spacecraft.friction import Friction
from ftac_gym.spacecraft.wheel_array import WheelArray

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


# ----------------------------------------------------------------------------------------------------------- solver


@njit
def solve(table, free, weight, drive, guess, factor, brake):
    """Return the solution, and what is left of the equation there and a hair on either side of it."""
    wheel = table[0]
    x = kernel.implicit_momentum(wheel, free, weight, drive, guess, (factor, factor, brake))
    left = np.zeros(3)
    for index in range(3):
        at = x + (index - 1) * (1e-9 * abs(x) + 1e-13 * (abs(free) + weight * abs(drive)))
        drag, _ = kernel.friction(wheel, at, factor)
        left[index] = at + weight * (kernel.powered(wheel, drive, at) + drag + np.sign(at) * brake) - free
    return x, left


@settings(max_examples=150, deadline=None, derandomize=True)
@given(
    rubbing(),
    st.none() | log_uniform(1e-3, 1e2),
    log_uniform(1e-4, 1.0),
    st.sampled_from([0.0, 0.3]),
    st.sampled_from([1.0, 20.0]),
    st.tuples(*[st.just(0.0) | st.floats(-7.0, 1.0).map(lambda exponent: 10.0**exponent)] * 3),
    st.tuples(*[st.sampled_from([-1.0, 1.0])] * 3),
)
def test_the_implicit_equation_is_solved(wheel, power, weight, brake, factor, sizes, signs):
    inertia, drag, _ = wheel
    free, drive, guess = (size * sign for size, sign in zip(sizes, signs, strict=True))
    array = WheelArray(np.eye(3)[:, :1], 1.0, spin_inertia=inertia, friction=drag, power_limit=power)
    x, left = solve(wheel_table(array, 0.02), free, weight, drive, guess, factor, brake)
    scale = abs(free) + weight * abs(drive)
    if x == 0.0:  # the brake holds
        assert abs(free - weight * drive) <= weight * brake * (1.0 + 1e-12)
    else:
        assert np.isfinite(x) and x * (free - weight * drive) > 0.0
        assert abs(left[1]) <= 1e-9 * scale or left[0] * left[2] <= 0.0
