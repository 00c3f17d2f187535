"""Kept results: damaged files are flown again, changed code and data are noticed, killed evaluations go on."""

import io
import json
import os
import shutil
import signal
import subprocess
import sys
import textwrap
from concurrent.futures import ThreadPoolExecutor
from importlib import import_module

import numpy as np
import pytest
from helpers.rattle import RATTLE
from helpers.short_benchmarks import EPISODES, FLAGSHIP
from helpers.untrained_agents import write_agent

from ftac_gym.agents.agent import Interface
from ftac_gym.baselines import tuned
from ftac_gym.evaluation import evaluate, identity, tabulate
from ftac_gym.evaluation.batches import batches
from ftac_gym.evaluation.files import write_episodes, write_summary
from ftac_gym.faults import FaultDistribution
from ftac_gym.policies import resolve
from ftac_gym.utils import serialization

TWO = EPISODES["flagship"][:2]


def saved(**arrays):
    buffer = io.BytesIO()
    np.savez(buffer, **arrays)
    return buffer.getvalue()


def changed(content, change, *names):
    """Change the arrays of these names, or all."""
    arrays = np.load(io.BytesIO(content)).items()
    chosen = names or [name for name, _ in arrays if name != "digest"]
    return saved(**{name: change(array) if name in chosen else array for name, array in arrays})


