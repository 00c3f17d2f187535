"""Compiled evaluation of the fault tables: acting faults, the part of them that is present, and their signals.

A fault acts during a whole physics step or not at all, as decided at its start. A fault that grows or shrinks does so
linearly across the step. Within a step everything is smooth, and the integrator keeps its order.
"""

import math
from typing import Any

from ftac_gym.utils.compiling import inlined, merged

# Times closer than this are equal [s]: it absorbs rounding in t = step * period.
TIME_TOLERANCE = 1e-9


@merged
def acts(fault: Any, switches: Any, i: int, time: float) -> bool:
    """Return True if a fault of spacecraft i acts at a time [s]; ``switches`` (N, chains, FLIPS): switching times."""
    since = time - fault.onset
    if since < -TIME_TOLERANCE or time >= fault.recovery - TIME_TOLERANCE:
        return False
    if fault.period > 0.0:
        since = max(since, 0.0)
        in_period = since - math.floor((since + TIME_TOLERANCE) / fault.period) * fault.period
        if in_period >= fault.on_time - TIME_TOLERANCE:
            return False
    if fault.chain >= 0:
        flips = 0
        while flips < switches.shape[2] and switches[i, fault.chain, flips] <= time + TIME_TOLERANCE:
            flips += 1
        return flips % 2 == 0
    return True


@merged
def part_at(fault: Any, time: float) -> float:
    """Return the part of an acting fault that is present at a time [s], in [0, 1]."""
    part = 1.0
    if fault.rise > 0.0:
        part = min(max((time - fault.onset) / fault.rise, 0.0), 1.0)
    if fault.fall > 0.0:
        part = min(part, max((fault.recovery - time) / fault.fall, 0.0))
    return part


@inlined
def effectiveness_at(fault: Any, part: float, time: float) -> float:
    """Return the effectiveness under a part of an acting fault at a time of the episode [s]."""
    whole = fault.effectiveness
    if fault.effectiveness_amplitude != 0.0:
        angle = fault.effectiveness_frequency * time + fault.effectiveness_phase
        whole += fault.effectiveness_amplitude * math.sin(angle)
    return 1.0 + part * (whole - 1.0) if part < 1.0 else whole


@inlined
def bias_at(fault: Any, part: float, since: float) -> float:
    """Return the bias torque [N m] of a part of an acting fault, ``since`` seconds after its onset."""
    bias = fault.bias + fault.bias_slope * since
    if fault.bias_amplitude != 0.0:
        wave = fault.bias_amplitude * math.sin(fault.bias_frequency * since + fault.bias_phase)
        bias += wave * since**fault.bias_exponent if fault.bias_exponent != 0.0 else wave
    return part * bias


@inlined
def untouched(faults: Any, i: int, j: int, begin: float, end: float) -> bool:
    """Return True if no fault of wheel j of spacecraft i can act between two times [s]."""
    touched = False
    for layer in range(faults.shape[2]):
        touched |= faults[i, j, layer].onset < end and faults[i, j, layer].recovery > begin
    return not touched


@merged
def constant_signals(faults: Any, i: int, j: int, begin: float, end: float) -> Any:
    """Return the signals of wheel j of spacecraft i, if they are constant between two times [s].

    Returns
    -------
    Flag of constant signals, without which the others have no meaning; flag of a locked wheel; delay [control
    periods], effectiveness, bias [N m], factors on the dry friction forward and backward, and brake [N m].
    """
    locked, delay, effectiveness, bias = False, 0, 1.0, 0.0
    forward, backward, brake = 1.0, 1.0, 0.0
    constant = True
    for layer in range(faults.shape[2]):
        fault = faults[i, j, layer]
        if fault.onset >= end or fault.recovery <= begin:
            continue
        switches = fault.onset > begin or fault.recovery < end or fault.period > 0.0 or fault.chain >= 0
        grows = begin < fault.onset + fault.rise or end > fault.recovery - fault.fall
        varies = fault.effectiveness_amplitude != 0.0 or fault.bias_amplitude != 0.0 or fault.bias_slope != 0.0
        if switches or grows or varies:
            constant = False
        locked = locked or fault.locked > 0.5
        delay = max(delay, fault.delay)
        effectiveness *= fault.effectiveness
        bias += fault.bias
        forward *= fault.friction_forward
        backward *= fault.friction_backward
        brake += fault.brake
    return constant, locked, delay, effectiveness, bias, forward, backward, brake


@merged
def step_signals(faults: Any, switches: Any, i: int, j: int, time: float, step: float) -> Any:
    """Return the signals of wheel j of spacecraft i over one physics step.

    Returns
    -------
    Flag of a locked wheel; delay [control periods]; effectiveness at the start, the middle and the end; bias [N m] at
    the same times; factors on the dry friction forward and backward, and brake [N m], in the middle.
    """
    locked, delay = False, 0
    start, middle, end = 1.0, 1.0, 1.0
    bias_start, bias_middle, bias_end = 0.0, 0.0, 0.0
    forward, backward, brake = 1.0, 1.0, 0.0
    for layer in range(faults.shape[2]):
        fault = faults[i, j, layer]
        if not acts(fault, switches, i, time):
            continue
        since = max(time - fault.onset, 0.0)
        part_start, part_end = part_at(fault, time), part_at(fault, time + step)
        part_middle = 0.5 * (part_start + part_end)
        locked = locked or fault.locked > 0.5
        delay = max(delay, fault.delay)
        start *= effectiveness_at(fault, part_start, time)
        middle *= effectiveness_at(fault, part_middle, time + 0.5 * step)
        end *= effectiveness_at(fault, part_end, time + step)
        bias_start += bias_at(fault, part_start, since)
        bias_middle += bias_at(fault, part_middle, since + 0.5 * step)
        bias_end += bias_at(fault, part_end, since + step)
        forward *= 1.0 + part_middle * (fault.friction_forward - 1.0)
        backward *= 1.0 + part_middle * (fault.friction_backward - 1.0)
        brake += fault.brake
    return locked, delay, start, middle, end, bias_start, bias_middle, bias_end, forward, backward, brake
