"""Effects of faults at a moment: the truth, for oracles and plots.

The compiled plant evaluates the same tables in :mod:`ftac_gym.faults.signals`; ``tests/faults`` holds the two
to each other.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ftac_gym.faults.table import DrawnFaults
from ftac_gym.spacecraft.wheel_array import WheelArray
from ftac_gym.utils.parameters import FloatArray

_TOLERANCE = 1e-9
"""Two times closer than this are the same time [s]; it absorbs rounding in step * period."""


class FaultEffect(NamedTuple):
    """Effects at a moment of the faults of N spacecraft with m wheels.

    Attributes
    ----------
    effectiveness
        (N, m) ratio of each wheel's torque to its command.
    bias
        (N, m) added torque [N m]; excess friction counts as bias.
    delay
        (N, m) delay of the command [control periods].
    rate_bias
        (N, 3) error of the measured rate [rad/s].
    attitude_turn
        (N, 3) error of the measured attitude, a rotation vector in body axes [rad].
    star_tracker_out
        (N,) whether the star tracker delivers nothing.
    """

    effectiveness: FloatArray
    bias: FloatArray
    delay: npt.NDArray[np.int64]
    rate_bias: FloatArray
    attitude_turn: FloatArray
    star_tracker_out: npt.NDArray[np.bool_]


def presence(records: npt.NDArray[np.void], switches: FloatArray, time: FloatArray) -> FloatArray:
    """Return the part of each fault that is present.

    Parameters
    ----------
    records
        FAULT or SENSOR_FAULT records (N, ...).
    switches
        (N, chains, FLIPS) switching times [s].
    time
        (N,) time of each episode [s].

    Returns
    -------
    Array of the records' shape, in [0, 1]; a fault that is not gradual gives 0 or 1.
    """
    now = time.reshape(-1, *(1,) * (records.ndim - 1))
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        since = np.maximum(now - records["onset"], 0.0)
        acting = (now >= records["onset"] - _TOLERANCE) & (now < records["recovery"] - _TOLERANCE)
        period = np.where(records["period"] > 0.0, records["period"], np.inf)
        phase = since - np.floor((since + _TOLERANCE) / period) * np.where(np.isinf(period), 0.0, period)
        acting &= np.isinf(period) | (phase < records["on_time"] - _TOLERANCE)
        grown = np.where(records["rise"] > 0.0, since / records["rise"], 1.0)
        left = np.where(records["fall"] > 0.0, (records["recovery"] - now) / records["fall"], 1.0)
    if switches.shape[1]:
        flips = (switches <= time[:, None, None] + _TOLERANCE).sum(axis=2)
        flipped = np.take_along_axis(flips, np.maximum(records["chain"], 0).reshape(len(records), -1), axis=1)
        acting &= (records["chain"] < 0) | (flipped.reshape(records.shape) % 2 == 0)
    return np.where(acting, np.clip(np.minimum(grown, left), 0.0, 1.0), 0.0)


def fault_effect(
    drawn: DrawnFaults, time: FloatArray, wheels: WheelArray, wheel_momentum: FloatArray, wheel_torque: FloatArray
) -> FaultEffect:
    """Evaluate the fault tables.

    Parameters
    ----------
    drawn
        Faults of N episodes.
    time
        (N,) time of each episode [s].
    wheels
        The wheel array.
    wheel_momentum
        (N, m) momentum of each wheel [N m s], on which friction depends.
    wheel_torque
        (N, m) torque that each wheel applied last [N m]: a locked wheel repeats it, and a seized one cannot change it.
    """
    faults = drawn.wheels
    part = presence(faults, drawn.switches, time)
    now = time[:, None, None]
    with np.errstate(invalid="ignore"):
        since = np.maximum(now - faults["onset"], 0.0)
    angle = faults["effectiveness_frequency"] * now + faults["effectiveness_phase"]
    whole = faults["effectiveness"] + faults["effectiveness_amplitude"] * np.sin(angle)
    swing = faults["bias_amplitude"] * np.sin(faults["bias_frequency"] * since + faults["bias_phase"])
    bias = faults["bias"] + faults["bias_slope"] * since + swing * since ** faults["bias_exponent"]
    stuck = ((part > 0.0) & ((faults["locked"] > 0.5) | (faults["brake"] > 0.0))).any(axis=2)
    excess = np.where(wheel_momentum[:, :, None] > 0.0, faults["friction_forward"], faults["friction_backward"])
    factor = (1.0 + part * (excess - 1.0)).prod(axis=2) - 1.0
    rubbing = np.zeros_like(wheel_torque)
    for wheel, friction in enumerate(wheels.frictions):
        if friction is not None:
            dry = friction.dry(wheel_momentum[:, wheel] / wheels.spin_inertias[wheel])
            rubbing[:, wheel] = factor[:, wheel] * dry
    seen = presence(drawn.sensors, drawn.switches, time)
    return FaultEffect(
        effectiveness=np.where(stuck, 0.0, (1.0 + part * (whole - 1.0)).prod(axis=2)),
        bias=np.where(stuck, wheel_torque, np.where(part > 0.0, part * bias, 0.0).sum(axis=2) + rubbing),
        delay=np.where(part > 0.0, faults["delay"], 0).max(axis=2),
        rate_bias=np.einsum("nk,nki->ni", seen, drawn.sensors["rate_bias"]),
        attitude_turn=np.einsum("nk,nki->ni", seen, drawn.sensors["attitude_turn"]),
        star_tracker_out=np.any((seen > 0.0) & (drawn.sensors["outage"] > 0.5), axis=1),
    )
