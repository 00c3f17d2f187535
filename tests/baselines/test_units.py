"""Units of a scenario: their sizes, and that what is in them flies spacecraft of every size and loop alike."""

import math
from functools import cache

import numpy as np
import pytest
from helpers import sizes
from helpers.units import NFTSM, in_units
from hypothesis import given, settings
from hypothesis import strategies as st

from ftac_gym import baselines, scenarios
from ftac_gym.baselines import observers
from ftac_gym.baselines.components.allocation import MinimaxAllocation
from ftac_gym.baselines.memory import Memory
from ftac_gym.baselines.units import PER_LOOP, Scales, Unit, factors_of, physical, relative
from ftac_gym.dynamics import Simulator
from ftac_gym.evaluation import rollout
from ftac_gym.faults import FaultSchedule, LossOfEffectiveness
from ftac_gym.spacecraft import Spacecraft, WheelArray
from ftac_gym.spacecraft.layouts import three_orthogonal
from ftac_gym.task.initial_state import InitialState

OURS = (
    "pd", "pd_dob", "pd_shaped", "nftsm", "nftsm_observer", "nftsm_telemetry", "predefined_time",
    "predefined_time_observer", "predefined_time_telemetry", "prescribed_performance",
)  # fmt: skip
DEFAULT = (
    "pd", "pd_dob", "nftsm", "nftsm_observer", "predefined_time", "predefined_time_observer", "prescribed_performance",
)  # fmt: skip
SCALED = ("asmo_scaled", "lo_scaled", "tachometer")
FLAGSHIP = scenarios.get("flagship")
COUNT, STEPS = 4, 80


def task(mass=1.0, slowness=1.0):
    """Return a quiet slew with a weak wheel: inertia, torque and momentum times a mass, or all times a slowness."""
    nominal = FLAGSHIP.spacecraft
    inertia = (mass * nominal.inertia_matrix).tolist()
    wheels = WheelArray.sign_pyramid(0.2 * mass / slowness**2, 12.0 * mass / slowness)
    weak = LossOfEffectiveness(wheel=1, onset=2.0 * slowness, effectiveness=0.4)
    return FLAGSHIP.replace(
        spacecraft=Spacecraft(inertia, wheels), disturbance=None, sensors=None, inertia_uncertainty=None,
        tumble_rate=None, faults=FaultSchedule((weak,)), initial_state=InitialState(angle=(0.3, 1.5)),
        control_period=0.1 * slowness, loop_delay=0.1 * slowness, physics_step=0.02 * slowness,
        duration=12.0 * slowness,
    )  # fmt: skip


def flown(scenario, name, **gains):
    """Return the attitudes after the first control periods (STEPS, N, 4)."""
    law, simulator = baselines.make(name, scenario, COUNT, **gains), Simulator(scenario, COUNT)
    simulator.reset(scenario.draw(7, COUNT))
    found = []
    for _ in range(STEPS):
        simulator.step(law.act(simulator.measurement()))
        found.append(simulator.state.attitude.copy())
    return np.array(found)


@cache
def nominal(name, **gains):
    return flown(task(), name, **gains)


@pytest.mark.parametrize("name", OURS)
@settings(max_examples=6, deadline=None)
@given(mass=st.floats(-3.0, 3.0).map(lambda power: 10.0**power))
def test_spacecraft_of_every_mass_fly_the_same_slew(name, mass):
    np.testing.assert_allclose(flown(task(mass), name), nominal(name), rtol=0.0, atol=1e-7)


@pytest.mark.parametrize("name", OURS)
@settings(max_examples=4, deadline=None)
@given(slowness=st.sampled_from([0.25, 0.5, 2.0, 5.0, 20.0]))
def test_slow_loops_fly_the_same_slew_slowly(name, slowness):
    """The attitude filter alone has a time of its own."""
    slow = flown(task(slowness=slowness), name, attitude_filter_time=slowness)
    np.testing.assert_allclose(slow, nominal(name, attitude_filter_time=1.0), rtol=0.0, atol=1e-7)


