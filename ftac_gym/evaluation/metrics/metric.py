"""A metric as data: one value for each episode."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Metric:
    """Name and properties of a metric.

    Attributes
    ----------
    name, unit
        Name and unit.
    higher_is_better
        Whether larger values are better.
    share
        Whether the mean is a share itself, of time or of episodes. Tables show the mean of shares, and robust
        statistics of other metrics.
    partial
        Whether it is defined for some episodes of a task and not for others: a count belongs beside it.
    """

    name: str
    unit: str
    higher_is_better: bool = False
    share: bool = False
    partial: bool = False
