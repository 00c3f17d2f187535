"""Networks of policies as data: class, arguments and spaces as JSON, weights as named arrays."""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Mapping
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from gymnasium.spaces import Box

from ftac_gym.utils.extras import require_extra
from ftac_gym.utils.parameters import require, whole
from ftac_gym.utils.tables import check_finite

if TYPE_CHECKING:
    from stable_baselines3.common.policies import BasePolicy

Array = npt.NDArray[Any]
Description = dict[str, Any]
"""Plain data from which :func:`build` makes a network."""

_ON_POLICY = ("net_arch", "activation_fn", "use_sde", "full_std", "use_expln", "squash_output")
_OFF_POLICY = ("net_arch", "activation_fn", "use_sde", "use_expln", "clip_mean", "n_critics")
_LSTM = ("lstm_hidden_size", "n_lstm_layers", "shared_lstm", "enable_critic_lstm")

POLICIES: dict[str, tuple[str, tuple[str, ...]]] = {
    "ActorCriticPolicy": ("stable_baselines3.common.policies", _ON_POLICY),
    "PrivilegedCriticPolicy": ("ftac_gym.training.networks", (*_ON_POLICY, "actor_size")),
    "RecurrentActorCriticPolicy": ("sb3_contrib.common.recurrent.policies", (*_ON_POLICY, *_LSTM)),
    "SACPolicy": ("stable_baselines3.sac.policies", _OFF_POLICY),
    "TD3Policy": ("stable_baselines3.td3.policies", ("net_arch", "activation_fn", "n_critics")),
    "TQCPolicy": ("sb3_contrib.tqc.policies", (*_OFF_POLICY, "n_quantiles")),
}
"""Classes of policies that an agent can have: module, and those arguments on which its function of weights depends."""

ACTIVATIONS = (
    "CELU", "ELU", "GELU", "Hardswish", "Hardtanh", "Identity", "LeakyReLU", "Mish", "ReLU", "ReLU6", "SELU", "SiLU",
    "Sigmoid", "Softplus", "Softsign", "Tanh",
)  # fmt: skip
"""Activation functions of hidden layers, by their name in ``torch.nn``."""

ZIP = "an agent's files hold no code: keep such a model as Stable-Baselines3's own zip (model.save)"
"""Remedy for networks that cannot be described."""


def describe(policy: BasePolicy) -> tuple[Description, dict[str, Array]]:
    """Return a policy of Stable-Baselines3 as plain data and named weights.

    Raises
    ------
    ValueError
        If it has a class or an argument that is not data, or weights that are not finite.
    """
    name = type(policy).__name__
    known = name in POLICIES and type(policy).__module__ == POLICIES[name][0]
    require(known, "policy", f"must be one of {list(POLICIES)}; {ZIP}", f"{type(policy).__module__}.{name}")
    given = {"full_std": True, "use_expln": False, "squash_output": False, **_arguments(policy)}
    extractor = given["features_extractor_class"].__name__, given["features_extractor_kwargs"]
    require(extractor == ("FlattenExtractor", {}), "features_extractor_class", f"must be the default; {ZIP}", extractor)
    lstm = getattr(policy, "lstm_kwargs", {})
    require(not lstm, "lstm_kwargs", f"must be empty; {ZIP}", lstm)
    activation = given["activation_fn"]
    require(activation in _activations().values(), "activation_fn", f"must be one of {ACTIVATIONS}; {ZIP}", activation)
    given["activation_fn"] = activation.__name__
    arguments = {item: _RULES[item](given[item], item) for item in POLICIES[name][1]}
    spaces = {item: _bounds_of(getattr(policy, item), item) for item in ("observation_space", "action_space")}
    weights = {key: value.detach().cpu().numpy().copy() for key, value in policy.state_dict().items()}
    for key, value in weights.items():
        check_finite(value, key)
    return {**spaces, "policy": name, "arguments": arguments}, weights


def build(description: Description, weights: Mapping[str, Array]) -> BasePolicy:
    """Return the policy that :func:`describe` was given, bit for bit, without a change of any global state.

    Raises
    ------
    ValueError
        If the data do not describe a network, or the weights are not those of this network.
    MissingExtra
        If Stable-Baselines3, or sb3-contrib for its policies, is not installed.
    """
    require_extra("torch", "stable_baselines3")
    import torch
    from torch.overrides import TorchFunctionMode

    drawn = random.getstate()
    kind, arguments = constructor(description)
    random.setstate(drawn)  # rich, which Stable-Baselines3 imports, draws when it is imported first
    # Orthogonal initial weights take most of the time and are replaced.
    arguments |= {"ortho_init": False} if "full_std" in arguments else {}
    spaces = [_box_of(description[item], item) for item in ("observation_space", "action_space")]
    for key, value in weights.items():
        check_finite(value, key)
    left = 4 * sum(value.size for value in weights.values())  # matrices of exploration are as large as weights

    class Bounded(TorchFunctionMode):
        """Refusal of a network far larger than its weights, before it takes memory."""

        def __torch_function__(self, function: Any, types: Any, args: Any = (), kwargs: Any = None) -> Any:
            nonlocal left
            if function is torch.empty and args:
                left -= math.prod(args[0]) if isinstance(args[0], (tuple, list)) else math.prod(args)
                require(left >= 0, "arguments", "must be of a network that has these weights", description["arguments"])
            return function(*args, **(kwargs or {}))

    with torch.random.fork_rng(devices=[]), Bounded():
        policy: BasePolicy = kind(*spaces, lambda _: 0.0, **arguments)
    expected = policy.state_dict()
    require(set(weights) == set(expected), "weights", f"must be {sorted(expected)}", sorted(weights))
    for key, value in expected.items():
        rule = f"must be {tuple(value.shape)} of float32"
        fits = weights[key].shape == tuple(value.shape) and weights[key].dtype == np.float32
        require(fits, key, rule, f"{weights[key].shape} of {weights[key].dtype}")
    policy.load_state_dict({key: torch.from_numpy(np.array(value)) for key, value in weights.items()})
    policy.set_training_mode(False)
    return policy


