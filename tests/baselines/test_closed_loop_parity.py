"""Closed loops with faults, disturbance and boundary layer against laws and a plant that were written twice."""

import numpy as np
import pytest
from helpers import controllers
from helpers.laws import Learning, NominalModel, Plant, SlidingMode, Target, kinematic_matrix, mrp
from helpers.units import LEARNING, NFTSM, PREDEFINED_TIME, SLIDING_MODE, in_units, observer_in_units
from scipy.integrate import solve_ivp

from ftac_gym import baselines
from ftac_gym.attitude import quaternion_from_mrp
from ftac_gym.dynamics import Simulator
from ftac_gym.faults import Bias, FaultSchedule, LossOfEffectiveness
from ftac_gym.spacecraft.layouts import orthogonal_and_skew, three_orthogonal
from ftac_gym.spacecraft.spacecraft import Spacecraft
from ftac_gym.spacecraft.wheel_array import WheelArray
from ftac_gym.task.disturbances import Disturbance, Harmonic
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.references import MRPSinusoid, fixed_attitude
from ftac_gym.task.scenario import Scenario

STRONG = ((30.0, 5.3, 6.4), (5.3, 27.0, 10.0), (6.4, 10.0, 19.0))  # kg m^2, Zhang and Zhou 2019
DIAGONAL = ((36.0, 0.0, 0.0), (0.0, 17.0, 0.0), (0.0, 0.0, 26.0))  # kg m^2, Cao, Gong and Han 2022
SIGMA, RATE = (0.3, -0.25, 0.2), (0.1, -0.05, 0.08)
WAVE = {"amplitude": (0.3, 0.1, 0.2), "frequency": (0.2, 0.4, 0.2)}
ONSET = 0.5  # s
TORQUE = np.array([[0.1, 0.05, -0.1], [0.1, 0.3, 0.5]])  # N m, constant and sin(t)


def task(wheels, period, reference=None, limit=5.0, faults=True):
    """A spacecraft with a varying loss of effectiveness, a bias and an external torque."""
    axes, inertia = (three_orthogonal(), DIAGONAL) if wheels == 3 else (orthogonal_and_skew(), STRONG)
    schedule = (
        LossOfEffectiveness(wheel=0, onset=ONSET, effectiveness=0.5, amplitude=0.2, frequency=0.9, phase=0.3),
        Bias(wheel=1, onset=ONSET, constant=0.06),
        LossOfEffectiveness(wheel=2, effectiveness=0.8),
    )
    return Scenario(
        name="twice",
        spacecraft=Spacecraft(
            inertia, WheelArray(axes, limit, momentum_coupling=False), allow_unphysical_inertia=True
        ),
        initial_state=InitialState.fixed(quaternion_from_mrp(np.array(SIGMA)).tolist(), RATE),
        reference=fixed_attitude() if reference is None else reference,
        faults=FaultSchedule(schedule) if faults else None,
        disturbance=Disturbance(tuple(TORQUE[0]), (Harmonic(tuple(TORQUE[1]), 1.0),)) if faults else None,
        control_period=period,
        physics_step=period / round(period / 0.005),
        duration=100.0 * period,
    )  # fmt: skip


def truth(wheels):
    """The same faults and torque, as functions of time."""

    def effectiveness(time, probe):
        share = np.ones(wheels)
        share[0] = 0.5 + 0.2 * np.sin(0.9 * time + 0.3) if probe > ONSET else 1.0
        share[2] = 0.8
        return share

    def bias(time, probe):
        return np.where(np.arange(wheels) == 1, 0.06 * (probe > ONSET), 0.0)

    return effectiveness, bias, lambda time: TORQUE[0] + TORQUE[1] * np.sin(time)


def flown(scenario, name, steps, **gains):
    """Return true states (steps + 1, 7), commands and estimates (steps, m) under the package's law."""
    simulator, law = Simulator(scenario, 1), baselines.make(name, scenario, **gains)
    simulator.reset(scenario.draw(0, 1))
    states, commands, estimates = [], [], []
    for _ in range(steps):
        states.append(np.append(simulator.state.attitude[0], simulator.state.rate[0]))
        simulator.step(law.act(simulator.measurement()))
        commands.append(simulator.last_command[0].copy())
        if law.estimate is not None:
            bias = law.estimate.bias
            estimates.append(np.append(law.estimate.effectiveness[0], [] if bias is None else bias[0]))
    states.append(np.append(simulator.state.attitude[0], simulator.state.rate[0]))
    return np.array(states), np.array(commands), np.array(estimates)


def working(model):
    return Learning(model, 2.0 * model.inertia, 2.0 * model.axes.T, 2.0 * model.axes.T, full=0.1)


def corrected(model):
    return Learning(model, 2.0 * model.inertia, model.axes.T, model.axes.T)


def printed(model):
    first, second = np.diag([8.0, 15.0, 12.0]), np.diag([20.0, 3.0, 8.0])
    return Learning(model, np.diag([80.0, 50.0, 60.0]), first, second, forgetting=0.9, switching=2.5, full=None)


