"""Agents of pickles become agents of data, once and on request."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from helpers.networks import MODELS, every_model, model_of, observations
from helpers.scripts import module_of
from stable_baselines3.common.save_util import load_from_zip_file

from ftac_gym.agents.agent import Agent
from ftac_gym.agents.conversion import convert
from ftac_gym.agents.interface import Interface
from ftac_gym.agents.storage import read_card

INTERFACE = {"observation": "telemetry", "wrappers": [["ObservationHistory", {"steps": 2}]], "hold": 2}


def write_old(folder, model, **card):
    """Write an agent as earlier versions did."""
    folder.mkdir(parents=True, exist_ok=True)
    model.save(folder / "model.zip")
    model.get_vec_normalize_env().save(str(folder / "normalizer.pkl"))
    (folder / "card.json").write_text(json.dumps({"interface": INTERFACE, "normalized": True, **card}))


def assert_acts_as(agent, model):
    expected = Agent.of(model, agent.interface)
    actions = [item.predict(observations(agent.observation_size))[0] for item in (agent, expected)]
    np.testing.assert_array_equal(*actions)


@every_model
def test_an_old_agent_acts_as_before(name, tmp_path):
    model = model_of(**MODELS[name])
    write_old(tmp_path / "old", model, seed=4, steps=100)
    assert convert(tmp_path / "old", tmp_path / "new") == {tmp_path / "new": True}
    agent = Agent.load(tmp_path / "new")
    assert agent.interface == Interface(**INTERFACE) and agent.normalizer.count == 12.5
    assert_acts_as(agent, model)
    card = read_card(tmp_path / "new")
    assert card["seed"] == 4 and card["steps"] == 100
    assert not {path.suffix for path in (tmp_path / "new").iterdir()} & {".zip", ".pkl"}


@pytest.mark.parametrize("place", ["vecnormalize.pkl", "best_model/vecnormalize.pkl", None])
def test_a_zip_of_the_zoo(place, tmp_path):
    model = model_of()
    model.save(tmp_path / "best_model.zip")
    if place is not None:
        (tmp_path / place).parent.mkdir(exist_ok=True)
        model.get_vec_normalize_env().save(str(tmp_path / place))
    assert convert(tmp_path / "best_model.zip", tmp_path / "new") == {tmp_path / "new": place is not None}
    agent = Agent.load(tmp_path / "new")
    assert agent.interface == Interface() and (agent.normalizer is not None) == (place is not None)
    if place is not None:
        assert_acts_as(agent, model)


def test_seeds_and_runs_keep_their_evaluations(tmp_path):
    models = {seed: model_of(use_sde=seed == 1) for seed in (0, 1)}
    write_old(tmp_path / "design" / "seed_0", models[0])
    (tmp_path / "design" / "seed_0" / "evaluations.csv").write_text("steps,mean_return\n1,2.0\n")
    write_old(tmp_path / "design" / "seed_1" / "agent", models[1])
    (tmp_path / "design" / "seed_1" / "evaluations.csv").write_text("steps,mean_return\n1,3.0\n")
    new = tmp_path / "new"
    assert list(convert(tmp_path / "design", new)) == [new / "seed_0", new / "seed_1" / "agent"]
    assert [(new / f"seed_{seed}" / "evaluations.csv").read_text()[-4:] for seed in (0, 1)] == ["2.0\n", "3.0\n"]
    for seed, folder in ((0, new / "seed_0"), (1, new / "seed_1" / "agent")):
        assert_acts_as(Agent.load(folder), models[seed])


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda old: (old / "normalizer.pkl").unlink(), r"old must have normalizer\.pkl beside it"),
        (lambda old: (old / "normalizer.pkl").write_bytes(b"torn"), r"normalizer\.pkl cannot be read"),
        (lambda old: (old / "model.zip").write_bytes(b"torn"), r"model\.zip cannot be read"),
        (lambda old: (old / "model.zip").unlink(), r"old must have model\.zip"),
        (lambda old: (old / "card.json").write_text("{"), r"card\.json cannot be read"),
        (lambda old: shutil.rmtree(old), r"old must be a folder or a zip file"),
        (lambda old: Agent.of(model_of()).save(old.parent / "new"), r"new must not hold an agent yet"),
    ],
)
def test_what_is_refused(damage, message, tmp_path):
    write_old(tmp_path / "old", model_of())
    damage(tmp_path / "old")
    with pytest.raises(ValueError, match=message):
        convert(tmp_path / "old", tmp_path / "new")


def test_the_script_reads_nothing_unless_the_files_are_trusted(tmp_path, monkeypatch, capsys):
    write_old(tmp_path / "old", model_of())
    script = module_of("convert")
    with monkeypatch.context() as context:
        context.setattr(Path, "read_bytes", None)
        context.setattr(f"{load_from_zip_file.__module__}.load_from_zip_file", None)
        with pytest.raises(SystemExit, match=r"runs the code in them\. If you trust their author, add --trust"):
            script.main(script.Config(tmp_path / "old", tmp_path / "new"))
    assert not (tmp_path / "new").exists()
    script.main(script.Config(tmp_path / "old", tmp_path / "new", trust=True))
    printed = capsys.readouterr().out
    assert "which runs the code in them" in printed and "with its normaliser" in printed
    with pytest.raises(SystemExit, match="new must not hold an agent yet"):
        script.main(script.Config(tmp_path / "old", tmp_path / "new", trust=True))
