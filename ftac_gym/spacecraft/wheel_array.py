"""Nominal parameters of the reaction wheels: ideal torquers by default, real ones on request."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ftac_gym.spacecraft.friction import Friction
from ftac_gym.spacecraft.layouts import sign_pyramid
from ftac_gym.utils.parameters import (
    FloatArray,
    Matrix,
    Vector,
    each,
    flag,
    matrix,
    normalise,
    optional,
    positive,
    require,
    rows,
)
from ftac_gym.utils.serialization import serializable

_LIMITS = ("torque_limit", "momentum_limit", "spin_inertia", "speed_limit", "lag", "dead_band", "power_limit")
"""Fields with one positive number for all wheels, one per wheel, or None for an effect that is off."""


@serializable
@dataclass(frozen=True)
class WheelArray:
    """Reaction wheels: their axes, limits and losses.

    A commanded torque passes, in this order, the torque limit, the dead-band, the lag, the effectiveness and the bias
    of a fault, and the power limit. Friction and the momentum limit then act on the wheel itself. Every effect is off
    unless it is given, and each can differ from wheel to wheel. The speed of a wheel is its momentum over its spin
    inertia; the body's own rate is left out of it, being thousands of times smaller.

    Parameters
    ----------
    axes
        The matrix D, 3 x m: column j is the unit axis of wheel j in body axes. A torque tau_j turns the body along
        D[:, j] and takes as much momentum from the wheel.
    torque_limit
        Largest commanded torque of each wheel [N m]; a number for all wheels; None for unlimited.
    momentum_limit
        Largest momentum of each wheel [N m s]; a number for all wheels; None for unlimited. At the limit only torque
        that would accelerate the wheel further is blocked.
    momentum_coupling
        Whether the stored momentum enters the gyroscopic torque. False models ideal torquers, as the papers do.
    spin_inertia
        Inertia of each wheel about its axis [kg m^2]; friction, speed limit and power limit need it.
    speed_limit
        Largest speed of each wheel [rad/s], which limits the momentum too; None for unlimited.
    friction
        Bearing friction: one for all wheels, or one per wheel (None among them for none); None for no friction.
    lag
        Time constant of the first-order lag between command and motor torque [s].
    dead_band
        Commands smaller than this give no torque [N m].
    power_limit
        Largest mechanical power ``|tau W|`` of the motor of each wheel [W].

    Raises
    ------
    ValueError
        If D is not 3 x m with m >= 1 and unit columns, or a value is not positive. Also if an effect lacks the spin
        inertia that it needs.
    """

    axes: Matrix
    torque_limit: Vector | float | None
    momentum_limit: Vector | float | None = None
    momentum_coupling: bool = True
    spin_inertia: Vector | float | None = None
    speed_limit: Vector | float | None = None
    friction: Friction | tuple[Friction | None, ...] | None = None
    lag: Vector | float | None = None
    dead_band: Vector | float | None = None
    power_limit: Vector | float | None = None

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        axes = matrix(self.axes, 3, None, "axes")
        norms = np.linalg.norm(axes, axis=0)
        require(bool(np.all(np.abs(norms - 1.0) < 1e-6)), "axes", "must have columns of unit length", norms.tolist())
        count = axes.shape[1]
        object.__setattr__(self, "axes", rows(axes))
        normalise(self, flag, "momentum_coupling")
        normalise(self, optional(lambda values, name: each(values, count, name, positive)), *_LIMITS)
        if isinstance(self.friction, (tuple, list)):
            given = len(self.friction)
            require(given == count, "friction", f"must have {count} entries, one per wheel", given)
            for wheel, entry in enumerate(self.friction):
                valid = isinstance(entry, Friction | None)
                require(valid, f"friction[{wheel}]", "must be a Friction or None", entry)
            object.__setattr__(self, "friction", tuple(self.friction))
        elif self.friction is not None:
            valid = isinstance(self.friction, Friction)
            require(valid, "friction", "must be a Friction, one per wheel, or None", self.friction)
            object.__setattr__(self, "friction", (self.friction,) * count)
        if self.spin_inertia is None:
            for name in ("speed_limit", "friction", "power_limit"):
                require(getattr(self, name) is None, name, "needs spin_inertia: it depends on the speed", None)

    @property
    def count(self) -> int:
        """Number of wheels m."""
        return len(self.axes[0])

    @property
    def axis_matrix(self) -> FloatArray:
        """The matrix D, array (3, m)."""
        return np.array(self.axes)

    @property
    def torque_limits(self) -> FloatArray:
        """Torque limits [N m], array (m,), infinite where unlimited."""
        return self._array("torque_limit", np.inf)

    @property
    def spin_inertias(self) -> FloatArray:
        """Spin inertias [kg m^2], array (m,), infinite where not given: such a wheel has no speed."""
        return self._array("spin_inertia", np.inf)

    @property
    def momentum_limits(self) -> FloatArray:
        """Momentum limits [N m s], array (m,), from the momentum and the speed limit; infinite where unlimited."""
        limits = self._array("momentum_limit", np.inf)
        if self.speed_limit is None:
            return limits
        return np.minimum(limits, self.spin_inertias * self._array("speed_limit", np.inf))

    @property
    def lags(self) -> FloatArray:
        """Time constants of the motors [s], array (m,), zero where there is no lag."""
        return self._array("lag", 0.0)

    @property
    def dead_bands(self) -> FloatArray:
        """Dead-bands [N m], array (m,), zero where there is none."""
        return self._array("dead_band", 0.0)

    @property
    def power_limits(self) -> FloatArray:
        """Power limits [W], array (m,), infinite where unlimited."""
        return self._array("power_limit", np.inf)

    @property
    def frictions(self) -> tuple[Friction | None, ...]:
        """Friction of each wheel, None where there is none."""
        return self.friction if isinstance(self.friction, tuple) else (None,) * self.count

    def _array(self, name: str, default: float) -> FloatArray:
        values = getattr(self, name)
        return np.full(self.count, default) if values is None else np.array(values)

    @classmethod
    def sign_pyramid(cls, torque_limit: float, momentum_limit: float | None, coupling: bool = True) -> WheelArray:
        """Four wheels along (+-1, +-1, 1)/sqrt 3: the layout with the largest torque envelope after one loss."""
        return cls(sign_pyramid(), torque_limit, momentum_limit, coupling)