def constructor(description: Description) -> tuple[Any, dict[str, Any]]:
    """Return the class of a network and its arguments without the spaces, which have been checked.

    Raises
    ------
    ValueError
        If one is unknown or breaks a rule.
    """
    keys = ["observation_space", "action_space", "policy", "arguments"]
    whole_one = isinstance(description, dict) and set(description) == set(keys)
    require(whole_one, "network", f"must have {keys}", description)
    name, given = description["policy"], description["arguments"]
    require(name in list(POLICIES), "policy", f"must be one of {list(POLICIES)}", name)
    module, names = POLICIES[name]
    require(isinstance(given, dict) and set(given) == set(names), "arguments", f"must be those of {names}", given)
    arguments = {item: _RULES[item](given[item], item) for item in names}
    activation = arguments["activation_fn"]
    require(activation in ACTIVATIONS, "activation_fn", f"must be one of {ACTIVATIONS}", activation)
    arguments["activation_fn"] = _activations()[activation]
    require_extra(module.partition(".")[0])
    return getattr(import_module(module), name), arguments


def _arguments(policy: Any) -> dict[str, Any]:
    """Return the arguments with which a policy was built, without those that are None."""
    given = {key: value for key, value in policy._get_constructor_parameters().items() if value is not None}
    if hasattr(policy, "lstm_hidden_state_shape"):  # sb3-contrib leaves out what is its own
        layers, _, size = policy.lstm_hidden_state_shape
        given |= {"lstm_hidden_size": size, "n_lstm_layers": layers}
        given |= {name: getattr(policy, name) for name in ("shared_lstm", "enable_critic_lstm")}
    return given


def _activations() -> dict[str, Any]:
    from torch import nn

    return {name: getattr(nn, name) for name in ACTIVATIONS}


def _bounds_of(space: Any, field: str) -> dict[str, list[float | None]]:
    """Return the bounds of a box as plain data; None is infinite."""
    flat = isinstance(space, Box) and space.dtype == np.float32 and len(space.shape) == 1
    require(flat, field, f"must be a box (size,) of float32; {ZIP}", space)
    pairs = {"low": space.low, "high": space.high}
    return {name: [float(value) if np.isfinite(value) else None for value in values] for name, values in pairs.items()}


def _box_of(bounds: Any, field: str) -> Box[Any]:
    require(isinstance(bounds, dict) and set(bounds) == {"low", "high"}, field, "must have low and high", bounds)
    ends = []
    for name, infinite in (("low", -np.inf), ("high", np.inf)):
        values = bounds[name]
        numbers = isinstance(values, list) and all(value is None or _is_number(value) for value in values)
        require(numbers and values, f"{field}.{name}", "must be a list of numbers", values)
        ends.append(np.array([infinite if value is None else value for value in values], dtype=np.float32))
    fits = ends[0].shape == ends[1].shape and (ends[0] <= ends[1]).all()
    require(bool(fits), field, "must have as many high as low bounds, none below", bounds)
    return Box(ends[0], ends[1], dtype=np.float32)


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < 3e38


def _number(value: Any, field: str) -> Any:
    require(_is_number(value), field, "must be a number", value)
    return value


def _flag(value: Any, field: str) -> Any:
    require(isinstance(value, bool), field, "must be true or false", value)
    return value


def _text(value: Any, field: str) -> Any:
    require(isinstance(value, str), field, "must be text", value)
    return value


def _units(value: Any, field: str) -> int:
    return whole(value, 1, field)


def _layers(value: Any, field: str) -> Any:
    """Return the widths of hidden layers: a list, or one for the actor and one for the critic."""
    if isinstance(value, dict):
        known = set(value) <= {"pi", "vf"} or set(value) == {"pi", "qf"}
        require(known, field, 'must have "pi", and "vf" or "qf"', value)
        return {part: _layers(widths, f"{field}.{part}") for part, widths in value.items()}
    require(isinstance(value, (list, tuple)), field, "must be a list of widths", value)
    return [_units(width, field) for width in value]


_RULES: dict[str, Callable[[Any, str], Any]] = {
    "net_arch": _layers,
    "activation_fn": _text,
    "clip_mean": _number,
    **dict.fromkeys(("use_sde", "full_std", "use_expln", "squash_output", "shared_lstm", "enable_critic_lstm"), _flag),
    **dict.fromkeys(("actor_size", "lstm_hidden_size", "n_lstm_layers", "n_critics", "n_quantiles"), _units),
}
