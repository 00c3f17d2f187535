"""Checkpoints: a restored model is the one that was saved, and reading it executes nothing."""

import shutil
import sys

import numpy as np
import pytest
import torch
from helpers.tiny_models import RESIDUAL, model_of

from ftac_gym.agents.agent import Agent
from ftac_gym.agents.interface import Interface
from ftac_gym.training.checkpoints import checkpoints, restore_checkpoint, save_checkpoint
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


def test_only_the_newest_checkpoint_has_the_buffer_and_all_fly(tmp_path):
    model, _ = model_of("tqc", INTERFACE)
    for _ in range(3):
        model.learn(20, reset_num_timesteps=False)
        save_checkpoint(tmp_path, model, INTERFACE, {"steps": model.num_timesteps})
    found = checkpoints(tmp_path)
    assert [path.name for path in found] == ["0000000020", "0000000040", "0000000060"]
    assert [(path / "replay_buffer.npz").exists() for path in found] == [False, False, True]
    assert all(Agent.load(path).normalizer is not None for path in found)
    with pytest.raises(ValueError, match=r"replay_buffer\.npz cannot be read: .*only the newest checkpoint has one"):
        restore_checkpoint(found[1], model)


def test_damaged_checkpoints_are_refused_in_a_line(tmp_path):
    model, _ = model_of("sac", INTERFACE)
    model.learn(60)
    save_checkpoint(tmp_path / "run", model, INTERFACE, {})
    (good,) = checkpoints(tmp_path / "run")
    for name, file in enumerate(("training.safetensors", "replay_buffer.npz", "card.json")):
        for keep in (0.0, 0.5, 0.99):
            copy = tmp_path / f"{name}_{keep}"
            shutil.copytree(good, copy)
            whole = (good / file).read_bytes()
            (copy / file).write_bytes(whole[: int(keep * len(whole))])
            with pytest.raises(ValueError, match=rf"{file} cannot be read: .*; ") as caught:
                restore_checkpoint(copy, model)
            assert len(str(caught.value)) < 700 and "\n" not in str(caught.value)
    other, _ = model_of("sac", INTERFACE, buffer_size=20)
    with pytest.raises(ValueError, match="observations must fit"):
        restore_checkpoint(good, other)
    (good / "training.safetensors").unlink()
    with pytest.raises(
        ValueError, match=r"checkpoint must have training\.safetensors, which those of earlier versions"
    ):
        restore_checkpoint(good, model)


def test_what_is_no_checkpoint(tmp_path):
    for name in ("0000000512.partial", "0000000256_backup", "latest", "256", "0000001024", "0000000512"):
        (tmp_path / "checkpoints" / name).mkdir(parents=True)
    assert [path.name for path in checkpoints(tmp_path)] == ["0000000512", "0000001024"]
