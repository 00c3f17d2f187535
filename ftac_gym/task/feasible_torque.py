"""Compiled torques of faulty wheels in a step of a coarse grid of times: their bounds, and how they share a sum."""

import math
from typing import Any

import numpy as np

from ftac_gym.faults.signals import acts, bias_at, effectiveness_at, part_at
from ftac_gym.utils import algebra
from ftac_gym.utils.compiling import called, merged

CAPACITY = np.dtype(
    [
        (name, "f8")
        for name in ("torque_limit", "momentum_limit", "inverse_inertia", "power_limit", "coulomb", "viscous")
    ]
)
"""One wheel: limits [N m, N m s], inverse spin inertia [1/(kg m^2)], power limit [W], dry [N m] and viscous friction
[N m s/rad]; the limits are finite."""

DAMPING = 1e-7
"""Weight of the torques against the error of their sum, which keeps them defined for wheels that span no space."""

SIGNALS = 6
"""Numbers that tell the state of a wheel: effectiveness, bias [N m], 1.0 if locked, factors on the dry friction forward
and backward, brake [N m]. A locked wheel has no effectiveness, and a torque as bias."""

# Merged as machine code: inlined as statements, they would take twice as long to compile.
add3, cross3, quaternion_product, rotation_change, row3, symmetric_times = (
    merged(getattr(function, "py_func", function))
    for function in (
        algebra.add3,
        algebra.cross3,
        algebra.quaternion_product,
        algebra.rotation_change,
        algebra.row3,
        algebra.symmetric_times,
    )
)


