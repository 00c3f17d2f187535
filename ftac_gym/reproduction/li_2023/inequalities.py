"""Matrix inequalities of Li, Xu and Chang 2023, solved and certified for their example."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from itertools import product

import numpy as np

from ftac_gym import scenarios
from ftac_gym.baselines import synthesis
from ftac_gym.baselines.components.takagi_sugeno import TakagiSugenoModel
from ftac_gym.spacecraft.spacecraft import Spacecraft
from ftac_gym.utils.parameters import FloatArray

Answer = tuple[synthesis.Certificate, FloatArray]
"""Certificate of a problem, and its gains."""


@dataclass(frozen=True)
class Solved:
    """Result of one problem of matrix inequalities.

    Attributes
    ----------
    gamma
        The H-infinity bound.
    holds
        Whether the certificate proves it.
    outside
        Numbers of the rules with poles outside the disc.
    reach
        Distance of the farthest pole from the centre of the disc [1/s].
    gain
        Largest gain.
    seconds
        Time for solving and certifying [s].
    """

    gamma: float
    holds: bool
    outside: tuple[int, ...]
    reach: float
    gain: float
    seconds: float


def _observer(model: TakagiSugenoModel, solve: bool) -> Answer:
    if solve:
        design = synthesis.design_observer(model)
        return design.certificate, design.gains.fault
    gains = synthesis.published().observer
    return synthesis.certify_observer(model, gains), gains.fault


def _controller(model: TakagiSugenoModel, solve: bool) -> Answer:
    if solve:
        design = synthesis.design_controller(model)
        return design.proof.certificate, design.gains.feedback
    gains = synthesis.published().controller
    return synthesis.certify_controller(model, gains).certificate, gains.feedback


PROBLEMS: dict[str, Callable[[TakagiSugenoModel, bool], Answer]] = {"Theorem 1": _observer, "Theorem 2": _controller}


def _other_sign(spacecraft: Spacecraft) -> Spacecraft:
    """Return the spacecraft with the printed sign of delta(3, 3)."""
    appendages = spacecraft.appendages
    assert appendages is not None
    coupling = appendages.coupling_matrix
    coupling[2, 2] = -coupling[2, 2]
    changed = replace(appendages, coupling=tuple(tuple(row) for row in coupling.tolist()))
    return replace(spacecraft, appendages=changed)


@cache
def inequalities() -> dict[str, Solved]:
    """Return the results of Theorems 1 and 2 for the example, by problem; solving takes half a minute."""
    spacecraft = scenarios.get("li_2023").spacecraft
    models = {"-": TakagiSugenoModel(spacecraft), "+": TakagiSugenoModel(_other_sign(spacecraft))}
    found = {}
    for (sign, model), gains, (theorem, problem) in product(models.items(), ("published", "solved"), PROBLEMS.items()):
        start = time.perf_counter()
        proof, values = problem(model, gains == "solved")
        assert proof.disc is not None
        found[f"{theorem}, {gains}, delta(3,3) {sign}"] = Solved(
            gamma=proof.gamma,
            holds=proof.holds,
            outside=tuple(int(rule) + 1 for rule in np.flatnonzero(proof.reach > proof.disc.radius)),
            reach=float(proof.reach.max()),
            gain=float(np.abs(values).max()),
            seconds=time.perf_counter() - start,
        )
    return found


@cache
def refused() -> str:
    """Return the answer of the solver to gamma_1^2 = 0.1."""
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
