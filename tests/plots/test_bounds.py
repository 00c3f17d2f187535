"""The figure of prescribed bounds shows the errors of every policy and the bounds themselves."""

import numpy as np
import pytest

from ftac_gym import scenarios
from ftac_gym.evaluation import rollout
from ftac_gym.plots import prescribed_bound
from ftac_gym.task.prescribed_bound import PrescribedBound

BOUND = PrescribedBound(initial=1.5, final=0.05, decay=0.1, lower=(1.0, 0.5, 1.0))
TASK = scenarios.get("flagship").replace(duration=20.0, prescribed_bound=BOUND)


def test_policies_and_bounds_are_drawn_axis_by_axis():
    histories = {name: rollout(TASK, name, seed=3) for name in ("pd", "prescribed_performance")}
    figure = prescribed_bound(histories)
    low, high = BOUND.bound(histories["pd"].time)
    panels = figure.axes
    assert len(panels) == 6
    for axis, panel in enumerate(panels[:3]):
        lines = [line.get_ydata() for line in panel.lines]
        assert len(lines) == 4
        for line, history in zip(lines, histories.values(), strict=False):
            np.testing.assert_array_equal(line, history.error_mrp[:, 0, axis])
        np.testing.assert_array_equal(lines[2], low[:, axis])
        np.testing.assert_array_equal(lines[3], high[:, axis])
    for panel in panels[3:]:  # enlarged: the bounds fill half of the panel where it begins
        bottom, top = panel.get_ylim()
        edges = [line.get_ydata()[0] for line in panel.lines[-2:]]
        assert top - bottom == pytest.approx(2.0 * (edges[1] - edges[0]))


def test_without_a_bound_there_is_nothing_to_draw():
    history = rollout(TASK.replace(prescribed_bound=None, duration=1.0), "pd", seed=3)
    with pytest.raises(ValueError, match=r"^prescribed_bound must be given by the scenario, got 'flagship'"):
        prescribed_bound({"pd": history})
