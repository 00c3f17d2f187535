"""The success against the delay margin, on two short episodes."""

import csv
from dataclasses import replace

import delay_margin as script
import numpy as np
import pytest

from ftac_gym import baselines, scenarios
from ftac_gym.baselines.linear_loop import loop_margins
from ftac_gym.evaluation.statistics import Estimate

FLAGSHIP = scenarios.get("flagship")
TASK = FLAGSHIP.replace(duration=3.0)


@pytest.fixture(scope="module")
def episodes():
    return replace(TASK.draw(0, 2), feasible=np.ones(2, dtype=bool))


@pytest.fixture(scope="module")
def points(episodes):
    return script.measure(TASK, ["pd"], episodes)


def test_every_policy_flies_every_further_delay_with_and_without_isolation(points):
    for policy in ("pd", *script.ROBUST):
        own = [(point.isolation, point.further) for point in points if point.policy == policy]
        assert own == [(isolation, further) for isolation in (False, True) for further in script.FURTHER]
    assert {point.success.count for point in points} == {2}


def test_the_margin_is_that_of_the_linear_loop_without_isolation(points):
    found = loop_margins(baselines.build("pd", TASK, isolation="none")).delay_margin / TASK.control_period
    assert {point.margin for point in points if point.policy == "pd"} == {found}


@pytest.mark.parametrize(("number", "policy"), list(enumerate(script.ROBUST, start=1)))
def test_low_gains_have_the_margin_of_their_name(number, policy):
    assert script.margin_of(FLAGSHIP, "pd_dob", "default", script.ROBUST[policy]) > number
    assert policy.endswith(f"over {number}")


def test_checks_compare_success_within_the_margin():
    def flown(policy, successes, margin):
        return [
            script.Point(policy, False, margin, further, Estimate(value, value, value, 10))
            for further, value in enumerate(successes)
        ]

    names = list(script.ROBUST)
    lines = script.checks(
        [
            *flown(names[0], [0.9, 0.82, 0.0, 0.0], 1.5),
            *flown(names[1], [0.9, 0.9, 0.7, 0.0], 2.5),
            *flown(names[2], [0.9, 0.9, 0.9, 0.9], 2.9),
        ]
    )
    assert [line.endswith("NOT kept") for line in lines] == [False, True, True]


def test_the_program_writes_both_files(tmp_path, monkeypatch, capsys, episodes):
    monkeypatch.setattr(script, "judging_episodes", lambda task, count, kind: episodes)
    monkeypatch.setattr(script.scenarios, "get", lambda name: TASK)
    monkeypatch.setattr(script, "ROBUST", {})
    script.main(script.Config(policies=("pd_dob",), episodes=2, output=tmp_path))
    with (tmp_path / "delay_margin.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["further"] for row in rows] == 2 * [str(further) for further in script.FURTHER]
    assert (tmp_path / "delay_margin.png").read_bytes().startswith(b"\x89PNG")
    assert capsys.readouterr().out.split()[:3] == ["policy", "isolation", "margin"]
