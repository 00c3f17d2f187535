"""Reaching laws: the demanded derivative of the sliding variable."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ftac_gym.baselines.components.surfaces import signed_power
from ftac_gym.utils.parameters import FloatArray, finite, non_negative, require, within


def switching(variable: FloatArray, layer: float | FloatArray) -> FloatArray:
    """Return sign(s), or tanh(s / layer) if there is a boundary layer.

    The papers print the sign. Sampled, it chatters with an amplitude in proportion to the sampling time; a layer of
    about the switching gain times that time removes the chatter. A layer for each spacecraft (N, 1) is positive.
    """
    sharp = not isinstance(layer, np.ndarray) and layer == 0.0
    return np.sign(variable) if sharp else np.tanh(variable * (1.0 / layer))


def saturation(variable: FloatArray, width: float) -> FloatArray:
    """Return x / width, clipped to +-1: the saturation functions (43) and (54) of Ma et al. 2023.

    A width of zero gives the sign.
    """
    if width == 0.0:
        return np.sign(variable)
    return np.minimum(np.maximum(variable * (1.0 / width), -1.0), 1.0)


def soft_sign(variable: FloatArray, width: FloatArray) -> FloatArray:
    """Return x / (``|x|`` + width), within +-1: the bounded feedback (18) of Ma et al. 2023."""
    return variable / (np.abs(variable) + width)


@dataclass(frozen=True)
class ExponentialReaching:
    """s' = -e1 s - e2 / N(s) sign(s) with N(s) = d0 + (1 - d0) exp(-alpha ``|s|^p0``), axis by axis.

    Eqs. (35) and (66) of Zhang and Zhou 2019: the switching gain grows from e2 near the surface to e2 / d0 far from it.

    Parameters
    ----------
    linear
        e1 [1/s].
    switching
        e2 [rad/s^2].
    floor
        d0, within (0, 1).
    steepness
        alpha [(s/rad)^p0].
    power
        p0, a positive integer.
    layer
        Boundary layer of the sign [rad/s]; zero for none.

    Raises
    ------
    ValueError
        If a value breaks a rule.
    """

    linear: float
    switching: float
    floor: float = 0.5
    steepness: float = 5.0
    power: int = 1
    layer: float = 0.0

    def __post_init__(self) -> None:
        """Check the fields."""
        for name in ("linear", "switching", "steepness", "layer"):
            non_negative(getattr(self, name), name)
        within(self.floor, 0.0, 1.0, "floor")
        power = finite(self.power, "power")
        require(power >= 1.0 and power.is_integer(), "power", "must be a positive integer", self.power)

    def __call__(self, variable: FloatArray) -> FloatArray:
        """Return the designed s' [rad/s^2] for s (N, 3) [rad/s]."""
        return self.scheduled(variable, self.linear, self.switching, self.layer)

    def scheduled(
        self,
        variable: FloatArray,
        linear: float | FloatArray,
        gain: float | FloatArray,
        layer: float | FloatArray,
    ) -> FloatArray:
        """Return the same with another e1, e2 and layer, numbers or columns (N, 1)."""
        distance = np.abs(variable)
        if self.power != 1:
            distance = distance**self.power
        share = self.floor + (1.0 - self.floor) * np.exp(-self.steepness * distance)
        return -linear * variable - gain / share * switching(variable, layer)


@dataclass(frozen=True)
class PowerReaching:
    """s' = -k s - l sig(s)^a: finite-time reaching without a sign, per unit of acceleration or of torque.

    Parameters
    ----------
    linear
        k [1/s].
    power_gain
        l [(rad/s)^(1-a) / s]; zero leaves the power out.
    exponent
        a, within (0, 1).

    Raises
    ------
    ValueError
        If a value breaks a rule.
    """

    linear: float
    power_gain: float
    exponent: float

    def __post_init__(self) -> None:
        """Check the fields."""
        non_negative(self.linear, "linear")
        non_negative(self.power_gain, "power_gain")
        within(self.exponent, 0.0, 1.0, "exponent")

    def __call__(self, variable: FloatArray) -> FloatArray:
        """Return the designed s' [rad/s^2] for s (N, 3) [rad/s]."""
        rate: FloatArray = -self.linear * variable
        if self.power_gain > 0.0:
            rate -= self.power_gain * signed_power(variable, self.exponent)
        return rate