@pytest.mark.parametrize("name", SCALED)
@settings(max_examples=6, deadline=None)
@given(mass=st.floats(-3.0, 3.0).map(lambda power: 10.0**power))
def test_observers_estimate_alike_for_every_mass(name, mass):
    found = []
    for scale in (1.0, mass):
        scenario = task(scale)
        observer, simulator = observers.make(name, scenario, Memory(COUNT)), Simulator(scenario, COUNT)
        simulator.reset(scenario.draw(7, COUNT))
        limits = scenario.spacecraft.wheels.torque_limits
        for step in range(60):
            measurement = simulator.measurement()
            estimate = observer.update(measurement, measurement.command_in_effect, scenario.control_period)
            simulator.step(0.7 * limits * np.sin(0.05 * step + np.arange(COUNT))[:, None] * np.ones(4))
        parts = [estimate.effectiveness, estimate.identifiable, estimate.bias, estimate.disturbance]
        sizes_of = [1.0, 1.0, limits, limits[:3]]
        found.append([part / size for part, size in zip(parts, sizes_of, strict=True) if part is not None])
    for first, second in zip(*found, strict=True):
        np.testing.assert_allclose(second, first, rtol=0.0, atol=1e-7)
    assert any(np.ptp(part) > 1e-3 for part in found[0]), "there is something to estimate"


TASKS = {
    "3U": sizes.CUBESAT,
    "3U, weak wheel": sizes.FAULTY_CUBESAT,
    "300 kg": sizes.OBSERVATORY,
    "300 kg, wheel weak or out": sizes.FAULTY_OBSERVATORY,
}


@pytest.mark.parametrize("case", TASKS)
@pytest.mark.parametrize("name", DEFAULT)
def test_default_gains_succeed_on_spacecraft_of_other_sizes(name, case):
    history = rollout(TASKS[case], name, seed=1234, count=20)
    assert history.episodes.feasible.all()
    assert history.metrics()["success"].mean() >= 0.95


@pytest.mark.parametrize("name", ["nftsm_observer", "predefined_time_observer"])
def test_observers_are_finite_on_a_tiny_spacecraft(name):
    small = Spacecraft((0.01 * np.eye(3)).tolist(), WheelArray(three_orthogonal(), 1e-3, 2e-3))
    scenario = sizes.FAULTY_CUBESAT.replace(spacecraft=small, initial_state=InitialState())
    history = rollout(scenario, name, seed=5, count=20, estimates=True)
    assert np.isfinite(history.command).all() and np.isfinite(history.estimates.effectiveness).all()
    assert np.degrees(history.attitude_error[-50:]).max() < 5.0


def test_sizes_of_a_scenario():
    """Three orthogonal wheels on a diagonal inertia: the axis of 4 kg m^2 has the smallest acceleration and rate."""
    wheels = WheelArray(three_orthogonal(), (0.1, 0.2, 0.3), (1.0, 0.4, 3.0))
    scenario = FLAGSHIP.replace(
        spacecraft=Spacecraft(np.diag([3.0, 4.0, 5.0]).tolist(), wheels), control_period=0.2, loop_delay=0.1,
        initial_state=InitialState(), faults=None,
    )  # fmt: skip
    found = Scales.of(scenario)
    assert found.loop_time == pytest.approx(0.3) and found.torque == 0.1 and found.inertia == pytest.approx(3.0)
    assert found.acceleration == pytest.approx(0.1 / 3.0)
    assert found.speed == pytest.approx(0.5 * 0.4 / 4.0)  # half of the stored rate, below sqrt(0.1 / 3) = 0.18
    free = scenario.replace(spacecraft=Spacecraft(np.diag([3.0, 4.0, 5.0]).tolist(), WheelArray(wheels.axes, None)))
    assert Scales.of(free).acceleration == pytest.approx(0.2) and Scales.of(free).torque == 1.0
    assert Scales.of(free).speed == pytest.approx(math.sqrt(0.2))


