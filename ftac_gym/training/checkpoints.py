"""Checkpoints of a training: the agent, and all else that its algorithm needs to continue. Nothing in them is code."""

from __future__ import annotations

import hashlib
import itertools
import json
import os
import re
import zipfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import torch
from safetensors import SafetensorError
from safetensors.torch import load, save
from stable_baselines3.common.base_class import BaseAlgorithm

from ftac_gym.agents.agent import Agent
from ftac_gym.agents.interface import Interface
from ftac_gym.agents.storage import read_agent, read_card
from ftac_gym.training.algorithms import refill
from ftac_gym.utils.files import appearing, reading, replacing, write_text
from ftac_gym.utils.parameters import require
from ftac_gym.utils.serialization import parse_json

TRAINING_FILE = "training.safetensors"
"""File in a checkpoint: counters, optimisers and statistics of returns."""

REPLAY_FILE = "replay_buffer.npz"
"""File in the newest checkpoint of an off-policy run: the filled part of the replay buffer."""

_COUNTERS = ("num_timesteps", "_n_updates", "_episode_num")

CONTENT_FILE = "checkpoint.json"
"""File in a checkpoint: SHA-256 of the files beside those of the agent, whose card has its own."""

DAMAGED = ".damaged"
"""Suffix of a checkpoint that a resumed run has passed over. It is never read."""

_REMEDY = "restore it from a copy to use this checkpoint"

DIVERGED = 1e6
"""Size of a weight that no training returns from: the sums of a layer then overflow soon."""


def checkpoints(folder: Path) -> list[Path]:
    """Return the complete checkpoints of a run, oldest first."""
    found = [path for path in (folder / "checkpoints").glob("*") if re.fullmatch("[0-9]{10,}", path.name)]
    return sorted(found, key=lambda path: int(path.name))


def save_checkpoint(folder: Path, model: BaseAlgorithm, interface: Interface, provenance: Mapping[str, Any]) -> None:
    """Write a checkpoint of a run, named by its steps; it appears complete or not at all.

    Parameters
    ----------
    folder
        Folder of the run.
    model
        The model, between two rollouts.
    interface, provenance
        Those of the agent.
    """
    require(
        is_finite(model), "model", "must have finite weights and statistics", f"others at {model.num_timesteps} steps"
    )
    with appearing(folder / "checkpoints" / f"{model.num_timesteps:010d}") as partial:
        Agent.of(model, interface).save(partial, **provenance)
        with replacing(partial / TRAINING_FILE) as file:
            file.write(save(_training_state(model)))
        if (buffer := getattr(model, "replay_buffer", None)) is not None:
            with replacing(partial / REPLAY_FILE) as file:
                filled: Any = {name: values[: buffer.size()] for name, values in _arrays(buffer)}
                np.savez(file, pos=buffer.pos, **filled)
        written = [path for name in (TRAINING_FILE, REPLAY_FILE) if (path := partial / name).exists()]
        write_text(partial / CONTENT_FILE, json.dumps({path.name: _sha256(path) for path in written}, indent=2) + "\n")
    for older in checkpoints(folder)[:-1]:
        (older / REPLAY_FILE).unlink(missing_ok=True)


def restore_newest(folder: Path, model: BaseAlgorithm) -> dict[str, Any]:
    """Give the state of the newest whole checkpoint of a run to a model, as :func:`restore_checkpoint` does.

    Newer ones, which are damaged or strays, are set aside under another name, each with a printed line.

    Raises
    ------
    ValueError
        If no checkpoint is whole; all stay as they are.
    """
    passed: list[tuple[Path, ValueError]] = []
    for checkpoint in reversed(checkpoints(folder)):
        try:
            card = restore_checkpoint(checkpoint, model)
        except ValueError as error:
            passed.append((checkpoint, error))
            continue
        for path, reason in passed:
            print(f"checkpoint {path.name} is passed over, and now {_set_aside(path).name}: {reason}")  # noqa: T201
        return card
    newest = f" The newest: {passed[0][1]}" if passed else ""
    raise ValueError(f"no checkpoint of {folder} can be used; start again in a new --run-folder.{newest}")


