"""Isolation of faulty wheels by the multiple-model estimator: right wheel, right kind, and false alarms.

    python benchmarks/isolation.py                                  # prints, and writes docs/isolation_confusion.png
    python benchmarks/isolation.py --scenario flagship_hardware --faults scenario --output results

Every episode has one faulty wheel. Its torque counts once it differs from its command by five standard deviations of
the estimator's residual along the axis of the wheel. The first wheel that is declared faulty up to five seconds later
is the one that is named. The kind is that of ten seconds after the alarm, or of the end of the fault; a wheel that is
locked without torque is out. The episodes are the script's own: no frozen list has them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ftac_gym import Simulator, baselines, scenarios
from ftac_gym.baselines import observers
from ftac_gym.baselines.estimate import WheelCondition
from ftac_gym.baselines.estimators.wheel_kernel import CONSTANT
from ftac_gym.baselines.memory import Memory
from ftac_gym.evaluation.files import write_figure
from ftac_gym.evaluation.intervals import rate_of_count, share_of_count
from ftac_gym.evaluation.statistics import Estimate
from ftac_gym.faults import (
    Bias,
    CommandDelay,
    FaultDistribution,
    FaultKind,
    HardOver,
    LockInPlace,
    LossOfEffectiveness,
    Outage,
)
from ftac_gym.plots import style
from ftac_gym.scenarios.flagship import ONSET
from ftac_gym.task import Episodes, Scenario
from ftac_gym.utils.console import run_program
from ftac_gym.utils.parameters import FloatArray, require

OBSERVERS = {"rate": "multiple_model", "telemetry": "multiple_model_telemetry"}
"""The estimator in both tiers of information."""

SIGMAS, WITHIN, SETTLED = 5.0, 5.0, 10.0
"""Excess torque that counts, in standard deviations; time in which the wheel is to be named [s]; time from the alarm
after which the kind is read [s]."""

NONE = -1
"""Wheel that is named where none is."""

TRUE_CONDITION = {
    FaultKind.LOSS_OF_EFFECTIVENESS: WheelCondition.EFFECTIVENESS,
    FaultKind.DRIFTING_EFFECTIVENESS: WheelCondition.EFFECTIVENESS,
    FaultKind.BIAS: WheelCondition.BIAS,
    FaultKind.FRICTION_RISE: WheelCondition.BIAS,
    FaultKind.SEIZURE: WheelCondition.LOCK,
    FaultKind.LOCK_IN_PLACE: WheelCondition.LOCK,
    FaultKind.HARD_OVER: WheelCondition.LOCK,
    FaultKind.OUTAGE: WheelCondition.OUTAGE,
    FaultKind.INTERMITTENT_SHUTDOWN: WheelCondition.OUTAGE,
    FaultKind.COMMAND_DELAY: WheelCondition.DELAY,
}
"""The condition that a fault of each kind is."""

KINDS = tuple(condition for condition in WheelCondition if condition not in (0, WheelCondition.UNKNOWN))
"""Conditions that a fault can be."""


@dataclass(frozen=True)
class Config:
    """Episodes and policy."""

    scenario: str = "flagship"
    """Scenario whose spacecraft flies."""
    faults: str = "kinds"
    """``kinds`` for one of the estimator's kinds, each as often; ``scenario`` for those of the scenario."""
    policy: str = "pd_dob"
    """Baseline in the loop, with tuned gains where there are any."""
    episodes: int = 1000
    """Episodes with a faulty wheel."""
    healthy: int = 1500
    """Healthy episodes."""
    seed: int = 20262
    """Seed of the episodes."""
    output: Path = Path(__file__).parents[1] / "docs"
    """Folder of the figure."""


@dataclass(frozen=True, eq=False)
class Watch:
    """Conditions by the estimator, and true torques, along a flight of T control periods of N spacecraft with m wheels.

    Attributes
    ----------
    condition
        (T, N, m) condition of each wheel.
    sigmas
        (T, N, m) true torque of each wheel beyond its command, in standard deviations of the residual.
    torque
        (T, N, m) true torque of each wheel over its limit.
    """

    condition: npt.NDArray[np.int64]
    sigmas: FloatArray
    torque: FloatArray


FOUND = np.dtype([("kind", "i8"), ("wheel", "i8"), ("named", "i8"), ("delay", "f8"), ("condition", "i8")])
"""One fault whose torque counts: its condition and wheel; the wheel that is named; the time until then [s], NaN for
none; the condition of the faulty wheel by the estimator."""


