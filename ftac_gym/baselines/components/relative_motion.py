"""Motion of the body relative to its reference."""

from __future__ import annotations

from dataclasses import dataclass

from ftac_gym.attitude import cross, quaternion_conjugate, quaternion_error, quaternion_product, rotate_to_body
from ftac_gym.task.measurement import Measurement
from ftac_gym.utils.parameters import FloatArray


@dataclass(frozen=True, eq=False)
class RelativeMotion:
    """Errors of N spacecraft: q_e = conj(q_d) (x) q and w_e = w - C(q_e) w_d.

    Attributes
    ----------
    error
        q_e (N, 4), the short way, or with the sign given by the two attitudes.
    rate_error
        w_e (N, 3), body axes [rad/s].
    reference_rate
        C(q_e) w_d (N, 3), body axes [rad/s]; None for a reference at rest.
    """

    error: FloatArray
    rate_error: FloatArray
    reference_rate: FloatArray | None

    def feed_forward(self, measurement: Measurement) -> FloatArray:
        """Return w' - w_e' = C w_d' - w_e x C w_d (N, 3) [rad/s^2], of a reference that moves."""
        assert self.reference_rate is not None
        turned = rotate_to_body(self.error, measurement.reference_acceleration)
        return turned - cross(self.rate_error, self.reference_rate)


def relative_motion(
    attitude: FloatArray, measurement: Measurement, moving: bool, short_way: bool = True
) -> RelativeMotion:
    """Return the motion of spacecraft with an attitude (N, 4), measured or filtered, and the measured rate.

    Parameters
    ----------
    attitude
        (N, 4) quaternion of the body.
    measurement
        Source of the rate and the reference.
    moving
        Whether the reference has a rate.
    short_way
        Whether q_e is the quaternion with q0 >= 0.
    """
    if short_way:
        error = quaternion_error(attitude, measurement.reference_attitude)
    else:
        error = quaternion_product(quaternion_conjugate(measurement.reference_attitude), attitude)
    if not moving:
        return RelativeMotion(error, measurement.rate, None)
    reference_rate = rotate_to_body(error, measurement.reference_rate)
    return RelativeMotion(error, measurement.rate - reference_rate, reference_rate)
