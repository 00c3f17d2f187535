"""Checkpoints: a restored model is the one that was saved, and reading it executes nothing."""

import sys
from pathlib import Path

import numpy as np
import pytest
import torch
from helpers.tiny_models import NUM_ENVS, RESIDUAL, model_of

from ftac_gym.agents.agent import Agent
from ftac_gym.agents.interface import Interface
from ftac_gym.training.checkpoints import (
    checkpoints,
    naming_divergence,
    restore_checkpoint,
    restore_newest,
    save_checkpoint,
)
from ftac_gym.training.hyperparameters import ALGORITHMS

INTERFACE = Interface(wrappers=RESIDUAL)
ARRAYS = ("observations", "next_observations", "actions", "rewards", "dones", "timeouts")
FOUND = []
"""Classes that unpickling looks up while the list is watched."""


@pytest.fixture(scope="module", autouse=True)
def watched():
    sys.addaudithook(lambda event, args: FOUND.append(args) if event == "pickle.find_class" else None)


def state_of(model):
    """Return everything on which the further training of a model depends, as arrays by name."""
    found = {}

    def gather(name, value):
        if isinstance(value, dict):
            for key, item in value.items():
                gather(f"{name}/{key}", item)
        elif isinstance(value, (list, tuple)):
            gather(name, dict(enumerate(value)))
        else:
            found[name] = value.detach().numpy() if isinstance(value, torch.Tensor) else np.asarray(value)

    gather("parameters", model.get_parameters())
    gather("variables", {name: getattr(model, name) for name in model._get_torch_save_params()[1]})
    gather("counters", [model.num_timesteps, model._n_updates, model._episode_num])
    normalizer = model.get_vec_normalize_env()
    gather("normalizer", [vars(normalizer.obs_rms), vars(normalizer.ret_rms)])
    if (buffer := getattr(model, "replay_buffer", None)) is not None:
        gather("buffer", [buffer.pos, buffer.full, *(getattr(buffer, name)[: buffer.size()] for name in ARRAYS)])
    return found


def assert_same(one, other):
    first, second = state_of(one), state_of(other)
    assert first.keys() == second.keys()
    for name, values in first.items():
        np.testing.assert_array_equal(values, second[name], err_msg=name)


def learn_on(model, steps):
    """Continue a training with episodes and random numbers of a seed."""
    model._last_obs = None
    model.set_random_seed(5)
    model.env.seed(7)
    model.learn(steps, reset_num_timesteps=False)


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_a_restored_model_goes_on_as_the_one_before(algorithm, tmp_path):
    settings = {"batch_size": 16, "learning_rate": "lin_0.001", **({"n_epochs": 2} if "ppo" in algorithm else {})}
    model, _ = model_of(algorithm, INTERFACE, **settings)
    model.learn(80)
    save_checkpoint(tmp_path, model, INTERFACE, {"steps": 80})
    other, _ = model_of(algorithm, INTERFACE, seed=2, **settings)
    (folder,) = checkpoints(tmp_path)
    FOUND.clear()
    assert restore_checkpoint(folder, other)["steps"] == 80
    assert not FOUND, "files that can hold code were read"
    assert_same(model, other)
    for item in (model, other):
        learn_on(item, 64)
    assert model.num_timesteps == 160 if "ppo" in algorithm else 144
    assert_same(model, other)


def test_a_full_buffer_goes_on_where_it_was_written_last(tmp_path):
    model, _ = model_of("sac", INTERFACE, buffer_size=60, learning_starts=10_000)
    model.learn(80)
    assert model.replay_buffer.full and 0 < model.replay_buffer.pos < 15
    save_checkpoint(tmp_path, model, INTERFACE, {})
    other, _ = model_of("sac", INTERFACE, buffer_size=60, learning_starts=10_000)
    restore_checkpoint(checkpoints(tmp_path)[0], other)
    assert_same(model, other)


@pytest.fixture
def three(tmp_path):
    """Return a model, and the folder of its run with checkpoints of 20, 40 and 60 steps."""
    model, _ = model_of("sac", INTERFACE)
    for _ in range(3):
        model.learn(20, reset_num_timesteps=False)
        save_checkpoint(tmp_path, model, INTERFACE, {"steps": model.num_timesteps})
    return model, tmp_path


def names_of(folder):
    return sorted(path.name for path in (folder / "checkpoints").iterdir())


def test_only_the_newest_checkpoint_has_the_buffer_and_all_fly(three):
    found = checkpoints(three[1])
    assert [path.name for path in found] == ["0000000020", "0000000040", "0000000060"]
    assert [(path / "replay_buffer.npz").exists() for path in found] == [False, False, True]
    assert all(Agent.load(path).normalizer is not None for path in found)


def flip(path):
    """Change one bit in the middle of a file."""
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    path.write_bytes(data)


