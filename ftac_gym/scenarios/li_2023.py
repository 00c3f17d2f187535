"""The numerical example of Li, Xu and Chang 2023 (IET Control Theory & Applications 17, section 5).

A heavy body with flexible appendages turns twice while uncommanded torques act on two of its three wheels, whose axes
are slightly misaligned. The wheels are ideal torquers without gyroscopic coupling, as in the paper's equations.

Corrected:

- the sign of the third mode's coupling with the third axis, without which the published gains lack the stated property;
- the misalignment, whose degrees are degrees.

The paper leaves these open, and they are chosen here:

- the start of the manoeuvres from the attitude of section 5.1 (printed is the target itself), the reading under which
  there is a first manoeuvre;
- the limit of the torque, wheel by wheel, no momentum limit, perfect sensors;
- the control period, the integrator's step and the success criterion.

All other numbers are the authors'.
"""

import math

from ftac_gym.faults import Bias, FaultSchedule
from ftac_gym.spacecraft import FlexibleAppendages, Spacecraft, WheelArray, three_orthogonal
from ftac_gym.task import Disturbance, Harmonic, InitialState, RewardWeights, Scenario, SetPoints

WEAK = 0.2
"""Scale of the faults in the example with weak faults."""


def _quaternion(vector: tuple[float, float, float]) -> tuple[float, float, float, float]:
    return (math.sqrt(1.0 - sum(value * value for value in vector)), *vector)


START, FIRST, SECOND = (_quaternion(vector) for vector in ((0.1, -0.1, 0.1), (0.3, 0.2, -0.4), (0.2, -0.1, -0.1)))


def spacecraft() -> Spacecraft:
    """Return the nominal spacecraft, with three wheels along the body axes."""
    appendages = FlexibleAppendages(
        frequencies=(1.5362, 2.2076, 3.7466, 3.7466),
        damping_ratios=(0.0056, 0.0086, 0.013, 0.013),
        coupling=(
            (6.45637, 1.27814, 2.15629),
            (-1.25819, 0.91756, -1.67264),
            (1.11687, 2.48901, -0.83674),
            (1.23637, -2.65810, -1.12530),
        ),
    )
    return Spacecraft(
        ((350.0, 3.0, 4.0), (3.0, 270.0, 10.0), (4.0, 10.0, 190.0)),  # kg m^2
        WheelArray(three_orthogonal(), torque_limit=5.0, momentum_coupling=False),
        appendages=appendages,
    )


def _faults(scale: float) -> FaultSchedule:
    return FaultSchedule(
        (
            Bias(wheel=0, onset=40.0, amplitude=0.5 * scale, exponent=0.2, frequency=0.2),
            Bias(wheel=1, onset=40.0, constant=1.0 * scale, duration=30.0),
            Bias(wheel=1, onset=100.0, constant=1.5 * scale),
        )
    )


def _misalignment() -> tuple[tuple[float, ...], ...]:
    """Return Delta Gamma: each wheel's axis leans by the same amount towards the other two."""
    first, second, third = (
        math.radians(lean) * math.cos(math.radians(turn)) for lean, turn in ((0.2, 0.15), (0.1, 0.1), (0.1, 0.1))
    )
    return (0.0, second, third), (first, 0.0, third), (first, second, 0.0)


def li_2023() -> Scenario:
    """Return the manoeuvre sequence of Table 1 with the faults (66)."""
    slow, quarter = 0.2 * math.pi, 0.5 * math.pi
    return Scenario(
        name="li_2023",
        spacecraft=spacecraft(),
        initial_state=InitialState.fixed(START, rate=(0.02, -0.03, 0.01)),
        reference=SetPoints((FIRST, SECOND), (0.0, 80.0)),
        faults=_faults(1.0),
        disturbance=Disturbance(
            constant=(-3e-4, 4e-4, -3e-4),
            harmonics=(
                Harmonic((4e-4, 3e-4, 4e-4), frequency=slow, phase=(quarter, 0.0, 0.0)),
                Harmonic((-1e-4, -2e-4, -3e-4), frequency=2.0 * slow, phase=(quarter, quarter, 0.0)),
            ),
        ),
        misalignment=_misalignment(),
        control_period=0.05,
        physics_step=0.01,
        duration=200.0,
        # A slow spacecraft: at 0.1 rad/s it already spins.
        reward=RewardWeights(rate_scale=0.1),
    )


def li_2023_weak() -> Scenario:
    """Return the scenario with a fifth of the faults."""
    return li_2023().replace(name="li_2023_weak", faults=_faults(WEAK))


def li_2023_printed_start() -> Scenario:
    """Return the scenario from the printed start, which is the first target: only the rate must be removed."""
    return li_2023().replace(
        name="li_2023_printed_start", initial_state=InitialState.fixed(FIRST, rate=(0.02, -0.03, 0.01))
    )
