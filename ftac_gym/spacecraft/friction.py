"""Bearing friction of a reaction wheel."""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ftac_gym.utils.parameters import FloatArray, non_negative, normalise, positive, require
from ftac_gym.utils.serialization import serializable


@serializable
@dataclass(frozen=True)
class Friction:
    """Stribeck, Coulomb and viscous friction, smooth through rest.

    The drag torque on a wheel that spins at W against the body is, with W_st = sqrt(2) W_brk and W_c = W_brk / 10::

        T(W) = sqrt(2 e) (T_brk - T_C) exp(-(W / W_st)^2) W / W_st + T_C tanh(W / W_c) + f W

    (the form of MathWorks' rotational friction block). It rises to the breakaway torque T_brk near the breakaway speed
    W_brk, falls to the Coulomb torque T_C, and grows with the viscous coefficient f. Its power T W is never negative.

    Parameters
    ----------
    coulomb
        T_C [N m].
    breakaway
        T_brk [N m], at least T_C; None for T_C.
    breakaway_speed
        W_brk [rad/s].
    viscous
        f [N m s/rad].

    Raises
    ------
    ValueError
        If a value is negative, the breakaway speed is zero, or the breakaway torque is below the Coulomb torque.
    """

    coulomb: float = 0.0
    breakaway: float | None = None
    breakaway_speed: float = 0.1
    viscous: float = 0.0

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        normalise(self, non_negative, "coulomb", "viscous")
        normalise(self, positive, "breakaway_speed")
        breakaway = self.coulomb if self.breakaway is None else non_negative(self.breakaway, "breakaway")
        require(breakaway >= self.coulomb, "breakaway", f"must not be below coulomb = {self.coulomb!r}", breakaway)
        object.__setattr__(self, "breakaway", breakaway)

    @property
    def stribeck(self) -> float:
        """Amplitude sqrt(2 e) (T_brk - T_C) of the Stribeck part [N m]."""
        return math.sqrt(2.0 * math.e) * ((self.breakaway or 0.0) - self.coulomb)

    @property
    def stribeck_speed(self) -> float:
        """W_st [rad/s]."""
        return math.sqrt(2.0) * self.breakaway_speed

    @property
    def coulomb_speed(self) -> float:
        """W_c [rad/s]."""
        return 0.1 * self.breakaway_speed

    def dry(self, speed: npt.ArrayLike) -> FloatArray:
        """Return the drag torque without its viscous part [N m] at speeds [rad/s], an array of their shape."""
        speed = np.asarray(speed, dtype=np.float64)
        ratio = speed / self.stribeck_speed
        return self.stribeck * ratio * np.exp(-(ratio**2)) + self.coulomb * np.tanh(speed / self.coulomb_speed)

    def torque(self, speed: npt.ArrayLike) -> FloatArray:
        """Return the drag torque [N m] at speeds [rad/s], an array of their shape; it has the sign of the speed."""
        return self.dry(speed) + self.viscous * np.asarray(speed, dtype=np.float64)
