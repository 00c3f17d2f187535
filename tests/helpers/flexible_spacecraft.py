"""Flexible spacecraft: random appendages, and an independent integration of the full coupled equations."""

import numpy as np
from helpers.rigid_spacecraft import integrate

from ftac_gym.dynamics import Simulator
from ftac_gym.spacecraft.appendages import FlexibleAppendages
from ftac_gym.spacecraft.spacecraft import Spacecraft
from ftac_gym.spacecraft.wheel_array import WheelArray
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.scenario import Scenario

INERTIA = np.array([[10.0, 1.2, 0.5], [1.2, 19.0, 1.5], [0.5, 1.5, 25.0]])  # kg m^2
PYRAMID = WheelArray.sign_pyramid(0.2, None).axis_matrix
QUATERNION = (0.5, -0.5, 0.5, 0.5)
RATE = (0.03, -0.04, 0.02)  # rad/s


def random_appendages(count, seed=0, share=0.4, frequencies=(0.5, 4.0), damping=(0.002, 0.02)):
    """Modes whose delta' delta is at most a share of ``INERTIA`` in every direction."""
    rng = np.random.default_rng(seed)
    coupling = rng.normal(size=(count, 3))
    root = np.linalg.inv(np.linalg.cholesky(INERTIA))
    most = np.linalg.eigvalsh(root @ coupling.T @ coupling @ root.T)[-1]
    return FlexibleAppendages(
        frequencies=tuple(rng.uniform(*frequencies, count)),
        damping_ratios=tuple(rng.uniform(*damping, count)),
        coupling=coupling * np.sqrt(share / most),
    )


def flexible_scenario(
    appendages, rate=RATE, momentum=0.0, coupling=True, displacement=None, swing=None, inertia=INERTIA, **parts
):
    """Return a scenario of a flexible spacecraft with four wheels; ``appendages=None`` is the rigid one."""
    start = InitialState.fixed(QUATERNION, rate, momentum).__dict__
    if displacement is not None:
        start = {**start, "modal_displacement": tuple(displacement)}
    if swing is not None:
        start = {**start, "modal_rate": tuple(swing)}
    return Scenario(
        name="flexible physics",
        spacecraft=Spacecraft(inertia, WheelArray(PYRAMID, 0.2, None, coupling), True, appendages),
        initial_state=InitialState(**start),
        **parts,
    )


def li_spacecraft(delta33=-0.83674):
    """The spacecraft of Li et al. 2023 with either sign of the third mode's coupling with the third axis."""
    appendages = FlexibleAppendages(
        frequencies=(1.5362, 2.2076, 3.7466, 3.7466),
        damping_ratios=(0.0056, 0.0086, 0.013, 0.013),
        coupling=(
            (6.45637, 1.27814, 2.15629),
            (-1.25819, 0.91756, -1.67264),
            (1.11687, 2.48901, delta33),
            (1.23637, -2.65810, -1.12530),
        ),
    )
    inertia = ((350.0, 3.0, 4.0), (3.0, 270.0, 10.0), (4.0, 10.0, 190.0))
    wheels = WheelArray(np.eye(3), torque_limit=5.0, momentum_coupling=False)
    return Spacecraft(inertia, wheels, appendages=appendages)


def started(scenario, count=1):
    """Return a simulator at the start of the scenario's first episodes."""
    simulator = Simulator(scenario, count)
    simulator.reset(scenario.draw(0, count))
    return simulator


def state_vector(simulator, index=0):
    """Return [q, w, h, eta, eta'] of one spacecraft."""
    state = simulator.state
    parts = (state.attitude, state.rate, state.wheel_momentum, state.modal_displacement, state.modal_rate)
    return np.concatenate([part[index] for part in parts])


def flown(scenario, commands):
    """State vectors (T + 1, .) of the compiled plant under commands (T, m)."""
    simulator = started(scenario)
    states = [state_vector(simulator)]
    for command in commands:
        simulator.step(command[None])
        states.append(state_vector(simulator))
    return np.array(states)


def integrated(start, commands, period, appendages, axes, coupled, inertia=None, inertia_rate=None, external=None):
    """State vectors (T + 1, .) of the equations as they are printed, by SciPy.

    The accelerations come from the mass matrix [[J, delta'], [delta, I]]; the plant uses neither it nor them.
    ``inertia(t)``, ``inertia_rate(t)`` and ``external(t, w)`` are functions; wheels are ideal.
    """
    delta, wheels, modes = np.array(appendages.coupling), axes.shape[1], appendages.count
    frequency = np.array(appendages.frequencies)
    stiffness, damping = frequency**2, 2.0 * np.array(appendages.damping_ratios) * frequency

    def derivative(time, state, command, _):
        q, w, h = state[:4], state[4:7], state[7 : 7 + wheels]
        eta, swing = state[7 + wheels : 7 + wheels + modes], state[7 + wheels + modes :]
        matrix = INERTIA if inertia is None else inertia(time)
        mass = np.block([[matrix, delta.T], [delta, np.eye(modes)]])
        momentum = matrix @ w + delta.T @ swing + (axes @ h if coupled else 0.0)
        torque = axes @ command - np.cross(w, momentum)
        if external is not None:
            torque = torque + external(time, w)
        if inertia_rate is not None:
            torque = torque - inertia_rate(time) @ w
        acceleration = np.linalg.solve(mass, np.concatenate([torque, -damping * swing - stiffness * eta]))
        turn = 0.5 * np.append(-q[1:] @ w, q[0] * w + np.cross(q[1:], w))
        return np.concatenate([turn, acceleration[:3], -command, swing, acceleration[3:]])

    return integrate(derivative, start, commands, period, rtol=1e-13, atol=1e-15)