def one_of_each_kind() -> FaultDistribution:
    """Return faults of the estimator's kinds: every episode has one of them, and each kind is as frequent."""
    kinds = (
        LossOfEffectiveness(onset=ONSET, effectiveness=(0.1, 0.8)),
        Bias(onset=ONSET, constant=(0.01, 0.1), random_sign=True),
        LockInPlace(onset=ONSET),
        HardOver(onset=ONSET, fraction=(0.2, 0.5)),
        Outage(onset=ONSET),
        CommandDelay(onset=ONSET),
    )
    return FaultDistribution(kinds, weights=(1.0, 1.0, 0.5, 0.5, 1.0, 1.0), fault_counts=(0.0, 1.0))


def watch(task: Scenario, episodes: Episodes, policy: str, observer: str) -> Watch:
    """Fly a baseline through episodes, and return what an estimator beside it says."""
    count, period = len(episodes), task.control_period
    simulator, memory = Simulator(task, count), Memory(count)
    simulator.reset(episodes)
    estimator = observers.make(observer, task, memory)
    gains = "tuned" if policy in baselines.tuned.names() else "default"
    baseline = baselines.make(policy, task, count, gains=gains)
    condition, sigmas, torques = [], [], []
    momentum = simulator.state.wheel_momentum.copy()
    for _ in range(task.horizon):
        measurement = simulator.measurement()
        estimate = estimator.update(measurement, measurement.last_command, period)
        torque = (momentum - simulator.state.wheel_momentum) / period
        momentum = simulator.state.wheel_momentum.copy()
        assert estimate.condition is not None
        condition.append(estimate.condition)
        information = memory["wheels"]["information"]
        sigmas.append((torque - measurement.command_in_effect) * np.sqrt(information))
        torques.append(torque / task.spacecraft.wheels.torque_limits)
        simulator.step(baseline.act(measurement))
    return Watch(np.array(condition), np.array(sigmas), np.array(torques))


def found_faults(seen: Watch, episodes: Episodes, period: float) -> npt.NDArray[np.void]:
    """Return a FOUND record for each fault whose torque counts, of episodes with one fault.

    Parameters
    ----------
    seen
        What the estimator says.
    episodes
        The episodes.
    period
        Control period [s].
    """
    steps, records = len(seen.condition), []
    for n, wheel, layer in zip(*np.nonzero(episodes.faults["kind"] > 0), strict=True):
        fault = episodes.faults[n, wheel, layer]
        onset = int(np.ceil(fault["onset"] / period - 1e-9))
        end = int(min(np.ceil(fault["recovery"] / period - 1e-9), steps)) if fault["recovery"] < np.inf else steps
        counts = np.flatnonzero(np.abs(seen.sigmas[onset:end, n, wheel]) > SIGMAS)
        # Faults in the last seconds are not followed to their end.
        if not counts.size or onset + counts[0] + round(WITHIN / period) >= steps:
            continue
        first = onset + int(counts[0])
        alarm = seen.condition[:, n] > 0
        new = alarm[onset : first + round(WITHIN / period) + 1] & ~alarm[max(onset - 1, 0)]
        named, delay, row = NONE, np.nan, first + round(WITHIN / period)
        if new.any():
            begun = int(new.any(axis=1).argmax())
            # Of two in the same period the right one counts.
            named = int(wheel) if new[begun, wheel] else int(new[begun].argmax())
            delay, row = max(onset + begun - first, 0) * period, onset + begun
        read = min(max(min(row + round(SETTLED / period), end - 1), row), steps - 1)
        kind = TRUE_CONDITION[FaultKind(int(fault["kind"]))]
        if kind == WheelCondition.LOCK and abs(seen.torque[read, n, wheel]) < CONSTANT:
            kind = WheelCondition.OUTAGE
        records.append((kind, wheel, named, delay, seen.condition[read, n, wheel]))
    return np.array(records, dtype=FOUND)


def _share(cases: npt.NDArray[np.bool_]) -> Estimate:
    return share_of_count(int(cases.sum()), len(cases))


def right_wheel(found: npt.NDArray[np.void]) -> dict[str, Estimate]:
    """Return the share of faults whose wheel is named in time, with Wilson's interval: of all, and by kind."""
    right = found["named"] == found["wheel"]
    groups = {"all": np.ones(len(found), dtype=np.bool_)}
    groups |= {kind.name.lower(): found["kind"] == kind for kind in KINDS}
    return {name: _share(right[group]) for name, group in groups.items() if group.any()}


def right_kind(found: npt.NDArray[np.void]) -> dict[str, tuple[Estimate, Estimate]]:
    """Return by kind the shares of named wheels with the right kind, and with a wrong one; the rest is unknown."""
    shares = {}
    for kind in KINDS:
        named = found[(found["kind"] == kind) & (found["named"] == found["wheel"])]
        wrong = ~np.isin(named["condition"], (kind, WheelCondition.UNKNOWN, WheelCondition.HEALTHY))
        if len(named):
            shares[kind.name.lower()] = _share(named["condition"] == kind), _share(wrong)
    return shares


