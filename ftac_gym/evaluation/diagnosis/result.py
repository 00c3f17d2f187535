"""Result of a diagnosis: detection, isolation, false alarms and errors of the estimates, with their tables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from ftac_gym.evaluation.diagnosis.alarms import AlarmRule
from ftac_gym.evaluation.diagnosis.detection import Detections
from ftac_gym.evaluation.diagnosis.errors import ERROR_UNITS, SquaredErrors
from ftac_gym.evaluation.intervals import rate_of_count, share_of_count, survival
from ftac_gym.evaluation.statistics import Estimate
from ftac_gym.evaluation.tables import Cells, markdown, short
from ftac_gym.faults import label_of
from ftac_gym.utils.parameters import FloatArray

HOUR = 3600.0

MEASURES = {
    "detected": "share",
    "detection_delay": "s",
    "isolated": "share",
    "false_alarms": "1/h",
    "false_alarm_time": "share",
    **{f"{part}_error": unit for part, unit in ERROR_UNITS.items()},
}
"""Unit of each measure, in the order of tables."""


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """Diagnosis of faults by a policy over N episodes.

    Attributes
    ----------
    policy
        Name of the policy.
    rule
        Thresholds of the alarms; of an estimator with alarms of its own the grace period alone.
    names_wheels
        Whether the estimator can name a wheel.
    detections
        :data:`~ftac_gym.evaluation.diagnosis.detection.DETECTION` records (F,) of all faults of wheels.
    false_alarms
        (N,) alarms of each episode that began while no fault acted.
    healthy_time, alarm_time
        (N,) time of each episode without a fault, and the part of it in alarm [s].
    errors
        Sums of squared errors of the episodes by part; see
        :func:`~ftac_gym.evaluation.diagnosis.errors.squared_errors`.
    """

    policy: str
    rule: AlarmRule
    names_wheels: bool
    detections: Detections
    false_alarms: npt.NDArray[np.int64]
    healthy_time: FloatArray
    alarm_time: FloatArray
    errors: Mapping[str, SquaredErrors]

    def estimates(self, kind: int | None = None) -> dict[str, Estimate]:
        """Return the measures by name, those of :data:`MEASURES` that the estimator has.

        ==================== ==========================================================================================
        ``detected``         share of the faults with a new alarm before they end
        ``detection_delay``  median time from the onset to that alarm, with missed faults as censored (Kaplan-Meier)
        ``isolated``         share of the detected faults whose alarms name the right wheel
        ``false_alarms``     alarms that begin while no fault acts, per hour without faults
        ``false_alarm_time`` share of the time without faults in which there is an alarm
        ``NAME_error``       root mean square error of the estimates, over all values that can be identified
        ==================== ==========================================================================================

        Shares have Wilson's interval, the rate the exact one of Poisson; the last two have no interval.

        Parameters
        ----------
        kind
            Kind of the faults; all of them by default. False alarms and errors belong to no kind.
        """
        found = self.detections if kind is None else self.detections[self.detections["kind"] == kind]
        seen = ~np.isnan(found["delay"])
        right = int((seen & (found["named"] == found["wheel"])).sum())
        times = np.where(seen, found["delay"], found["watched"])
        measures = {
            "detected": share_of_count(int(seen.sum()), len(found)),
            "detection_delay": survival(times, seen).median,
        }
        if self.names_wheels:
            measures["isolated"] = share_of_count(right, int(seen.sum()))
        if kind is not None:
            return measures
        healthy = float(self.healthy_time.sum())
        measures["false_alarms"] = rate_of_count(int(self.false_alarms.sum()), healthy / HOUR)
        measures["false_alarm_time"] = _plain(float(self.alarm_time.sum()), healthy)
        for part, sums in self.errors.items():
            mean = _plain(float(sums.estimated.sum()), float(sums.number.sum()))
            root = float(np.sqrt(mean.value))
            measures[f"{part}_error"] = replace(mean, value=root)
        return measures

    @property
    def healthy_errors(self) -> dict[str, float]:
        """Root mean square of the same errors, if every wheel were taken for healthy."""
        return {
            part: float(np.sqrt(_plain(float(sums.healthy.sum()), float(sums.number.sum())).value))
            for part, sums in self.errors.items()
        }

    @property
    def kinds(self) -> list[int]:
        """Kinds of the faults in ascending order."""
        return sorted(set(self.detections["kind"].tolist()))

    def _repr_markdown_(self) -> str:
        return "\n\n".join(markdown(cells) for cells in (diagnosis_table([self]), kinds_table([self])))

    def __str__(self) -> str:
        """Return the tables as Markdown."""
        return self._repr_markdown_()


def _plain(part: float, whole: float) -> Estimate:
    """Return a ratio without an interval; its count is the whole, rounded."""
    unknown = float("nan")
    return Estimate(part / whole if whole > 0.0 else unknown, unknown, unknown, *(round(whole),) * 3)


def diagnosis_table(diagnoses: Sequence[Diagnosis]) -> Cells:
    """Return the measures of policies with their intervals and counts: measures down, policies across.

    The counts are those of the faults, of the false alarms and the hours, and of the values of an error. Beside an
    error stands that of taking every wheel for healthy. A median delay is "never" if half of the faults are missed.
    """
    cells = [["measure", *(item.policy for item in diagnoses)]]
    for name, unit in MEASURES.items():
        cells.append([f"{name.replace('_', ' ')} [{unit}]", *(_cell(name, item) for item in diagnoses)])
    return [row for row in cells if any(cell != "-" for cell in row[1:])]


def kinds_table(diagnoses: Sequence[Diagnosis]) -> Cells:
    """Return detection, its median delay where there is one, and isolation by the kind of the fault."""
    cells = [["fault", "faults", *(item.policy for item in diagnoses)]]
    for kind in diagnoses[0].kinds if diagnoses else []:
        measures = [item.estimates(kind) for item in diagnoses]
        row = [label_of(kind), str(measures[0]["detected"].total)]
        for found in measures:
            isolated = found.get("isolated")
            named = "" if isolated is None or not isolated.total else f", {_share(isolated)} isolated"
            delay = found["detection_delay"].value
            median = "" if np.isinf(delay) else f", {short(delay)} s"
            row.append(f"{_share(found['detected'])}{median}{named}")
        cells.append(row)
    return cells


def diagnosis_rows(diagnoses: Sequence[Diagnosis]) -> list[list[Any]]:
    """Return rows for a CSV file, headings first: every measure of every policy, for all faults and by kind.

    Values that are not defined are empty; a median delay that is not reached is ``inf``.
    """
    rows: list[list[Any]] = [["policy", "faults", "measure", "unit", "value", "low", "high", "defined", "total"]]
    for item in diagnoses:
        groups = {"all": item.estimates(), **{label_of(kind): item.estimates(kind) for kind in item.kinds}}
        for faults, measures in groups.items():
            for name, value in measures.items():
                numbers = [
                    "" if np.isnan(number) else f"{number:.6g}" for number in (value.value, value.low, value.high)
                ]
                rows.append([item.policy, faults, name, MEASURES[name], *numbers, value.defined, value.total])
    return rows


def detection_rows(diagnoses: Sequence[Diagnosis]) -> list[list[Any]]:
    """Return rows for a CSV file, headings first: one for each fault and policy."""
    rows: list[list[Any]] = [["policy", "episode", "fault", "wheel", "onset", "watched", "delay", "named"]]
    for item in diagnoses:
        for fault in item.detections:
            values = ["" if np.isnan(fault[name]) else f"{fault[name]:.6g}" for name in ("onset", "watched", "delay")]
            rows.append(
                [item.policy, fault["episode"], label_of(int(fault["kind"])), fault["wheel"], *values, fault["named"]]
            )
    return rows


def _cell(name: str, item: Diagnosis) -> str:
    """Return a measure of a policy as text, "-" for one that its estimator does not have."""
    measure = item.estimates().get(name)
    if measure is None or np.isnan(measure.value):
        return "-"
    interval = f"[{short(measure.low)}, {short(measure.high)}]"
    hours = item.healthy_time.sum() / HOUR
    if name == "detection_delay":
        ends = f"[{_time(measure.low)}, {_time(measure.high)}]"
        return f"{_time(measure.value)} {ends} ({measure.defined} detected)"
    if name == "false_alarms":
        return f"{short(measure.value)} {interval} ({measure.count} in {short(hours)} h)"
    if name == "false_alarm_time":
        return f"{short(measure.value)} ({short(hours)} h)"
    if name.endswith("_error"):
        healthy = item.healthy_errors[name.removesuffix("_error")]
        return f"{short(measure.value)}, healthy {short(healthy)} ({measure.count} values)"
    return f"{short(measure.value)} {interval} ({measure.total})"


def _share(value: Estimate) -> str:
    return f"{round(value.value * value.total)} of {value.total}" if value.total else "0 of 0"


def _time(value: float) -> str:
    """Return a time as text: "never" for one that more than half of the faults exceed."""
    return "never" if np.isinf(value) else short(value)
