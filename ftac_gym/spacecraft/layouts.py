"""Common ways to mount reaction wheels, as matrices D of wheel axes.

Each function returns D, 3 x m: column j is the unit axis of wheel j in body axes. How large a torque every layout gives
in its weakest direction, before and after the loss of a wheel, follows from
:func:`~ftac_gym.spacecraft.envelope.envelope_normals`;
in units of the torque of one wheel:

=========================  =======  ================
layout                     healthy  after worst loss
=========================  =======  ================
three orthogonal           1        0
orthogonal and skew        1.414    0.577
sign pyramid (35.3 deg)    1.633    0.816
pyramid of four, 30 deg    1.549    0.775
pyramid of four, 45 deg    1.414    0.707
pyramid of four, 54.7 deg  1.155    0.577
=========================  =======  ================
"""

import math

from ftac_gym.utils.parameters import Matrix, finite, is_whole, require


def three_orthogonal() -> Matrix:
    """Return the axes of three wheels along the body axes, 3 x 3: no wheel to spare."""
    return ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def orthogonal_and_skew() -> Matrix:
    """Return the axes of three wheels along the body axes and a spare along (1, 1, 1)/sqrt 3, 3 x 4."""
    skew = 1.0 / math.sqrt(3.0)
    return ((1.0, 0.0, 0.0, skew), (0.0, 1.0, 0.0, skew), (0.0, 0.0, 1.0, skew))


def sign_pyramid() -> Matrix:
    """Return the axes (+-1, +-1, 1)/sqrt 3 of four wheels, 3 x 4.

    Of the layouts here it has the largest torque envelope, both healthy and after one loss, and D D' = 4/3 I.
    """
    signs = ((1.0, -1.0, -1.0, 1.0), (1.0, 1.0, -1.0, -1.0), (1.0, 1.0, 1.0, 1.0))
    return tuple(tuple(sign / math.sqrt(3.0) for sign in row) for row in signs)


def pyramid(elevation: float, count: int = 4, azimuth: float = 0.0) -> Matrix:
    """Return the axes of wheels spaced evenly around body z, 3 x ``count``.

    Parameters
    ----------
    elevation
        Angle of every axis above the x-y plane [rad], within (-pi/2, pi/2) and not zero.
    count
        Number of wheels, at least 3.
    azimuth
        Angle of the first wheel from x towards y [rad].

    Raises
    ------
    ValueError
        If a value breaks a rule. Level or upright wheels, or fewer than three, would not span space.
    """
    elevation, azimuth = finite(elevation, "elevation"), finite(azimuth, "azimuth")
    within = abs(elevation) < 0.5 * math.pi and elevation != 0.0
    require(within, "elevation", "must lie within (-pi/2, pi/2) and not be zero", elevation)
    require(is_whole(count) and count >= 3, "count", "must be an integer of at least 3", count)
    angles = [azimuth + 2.0 * math.pi * wheel / count for wheel in range(count)]
    return (
        tuple(math.cos(elevation) * math.cos(angle) for angle in angles),
        tuple(math.cos(elevation) * math.sin(angle) for angle in angles),
        (math.sin(elevation),) * count,
    )
