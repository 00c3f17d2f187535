"""State and model of the multiple-model estimator of :mod:`.plant_kernel`."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ftac_gym.baselines.estimators.wheel_kernel import LONGEST_LOOP

PLANT_STATE = np.dtype(
    [
        ("started", "?"),
        ("age", "i8"),
        ("late", "i8"),
        ("energies", "f8", (LONGEST_LOOP + 1,)),
        ("rate", "f8", (3,)),
        ("missing", "f8", (3,)),
        ("rest", "f8", (3,)),
        ("slow", "f8", (3,)),
        ("parameters", "f8", (9,)),
        ("covariance", "f8", (9, 9)),
    ]
)
"""State of one spacecraft.

Whether it has started; control periods since then; delay of the loop beyond the nominal one [control periods], and the
squared normalised residuals that each such delay leaves, summed with a weight that fades. The rate of the last period
[rad/s]; in body axes [N m] the missing torque of the last period, its rest without that of faulty wheels, and the rest
low-passed. Then inertia (xx, yy, zz, xy, xz, yz) [kg m^2] and angular momentum in inertial axes [N m s], with their
covariance.
"""


class PlantModel(NamedTuple):
    """Nominal spacecraft and thresholds of the estimator; SI units.

    Attributes
    ----------
    period
        Control period [s].
    axes
        (m, 3) wheel axes.
    limits
        (m,) torque limits [N m].
    assured
        (m,) torque that each wheel gives at any speed [N m]; infinite without a limit of its power.
    coupled
        Whether the momentum of the wheels acts on the body.
    start, spread
        (9,) parameters at the start, and (9, 9) their covariance.
    noise
        (3, 3) covariance of the torque that the gyro noise of one period looks like [N2 m2].
    excitation
        Least squared angular acceleration at which the parameters are learned [rad^2/s^4].
    tolerance
        Error of the model as a share of the commanded torque.
    floor
        Standard deviation of the torque of environment, friction and dead band [N m].
    lags
        (m,) time constants of the wheels [s].
    tachometer
        Variance of the torque of a wheel by its tachometer [N2 m2]; infinite without telemetry.
    drift
        Score that each wheel loses every period; a healthy wheel gains 1 on average.
    largest
        Largest increment of a score.
    threshold
        Score of a faulty wheel.
    margin
        Least difference of twice the logarithms of likelihood by which a kind of fault is told from others.
    """

    period: float
    axes: Any
    limits: Any
    assured: Any
    coupled: bool
    start: Any
    spread: Any
    noise: Any
    excitation: float
    tolerance: float
    floor: float
    lags: Any
    tachometer: float
    drift: float
    largest: float
    threshold: float
    margin: float
