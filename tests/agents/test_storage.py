"""Files of an agent: replaced as a whole, damage named in a line, nothing global changed."""

import json
import random
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import torch
from helpers.networks import model_of, observations

from ftac_gym.agents import storage
from ftac_gym.agents.agent import Agent
from ftac_gym.agents.interface import Interface
from ftac_gym.agents.shipped import SHIPPED
from ftac_gym.agents.storage import amend_card, read_card
from ftac_gym.baselines import tuned
from ftac_gym.baselines.synthesis import designs

ORIGIN = {"seed": 3, "steps": 10, "command": "python train/train.py", "training_seconds": 1.5}


@pytest.fixture
def folder(tmp_path):
    Agent.of(model_of()).save(tmp_path / "agent", **ORIGIN)
    return tmp_path / "agent"


def test_the_card_has_interface_and_origin(folder):
    card = read_card(folder)
    assert {name: card[name] for name in ORIGIN} == ORIGIN and card["interface"]["observation"] == "attitude"
    before = Agent.load(folder).fingerprint
    amend_card(folder, {"run_steps": 20})
    assert read_card(folder) == {**card, "run_steps": 20} and Agent.load(folder).fingerprint == before
    with pytest.raises(ValueError, match=r"card must have entries among .*'run_steps'.*got 'note'"):
        amend_card(folder, {"note": "mine"})
    with pytest.raises(ValueError, match="steps must be int, got '20'"):
        amend_card(folder, {"steps": "20"})


class KilledError(BaseException):
    """A kill: no handler of the package sees it."""


def kill_before(monkeypatch, step):
    """Kill the process before the n-th change of a file name: two take the place of files, then old weights go."""
    passed = iter(range(100))

    def stops(method):
        def call(*arguments, **keywords):
            if next(passed) == step:
                monkeypatch.undo()
                raise KilledError
            return method(*arguments, **keywords)

        return call

    for name in ("replace", "unlink"):
        monkeypatch.setattr(Path, name, stops(getattr(Path, name)))


def test_a_kill_at_any_step_leaves_the_earlier_agent_or_the_new_one(folder, monkeypatch):
    earlier = Agent.load(folder).fingerprint
    (folder / "evaluations.csv").write_text("steps\n")
    successor, seen = Agent.of(model_of(use_sde=True)), []
    for step in range(4):
        kill_before(monkeypatch, step)
        try:
            successor.save(folder)
        except KilledError:
            seen.append(Agent.load(folder).fingerprint == earlier)
    assert seen == [True, True, False]  # before the card is replaced, and after
    monkeypatch.undo()
    assert Agent.load(folder).fingerprint != earlier
    weights = json.loads((folder / "card.json").read_text())["weights"]["file"]
    assert sorted(path.name for path in folder.iterdir()) == ["card.json", "evaluations.csv", weights]


def test_an_agent_that_is_replaced_while_it_is_read_is_the_new_one(folder, monkeypatch):
    successor, parse = Agent.of(model_of(use_sde=True)), storage.parse_json

    def replaced(text):
        monkeypatch.undo()
        successor.save(folder)
        return parse(text)

    monkeypatch.setattr(storage, "parse_json", replaced)
    agent = Agent.load(folder)
    assert agent.policy.use_sde and agent.fingerprint == Agent.load(folder).fingerprint


def test_any_damage_is_named_in_a_line(folder):
    """The damaged agent is refused, or acts as the whole one."""
    whole = Agent.load(folder)
    expected, rng, refused = whole.predict(observations())[0], np.random.default_rng(5), 0
    for path in folder.iterdir():
        data = path.read_bytes()
        places = rng.integers(0, len(data), 150)
        flips = [data[:at] + bytes([data[at] ^ rng.integers(1, 256)]) + data[at + 1 :] for at in places]
        cuts = [data[:at] for at in (0, 1, *places[:30], len(data) - 1)]
        doubled = [data + data, data[: places[0]] + data[places[1] :], data.replace(b"5", b"6")]
        for damaged in (*flips, *cuts, *doubled):
            path.write_bytes(damaged)
            try:
                agent = Agent.load(folder)
            except ValueError as error:
                refused += 1
                text = str(error)
                assert str(folder) in text and "\n" not in text and len(text) <= 500
            else:
                assert agent.fingerprint == whole.fingerprint
                np.testing.assert_array_equal(agent.predict(observations())[0], expected)
        path.write_bytes(data)
    assert refused > 250 and Agent.load(folder).fingerprint == whole.fingerprint


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda folder: next(folder.glob("*.safetensors")).unlink(), r"safetensors cannot be read: .*No such file"),
        (lambda folder: (folder / "card.json").unlink(), r"agent must be a folder with card\.json"),
        (lambda folder: (folder / "card.json").write_text('{"a": 1, "a": 2}'), "must have every key once, got 'a'"),
        (lambda folder: (folder / "card.json").write_text("{}"), "interface must be in the card"),
        (
            lambda folder: (folder / "card.json").write_text('{"interface": {}, "normalized": true}'),
            r"agent must be of this version; .*ftac-convert OLD NEW --trust",
        ),
        (
            lambda folder: ((folder / "card.json").unlink(), (folder / "model.zip").write_bytes(b"")),
            r"agent must be of this version; pickles run code.*ftac-convert OLD NEW --trust",
        ),
    ],
)
def test_messages(folder, damage, message):
    damage(folder)
    with pytest.raises(ValueError, match=message):
        Agent.load(folder)


