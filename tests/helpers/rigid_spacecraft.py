"""A rigid spacecraft under known commands: flown by the plant, and integrated by SciPy from equations of a paper."""

from itertools import pairwise

import numpy as np
from scipy.integrate import solve_ivp

from ftac_gym.dynamics import Simulator


def flown(scenario, commands):
    """States [q, w] (T + 1, 7) of the compiled plant under commands (T, wheels) [N m]."""
    simulator = Simulator(scenario, 1)
    simulator.reset(scenario.draw(0, 1))
    states = [np.append(simulator.state.attitude[0], simulator.state.rate[0])]
    for command in commands:
        simulator.step(command[None])
        states.append(np.append(simulator.state.attitude[0], simulator.state.rate[0]))
    return np.array(states)


def integrated(start, commands, period, inertia, wheels, external):
    """States (T + 1, 7) of J(t) w' = -w x J(t) w + D tau + d.

    The functions are the paper's: ``inertia(t)``, ``wheels(t, command, probe)``, the torque on the body, and
    ``external(t, w)``. ``probe`` is a time within the period and decides which faults act.
    """

    def derivative(time, state, command, probe):
        q, w = state[:4], state[4:]
        matrix = inertia(time)
        torque = wheels(time, command, probe) + external(time, w) - np.cross(w, matrix @ w)
        turn = 0.5 * np.append(-q[1:] @ w, q[0] * w + np.cross(q[1:], w))
        return np.append(turn, np.linalg.solve(matrix, torque))

    return integrate(derivative, start, commands, period, rtol=1e-11, atol=1e-12)


def integrate(derivative, start, commands, period, **tolerances):
    """Return the states (T + 1, .) of ``derivative(time, state, command, probe)``, integrated period by period."""
    states = [np.array(start)]
    for (begin, end), command in zip(pairwise(np.arange(len(commands) + 1) * period), commands, strict=True):
        arguments = (command, 0.5 * (begin + end))
        solution = solve_ivp(derivative, (begin, end), states[-1], "DOP853", args=arguments, **tolerances)
        states.append(solution.y[:, -1])
    return np.array(states)
