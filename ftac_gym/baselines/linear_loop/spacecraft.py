"""Linear model of the nominal spacecraft near rest, with reaction wheels and vibration modes."""

from __future__ import annotations

import numpy as np

from ftac_gym.baselines.linear_loop.system import System
from ftac_gym.task.scenario import Scenario


def spacecraft_model(scenario: Scenario) -> tuple[System, dict[str, slice]]:
    """Return the nominal spacecraft near rest in continuous time: from motor commands [N m] to what is measured.

    Its state is attitude error, rate, wheel momentum, modal displacement and rate, and the motor torques if they lag.

    Returns
    -------
    The system, and the rows of its output by the name of the field of a measurement.
    """
    spacecraft, wheels = scenario.spacecraft, scenario.spacecraft.wheels
    axes, count, modes = wheels.axis_matrix, wheels.count, spacecraft.modes
    names, first = {}, 0
    fields = {"attitude": 3, "rate": 3, "wheel_momentum": count, "modal_displacement": modes, "modal_rate": modes}
    for name, size in fields.items():
        names[name], first = slice(first, first + size), first + size
    size = first + (count if wheels.lag is not None else 0)
    a, torque = np.zeros((size, size)), np.zeros((size, count))
    a[names["attitude"], names["rate"]] = np.eye(3)
    torque[names["wheel_momentum"]] = -np.eye(count)
    inertia, appendages = spacecraft.inertia_matrix, spacecraft.appendages
    if appendages is None:
        torque[names["rate"]] = np.linalg.solve(inertia, axes)
    else:
        # J w' + delta' eta'' = tau and eta'' + C eta' + K eta = -delta w'.
        coupling = appendages.coupling_matrix
        body = inertia - appendages.carried_inertia
        force = np.concatenate([np.diag(appendages.stiffness), np.diag(appendages.damping)], axis=1)
        bending = slice(names["modal_displacement"].start, names["modal_rate"].stop)
        a[names["rate"], bending] = np.linalg.solve(body, coupling.T @ force)
        a[names["modal_displacement"], names["modal_rate"]] = np.eye(modes)
        a[names["modal_rate"], bending] = -force - coupling @ a[names["rate"], bending]
        torque[names["rate"]] = np.linalg.solve(body, axes)
        torque[names["modal_rate"]] = -coupling @ torque[names["rate"]]
    b = torque
    if wheels.lag is not None:
        lag = np.diag(1.0 / np.broadcast_to(wheels.lag, count))
        a[:, first:], b = torque, np.zeros_like(torque)
        a[first:, first:], b[first:] = -lag, lag
    return System(a, b, np.eye(size)[:first], np.zeros((first, count))), names
