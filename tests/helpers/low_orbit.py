"""Geometries, inertias and single torques of a low orbit."""

import math

import numpy as np

from ftac_gym.task import InertiaUncertainty, LowOrbitTorque

NOMINAL = np.array([[10.0, 1.2, 0.5], [1.2, 19.0, 1.5], [0.5, 1.5, 25.0]])  # kg m^2
SPHERE = np.eye(3)  # an inertia without gravity gradient [kg m^2]
ORBIT = np.linspace(0.0, 2.0 * math.pi, 49)  # n t over one orbit
TORQUE = LowOrbitTorque()
GRADIENT = LowOrbitTorque(drag_area=0.0, solar_area=0.0, residual_dipole=0.0)  # gravity gradient alone
MAGNETIC = LowOrbitTorque(drag_area=0.0, solar_area=0.0)  # on a sphere: residual dipole alone
DRAG = LowOrbitTorque(solar_area=0.0, residual_dipole=0.0)  # on a sphere: drag alone
SUNLIGHT = LowOrbitTorque(drag_area=0.0, residual_dipole=0.0)  # on a sphere: sunlight alone

# Two square metres, 15 cm off centre.
PANELS = LowOrbitTorque(drag_area=2.0, solar_area=2.0, pressure_offset=0.15, density_factor=1.0, residual_dipole=0.0)


def deviates(count=500, seed=0):
    return np.random.default_rng(seed).random((count, TORQUE.uniform_count))


def inertias(count, seed=1):
    """Inertias (N, 3, 3) spread by 30 % around the nominal one."""
    uncertainty = InertiaUncertainty(relative=0.3)
    return uncertainty.draw(NOMINAL, np.random.default_rng(seed).random((count, 6)))["constant"]


def same(inertia, count):
    return np.tile(inertia, (count, 1, 1))


def history(steady, harmonics):
    """Evaluate drawn records (N,), (N, 2) over one orbit of each spacecraft: (N, times, 3)."""
    time = ORBIT / harmonics["frequency"][:, :1]
    angle = harmonics["frequency"][:, None, :, None] * time[:, :, None, None]
    part = harmonics["sine"][:, None] * np.sin(angle) + harmonics["cosine"][:, None] * np.cos(angle)
    return steady["constant"][:, None] + part.sum(axis=2)


def peak(torque, inertia, uniform):
    """Largest torque over an orbit, (N,)."""
    return np.linalg.norm(history(*torque.draw(uniform, same(inertia, len(uniform)))), axis=2).max(axis=1)


def size(vectors):
    return np.linalg.norm(vectors, axis=-1)
