"""Input shaping: motions of a hub that leave its appendages at rest.

A mode of a hub with a given motion has the equation eta'' + 2 zeta f eta' + f^2 eta = -delta w', with the cantilever
frequency f. It is linear in w': a motion split into parts with suitable delays leaves vibrations that cancel.

Source: Singer and Seering, Preshaping Command Inputs to Reduce System Vibration, ASME J. Dyn. Syst. Meas. Control 112,
1990, pp. 76-82.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ftac_gym.spacecraft.appendages import FlexibleAppendages
from ftac_gym.utils.parameters import FloatArray, Vector, non_negative, positive, require, vector, whole


@dataclass(frozen=True)
class InputShaper:
    """Impulses that a motion is convolved with: the sum of its copies, delayed and scaled.

    Parameters
    ----------
    times
        Delays (p) [s], not negative, in rising order.
    amplitudes
        (p) [-]; they sum to 1, so that the end of the motion is unchanged.

    Raises
    ------
    ValueError
        If there is no impulse, a time is negative or out of order, or the amplitudes are not as many or do not sum
        to 1.
    """

    times: Vector = (0.0,)
    amplitudes: Vector = (1.0,)

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        given = np.shape(self.times)
        require(len(given) == 1 and given[0] >= 1, "times", "must have one number per impulse", self.times)
        times = vector(self.times, given[0], "times")
        amplitudes = vector(self.amplitudes, given[0], "amplitudes")
        require(times[0] >= 0.0, "times", "must not be negative", self.times)
        require(all(np.diff(times) >= 0.0), "times", "must be in rising order", self.times)
        require(abs(math.fsum(amplitudes) - 1.0) < 1e-9, "amplitudes", "must sum to 1", self.amplitudes)
        object.__setattr__(self, "times", times)
        object.__setattr__(self, "amplitudes", amplitudes)

    @property
    def delay(self) -> float:
        """Additional duration of a shaped motion: the time of the last impulse [s]."""
        return self.times[-1]

    @property
    def mean_delay(self) -> float:
        """Lag of a shaped motion at constant rate: the mean of the times [s]."""
        return math.fsum(time * amplitude for time, amplitude in zip(self.times, self.amplitudes, strict=True))

    def residual(self, frequency: float, damping_ratio: float = 0.0) -> float:
        """Return the vibration after the last impulse, as a share of that after one impulse at that time.

        V = exp(-zeta f t_p) sqrt(c^2 + s^2), with c + i s the sum of A_j exp(zeta f t_j) exp(i f_d t_j) and
        f_d = f sqrt(1 - zeta^2) (Singer and Seering 1990).

        Parameters
        ----------
        frequency
            f [rad/s], undamped.
        damping_ratio
            zeta [-], below 1.

        Raises
        ------
        ValueError
            If the frequency is not positive or the damping ratio lies outside [0, 1).
        """
        frequency, damping_ratio = _mode(frequency, damping_ratio)
        damped, decay = frequency * math.sqrt(1.0 - damping_ratio**2), damping_ratio * frequency
        # Both exponentials in one, so that none overflows.
        exponent = (decay + 1j * damped) * (np.array(self.times) - self.delay)
        return float(abs(np.array(self.amplitudes) @ np.exp(exponent)))

    def ramp(self, time: FloatArray) -> FloatArray:
        """Return the shaped unit ramp, sum of A_j max(t - t_j, 0), for any times [s]; same shape."""
        return self.ramp_and_parabola(time)[0]

    def ramp_and_parabola(self, time: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the shaped unit ramp and its integral, sum of A_j max(t - t_j, 0)^2 / 2 [s^2]; same shape."""
        times, *moments = self._moments
        begun = times.searchsorted(time, side="right")
        total, first, second = (moment[begun] for moment in moments)
        ramp = total * time - first
        return ramp, 0.5 * ((ramp - first) * time + second)

    @cached_property
    def _moments(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Times (p,), and sums of A_j, A_j t_j and A_j t_j^2 over the first impulses, none to all (p + 1,)."""
        times = np.array(self.times)
        zeroth, first, second = (np.cumsum([0.0, *(self.amplitudes * times**power)]) for power in range(3))
        return times, zeroth, first, second


def zero_vibration(frequency: float, damping_ratio: float = 0.0, order: int = 1) -> InputShaper:
    """Return the shaper that leaves no vibration of one mode.

    Parameters
    ----------
    frequency
        f [rad/s], undamped; the cantilever frequency of a mode of a hub with a given motion.
    damping_ratio
        zeta [-], below 1.
    order
        1 for two impulses half a period apart (ZV), 2 for these convolved with themselves (ZVD), and so on. The
        derivatives of the vibration with respect to the frequency vanish below this order.

    Raises
    ------
    ValueError
        If the frequency is not positive, the damping ratio lies outside [0, 1), or the order is below 1.
    """
    frequency, damping_ratio = _mode(frequency, damping_ratio)
    order = whole(order, 1, "order")
    root = math.sqrt(1.0 - damping_ratio**2)
    half_period, decay = math.pi / (frequency * root), math.exp(-math.pi * damping_ratio / root)
    weights = [math.comb(order, impulse) * decay**impulse / (1.0 + decay) ** order for impulse in range(order + 1)]
    return InputShaper(tuple(half_period * impulse for impulse in range(order + 1)), tuple(weights))


def convolved(*shapers: InputShaper) -> InputShaper:
    """Return the convolution of shapers; of none, one impulse at time zero.

    Its number of impulses is the product of theirs, and its delay the sum. The share of the vibration of a mode that
    remains is the product of their shares.
    """
    times, amplitudes = np.zeros(1), np.ones(1)
    for shaper in shapers:
        times = np.add.outer(times, shaper.times).ravel()
        amplitudes = np.multiply.outer(amplitudes, shaper.amplitudes).ravel()
    order = np.argsort(times, kind="stable")
    return InputShaper(tuple(times[order].tolist()), tuple(amplitudes[order].tolist()))


def shaper_of(appendages: FlexibleAppendages | None, order: int = 1, modes: int | None = None) -> InputShaper:
    """Return the shaper for the clamped modes of a spacecraft.

    Parameters
    ----------
    appendages
        The appendages; None for a rigid body, whose shaper is one impulse at time zero.
    order
        Order of each mode's shaper.
    modes
        Number of modes to shape for, lowest frequency first; None for all. Equal modes share a shaper.

    Raises
    ------
    ValueError
        If the order is below 1, the number of modes is below 0, or a mode is not underdamped.
    """
    whole(order, 1, "order")
    if modes is not None:
        whole(modes, 0, "shaped_modes")
    if appendages is None:
        return InputShaper()
    known = appendages.count
    require(modes is None or modes <= known, "shaped_modes", f"must be at most {known}, the number of modes", modes)
    ratios = np.broadcast_to(appendages.damping_ratios, appendages.count).tolist()
    lowest = sorted(zip(appendages.frequencies, ratios, strict=True))[:modes]
    return convolved(*(zero_vibration(frequency, ratio, order) for frequency, ratio in dict.fromkeys(lowest)))


@dataclass(frozen=True, eq=False)
class RestToRest:
    """Turns of N spacecraft about an axis, from rest to rest: full acceleration, coast where needed, full deceleration.

    Attributes
    ----------
    acceleration
        (N,) size of the acceleration [rad/s^2].
    switches
        (N, 4) times at which it goes up, down, down, and up again by that much [s]; the first is 0.
    """

    acceleration: FloatArray
    switches: FloatArray

    @property
    def duration(self) -> FloatArray:
        """(N,) time that a turn takes without a shaper [s]."""
        return self.switches[:, 3]

    def motion(self, time: FloatArray, shaper: InputShaper | None = None) -> tuple[FloatArray, FloatArray]:
        """Return angles [rad] and rates [rad/s], each (N,), at times (N,) [s], of the shaped turns or the plain ones.

        The acceleration is constant between switches (and impulses), so that rates give its mean over a period exactly.
        """
        since = np.asarray(time)[:, None] - self.switches
        ramp, parabola = (shaper or InputShaper()).ramp_and_parabola(since)
        return self.acceleration * (parabola @ SIGNS), self.acceleration * (ramp @ SIGNS)


SIGNS: FloatArray = np.array([1.0, -1.0, -1.0, 1.0])
"""Signs of the four steps of the acceleration of a turn from rest to rest."""


def rest_to_rest(angle: FloatArray, acceleration: FloatArray, rate_limit: float) -> RestToRest:
    """Return the quickest turns from rest to rest.

    Parameters
    ----------
    angle
        (N,) angles [rad], not negative.
    acceleration
        (N,) limits of the acceleration [rad/s^2], positive.
    rate_limit
        Limit of the rate [rad/s].

    Raises
    ------
    ValueError
        If the rate limit is not positive.
    """
    rate_limit = positive(rate_limit, "rate_limit")
    rise = np.minimum(np.sqrt(angle / acceleration), rate_limit / acceleration)
    # A zero angle takes no time, although the quotient is undefined.
    fall = angle / np.maximum(acceleration * rise, np.finfo(np.float64).tiny)
    fall = np.maximum(fall, rise)
    return RestToRest(acceleration, np.stack((np.zeros_like(rise), rise, fall, fall + rise), axis=1))


def _mode(frequency: float, damping_ratio: float) -> tuple[float, float]:
    frequency, damping_ratio = positive(frequency, "frequency"), non_negative(damping_ratio, "damping_ratio")
    require(damping_ratio < 1.0, "damping_ratio", "must be below 1", damping_ratio)
    return frequency, damping_ratio
