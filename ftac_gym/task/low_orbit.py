"""External torque in a low orbit, from models of gravity gradient, magnetic dipole, air drag and sunlight.

The spacecraft holds one attitude, inertial or turning with a circular orbit. Then :mod:`ftac_gym.task.orbit` has the
torque as a constant and harmonics at the orbital rate n and at 2n. The records of `ftac_gym.task.disturbances` hold
such a series.

The torques differ while the spacecraft turns to its target, and for later set points. There they keep their size and
their frequencies; beside wheels a thousand times as strong the difference does not matter. References that move are
another matter: :mod:`ftac_gym.task.pointing` refuses them.
"""

import math
from dataclasses import dataclass, field
from functools import partial

import numpy as np
import numpy.typing as npt

from ftac_gym.attitude import random_quaternion_from_uniforms, rotation_matrix
from ftac_gym.task.atmosphere import ATMOSPHERE, atmospheric_density
from ftac_gym.task.disturbances import DISTURBANCE, HARMONIC
from ftac_gym.task.orbit import (
    EARTH_RADIUS,
    GRAVITATIONAL_PARAMETER,
    MAGNETIC_MOMENT,
    SOLAR_PRESSURE,
    OrbitGeometry,
    drag,
    gravity_gradient,
    magnetic,
    sunlight,
)
from ftac_gym.utils.parameters import (
    FloatArray,
    Interval,
    Vector,
    bounds,
    draw,
    interval,
    largest,
    non_negative,
    non_negative_interval,
    normalise,
    optional,
    require,
    uniform_directions,
    unit_vector,
)
from ftac_gym.utils.serialization import LATER_PART, serializable


@serializable
@dataclass(frozen=True)
class LowOrbitTorque:
    """Distribution of the external torque on a spacecraft in a circular low orbit.

    The torque is that of one attitude: an inertial one, or with ``nadir`` one that turns with the orbit. The reference
    of the scenario must stay within 10 deg of it, see :mod:`ftac_gym.task.pointing`. Fixed set points are inertial
    attitudes.

    Each episode draws the numbers below. The orientation of the orbit relative to an inertial body, the start on the
    orbit and the direction of sunlight are uniform. With the defaults, the largest torque over an orbit of a body of
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
    nadir, orbit_normal
        Unit vectors in body axes, perpendicular: to the Earth, and the normal of the orbit, about which the body turns
        at the orbital rate. For a reference that turns with the orbit; None for an inertial attitude.

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
    nadir: Vector | None = field(default=None, metadata=LATER_PART)
    orbit_normal: Vector | None = field(default=None, metadata=LATER_PART)

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        sizes = ("drag_area", "solar_area", "pressure_offset", "residual_dipole", "density_factor")
        normalise(self, non_negative_interval, *sizes)
        normalise(self, partial(interval, low=0.0, high=math.pi), "inclination")
        normalise(self, partial(interval, low=ATMOSPHERE[0, 0], high=ATMOSPHERE[-1, 0]), "altitude")
        normalise(self, non_negative, "drag_coefficient", "reflectivity")
        require(self.reflectivity <= 1.0, "reflectivity", "must stay within [0, 1]", self.reflectivity)
        normalise(self, optional(unit_vector), "nadir", "orbit_normal")
        both = (self.nadir is None) == (self.orbit_normal is None)
        require(both, "orbit_normal", "must come with nadir", self.orbit_normal)
        if self.nadir is not None and self.orbit_normal is not None:
            share = float(np.dot(self.nadir, self.orbit_normal))
            require(
                abs(share) <= 1e-3, "orbit_normal", "must be perpendicular to nadir; the cosine of the angle", share
            )

    @property
    def turning(self) -> bool:
        """True for the torque on a body that turns with the orbit."""
        return self.nadir is not None

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
        Arrays of DISTURBANCE (N,) and HARMONIC (N, 2): the harmonics have the frequencies n and 2n. On a body that
        turns with the orbit there is none at 2n, HARMONIC (N, 1).

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

        turning = self.turning
        series = gravity_gradient(geometry, inertia, turning) + magnetic(geometry, turning)
        series = (
            series + drag(geometry, self.drag_coefficient, turning) + sunlight(geometry, self.reflectivity, turning)
        )
        steady = np.zeros(count, DISTURBANCE)
        steady["constant"] = series[:, 0]
        table = np.zeros((count, 1 if turning else 2), HARMONIC)
        for column in range(table.shape[1]):
            order, cosine, sine = column + 1, series[:, 2 * column + 1], series[:, 2 * column + 2]
            # From the argument of latitude u to time: u = u0 + n t.
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
        if self.nadir is None or self.orbit_normal is None:
            orbit = rotation_matrix(random_quaternion_from_uniforms(uniform[:, 2:5]))
        else:
            away, normal = -np.array(self.nadir), np.array(self.orbit_normal)
            orbit = np.tile(np.column_stack([away, np.cross(normal, away), normal]), (len(uniform), 1, 1))
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