@merged
def dot3(a: Any, b: Any) -> float:
    """Return a.b for triples."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@merged
def scaled3(factor: float, a: Any) -> Any:
    """Return factor a."""
    return factor * a[0], factor * a[1], factor * a[2]


@merged
def inverse_symmetric(a: Any) -> Any:
    """Return the inverse of a symmetric matrix (xx, yy, zz, xy, xz, yz), in the same order."""
    minor_x, minor_y, minor_z = a[1] * a[2] - a[5] * a[5], a[4] * a[5] - a[3] * a[2], a[3] * a[5] - a[4] * a[1]
    scale = 1.0 / (a[0] * minor_x + a[3] * minor_y + a[4] * minor_z)
    return (
        scale * minor_x,
        scale * (a[0] * a[2] - a[4] * a[4]),
        scale * (a[0] * a[1] - a[3] * a[3]),
        scale * minor_y,
        scale * minor_z,
        scale * (a[3] * a[4] - a[0] * a[5]),
    )


@called
def load_signals(i: int, faults: Any, switches: Any, step: float, signals: Any) -> None:
    """Write the state of each wheel of spacecraft i in the middle of each step [s], (steps, m, SIGNALS)."""
    for j in range(signals.shape[1]):
        first, last = np.inf, 0.0
        for layer in range(faults.shape[2]):
            if faults[i, j, layer].kind > 0:
                first = min(first, faults[i, j, layer].onset)
                last = max(last, faults[i, j, layer].recovery)
        for k in range(signals.shape[0]):
            time = (k + 0.5) * step
            effectiveness, bias, locked, forward, backward, brake = 1.0, 0.0, 0.0, 1.0, 1.0, 0.0
            if first <= time < last:
                for layer in range(faults.shape[2]):
                    fault = faults[i, j, layer]
                    if fault.kind > 0 and acts(fault, switches, i, time):
                        part = part_at(fault, time)
                        effectiveness *= effectiveness_at(fault, part, time)
                        bias += bias_at(fault, part, max(time - fault.onset, 0.0))
                        locked = max(locked, fault.locked)
                        forward *= 1.0 + part * (fault.friction_forward - 1.0)
                        backward *= 1.0 + part * (fault.friction_backward - 1.0)
                        brake += fault.brake
            if locked > 0.5:
                effectiveness, bias = 0.0, 0.0
            signals[k, j, 0], signals[k, j, 1], signals[k, j, 2] = effectiveness, bias, locked
            signals[k, j, 3], signals[k, j, 4], signals[k, j, 5] = forward, backward, brake


@called
def bounds(signals: Any, capacity: Any, momentum: Any, step: float, braked: bool, low: Any, high: Any) -> None:
    """Write the least and the largest mean torque of each wheel over a step, (m,) [N m].

    A wheel that follows no command has one torque, its bias.

    Parameters
    ----------
    signals, capacity
        State of the wheels (m, SIGNALS) and CAPACITY records (m,).
    momentum
        (m,) momentum of the wheels at the start of the step [N m s].
    step
        Length of the step [s].
    braked
        True for the torque of a seizing wheel's brake, False for that of a wheel that it has stopped: none.
    """
    for j in range(capacity.shape[0]):
        wheel, h = capacity[j], momentum[j]
        size, sign = abs(h), math.copysign(1.0, h)
        if signals[j, 5] > 0.0:
            low[j] = sign * min(signals[j, 5], size / step) if braked else 0.0
            high[j] = low[j]
            continue
        most = abs(signals[j, 0]) * wheel.torque_limit
        least, largest = signals[j, 1] - most, signals[j, 1] + most
        speed = size * wheel.inverse_inertia
        if speed > 0.0:
            strongest = wheel.power_limit / speed
            least, largest = min(max(least, -strongest), strongest), min(max(largest, -strongest), strongest)
            dry = wheel.coulomb * (signals[j, 3] if h > 0.0 else signals[j, 4])
            drag = sign * min(dry + wheel.viscous * speed, size / step)
            least, largest = least + drag, largest + drag
        # A wheel at its momentum limit gives no torque that would accelerate it further.
        bottom, top = (h - wheel.momentum_limit) / step, (h + wheel.momentum_limit) / step
        low[j], high[j] = min(max(least, bottom), top), max(min(largest, top), bottom)


@called
def multiple(normals: Any, across: Any, base: Any, torque: Any, low: Any, high: Any, reached: bool) -> float:
    """Return how many times a torque fits beside another one into the envelope of torques between two bounds.

    Parameters
    ----------
    normals, across
        (facets, 3) normals of the envelope, and (facets, m) their products with the wheel axes.
    base, torque
        The other torque and the torque [N m], body axes.
    low, high
        (m,) bounds [N m].
    reached
        True to leave out directions in which the wheels give no torque; otherwise no multiple fits there.
    """
    times = np.inf
    for facet in range(normals.shape[0]):
        normal = (normals[facet, 0], normals[facet, 1], normals[facet, 2])
        needed = dot3(normal, torque)
        sign = 1.0 if needed >= 0.0 else -1.0
        most, width = 0.0, 0.0
        for j in range(low.shape[0]):
            along = sign * across[facet, j]
            most += along * (high[j] if along > 0.0 else low[j])
            width += abs(along) * (high[j] - low[j])
        needed = abs(needed)
        if needed > 1e-12 and (width > 1e-9 or not reached):
            times = min(times, max(most - sign * dot3(normal, base), 0.0) / needed)
    return times


@called
def share(axes: Any, wanted: Any, low: Any, high: Any, torque: Any, fixed: Any) -> Any:
    """Write torques between two bounds (m,) [N m] whose sum is nearest to the one wanted, and return the sum.

    Of those they are near the given ones. The method is active-set: the wheel that would go farthest beyond its bounds
    stays at them, and the others share its part.

    Parameters
    ----------
    axes
        (m, 3) wheel axes.
    wanted
        Sum [N m], body axes.
    low, high
        (m,) bounds [N m].
    torque
        (m,) torques to be near to [N m], in place.
    fixed
        (m,) work space.
    """
    count = axes.shape[0]
    for j in range(count):
        fixed[j] = 0.0 if high[j] - low[j] > 1e-9 else 1.0
        torque[j] = min(max(torque[j], low[j]), high[j])
    for _ in range(count):
        x, y, z = wanted
        xx, yy, zz, xy, xz, yz = DAMPING, DAMPING, DAMPING, 0.0, 0.0, 0.0
        for j in range(count):
            a, b, c = axes[j, 0], axes[j, 1], axes[j, 2]
            x, y, z = x - a * torque[j], y - b * torque[j], z - c * torque[j]
            if fixed[j] == 0.0:
                xx, yy, zz = xx + a * a, yy + b * b, zz + c * c
                xy, xz, yz = xy + a * b, xz + a * c, yz + b * c
        missing = symmetric_times(inverse_symmetric((xx, yy, zz, xy, xz, yz)), (x, y, z))
        farthest, worst = 1e-9, -1
        for j in range(count):
            if fixed[j] == 0.0:
                torque[j] += axes[j, 0] * missing[0] + axes[j, 1] * missing[1] + axes[j, 2] * missing[2]
                beyond = max(low[j] - torque[j], torque[j] - high[j])
                if beyond > farthest:
                    farthest, worst = beyond, j
        if worst < 0:
            break
        torque[worst] = min(max(torque[worst], low[worst]), high[worst])
        fixed[worst] = 1.0
    total = (0.0, 0.0, 0.0)
    for j in range(count):
        torque[j] = min(max(torque[j], low[j]), high[j])
        total = add3(total, torque[j], (axes[j, 0], axes[j, 1], axes[j, 2]))
    return total
