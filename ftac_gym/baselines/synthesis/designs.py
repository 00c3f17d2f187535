"""Gains by their source: the paper's appendix, or matrix inequalities solved for a spacecraft.

Solved designs are stored as data, so that their use needs no solver and gives the same numbers everywhere. They are
made by ``ftac-synthesize --scenario NAME --store``.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, lru_cache
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

from ftac_gym.baselines.components.takagi_sugeno import TakagiSugenoModel
from ftac_gym.baselines.synthesis.controller_design import DISC as CONTROLLER_DISC
from ftac_gym.baselines.synthesis.controller_design import ControllerDesign, design_controller
from ftac_gym.baselines.synthesis.gain_matrices import (
    ControllerGains,
    ObserverGains,
    default_fault_proportional,
    default_vibration_proportional,
)
from ftac_gym.baselines.synthesis.observer_design import DISC as OBSERVER_DISC
from ftac_gym.baselines.synthesis.observer_design import ObserverDesign, design_observer
from ftac_gym.baselines.synthesis.regions import Disc
from ftac_gym.spacecraft.spacecraft import Spacecraft
from ftac_gym.utils.extras import MissingExtra
from ftac_gym.utils.files import reading
from ftac_gym.utils.parameters import FloatArray, require
from ftac_gym.utils.serialization import parse_json

DESIGNS = ("published", "solved")

_FOLDER = resources.files("ftac_gym.baselines.synthesis")
_PUBLISHED = "li_2023_published.json"


def stored_files() -> dict[str, bytes]:
    """Return the contents of the files of published and solved gains by name: who uses gains depends on them."""
    solved_files = {file.name: file.read_bytes() for file in _FOLDER.joinpath("stored").iterdir()}
    return {_PUBLISHED: _FOLDER.joinpath(_PUBLISHED).read_bytes(), **dict(sorted(solved_files.items()))}


@dataclass(frozen=True, eq=False)
class DesignGains:
    """Gains of observer and controller."""

    observer: ObserverGains
    controller: ControllerGains


@cache
def published() -> DesignGains:
    """Return the gains of the appendix (A.1), (A.2) of Li et al. 2023, with theta F_2 and theta G_2 of Eq. (68)."""
    with reading(Path(str(_FOLDER.joinpath(_PUBLISHED))), "install the package again"):
        data = parse_json(stored_files()[_PUBLISHED])
        observer = ObserverGains(
            **{name: np.array(part) for name, part in data["observer"].items()},
            fault_proportional=default_fault_proportional(),
            vibration_proportional=default_vibration_proportional(4),
        )
        return DesignGains(observer, ControllerGains(**data["controller"]))


def design(
    spacecraft: Spacecraft, observer_disc: Disc = OBSERVER_DISC, controller_disc: Disc = CONTROLLER_DISC
) -> tuple[ObserverDesign, ControllerDesign]:
    """Solve both theorems for a spacecraft, each for its smallest level.

    The bound on the virtual torque is the smallest torque of the wheels at their limits about a body axis, times the
    root of three. In the paper's example it is 5 sqrt(3) N m.

    Raises
    ------
    ValueError
        If the spacecraft is rigid or there is no solution.
    MissingExtra
        Without CVXPY.
    """
    model, wheels = TakagiSugenoModel(spacecraft), spacecraft.wheels
    limits = np.where(np.isfinite(wheels.torque_limits), wheels.torque_limits, 5.0)
    bound = float(np.sqrt(3.0) * (np.abs(wheels.axis_matrix) @ limits).min())
    return design_observer(model, observer_disc), design_controller(model, controller_disc, torque_bound=bound)


def identity(spacecraft: Spacecraft) -> dict[str, Any]:
    """Return the numbers of a spacecraft that identify its design."""
    appendages = spacecraft.appendages
    if appendages is None:
        raise ValueError("appendages must be given: a fuzzy design is one for a flexible spacecraft, got None")
    return {
        "inertia": [list(row) for row in spacecraft.inertia],
        "frequencies": list(appendages.frequencies),
        "damping_ratios": np.array(appendages.damping_ratios).tolist(),
        "coupling": [list(row) for row in appendages.coupling],
        "axes": [list(row) for row in spacecraft.wheels.axes],
        "torque_limits": [None if np.isinf(limit) else float(limit) for limit in spacecraft.wheels.torque_limits],
    }


@lru_cache(maxsize=32)
def solved(spacecraft: Spacecraft) -> DesignGains:
    """Return the gains for a spacecraft: stored ones if there are any, else by solving, which takes seconds.

    Raises
    ------
    ValueError
        If the spacecraft is rigid, there is no solution, or a stored design is damaged.
    MissingExtra
        If no design is stored, and without CVXPY.
    """
    numbers = identity(spacecraft)
    for name, content in stored_files().items():
        if name == _PUBLISHED:
            continue
        remedy = f"solve it again: ftac-synthesize --scenario {name.removesuffix('.json')} --store"
        with reading(Path(str(_FOLDER.joinpath("stored", name))), remedy):
            data = parse_json(content)
            if data["spacecraft"] == numbers:
                return DesignGains(ObserverGains(**data["observer"]), ControllerGains(**data["controller"]))
    try:
        observer, controller = design(spacecraft)
    except MissingExtra as error:
        raise MissingExtra(f"no design is stored for this spacecraft, and {error}") from None
    return DesignGains(observer.gains, controller.gains)


def gains(spacecraft: Spacecraft, source: str) -> DesignGains:
    """Return the gains from a source.

    Parameters
    ----------
    spacecraft
        The spacecraft; the published gains do not depend on it.
    source
        ``"published"`` or ``"solved"``.

    Raises
    ------
    ValueError
        If the source is unknown, or the spacecraft does not have as many modes as the paper's.
    """
    require(source in DESIGNS, "design", f"must be one of {list(DESIGNS)}", source)
    if source == "solved":
        return solved(spacecraft)
    identity(spacecraft)
    rule = f"must be 'solved' for a spacecraft with {spacecraft.modes} modes: published is for 4"
    require(spacecraft.modes == 4, "design", rule, source)
    return published()


def record(spacecraft: Spacecraft, observer: ObserverDesign, controller: ControllerDesign) -> dict[str, Any]:
    """Return the stored form of a design, as plain data."""
    disc = observer.certificate.disc

    def rounded(data: dict[str, Any]) -> dict[str, Any]:
        # Nine digits: the certificate holds for the rounded gains, which are the same on all machines.
        return {name: _rounded(np.array(part)) for name, part in data.items()}

    return {
        "spacecraft": identity(spacecraft),
        "gamma_1": round(observer.certificate.gamma, 4),
        "gamma_2": round(controller.proof.certificate.gamma, 4),
        "observer_disc": None if disc is None else [disc.centre, disc.radius],
        "observer": rounded(observer.gains.to_dict()),
        "controller": rounded(controller.gains.to_dict()),
    }


def _rounded(array: FloatArray) -> Any:
    digits = np.vectorize(lambda value: float(f"{value:.9g}"))
    return digits(array).tolist()
