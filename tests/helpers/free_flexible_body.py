"""Tasks, energies and momenta of a flexible body."""

import numpy as np
from helpers.flexible_spacecraft import (
    INERTIA,
    PYRAMID,
)

from ftac_gym import attitude as att
from ftac_gym.spacecraft.appendages import FlexibleAppendages
from ftac_gym.task.disturbances import Disturbance, Harmonic

MOMENTUM = (1.0, -0.5, 0.3, 2.0)  # N m s
VARYING = {"amplitude": (1.0, 2.0, -1.5), "frequency": (0.8, 0.5, 0.3), "phase": (0.2, 0.0, 1.0)}
LEAN = np.array([[0.0, 0.02, -0.01, 0.03], [0.01, 0.0, 0.02, 0.0], [-0.02, 0.01, 0.0, 0.01]])
DISTURBANCE = Disturbance(
    constant=(0.02, -0.03, 0.01),
    harmonics=(
        Harmonic((0.05, 0.04, -0.03), 0.6, (0.0, 1.0, 2.0)),
        Harmonic((0.01, 0.02, 0.03), 1.7, (0.5, 0.0, -1.0)),
    ),
    rate_offset=0.3,
)


def external(time, rate):
    torque = np.array([0.02, -0.03, 0.01])
    torque = torque + np.array([0.05, 0.04, -0.03]) * np.sin(0.6 * time + np.array([0.0, 1.0, 2.0]))
    torque = torque + np.array([0.01, 0.02, 0.03]) * np.sin(1.7 * time + np.array([0.5, 0.0, -1.0]))
    return (rate @ rate + 0.3) * torque


def inertia(time):
    angle = np.array(VARYING["frequency"]) * time + np.array(VARYING["phase"])
    return INERTIA + np.diag(VARYING["amplitude"] * np.sin(angle))


def inertia_rate(time):
    angle = np.array(VARYING["frequency"]) * time + np.array(VARYING["phase"])
    return np.diag(np.array(VARYING["amplitude"]) * VARYING["frequency"] * np.cos(angle))


def undamped(appendages):
    return FlexibleAppendages(appendages.frequencies, 0.0, appendages.coupling)


def shaken(count, seed=1):
    """Displacements and rates of modes that are anything but at rest."""
    rng = np.random.default_rng(seed)
    return {"displacement": rng.uniform(-0.1, 0.1, count), "swing": rng.uniform(-0.1, 0.1, count)}


def split(states, modes):
    """Return rate, eta and eta' from state vectors (T, .) of spacecraft with four wheels."""
    return states[:, 4:7], states[:, 11 : 11 + modes], states[:, 11 + modes :]


def total_energy(states, appendages):
    """w' J w / 2 + w' delta' eta' + eta'.eta' / 2 + eta . K eta / 2."""
    rate, eta, swing = split(states, appendages.count)
    delta, stiffness = np.array(appendages.coupling), np.array(appendages.frequencies) ** 2
    body = 0.5 * np.einsum("ni,ij,nj->n", rate, INERTIA, rate)
    return body + np.einsum("ni,ki,nk->n", rate, delta, swing) + 0.5 * (swing**2 + stiffness * eta**2).sum(axis=1)


def inertial_momentum(states, appendages):
    rate, _, swing = split(states, appendages.count)
    body = rate @ INERTIA + swing @ np.array(appendages.coupling) + states[:, 7:11] @ PYRAMID.T
    return att.rotate_to_reference(states[:, :4], body)


def simpson(values, step):
    """Integral over an even number of steps."""
    return step / 3.0 * (values[0] + values[-1] + 4.0 * values[1:-1:2].sum() + 2.0 * values[2:-1:2].sum())
