"""Policies: everything that acts, resolved from what a user names, and run on environments."""

from ftac_gym.policies.policy import TUNED, DeferredBaseline, DirectPolicy, Policy, policy_label
from ftac_gym.policies.resolve import resolve
from ftac_gym.policies.runner import PolicyRunner

__all__ = ["TUNED", "DeferredBaseline", "DirectPolicy", "Policy", "PolicyRunner", "policy_label", "resolve"]
