"""The overview of an episode draws the rollout, on any spacecraft."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from ftac_gym import scenarios
from ftac_gym.evaluation import rollout
from ftac_gym.faults import Bias, FaultSchedule, GyroBiasStep, LockInPlace, Outage
from ftac_gym.plots import FLOOR, episode, fault_description, true_effect
from ftac_gym.spacecraft.layouts import pyramid

FAULTS = FaultSchedule(
    (Bias(wheel=2, onset=1.0, constant=0.05), Outage(wheel=0, onset=2.0), LockInPlace(wheel=1, onset=3.0),
     GyroBiasStep(onset=2.5))
)  # fmt: skip


def scenario_of(count=4, name="flagship"):
    scenario = scenarios.get(name)
    if count != scenario.spacecraft.wheels.count:
        axes = pyramid(0.6, count)
        wheels = replace(scenario.spacecraft.wheels, axes=axes, torque_limit=0.2, momentum_limit=12.0)
        scenario = scenario.replace(spacecraft=replace(scenario.spacecraft, wheels=wheels))
    return scenario.replace(duration=5.0, faults=FAULTS)


def test_long_names_do_not_meet():
    history = rollout(scenario_of(), "pd", seed=3)
    names = [f"pd_dob runs/tuning/my_satellite/{number}/gains.json" for number in range(3)]
    figure = episode(dict.fromkeys(names, history))
    figure.draw_without_rendering()
    boxes = [panel.get_tightbbox() for panel in figure.axes if "json" in panel.get_title(loc="left")]
    assert len(boxes) == 3 and all(left.x1 < right.x0 for left, right in pairwise(boxes))


def data(panel):
    return [line.get_ydata() for line in panel.lines]


@pytest.mark.parametrize(("count", "name"), [(3, "flagship"), (4, "flexible"), (8, "flagship_tracking")])
def test_what_is_drawn_is_what_was_flown(count, name, tmp_path):
    histories = {policy: rollout(scenario_of(count, name), policy, seed=3) for policy in ("pd", "pd_dob")}
    figure = episode(histories)
    flexible = name == "flexible"
    wide, narrow = (figure.axes[:3], figure.axes[3:]) if flexible else (figure.axes[:2], figure.axes[2:])
    for number, history in enumerate(histories.values()):
        np.testing.assert_array_equal(
            data(wide[0])[number], np.maximum(np.degrees(history.attitude_error[:, 0]), FLOOR)
        )
        np.testing.assert_array_equal(data(wide[1])[number], np.maximum(np.degrees(history.rate_error[:, 0]), FLOOR))
        if flexible:
            np.testing.assert_array_equal(data(wide[2])[number], np.maximum(history.modal_energy[:, 0], 1e-12))
        torque, momentum, effectiveness, bias = narrow[4 * number : 4 * number + 4]
        effect = true_effect(history)
        drawn = ((torque, history.applied_torque[:, 0]), (momentum, history.wheel_momentum[:, 0]),
                 (effectiveness, effect.effectiveness), (bias, effect.bias))  # fmt: skip
        for panel, values in drawn:
            np.testing.assert_array_equal(np.array(data(panel)[:count]).T, values)
    words = " ".join(wide[0].get_title(loc="left").split())
    assert words == fault_description(history.episodes)
    assert "wheel 2: bias at 1.0 s" in words and "gyro bias step at 2.5 s" in words
    legends = [text.get_text() for legend in figure.legends for text in legend.get_texts()]
    assert legends == [*histories, *(f"wheel {wheel}" for wheel in range(count))]
    figure.savefig(tmp_path / "episode.png", dpi=30)


def test_the_true_effect_is_that_of_the_faults():
    history = rollout(scenario_of(), "pd_dob", seed=3)
    effect, time = true_effect(history), history.time
    np.testing.assert_array_equal(effect.effectiveness[:, 0], np.where(time < 2.0 - 1e-9, 1.0, 0.0))
    np.testing.assert_array_equal(effect.bias[:, 2], np.where(time < 1.0 - 1e-9, 0.0, 0.05))
    # A locked wheel keeps the torque that it had.
    locked = effect.bias[time > 3.2, 1]
    assert np.ptp(locked) < 1e-12 and locked[0] == pytest.approx(history.applied_torque[31, 0, 1])


def test_limits_are_drawn_where_wheels_come_near_them():
    busy = episode({"pd": rollout(scenario_of(), "pd", seed=3)})
    torque, momentum = busy.axes[2:4]
    assert {0.2, -0.2} <= {float(line.get_ydata()[0]) for line in torque.lines if len(set(line.get_ydata())) == 1}
    assert momentum.get_ylim()[1] < 12.0


def test_healthy_episodes_have_a_description():
    history = rollout(scenario_of().replace(faults=None), "pd", seed=0)
    assert fault_description(history.episodes) == "healthy" == fault_description(history.episodes, 0)


def test_what_does_not_fit_is_refused():
    with pytest.raises(ValueError, match="histories must hold at least one rollout"):
        episode({})
    first, longer = (rollout(scenario_of().replace(duration=length), "pd", seed=3) for length in (5.0, 6.0))
    with pytest.raises(ValueError, match="histories must all have the same times"):
        episode({"a": first, "b": longer})
    with pytest.raises(ValueError, match="the same number of wheels, got 'b'"):
        episode({"a": first, "b": rollout(scenario_of(5), "pd", seed=3)})
