"""Nothing that the package reads is executed: no pickle in any file is undone, and no module could undo one."""

import ast
import base64
import json
import pickle
import shutil
import warnings
import zipfile
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from helpers.networks import model_of

import ftac_gym
from ftac_gym import scenarios
from ftac_gym.agents.agent import Agent
from ftac_gym.agents.shipped import evaluations
from ftac_gym.baselines import tuned
from ftac_gym.baselines.synthesis import designs
from ftac_gym.evaluation.batches import Batch
from ftac_gym.evaluation.tuning_objective import Search
from ftac_gym.evaluation.tuning_study import Study
from ftac_gym.policies import resolve
from ftac_gym.task.episodes import Episodes
from ftac_gym.task.scenario import Scenario
from ftac_gym.training.hyperparameters import read_hyperparameters

SHORT = scenarios.get("flagship").replace(duration=1.0)
EPISODES = SHORT.draw(0, 1)
SEARCH = Search("pd", scenarios.get("flagship"), episodes=4)


class Bomb:
    """An object whose pickle writes a file when it is undone."""

    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return Path.touch, (self.path,)


def texts(bomb):
    """Return files that hold the object, as text or as a pickle."""
    written = pickle.dumps(bomb)
    encoded = base64.b64encode(written).decode()
    yield written
    yield f'!!python/object/apply:pathlib.Path.touch [!!python/object/apply:pathlib.Path ["{bomb.path}"]]'.encode()
    yield json.dumps({":type:": "Bomb", ":serialized:": encoded}).encode()


def archives(bomb, names):
    """Return arrays and NumPy archives whose entries are objects."""
    array = np.array([bomb], dtype=object)
    for write in (
        lambda file: np.save(file, array),
        lambda file: np.savez(file, **dict.fromkeys(names, array)),
        lambda file: zipped(file, dict.fromkeys(("data", "policy.pth", *names), pickle.dumps(bomb))),
    ):
        with open(f"{bomb.path}.npz", "wb") as file:
            write(file)
        yield Path(f"{bomb.path}.npz").read_bytes()


def zipped(file, entries):
    with zipfile.ZipFile(file, "w") as archive:
        for name, data in entries.items():
            archive.writestr(name, data)


def read_agent(path, data):
    """Read an agent with its card replaced, with its weights replaced, and as a zip."""
    Agent.of(model_of()).save(path)
    for part in sorted(path.iterdir()):
        whole = part.read_bytes()
        part.write_bytes(data)
        with suppress(ValueError):
            Agent.load(path)
        part.write_bytes(whole)
    for name in ("model.zip", "normalizer.pkl", "vecnormalize.pkl"):
        (path / name).write_bytes(data)
    Agent.load(path)
    (path / "card.json").unlink()
    for policy in (path, path / "model.zip"):
        with pytest.raises(ValueError, match=r"ftac-convert"):
            resolve(policy)


def of_file(name, read):
    """Return a function that writes a file and reads it."""

    def write_and_read(path, data):
        path.mkdir()
        (path / name).write_bytes(data)
        read(path / name)

    return write_and_read


def read_tuned(path):
    with pytest.MonkeyPatch.context() as context:
        context.setattr(tuned, "FOLDER", path.parent)
        tuned.gains("pd")


def read_designs(path):
    (path.parent / "stored").mkdir()
    shutil.copy(path, path.parent / "stored" / "flexible.json")
    with pytest.MonkeyPatch.context() as context:
        context.setattr(designs, "_FOLDER", path.parent)
        with suppress(Exception):
            designs.published.__wrapped__()
        designs.solved.__wrapped__(scenarios.get("flexible").spacecraft)


