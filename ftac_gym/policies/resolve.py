"""What policies are called on command lines."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ftac_gym import baselines
from ftac_gym.agents.shipped import designs, shipped
from ftac_gym.evaluation.entries import TUNED
from ftac_gym.evaluation.rollout import BaselineContestant
from ftac_gym.utils.parameters import require

AGENT = "agent"
"""Name of the shipped residual of a scenario, else of the flagship's."""


def source_of(policy: str, scenario: str = "flagship") -> str:
    """Return what to load for a policy.

    Parameters
    ----------
    policy
        ``"agent"``, the name of a shipped agent, a baseline's name, ``"NAME tuned"`` for its tuned gains, an agent's
        folder or a Stable-Baselines3 zip.
    scenario
        Whose agent ``"agent"`` is.

    Returns
    -------
    The baseline's name as it was given, or the path of the agent.

    Raises
    ------
    ValueError
        If the name is unknown; the message lists the known ones.
    """
    if policy == AGENT:
        own = f"{scenario}_residual"
        return str(shipped(own if own in designs() else "flagship_residual"))
    if policy in designs():
        return str(shipped(policy))
    known = baselines.is_baseline(policy.removesuffix(TUNED)) or Path(policy).exists()
    rule = f"must be {AGENT!r}, a shipped agent ({', '.join(designs())}), a baseline ({', '.join(baselines.names())}), "
    rule += "a baseline with tuned gains like 'nftsm tuned', an own law as 'module:Class', or the path of an agent"
    require(known, "policy", rule, policy)
    return policy


def contestant_of(policy: str, scenario: str = "flagship", gains: str = "default") -> Any:
    """Return what flies for a policy, to be given to :func:`~ftac_gym.evaluation.rollout` and its like.

    Parameters
    ----------
    policy, scenario
        See :func:`source_of`.
    gains
        Gains of a baseline whose name does not say ``tuned``.

    Raises
    ------
    ValueError
        If the name is unknown or the baseline has no such gains; agents are loaded when they fly.
    """
    source = source_of(policy, scenario)
    law = source.removesuffix(TUNED)
    if baselines.is_baseline(law):
        return BaselineContestant(law, "tuned" if source.endswith(TUNED) else gains)
    return source
