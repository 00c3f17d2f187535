"""HSFC, AFNTSMC and SHOPD+ along flights, against laws and a plant that were written twice."""

import numpy as np
import pytest
from helpers.hybrid_laws import AFNTSMC, HSFC, SHOPD, RateTarget, kinematics
from helpers.laws import NominalModel, Plant
from scipy.integrate import solve_ivp

from ftac_gym import baselines, scenarios
from ftac_gym.dynamics import Simulator
from ftac_gym.faults import FaultSchedule, LossOfEffectiveness
from ftac_gym.spacecraft.layouts import orthogonal_and_skew
from ftac_gym.spacecraft.spacecraft import Spacecraft
from ftac_gym.spacecraft.wheel_array import WheelArray
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.references import RateProfile, fixed_attitude

MA = scenarios.get("ma_2023_faulty")
SKEWED = np.array([[1.0, 0.1, -0.2], [0.1, 0.9, 0.2], [-0.1, 0.2, 1.0]])
SKEWED = SKEWED / np.linalg.norm(SKEWED, axis=0)
AXES = {"orthogonal": np.eye(3), "skewed": SKEWED, "four": np.array(orthogonal_and_skew())}
FREQUENCY = (0.5, 0.8, 1.1)  # rad/s, faster than the paper's: the feed-forward matters
START = np.array([0.83, 0.3, -0.25, -0.4]) / np.linalg.norm([0.83, 0.3, -0.25, -0.4])
RATE = (0.06, -0.04, 0.05)
NEAR = np.array([0.15, 0.6, -0.5, 0.6]) / np.linalg.norm([0.15, 0.6, -0.5, 0.6])  # 163 degrees
AWAY = tuple(2.0 * NEAR[1:])  # a rate that takes it through 180 degrees


def task(period, wheels="orthogonal", limit=10.0, attitude=START, rate=RATE, **changes):
    """The paper's spacecraft, disturbance and kind of fault and reference."""
    array = WheelArray(AXES[wheels].tolist(), limit, momentum_coupling=False)
    faults = tuple(
        LossOfEffectiveness(wheel=wheel, effectiveness=0.5 + 0.05 * wheel, amplitude=0.05, frequency=2.0 + wheel)
        for wheel in range(array.count)
    )
    return MA.replace(
        spacecraft=Spacecraft(MA.spacecraft.inertia, array),
        initial_state=InitialState.fixed(tuple(attitude), rate),
        reference=RateProfile(amplitude=(0.05, 0.05, 0.05), frequency=FREQUENCY),
        faults=FaultSchedule(faults),
        control_period=period,
        physics_step=period / round(period / 0.005),
        **changes,
    )


def truth(count):
    """The same effectiveness and disturbance, as functions of time."""
    wheels = np.arange(count)

    def external(time):
        return np.array([0.1 * np.sin(time), 0.2 * np.sin(1.2 * time), 0.3 * np.sin(1.5 * time)])

    def effectiveness(time, probe):
        return 0.5 + 0.05 * wheels + 0.05 * np.sin((2.0 + wheels) * time)

    return effectiveness, lambda time, probe: np.zeros(count), external


def flown(scenario, name, steps, **gains):
    """Return true states (steps + 1, 7) and commands (steps, m) under the package's law."""
    simulator, law = Simulator(scenario, 1), baselines.make(name, scenario, **gains)
    simulator.reset(scenario.draw(0, 1))
    states, commands = [np.append(simulator.state.attitude[0], simulator.state.rate[0])], []
    for _ in range(steps):
        commands.append(law.act(simulator.measurement())[0])
        simulator.step(commands[-1][None])
        states.append(np.append(simulator.state.attitude[0], simulator.state.rate[0]))
    return np.array(states), np.array(commands)


def both(scenario, name, law, steps, start, gains):
    """Return states and commands of the package and of the law that was written again."""
    plant = Plant(law.model, *truth(law.model.axes.shape[1]))
    return *flown(scenario, name, steps, **gains), *plant.history(law, start, steps)


def craft_of(scenario):
    return NominalModel(scenario, RateTarget((0.05, 0.05, 0.05), FREQUENCY))


