"""An own satellite from the command line: tuned gains, a comparison, a residual on them, and their report."""

import json
from dataclasses import replace

import numpy as np
import pytest
from helpers.scripts import module_of
from matplotlib.figure import Figure
from stable_baselines3.common.callbacks import CallbackList

from ftac_gym import scenarios
from ftac_gym.agents.agent import Agent
from ftac_gym.evaluation import rollout
from ftac_gym.evaluation.episodes import judging_episodes
from ftac_gym.report import comparison
from ftac_gym.spacecraft.spacecraft import Spacecraft
from ftac_gym.spacecraft.wheel_array import WheelArray
from ftac_gym.utils import console

CUBESAT = Spacecraft(np.diag([0.04, 0.045, 0.01]), WheelArray(np.eye(3), torque_limit=0.004, momentum_limit=0.03))
MODULE = """
from pathlib import Path
from ftac_gym import scenarios

def satellite():
    return scenarios.resolve(Path("mine.json"))

def torn():
    return scenarios.resolve(Path("torn.json"))
"""


@pytest.fixture
def own(tmp_path, monkeypatch):
    """Return the scenario, which lies in the working folder as mine.json and as mission:satellite."""
    base = scenarios.get("flagship")
    scenario = base.replace(
        name="cubesat", spacecraft=CUBESAT, control_period=0.2, duration=30.0, disturbance=None, faults=None,
        initial_state=replace(base.initial_state, wheel_momentum=0.001),
    )  # fmt: skip
    (tmp_path / "mine.json").write_text(scenario.to_json())
    (tmp_path / "mission.py").write_text(MODULE)
    monkeypatch.chdir(tmp_path)
    return scenario


def test_from_a_file_to_tuned_gains_an_agent_and_a_report(own, tmp_path, monkeypatch, capsys):
    tune, train, evaluate = module_of("tune"), module_of("train"), module_of("evaluate")
    monkeypatch.setattr(comparison, "fault_gallery", lambda scenario, policy: Figure())
    run = module_of("training_run")
    monkeypatch.setattr(run, "ProgressBarCallback", lambda: CallbackList([]))  # an experiment of tqdm, as it warns
    gains = "runs/tuning/mine/pd/gains.json"
    tune.main(tune.Config("pd", "mine.json", trials=2, episodes=6, workers=1))
    record = json.loads((tmp_path / gains).read_text())
    assert record["provenance"]["scenario"] == "cubesat" and record["provenance"]["baseline"] == "pd"
    assert record["provenance"]["command"] == "ftac-tune --baseline pd --scenario mine.json --trials 2 --episodes 6"
    config = train.Config(
        run_folder=tmp_path / "run", scenario="mine.json", wrappers=(f"ResidualPolicy base=pd gains={gains}",), hold=1,
        total_steps=64, num_envs=2, critic_warmup=0, hyperparameters=("n_steps=32", "batch_size=64"),
        evaluation_episodes=2, torch_threads=1,
    )  # fmt: skip
    train.main(config)
    agent, card = Agent.load(tmp_path / "run" / "agent"), json.loads((tmp_path / "run/agent/card.json").read_text())
    assert card["scenario"] == "cubesat" and "--scenario mine.json" in card["command"]
    assert card["interface"]["wrappers"][0][1].items() >= record["gains"].items()
    # The evaluations of the run were on the own scenario.
    validation = judging_episodes(own, 2, "validation")
    expected = rollout(own, agent, validation).feasible_metrics()["return"].mean()
    assert card["evaluation"]["mean_return"] == pytest.approx(expected)
    # The run goes on with its own copy.
    (tmp_path / "mine.json").write_text(own.replace(duration=1.0).to_json())
    resumed = run.resumed(train.Config(run_folder=tmp_path / "run", resume=True))
    assert run.task_of(resumed) == own and run.task_of(config) != own
    (tmp_path / "mine.json").write_text(own.to_json())
    policies = ("pd", f"pd {gains}", "run/agent")
    for scenario, name in (("mine.json", "mine"), ("mission:satellite", "satellite")):
        evaluate.main(evaluate.Config(policies=policies, scenario=scenario, episodes=1, reference="pd"))
        report = (tmp_path / "results" / name / "report.md").read_text()
        assert report.startswith(f"# {name}: pd, pd {gains}, run/agent") and "tuned by 2 trials on cubesat" in report
    benchmark = evaluate.Config(
        policies=policies, scenario="mine.json", episodes=1, reference="pd", benchmark=True, workers=1
    )
    evaluate.main(benchmark)
    page = (tmp_path / "results" / "benchmark" / "report.html").read_text()
    assert gains in page and "ftac-evaluate --policies" not in page  # no name of a scenario finds its episodes again
    assert "of its last number" not in page


