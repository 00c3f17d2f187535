"""Figures of evaluations and of single episodes, in one style that the colour-blind and grey printers can read.

Every function returns a new matplotlib ``Figure``, which its ``savefig`` saves. Matplotlib's settings and pyplot stay
as they are.
"""

from __future__ import annotations

from ftac_gym.utils.extras import naming_extra

with naming_extra():
    from ftac_gym.evaluation.truth import true_effect
    from ftac_gym.plots.bands import error_bands, error_percentiles
    from ftac_gym.plots.bounds import prescribed_bound
    from ftac_gym.plots.envelope import wheel_envelope
    from ftac_gym.plots.estimates import fault_estimates, torque_estimates
    from ftac_gym.plots.overview import episode
    from ftac_gym.plots.polytope import TorquePolytope, polytopes_along, torque_polytope
    from ftac_gym.plots.recording import EstimateHistory, estimates_along
    from ftac_gym.plots.sphere import boresight_paths
    from ftac_gym.plots.style import COLORS, FLOOR, Stroke, fault_description, stroke

__all__ = [
    "COLORS",
    "FLOOR",
    "EstimateHistory",
    "Stroke",
    "TorquePolytope",
    "boresight_paths",
    "episode",
    "error_bands",
    "error_percentiles",
    "estimates_along",
    "fault_description",
    "fault_estimates",
    "polytopes_along",
    "prescribed_bound",
    "stroke",
    "torque_estimates",
    "torque_polytope",
    "true_effect",
    "wheel_envelope",
]
