"""What the claims of Li, Xu and Chang 2023 are judged by."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import numpy.typing as npt

from ftac_gym import scenarios
from ftac_gym.attitude import quaternion_error, quaternion_from_mrp
from ftac_gym.baselines import synthesis
from ftac_gym.baselines.components.takagi_sugeno import TakagiSugenoModel, TriangularSets
from ftac_gym.reproduction.flight import Flight, from_when
from ftac_gym.spacecraft.spacecraft import Spacecraft
from ftac_gym.utils.parameters import FloatArray

CALM = (15.0, 39.5)
"""After the observer's transient, before the faults [s]."""

LENGTH = 200.0
"""The example's duration [s]."""

SETTLED = 1e-2
"""|q_ev| below which a manoeuvre counts as done: 1.1 degrees."""

FIRST, SECOND, LATE = (0.0, 40.0), (80.0, LENGTH), (160.0, LENGTH)
"""The manoeuvres of Table 1, and the end [s]."""


def during(flight: Flight, window: tuple[float, float]) -> npt.NDArray[np.bool_]:
    """Return which of the (T + 1) samples lie in a window of the example, which a shorter flight has shortened with it.

    Of flights that are shorter on purpose no window is asked for.
    """
    scale = min(1.0, flight.time[-1] / LENGTH)
    inside: npt.NDArray[np.bool_] = (flight.time >= window[0] * scale) & (flight.time <= window[1] * scale)
    return inside


def pointing(flight: Flight) -> FloatArray:
    """Return |q_ev| (T + 1,) of the first craft."""
    size: FloatArray = np.sin(0.5 * np.radians(flight.error[:, 0]))
    return size


def largest(flight: Flight, window: tuple[float, float]) -> float:
    """Return the largest |q_ev| in a window."""
    return float(pointing(flight)[during(flight, window)].max())


def settling(flight: Flight, window: tuple[float, float], limit: float = SETTLED) -> float:
    """Return how long after the start of a window |q_ev| falls below a limit for its rest [s]; infinite if never."""
    inside = during(flight, window)
    when = flight.time[inside]
    return from_when(when - when[0], pointing(flight)[inside], limit)


def rate_error(flight: Flight, window: tuple[float, float]) -> float:
    """Return the largest |w - w^| in a window [rad/s]."""
    assert flight.rate_mismatch is not None
    size = np.linalg.norm(flight.rate_mismatch[:, 0], axis=1)
    return float(size[during(flight, window)[:-1]].max())


def fault_torque(flight: Flight) -> FloatArray:
    """Return what the faults do, (E - I) u + f (T, 3) [N m]: the wheels of the example lie along the body axes."""
    torque: FloatArray = (flight.true_effectiveness[:, 0] - 1.0) * flight.command[:, 0] + flight.true_bias[:, 0]
    return torque


def fault_error(flight: Flight, window: tuple[float, float]) -> FloatArray:
    """Return the root mean square of f^ - f in a window, (3,) [N m]."""
    assert flight.disturbance is not None
    error = (flight.disturbance[:, 0] - fault_torque(flight))[during(flight, window)[:-1]]
    size: FloatArray = np.sqrt((error**2).mean(axis=0))
    return size


def vibration_error(flight: Flight, window: tuple[float, float]) -> tuple[float, float]:
    """Return the root mean squares of d^ - d and of d in a window [N m]."""
    assert flight.vibration is not None
    inside = during(flight, window)[:-1]
    truth = flight.true_vibration[:-1, 0][inside]
    error = flight.vibration[:, 0][inside] - truth
    return tuple(float(np.sqrt((part**2).sum(axis=1).mean())) for part in (error, truth))  # type: ignore[return-value]


def shaking(flight: Flight, window: tuple[float, float]) -> float:
    """Return the root mean square of the modes' torque on the body in a window [N m]."""
    torque = flight.true_vibration[:, 0][during(flight, window)]
    return float(np.sqrt((torque**2).sum(axis=1).mean()))


def energy_at(flight: Flight, moment: float) -> float:
    """Return the energy of the modes at a moment of the example, the mean of 4 s about it [J]."""
    return float(flight.modal_energy[during(flight, (moment - 2.0, moment + 2.0)), 0].mean())


def virtual_control(flight: Flight) -> tuple[float, float]:
    """Return the largest |s| [rad/s] and |sum h_i K_i s| [N m] at the starts of the manoeuvres; published gains."""
    sets, feedback = TriangularSets(), synthesis.published().controller.feedback
    attitude, reference = (quaternion_from_mrp(part[:, 0]) for part in (flight.attitude, flight.reference))
    variable = flight.rate[:, 0] + 2.0 * quaternion_error(attitude, reference)[:, 1:]
    torque = np.einsum("nr,rij,nj->ni", sets(flight.rate[:, 0]), feedback, variable)
    starts = [int(np.flatnonzero(during(flight, window))[0]) for window in (FIRST, SECOND)]
    return tuple(float(np.linalg.norm(part[starts], axis=1).max()) for part in (variable, torque))  # type: ignore[return-value]


