"""Gains of observer and controller from linear matrix inequalities (Li, Xu and Chang 2023), proved after solving."""

from ftac_gym.baselines.synthesis.certificate import Certificate
from ftac_gym.baselines.synthesis.controller_design import (
    ControllerDesign,
    ControllerProof,
    certify_controller,
    design_controller,
)
from ftac_gym.baselines.synthesis.designs import DesignGains, design, gains, published, solved
from ftac_gym.baselines.synthesis.gain_matrices import ControllerGains, ObserverGains
from ftac_gym.baselines.synthesis.observer_design import (
    ObserverDesign,
    certify_observer,
    design_observer,
    error_dynamics,
    error_inputs,
)
from ftac_gym.baselines.synthesis.regions import Disc

__all__ = [
    "Certificate",
    "ControllerDesign",
    "ControllerGains",
    "ControllerProof",
    "DesignGains",
    "Disc",
    "ObserverDesign",
    "ObserverGains",
    "certify_controller",
    "certify_observer",
    "design",
    "design_controller",
    "design_observer",
    "error_dynamics",
    "error_inputs",
    "gains",
    "published",
    "solved",
]
