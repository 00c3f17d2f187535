"""A small catalogue of real reaction wheels, with the sources of their numbers.

What no source gives is left off (None) rather than guessed; the breakaway speed of friction is the default of
:class:`~ftac_gym.spacecraft.friction.Friction`, and the spin inertia follows from momentum and speed.
"""

import math
from dataclasses import dataclass

from ftac_gym.spacecraft.friction import Friction
from ftac_gym.spacecraft.wheel_array import WheelArray
from ftac_gym.utils.parameters import Matrix, require

RPM = 2.0 * math.pi / 60.0
"""One revolution per minute [rad/s]."""


@dataclass(frozen=True)
class ReactionWheel:
    """Data of one product.

    Attributes
    ----------
    name
        Maker and model.
    torque
        Largest torque [N m].
    momentum
        Momentum at the largest speed [N m s].
    speed
        Largest speed [rad/s].
    source
        Where the numbers are from.
    coulomb
        Coulomb friction [N m]; None if unknown.
    least_torque
        Smallest torque [N m]; None if unknown.
    power
        Largest power [W]; None if unknown.
    """

    name: str
    torque: float
    momentum: float
    speed: float
    source: str
    coulomb: float | None = None
    least_torque: float | None = None
    power: float | None = None

    @property
    def spin_inertia(self) -> float:
        """Inertia about the spin axis [kg m^2]."""
        return self.momentum / self.speed

    def array(self, axes: Matrix, lag: float | None = None, power_limit: float | None = None) -> WheelArray:
        """Return an array of these wheels.

        Parameters
        ----------
        axes
            The matrix D, 3 x m; see :mod:`ftac_gym.spacecraft.layouts`.
        lag
            Time constant of the motors [s]; makers do not publish it.
        power_limit
            Power limit [W] where the catalogue has none.
        """
        return WheelArray(
            axes,
            torque_limit=self.torque,
            momentum_limit=self.momentum,
            spin_inertia=self.spin_inertia,
            speed_limit=self.speed,
            friction=None if self.coulomb is None else Friction(self.coulomb),
            lag=lag,
            dead_band=self.least_torque,
            power_limit=power_limit if self.power is None else self.power,
        )


_BASILISK = "Basilisk, simIncludeRW.py, after the maker's data sheet"
_HONEYWELL = f"{_BASILISK} (Honeywell Constellation series)"


def _honeywell(model: str, momentum: float) -> ReactionWheel:
    return ReactionWheel(
        f"Honeywell {model}", 0.2, momentum, 6000.0 * RPM, _HONEYWELL, coulomb=5e-4, least_torque=1e-5
    )  # fmt: skip


_WHEELS: dict[str, ReactionWheel] = {
    "rwp015": ReactionWheel(
        "Blue Canyon RWP015", 0.004, 0.015, 6000.0 * RPM, f"{_BASILISK}; friction as for its cubesat wheels",
        coulomb=5e-5,
    ),
    "rw0": ReactionWheel("NanoAvionics RW0", 0.0032, 0.020, 6500.0 * RPM, _BASILISK),
    "rwp500": ReactionWheel(
        "Blue Canyon RWP500", 0.025, 0.5, 6000.0 * RPM, "two public repositories; the speed is that of its family",
        power=6.0,
    ),
    "hr12-12": _honeywell("HR12", 12.0),
    "hr12-25": _honeywell("HR12", 25.0),
    "hr12-50": _honeywell("HR12", 50.0),
    "hr14-75": _honeywell("HR14", 75.0),
    "hr16-100": _honeywell("HR16", 100.0),
}  # fmt: skip


def names() -> list[str]:
    """Return the names of all wheels."""
    return sorted(_WHEELS)


def get(name: str) -> ReactionWheel:
    """Return a wheel by name.

    Raises
    ------
    ValueError
        If the name is unknown; the message lists the known ones.
    """
    require(isinstance(name, str) and name in _WHEELS, "wheel", f"must be one of {names()}", name)
    return _WHEELS[name]
