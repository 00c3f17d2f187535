"""The schemes of Chen et al. 2018 and what is made of them: against a second implementation, and what they claim."""

import math

import numpy as np
import pytest
from helpers.laws import NominalModel, Target
from helpers.prescribed_laws import M1, M2, M3, Bounds, Sampled, VaryingPlant
from helpers.units import PRESCRIBED, in_units

from ftac_gym import baselines, scenarios
from ftac_gym.attitude import (
    quaternion_from_mrp,
)
from ftac_gym.dynamics import Simulator
from ftac_gym.faults import FaultSchedule, LossOfEffectiveness
from ftac_gym.spacecraft.layouts import orthogonal_and_skew, three_orthogonal
from ftac_gym.spacecraft.spacecraft import Spacecraft
from ftac_gym.spacecraft.wheel_array import WheelArray
from ftac_gym.task.inertia import InertiaUncertainty
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.references import MRPSinusoid, SetPoints

CHEN = scenarios.get("chen_2018")
NAMES = ["chen_m1", "chen_m1_sampled", "chen_m2", "chen_m3", "chen_m3_scaled"]
SIGMA, RATE = (-0.3, -0.4, 0.2), (0.03, 0.05, -0.04)
WAVE = {"amplitude": (0.15, 0.1, -0.2), "frequency": (0.2, 0.3, 0.2), "phase": (0.1, 0.5, -0.4)}

# ------------------------------------------------------------------------------------------------------------- parity


def task(period, onsets, rate_torque, wheels=3, limit=8.0, **changes):
    """The paper's example with the faults brought forward, the inertia varying faster, and a rate at the start."""
    schedule = FaultSchedule(
        tuple(
            LossOfEffectiveness(wheel=wheel, onset=onset, effectiveness=0.2, amplitude=0.1, frequency=f * math.pi)
            for wheel, (onset, f) in enumerate(zip(onsets, (0.2, 0.3, 0.4), strict=True))
        )
    )
    axes = three_orthogonal() if wheels == 3 else orthogonal_and_skew()
    spacecraft = Spacecraft(CHEN.spacecraft.inertia, WheelArray(axes, limit, momentum_coupling=False))
    return CHEN.replace(
        spacecraft=spacecraft,
        initial_state=InitialState.fixed(quaternion_from_mrp(np.array(SIGMA)).tolist(), RATE),
        faults=schedule,
        inertia_uncertainty=InertiaUncertainty(
            amplitude=(5.0, 7.0, 9.0), frequency=(1.1, 1.2, 1.3), rate_torque=rate_torque
        ),
        control_period=period,
        physics_step=period / round(period / 0.005),
        duration=1000.0 * period,
        **changes,
    )  # fmt: skip


def truth(model, onsets, rate_torque):
    """The plant of the same task from the paper's equations."""
    amplitude, frequency = np.array([5.0, 7.0, 9.0]), np.array([1.1, 1.2, 1.3])

    def effectiveness(time, probe):
        share = np.ones(model.axes.shape[1])
        for wheel, (onset, f) in enumerate(zip(onsets, (0.2, 0.3, 0.4), strict=True)):
            if probe > onset:
                share[wheel] = 0.2 + 0.1 * math.sin(f * math.pi * time)
        return share

    def external(time, w):
        return (w @ w + 0.05) * np.array([math.sin(0.8 * time), math.cos(0.5 * time), math.sin(0.3 * time)])

    return VaryingPlant(
        model,
        lambda time: model.inertia + np.diag(amplitude * np.sin(frequency * time)),
        (lambda time: np.diag(amplitude * frequency * np.cos(frequency * time))) if rate_torque else None,
        effectiveness,
        external,
    )


def flown(scenario, name, steps, **gains):
    """True states (steps + 1, 7) and commands (steps, m) of one spacecraft under the package's law."""
    simulator, law = Simulator(scenario, 1), baselines.make(name, scenario, **gains)
    simulator.reset(scenario.draw(0, 1))
    states, commands = [np.append(simulator.state.attitude[0], simulator.state.rate[0])], []
    for _ in range(steps):
        simulator.step(law.act(simulator.measurement()))
        commands.append(simulator.last_command[0].copy())
        states.append(np.append(simulator.state.attitude[0], simulator.state.rate[0]))
    return np.array(states), np.array(commands)


