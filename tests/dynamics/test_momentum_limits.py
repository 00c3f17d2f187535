"""Momentum limits of wheels, however coarse the step is."""

import numpy as np
import pytest
from helpers.wheels import LIMIT, run, start
from hypothesis import given, settings
from hypothesis import strategies as st

from ftac_gym.dynamics import Simulator
from ftac_gym.faults import Bias, CommandDelay, HardOver, LockInPlace, LossOfEffectiveness, Outage, Seizure
from ftac_gym.spacecraft import Friction

BENCH = {"axes": ((0.0,), (0.0,), (1.0,)), "inertia": 1e5 * np.diag([1.0, 1.2, 1.4]), "spin_inertia": 1e-3}
FAULTS = (
    Bias(wheel=0, constant=2.0 * LIMIT, onset=3.0),
    Bias(wheel=0, amplitude=3.0 * LIMIT, frequency=1.0),
    CommandDelay(wheel=0, periods=3.0),
    HardOver(wheel=0, onset=3.0),
    LockInPlace(wheel=0, onset=5.0),
    LossOfEffectiveness(wheel=0, effectiveness=0.5, amplitude=0.5, frequency=1.5),
    Outage(wheel=0, onset=3.0, duration=3.0),
    Seizure(wheel=0, onset=6.0, duration=4.0),
)
frictions = st.none() | st.builds(
    Friction,
    coulomb=st.floats(0.0, 0.5 * LIMIT),
    breakaway_speed=st.floats(0.1, 10.0),
    viscous=st.sampled_from([0.0, 1e-5, 1e-3]),
)


def log_uniform(low, high):
    return st.floats(np.log(low), np.log(high)).map(lambda value: float(np.exp(value)))


@settings(max_examples=60, deadline=None, derandomize=True)
@given(
    limit=log_uniform(1e-3, 10.0),
    lag=st.none() | log_uniform(1e-3, 10.0),
    friction=frictions,
    power=st.none() | log_uniform(1e-3, 1e3),
    step=st.sampled_from([0.01, 0.1, 0.5, 1.0]),
    substeps=st.integers(1, 5),
    faults=st.lists(st.sampled_from(FAULTS), max_size=2),
    seed=st.integers(0, 1000),
)
def test_no_wheel_passes_its_limit_by_more_than_rounding(limit, lag, friction, power, step, substeps, faults, seed):
    parts = BENCH | {"momentum_limit": limit, "lag": lag, "friction": friction, "power_limit": power}
    period = step * substeps
    rng = np.random.default_rng(seed)
    simulator = start(*faults, step=step, period=period, duration=100.0 * period, **parts)
    commands = LIMIT * np.where(
        rng.random((60, 1)) < 0.7, np.sign(rng.normal(size=(60, 1))), rng.uniform(-1.0, 1.0, (60, 1))
    )
    torque, momentum = run(simulator, commands)
    assert np.abs(momentum).max() <= limit * (1.0 + 1e-12)
    assert np.isfinite(torque).all()


@pytest.mark.parametrize(
    ("lag", "viscous", "tolerance"), [(0.05, 0.0, 1e-12), (0.3, 0.0, 1e-12), (1.0, 0.0, 1e-12), (0.5, 1e-4, 3e-3)]
)
def test_a_coarse_step_does_not_carry_a_wheel_with_lag_beyond_its_limit_and_back(lag, viscous, tolerance):
    """One step of 1 s ends where a thousand steps end: none of them overshoots the limit."""
    friction = Friction(viscous=viscous) if viscous > 0.0 else None
    parts = BENCH | {"momentum_limit": 0.3, "lag": lag, "friction": friction, "period": 1.0, "duration": 100.0}
    commands = LIMIT * np.sign(np.random.default_rng(0).normal(size=(80, 1)))
    coarse, fine = (run(start(step=step, **parts), commands)[1] for step in (1.0, 0.001))
    assert (np.abs(fine) == 0.3).mean() > 0.2  # the limit matters
    np.testing.assert_allclose(coarse, fine, rtol=0.0, atol=tolerance)


def test_the_impulse_that_the_limit_stops_is_not_given_to_the_body():
    """The total momentum stays what it was while lag and limit overlap within a step."""
    axes = ((1.0, 0.0, 0.0, 0.6), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.8))
    inertia = 1e3 * np.diag([1.0, 1.2, 1.4])
    simulator: Simulator = start(
        step=0.5, period=0.5, duration=100.0, axes=axes, inertia=inertia, momentum_limit=0.3, lag=0.4
    )
    rng = np.random.default_rng(1)
    for _ in range(100):
        simulator.step(LIMIT * np.sign(rng.normal(size=(1, 4))))
        state = simulator.state
        total = state.rate[0] @ inertia + np.array(axes) @ state.wheel_momentum[0]
        np.testing.assert_allclose(total, 0.0, atol=1e-9)