def test_the_largest_acceleration_about_every_axis():
    """No direction has less than A, and some direction has A, by the allocation of the wheels."""
    nominal = FLAGSHIP.spacecraft
    directions = np.random.default_rng(0).normal(size=(20000, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    shares = np.abs(MinimaxAllocation(nominal.wheels)(directions @ nominal.inertia_matrix)) / 0.2
    largest = 1.0 / shares.max(axis=1)
    assert Scales.of(FLAGSHIP).acceleration <= largest.min() <= 1.005 * Scales.of(FLAGSHIP).acceleration


def test_wheels_that_do_not_span_space_have_no_sizes():
    flat = WheelArray(((1.0, 0.0, 1.0), (0.0, 1.0, 0.0), (0.0, 0.0, 0.0)), 0.1)
    scenario = FLAGSHIP.replace(spacecraft=Spacecraft(np.eye(3).tolist(), flat), faults=None)
    with pytest.raises(ValueError, match="axes must span three dimensions"):
        Scales.of(scenario)


def test_the_value_of_a_unit_is_a_product_of_powers():
    scales = Scales(loop_time=0.5, acceleration=3.0, speed=7.0, torque=2.0, inertia=5.0)
    assert PER_LOOP.value(scales) == 2.0 and str(PER_LOOP) == "1/L"
    assert Unit("R L/I", "rad/s", torque=1, loop_time=1, inertia=-1).value(scales) == pytest.approx(0.2)


@pytest.mark.parametrize("name", OURS)
def test_relative_is_the_inverse_of_physical(name):
    own, scales = baselines.baseline_class(name).gains, Scales.of(sizes.CUBESAT)
    factors = factors_of(own, scales)
    values = {key: getattr(own, key) for key in factors if key != "bound"}
    in_si = physical(own, factors)
    assert relative(own, scales, {key: getattr(in_si, key) for key in values}) == pytest.approx(values)
    assert len(values) >= 3 and any(getattr(in_si, key) != value for key, value in values.items())


def test_bounds_decay_with_the_speed_of_the_wheels():
    """Given ones and those of the default; the bound of a scenario is physical."""
    name, scales = "prescribed_performance", Scales.of(sizes.CUBESAT)
    own = baselines.make(name, sizes.CUBESAT, bound={"decay": 0.5, "final": 0.01}).bound
    assert own.decay == pytest.approx(0.5 * scales.speed) and own.final == 0.01
    assert baselines.make(name, FLAGSHIP).bound.decay == pytest.approx(0.04, rel=1e-3)
    prescribed = scenarios.get("chen_2018")
    assert baselines.make(name, prescribed).bound == prescribed.prescribed_bound


def test_the_flagship_has_the_gains_of_its_search():
    """Values in SI units at which the laws were tuned."""
    expected = {
        "pd_dob": {"rate_gain": 6.162, "position_gain": 2.484, "rate_limit": 0.1743, "bandwidth": 0.3897},
        "nftsm": {key: NFTSM[key] for key in ("linear", "terminal", "reaching_linear", "rate_gain", "steepness")},
    }
    for name, values in expected.items():
        found = baselines.make(name, FLAGSHIP).scheduled
        assert {key: getattr(found, key) for key in values} == pytest.approx(values, rel=1e-3)


def test_the_bound_of_the_surface_gives_its_slope():
    """mu = 0.001 on the flagship, where the surface has the slope k1 + k2 (2 - r) mu^(r - 1) at zero."""
    assert in_units("nftsm", FLAGSHIP, **NFTSM)["terminal_slope"] == pytest.approx(0.6656, rel=1e-3)
    law = baselines.make("nftsm", FLAGSHIP)
    error = 1e-9 * np.eye(3)
    ratio, slope = law._profile(np.linalg.norm(error, axis=1, keepdims=True))
    gains = law.scheduled
    np.testing.assert_allclose(ratio, gains.linear + gains.terminal_slope, rtol=1e-5)
    np.testing.assert_allclose(slope, ratio, rtol=1e-5)