def false_alarms(seen: Watch, period: float) -> Estimate:
    """Return the alarms per hour of healthy flights, with the exact interval of Poisson."""
    alarm = np.any(seen.condition > 0, axis=2)
    begun = np.diff(alarm.astype(np.int64), axis=0, prepend=0) > 0
    return rate_of_count(int(begun.sum()), alarm.size * period / 3600.0)


def confusion(found: npt.NDArray[np.void], wheels: int) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Return numbers of faults: true kind (5) by condition (7), true wheel (m) by named one, last none (m + 1)."""
    kinds = np.zeros((len(KINDS), len(WheelCondition)), dtype=np.int64)
    named = np.zeros((wheels, wheels + 1), dtype=np.int64)
    for record in found:
        kinds[KINDS.index(record["kind"]), record["condition"]] += 1
        named[record["wheel"], record["named"]] += 1
    return kinds, named


def drawn(found: dict[str, npt.NDArray[np.void]], wheels: int) -> Figure:
    """Draw both confusion matrices of each tier, in percent of their rows, with counts."""
    chart = style.figure(10.5, 3.9 * len(found))
    panels = chart.subplots(len(found), 2, squeeze=False, width_ratios=(1.45, 1.0))
    true = [kind.name.lower() for kind in KINDS]
    said = ["healthy", *true, "not\nidentifiable"]
    numbers = [str(wheel) for wheel in range(wheels)]
    for row, (tier, records) in zip(panels, found.items(), strict=True):
        kinds, named = confusion(records, wheels)
        _matrix(row[0], kinds, true, said, f"kind, from {tier}", "true kind", "ten seconds after the alarm")
        _matrix(row[1], named, numbers, [*numbers, "none"], f"wheel, from {tier}", "faulty wheel", "wheel named in 5 s")
    return chart


def _matrix(
    panel: Axes,
    counts: npt.NDArray[np.int64],
    rows: Sequence[str],
    columns: Sequence[str],
    title: str,
    down: str,
    across: str,
) -> None:
    shares = counts / np.maximum(counts.sum(axis=1, keepdims=True), 1)
    panel.imshow(shares, cmap="Blues", vmin=0.0, vmax=1.0, aspect="auto")
    for (i, k), number in np.ndenumerate(counts):
        color = "white" if shares[i, k] > 0.55 else style.INK
        text = f"{100.0 * shares[i, k]:.0f} %\n{number}" if number else "0"
        panel.text(k, i, text, ha="center", va="center", fontsize=8.5, color=color if number else style.FAINT)
    style.apply(panel, title, across, down)
    panel.grid(visible=False)
    panel.set_xticks(range(len(columns)), columns)
    panel.set_yticks(range(len(rows)), rows)


def _text(estimate: Estimate, unit: float = 1.0) -> str:
    return f"{unit * estimate.value:.3g} [{unit * estimate.low:.3g}, {unit * estimate.high:.3g}]"


def main(config: Config) -> None:
    """Fly, print and draw."""
    known = config.faults in ("kinds", "scenario")
    require(known, "faults", "must be 'kinds' or 'scenario'", config.faults)
    task = scenarios.get(config.scenario)
    faulty = task.replace(faults=one_of_each_kind()) if config.faults == "kinds" else task
    healthy = task.replace(faults=None)
    found = {}
    for tier, observer in OBSERVERS.items():
        calm = watch(healthy, healthy.draw(config.seed, config.healthy), config.policy, observer)
        rate = false_alarms(calm, task.control_period)
        hours = calm.condition.shape[0] * config.healthy * task.control_period / 3600.0
        print(f"{tier}: false alarms per ten healthy hours {_text(rate, 10.0)}, of {hours:g} h")
        episodes = faulty.draw(config.seed + 1, config.episodes)
        found[tier] = found_faults(watch(faulty, episodes, config.policy, observer), episodes, task.control_period)
        for name, estimate in right_wheel(found[tier]).items():
            print(f"  {name}: right wheel within {WITHIN:g} s {_text(estimate, 100.0)} % of {estimate.total}")
        for name, (right, wrong) in right_kind(found[tier]).items():
            print(f"  {name}: right kind {_text(right, 100.0)} %, wrong kind {_text(wrong, 100.0)} % of {right.total}")
    write_figure(config.output / "isolation_confusion.png", drawn(found, task.spacecraft.wheels.count), 110)


if __name__ == "__main__":
    run_program(main, Config, __doc__)
