"""External torque in a low orbit, from models of gravity gradient, magnetic dipole, air drag and sunlight.

The spacecraft holds an inertial attitude in a circular orbit. Then each model is a finite Fourier series in the
argument of latitude, exact without any fit: a constant and harmonics at the orbital rate n and at 2n. The records of
`ftac_gym.task.disturbances` hold such a series. Three assumptions simplify the orbit:

* The torques are those of one attitude, the target. They differ while the spacecraft turns and for later targets, but
  keep their size and frequencies; beside wheels a thousand times as strong the difference does not matter.
* The Earth's field is a dipole along its axis (not tilted), and the air does not turn with the Earth.
* There is no shadow of the Earth, and the areas across air and sunlight are the same from every side.
"""

import math
from dataclasses import dataclass
from functools import partial

import numpy as np
import numpy.typing as npt

from ftac_gym.attitude import cross, random_quaternion_from_uniforms, rotation_matrix
from ftac_gym.task.atmosphere import ATMOSPHERE, atmospheric_density
from ftac_gym.task.disturbances import DISTURBANCE, HARMONIC
from ftac_gym.utils.parameters import (
    FloatArray,
    Interval,
    bounds,
    draw,
    interval,
    largest,
    non_negative,
    non_negative_interval,
    normalise,
    require,
    uniform_directions,
)
from ftac_gym.utils.serialization import serializable

EARTH_RADIUS = 6378.137e3
"""Equatorial radius of the Earth [m] (WGS 84)."""

GRAVITATIONAL_PARAMETER = 3.986004418e14
"""Gravitational parameter of the Earth [m^3/s^2] (WGS 84)."""

MAGNETIC_MOMENT = 7.71e15
"""Magnetic dipole moment of the Earth, times mu0/(4 pi) [T m^3] (degree 1 of IGRF-13 at epoch 2020)."""

SOLAR_PRESSURE = 4.56e-6
"""Pressure of sunlight on a black surface at 1 au [N/m^2] (1367 W/m^2 over the speed of light)."""