def test_a_scenario_of_the_training_alone(own):
    train, run = module_of("train"), module_of("training_run")
    config = train.Config(scenario="flagship", training_scenario="flagship_pointing")
    parameters = run.hyperparameters_of(config)
    task = run.task_of(config)
    assert (task.name, run.training_scenario(config, parameters, task).name) == ("flagship", "flagship_pointing")
    # Without a scenario, that of the hyperparameters; with one, all is on it.
    usual, named = train.Config(), train.Config(scenario="flagship")
    assert run.training_scenario(usual, parameters, run.task_of(usual)).name == "flagship_pointing"
    assert run.training_scenario(named, parameters, task).name == "flagship"
    flexible = train.Config(scenario="flexible")
    assert run.env_id_of(flexible) == "SpacecraftFTCFlexible-v0" and run.task_of(flexible).name == "flexible"
    # An own satellite has the default entry, not the one that is made for the flagship.
    wrappers = [name for name, _ in run.hyperparameters_of(train.Config(scenario="mine.json")).interface.wrappers]
    assert wrappers == ["ResidualPolicy"] and len(parameters.interface.wrappers) == 2


@pytest.mark.parametrize(
    ("name", "options", "message"),
    [
        ("evaluate", {"scenario": "absent.json"}, "--scenario must be a file that can be read, got 'absent.json'"),
        ("evaluate", {"scenario": "flagship.json"}, "--scenario must not be called like one of the package"),
        (
            "evaluate",
            {"splits": ("mine.json", "sub/mine.json")},
            "--splits: 'sub/mine.json' would have the same folder",
        ),
        ("train", {"scenario": "mission:nothing"}, "--scenario must be defined in its module, got 'mission:nothing'$"),
        ("train", {"training_scenario": "absent.json"}, "--training-scenario must be a file that can be read"),
        ("tune", {"scenario": "no_module:f"}, "--scenario must be in a module that can be imported"),
        ("play", {"scenario": "absent.json"}, "--scenario must be a file that can be read"),
        ("play", {"scenario": "torn.json"}, "--scenario: torn.json: scenario must be JSON text: "),
        ("tune", {"scenario": "mission:torn"}, "--scenario mission:torn: torn.json: scenario must be JSON text: "),
        ("tune", {"scenario": "failing:f"}, r"--scenario failing:f: KeyError: 'missing' \(failing.py, line 2\)$"),
        ("synthesize", {"scenario": "mine.json"}, "--scenario mine.json: appendages must be given"),
    ],
)
def test_a_scenario_that_is_none(name, options, message, own, tmp_path):
    for other in (tmp_path / "flagship.json", tmp_path / "sub" / "mine.json"):
        other.parent.mkdir(exist_ok=True)
        other.write_text(own.to_json())
    (tmp_path / "torn.json").write_text("")
    (tmp_path / "failing.py").write_text("def f(): ...\n{}['missing']\n")
    program = module_of(name)
    with pytest.raises(SystemExit, match=f"^{message}"):
        program.main(program.Config(**options))
    assert not (tmp_path / "runs").exists() and not (tmp_path / "results").exists()


def test_nothing_is_stored_in_an_installed_package(own, monkeypatch):
    monkeypatch.setattr(console, "checkout", lambda: None)
    assert console.commit() is None
    for name in ("tune", "synthesize"):
        program = module_of(name)
        with pytest.raises(SystemExit, match=r"^--store writes into a checkout of the package; this one is installed"):
            program.main(program.Config(store=True))
