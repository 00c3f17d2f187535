"""Faults that come and go while an episode runs, because somebody wants to see what happens.

The tables that result are those of an episode that had these faults from the start: it replays.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ftac_gym.faults.fault import UNIFORMS_PER_FAULT, Fault, SensorFault, WheelFault
from ftac_gym.faults.table import FLIPS, DrawnFaults, no_faults, no_sensor_faults
from ftac_gym.utils.parameters import FloatArray, require

AFTER = 1e-6
"""How long after now faults of the sensors come and go [s]: the measurement of this moment has been taken."""


def add_fault(
    drawn: DrawnFaults, craft: int, fault: Fault, time: float, torque_limits: FloatArray, random: np.random.Generator
) -> DrawnFaults:
    """Return tables in which one more fault strikes a craft; those given are left as they are.

    Parameters
    ----------
    drawn
        Faults of N episodes.
    craft
        Which of them is struck.
    fault
        The fault; its times count from now. A fault of a wheel must name it, and comes on top of what is wrong with it.
    time
        Now, in the time of the craft's episode [s].
    torque_limits
        (m,) of the wheels [N m].
    random
        Draws what the fault leaves open.

    Raises
    ------
    ValueError
        If the fault of a wheel names none, or one that the craft does not have.
    """
    uniform = random.random((1, UNIFORMS_PER_FAULT))
    layers, sensed, chains = drawn.wheels.shape[2], drawn.sensors.shape[1], drawn.switches.shape[1]
    if isinstance(fault, WheelFault):
        count = len(torque_limits)
        valid = fault.wheel is not None and fault.wheel < count
        require(valid, "wheel", f"must be one of {list(range(count))}", fault.wheel)
        wheel = fault.wheel or 0
        records = fault.draw(uniform, torque_limits[[wheel]])
        place: tuple[int, ...] = (craft, wheel)
        layers += int((drawn.wheels["kind"][place] > 0).all())
    else:
        assert isinstance(fault, SensorFault)
        records = fault.draw(uniform)
        time += AFTER
        place = (craft,)
        sensed += int((drawn.sensors["kind"][place] > 0).all())
    wider = widened(drawn.copy(), layers, sensed, chains + int(fault.random_chain))
    if fault.random_chain:
        records["chain"] = chains
        wider.switches[craft, chains] = time + fault.switching_times(records["onset"], random.random((1, FLIPS)))[0]
    records["onset"] += time
    records["recovery"] += time
    table = (wider.wheels if isinstance(fault, WheelFault) else wider.sensors)[place]
    table[int(np.argmin(table["kind"] > 0))] = records[0]
    return wider


def clear_faults(drawn: DrawnFaults, craft: int, wheel: int | None, time: float) -> DrawnFaults:
    """Return tables in which nothing is wrong with a wheel, or with the sensors, from now on.

    Parameters
    ----------
    drawn
        Faults of N episodes; left as they are.
    craft
        Which of them is repaired.
    wheel
        Which of its wheels; None for its sensors.
    time
        Now, in the time of the craft's episode [s].
    """
    healed = drawn.copy()
    records = healed.sensors[craft] if wheel is None else healed.wheels[craft, wheel]
    over = records["onset"] >= time
    time += AFTER if wheel is None else 0.0
    records["recovery"] = np.where(over, records["recovery"], np.minimum(records["recovery"], time))
    records["fall"] = np.where(over, records["fall"], 0.0)
    healthy: npt.NDArray[np.void] = (
        no_sensor_faults(1, len(records))[0] if wheel is None else no_faults(1, 1, len(records))[0, 0]
    )
    records[over] = healthy[over]
    return healed


def widened(drawn: DrawnFaults, layers: int, sensed: int, chains: int) -> DrawnFaults:
    """Return tables with room for at least so many faults of a wheel and of the sensors, and so many random chains."""
    wheels, sensors, switches = drawn
    craft, count = wheels.shape[:2]
    if (lacking := layers - wheels.shape[2]) > 0:
        wheels = np.concatenate([wheels, no_faults(craft, count, lacking)], axis=2)
    if (lacking := sensed - sensors.shape[1]) > 0:
        sensors = np.concatenate([sensors, no_sensor_faults(craft, lacking)], axis=1)
    if (lacking := chains - switches.shape[1]) > 0:
        switches = np.concatenate([switches, np.full((craft, lacking, FLIPS), np.inf)], axis=1)
    return DrawnFaults(wheels, sensors, switches)