def restore_checkpoint(checkpoint: Path, model: BaseAlgorithm) -> dict[str, Any]:
    """Give the state of a checkpoint to a model as it was built for the run, and return the card of the agent.

    Episodes and random numbers start anew. A replay buffer that is missing or damaged is replaced by an empty one, with
    a printed line; the agent's own flights fill it before learning goes on.

    Raises
    ------
    ValueError
        If another file is missing, damaged or of another design; the message is one line with file and remedy.
    """
    stored, card = read_agent(checkpoint, _REMEDY), read_card(checkpoint, _REMEDY)
    content = checkpoint / CONTENT_FILE
    rule = f"must have {CONTENT_FILE}, which those of earlier versions lack; {_REMEDY}"
    require(content.is_file(), "checkpoint", rule, str(checkpoint))
    with reading(content, _REMEDY):
        expected = parse_json(content.read_bytes())
        known = isinstance(expected, dict) and TRAINING_FILE in expected
        require(known, CONTENT_FILE, f"must have the SHA-256 of {TRAINING_FILE}", expected)
    path = checkpoint / TRAINING_FILE
    with reading(path, _REMEDY, SafetensorError, RuntimeError):
        _check_content(path, expected)
        state = load(path.read_bytes())
        for name, values in state.items():
            require(bool(torch.isfinite(values).all()), name, "must be finite", values)
        steps = int(state["num_timesteps"])
        require(steps == int(checkpoint.name), "num_timesteps", f"must be those of the name {checkpoint.name}", steps)
        model.policy.load_state_dict(stored.policy.state_dict())
        _restore_training(model, state)
        normalizer: Any = model.get_vec_normalize_env()
        same = (normalizer is None) == (stored.normalizer is None)
        require(same, "normalizer", "must be in the checkpoint if the run has one", stored.normalizer)
        if stored.normalizer is not None:
            statistics = normalizer.obs_rms
            statistics.mean, statistics.var = stored.normalizer.mean.copy(), stored.normalizer.variance.copy()
            statistics.count = stored.normalizer.count
    if (buffer := getattr(model, "replay_buffer", None)) is not None:
        remedy = "the replay buffer starts empty"
        try:
            with reading(checkpoint / REPLAY_FILE, remedy, zipfile.BadZipFile):
                _check_content(checkpoint / REPLAY_FILE, expected)
                _restore_buffer(checkpoint / REPLAY_FILE, buffer)
        except ValueError as error:
            buffer.reset()
            print(error)  # noqa: T201
        if lacking := refill(model):
            print(f"learning starts after {lacking} more decisions, flown by the agent itself")  # noqa: T201
    return card


def is_finite(model: BaseAlgorithm) -> bool:
    """Return whether all weights of a model, and all else that its training depends on, are finite."""
    state = {**model.policy.state_dict(), **_training_state(model)}
    return all(bool(torch.isfinite(values).all()) for values in state.values())


@contextmanager
def naming_divergence(model: BaseAlgorithm) -> Iterator[None]:
    """Turn any error of a training whose weights have diverged into one line.

    Raises
    ------
    FloatingPointError
        In the place of the error.
    """
    try:
        yield
    except Exception as error:
        weights = [value.abs().max().item() for value in model.policy.state_dict().values() if value.numel()]
        if is_finite(model) and max(weights) < DIVERGED:
            raise
        remedy = "the best agent and the checkpoints before are whole; try a lower learning rate"
        weights_are = f"weights are not finite or beyond {DIVERGED:g} after {model.num_timesteps} steps"
        raise FloatingPointError(f"the training diverged: {weights_are}; {remedy}") from error


