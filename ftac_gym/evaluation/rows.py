"""Rows of tables: estimates of policies and their differences to a reference, over identical episodes."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from ftac_gym.evaluation.batches import Evaluation
from ftac_gym.evaluation.metrics import HIGHER_IS_BETTER, SHARES, UNITS
from ftac_gym.evaluation.recovery import recovered_difference, recovered_within
from ftac_gym.evaluation.statistics import (
    Estimate,
    Statistic,
    estimate,
    interquartile_mean,
    mean,
    paired_difference,
    share,
)
from ftac_gym.faults import FaultDistribution, FaultKind, label_of
from ftac_gym.task.episodes import Episodes
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, require


@dataclass(frozen=True)
class Row:
    """A policy in a table.

    Attributes
    ----------
    policy
        Name of the policy.
    estimates
        Estimates by column, over the episodes that count.
    differences
        Paired differences to the reference by column; empty for the reference.
    drawn
        Estimates of :data:`HEADLINES` over all drawn episodes.
    """

    policy: str
    estimates: Mapping[str, Estimate]
    differences: Mapping[str, Estimate]
    drawn: Mapping[str, Estimate] = field(default_factory=dict)


HEADLINES = ("availability", "success")
"""Metrics that are given over all drawn episodes too, those included that are labelled infeasible."""

RECOVERED = "recovered_within_10_s"
"""Column of the share of the faults that are recovered within ten seconds (:mod:`ftac_gym.evaluation.recovery`)."""

ERROR_AND_VIBRATION = "error_and_vibration"
"""Integrated error plus modal energy, each over the mean of the reference: a further column of flexible spacecraft."""

_BOUND_METRICS = ("bound_kept", "bound_margin")
_VIBRATION_METRICS = ("jitter", "modal_energy", "residual_energy", "vibration_torque")

TABLE_METRICS = (
    *HEADLINES,
    "settling_time",
    RECOVERED,
    "ape_95",
    "integrated_error",
    "energy",
    "chatter",
    "momentum_headroom",
    *_BOUND_METRICS,
    *_VIBRATION_METRICS,
)
"""Columns of tables. A scenario without a bound, vibration modes or limits of momentum has no such ones.

Files with one line for each episode have all of :data:`~ftac_gym.evaluation.metrics.UNITS`.
"""

COLUMN_UNITS = {**UNITS, RECOVERED: "share of faults", ERROR_AND_VIBRATION: "-"}
"""Unit of each column."""

BETTER_IF_HIGHER = HIGHER_IS_BETTER | {RECOVERED}
"""Columns that are better if they are larger."""


def statistic_of(metric: str) -> Statistic:
    """Return the statistic of a metric in tables: the mean of shares, the interquartile mean of others."""
    if metric in SHARES:
        return share
    return mean if metric == ERROR_AND_VIBRATION else interquartile_mean


def column_estimate(runs: Sequence[Evaluation], column: str, chosen: npt.NDArray[np.bool_]) -> Estimate:
    """Estimate a column of a policy over all its training seeds and some of the episodes.

    Parameters
    ----------
    runs
        Evaluation of each training seed; one of a policy without seeds.
    column
        A metric, or :data:`RECOVERED`.
    chosen
        (N,) which episodes count.
    """
    if column == RECOVERED:
        return recovered_within([item.recoveries for item in runs], chosen)
    return estimate(_values(runs, column, chosen), statistic_of(column))


def column_difference(
    runs: Sequence[Evaluation], reference: Sequence[Evaluation], column: str, chosen: npt.NDArray[np.bool_]
) -> Estimate:
    """Estimate the difference of a column to that of the reference; parameters as for :func:`column_estimate`."""
    if column == RECOVERED:
        own, others = ([item.recoveries for item in part] for part in (runs, reference))
        return recovered_difference(own, others, chosen)
    first, second = (_values(part, column, chosen) for part in (runs, reference))
    return paired_difference(first, second, share if column in SHARES else mean)


def headlines(runs: Sequence[Evaluation]) -> dict[str, Estimate]:
    """Return the estimates of :data:`HEADLINES` over all drawn episodes."""
    everything = np.ones(len(runs[0].metrics[HEADLINES[0]]), dtype=np.bool_)
    return {metric: column_estimate(runs, metric, everything) for metric in HEADLINES}


def _values(runs: Sequence[Evaluation], metric: str, chosen: npt.NDArray[np.bool_]) -> FloatArray:
    """Return a metric, (seeds, chosen episodes)."""
    return np.array([item.metrics[metric][chosen] for item in runs], dtype=np.float64)


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
    by_name = {evaluation.policy: evaluation for evaluation in evaluations}
    require(reference in by_name, "reference", f"must be one of {sorted(by_name)}", reference)
    base = by_name[reference]
    columns = [column for column in TABLE_METRICS if column not in _left_out(base)]
    flexible = not np.isnan(base.metrics["modal_energy"]).all()
    compared = _error_and_vibration(base, base, chosen) if flexible else None
    rows = []
    for item in evaluations:
        estimates = {column: column_estimate([item], column, chosen) for column in columns}
        differences = {}
        if item.policy != reference:
            differences = {column: column_difference([item], [base], column, chosen) for column in columns}
        if compared is not None:
            own = _error_and_vibration(item, base, chosen)
            estimates[ERROR_AND_VIBRATION] = estimate(own, statistic_of(ERROR_AND_VIBRATION))
            if item.policy != reference:
                differences[ERROR_AND_VIBRATION] = paired_difference(own, compared)
        rows.append(Row(item.policy, estimates, differences, headlines([item])))
    return rows


def _left_out(evaluation: Evaluation) -> set[str]:
    """Return the columns that the scenario of an evaluation does not have."""
    groups = {
        "bound_kept": _BOUND_METRICS,
        "modal_energy": _VIBRATION_METRICS,
        "momentum_headroom": ("momentum_headroom",),
    }
    return {name for key, group in groups.items() if np.isnan(evaluation.metrics[key]).all() for name in group}


def _error_and_vibration(item: Evaluation, base: Evaluation, chosen: npt.NDArray[np.bool_]) -> FloatArray:
    """Return integrated error plus modal energy of the chosen episodes, each over the mean of the reference."""
    parts = [
        item.metrics[name][chosen] / np.mean(base.metrics[name][chosen])
        for name in ("integrated_error", "modal_energy")
    ]
    found: FloatArray = parts[0] + parts[1]
    return found


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
