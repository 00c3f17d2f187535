"""One number for each metric, over the episodes of a flight."""

import numpy as np

from ftac_gym.evaluation.metrics.episode import PARTIAL, SHARES, Metrics


def summarize(metrics: Metrics) -> dict[str, float]:
    """Return the mean of shares and the median of every other metric, without NaN."""
    summary = {}
    for name, values in metrics.items():
        known = values[~np.isnan(values)]
        middle = np.mean if name in SHARES else np.median
        summary[name] = float(middle(known)) if known.size else float("nan")
    return summary


def counted(metrics: Metrics) -> dict[str, float]:
    """Return :func:`summarize` with counts: ``episodes``, and ``NAME_defined`` after each partial metric."""
    summary: dict[str, float] = {"episodes": float(len(metrics["return"]))}
    for name, value in summarize(metrics).items():
        summary[name] = value
        if name in PARTIAL:
            summary[f"{name}_defined"] = float((~np.isnan(metrics[name])).sum())
    return summary


def described(metrics: Metrics) -> str:
    """Return :func:`summarize` as a line, with the number of values where a metric is not defined for all episodes."""
    known = {name: int((~np.isnan(values)).sum()) for name, values in metrics.items()}
    return ", ".join(
        f"{'median return' if name == 'return' else name} {value:.4g}{share_of(known[name], metrics[name].size)}"
        for name, value in summarize(metrics).items()
        if known[name]
    )


def share_of(defined: int, total: int) -> str:
    """Return the number of values that a statistic is over, as " (93 of 100)"; nothing if all are defined."""
    return f" ({defined} of {total})" if defined < total else ""
