"""Random heaps of faults: nothing depends on where the control periods begin, and momentum is conserved."""

import numpy as np
import pytest

from ftac_gym import attitude as att
from ftac_gym import faults as fault_kinds
from ftac_gym.dynamics import Simulator
from ftac_gym.spacecraft.friction import Friction
from ftac_gym.spacecraft.spacecraft import Spacecraft
from ftac_gym.spacecraft.wheel_array import WheelArray
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.scenario import Scenario

INERTIA = np.array([[10.0, 1.2, 0.5], [1.2, 19.0, 1.5], [0.5, 1.5, 25.0]])  # kg m^2
AXES = WheelArray.sign_pyramid(0.2, None).axes
ARRAYS = {
    "ideal": WheelArray(AXES, 0.2),
    "saturating": WheelArray(AXES, 0.2, 0.6),
    "real": WheelArray(AXES, 0.2, 1.0, spin_inertia=0.02, friction=Friction(0.01, 0.012, 0.3, 1e-4), lag=0.03),
}
SWING = {"amplitude": (0.0, 0.1), "frequency": (0.0, 5.0)}


def timing(random, gradual):
    """A time profile off the grid of the physics steps: it may end before it is all there, or come and go."""
    profile = {"onset": (0.0, random.uniform(0.1, 4.0))}
    if random.random() < 0.5:
        profile["duration"] = (0.1, random.uniform(0.2, 5.0))
    mode = random.integers(3)
    if mode == 1:
        profile |= {"period": (0.5, 2.0), "on_time": (0.05, 0.4)}
    if mode == 2:
        profile |= {"mean_acting": random.uniform(0.2, 2.0), "mean_resting": random.uniform(0.5, 2.0)}
    if gradual:
        profile["rise"] = (0.1, random.uniform(0.2, 4.0))
        if "duration" in profile:
            profile["fall"] = (0.0, random.uniform(0.1, 4.0))
    return profile


def heap(random, name):
    """Up to nine faults, several of them on the same wheel."""
    kinds = [
        (fault_kinds.LossOfEffectiveness, {"effectiveness": (0.3, 0.7), **SWING}),
        (fault_kinds.Bias, {"constant": (-0.1, 0.1), "slope": (-0.02, 0.02), "exponent": (0.0, 1.5), **SWING}),
        (fault_kinds.HardOver, {"fraction": (-1.0, 1.0)}),
        *(
            (kind, {})
            for kind in (
                fault_kinds.Outage,
                fault_kinds.DriftingEffectiveness,
                fault_kinds.LockInPlace,
                fault_kinds.Seizure,
            )
        ),
        (fault_kinds.IntermittentShutdown, {"mean_acting": 0.4, "mean_resting": 0.6, "period": None, "on_time": None}),
    ]
    if name == "real":
        kinds.append((fault_kinds.FrictionRise, {"direction": "either"}))
    faults = []
    for _ in range(random.integers(2, 10)):
        kind, fields = kinds[random.integers(len(kinds))]
        faults.append(kind(wheel=int(random.integers(4)), **{**timing(random, kind.gradual), **fields}))
    return fault_kinds.FaultSchedule(tuple(faults))


def scenario_of(random, name, **changes):
    fields = {
        "name": name,
        "spacecraft": Spacecraft(INERTIA, ARRAYS[name]),
        "initial_state": InitialState(max_rate=0.02, wheel_momentum=(-0.5, 0.5)),
        "faults": heap(random, name),
        "control_period": 0.1,
        "physics_step": 0.02,
        "duration": 10.0,
    }
    return Scenario(**{**fields, **changes})


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("name", ARRAYS)
def test_the_control_period_is_only_how_long_a_command_is_held(name, seed):
    """Faults look at physics steps: five short periods with the same command are one long period."""
    random = np.random.default_rng(seed)
    scenario = scenario_of(random, name)
    episodes = scenario.draw(seed, 10)
    long, short = Simulator(scenario, 10), Simulator(scenario.replace(control_period=0.02), 10)
    for simulator in (long, short):
        simulator.reset(episodes)
    for command in random.uniform(-0.25, 0.25, (100, 10, 4)):
        long.step(command)
        for _ in range(5):
            short.step(command)
        for field in ("attitude", "rate", "wheel_momentum", "wheel_torque"):
            values = getattr(long.state, field)
            assert np.isfinite(values).all()
            np.testing.assert_allclose(values, getattr(short.state, field), rtol=0.0, atol=1e-10)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("name", ARRAYS)
def test_faults_of_wheels_cannot_change_the_total_momentum(name, seed):
    random = np.random.default_rng(100 + seed)
    scenario = scenario_of(random, name)
    simulator = Simulator(scenario, 20)
    simulator.reset(scenario.draw(seed, 20))

    def momentum():
        state = simulator.state
        body = state.rate @ INERTIA + state.wheel_momentum @ scenario.spacecraft.wheels.axis_matrix.T
        return att.rotate_to_reference(state.attitude, body)

    before, limits = momentum(), scenario.spacecraft.wheels.momentum_limits
    for command in random.uniform(-0.25, 0.25, (100, 20, 4)):
        simulator.step(command)
        assert np.all(np.abs(simulator.state.wheel_momentum) <= limits + 1e-12)
    np.testing.assert_allclose(momentum(), before, rtol=0.0, atol=1e-9)
    assert np.abs(simulator.state.wheel_torque).max() > 0.0
