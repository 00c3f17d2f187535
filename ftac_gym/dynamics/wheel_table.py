"""Wheel array as the compiled plant reads it: every constant of a physics step, computed beforehand."""

import math

import numpy as np
import numpy.typing as npt

from ftac_gym.spacecraft.wheel_array import WheelArray
from ftac_gym.utils.parameters import FloatArray

WHEEL = np.dtype(
    [
        ("axis", "f8", (3,)),
        ("torque_limit", "f8"),
        ("momentum_limit", "f8"),
        ("dead_band", "f8"),
        ("power_limit", "f8"),
        ("ideal", "f8"),
        ("inverse_inertia", "f8"),
        ("coulomb", "f8"),
        ("inverse_coulomb_speed", "f8"),
        ("stribeck", "f8"),
        ("inverse_stribeck_speed", "f8"),
        ("viscous", "f8"),
        ("coulomb_momentum", "f8"),
        ("linear_momentum", "f8"),
        ("keep", "f8"),
        ("forcing", "f8", (3,)),
        ("lag_forcing", "f8", (3,)),
        ("lag_left", "f8", (3,)),
    ]
)
"""Constants of one wheel.

========================= =============================================================================================
``axis``                  unit vector in body axes
``torque_limit``, ...     limits [N m, N m s, N m, W]
``ideal``                 1.0 if none of dead-band, power limit, friction and lag is on
``coulomb``, ...          friction as in :class:`~ftac_gym.spacecraft.friction.Friction`, speeds inverted [SI units]
``coulomb_momentum``      momentum at which the Coulomb torque sets in [N m s]; infinite without friction
``linear_momentum``       momentum beyond which friction is Coulomb plus viscous to 1e-12 [N m s]; negative without dry
                          friction
``keep``                  share of the momentum that viscous friction leaves after a step
``forcing``               weights [s] of the forcing at the start, the middle and the end of a step
``lag_forcing``           the same for a forcing times the exponential of the lag
``lag_left``              remaining share of the lag at the two inner stages and at the end of a step
========================= =============================================================================================
"""

STIFF_GAMMA = 0.43586652150845899942
"""Diagonal of the third-order, L-stable singly diagonally implicit Runge-Kutta method of Alexander (SIAM J. Numer.
Anal. 14(6), 1977); a root of x^3 - 3 x^2 + 3/2 x - 1/6."""

_LINEAR_RATIO = 5.3
"""Beyond this ratio of speed to Stribeck speed, exp(-ratio^2) is below 1e-12."""


def wheel_table(wheels: WheelArray, step: float) -> npt.NDArray[np.void]:
    """Return the WHEEL records (m,) of a wheel array for a physics step [s]."""
    table = np.zeros(wheels.count, WHEEL)
    table["axis"] = wheels.axis_matrix.T
    table["torque_limit"] = wheels.torque_limits
    table["momentum_limit"] = wheels.momentum_limits
    table["dead_band"] = wheels.dead_bands
    table["power_limit"] = wheels.power_limits
    table["inverse_inertia"] = 1.0 / wheels.spin_inertias
    table["coulomb_momentum"] = np.inf
    table["linear_momentum"] = -1.0
    for wheel, friction in enumerate(wheels.frictions):
        if friction is None:
            continue
        record = table[wheel]
        record["coulomb"] = friction.coulomb
        record["inverse_coulomb_speed"] = 1.0 / friction.coulomb_speed
        record["coulomb_momentum"] = friction.coulomb_speed * wheels.spin_inertias[wheel]
        record["stribeck"] = friction.stribeck
        record["inverse_stribeck_speed"] = 1.0 / friction.stribeck_speed
        record["viscous"] = friction.viscous
        if friction.coulomb > 0.0 or friction.stribeck > 0.0:
            record["linear_momentum"] = _LINEAR_RATIO * friction.stribeck_speed * wheels.spin_inertias[wheel]
    for wheel, lag in enumerate(wheels.lags):
        record = table[wheel]
        decay = float(record["viscous"] * record["inverse_inertia"])
        record["keep"] = math.exp(-decay * step)
        record["forcing"] = _weights(step, decay, 0.0)
        if lag > 0.0:
            record["lag_forcing"] = _weights(step, decay, 1.0 / lag)
            stages = np.array([STIFF_GAMMA, 0.5 * (1.0 + STIFF_GAMMA), 1.0])
            record["lag_left"] = np.exp(-stages * step / lag)
    plain = (wheels.lags == 0.0) & (wheels.dead_bands == 0.0) & np.isinf(wheels.power_limits)
    table["ideal"] = plain & np.array([friction is None for friction in wheels.frictions])
    return table


def _weights(step: float, decay: float, lag_rate: float) -> FloatArray:
    """Return the weights of a forcing at the start, the middle and the end of a step.

    They integrate p(t) exp(-lag_rate t) exp(-decay (step - t)) over the step, exactly for every quadratic p: Simpson's
    rule if both rates are zero.
    """
    # In units of the step, the product of the exponentials is exp(-slower) exp(-rate y).
    # With y counted from the end where the second one is 1, no factor can overflow.
    slower, rate = min(lag_rate, decay) * step, abs(lag_rate - decay) * step
    if rate < 20.0:
        nodes, weights = np.polynomial.legendre.leggauss(40)
        y = 0.5 * (nodes + 1.0)
        moments = np.array([0.5 * np.sum(weights * y**power * np.exp(-rate * y)) for power in range(3)])
    else:  # The recursion loses digits where the rate is small, and the quadrature where it is large.
        last = math.exp(-rate)
        first = (1.0 - last) / rate
        second = (first - last) / rate
        moments = np.array([first, second, (2.0 * second - last) / rate])
    # Lagrange polynomials of the points 0, 1/2, 1 by powers of y.
    shapes = np.array([[1.0, -3.0, 2.0], [0.0, 4.0, -4.0], [0.0, -1.0, 2.0]])
    weights = step * math.exp(-slower) * (shapes @ moments)
    return weights if lag_rate >= decay else weights[::-1]