DAMAGES = {
    "empty": lambda content: b"",
    "cut": lambda content: content[: len(content) // 2],
    "zeros": lambda content: bytes(len(content)),
    "flipped": lambda content: content[:400] + bytes([content[400] ^ 255]) + content[401:],
    "other arrays": lambda content: saved(success=np.zeros(2)),
    "fewer episodes": lambda content: changed(content, lambda array: array[..., :1]),
    "other numbers": lambda content: changed(content, lambda array: array.astype("f2")),
    "one value": lambda content: changed(content, lambda array: array + 6.0, "success"),
    "not finite": lambda content: changed(content, lambda array: array * np.nan, "return"),
    "other digest": lambda content: changed(content, lambda array: np.array("0" * 64), "digest"),
    "no digest": lambda content: saved(
        **{name: array for name, array in np.load(io.BytesIO(content)).items() if name != "digest"}
    ),
    "objects": lambda content: saved(success=np.array([print, print])),
    "text": lambda content: b"not found",
}


@pytest.mark.parametrize("damage", DAMAGES.values(), ids=DAMAGES)
def test_a_damaged_batch_is_named_and_flown_again(damage, tmp_path):
    first = evaluate(FLAGSHIP, "pd", TWO, folder=tmp_path)
    (path,) = tmp_path.iterdir()
    path.write_bytes(damage(path.read_bytes()))
    with pytest.warns(UserWarning, match=rf"{path.name} cannot be read: .*; its episodes are flown again$") as caught:
        again = evaluate(FLAGSHIP, "pd", TWO, folder=tmp_path)
    assert len(caught) == 1 and "\n" not in str(caught[0].message) and len(str(caught[0].message)) < 500
    np.testing.assert_equal(again.metrics, first.metrics)
    np.testing.assert_equal(evaluate(FLAGSHIP, "pd", TWO, folder=tmp_path).metrics, first.metrics)


def test_many_may_write_the_same_batch(tmp_path):
    (batch,) = batches(FLAGSHIP, resolve("pd"), TWO, tmp_path)
    result = batch.fly()
    with ThreadPoolExecutor(8) as pool:
        list(pool.map(lambda _: batch.write(result), range(40)))
    np.testing.assert_equal(batch.read(), result)
    assert [item.name for item in tmp_path.iterdir()] == [batch.path.name]


def test_tuned_gains_of_the_base_of_an_agent_count(tmp_path, monkeypatch):
    monkeypatch.setattr(tuned, "FOLDER", tmp_path / "gains")
    (tmp_path / "gains").mkdir()

    def returns(rate_limit):
        record = {"gains": {"rate_limit": rate_limit}, "provenance": {"trials": 1, "scenario": "flagship"}}
        (tmp_path / "gains" / "pd.json").write_text(json.dumps(record))
        if not (tmp_path / "agent").exists():
            write_agent(tmp_path / "agent", Interface(wrappers=(("ResidualPolicy", {"base": "pd", "gains": "tuned"}),)))
        found = evaluate(FLAGSHIP, tmp_path / "agent", TWO, folder=tmp_path / "batches").metrics["return"]
        return found.tolist(), len(list((tmp_path / "batches").iterdir()))

    (first, one), (same, still_one), (other, two) = returns(0.1), returns(0.1), returns(0.01)
    assert first == same and (one, still_one, two) == (1, 1, 2) and first != other


@pytest.mark.parametrize("change", ["baselines/synthesis/stored/flexible.json", "baselines/components/new.py"])
def test_data_and_code_of_the_package_count(change, tmp_path, monkeypatch):
    copy = tmp_path / "ftac_gym"
    shutil.copytree(identity.PACKAGE / "baselines", copy / "baselines")
    monkeypatch.setattr(identity, "PACKAGE", copy)

    def stored():
        identity.package_digest.cache_clear()
        evaluate(FLAGSHIP, "pd", TWO, folder=tmp_path / "batches")
        return len(list((tmp_path / "batches").iterdir()))

    try:
        assert (stored(), stored()) == (1, 1)
        (copy / "baselines/tuned_gains/pd.json").write_text("{}")  # of another baseline than the policy's own gains
        assert stored() == 1
        with (copy / change).open("a") as file:
            file.write("\n")
        assert (stored(), stored()) == (2, 2)
        monkeypatch.setattr(identity, "version", lambda library: "99")
        assert stored() == 3
    finally:
        monkeypatch.undo()
        identity.package_digest.cache_clear()


def test_code_of_kinds_of_faults_from_elsewhere_counts(tmp_path, monkeypatch):
    monkeypatch.setattr(serialization, "_CLASSES", serialization.classes())
    monkeypatch.syspath_prepend(tmp_path)
    path = tmp_path / "rattling.py"
    path.write_text(RATTLE)
    module = import_module("rattling")

    def stored():
        task = FLAGSHIP.replace(faults=FaultDistribution((module.Rattle(onset=1.0),), fault_counts=(0.0, 1.0)))
        evaluate(task, "pd", task.draw(0, 1), folder=tmp_path / "batches")
        return len(list((tmp_path / "batches").glob("*")))

    assert (stored(), stored()) == (1, 1)
    path.write_text(RATTLE.replace("0.1", "0.1000000000001"))
    assert (stored(), stored()) == (2, 2)
    # A class of a notebook has no file, and its older versions cannot be told from it.
    path.unlink()
    assert stored() == 2
    sys.modules.pop("rattling")


def kept(folder):
    """Fly an evaluation of three batches and write its tables; return them."""
    episodes = EPISODES["flagship"]
    items = [evaluate(FLAGSHIP, name, episodes, name, folder / "batches") for name in ("pd", "pd_dob")]
    write_episodes(folder / "episodes.csv", items, episodes)
    write_summary(folder / "summary.csv", tabulate(items, "pd", episodes.feasible))
    return [(folder / f"{name}.csv").read_bytes() for name in ("episodes", "summary")]


def test_a_killed_evaluation_gives_the_tables_of_an_undisturbed_one(tmp_path, monkeypatch):
    program = f"""
        import os, pathlib, signal
        from ftac_gym import scenarios
        from ftac_gym.evaluation import batches
        batches.BATCH, task = 2, scenarios.get("flagship").replace(duration={FLAGSHIP.duration})
        folder = pathlib.Path({str(tmp_path / "killed" / "batches")!r})
        def kill(count, flown=[]):
            flown.append(count)
            if len(flown) == 2:
                os.kill(os.getpid(), signal.SIGKILL)
        batches.evaluate(task, "pd", task.draw(3, 5), "pd", folder, kill)
    """
    killed = subprocess.run([sys.executable, "-c", textwrap.dedent(program)], check=False)
    assert killed.returncode == -signal.SIGKILL
    before = os.listdir(tmp_path / "killed" / "batches")
    assert len(before) == 2
    monkeypatch.setattr(import_module("ftac_gym.evaluation.batches"), "BATCH", 2)
    assert kept(tmp_path / "killed") == kept(tmp_path / "undisturbed")
    after = os.listdir(tmp_path / "killed" / "batches")
    assert len(after) == 6 and set(before) < set(after)