READERS = {
    "agent": read_agent,
    "episodes": of_file("episodes.npz", Episodes.load),
    "batch": of_file("batch.npz", lambda path: Batch(SHORT, "pd", EPISODES, path).read()),
    "scenario": of_file("scenario.json", lambda path: Scenario.from_json(path.read_text(encoding="latin-1"))),
    "evaluations": of_file("evaluations.csv", lambda path: evaluations(path.parent)),
    "hyperparameters": of_file("ppo.yml", lambda path: read_hyperparameters(path, "SpacecraftFTC-v0")),
    "tuning journal": of_file("trials.jsonl", lambda path: Study(SEARCH, path.parent)),
    "tuned gains": of_file("pd.json", read_tuned),
    "solved gains": of_file("li_2023_published.json", read_designs),
}


@pytest.mark.parametrize("name", READERS)
def test_no_file_is_executed(name, tmp_path):
    written = tmp_path / "written"
    bomb = Bomb(written)
    pickle.loads(pickle.dumps(bomb))
    assert written.exists()
    written.unlink()
    names = (*Episodes.__dataclass_fields__, "return", "attitude_error")
    for index, data in enumerate((*texts(bomb), *archives(bomb, names))):
        with suppress(Exception), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            READERS[name](tmp_path / str(index), data)
        assert not written.exists()


SOURCES = Path(ftac_gym.__file__).parent
PICKLES = SOURCES / "agents" / "pickles.py"
UNDOING = {"pickle", "cPickle", "_pickle", "cloudpickle", "dill", "shelve", "marshal", "jsonpickle"}
"""Modules that read objects."""
SAFE = {"Agent", "Episodes", "frozen", "np", "json", "type(episodes)"}
"""Owners of a function ``load`` that reads data."""


def executing(tree):
    """Yield the expressions of a module that could execute what they read."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (item.name for item in node.names if item.name.split(".")[0] in UNDOING)
        if isinstance(node, ast.ImportFrom):
            module, names = str(node.module), {item.name for item in node.names}
            if module.split(".")[0] in UNDOING or (names & {"load", "loads"} and not module.startswith("safetensors")):
                yield ast.unparse(node)
            yield from names & {"load_from_zip_file", "load_from_pkl", "joblib.load"}
        if isinstance(node, ast.Call):
            text, owner, name = ast.unparse(node), "", ast.unparse(node.func)
            if isinstance(node.func, ast.Attribute):
                owner, name = ast.unparse(node.func.value), node.func.attr
            weights = owner == "torch" and "weights_only=True" in text
            if owner and name == "load" and owner not in SAFE and not weights:
                yield text
            if owner == "np" and "allow_pickle=True" in text:
                yield text
            if name in {"eval", "exec", "unsafe_load", "full_load", "load_all", "load_replay_buffer", "set_parameters"}:
                yield text


@pytest.mark.parametrize("root", [SOURCES, SOURCES.parent / "train"], ids=["ftac_gym", "train"])
def test_no_module_executes_what_it_reads(root):
    assert list(executing(ast.parse("import pickle\ntorch.load(path)\nyaml.load(text)"))) != []
    found = {
        str(path.relative_to(root)): calls
        for path in sorted(root.rglob("*.py"))
        if path != PICKLES and (calls := list(executing(ast.parse(path.read_text(encoding="utf-8")))))
    }
    assert found == {}


def test_one_module_alone_undoes_pickles_for_those_that_say_so():
    assert list(executing(ast.parse(PICKLES.read_text(encoding="utf-8"))))
    users = [
        path.name
        for root in (SOURCES, SOURCES.parent / "train")
        for path in root.rglob("*.py")
        if "agents.pickles" in path.read_text(encoding="utf-8")
    ]
    # The command line reaches them by the prefixes "sb3:" and "zoo:" alone, and by --trust.
    assert set(users) == {"conversion.py", "sb3.py", "zoo.py"}


@pytest.mark.parametrize("prefix", ["", "./"])
def test_a_path_without_a_prefix_undoes_nothing(prefix, tmp_path, monkeypatch):
    model_of().save(tmp_path / "model.zip")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(pickle, "loads", None)
    for name in ("model.zip", "."):
        with pytest.raises(ValueError, match="agent must be"):
            resolve(prefix + name)