RAW = {"attitude_filter_time": 0.0}
LOOPS = {
    "stabilisation": ("zhang_zhou_stabilisation", controllers.Stabilisation, SlidingMode, 4, 0.02, 90, {}),
    "stabilisation, saturated": ("zhang_zhou_stabilisation", controllers.Stabilisation, SlidingMode, 4, 0.02, 90, {}),
    "tracking": ("zhang_zhou_tracking", controllers.Tracking, SlidingMode, 4, 0.02, 90, {"bound": 0.1}),
    "tracking, feed-forward": (
        "zhang_zhou_tracking", controllers.Tracking, SlidingMode, 4, 0.02, 90, {"feed_forward": True},
    ),
    "ptc": ("ptc", controllers.PTC, corrected, 3, 0.01, 150, {"layer": 0.1}),
    "ptc, acceleration": (
        "ptc", controllers.PTC, corrected, 4, 0.01, 120, {"switching_form": "acceleration", "layer": 0.1},
    ),
    "ptc, observer as printed": ("ptc", controllers.PTC, printed, 3, 0.01, 20, {"faults": "lo", "layer": 0.1}),
    "tsmc_class": ("tsmc_class", controllers.TSMC, None, 4, 0.05, 60, RAW),
    "nftsm_observer": ("nftsm_observer", controllers.NFTSM, SlidingMode, 4, 0.05, 60, {**RAW, **NFTSM}),
    "predefined_time_observer": (
        "predefined_time_observer", controllers.PredefinedTime, working, 4, 0.05, 60, {**RAW, **PREDEFINED_TIME},
    ),
}  # fmt: skip
OBSERVERS = {
    "nftsm_observer": ("asmo_scaled", SLIDING_MODE), "predefined_time_observer": ("lo_scaled", LEARNING),
}  # fmt: skip
MOVING = ("tracking", "tracking, feed-forward", "ptc, acceleration", "tsmc_class", "nftsm_observer")


@pytest.mark.parametrize("case", LOOPS)
def test_flights_agree_with_an_independent_implementation(case):
    name, controller, observer, wheels, period, steps, gains = LOOPS[case]
    moving = case in MOVING
    limit = 20.0 if "acceleration" in case else 2.0 if "saturated" in case else 5.0
    scenario = task(wheels, period, MRPSinusoid(**WAVE) if moving else None, limit)
    model = NominalModel(scenario, Target(**WAVE) if moving else None)
    watching = None if observer is None else observer(model)
    law = controller(model, watching, **{key: value for key, value in gains.items() if hasattr(controller, "GAINS")
                                         and key in controller.GAINS})  # fmt: skip
    believed = []

    def recorded(time, q, w, last):
        command = law(time, q, w, last)
        believed.append(np.append(law.observer.effectiveness, law.observer.bias))
        return command

    start = np.append(quaternion_from_mrp(np.array(SIGMA)), RATE)
    states, commands = Plant(model, *truth(wheels)).history(recorded, start, steps)
    kind, known = OBSERVERS.get(name, (None, {}))
    ours = in_units(name, scenario, **gains)
    if kind is not None:
        ours["observer"] = observer_in_units(kind, scenario, **known)
    theirs, their_commands, estimates = flown(scenario, name, steps, **ours)
    np.testing.assert_allclose(theirs, states, atol=1e-8)
    np.testing.assert_allclose(their_commands, commands, atol=1e-6)  # N m
    if observer is not None:
        np.testing.assert_allclose(estimates, np.array(believed)[:, : estimates.shape[1]], atol=1e-8)
        assert estimates[:, :wheels].min() < 0.97  # there is an estimate to compare
    if "saturated" in case:
        assert (np.abs(commands) == limit).mean() > 0.2


def test_a_shorter_period_converges_to_the_continuous_loop():
    """To first order, for a smooth layer and as long as no component of sigma, whose root is in the law, is zero."""
    layer, duration = 0.3, 0.8
    base = task(4, 0.005, limit=1e6, faults=False)
    model = NominalModel(base)
    law = controllers.Stabilisation(model, layer=layer)

    def derivative(time, state):
        q, w = state[:4], state[4:7]
        law.chi, law.rho, law.weights = state[7], state[8], state[9:].reshape(5, 3)
        sigma, _, s = law.errors(q, w)
        torque = law.state(time, q, w)[2]
        distance = np.linalg.norm(s)
        return np.concatenate([
            0.5 * np.append(-q[1:] @ w, q[0] * w + np.cross(q[1:], w)),
            model.inverse @ (torque - model.gyroscopic(w)),
            [0.01 * distance * np.linalg.norm(kinematic_matrix(sigma) @ w), 0.001 * distance * model.norms],
            np.outer(law.network(w), model.inverse @ s).ravel(),
        ])  # fmt: skip

    start = np.concatenate([quaternion_from_mrp(np.array(SIGMA)), RATE, np.zeros(17)])
    limit = solve_ivp(derivative, (0.0, duration), start, method="DOP853", rtol=1e-11, atol=1e-12).y[:, -1]
    assert np.abs(mrp(limit[:4])).min() > 0.05
    errors = []
    for period in (0.02, 0.01, 0.005):
        scenario = task(4, period, limit=1e6, faults=False)
        steps = round(duration / period)
        end = flown(scenario, "zhang_zhou_stabilisation_no_observer", steps, layer=layer)[0][-1]
        errors.append(np.linalg.norm(end - limit[:7]))
    assert errors[0] < 0.02
    np.testing.assert_allclose(np.array(errors[:-1]) / errors[1:], 2.0, rtol=0.1)