SOFT = {"layer": 0.05}
HSFC_CASES = {
    # name, period, steps, task, the package's gains, those of the law written again
    "as printed, clipped": ("hsfc", 0.01, 100, {"wheels": "skewed"}, SOFT, SOFT),
    "componentwise": (
        "hsfc_componentwise", 0.02, 100, {"wheels": "skewed"},
        {"layer": 0.02}, {"form": "componentwise", "gamma0": 0.6, "layer": 0.02},
    ),
    "componentwise, four wheels": (
        "hsfc_componentwise", 0.05, 100, {"wheels": "four", "limit": 3.0},
        SOFT, {"form": "componentwise", "gamma0": 0.6, **SOFT},
    ),
    "sliding": (
        "hsfc", 0.02, 100, {"limit": 50.0}, {"compensation": "sliding", "smallest_effectiveness": 0.5, "layer": 0.5},
        {"form": "sliding", "gamma0": 0.5, "layer": 0.5},
    ),
    "floor": (
        "hsfc_floor", 0.05, 100, {}, {"initial_gamma": 2.0},
        {"gamma0": 1.0, "alpha": 0.1, "delta": 0.01, "floor": 1.0, "gamma": 2.0},
    ),
    "unlike numbers": (
        "hsfc", 0.02, 100, {},
        {
            "gain": 3.0, "attitude_gain": 7.0, "adaptation": 0.3, "smoothing": 0.2, "smallest_effectiveness": 0.7,
            "layer": 0.1, "initial_gamma": 1.5, "hysteresis": 0.4,
        },
        {"k": 3.0, "k1": 7.0, "alpha": 0.3, "delta": 0.2, "gamma0": 0.7, "layer": 0.1, "gamma": 1.5, "eta": 0.4},
    ),
    "no layer": ("hsfc", 0.01, 100, {}, {"smallest_effectiveness": 0.8, "layer": 0.0}, {"gamma0": 0.8, "layer": 0.0}),
}  # fmt: skip


@pytest.mark.parametrize("case", HSFC_CASES)
def test_hsfc_agrees_with_an_independent_implementation(case):
    name, period, steps, setting, gains, theirs = HSFC_CASES[case]
    scenario = task(period, **setting)
    law = HSFC(craft_of(scenario), **theirs)
    states, commands, expected, orders = both(scenario, name, law, steps, np.append(START, RATE), gains)
    np.testing.assert_allclose(states, expected, rtol=0.0, atol=1e-10)
    np.testing.assert_allclose(commands, orders, rtol=0.0, atol=1e-8)  # N m
    assert np.ptp(law.history) > 0.05  # the adaptive gain moves
    limit = setting.get("limit", 10.0)
    if case == "floor":
        assert 5 < (np.array(law.history) > 1.0).sum() < 100  # above it, and on it
    assert ((np.abs(orders) == limit).mean() > 0.1) == (case in ("as printed, clipped", "componentwise, four wheels"))


SLOW = {
    "reaching_linear": 2.0,
    "reaching_power_gain": 1.0,
    "adaptation": 1e-4,
    "initial_bound": 1e-3,
    "hysteresis": 0.1,
}
SLOW_AGAIN = {"tau": 2.0, "beta": 1.0, "n": 1e-4, "start": 1e-3, "eta": 0.1}


@pytest.mark.parametrize(
    ("name", "law", "gains"),
    [("hsfc", HSFC, SOFT), ("shopd_plus", SHOPD, {}), ("afntsmc", AFNTSMC, SLOW_AGAIN)],
)  # fmt: skip
def test_a_jump_of_h_along_the_way_agrees_too(name, law, gains):
    scenario = task(0.02, limit=50.0, attitude=NEAR, rate=AWAY)
    theirs = {"hsfc": SOFT, "afntsmc": SLOW}.get(name, {})
    mine = law(craft_of(scenario), **gains)
    states, commands, expected, orders = both(scenario, name, mine, 50, np.append(NEAR, AWAY), theirs)
    assert (np.abs(orders) < 50.0).mean() > 0.9
    assert mine.jumps == 1 and states[0, 0] > 0.1  # not at the first call
    np.testing.assert_allclose(states, expected, rtol=0.0, atol=1e-10)
    np.testing.assert_allclose(commands, orders, rtol=0.0, atol=1e-8)


