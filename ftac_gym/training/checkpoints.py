"""Checkpoints of a training: the agent, and all else that its algorithm needs to continue. Nothing in them is code."""

from __future__ import annotations

import re
import zipfile
from collections.abc import Mapping
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
from ftac_gym.utils.files import appearing, reading, replacing
from ftac_gym.utils.parameters import require

TRAINING_FILE = "training.safetensors"
"""File in a checkpoint: counters, optimisers and statistics of returns."""

REPLAY_FILE = "replay_buffer.npz"
"""File in the newest checkpoint of an off-policy run: the filled part of the replay buffer."""

_COUNTERS = ("num_timesteps", "_n_updates", "_episode_num")
_REMEDY = "remove this checkpoint to resume from the one before, or start again in a new --run-folder"
_REMEDY_REPLAY = "restore it from a copy, for only the newest checkpoint has one, or start again in a new --run-folder"


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
    with appearing(folder / "checkpoints" / f"{model.num_timesteps:010d}") as partial:
        Agent.of(model, interface).save(partial, **provenance)
        with replacing(partial / TRAINING_FILE) as file:
            file.write(save(_training_state(model)))
        if (buffer := getattr(model, "replay_buffer", None)) is not None:
            with replacing(partial / REPLAY_FILE) as file:
                filled: Any = {name: values[: buffer.size()] for name, values in _arrays(buffer)}
                np.savez(file, pos=buffer.pos, **filled)
    for older in checkpoints(folder)[:-1]:
        (older / REPLAY_FILE).unlink(missing_ok=True)


def restore_checkpoint(checkpoint: Path, model: BaseAlgorithm) -> dict[str, Any]:
    """Give the state of a checkpoint to a model as it was built for the run, and return the card of the agent.

    Episodes and random numbers start anew.

    Raises
    ------
    ValueError
        If a file is missing, damaged or of another design; the message is one line with file and remedy.
    """
    path = checkpoint / TRAINING_FILE
    rule = f"must have {TRAINING_FILE}, which those of earlier versions lack: start again in a new --run-folder"
    require(path.is_file(), "checkpoint", rule, str(checkpoint))
    stored = read_agent(checkpoint)
    with reading(path, _REMEDY, SafetensorError, RuntimeError):
        state = load(path.read_bytes())
        for name, values in state.items():
            require(bool(torch.isfinite(values).all()), name, "must be finite", values)
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
        _restore_buffer(checkpoint / REPLAY_FILE, buffer)
    return read_card(checkpoint)


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
    with (
        reading(path, _REMEDY_REPLAY, zipfile.BadZipFile),
        path.open("rb") as file,
        np.load(file, allow_pickle=False) as stored,
    ):
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
