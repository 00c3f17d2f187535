"""Faults that are added and cleared while an episode runs, for experiments by hand.

The tables that result are those of an episode that had these faults from the start: it replays.
"""

import numpy as np

from ftac_gym.faults.fault import UNIFORMS_PER_FAULT, Fault, WheelFault
from ftac_gym.faults.table import FLIPS, DrawnFaults, no_faults, no_sensor_faults
from ftac_gym.utils.parameters import FloatArray, require

SENSOR_DELAY = 1e-6
"""Time from now to a change of the sensors' faults [s]: the measurement of this moment is already taken."""


def add_fault(
    drawn: DrawnFaults,
    spacecraft: int,
    fault: Fault,
    time: float,
    torque_limits: FloatArray,
    random: np.random.Generator,
) -> DrawnFaults:
    """Return tables with one more fault of one spacecraft; those given are left as they are.

    Parameters
    ----------
    drawn
        Faults of N episodes.
    spacecraft
        Index of the affected one.
    fault
        The fault; its times count from now. A fault of a wheel must name it, and adds to the other faults of the wheel.
    time
        Now, in the time of the spacecraft's episode [s].
    torque_limits
        (m,) of the wheels [N m].
    random
        Draws the times and magnitudes that the fault leaves open.

    Raises
    ------
    ValueError
        If the fault of a wheel names none, or one that the spacecraft does not have.
    """
    uniform = random.random((1, UNIFORMS_PER_FAULT))
    layers, sensed, chains = drawn.wheels.shape[2], drawn.sensors.shape[1], drawn.switches.shape[1]
    if isinstance(fault, WheelFault):
        count, wheel = len(torque_limits), fault.wheel if fault.wheel is not None else -1
        require(0 <= wheel < count, "wheel", f"must be one of {list(range(count))}", fault.wheel)
        records = fault.draw(uniform, torque_limits[[wheel]])
        place: tuple[int, ...] = (spacecraft, wheel)
        layers += int((drawn.wheels["kind"][place] > 0).all())
    else:
        records = fault.draw(uniform, torque_limits[[0]])
        time += SENSOR_DELAY
        place = (spacecraft,)
        sensed += int((drawn.sensors["kind"][place] > 0).all())
    wider = widened(drawn.copy(), layers, sensed, chains + int(fault.random_chain))
    if fault.random_chain:
        records["chain"] = chains
        flips = fault.switching_times(records["onset"], random.random((1, FLIPS)))[0]
        wider.switches[spacecraft, chains] = time + flips
    records["onset"] += time
    records["recovery"] += time
    table = (wider.wheels if isinstance(fault, WheelFault) else wider.sensors)[place]
    table[int(np.argmin(table["kind"] > 0))] = records[0]
    return wider


def clear_faults(drawn: DrawnFaults, spacecraft: int, wheel: int | None, time: float) -> DrawnFaults:
    """Return tables in which a wheel, or the sensors, have no faults from now on.

    Parameters
    ----------
    drawn
        Faults of N episodes; left as they are.
    spacecraft
        Index of the affected one.
    wheel
        Index of its wheel; None for its sensors.
    time
        Now, in the time of the spacecraft's episode [s].
    """
    cleared = drawn.copy()
    records = cleared.sensors[spacecraft] if wheel is None else cleared.wheels[spacecraft, wheel]
    future = records["onset"] >= time
    time += SENSOR_DELAY if wheel is None else 0.0
    records["recovery"] = np.where(future, records["recovery"], np.minimum(records["recovery"], time))
    records["fall"] = np.where(future, records["fall"], 0.0)
    healthy = no_sensor_faults(1, len(records))[0] if wheel is None else no_faults(1, 1, len(records))[0, 0]
    records[future] = healthy[future]
    return cleared


def widened(drawn: DrawnFaults, layers: int, sensed: int, chains: int) -> DrawnFaults:
    """Return tables with room for at least so many faults of a wheel and of the sensors, and so many random chains."""
    wheels, sensors, switches = drawn
    spacecraft, count = wheels.shape[:2]
    if (lacking := layers - wheels.shape[2]) > 0:
        wheels = np.concatenate([wheels, no_faults(spacecraft, count, lacking)], axis=2)
    if (lacking := sensed - sensors.shape[1]) > 0:
        sensors = np.concatenate([sensors, no_sensor_faults(spacecraft, lacking)], axis=1)
    if (lacking := chains - switches.shape[1]) > 0:
        switches = np.concatenate([switches, np.full((spacecraft, lacking, FLIPS), np.inf)], axis=1)
    return DrawnFaults(wheels, sensors, switches)