def _sha256(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _check_content(path: Path, expected: Mapping[str, Any]) -> None:
    found = _sha256(path)
    require(found == expected.get(path.name), "SHA-256", f"must be that of {CONTENT_FILE}", found)


def _set_aside(checkpoint: Path) -> Path:
    """Give a checkpoint a name that is none of a checkpoint, and return its new path."""
    names = (checkpoint.with_name(f"{checkpoint.name}{DAMAGED}{number or ''}") for number in itertools.count())
    return checkpoint.rename(next(path for path in names if not os.path.lexists(path)))


def _parts(model: BaseAlgorithm) -> tuple[dict[str, torch.optim.Optimizer], dict[str, torch.Tensor]]:
    """Return the optimisers and the further parameters of a model, by name."""
    names, variables = model._get_torch_save_params()
    found = {name: _attribute(model, name) for name in [*names, *variables]}
    optimizers = {name: part for name, part in found.items() if isinstance(part, torch.optim.Optimizer)}
    return optimizers, {name: found[name] for name in variables}


def _attribute(model: Any, path: str) -> Any:
    for name in path.split("."):
        model = getattr(model, name)
    return model


def _training_state(model: BaseAlgorithm) -> dict[str, torch.Tensor]:
    """Return what a model needs to continue beside its policy and observation statistics."""
    optimizers, variables = _parts(model)
    state = {name: torch.tensor(getattr(model, name)) for name in _COUNTERS}
    state |= {name: values.detach().clone() for name, values in variables.items()}
    for name, optimizer in optimizers.items():
        content = optimizer.state_dict()
        rates = [group["lr"] for group in content["param_groups"]]
        state[f"{name}/lr"] = torch.tensor(rates, dtype=torch.float64)
        for index, entries in content["state"].items():
            state |= {f"{name}/{index}/{entry}": values.clone() for entry, values in entries.items()}
    if (normalizer := model.get_vec_normalize_env()) is not None:
        for entry in ("mean", "var", "count"):
            value = getattr(normalizer.ret_rms, entry)
            state[f"returns/{entry}"] = torch.tensor(float(value), dtype=torch.float64)
    return state


def _restore_training(model: BaseAlgorithm, state: Mapping[str, torch.Tensor]) -> None:
    optimizers, variables = _parts(model)
    for name in _COUNTERS:
        setattr(model, name, int(state[name]))
    for name, values in variables.items():
        values.data.copy_(state[name])
    for name, optimizer in optimizers.items():
        content = optimizer.state_dict()
        for group, rate in zip(content["param_groups"], state[f"{name}/lr"].tolist(), strict=True):
            group["lr"] = rate
        entries: dict[int, dict[str, torch.Tensor]] = {}
        for key, values in state.items():
            if found := re.fullmatch(re.escape(name) + "/([0-9]+)/(.*)", key):
                entries.setdefault(int(found[1]), {})[found[2]] = values
        optimizer.load_state_dict({**content, "state": entries})
    if (normalizer := model.get_vec_normalize_env()) is not None:
        for entry in ("mean", "var", "count"):
            setattr(normalizer.ret_rms, entry, state[f"returns/{entry}"].numpy().copy())


def _arrays(buffer: Any) -> list[tuple[str, np.ndarray]]:
    """Return the arrays (entries, environments, ...) of a replay buffer."""
    names = ("observations", "next_observations", "actions", "rewards", "dones", "timeouts")
    return [(name, getattr(buffer, name)) for name in names if hasattr(buffer, name)]


def _restore_buffer(path: Path, buffer: Any) -> None:
    with path.open("rb") as file, np.load(file, allow_pickle=False) as stored:
        size = len(stored["rewards"])
        for name, into in _arrays(buffer):
            values = stored[name]
            fits = values.dtype == into.dtype and values.shape == (size, *into.shape[1:]) and size <= len(into)
            require(fits, name, f"must fit {into.shape} of {into.dtype}", f"{values.shape} of {values.dtype}")
            require(bool(np.isfinite(values).all()), name, "must be finite", "another value")
            into[:size] = values
        buffer.full, buffer.pos = size == buffer.buffer_size, int(stored["pos"])
        expected = range(size) if buffer.full else [size]
        require(buffer.pos in expected, "pos", f"must be within the {size} entries", buffer.pos)