WIDE = {"initial": 1.5, "decay": 0.04, "final": 0.001, "lower": (1.0,) * 3, "upper": (1.0,) * 3, "initial_factor": None}
FEASIBLE = Bounds(1.5, 0.001, 0.04, (1.0,) * 3, (1.0,) * 3, None)
TABLE = CHEN.prescribed_bound
MIRRORED = {"lower": TABLE.upper, "upper": TABLE.lower}
LOOPS = {
    # the package's law, the other, gains of both, period, steps, torque limit
    "m1": ("chen_m1", M1, {}, {}, 0.005, 105, 8.0),
    "m1, strong": ("chen_m1", M1, {}, {}, 0.005, 105, 1e3),
    "m1, at the virtual control": ("chen_m1", M1, {"start": "virtual"}, {"filter_start": "virtual"}, 0.02, 105, 200.0),
    "m1, ten sub-steps": ("chen_m1", M1, {"substeps": 10}, {"filter_substeps": 10}, 0.02, 105, 200.0),
    "m1, slow": ("chen_m1", M1, {"substeps": 3}, {"filter_substeps": 3}, 0.05, 105, 200.0),
    "m1, no filter": ("chen_m1", M1, {"substeps": None}, {"filter_substeps": 0}, 0.01, 105, 200.0),
    "m1, mirrored": ("chen_m1", M1, {}, {"bound": MIRRORED, "mirror": True}, 0.02, 105, 200.0),
    "m1 sampled": (
        "chen_m1_sampled", M1, {"substeps": None, "k2": 2.0, "tau2": 0.0, "bounds": FEASIBLE}, {"bound": WIDE},
        0.1, 105, 8.0,
    ),
    "m2": ("chen_m2", M2, {}, {}, 0.05, 105, 8.0),
    "m3": ("chen_m3", M3, {}, {}, 0.05, 105, 8.0),
    "m3, wide layer": ("chen_m3", M3, {"jump": True, "layer": 0.2}, {"jump": True, "layer": 0.2}, 0.05, 105, 8.0),
    "m3 scaled": ("chen_m3_scaled", M3, {"tau": 100.0, "rho": 10.0}, {}, 0.05, 105, 8.0),
    "prescribed": ("prescribed_performance", Sampled, {}, {"bound": WIDE}, 0.1, 105, 8.0),
    "prescribed, four wheels": ("prescribed_performance", Sampled, {}, {"bound": WIDE}, 0.1, 105, 8.0),
    "prescribed, moving": ("prescribed_performance", Sampled, {}, {"bound": WIDE}, 0.1, 105, 8.0),
    "prescribed, narrow": (
        "prescribed_performance", Sampled, {"bounds": Bounds(), "margin": 0.2}, {"margin": 0.2}, 0.1, 105, 8.0,
    ),
}  # fmt: skip
"""Cases in which no command depends on sign(x) for an x that is zero up to rounding.

That happens where M1's power tau2 sig(s2)^g is in its chatter, whose slope is infinite at zero: beyond some 150 periods
without saturation. Under the paper's 8 N m all of M1's commands are +-8; so it is flown with stronger wheels too."""
RAW = {"attitude_filter_time": 0.0}


@pytest.mark.parametrize("case", LOOPS)
def test_flights_agree_with_an_independent_implementation(case):
    """Through onsets of all three faults, the disturbance and a varying inertia, with and without -J' w."""
    name, law, theirs, ours, period, steps, limit = LOOPS[case]
    rate_torque = list(LOOPS).index(case) % 2 == 1
    onsets = [round(share * steps) * period for share in (0.6, 0.4, 0.2)]
    changes = {"reference": MRPSinusoid(**WAVE)} if "moving" in case else {}
    scenario = task(period, onsets, rate_torque, 4 if "four" in case else 3, limit, **changes)
    model = NominalModel(scenario, Target(**WAVE) if "moving" in case else None)
    start = np.append(quaternion_from_mrp(np.array(SIGMA)), RATE)
    base = PRESCRIBED if name == "prescribed_performance" else {}
    states, commands = truth(model, onsets, rate_torque).history(law(model, **theirs), start, steps)
    seen_states, seen_commands = flown(scenario, name, steps, **in_units(name, scenario, **{**base, **ours}), **RAW)
    np.testing.assert_allclose(seen_states, states, atol=1e-10)
    np.testing.assert_allclose(seen_commands, commands, atol=1e-6)  # N m


# --------------------------------------------------------------------------------------------------------- bad input


@pytest.mark.parametrize("name", NAMES)
def test_a_moving_reference_is_refused(name):
    scenario = CHEN.replace(reference=MRPSinusoid(**WAVE))
    with pytest.raises(ValueError, match=f"^{name}: reference must be at rest: .*got 'MRPSinusoid'"):
        baselines.make(name, scenario)
    baselines.make(name, CHEN.replace(reference=SetPoints()))