@dataclass(frozen=True)
class OrbitGeometry:
    """Drawn orbits of N spacecraft, seen from body axes, with the areas and the dipole that the environment acts upon.

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
        return np.sqrt(GRAVITATIONAL_PARAMETER / self.radius**3)


Series = tuple[FloatArray, FloatArray, FloatArray]
"""Torque as a Fourier series: constant, amplitude of the cosine and of the sine, each (N, 3) [N m]."""


@serializable
@dataclass(frozen=True)
class LowOrbitTorque:
    """Distribution of the external torque on a spacecraft that holds an inertial attitude in a circular low orbit.

    Each episode draws the numbers below. The orientation of the orbit relative to the body, the start on the orbit and
    the direction of sunlight are uniform. With the defaults, the largest torque over an orbit of a body of
    about 20 kg m^2 lies between 1e-6 and 2e-4 N m.

    Parameters
    ----------
    altitude
        Height of the orbit [m], within 200-1000 km.
    inclination
        Angle between the orbit normal and the Earth's axis [rad], within [0, pi].
    drag_area
        Area across the flow of air [m^2].
    drag_coefficient
        Coefficient of drag.
    solar_area
        Area across the sunlight [m^2].
    reflectivity
        Share of sunlight that is reflected, within [0, 1]: 0 is black, 1 a mirror.
    pressure_offset
        Distance of the centre of pressure from the centre of mass [m], in a uniform direction; the same for air and
        sunlight.
    residual_dipole
        Residual magnetic dipole of the spacecraft [A m^2], in a uniform direction.
    density_factor
        Solar activity: a factor on the density of the table ATMOSPHERE. Averaged over the globe, NRLMSISE-00 has other
        multiples for F10.7 of 68, 150 and 230: 0.18, 1.1 and 2.8 at 400 km, and 0.11, 1.3 and 5.4 at 600 km.

    Raises
    ------
    ValueError
        If a value breaks a rule; the message names the field and the rule.
    """

    altitude: Interval = (400e3, 600e3)
    inclination: Interval = (0.0, math.pi)
    drag_area: Interval = (0.5, 1.2)
    drag_coefficient: float = 2.2
    solar_area: Interval = (0.5, 1.5)
    reflectivity: float = 0.6
    pressure_offset: Interval = (0.02, 0.1)
    residual_dipole: Interval = (0.1, 1.0)
    density_factor: Interval = (0.2, 3.0)

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        sizes = ("drag_area", "solar_area", "pressure_offset", "residual_dipole", "density_factor")
        normalise(self, non_negative_interval, *sizes)
        normalise(self, partial(interval, low=0.0, high=math.pi), "inclination")
        normalise(self, partial(interval, low=ATMOSPHERE[0, 0], high=ATMOSPHERE[-1, 0]), "altitude")
        normalise(self, non_negative, "drag_coefficient", "reflectivity")
        require(self.reflectivity <= 1.0, "reflectivity", "must stay within [0, 1]", self.reflectivity)

    @property
    def uniform_count(self) -> int:
        """Number of uniform deviates of one episode."""
        return 17

    def largest_torque(self, moment: float) -> float:
        """Return a bound on the torque [N m] on a body whose largest principal moment is given [kg m^2]."""
        lowest = bounds(self.altitude)[0]
        radius = EARTH_RADIUS + lowest
        density = largest(self.density_factor) * float(atmospheric_density(np.array(lowest)))
        speed_squared = GRAVITATIONAL_PARAMETER / radius
        drag = 0.5 * density * speed_squared * self.drag_coefficient * largest(self.drag_area)
        sunlight = SOLAR_PRESSURE * (1.0 + self.reflectivity) * largest(self.solar_area)
        gradient = 3.0 * GRAVITATIONAL_PARAMETER / radius**3 * moment
        dipole = 2.0 * MAGNETIC_MOMENT / radius**3 * largest(self.residual_dipole)
        return (drag + sunlight) * largest(self.pressure_offset) + gradient + dipole

    def draw(self, uniform: FloatArray, inertia: FloatArray) -> tuple[npt.NDArray[np.void], npt.NDArray[np.void]]:
        """Draw N torques.

        Parameters
        ----------
        uniform
            (N, uniform_count) uniform deviates in [0, 1).
        inertia
            (N, 3, 3) true inertia, symmetric, for the gravity gradient [kg m^2], without any varying part.

        Returns
        -------
        Arrays of DISTURBANCE (N,) and HARMONIC (N, 2): the harmonics have the frequencies n and 2n.

        Raises
        ------
        ValueError
            If an array has another shape, a deviate lies outside [0, 1) or an inertia is not finite.
        """
        geometry = self.geometry(uniform)
        count, inertia = len(uniform), np.asarray(inertia, dtype=np.float64)
        require(inertia.shape == (count, 3, 3), "inertia", f"must have the shape ({count}, 3, 3)", inertia.shape)
        endless = inertia[~np.isfinite(inertia)]
        require(endless.size == 0, "inertia", "must be finite", endless.tolist())

        gradient, dipole = _gravity_gradient(geometry, inertia), _magnetic(geometry)
        drag = _drag(geometry, self.drag_coefficient)
        steady = np.zeros(count, DISTURBANCE)
        steady["constant"] = gradient[0] + dipole[0] + drag[0] + _sunlight(geometry, self.reflectivity)
        table = np.zeros((count, 2), HARMONIC)
        double = (gradient[1] + dipole[1], gradient[2] + dipole[2])
        for column, (cosine, sine) in enumerate((drag[1:], double)):
            # From the argument of latitude u to time: u = u0 + n t.
            order = column + 1
            start = order * geometry.latitude_argument[:, None]
            table["frequency"][:, column] = order * geometry.orbital_rate
            table["cosine"][:, column] = cosine * np.cos(start) + sine * np.sin(start)
            table["sine"][:, column] = sine * np.cos(start) - cosine * np.sin(start)
        return steady, table

    def geometry(self, uniform: FloatArray) -> OrbitGeometry:
        """Draw N orbits and spacecraft from uniform deviates (N, uniform_count).

        Raises
        ------
        ValueError
            If the array has another shape or a deviate lies outside [0, 1).
        """
        uniform = np.asarray(uniform, dtype=np.float64)
        fits = uniform.ndim == 2 and uniform.shape[1] == self.uniform_count
        require(fits, "uniform", f"must have the shape (N, {self.uniform_count})", uniform.shape)
        outside = uniform[~((uniform >= 0.0) & (uniform < 1.0))]
        require(outside.size == 0, "uniform", "must lie within [0, 1)", outside.tolist())
        altitude = draw(self.altitude, uniform[:, 0])
        # The columns are the axes of the orbit in body axes.
        orbit = rotation_matrix(random_quaternion_from_uniforms(uniform[:, 2:5]))
        return OrbitGeometry(
            altitude=altitude,
            inclination=draw(self.inclination, uniform[:, 1]),
            node=orbit[:, :, 0],
            transverse=orbit[:, :, 1],
            normal=orbit[:, :, 2],
            latitude_argument=2.0 * np.pi * uniform[:, 5],
            sunlight=uniform_directions(uniform[:, 6:8]),
            pressure_offset=draw(self.pressure_offset, uniform[:, 8])[:, None] * uniform_directions(uniform[:, 9:11]),
            residual_dipole=draw(self.residual_dipole, uniform[:, 11])[:, None] * uniform_directions(uniform[:, 12:14]),
            drag_area=draw(self.drag_area, uniform[:, 14]),
            solar_area=draw(self.solar_area, uniform[:, 15]),
            density=draw(self.density_factor, uniform[:, 16]) * atmospheric_density(altitude),
        )


def _gravity_gradient(geometry: OrbitGeometry, inertia: FloatArray) -> Series:
    """Return the series in 2u of 3 n^2 r x J r, with r = node cos u + transverse sin u pointing away from the Earth."""
    node, transverse = geometry.node, geometry.transverse
    node_moment = np.einsum("nij,nj->ni", inertia, node)
    transverse_moment = np.einsum("nij,nj->ni", inertia, transverse)
    along, across = cross(node, node_moment), cross(transverse, transverse_moment)
    mixed = cross(node, transverse_moment) + cross(transverse, node_moment)
    scale = 1.5 * geometry.orbital_rate[:, None] ** 2
    return scale * (along + across), scale * (along - across), scale * mixed


def _magnetic(geometry: OrbitGeometry) -> Series:
    """Return the series in 2u of m x B, with B = M/R^3 (k - 3 (k.r) r).

    The Earth's axis is k = transverse sin i + normal cos i. Its dipole points south: at the equator the field points
    north.
    """
    strength = (MAGNETIC_MOMENT / geometry.radius**3)[:, None]
    sine, cosine = np.sin(geometry.inclination)[:, None], np.cos(geometry.inclination)[:, None]
    along = strength * cross(geometry.residual_dipole, geometry.node)
    across = strength * cross(geometry.residual_dipole, geometry.transverse)
    upright = strength * cross(geometry.residual_dipole, geometry.normal)
    return cosine * upright - 0.5 * sine * across, 1.5 * sine * across, -1.5 * sine * along


def _drag(geometry: OrbitGeometry, coefficient: float) -> Series:
    """Return the series in u of offset x (-1/2 rho V^2 Cd A v), with v = transverse cos u - node sin u along flight."""
    speed = geometry.orbital_rate * geometry.radius
    force = (0.5 * geometry.density * speed**2 * coefficient * geometry.drag_area)[:, None]
    offset = geometry.pressure_offset
    return np.zeros_like(offset), -force * cross(offset, geometry.transverse), force * cross(offset, geometry.node)


def _sunlight(geometry: OrbitGeometry, reflectivity: float) -> FloatArray:
    """Return the constant torque (N, 3) of sunlight, offset x P (1 + reflectivity) A s [N m]."""
    force = (SOLAR_PRESSURE * (1.0 + reflectivity) * geometry.solar_area)[:, None]
    return force * cross(geometry.pressure_offset, geometry.sunlight)
