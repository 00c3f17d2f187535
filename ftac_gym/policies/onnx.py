"""Networks in ONNX files, run by ONNX Runtime."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium import spaces

from ftac_gym.agents.normalizer import Normalizer
from ftac_gym.policies.external import ExternalPolicy
from ftac_gym.utils.extras import require_extra
from ftac_gym.utils.files import reading
from ftac_gym.utils.parameters import require

OUTPUTS = ("action", "actions")
"""Names that tell the action among several outputs."""


def load_onnx(
    path: str | Path,
    observation: str = "attitude",
    hold: int = 1,
    normalizer: Normalizer | None = None,
    wrappers: Sequence[Any] = (),
) -> ExternalPolicy:
    """Load a network from an ONNX file. The file is data: loading executes nothing of its author.

    The network has one input of type float32: observations (N, size), or (1, size) for one spacecraft at a time. Its
    only output, or that of the name ``action`` or ``actions``, is the action (N, k) in [-1, 1]. A deterministic policy
    has no random node.

    Parameters
    ----------
    path
        The file.
    observation
        Information tier on which the network was trained.
    hold
        Control periods for which every action was held.
    normalizer
        Standardisation of the observations, if the network does not contain it.
    wrappers
        Name in :mod:`ftac_gym.wrappers` and arguments of each wrapper of the training, the innermost first.

    Raises
    ------
    ValueError
        If the file is missing or damaged, or has other inputs or outputs.
    MissingExtra
        If ONNX Runtime is not installed.
    """
    return ExternalPolicy(Network(Path(path)), observation, hold, normalizer, wrappers, batched=True)


class Network:
    """A network in an ONNX file, with observations as input and actions as output.

    Parameters
    ----------
    path
        The file. Copies in other processes read it again.

    Raises
    ------
    ValueError
        If the file is missing or damaged, or has other inputs or outputs.
    MissingExtra
        If ONNX Runtime is not installed.
    """

    def __init__(self, path: Path) -> None:
        require_extra("onnxruntime")
        import onnxruntime

        self._path = path.absolute()
        options = onnxruntime.SessionOptions()
        # One thread: the networks are small, and sums depend on the number of threads.
        options.intra_op_num_threads = options.inter_op_num_threads = 1
        options.log_severity_level = 3
        require(path.is_file(), "onnx", "must be an ONNX file", str(path))
        with reading(path, "export it again", Exception):
            self._session = onnxruntime.InferenceSession(str(path), options, providers=["CPUExecutionProvider"])
        inputs = self._session.get_inputs()
        shapes = [(item.type, len(item.shape)) for item in inputs]
        rule = "must have one input of type float32 with the observations (N, size)"
        require(shapes == [("tensor(float)", 2)], f"inputs of {path.name}", rule, shapes)
        outputs = [item.name for item in self._session.get_outputs()]
        chosen = outputs if len(outputs) == 1 else [name for name in outputs if name in OUTPUTS]
        rule = f"must be one, or have one of the names {list(OUTPUTS)}"
        require(len(chosen) == 1, f"outputs of {path.name}", rule, outputs)
        self._input, self._output = inputs[0].name, chosen[0]
        count, size = inputs[0].shape
        self._single = count == 1
        rule = "must have a free first dimension, or 1"
        require(self._single or not isinstance(count, int), f"inputs of {path.name}", rule, inputs[0].shape)
        if isinstance(size, int):
            self.observation_space = spaces.Box(-np.inf, np.inf, (size,), dtype=np.float32)

    def __call__(self, observations: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """Return the actions (N, k) for observations (N, size)."""
        given = np.asarray(observations, dtype=np.float32)
        parts = np.split(given, len(given)) if self._single else [given]
        return np.concatenate([self._session.run([self._output], {self._input: part})[0] for part in parts])

    def __reduce__(self) -> tuple[Any, ...]:
        """Return what makes a copy: sessions cannot be pickled."""
        return partial(Network, self._path), ()
