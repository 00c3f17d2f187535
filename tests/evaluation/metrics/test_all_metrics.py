"""All metrics together: units, summaries, and episodes that do not mix."""

import dataclasses

import numpy as np
import pytest
from helpers.histories import FLAGSHIP, STEPS, WHEELS, history, one

from ftac_gym.evaluation import Rollout, episode_metrics, rollout, summarize
from ftac_gym.evaluation.metrics import HIGHER_IS_BETTER, PARTIAL, SHARES, UNITS, counted
from ftac_gym.task.initial_state import InitialState


def test_return():
    assert one("return", reward=np.arange(STEPS)[:, None]) == pytest.approx(np.arange(STEPS).sum())


def test_every_metric_has_a_unit():
    metrics = episode_metrics(history(count=3))
    assert list(metrics) == list(UNITS)
    assert set(UNITS) >= HIGHER_IS_BETTER | SHARES | PARTIAL
    assert all(values.shape == (3,) and values.dtype == np.float64 for values in metrics.values())


def test_spacecraft_do_not_mix():
    """The metrics of many episodes are those of each."""
    random = np.random.default_rng(0)
    error = np.abs(random.normal(size=(STEPS + 1, 6))) * np.linspace(30.0, 0.1, STEPS + 1)[:, None]
    together = history(
        error=error, rate_error=error * 1e-3, command=random.normal(size=(STEPS, 6, WHEELS)), onset=[3.0], count=6,
        torque=random.normal(size=(STEPS, 6, WHEELS)), reward=random.normal(size=(STEPS, 6)),
    )  # fmt: skip
    metrics = episode_metrics(together)
    for spacecraft in range(6):
        parts = {
            item.name: getattr(together, item.name)[:, spacecraft : spacecraft + 1]
            for item in dataclasses.fields(Rollout)
            if item.name not in ("scenario", "episodes", "time") and getattr(together, item.name) is not None
        }
        alone = episode_metrics(dataclasses.replace(together, episodes=together.episodes[spacecraft], **parts))
        for name, values in metrics.items():
            np.testing.assert_allclose(alone[name], values[spacecraft : spacecraft + 1], rtol=1e-12, err_msg=name)


def test_summary():
    summary = summarize({"success": np.array([1.0, 0.0, 0.0, 1.0]), "energy": np.array([1.0, np.nan, 100.0, 2.0])})
    assert summary == {"success": 0.5, "energy": 2.0}
    assert np.isnan(summarize({"peak_after_fault": np.array([np.nan])})["peak_after_fault"])


def test_a_summary_counts_the_episodes_of_metrics_that_not_all_define():
    scenario = FLAGSHIP.replace(duration=30.0, initial_state=InitialState(angle=(0.0, 0.05), max_rate=0.0))
    metrics = rollout(scenario, "pd_dob", scenario.draw(3, 12)).metrics()
    counts = {name: int((~np.isnan(values)).sum()) for name, values in metrics.items()}
    # Any other metric is defined for all episodes of a task, or for none.
    assert {name for name, count in counts.items() if 0 < count < 12} == PARTIAL
    summary = counted(metrics)
    assert summary["episodes"] == 12
    assert summary.items() >= {name: value for name, value in summarize(metrics).items() if counts[name]}.items()
    assert {name: summary[f"{name}_defined"] for name in PARTIAL} == {name: counts[name] for name in PARTIAL}