@pytest.mark.parametrize("damage", [Path.unlink, flip, lambda path: path.write_bytes(path.read_bytes()[:-9])])
@pytest.mark.parametrize("file", ["training.safetensors", "checkpoint.json", "card.json", "weights-*"])
def test_a_damaged_checkpoint_is_passed_over_and_named(file, damage, three, capsys):
    model, folder = three
    newest = checkpoints(folder)[-1]
    damage(next(newest.glob(file)))
    (folder / "checkpoints" / "9999999999").mkdir()
    assert restore_newest(folder, model)["steps"] == 40 == model.num_timesteps
    buffer, delay, stray, passed = capsys.readouterr().out.splitlines()
    assert stray.startswith("checkpoint 9999999999 is passed over, and now 9999999999.damaged: ")
    assert passed.startswith("checkpoint 0000000060 is passed over, and now 0000000060.damaged: ")
    assert len(passed) < 700 and "train the agent again" not in passed and "--run-folder" not in passed
    assert names_of(folder) == ["0000000020", "0000000040", "0000000060.damaged", "9999999999.damaged"]
    assert "replay_buffer.npz cannot be read" in buffer and delay.startswith("learning starts after 40 more decisions")
    # The run makes a checkpoint of the same name once more.
    model.learn(20, reset_num_timesteps=False)
    save_checkpoint(folder, model, INTERFACE, {"steps": 60})
    assert restore_newest(folder, model)["steps"] == 60


def test_without_a_whole_checkpoint_all_stay_as_they_are(three):
    model, folder = three
    for path in checkpoints(folder):
        (path / "training.safetensors").unlink()
    with pytest.raises(ValueError, match=r"can be used; start again in a new --run-folder\. The newest: .*60.training"):
        restore_newest(folder, model)
    assert names_of(folder) == ["0000000020", "0000000040", "0000000060"]


@pytest.mark.parametrize("damage", [Path.unlink, flip])
def test_a_lost_buffer_is_filled_by_the_agent_itself_before_it_learns(damage, three, capsys, monkeypatch):
    model, folder = three
    damage(checkpoints(folder)[-1] / "replay_buffer.npz")
    assert restore_newest(folder, model)["steps"] == 60 and model.replay_buffer.size() == 0
    lost, delay = capsys.readouterr().out.splitlines()
    assert "replay_buffer.npz cannot be read: " in lost and lost.endswith("; the replay buffer starts empty")
    assert delay == "learning starts after 40 more decisions, flown by the agent itself"
    flown, learnt = [], []
    predict = model.predict
    monkeypatch.setattr(model, "predict", lambda *args, **kwargs: flown.append(1) or predict(*args, **kwargs))
    monkeypatch.setattr(model, "train", lambda *args, **kwargs: learnt.append(model.num_timesteps))
    model.learn(60, reset_num_timesteps=False)
    assert len(flown) == 60 // NUM_ENVS and min(learnt) == 60 + 40 + NUM_ENVS


def test_a_buffer_of_another_size_is_named(three, capsys):
    _, folder = three
    other, _ = model_of("sac", INTERFACE, buffer_size=20)
    restore_newest(folder, other)
    assert "replay_buffer.npz cannot be read: observations must fit" in capsys.readouterr().out
    assert other.replay_buffer.size() == 0


def test_another_network_does_not_set_checkpoints_aside(three):
    other, _ = model_of("tqc", INTERFACE)
    with pytest.raises(ValueError, match=r"no checkpoint of .* can be used"):
        restore_newest(three[1], other)
    assert len(names_of(three[1])) == 3


def test_a_diverged_model_is_no_checkpoint_and_one_line(three):
    model, folder = three
    with torch.no_grad():
        model.log_ent_coef.fill_(float("nan"))
    message = r"the training diverged: .* after 60 steps; .* lower"
    with pytest.raises(FloatingPointError, match=message) as caught, naming_divergence(model):
        save_checkpoint(folder, model, INTERFACE, {})
    assert "\n" not in str(caught.value) and names_of(folder) == ["0000000020", "0000000040", "0000000060"]


def test_huge_weights_have_diverged_too(three):
    with torch.no_grad():
        next(three[0].policy.parameters()).fill_(-1e7)
    with pytest.raises(FloatingPointError, match="the training diverged: "), naming_divergence(three[0]):
        raise ValueError("Expected parameter loc to satisfy the constraint Real()")


def test_another_error_of_a_training_is_as_it_was(three):
    with pytest.raises(KeyError, match="another"), naming_divergence(three[0]):
        raise KeyError("another")


def test_what_is_no_checkpoint(tmp_path):
    for name in ("0000000512.partial", "0000000256_backup", "latest", "256", "0000001024", "0000000512"):
        (tmp_path / "checkpoints" / name).mkdir(parents=True)
    assert [path.name for path in checkpoints(tmp_path)] == ["0000000512", "0000001024"]
