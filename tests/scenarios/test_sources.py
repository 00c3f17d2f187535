"""Scenarios from names, files, functions and data."""

import json
import pickle
from pathlib import Path

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec

import ftac_gym  # noqa: F401  registers the environments
from ftac_gym import scenarios
from ftac_gym.evaluation import evaluate, rollout
from ftac_gym.scenarios import library

OWN = scenarios.get("cao_2022").replace(name="own", duration=0.2)
MODULE = """
from ftac_gym import scenarios
def build():
    return scenarios.get("cao_2022").replace(name="own", duration=0.2)
SCENARIO = build()
NUMBER = 3
def sized(width): return SCENARIO
def wrong(): return SCENARIO.replace(duration=-1)
"""


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.setattr(library, "_OWN", {})
    monkeypatch.chdir(tmp_path)
    (tmp_path / "own.json").write_text(OWN.to_json())
    (tmp_path / "marked.json").write_text(OWN.to_json(), encoding="utf-8-sig")  # as some editors write it
    (tmp_path / "own_scenarios_here.py").write_text(MODULE)
    return tmp_path


SOURCES = [
    OWN, OWN.to_dict(), OWN.to_json(), f"\n {OWN.to_json()}", "own.json", Path("own.json"), "marked.json",
    "own_scenarios_here:build", "own_scenarios_here:SCENARIO",
]  # fmt: skip


@pytest.mark.parametrize("source", SOURCES)
def test_every_form_gives_the_same_scenario(source):
    assert scenarios.resolve(source).to_json() == OWN.to_json()


@pytest.mark.parametrize("source", ["own.json", "own_scenarios_here:build", "registered"])
def test_environments_and_evaluations_take_every_form(source, folder, monkeypatch):
    scenarios.register("registered", OWN)
    env = gym.make("SpacecraftFTC-v0", scenario=source, physics_step=0.005)
    vector = gym.make_vec("SpacecraftFTC-v0", num_envs=2, scenario=source)
    assert env.unwrapped.scenario.horizon == 20 == vector.unwrapped.scenario.horizon
    flights = [rollout(task, "pd", seed=3).command for task in (source, OWN)]
    np.testing.assert_array_equal(*flights)
    evaluation = evaluate(source, "pd", OWN.draw(3, 1))
    assert evaluation.attitude_error.shape == (21, 1)
    # The specification makes the same environment where there is neither the file nor the name.
    monkeypatch.setattr(library, "_OWN", {})
    (folder / "own.json").unlink()
    for made, make in ((env, gym.make), (vector, gym.make_vec)):
        again = make(EnvSpec.from_json(made.spec.to_json()))
        assert again.unwrapped.scenario == made.unwrapped.scenario


def test_a_file_may_begin_with_the_mark_of_windows_editors(folder):
    (folder / "marked.json").write_text(OWN.to_json(), encoding="utf-8-sig")
    assert scenarios.resolve("marked.json") == OWN


def test_a_name_of_the_package_stays_a_name_in_the_specification():
    env = gym.make("SpacecraftFTC-v0", scenario="cao_2022")
    assert env.spec.kwargs["scenario"] == "cao_2022"


@pytest.mark.parametrize(
    ("source", "message"),
    [
        (
            "no_such",
            r"scenario must be one of \[.*'flagship'.*\], a file FILE.json, 'module:function', .*got 'no_such'",
        ),
        ("no_such.json", r"scenario must be a file that can be read, got 'no_such.json': No such file"),
        (Path(), r"scenario must be a file that can be read, got '\.': Is a directory"),
        ("torn.json", r"^torn\.json: scenario must be JSON text: "),
        ("wrong.json", r"^wrong\.json: scenario.duration must be positive, got -1$"),
        ('{"type": "Scenario", "colour": 1}', "Scenario has no field 'colour'"),
        ("no_such_module:build", "scenario must be in a module that can be imported; there is no 'no_such_module'"),
        ("own_scenarios_here:absent", "scenario must be defined in its module, got 'own_scenarios_here:absent'"),
        ("own_scenarios_here:NUMBER", "scenario from 'own_scenarios_here:NUMBER' must be a Scenario, got 3"),
        (
            "own_scenarios_here:sized",
            r"scenario must be a function without arguments \(this has width\), got 'own_scenarios_here:sized'",
        ),
        ("own_scenarios_here:wrong", "^duration must be positive, got -1$"),
        (3, "scenario must be a name, a file FILE.json, .* got 3"),
        (None, "scenario must be a name, .* got None"),
    ],
)
def test_what_is_no_scenario_is_refused_in_a_line(source, message, folder):
    (folder / "torn.json").write_text(OWN.to_json()[:-9])
    (folder / "wrong.json").write_text(json.dumps({**OWN.to_dict(), "duration": -1}))
    with pytest.raises(ValueError, match=message) as error:
        scenarios.resolve(source)
    assert "\n" not in str(error.value)


def test_own_scenarios_have_names():
    assert scenarios.register("mine", lambda: OWN).name == "mine"
    assert "mine" in scenarios.names() and scenarios.resolve("mine") == scenarios.get("mine") == OWN.replace(
        name="mine"
    )
    # A notebook's cell runs again.
    scenarios.register("mine", OWN.replace(duration=0.1))
    assert scenarios.get("mine").duration == 0.1
    # Elsewhere the scenario is there without its name.
    data = pickle.dumps(scenarios.get("mine"))
    library._OWN.clear()
    assert pickle.loads(data).duration == 0.1
    with pytest.raises(ValueError, match="scenario must be one of"):
        scenarios.get("mine")


@pytest.mark.parametrize(
    ("name", "scenario", "message"),
    [
        ("flagship", OWN, "name of a scenario must be new; the package has a scenario of that name, got 'flagship'"),
        ("my.json", OWN, "must consist of letters"),
        ("", OWN, "must consist of letters"),
        (3, OWN, "must consist of letters"),
        ("mine", "flagship", "scenario must be a Scenario or a function that returns one, got 'flagship'"),
        ("mine", lambda: 3, "scenario must be a Scenario or a function that returns one, got 3"),
    ],
)
def test_what_cannot_be_registered(name, scenario, message):
    with pytest.raises(ValueError, match=message):
        scenarios.register(name, scenario)
    assert not library._OWN
