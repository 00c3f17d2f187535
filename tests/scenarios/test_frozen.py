"""Frozen validation and test episodes: the ones on file, every time, or an error."""

import json
from importlib import resources

import numpy as np
import pytest

from ftac_gym import scenarios
from ftac_gym.scenarios import SPLITS, frozen

LISTS = json.loads(resources.files(scenarios).joinpath("frozen.json").read_text())


@pytest.mark.parametrize("kind", ["validation", "test"])
@pytest.mark.parametrize("split", SPLITS)
def test_the_lists_on_file_are_what_is_drawn(split, kind):
    episodes, entry = frozen.load(split, kind=kind), LISTS[split][kind]
    assert episodes.digest() == entry["digest"] and len(episodes) == entry["count"]
    assert episodes.feasible.sum() == frozen.FEASIBLE and episodes.feasible[-1]
    assert episodes.scenario_json == scenarios.get(split).to_json()


def test_every_split_has_two_lists_with_seeds_of_their_own():
    assert tuple(LISTS) == SPLITS
    lists = [entry for split in LISTS.values() for entry in split.values()]
    for part in ("seed", "digest"):
        assert len({entry[part] for entry in lists}) == 2 * len(SPLITS)
    for kind in ("validation", "test"):
        assert frozen.seeds(kind) == {split: LISTS[split][kind]["seed"] for split in SPLITS}


def test_the_seeds_of_all_lists_are_reserved():
    for entry in (entry for split in LISTS.values() for entry in split.values()):
        with pytest.raises(ValueError, match=r"^own_seed must not be within \[10000, 29999\], the seeds of"):
            frozen.check_free(entry["seed"], "own_seed")
    frozen.check_free(9_999)
    frozen.check_free(30_000)


def test_a_scenario_without_lists_has_the_seeds_of_the_flagship():
    assert frozen.seed_of("flexible") == 10_000 and frozen.seed_of("flexible", "validation") == 20_000
    assert frozen.seed_of("flagship_severe") == 11_000 and frozen.seed_of("flagship_severe", "validation") == 21_000


def test_validation_and_test_share_no_episode():
    initial = [frozen.load("flagship", 100, kind).initial["attitude"] for kind in ("validation", "test")]
    assert not (initial[0][:, None] == initial[1]).all(axis=2).any()


def test_a_shorter_list_is_the_beginning_of_the_whole():
    whole, short = frozen.load("flagship_double"), frozen.load("flagship_double", 30)
    assert short.feasible.sum() == 30 and short.feasible[-1]
    np.testing.assert_array_equal(short.faults, whole.faults[: len(short)])
    np.testing.assert_array_equal(short.index, np.arange(len(short)))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("flagchip",), r"split must be one of \['flagship', .*got 'flagchip'"),
        (("flagship", 0), "feasible must be a whole number, 1 or more, got 0"),
        (("flagship", 501), r"feasible must be within \[1, 500\], got 501"),
        (("flagship", 2.5), "feasible must be a whole number, 1 or more, got 2.5"),
        (("flagship", None), "feasible must be a whole number, 1 or more, got None"),
        ((["flagship"],), r"split must be one of .*got \['flagship'\]"),
        (("flagship", 5, ["test"]), r"kind must be one of .*, got \['test'\]"),
        (("flagship", 5, "training"), r"kind must be one of \['validation', 'test'\], got 'training'"),
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
    with pytest.raises(ValueError, match="episodes must be the frozen test episodes of flagship, digest"):
        frozen.load("flagship")


def test_freezing_again_writes_the_same_file(tmp_path):
    frozen.freeze(tmp_path / "frozen.json")
    assert json.loads((tmp_path / "frozen.json").read_text()) == LISTS


def test_a_scenario_that_nobody_can_fly_has_no_list():
    hopeless = scenarios.get("flagship").replace(duration=10.0)
    with pytest.raises(ValueError, match="scenario must have more feasible episodes"):
        frozen.draw_feasible(hopeless, 0, 5)
