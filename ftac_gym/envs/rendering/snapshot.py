"""What there is to see of a craft at a moment."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ftac_gym.envs.batch import SpacecraftBatch
from ftac_gym.faults.description import Descriptions, acting_faults
from ftac_gym.utils.parameters import FloatArray


@dataclass(frozen=True, eq=False)
class Snapshot:
    """What there is to see of one craft of m wheels and k vibration modes: the truth, not the measurement.

    Attributes
    ----------
    time
        Since the start of the episode [s].
    attitude, reference_attitude
        (4,) quaternions relative to inertial axes, scalar first, of the body and of the target.
    rate
        (3,) body rate in body axes [rad/s].
    attitude_error
        [rad].
    rate_error
        [rad/s].
    on_target
        Whether both errors are within the scenario's limits of success.
    success
        Whether they have been for as long as success asks.
    command
        (m,) torque asked of each wheel [N m]; zero before the first step.
    wheel_torque
        (m,) torque of each wheel on the body [N m].
    wheel_momentum
        (m,) [N m s].
    effectiveness
        (m,) share of its command that each wheel gives, in [0, 1].
    faulty
        (m,) whether anything is wrong with each wheel.
    faults
        What is wrong now, in words: the faults of wheels with their wheel, then those of sensors.
    modal_displacement
        (k,) [kg^1/2 m].
    policy
        Who flies; empty if nobody said.
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
    """Return what there is to see of every craft.

    Parameters
    ----------
    batch
        The craft; they must have been reset.
    policy
        Who flies them.
    """
    simulator, reward, success = batch.simulator, batch.reward, batch.scenario.success
    state, time = simulator.state, simulator.time
    effect = simulator.truth()
    acting = acting_faults(simulator.faults, time)
    return tuple(
        Snapshot(
            time=float(time[craft]),
            attitude=state.attitude[craft].copy(),
            reference_attitude=simulator.reference_attitude[craft].copy(),
            rate=state.rate[craft].copy(),
            attitude_error=float(reward.attitude_error[craft]),
            rate_error=float(reward.rate_error[craft]),
            on_target=bool(reward.attitude_error[craft] < success.angle and reward.rate_error[craft] < success.rate),
            success=bool(reward.success[craft]),
            command=simulator.last_command[craft].copy(),
            wheel_torque=state.wheel_torque[craft].copy(),
            wheel_momentum=state.wheel_momentum[craft].copy(),
            effectiveness=effect.effectiveness[craft].copy(),
            faulty=acting[craft].wheels,
            faults=acting[craft].descriptions,
            modal_displacement=state.modal_displacement[craft].copy(),
            policy=policy,
        )
        for craft in range(simulator.num_spacecraft)
    )
