"""Truth about one spacecraft at a moment, the input of a frame."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ftac_gym.envs.batch import SpacecraftBatch
from ftac_gym.faults.description import Descriptions, acting_faults
from ftac_gym.utils.parameters import FloatArray


@dataclass(frozen=True, eq=False)
class Snapshot:
    """Truth, not measurement, about one spacecraft of m wheels and k vibration modes.

    Attributes
    ----------
    time
        Time since the start of the episode [s].
    attitude, reference_attitude
        (4,) quaternions relative to inertial axes, scalar first, of the body and of the target.
    rate
        (3,) body rate in body axes [rad/s].
    attitude_error
        Pointing error [rad].
    rate_error
        Magnitude of the rate error [rad/s].
    on_target
        Whether both errors are within the scenario's limits of success.
    success
        Whether an episode that ended now would be a success.
    command
        (m,) torque asked of each wheel [N m]; zero before the first step.
    wheel_torque
        (m,) torque of each wheel on the body [N m].
    wheel_momentum
        (m,) [N m s].
    effectiveness
        (m,) share of the command that each wheel gives, in [0, 1].
    faulty
        (m,) True for a wheel with an acting fault.
    faults
        Descriptions of the acting faults: those of wheels with their wheel, then those of sensors.
    modal_displacement
        (k,) [kg^1/2 m].
    policy
        Name of the policy; empty for none.
    """

    time: float
    attitude: FloatArray
    reference_attitude: FloatArray
    rate: FloatArray
    attitude_error: float
    rate_error: float
    on_target: bool
    success: bool
    command: FloatArray
    wheel_torque: FloatArray
    wheel_momentum: FloatArray
    effectiveness: FloatArray
    faulty: npt.NDArray[np.bool_]
    faults: Descriptions
    modal_displacement: FloatArray
    policy: str = ""


def snapshots(batch: SpacecraftBatch, policy: str = "") -> tuple[Snapshot, ...]:
    """Return a snapshot of every spacecraft.

    Parameters
    ----------
    batch
        The spacecraft; they must have been reset.
    policy
        Name of the policy.
    """
    simulator, reward, success = batch.simulator, batch.reward, batch.scenario.success
    state, time = simulator.state, simulator.time
    on_target = (reward.attitude_error < success.angle) & (reward.rate_error < success.rate)
    arrays = {
        "attitude": state.attitude,
        "reference_attitude": simulator.reference_attitude,
        "rate": state.rate,
        "command": simulator.last_command,
        "wheel_torque": state.wheel_torque,
        "wheel_momentum": state.wheel_momentum,
        "effectiveness": simulator.truth().effectiveness,
        "modal_displacement": state.modal_displacement,
    }
    return tuple(
        Snapshot(
            time=float(time[i]),
            attitude_error=float(reward.attitude_error[i]),
            rate_error=float(reward.rate_error[i]),
            on_target=bool(on_target[i]),
            success=bool(reward.success[i]),
            faulty=acting.wheels,
            faults=acting.descriptions,
            policy=policy,
            **{name: array[i].copy() for name, array in arrays.items()},
        )
        for i, acting in enumerate(acting_faults(simulator.faults, time))
    )