COMMON = [
    ({"attitude_gain": 0.0}, r"attitude_gain must be positive, got 0\.0"),
    ({"rate_gain": -1.0}, r"rate_gain must (be positive|not be negative), got -1\.0"),
]
FUZZY = [
    ({"fuzzy_width": 0.0}, r"fuzzy_width must be positive, got 0\.0"),
    ({"fuzzy_gain": -1.0}, r"fuzzy_gain must not be negative, got -1\.0"),
    ({"fuzzy_leak": -1.0}, r"fuzzy_leak must not be negative, got -1\.0"),
    ({"fuzzy_leak": 201.0}, r"fuzzy_leak must be at most one over the control period, 200\.0 1/s, got 201\.0"),
]
BOUND = [
    ({"bound": {"width": 1.0}}, r"bound must have fields among \['initial', 'final', .*got 'width'"),
    ({"bound": {"initial": 0.0}}, r"bound\.initial must be positive, got 0\.0"),
    ({"bound": {"final": 9.0}}, r"bound\.final must not exceed initial = 0\.5, got 9\.0"),
    ({"bound": {"lower": (1.0, 1.0)}}, r"bound\.lower must have 3 numbers"),
    ({"margin": 0.5}, r"margin must lie within \(0, 0\.5\), got 0\.5"),
    ({"power": 1.0}, r"power must lie within \(0, 1\), got 1\.0"),
    ({"rate_power_gain": -1.0}, r"rate_power_gain must not be negative, got -1\.0"),
]
BAD = {
    "chen_m1": [
        *COMMON, *FUZZY, *BOUND,
        ({"attitude_power_gain": -1.0}, r"attitude_power_gain must not be negative, got -1\.0"),
        ({"compensation_gain": -1.0}, r"compensation_gain must not be negative, got -1\.0"),
        ({"filter_first": 0.0}, r"filter_first must be positive, got 0\.0"),
        ({"filter_second": math.nan}, "filter_second must be finite, got nan"),
        ({"filter_substeps": -1}, "filter_substeps must be a whole number, 0 or more, got -1"),
        ({"filter_substeps": 1.5}, r"filter_substeps must be a whole number, 0 or more, got 1\.5"),
        ({"filter_start": "one"}, r"filter_start must be one of \['zero', 'virtual'\], got 'one'"),
        ({"attitude_filter_time": -1.0}, r"attitude_filter_time must not be negative, got -1\.0"),
    ],
    "chen_m2": [*COMMON, *FUZZY],
    "chen_m3": [
        ({"linear": -1.0}, r"linear must not be negative, got -1\.0"),
        ({"terminal": -1.0}, r"terminal must not be negative, got -1\.0"),
        ({"exponent": 1.0}, r"exponent must lie within \(0, 1\), got 1\.0"),
        ({"bound": 0.0}, r"bound must be positive, got 0\.0"),
        ({"reaching_linear": -1.0}, r"reaching_linear must not be negative, got -1\.0"),
        ({"reaching_power_gain": -0.1}, r"reaching_power_gain must not be negative, got -0\.1"),
        ({"reaching_exponent": 1.0}, r"reaching_exponent must lie within \(0, 1\), got 1\.0"),
        ({"adaptation": -1.0}, r"adaptation must not be negative, got -1\.0"),
        ({"forgetting": -1.0}, r"forgetting must not be negative, got -1\.0"),
        ({"forgetting": 201.0}, r"forgetting must be at most one over the control period, 200\.0 1/s, got 201\.0"),
        ({"layer": 0.0}, r"layer must be positive, got 0\.0"),
        ({"jump": True, "adaptation": 0.0}, r"adaptation must be positive, got 0\.0"),
    ],
    "prescribed_performance": [*COMMON, *BOUND, ({"faults": "guess"}, "faults must be one of")],
}  # fmt: skip
CASES = [(name, changes, message) for name, cases in BAD.items() for changes, message in cases]


@pytest.mark.parametrize(("name", "changes", "message"), CASES, ids=[f"{n}-{c}" for n, c, _ in CASES])
def test_bad_gains(name, changes, message):
    with pytest.raises(ValueError, match=rf"^({name}: )?{message}"):
        baselines.make(name, CHEN, **changes)


@pytest.mark.parametrize("name", ["chen_m2", "chen_m3"])
@pytest.mark.parametrize("scalar", [1.0, -1.0])
def test_at_the_target_with_either_sign_of_the_quaternion_commands_are_finite(name, scalar):
    """q = -1 is 360 degrees away from the target, where the MRP is infinite."""
    task = CHEN.replace(initial_state=InitialState.fixed((scalar, 0.0, 0.0, 0.0)))
    simulator, law = Simulator(task, 1), baselines.make(name, task, shadow_switch=False)
    simulator.reset(task.draw(0, 1))
    with np.errstate(all="raise"):
        for _ in range(5):
            command = law.act(simulator.measurement())
            assert np.isfinite(command).all()
            simulator.step(command)


def test_a_craft_that_does_not_act_is_not_refused():
    """act_only is of the first alone: that the second is outside its bounds is no matter yet."""
    task = CHEN.replace(initial_state=InitialState(angle=(2.0, 2.4)))
    bound = {"initial": 0.45, "lower": (1.0,) * 3, "upper": (1.0,) * 3, "initial_factor": None}
    simulator, law = Simulator(task, 40), baselines.make("chen_m1", task, 40, bound=bound)
    simulator.reset(task.draw(0, 40))
    measurement = simulator.measurement()
    sigma = measurement.attitude[:, 1:] / (1.0 + measurement.attitude[:, :1])
    inside = (np.abs(sigma) < 0.45).all(axis=1)
    assert inside.any() and not inside.all()
    command = law.act_only(measurement, inside)
    assert np.isfinite(command[inside]).all()
    alone = baselines.make("chen_m1", task, 40, bound=bound)
    with pytest.raises(ValueError, match="must be within its prescribed bound"):
        alone.act(measurement)
    with pytest.raises(ValueError, match="must be within its prescribed bound"):
        law.act_only(measurement, ~inside)  # they are still fresh
