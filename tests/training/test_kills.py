"""Trainings that are killed between any two file operations of their saves, and resumed."""

import math
import os
import re
import sys
from types import SimpleNamespace

import pytest
import torch
from helpers.untrained_agents import model_with
from stable_baselines3.common.logger import Logger

from ftac_gym.agents.agent import Agent
from ftac_gym.agents.interface import Interface
from ftac_gym.agents.shipped import evaluations
from ftac_gym.agents.storage import read_card
from ftac_gym.training.callbacks import Schedule, TrainingCallback
from ftac_gym.training.checkpoints import checkpoints, restore_newest
from ftac_gym.training.evaluations import Evaluations

try:
    import resource
except ImportError:  # Windows
    resource = None

OPERATIONS = {"open", "os.rename", "os.remove", "os.mkdir", "os.rmdir"}
SCHEDULE = Schedule(evaluate_every=1, checkpoint_every=2, evaluation_episodes=1, critic_warmup=0)
END = 4
FIRST = {1: 3.0, 2: 5.0, 3: 9.0, 4: 7.0}
"""Mean returns by steps, of which the best lies between two checkpoints."""
AGAIN = {1: 2.0, 2: 1.0, 3: 4.0, 4: 6.0}
"""Those of a resumed run, which is another."""


@pytest.fixture(scope="module")
def model():
    return model_with(Interface())


def run(folder, model, returns, end=END):
    """Do what a training does at its files: its actor's weights are its steps."""
    model.num_timesteps = 0
    if checkpoints(folder):
        restore_newest(folder, model)
    if model.num_timesteps == end:
        return
    callback = TrainingCallback(
        folder, Evaluations(folder, model.num_timesteps), lambda _: {"mean_return": returns[model.num_timesteps]},
        Interface(), SCHEDULE, lambda steps: {"steps": steps, "training_seconds": steps},
    )  # fmt: skip
    callback.init_callback(model)
    callback.on_training_start({}, {})
    for steps in range(model.num_timesteps + 1, end + 1):
        model.num_timesteps = steps
        with torch.no_grad():
            model.policy.action_net.weight.fill_(steps)
        if steps < end:
            callback.on_rollout_start()
    callback.on_training_end()


class Killed(BaseException):
    """End of a process as its files see it: from now on it changes none, not even to clean up."""


@pytest.fixture(scope="module")
def process():
    """Return the state of a process whose operations on the files in a folder are counted until it is killed."""
    state = SimpleNamespace(folder=None, left=0)

    def watch(event, args):
        if state.folder is None or event not in OPERATIONS or str(state.folder) not in str(args[0]):
            return
        state.left -= event != "open" or args[1] not in ("r", "rb")  # reading changes nothing
        if state.left <= 0:
            raise Killed

    sys.addaudithook(watch)
    return state


def killed_at(operation, process, folder, model):
    """Run until the process dies before one of its operations on files; return whether it came so far."""
    process.folder, process.left = folder, operation
    try:
        run(folder, model, FIRST)
    except Killed:
        return True
    finally:
        process.folder = None
    return False


def check(folder):
    """Check that the agent is whole and agrees with the table; return its steps and mean return."""
    if not (folder / "agent" / "card.json").exists():
        return 0, -math.inf
    agent, card = Agent.load(folder / "agent"), read_card(folder / "agent")
    assert (agent.policy.action_net.weight == card["steps"]).all()
    return card["steps"], card["evaluation"]["mean_return"]


def test_the_best_agent_survives_a_kill_at_any_moment(tmp_path, model, process, monkeypatch):
    monkeypatch.setattr(os, "fsync", lambda _: None)  # slow, and no matter of processes
    model.set_logger(Logger(None, []))
    kept = set()
    for operation in range(1, 1000):
        folder = tmp_path / str(operation)
        if not killed_at(operation, process, folder, model):
            break
        before = check(folder)
        kept.add(before[0])
        run(folder, model, AGAIN)
        # The resumed run repeats the evaluations after the last checkpoint, and the best of all is kept.
        steps, best = check(folder)
        rows = {int(row["steps"]): row["mean_return"] for row in evaluations(folder)}
        assert best >= before[1] and rows[steps] == best == max(rows.values())
        assert list(rows) == sorted(rows) == [1, 2, 3, 4]
        assert read_card(folder / "agent")["run_steps"] == END
        assert [int(path.name) for path in checkpoints(folder)] == [0, 2, 4]
        assert not list(folder.rglob("*.partial"))
    assert operation > 30 and kept == {0, 1, 2, 3}


@pytest.mark.skipif(resource is None, reason="needs limits of files")
@pytest.mark.parametrize("size", [0, 2000])
def test_a_full_disk_ends_the_run_with_the_name_of_a_file_and_what_was_there_is_whole(size, tmp_path, model):
    run(tmp_path, model, {1: 3.0, 2: 5.0, 3: 5.0, 4: 5.0}, end=2)
    before = check(tmp_path)
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, limits[1]))
    try:
        with pytest.raises(OSError, match=re.escape(str(tmp_path))):
            run(tmp_path, model, {3: 9.0, 4: 7.0})
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert check(tmp_path) == before == (2, 5.0) and not list(tmp_path.rglob("*.partial"))
    run(tmp_path, model, {3: 9.0, 4: 7.0})
    assert check(tmp_path) == (3, 9.0)
