"""Rows of tables: estimates of policies and their differences to a reference, over identical episodes."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ftac_gym.evaluation.batches import Evaluation
from ftac_gym.evaluation.metrics import SHARES, Metrics
from ftac_gym.evaluation.statistics import Estimate, Statistic, estimate, interquartile_mean, mean, paired_difference
from ftac_gym.faults import FaultDistribution, FaultKind, label_of
from ftac_gym.task.episodes import Episodes
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import require


@dataclass(frozen=True)
class Row:
    """A policy in a table.

    Attributes
    ----------
    policy
        Name of the policy.
    estimates
        Estimates by metric.
    differences
        Paired differences to the reference by metric; empty for the reference.
    """

    policy: str
    estimates: Mapping[str, Estimate]
    differences: Mapping[str, Estimate]


ERROR_AND_VIBRATION = "error_and_vibration"
"""Integrated error plus modal energy, each over the mean of the reference: a further metric of flexible spacecraft."""

_BOUND_METRICS = ("bound_kept", "bound_margin")
_VIBRATION_METRICS = ("jitter", "modal_energy", "residual_energy", "vibration_torque")

TABLE_METRICS = (
    "availability",
    "success",
    "settling_time",
    "final_error",
    "integrated_error",
    "peak_after_fault",
    "recovery_time",
    "energy",
    "chatter",
    *_BOUND_METRICS,
    *_VIBRATION_METRICS,
)
"""Metrics of tables. A scenario without a bound or without vibration modes has no such metrics, nor the jitter."""


def statistic_of(metric: str) -> Statistic:
    """Return the statistic of a metric in tables: the mean of shares, the interquartile mean of others."""
    return mean if metric in (*SHARES, ERROR_AND_VIBRATION) else interquartile_mean


def tabulate(evaluations: list[Evaluation], reference: str, chosen: npt.NDArray[np.bool_]) -> list[Row]:
    """Tabulate policies over some of the episodes.

    Parameters
    ----------
    evaluations
        One per policy, all on the same episodes.
    reference
        Name of the policy that the others are compared with; differences are policy minus reference.
    chosen
        (N,) which episodes count.

    Raises
    ------
    ValueError
        If the reference is not among the policies.
    """
    by_name = {evaluation.policy: evaluation.metrics for evaluation in evaluations}
    require(reference in by_name, "reference", f"must be one of {sorted(by_name)}", reference)
    base = by_name[reference]
    bounded, flexible = (not np.isnan(base[metric]).all() for metric in ("bound_kept", "modal_energy"))
    left_out = (*(() if bounded else _BOUND_METRICS), *(() if flexible else _VIBRATION_METRICS))
    means = {name: np.mean(base[name][chosen]) for name in ("integrated_error", "modal_energy") if flexible}

    def columns(metrics: Metrics) -> Metrics:
        found = {metric: metrics[metric][chosen] for metric in TABLE_METRICS if metric not in left_out}
        if flexible:
            error, energy = (metrics[name][chosen] / value for name, value in means.items())
            found[ERROR_AND_VIBRATION] = error + energy
        return found

    rows = []
    compared = columns(base)
    for evaluation in evaluations:
        own = columns(evaluation.metrics)
        estimates = {metric: estimate(values, statistic_of(metric)) for metric, values in own.items()}
        differences = {}
        if evaluation.policy != reference:
            differences = {metric: paired_difference(values, compared[metric]) for metric, values in own.items()}
        rows.append(Row(evaluation.policy, estimates, differences))
    return rows


ALWAYS_ONLY = "always-on only"
"""Class of an episode whose only faults are those that its distribution has in every episode."""


def fault_classes(episodes: Episodes) -> npt.NDArray[np.str_]:
    """Return the class of each episode (N,): a kind of fault, "healthy", or the number of faults, such as "2 faults".

    Several faults of one wheel count as one, of the kind that stands last in :class:`~ftac_gym.faults.FaultKind`. The
    ``always`` of a :class:`~ftac_gym.faults.FaultDistribution` does not count. An episode with no other fault has the
    class "always-on only".
    """
    source, drawn = Scenario.from_json(episodes.scenario_json).faults, episodes.drawn_faults
    none = label_of(FaultKind.NONE)
    if isinstance(source, FaultDistribution) and source.always:
        drawn, none = source.random_part(drawn), ALWAYS_ONLY
    kinds = np.concatenate([drawn.wheels["kind"].max(axis=2), drawn.sensors["kind"]], axis=1)
    counts, last = (kinds > 0).sum(axis=1).tolist(), kinds.max(axis=1).tolist()
    names = {FaultKind.NONE: none} | {kind: label_of(kind) for kind in set(last) - {FaultKind.NONE}}
    return np.array(
        [names[kind] if count <= 1 else f"{count} faults" for kind, count in zip(last, counts, strict=True)]
    )
