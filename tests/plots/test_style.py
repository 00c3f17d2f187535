"""The style: series that the colour-blind and grey printers can tell apart, and figures that touch nothing else."""

import copy
from itertools import pairwise

import matplotlib
import numpy as np
import pytest
from helpers.evaluations import evaluation
from matplotlib.colors import to_rgb

from ftac_gym import scenarios
from ftac_gym.evaluation import rollout
from ftac_gym.faults import Bias, FaultSchedule, LossOfEffectiveness
from ftac_gym.plots import (
    COLORS,
    boresight_paths,
    episode,
    error_bands,
    estimates_along,
    fault_estimates,
    stroke,
    torque_estimates,
    torque_polytope,
    wheel_envelope,
)
from ftac_gym.plots.style import wrapped

# Linear RGB as the three kinds of dichromats see it (Machado, Oliveira and Fernandes 2009, severity 1).
BLINDNESS = {
    "protan": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "deutan": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
    "tritan": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
}


def lab(linear):
    """CIELAB of linear sRGB, (n, 3)."""
    to_xyz = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
    ratio = linear @ to_xyz.T / np.array([0.9505, 1.0, 1.089])
    cube = np.where(ratio > 0.008856, np.cbrt(np.maximum(ratio, 0.0)), 7.787 * ratio + 16.0 / 116.0)
    x, y, z = cube.T
    return np.stack([116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)], axis=1)


def nearest(colors):
    """The smallest distance between two of some colours."""
    distances = np.linalg.norm(colors[:, None] - colors[None], axis=2)
    return distances[~np.eye(len(colors), dtype=bool)].min()


@pytest.mark.parametrize("kind", BLINDNESS)
def test_the_colour_blind_can_tell_the_colours_apart(kind):
    coded = np.array([to_rgb(color) for color in COLORS])
    linear = np.where(coded <= 0.04045, coded / 12.92, ((coded + 0.055) / 1.055) ** 2.4)
    seen = np.clip(linear @ np.array(BLINDNESS[kind]).T, 0.0, 1.0)
    assert nearest(lab(seen)) > 10.0
    # The test can tell: pure red and green of like lightness are one colour to most of them.
    if kind == "deutan":
        pair = np.array([[0.42, 0.02, 0.02], [0.06, 0.235, 0.02]])
        assert nearest(lab(pair)) > 40.0 > 20.0 > nearest(lab(np.clip(pair @ np.array(BLINDNESS[kind]).T, 0.0, 1.0)))


def test_strokes_differ():
    strokes = [stroke(number) for number in range(28)]
    assert len({(look.color, str(look.line)) for look in strokes}) == 28
    for first, second in pairwise(strokes):
        assert first.color != second.color and first.line != second.line and first.marker != second.marker


def test_lists_are_wrapped_between_their_entries():
    words = "wheel 0: bias at 1.0 s; wheel 1: outage at 12.0 s; gyro bias step at 3.0 s"
    lines = wrapped(words, 30).split("\n")
    assert " ".join(lines) == words and len(lines) == 3
    assert all(line.endswith((" s;", " s")) for line in lines)
    assert wrapped(words, 500) == words


def test_figures_leave_settings_and_random_numbers_alone(tmp_path):
    faults = FaultSchedule((LossOfEffectiveness(wheel=1, onset=2.0), Bias(wheel=2, onset=3.0, constant=0.05)))
    history = rollout(scenarios.get("flagship").replace(duration=6.0, faults=faults), "nftsm_observer", seed=1)
    estimates = {"asmo": estimates_along(history, "nftsm_observer")}
    error = np.degrees(history.attitude_error).astype(np.float32)
    settings, state = copy.deepcopy(dict(matplotlib.rcParams)), copy.deepcopy(np.random.get_state())  # noqa: NPY002
    figures = [
        episode({"a": history}),
        error_bands([evaluation("a", {}, error)], 0.1, 0.1, np.array([True])),
        error_bands([evaluation("a", {}, error)], 0.1, 0.1, np.array([True]), overlay=True),
        fault_estimates(estimates),
        torque_estimates(estimates),
        wheel_envelope({"healthy": torque_polytope(history.scenario.spacecraft.wheels)}),
        boresight_paths({"a": history}),
    ]
    for number, figure in enumerate(figures):
        figure.savefig(tmp_path / f"{number}.png", dpi=30)
        for panel in figure.axes:
            if panel.axison and panel.get_visible():
                assert labelled(panel, "x") and labelled(panel, "y"), (number, panel.get_title(loc="left"))
    assert dict(matplotlib.rcParams) == settings
    after = np.random.get_state()  # noqa: NPY002
    assert all(np.array_equal(old, new) for old, new in zip(state, after, strict=True))


def labelled(panel, name):
    """Return True if an axis has a label with a unit, its own or that of another panel in its column or row."""
    edge = {"x": "x0", "y": "y0"}[name]
    place = getattr(panel.get_position(), edge)
    line = [other for other in panel.figure.axes if abs(getattr(other.get_position(), edge) - place) < 0.02]
    return any("[" in getattr(other, f"{name}axis").get_label_text() for other in line)
