"""Frozen test episodes: the ones on file, every time, or an error."""

import json
from importlib import resources

import numpy as np
import pytest

from ftac_gym import scenarios
from ftac_gym.scenarios import SPLITS, frozen

LISTS = json.loads(resources.files(scenarios).joinpath("frozen.json").read_text())


@pytest.mark.parametrize("split", SPLITS)
def test_the_lists_on_file_are_what_is_drawn(split):
    episodes = frozen.load(split)
    assert episodes.digest() == LISTS[split]["digest"] and len(episodes) == LISTS[split]["count"]
    assert episodes.feasible.sum() == frozen.FEASIBLE and episodes.feasible[-1]
    assert episodes.scenario_json == scenarios.get(split).to_json()


def test_every_split_has_a_list_with_a_seed_of_its_own():
    assert tuple(LISTS) == SPLITS
    assert len({entry["seed"] for entry in LISTS.values()}) == len(SPLITS)
    assert len({entry["digest"] for entry in LISTS.values()}) == len(SPLITS)


def test_a_shorter_list_is_the_beginning_of_the_whole():
    whole, short = frozen.load("flagship_double"), frozen.load("flagship_double", 30)
    assert short.feasible.sum() == 30 and short.feasible[-1]
    np.testing.assert_array_equal(short.faults, whole.faults[: len(short)])
    np.testing.assert_array_equal(short.index, np.arange(len(short)))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("flagchip",), r"split must be one of \['flagship', .*got 'flagchip'"),
        (("flagship", 0), r"feasible must be within \[1, 500\], got 0"),
        (("flagship", 501), r"feasible must be within \[1, 500\], got 501"),
    ],
)
def test_what_is_not_on_file_is_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        frozen.load(*arguments)


@pytest.mark.parametrize("text", ["", "[]", '{"flagship": {"seed": 1}}', json.dumps(LISTS).replace("10000", '"10000"')])
def test_a_damaged_file_is_named_with_the_remedy(text, tmp_path, monkeypatch):
    monkeypatch.setattr(frozen, "_FILE", str(tmp_path / "frozen.json"))
    (tmp_path / "frozen.json").write_text(text)
    with pytest.raises(ValueError, match=r"frozen\.json cannot be read: .*; install the package again$"):
        frozen.load("flagship", 1)


def test_a_changed_scenario_is_noticed(monkeypatch):
    usual = scenarios.get("flagship")
    monkeypatch.setattr(scenarios, "get", lambda name: usual.replace(duration=60.0))
    with pytest.raises(ValueError, match="episodes must be the frozen episodes of flagship, digest"):
        frozen.load("flagship")


def test_freezing_again_writes_the_same_file(tmp_path):
    frozen.freeze(tmp_path / "frozen.json")
    assert json.loads((tmp_path / "frozen.json").read_text()) == LISTS


def test_a_scenario_that_nobody_can_fly_has_no_list():
    hopeless = scenarios.get("flagship").replace(duration=10.0)
    with pytest.raises(ValueError, match="scenario must have more feasible episodes"):
        frozen.draw_feasible(hopeless, 0, 5)
