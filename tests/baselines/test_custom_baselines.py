"""Laws from outside of the package are taken wherever a baseline's name is."""

import numpy as np
import pytest
from helpers.custom_baseline import CustomBaseline, CustomOracle, CustomTelemetry

from ftac_gym import baselines, scenarios
from ftac_gym.baselines import Baseline
from ftac_gym.evaluation import evaluate, rollout
from ftac_gym.evaluation.benchmark import entries_of, fly
from ftac_gym.evaluation.tuning import tune
from ftac_gym.evaluation.tuning_objective import Search
from ftac_gym.policies import DeferredBaseline, resolve
from ftac_gym.utils.importing import is_path

PATH = "helpers.custom_baseline:CustomBaseline"
TASK = scenarios.get("flagship").replace(duration=30.0)


def test_a_class_and_its_path_are_the_same_law():
    assert (
        baselines.baseline_class(PATH) is CustomBaseline and baselines.baseline_class(CustomBaseline) is CustomBaseline
    )
    assert baselines.path_of(CustomBaseline) == PATH == baselines.path_of(PATH)
    assert baselines.defaults(PATH) == {"stiffness": 0.3, "damping": 2.0}
    assert baselines.search_space(PATH) == CustomBaseline.search_space
    flights = [rollout(TASK, law, seed=2, count=3).command for law in (CustomBaseline, PATH, DeferredBaseline(PATH))]
    np.testing.assert_array_equal(flights[0], flights[1])
    np.testing.assert_array_equal(flights[0], flights[2])


def test_gains_reach_the_law():
    made = baselines.make(PATH, TASK, 2, damping=3.0)
    assert (made.num_spacecraft, made.stiffness, made.damping) == (2, 0.3, 3.0)
    stiff = rollout(TASK, DeferredBaseline(CustomBaseline, stiffness=0.9), seed=2, count=1)
    assert not np.array_equal(stiff.command, rollout(TASK, CustomBaseline, seed=2, count=1).command)


def test_a_law_may_need_gains_and_says_itself_what_is_wrong():
    class Needing(CustomBaseline):
        def __init__(self, scenario, num_spacecraft, stiffness):
            super().__init__(scenario, num_spacecraft, stiffness)

    assert baselines.make(Needing, TASK, stiffness=0.5).stiffness == 0.5
    with pytest.raises(TypeError, match="stiffness"):
        baselines.make(Needing, TASK)


@pytest.mark.parametrize(
    ("law", "message"),
    [
        ("helpers.no_law:CustomBaseline", r"there is no 'helpers.no_law' .* got 'helpers.no_law:CustomBaseline'"),
        (
            "helpers.custom_baseline:Missing",
            "baseline must name a class in helpers.custom_baseline that derives from Baseline",
        ),
        ("helpers.custom_baseline:NO_LAW", "baseline must name a class in helpers.custom_baseline"),
        (
            "nobody",
            "baseline must be one of .*names.*, such as .*\"module:Class\" for a custom baseline, got 'nobody'",
        ),
        (int, "baseline must be a name or a class that derives from Baseline"),
    ],
)
def test_laws_that_are_refused(law, message):
    with pytest.raises(ValueError, match=message):
        baselines.make(law, TASK)


def test_an_error_inside_the_module_is_not_hidden(tmp_path, monkeypatch):
    (tmp_path / "law_that_lacks_something.py").write_text("import something_that_is_not_there\n")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(ModuleNotFoundError, match="something_that_is_not_there"):
        baselines.baseline_class("law_that_lacks_something:Law")


def test_only_what_can_be_imported_has_a_path():
    class Local(CustomBaseline):
        pass

    for law in (Local, type("CustomBaseline", (CustomBaseline,), {"__module__": "helpers.custom_baseline"})):
        with pytest.raises(ValueError, match="must be a class that can be imported"):
            baselines.path_of(law)
    with pytest.raises(ValueError, match="must be a name or a Baseline class"):
        baselines.path_of(int)


@pytest.mark.parametrize(
    "text", ["pd", "runs/mine", "C:/runs/mine", r"C:\mine", "a folder:with this", ":Law", "my_law:"]
)
def test_names_and_folders_are_no_paths_of_classes(text):
    assert not is_path(text)


def test_tuned_gains_are_for_laws_of_the_package():
    for law in (CustomBaseline, PATH):
        with pytest.raises(ValueError, match="gains must be 'default' for a baseline not of this package"):
            DeferredBaseline(law, "tuned")


def test_results_of_a_law_that_may_change_are_not_kept(tmp_path):
    episodes = TASK.draw(0, 2)
    evaluate(TASK, PATH, episodes, folder=tmp_path)
    assert resolve(PATH).fingerprint is None and not list(tmp_path.iterdir())
    evaluate(TASK, "pd", episodes, folder=tmp_path)
    assert len(list(tmp_path.iterdir())) == 1


def test_the_benchmark_flies_own_laws_as_they_are_on_their_own():
    entries = entries_of(["pd", PATH, CustomTelemetry, CustomOracle], TASK)
    assert [entry.name for entry in entries] == ["pd", PATH, "CustomTelemetry", "CustomOracle"]
    assert [entry.tier for entry in entries] == ["attitude", "attitude", "telemetry", "oracle"]
    assert [entry.role for entry in entries] == ["policy", "policy", "policy", "oracle"]
    flown = fly(entries[:2], {"flagship": TASK.draw(0, 3)}, "pd", workers=1, measure=False)
    alone = evaluate(TASK, CustomBaseline, TASK.draw(0, 3))
    found = flown.evaluations["flagship"][PATH][0]
    np.testing.assert_array_equal(found.attitude_error, alone.attitude_error)


def test_two_own_laws_of_one_name_are_refused():
    other = type("CustomBaseline", (CustomBaseline,), {})
    with pytest.raises(ValueError, match=r"policies must be custom classes and other policies of different names"):
        entries_of([CustomBaseline, other], TASK)
    with pytest.raises(ValueError, match="must be a class whose name no baseline has"):
        entries_of([type("pd", (CustomBaseline,), {})], TASK)


def test_the_tuner_takes_a_path(tmp_path):
    found = tune(Search(PATH, scenarios.get("flagship"), episodes=2), tmp_path, trials=4)
    assert set(found.gains) == {"stiffness", "damping"} and found.trials == 4


def test_baselines_of_the_package_are_no_own_laws():
    assert all(issubclass(baselines.baseline_class(name), Baseline) and not is_path(name) for name in baselines.names())