def test_a_zip_is_refused_with_the_command_that_converts_it(tmp_path):
    model_of().save(tmp_path / "model.zip")
    with pytest.raises(ValueError, match=r"ftac-convert OLD NEW --trust; .*sb3:PATH, got .*model\.zip"):
        Agent.load(tmp_path / "model.zip")


def test_reading_changes_no_global_generator(folder):
    """Neither the model's seed nor the start of its weights reaches them."""
    random.seed(7)
    torch.manual_seed(7)
    before = random.getstate(), np.random.get_state()[1].copy(), torch.random.get_rng_state()  # noqa: NPY002
    Agent.load(folder)
    assert random.getstate() == before[0]
    np.testing.assert_array_equal(np.random.get_state()[1], before[1])  # noqa: NPY002
    assert torch.equal(torch.random.get_rng_state(), before[2])


FIRST = """
import random, sys
from pathlib import Path
import torch
from ftac_gym.agents import storage
from ftac_gym.agents.agent import Agent
assert "stable_baselines3" not in sys.modules
found, before = [], random.getstate()
sys.addaudithook(lambda event, _: found.append(event) if event.startswith("pickle") else None)
Agent.load(sys.argv[1])
assert random.getstate() == before, "the global generator was used"
assert not found, found
"""


def test_the_first_agent_of_a_process_is_read_without_pickles_too():
    folder = SHIPPED / "flagship_direct" / "seed_0"
    subprocess.run([sys.executable, "-c", FIRST, str(folder)], check=True, timeout=120)


def fingerprint(folder, interface, model=None):
    Agent.of(model_of() if model is None else model, interface).save(folder)
    return Agent.load(folder).fingerprint


def test_the_fingerprint_covers_all_on_which_the_actions_depend(tmp_path, monkeypatch):
    tuned_base = Interface(wrappers=(("ResidualPolicy", {"base": "pd_dob", "gains": "tuned"}),))
    other = model_of()
    other.get_vec_normalize_env().obs_rms.mean[0] += 1e-12
    first = fingerprint(tmp_path / "one", tuned_base)
    assert fingerprint(tmp_path / "two", tuned_base) == first
    changed = [fingerprint(tmp_path / "held", Interface("attitude", tuned_base.wrappers, hold=2))]
    changed.append(fingerprint(tmp_path / "normalizer", tuned_base, other))
    # Data of the package to which the interface refers.
    shutil.copytree(tuned.FOLDER, tmp_path / "tuned")
    text = json.loads((tmp_path / "tuned" / "pd_dob.json").read_text())
    text["gains"]["position_gain"] *= 1.01
    (tmp_path / "tuned" / "pd_dob.json").write_text(json.dumps(text))
    with monkeypatch.context() as context:
        context.setattr(tuned, "FOLDER", tmp_path / "tuned")
        changed.append(Agent.load(tmp_path / "one").fingerprint)
    shutil.copytree(designs._FOLDER, tmp_path / "designs")
    (tmp_path / "designs" / "stored" / "flexible.json").write_text("{}")
    with monkeypatch.context() as context:
        context.setattr(designs, "_FOLDER", tmp_path / "designs")
        changed.append(Agent.load(tmp_path / "one").fingerprint)
    assert Agent.load(tmp_path / "one").fingerprint == first and len({first, *changed}) == 5
