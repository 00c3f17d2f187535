"""The two controllers of Zhang and Zhou 2019: how well they point, and what their adaptation may and may not do."""

import numpy as np
import pytest
from helpers.observed import task

from ftac_gym import baselines
from ftac_gym.attitude import angle_between, quaternion_from_mrp
from ftac_gym.dynamics import Simulator
from ftac_gym.faults import Bias, FaultSchedule, LossOfEffectiveness
from ftac_gym.task.disturbances import Disturbance, Harmonic
from ftac_gym.task.inertia import InertiaUncertainty
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.references import MRPSinusoid, RateProfile

START = InitialState.fixed(quaternion_from_mrp(np.array([-0.8, 0.3, 0.5])).tolist(), (0.5, -0.6, 0.4))
PAPER = {
    "faults": FaultSchedule(
        (LossOfEffectiveness(wheel=0, onset=10.0, effectiveness=0.5), Bias(wheel=1, onset=10.0, constant=0.06))
    ),
    "disturbance": Disturbance((0.1, 0.1, 0.1), (Harmonic((0.1, 0.3, 0.5), 1.0),)),
    "inertia_uncertainty": InertiaUncertainty(amplitude=(1.0, 2.0, 1.0), frequency=(0.1, 0.2, 0.3), rate_torque=False),
}
SLOW = MRPSinusoid((0.3, 0.1, 0.2), (0.2, 0.4, 0.2))
NAMES = ("zhang_zhou_stabilisation", "zhang_zhou_tracking")


def paper(period=0.05, **changes):
    """The example of the paper; the reference rests unless another is given."""
    return task(4, period, **{**PAPER, "initial_state": START, "duration": 60.0, **changes})


def fly(scenario, name, duration, **gains):
    """Return errors [deg], sliding variables (steps, 3) and the memory after every period of one spacecraft."""
    simulator, law = Simulator(scenario, 1), baselines.make(name, scenario, **gains)
    simulator.reset(scenario.draw(0, 1))
    errors, variables, memories = [], [], []
    for _ in range(round(duration / scenario.control_period)):
        measurement = simulator.measurement(truth=law.information == "oracle")
        variables.append(law.sliding_variable(measurement)[0])
        simulator.step(law.act(measurement))
        errors.append(np.degrees(angle_between(simulator.state.attitude, simulator.reference_attitude))[0])
        memories.append(law.memory.copy())
    return np.array(errors), np.array(variables), memories


@pytest.mark.parametrize(
    ("name", "reference", "expected"),
    [("zhang_zhou_stabilisation", None, 0.107), ("zhang_zhou_tracking", SLOW, 0.204)],
)
def test_points_as_well_as_its_layer_allows(name, reference, expected):
    """The steady error of the paper's page for a layer of 0.2 rad/s, at 50 ms: largest over the last 10 s."""
    changes = {} if reference is None else {"reference": reference}
    errors, _, _ = fly(paper(**changes), name, 45.0, layer=0.2)
    assert errors[0] > 100.0
    assert errors[-200:].max() == pytest.approx(expected, rel=0.5)
    settled = 0.05 * (np.flatnonzero(errors > 1.0)[-1] + 1)
    assert settled < 30.0  # s


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("faults", ["none", "oracle", "asmo"])
def test_every_source_of_faults_flies(name, faults):
    errors, _, _ = fly(paper(), name, 25.0, layer=0.2, faults=faults)
    assert errors[-60:].max() < 1.0


def test_bounds_only_grow_and_eta_stays_above_its_floor():
    _, variables, memories = fly(paper(), "zhang_zhou_stabilisation", 5.0)
    distance = np.linalg.norm(variables, axis=1)
    for name in ("rate_bound", "fault_bound"):
        history = np.array([memory[name][0, 0] for memory in memories])
        assert (np.diff(history) >= 0.0).all() and history[-1] > 0.0
    spacecraft = paper().spacecraft
    norms = np.linalg.norm(np.linalg.inv(spacecraft.inertia_matrix), 2) * np.linalg.norm(
        spacecraft.wheels.axis_matrix, 2
    )
    np.testing.assert_allclose(history[-1], 0.001 * norms * 0.05 * distance.sum(), rtol=1e-9)
    _, variables, memories = fly(paper(reference=SLOW), "zhang_zhou_tracking", 5.0, coupling_gain=5.0)
    bound = np.array([memory["bound"][0, 0] for memory in memories])
    np.testing.assert_allclose(bound, 0.01 * 0.05 * np.cumsum(np.linalg.norm(variables, axis=1)), rtol=1e-9)
    eta = np.array([memory["eta"][0, 0] for memory in memories])
    assert eta.min() >= 1e-3 and np.ptp(eta) > 0.1 and np.isfinite(eta).all()
    # From its floor eta would fall for good, in finite time and with an infinite slope, as it is printed.
    _, _, memories = fly(paper(), "zhang_zhou_tracking", 5.0, initial_eta=1e-3)
    assert {memory["eta"][0, 0] for memory in memories} == {1e-3}


