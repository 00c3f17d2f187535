"""Error bands: the percentiles are right, one policy or twelve, side by side or together."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from helpers.evaluations import evaluation

from ftac_gym.plots import COLORS, FLOOR, error_bands, error_percentiles

RANDOM = np.random.default_rng(0)
CHOSEN = np.arange(21) % 3 != 0


def evaluations(count):
    errors = [10.0 ** RANDOM.uniform(-5.0, 2.0, (31, 21)).astype(np.float32) for _ in range(count)]
    return [evaluation(f"policy $_{number}", {}, error) for number, error in enumerate(errors)]


def middle(item):
    return np.maximum(np.median(item.attitude_error[:, CHOSEN], axis=1), FLOOR)


def test_percentiles_by_hand():
    error = np.tile(np.arange(101.0), (2, 1))
    np.testing.assert_allclose(error_percentiles(error), [[5.0] * 2, [25.0] * 2, [50.0] * 2, [75.0] * 2, [95.0] * 2])
    assert error_percentiles(np.zeros((3, 4))).max() == FLOOR


@pytest.mark.parametrize("count", [1, 2, 4, 5, 7, 12])
def test_every_policy_has_a_panel_with_its_median_and_bands(count, tmp_path):
    items = evaluations(count)
    figure = error_bands(items, 0.5, 0.1, CHOSEN)
    panels = [panel for panel in figure.axes if panel.get_visible()]
    assert [panel.get_title(loc="left") for panel in panels] == [item.policy for item in items]
    for panel, item in zip(panels, items, strict=True):
        line = next(line for line in panel.lines if line.get_label() == item.policy)
        np.testing.assert_allclose(line.get_ydata(), middle(item), rtol=1e-6)
        np.testing.assert_allclose(line.get_xdata(), 0.5 * np.arange(31))
        outer, inner = (area.get_paths()[0].vertices for area in panel.collections)
        low, quarter, _, three, high = error_percentiles(item.attitude_error[:, CHOSEN])
        for area, below, above in ((outer, low, high), (inner, quarter, three)):
            assert area[:, 1].min() == pytest.approx(below.min()) and area[:, 1].max() == pytest.approx(above.max())
    assert len({panel.get_position().y0.round(3) for panel in panels}) == -(-count // 4)
    figure.savefig(tmp_path / "bands.png", dpi=30)


def test_long_names_do_not_meet():
    items = [replace(item, policy="pd_dob runs/tuning/my_satellite/pd_dob/gains.json") for item in evaluations(4)]
    figure = error_bands(items, 0.5, 0.1, CHOSEN)
    figure.draw_without_rendering()
    boxes = [panel.get_tightbbox() for panel in figure.axes]
    assert all(left.x1 < right.x0 for left, right in pairwise(boxes))


@pytest.mark.parametrize("count", [1, 12])
def test_overlaid_medians_are_those_of_the_policies_and_look_different(count):
    items = evaluations(count)
    (panel,) = error_bands(items, 0.5, 0.1, CHOSEN, overlay=True).axes
    lines = panel.lines[:count]
    for line, item in zip(lines, items, strict=True):
        np.testing.assert_allclose(line.get_ydata(), middle(item), rtol=1e-6)
        assert line.get_color() in COLORS
    # Even in grey: markers and dashes alone tell all apart.
    assert len({(str(line._unscaled_dash_pattern), line.get_marker()) for line in lines}) == count
    assert len(panel.collections) == (count if count <= 6 else 0)


@pytest.mark.parametrize("overlay", [False, True])
def test_the_cone_is_drawn(overlay):
    panel = error_bands(evaluations(2), 0.5, 0.25, CHOSEN, overlay=overlay).axes[0]
    assert any(np.allclose(line.get_ydata(), 0.25) for line in panel.lines)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"evaluations": []}, "evaluations must hold at least one policy"),
        ({"control_period": 0.0}, "control_period must be positive"),
        ({"cone": -1.0}, "cone must be positive"),
        ({"chosen": np.zeros(21, dtype=bool)}, "chosen must choose at least one episode"),
        ({"chosen": np.ones(20, dtype=bool)}, r"chosen must be a boolean array of shape \(21,\)"),
        ({"chosen": np.ones(21)}, r"chosen must be a boolean array of shape \(21,\)"),
    ],
)
def test_refused(changes, message):
    given = {"evaluations": evaluations(1), "control_period": 0.5, "cone": 0.1, "chosen": CHOSEN, **changes}
    with pytest.raises(ValueError, match=message):
        error_bands(**given)


def test_policies_of_other_episodes_are_refused():
    items = [*evaluations(1), evaluation("short", {}, np.ones((30, 21)))]
    with pytest.raises(ValueError, match=r"evaluations must all have an error of shape \(31, 21\), got \(30, 21\)"):
        error_bands(items, 0.5, 0.1, CHOSEN)
