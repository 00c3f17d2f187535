"""Density of the air between 200 and 1000 km."""

import numpy as np

from ftac_gym.utils.parameters import FloatArray

ATMOSPHERE: FloatArray = np.array([
    [200e3, 2.789e-10, 37.105e3],
    [250e3, 7.248e-11, 45.546e3],
    [300e3, 2.418e-11, 53.628e3],
    [350e3, 9.518e-12, 53.298e3],
    [400e3, 3.725e-12, 58.515e3],
    [450e3, 1.585e-12, 60.828e3],
    [500e3, 6.967e-13, 63.822e3],
    [600e3, 1.454e-13, 71.835e3],
    [700e3, 3.614e-14, 88.667e3],
    [800e3, 1.170e-14, 124.640e3],
    [900e3, 5.245e-15, 181.050e3],
    [1000e3, 3.019e-15, 268.000e3],
])  # fmt: skip
"""Base altitude [m], density there [kg/m^3] and scale height [m] of the exponential atmosphere from 200 to 1000 km.

Vallado, Fundamentals of Astrodynamics and Applications, 4th ed. 2013, Table 8-4 (from Wertz 1978): moderate solar
activity.
"""


def atmospheric_density(altitude: FloatArray) -> FloatArray:
    """Return the density of the air [kg/m^3] at altitudes [m] within the table ATMOSPHERE; the range is not checked."""
    base, density, scale_height = ATMOSPHERE[np.searchsorted(ATMOSPHERE[:, 0], altitude, side="right") - 1].T
    return density * np.exp((base - altitude) / scale_height)
