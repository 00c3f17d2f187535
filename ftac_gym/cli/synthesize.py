"""Solve the matrix inequalities of Li et al. 2023 for the spacecraft of a scenario, and prove the solution.

For example:

    ftac-synthesize --scenario flexible
    ftac-synthesize --scenario flexible --store
"""

from __future__ import annotations

import json
import re
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ftac_gym.baselines import synthesis
from ftac_gym.baselines.synthesis.designs import record
from ftac_gym.cli.tasks import scenario_of, short_name
from ftac_gym.utils.console import check_store, exit_on
from ftac_gym.utils.files import write_text


@dataclass(frozen=True)
class Config:
    """A scenario, and the region for the poles of the observer."""

    scenario: str = "li_2023"
    """Scenario with the spacecraft: NAME, FILE.json or module:function."""
    centre: float = -10.0
    """Centre of the disc for all poles of the observer's error [1/s]."""
    radius: float = 10.0
    """Radius of the disc [1/s]."""
    store: bool = False
    """Store the gains in the package of a checkout, under the scenario's name."""


def main(config: Config) -> None:
    """Solve, prove, print, and store on request."""
    check_store(config.store)
    start, name = time.perf_counter(), config.scenario
    spacecraft = scenario_of(name).spacecraft
    with exit_on(ValueError, prefix=f"--scenario {name}: "):
        stored_as = short_name(name)
        observer, controller = synthesis.design(spacecraft, synthesis.Disc(config.centre, config.radius))
    elapsed = time.perf_counter() - start
    proof = observer.certificate
    print(f"solved in {elapsed:.1f} s for {spacecraft.modes} modes")
    print(
        f"observer (Theorem 1): gamma_1 = {proof.gamma:.4f}; poles at most {proof.reach.max():.3f} from "
        f"{config.centre:g}, real parts {proof.poles.real.min():.3g} to {proof.poles.real.max():.3g} 1/s; largest gain "
        f"of a rule {proof.peak_gain.max():.4f}; proved: {proof.holds}"
    )
    for name in ("rate", "fault", "vibration"):
        print(f"    largest {name} gain {np.abs(getattr(observer.gains, name)).max():.4g}")
    proof = controller.proof.certificate
    print(
        f"controller (Theorem 2): gamma_2 = {proof.gamma:.4f}; real parts {proof.poles.real.min():.3g} to "
        f"{proof.poles.real.max():.3g} 1/s; |K s| at most {controller.proof.torque_bound:.4g} N m from |s(0)| = "
        f"{controller.proof.state_bound:.4g} rad/s; proved: {proof.holds}"
    )
    if config.store:
        path = Path(synthesis.__file__).parent / "stored" / f"{stored_as}.json"
        text = json.dumps(record(spacecraft, observer, controller), indent=1)
        rows = re.compile(r"\[\s+([^\[\]{}]+?)\s+\]")
        write_text(path, rows.sub(lambda match: "[" + re.sub(r"\s+", " ", match[1]) + "]", text) + "\n")
        print(f"stored in {path}")