def at_limit(flight: Flight) -> float:
    """Return the share of time that any wheel is commanded its limit."""
    limits = flight.scenario.spacecraft.wheels.torque_limits
    return float((np.abs(flight.command[:, 0]) >= limits * (1.0 - 1e-9)).any(axis=1).mean())


def lag(flight: Flight) -> float:
    """Return by how much the first channel of f^ comes late from 110 to 195 s, where it fits f best [s]."""
    assert flight.disturbance is not None
    inside = np.flatnonzero(during(flight, (110.0, 195.0))[:-1])
    estimate, truth, period = (
        flight.disturbance[inside, 0, 0],
        fault_torque(flight)[:, 0],
        flight.scenario.control_period,
    )
    shifts = range(min(inside[0], round(3.0 / period)) + 1)
    misfits = [float(((estimate - truth[inside - shift]) ** 2).sum()) for shift in shifts]
    return int(np.argmin(misfits)) * period


def axis_errors(flight: Flight) -> FloatArray:
    """Return the largest |sigma_i - sigma_d,i| from 160 to 200 s, (3,)."""
    late = during(flight, LATE)
    errors: FloatArray = np.abs(flight.attitude[late, 0] - flight.reference[late, 0]).max(axis=0)
    return errors


def words(values: Mapping[str, float], form: str = ".2g", unit: str = "") -> str:
    """Return numbers by name in words."""
    return ", ".join(f"{name} {value:{form}}{unit}" for name, value in values.items())


@dataclass(frozen=True)
class Solved:
    """What one problem of matrix inequalities gave."""

    gamma: float
    holds: bool
    outside: tuple[int, ...]
    reach: float
    gain: float
    seconds: float


def _mirrored(spacecraft: Spacecraft) -> Spacecraft:
    """Return the spacecraft with the printed sign of delta(3, 3)."""
    appendages = spacecraft.appendages
    assert appendages is not None
    coupling = appendages.coupling_matrix
    coupling[2, 2] = -coupling[2, 2]
    changed = replace(appendages, coupling=tuple(tuple(row) for row in coupling.tolist()))
    return replace(spacecraft, appendages=changed)


@cache
def inequalities() -> dict[str, Solved]:
    """Return what Theorems 1 and 2 give for the example, by problem; it takes half a minute."""
    found = {}
    published = synthesis.published()
    for sign, spacecraft in (
        ("-", scenarios.get("li_2023").spacecraft),
        ("+", _mirrored(scenarios.get("li_2023").spacecraft)),
    ):
        model, where = TakagiSugenoModel(spacecraft), f"delta(3,3) {sign}"
        for what in ("published", "solved"):
            start = time.perf_counter()
            if what == "published":
                first, gains = synthesis.certify_observer(model, published.observer), published.observer
            else:
                design = synthesis.design_observer(model)
                first, gains = design.certificate, design.gains
            found[f"Theorem 1, {what}, {where}"] = _summary(first, float(np.abs(gains.fault).max()), start)
            start = time.perf_counter()
            if what == "published":
                proof, feedback = synthesis.certify_controller(model, published.controller), published.controller
            else:
                plan = synthesis.design_controller(model)
                proof, feedback = plan.proof, plan.gains
            largest_gain = float(np.abs(feedback.feedback).max())
            found[f"Theorem 2, {what}, {where}"] = _summary(proof.certificate, largest_gain, start)
    return found


def _summary(proof: synthesis.Certificate, gain: float, start: float) -> Solved:
    assert proof.disc is not None
    outside = tuple(int(rule) + 1 for rule in np.flatnonzero(proof.reach > proof.disc.radius))
    elapsed = time.perf_counter() - start
    return Solved(proof.gamma, proof.holds, outside, float(proof.reach.max()), gain, elapsed)


@cache
def refused() -> str:
    """Return what asking for gamma_1^2 = 0.1 is answered with."""
    try:
        synthesis.design_observer(TakagiSugenoModel(scenarios.get("li_2023").spacecraft), gamma=0.3162)
    except ValueError as error:
        return str(error)
    return "solved"


@cache
def symmetric_growth() -> float:
    """Return the largest eigenvalue of the symmetric part of A_i + B K_i, least over the rules [1/s]: (49)."""
    model = TakagiSugenoModel(scenarios.get("li_2023").spacecraft)
    closed = model.state + model.input @ synthesis.published().controller.feedback
    return float(np.linalg.eigvalsh(0.5 * (closed + closed.transpose(0, 2, 1)))[:, -1].min())