COMPARATORS = {
    "afntsmc, clipped": ("afntsmc", AFNTSMC, 0.02, {"wheels": "skewed"}, {}, {}),
    "afntsmc, unlike numbers": (
        "afntsmc", AFNTSMC, 0.05, {"limit": 1000.0},
        {
            "linear": 0.4, "terminal": 0.7, "exponent": 0.7, "bound": 0.2, "reaching_linear": 30.0,
            "reaching_power_gain": 4.0, "reaching_exponent": 0.8, "adaptation": 0.5, "forgetting": 0.6, "width": 0.3,
            "initial_bound": 0.2,
        },
        {
            "k2": 0.4, "k3": 0.7, "nu": 0.7, "epsilon": 0.2, "tau": 30.0, "beta": 4.0, "chi": 0.8, "n": 0.5, "e3": 0.6,
            "e5": 0.3, "start": 0.2,
        },
    ),
    "shopd_plus": ("shopd_plus", SHOPD, 0.02, {}, {}, {}),
    "shopd_plus, q_c(0) = 0": ("shopd_plus_zero_filter", SHOPD, 0.05, {"wheels": "skewed"}, {}, {"matched": False}),
    "shopd_plus, unlike numbers": (
        "shopd_plus", SHOPD, 0.05, {"wheels": "four", "limit": 4.0},
        {"gain": 20.0, "damping": 5.0, "filter_rate": 0.4, "filter_gain": 8.0},
        {"k4": 20.0, "k5": 5.0, "a": 0.4, "b": 8.0},
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", COMPARATORS)
def test_comparators_agree_with_an_independent_implementation(case):
    name, law, period, setting, gains, theirs = COMPARATORS[case]
    scenario = task(period, **setting)
    mine = law(craft_of(scenario), **theirs)
    states, commands, expected, orders = both(scenario, name, mine, 100, np.append(START, RATE), gains)
    np.testing.assert_allclose(states, expected, rtol=0.0, atol=1e-10)
    np.testing.assert_allclose(commands, orders, rtol=0.0, atol=1e-8)


@pytest.mark.parametrize("form", ["norm", "componentwise", "sliding"])
def test_a_shorter_period_converges_to_the_continuous_loop(form):
    """To first order, in a flight on which nothing that has a kink changes its sign."""
    duration, start, limit = 1.0, np.append(START, RATE), 1e6
    gains = {"form": form, "gamma0": 0.6, "layer": 10.0, "alpha": 0.5}
    scenario = task(0.01, limit=limit)
    law = HSFC(craft_of(scenario), **gains)
    effectiveness, _, external = truth(3)
    target, model = law.model.target, law.model

    def derivative(time, state):
        q, w, reference, law.gamma = state[:4], state[4:7], state[7:11], state[11]
        rate, acceleration = target.motion(time)
        torque, growth = law.demanded(*law.errors((reference, rate, acceleration), q, w))
        change = model.inverse @ (effectiveness(time, None) * torque + external(time) - model.gyroscopic(w))
        return np.concatenate([kinematics(q, w), change, kinematics(reference, rate), [growth * law.gamma]])

    begin = np.concatenate([start, [1.0, 0.0, 0.0, 0.0, 2.5]])
    options = {"method": "DOP853", "rtol": 1e-11, "atol": 1e-12}
    end = solve_ivp(derivative, (0.0, duration), begin, **options).y[:, -1]
    assert end[11] < 2.3
    errors = []
    for period in (0.02, 0.01, 0.005):
        ours = {"compensation": form, "smallest_effectiveness": 0.6, "layer": 10.0, "adaptation": 0.5}
        states, _ = flown(task(period, limit=limit), "hsfc", round(duration / period), **ours)
        errors.append(np.linalg.norm(states[-1] - end[:7]))
    assert errors[0] < 0.02
    np.testing.assert_allclose(np.array(errors[:-1]) / errors[1:], 2.0, rtol=0.1)


@pytest.mark.parametrize(
    ("name", "gains", "message"),
    [
        ("hsfc", {"gain": 0.0}, "gain must be positive"),
        ("hsfc", {"attitude_gain": -1.0}, "attitude_gain must not be negative"),
        ("hsfc", {"adaptation": -1.0}, "adaptation must not be negative"),
        ("hsfc", {"smoothing": 0.0}, r"smoothing must lie within \(0, 1\)"),
        ("hsfc", {"smoothing": 1.0}, r"smoothing must lie within \(0, 1\)"),
        ("hsfc", {"smallest_effectiveness": 0.0}, r"smallest_effectiveness must lie within \(0, 1\]"),
        ("hsfc", {"smallest_effectiveness": 1.1}, r"smallest_effectiveness must lie within \(0, 1\]"),
        ("hsfc", {"compensation": "both"}, "compensation must be one of .*'norm'.*'sliding'.*got 'both'"),
        ("hsfc", {"layer": -1.0}, "layer must not be negative"),
        ("hsfc", {"initial_gamma": 0.0}, r"initial_gamma must lie within \(0, 1e\+100\)"),
        ("hsfc_floor", {"gamma_floor": -1.0}, "gamma_floor must not be negative"),
        ("hsfc", {"hysteresis": 1.0}, r"hysteresis must lie within \(0, 1\)"),
        ("hsfc", {"attitude_filter_time": -1.0}, "attitude_filter_time must not be negative"),
        ("afntsmc", {"linear": -1.0}, "linear must not be negative"),
        ("afntsmc", {"terminal": -1.0}, "terminal must not be negative"),
        ("afntsmc", {"exponent": 1.0}, r"exponent must lie within \(0, 1\)"),
        ("afntsmc", {"bound": 0.0}, "bound must be positive"),
        ("afntsmc", {"reaching_linear": -1.0}, "reaching_linear must not be negative"),
        ("afntsmc", {"reaching_power_gain": -1.0}, "reaching_power_gain must not be negative"),
        ("afntsmc", {"reaching_exponent": 1.0}, r"reaching_exponent must lie within \(0, 1\)"),
        ("afntsmc", {"adaptation": -1.0}, "adaptation must not be negative"),
        ("afntsmc", {"forgetting": -1.0}, "forgetting must not be negative"),
        ("afntsmc", {"forgetting": 101.0}, "forgetting must be at most one over the control period, 100.0 1/s"),
        ("afntsmc", {"width": 0.0}, "width must be positive"),
        ("afntsmc", {"initial_bound": np.nan}, "initial_bound must be finite"),
        ("afntsmc", {"hysteresis": -0.1}, r"hysteresis must lie within \(0, 1\)"),
        ("shopd_plus", {"gain": -1.0}, "gain must be positive"),
        ("shopd_plus", {"damping": 0.0}, "damping must be positive"),
        ("shopd_plus", {"filter_rate": 0.0}, "filter_rate must be positive"),
        ("shopd_plus", {"filter_gain": 0.0}, "filter_gain must be positive"),
        ("shopd_plus", {"filter_start": "soft"}, r"filter_start must be one of \['matched', 'zero'\], got 'soft'"),
        ("shopd_plus", {"hysteresis": "wide"}, "hysteresis must be a number"),
    ],
)
def test_bad_gains(name, gains, message):
    with pytest.raises(ValueError, match=f"^{name}: {message}"):
        baselines.make(name, MA, **gains)


def test_a_gamma_that_has_vanished_gives_a_finite_torque():
    """Its square underflows, and S is zero on two axes: 0 / 0."""
    task = MA.replace(faults=None, disturbance=None, reference=fixed_attitude())
    task = task.replace(initial_state=InitialState.fixed((0.8, 0.6, 0.0, 0.0), rate=(0.1, 0.0, 0.0)))
    simulator, law = Simulator(task, 1), baselines.make("hsfc", task, initial_gamma=1e-170)
    simulator.reset(task.draw(0, 1))
    for _ in range(3):
        command = law.act(simulator.measurement())
        assert np.isfinite(command).all() and np.isfinite(law.memory["gamma"]).all() and (law.memory["gamma"] > 0).all()
        simulator.step(command)
