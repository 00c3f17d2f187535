"""The sweep of the loop delay, on two short episodes."""

import csv
from dataclasses import replace

import delay_sweep as script
import numpy as np
import pytest

from ftac_gym import scenarios
from ftac_gym.evaluation import rollout
from ftac_gym.evaluation.statistics import Estimate
from ftac_gym.policies import DeferredBaseline

TASK = scenarios.get("flagship").replace(duration=4.0, loop_delay=0.1)


@pytest.fixture(scope="module")
def episodes():
    return replace(TASK.draw(0, 2), feasible=np.ones(2, dtype=bool))


@pytest.fixture(scope="module")
def points(episodes):
    return script.sweep(TASK, ["pd", "pd_dob"], [0, 1, 3], episodes)


@pytest.mark.parametrize("delay", range(6))
def test_a_told_delay_is_in_the_scenario(delay):
    task = script.told(TASK, delay)
    assert task.loop_delay == pytest.approx(0.1 * delay) and task.extra_delay == 0


def test_untold_delays_fly_side_by_side(episodes):
    task, late = script.untold(TASK, episodes, [1, 2, 5])
    assert task.loop_delay == 0.1 and task.extra_delay == (0, 4)
    assert late.extra_delay.tolist() == [0, 0, 1, 1, 4, 4]
    np.testing.assert_array_equal(late.faults, np.tile(episodes.faults, (3, 1, 1)))


def test_what_cannot_be_untold_is_refused(episodes):
    with pytest.raises(ValueError, match=r"delays must be at least the usual one if they are untold, got \[0, 2\]"):
        script.untold(TASK, episodes, [0, 2])
    with pytest.raises(ValueError, match=r"loop_delay must be a multiple of the control period, got 0\.06"):
        script.untold(TASK.replace(loop_delay=0.06), episodes, [3])


def test_every_policy_flies_every_delay_told_and_longer_ones_untold(points):
    for policy in ("pd", "pd_dob"):
        found = [(point.delay, point.told) for point in points if point.policy == policy]
        assert found == [(0, True), (1, True), (3, True), (3, False)]
    assert all(point.episodes == 2 and 0.0 <= point.estimates["availability"].value <= 1.0 for point in points)


def test_only_prediction_and_observers_make_use_of_a_told_delay(episodes):
    """Without them the commands are the same; a disturbance observer takes a late command for a torque."""
    untold, told = script.untold(TASK, episodes, [3]), script.told(TASK, 3)
    without = {"prediction": False, "isolation": "none"}
    # The unit of gains is the told delay, so they are given in 1/s.
    gains = [{"rate_gain": 0.8, "position_gain": 0.25}, {"rate_gain": 1.6, "position_gain": 0.5}]
    for name, changes, same in (("pd", without, True), ("pd_dob", without, False), ("pd", {}, False)):
        bandwidths = [{"bandwidth": 0.08}, {"bandwidth": 0.16}] if name == "pd_dob" else [{}, {}]
        few, many = (
            DeferredBaseline(name, **{**gain, **band, **changes}) for gain, band in zip(gains, bandwidths, strict=True)
        )
        commands = rollout(untold[0], few, untold[1]).command
        # L is 0.2 s untold, and 0.4 s told.
        assert np.array_equal(rollout(told, many, episodes).command, commands) is same


def test_points_are_of_their_own_delay(points, episodes):
    """Side by side or alone, an episode is the same."""
    for delay in (1, 3):
        task, late = script.untold(TASK, episodes, [delay])
        expected = rollout(task, "pd_dob", late).metrics()["availability"].mean()
        found = [p for p in points if p.policy == "pd_dob" and p.delay == delay and p.told is (delay == 1)]
        assert [p.estimates["availability"].value for p in found] == pytest.approx([expected])


def test_the_cost_of_a_told_period_is_the_success_that_it_takes():
    def flown(delay, told, success):
        return script.Point("pd", delay, told, 10, {"success": Estimate(success, success, success, 10)})

    points = [flown(1, True, 0.9), flown(2, True, 0.86), flown(2, False, 0.1)]
    assert script.told_cost(points, "pd", 1) == pytest.approx(0.04)
    assert script.told_cost(points, "pd", 2) is None and script.told_cost(points, "lqr", 1) is None


def test_table_and_figure(points):
    rows = script.table(points)
    assert rows[0][:6] == ["policy", "delay", "told", "episodes", "availability", "availability_low"]
    assert [row[0] for row in rows[1:]] == ["pd"] * 4 + ["pd_dob"] * 4 and {len(row) for row in rows} == {10}
    chart = script.drawn(points, 1)
    chart.draw_without_rendering()
    availability, success = chart.axes
    assert [panel.get_title(loc="left") for panel in chart.axes] == ["availability", "success"]
    assert availability.get_xticks().tolist() == [0, 1, 3] and success.get_ylim()[1] >= 1.0


def test_the_program_writes_both_files(tmp_path, monkeypatch, capsys, episodes):
    monkeypatch.setattr(script, "judging_episodes", lambda task, count, kind: episodes)
    monkeypatch.setattr(script.scenarios, "get", lambda name: TASK)
    script.main(script.Config(policies=("pd",), delays=(1, 2), episodes=2, output=tmp_path))
    with (tmp_path / "delay_sweep.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [(row["delay"], row["told"]) for row in rows] == [("1", "yes"), ("2", "yes"), ("2", "no")]
    assert (tmp_path / "delay_sweep.png").read_bytes().startswith(b"\x89PNG")
    assert capsys.readouterr().out.splitlines()[0].split()[:4] == ["policy", "delay", "told", "episodes"]