@pytest.mark.parametrize("name", NAMES)
def test_gains_of_zero_switch_the_adaptation_off(name):
    off = {"network_gain": 0.0}
    off |= {"rate_bound_gain": 0.0, "fault_bound_gain": 0.0} if "stab" in name else {
        "bound_gain": 0.0, "coupling_gain": 0.0,
    }  # fmt: skip
    _, _, memories = fly(paper(), name, 2.0, faults="none", **off)
    for key in memories[-1].keys() - {"called_at", "command"}:
        array = memories[-1][key]
        np.testing.assert_array_equal(array, memories[0][key])


@pytest.mark.parametrize("name", NAMES)
def test_the_auxiliary_system_does_nothing_once_it_is_resolved(name):
    """Off by default; with steps that resolve it, it is gone in a moment, while the wheels are still saturated."""
    scenario = paper(0.02)
    without, _, memories = fly(scenario, name, 1.0)
    assert "anti_saturation" not in memories[0]
    fine = {"smallest": 0.05, "substeps": 300}
    with_it, _, memories = fly(scenario, name, 1.0, anti_saturation=fine)
    length = np.array([np.linalg.norm(memory["anti_saturation"][0]) for memory in memories])
    assert (np.diff(length) <= 0.0).all()
    assert (length[5:] < 0.05).all() and length[-1] == length[5]
    assert np.abs(with_it - without).max() < 3.0  # deg, out of 179


def test_stabilisation_refuses_a_reference_that_moves():
    message = "^zhang_zhou_stabilisation: reference must be at rest: .*, got '(MRPSinusoid|RateProfile)'"
    for reference in (SLOW, RateProfile((0.0, 0.1, 0.0), (1.0, 1.0, 1.0))):
        with pytest.raises(ValueError, match=message):
            baselines.make("zhang_zhou_stabilisation", paper(reference=reference))


@pytest.mark.parametrize(
    ("name", "gains", "message"),
    [
        ("zhang_zhou_stabilisation", {"linear": -1.0}, "linear must not be negative"),
        ("zhang_zhou_stabilisation", {"terminal": -1.0}, "terminal must not be negative"),
        ("zhang_zhou_stabilisation", {"exponent": 1.0}, r"exponent must lie within \(0, 1\)"),
        ("zhang_zhou_stabilisation", {"rate_bound_gain": -1.0}, "rate_bound_gain must not be negative"),
        ("zhang_zhou_stabilisation", {"fault_bound_gain": -1.0}, "fault_bound_gain must not be negative"),
        ("zhang_zhou_stabilisation", {"network_gain": -1.0}, "network_gain must not be negative"),
        ("zhang_zhou_stabilisation", {"layer": -1.0}, "layer must not be negative"),
        ("zhang_zhou_stabilisation", {"reaching_linear": -1.0}, "linear must not be negative"),
        ("zhang_zhou_stabilisation", {"reaching_switching": -1.0}, "switching must not be negative"),
        ("zhang_zhou_stabilisation", {"reaching_floor": 2.0}, r"floor must lie within \(0, 1\)"),
        ("zhang_zhou_stabilisation", {"reaching_power": 0.5}, "power must be a positive integer"),
        ("zhang_zhou_stabilisation", {"anti_saturation": {"decay": 0.5}}, "decay must exceed"),
        ("zhang_zhou_stabilisation", {"faults": "guess"}, "faults must be one of"),
        ("zhang_zhou_stabilisation", {"observer": {"barrier": -1.0}}, "barrier must be positive"),
        ("zhang_zhou_stabilisation_no_observer", {"observer": {"barrier": 1.0}}, "observer must not have gains"),
        ("zhang_zhou_tracking", {"virtual_gain": 0.0}, "virtual_gain must be positive"),
        ("zhang_zhou_tracking", {"exponent": 0.0}, r"exponent must lie within \(0, 1\)"),
        ("zhang_zhou_tracking", {"bound": 0.0}, "bound must be positive"),
        ("zhang_zhou_tracking", {"bound_gain": -1.0}, "bound_gain must not be negative"),
        ("zhang_zhou_tracking", {"coupling_gain": -1.0}, "coupling_gain must not be negative"),
        ("zhang_zhou_tracking", {"coupling_low": 0.0}, "coupling_low must be positive"),
        ("zhang_zhou_tracking", {"coupling_high": 0.01}, r"coupling_high must exceed coupling_low = 0\.01 > 0"),
        ("zhang_zhou_tracking", {"smallest_eta": 0.0}, "smallest_eta must be positive"),
        ("zhang_zhou_tracking", {"initial_eta": 1e-4}, r"initial_eta must be at least 0\.001"),
    ],
)
def test_bad_gains(name, gains, message):
    with pytest.raises(ValueError, match=f"^{name}: .*{message}"):
        baselines.make(name, paper(), **gains)
