"""Torques on a spacecraft in a circular low orbit: gravity gradient, magnetic dipole, air drag and sunlight.

The spacecraft holds its attitude, either inertial or turning with the orbit. Each model then is a finite Fourier series
in the argument of latitude u, exact without any fit. Three assumptions simplify the orbit:

* The Earth's field is a dipole along its axis (not tilted), and the air does not turn with the Earth.
* There is no shadow of the Earth, and the areas across air and sunlight are the same from every side.
* The orbit is circular, and its plane does not move.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ftac_gym.attitude import cross
from ftac_gym.utils.parameters import FloatArray

EARTH_RADIUS = 6378.137e3
"""Equatorial radius of the Earth [m] (WGS 84)."""

GRAVITATIONAL_PARAMETER = 3.986004418e14
"""Gravitational parameter of the Earth [m^3/s^2] (WGS 84)."""

MAGNETIC_MOMENT = 7.71e15
"""Magnetic dipole moment of the Earth, times mu0/(4 pi) [T m^3] (degree 1 of IGRF-13 at epoch 2020)."""

SOLAR_PRESSURE = 4.56e-6
"""Pressure of sunlight on a black surface at 1 au [N/m^2] (1367 W/m^2 over the speed of light)."""


def orbital_rate(altitude: Any) -> Any:
    """Return the rate [rad/s] of a circular orbit of an altitude [m], a number or an array."""
    return np.sqrt(GRAVITATIONAL_PARAMETER / (EARTH_RADIUS + altitude) ** 3)


@dataclass(frozen=True)
class OrbitGeometry:
    """Drawn orbits of N spacecraft, seen from body axes, with the areas and the dipole that the environment acts upon.

    The body axes are those at the ascending node. An inertial attitude has no others. For a body that turns with the
    orbit, ``node`` thus is the direction away from the Earth all the time, and ``transverse`` that of the flight.

    Parameters
    ----------
    altitude
        (N,) height of the orbit [m].
    inclination
        (N,) angle between the orbit normal and the Earth's axis [rad].
    node, transverse, normal
        (N, 3) unit vectors in body axes: to the ascending node, 90 deg ahead of it in the orbit, normal to the orbit.
    latitude_argument
        (N,) angle of the spacecraft from the node at time zero [rad].
    sunlight
        (N, 3) unit vector in which sunlight travels, in body axes.
    pressure_offset
        (N, 3) centre of pressure from the centre of mass, in body axes [m].
    residual_dipole
        (N, 3) magnetic dipole in body axes [A m^2].
    drag_area, solar_area
        (N,) areas [m^2].
    density
        (N,) density of the air [kg/m^3].
    """

    altitude: FloatArray
    inclination: FloatArray
    node: FloatArray
    transverse: FloatArray
    normal: FloatArray
    latitude_argument: FloatArray
    sunlight: FloatArray
    pressure_offset: FloatArray
    residual_dipole: FloatArray
    drag_area: FloatArray
    solar_area: FloatArray
    density: FloatArray

    @property
    def radius(self) -> FloatArray:
        """Radius of the orbit [m], array (N,)."""
        return EARTH_RADIUS + self.altitude

    @property
    def orbital_rate(self) -> FloatArray:
        """Orbital rate n [rad/s], array (N,)."""
        rate: FloatArray = orbital_rate(self.altitude)
        return rate


def series_of(constant: FloatArray, *waves: FloatArray) -> FloatArray:
    """Return a torque as a Fourier series, (N, 5, 3) [N m].

    Parameters
    ----------
    constant
        (N, 3) constant part [N m].
    *waves
        (N, 3) amplitudes of cos u, sin u, cos 2u and sin 2u [N m]; those left out are zero.
    """
    series = np.zeros((len(constant), 5, 3))
    for place, part in enumerate((constant, *waves)):
        series[:, place] = part
    return series


def gravity_gradient(geometry: OrbitGeometry, inertia: FloatArray, turning: bool) -> FloatArray:
    """Return the series (N, 5, 3) of 3 n^2 r x J r, with r pointing away from the Earth.

    In inertial body axes r = node cos u + transverse sin u; for a body that turns with the orbit it is constant.
    """
    node, transverse = geometry.node, geometry.transverse
    node_moment = np.einsum("nij,nj->ni", inertia, node)
    transverse_moment = np.einsum("nij,nj->ni", inertia, transverse)
    along, across = cross(node, node_moment), cross(transverse, transverse_moment)
    mixed = cross(node, transverse_moment) + cross(transverse, node_moment)
    scale = 1.5 * geometry.orbital_rate[:, None] ** 2
    nothing = np.zeros_like(along)
    if turning:
        return series_of(2.0 * scale * along)
    return series_of(scale * (along + across), nothing, nothing, scale * (along - across), scale * mixed)


def magnetic(geometry: OrbitGeometry, turning: bool) -> FloatArray:
    """Return the series (N, 5, 3) of m x B, with B = M/R^3 (k - 3 (k.r) r).

    The Earth's axis is k = transverse sin i + normal cos i at the node. Its dipole points south: at the equator the
    field points north. For a body that turns with the orbit k = sin i (r sin u + v cos u) + normal cos i, with v along
    the flight.
    """
    strength = (MAGNETIC_MOMENT / geometry.radius**3)[:, None]
    sine, cosine = np.sin(geometry.inclination)[:, None], np.cos(geometry.inclination)[:, None]
    along = strength * cross(geometry.residual_dipole, geometry.node)
    across = strength * cross(geometry.residual_dipole, geometry.transverse)
    upright = strength * cross(geometry.residual_dipole, geometry.normal)
    if turning:
        return series_of(cosine * upright, sine * across, -2.0 * sine * along)
    nothing = np.zeros_like(along)
    constant = cosine * upright - 0.5 * sine * across
    return series_of(constant, nothing, nothing, 1.5 * sine * across, -1.5 * sine * along)


def drag(geometry: OrbitGeometry, coefficient: float, turning: bool) -> FloatArray:
    """Return the series (N, 5, 3) of offset x (-1/2 rho V^2 Cd A v), with v along the flight.

    In inertial body axes v = transverse cos u - node sin u; for a body that turns with the orbit it is constant.
    """
    speed = geometry.orbital_rate * geometry.radius
    force = (0.5 * geometry.density * speed**2 * coefficient * geometry.drag_area)[:, None]
    offset = geometry.pressure_offset
    ahead, away = -force * cross(offset, geometry.transverse), force * cross(offset, geometry.node)
    return series_of(ahead) if turning else series_of(np.zeros_like(offset), ahead, away)


def sunlight(geometry: OrbitGeometry, reflectivity: float, turning: bool) -> FloatArray:
    """Return the series (N, 5, 3) of offset x P (1 + reflectivity) A s, with the sunlight along s.

    s is constant in inertial body axes; from a body that turns with the orbit it turns backwards about the normal.
    """
    force = (SOLAR_PRESSURE * (1.0 + reflectivity) * geometry.solar_area)[:, None]
    offset, normal, light = geometry.pressure_offset, geometry.normal, geometry.sunlight
    if not turning:
        return series_of(force * cross(offset, light))
    upright = normal * np.sum(normal * light, axis=1, keepdims=True)
    waves = (upright, light - upright, -cross(normal, light))
    return series_of(*(force * cross(offset, part) for part in waves))
