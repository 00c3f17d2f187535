"""Policies: everything that acts, resolved from what a user names, and run on environments."""

from ftac_gym.policies.policy import DeferredBaseline, DirectPolicy, Policy
from ftac_gym.policies.resolve import resolve
from ftac_gym.policies.runner import PolicyRunner

__all__ = ["DeferredBaseline", "DirectPolicy", "Policy", "PolicyRunner", "resolve"]
