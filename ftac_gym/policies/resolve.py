"""Resolution of policies: from names, paths, classes, models and functions."""

import os
from pathlib import Path
from typing import Any

from ftac_gym import baselines
from ftac_gym.agents.agent import Agent
from ftac_gym.agents.shipped import SHIPPED, best_agent, designs
from ftac_gym.baselines.registry import known_names
from ftac_gym.policies.external import ExternalPolicy
from ftac_gym.policies.policy import DeferredBaseline, Policy, named_gains
from ftac_gym.policies.references import REFERENCES
from ftac_gym.policies.text import external, is_external
from ftac_gym.policies.torchrl import from_torchrl, is_tensordict_module
from ftac_gym.utils.parameters import broken, require

AGENT = "agent"
"""Name of the shipped residual of a scenario, or of the flagship's if the scenario has none."""


def resolve(policy: Any, scenario: str = "flagship", gains: str = "default") -> Policy:
    """Return the policy that a user names.

    Parameters
    ----------
    policy
        One of

        - ``"zero"`` or ``"random"``: no action, or a random one;
        - a baseline's name, ``"NAME tuned"`` for its tuned gains, or ``"NAME FILE.json"`` for those that ``ftac-tune``
          wrote;
        - a subclass of :class:`~ftac_gym.baselines.Baseline`, or its path as ``"module:Class"``;
        - ``"agent"`` or the name of another shipped agent;
        - the path of an agent: its folder, or the folder of its run;
        - the path of a folder with one agent for each training seed, for the best in its own evaluations;
        - a file of another library, or an object of a module, as text: ``"sb3:PATH"``, ``"onnx:PATH"``,
          ``"zoo:FOLDER"``, ``"module:name"``, ``"module:name()"``, with arguments behind it; see
          :func:`~ftac_gym.policies.text.external`;
        - a model of Stable-Baselines3, sb3-contrib or SBX, which acts directly, in the attitude tier;
        - an actor of TorchRL, as of :func:`~ftac_gym.policies.torchrl.from_torchrl`;
        - a function from the observation (size,) of one spacecraft to its action (wheels,), or an object with
          ``predict``, as of :class:`~ftac_gym.policies.external.ExternalPolicy`;
        - a :class:`~ftac_gym.policies.policy.Policy`, for example an :class:`~ftac_gym.agents.agent.Agent`.
    scenario
        Name of the scenario whose agent ``"agent"`` is.
    gains
        ``"default"``, ``"tuned"`` or a file of ``ftac-tune``: gains of a baseline whose name says none.

    Raises
    ------
    ValueError
        If a name is unknown, a baseline has no such gains, or the policy is of another kind. The message says where
        the known names are.
    MissingExtra
        If the library of a model is not installed; the message has the command that installs it.
    """
    if isinstance(policy, str) and policy in REFERENCES:
        return REFERENCES[policy]()
    if isinstance(policy, str) and is_external(policy):
        found = external(policy)
        # The path of a class, not the class, tells other processes and results apart.
        law = isinstance(found, type) and issubclass(found, baselines.Baseline)
        return DeferredBaseline(policy, gains) if law else resolve(found, scenario, gains)
    if isinstance(policy, (str, Path)):
        folder = agent_path(policy, scenario)
        if folder is not None:
            return Agent.load(best_agent(folder))
        name, named = named_gains(str(policy))
        return DeferredBaseline(name, gains if named is None else named)
    if isinstance(policy, type) and issubclass(policy, baselines.Baseline):
        return DeferredBaseline(policy, gains)
    if all(hasattr(policy, name) for name in ("attach", "predict", "tier")):
        return policy
    if hasattr(policy, "get_vec_normalize_env"):
        return Agent.of(policy)
    if is_tensordict_module(policy):
        return from_torchrl(policy)
    attached = isinstance(policy, (type, baselines.BaselinePolicy))
    acts = not attached and (hasattr(policy, "predict") or callable(policy))
    rule = "must be a name, a path, an Agent or a Baseline class (not an instance), a model, an object with predict, "
    require(acts, "policy", rule + "or a function from observation to action", policy)
    return ExternalPolicy(policy)


def is_unshipped(name: object) -> bool:
    """Tell whether a text names a policy that is neither a baseline nor an agent: no path and no name of a file."""
    return isinstance(name, str) and (name in REFERENCES or is_external(name))


def agent_path(name: str | Path, scenario: str = "flagship") -> Path | None:
    """Return the folder or file of the agent that a user names, or None for a baseline.

    Parameters
    ----------
    name
        ``"agent"``, the name of another shipped agent, a baseline's name with or without its gains,
        ``"module:Class"``, or a path.
    scenario
        Name of the scenario whose agent ``"agent"`` is.

    Raises
    ------
    ValueError
        If the name is unknown; the message says where the known ones are.
    """
    text = str(name)
    shipped = designs()
    if text == AGENT:
        of_scenario = f"{scenario}_residual"
        return SHIPPED / (of_scenario if of_scenario in shipped else "flagship_residual")
    if text in shipped:
        return SHIPPED / text
    if baselines.is_baseline(named_gains(text)[0]):
        return None
    if not os.path.exists(text):
        rule = f"must be {AGENT!r}, a shipped agent ({', '.join(shipped)}), {known_names(text)}, "
        rule += "'nftsm tuned', 'nftsm FILE.json', 'module:name', 'sb3:PATH', 'zoo:PATH', 'onnx:PATH', "
        rule += "or the path of an agent"
        raise broken("policy", rule, text)
    return Path(text)
