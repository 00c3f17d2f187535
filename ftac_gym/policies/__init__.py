"""Policies: everything that acts, resolved from what a user names, and run on environments."""

from ftac_gym.policies.external import ExternalPolicy
from ftac_gym.policies.onnx import load_onnx
from ftac_gym.policies.policy import TUNED, DeferredBaseline, Policy, check_task, policy_label
from ftac_gym.policies.resolve import resolve
from ftac_gym.policies.runner import PolicyRunner
from ftac_gym.policies.sb3 import load_sb3
from ftac_gym.policies.torchrl import from_torchrl
from ftac_gym.policies.zoo import ZooAgent, load_zoo

__all__ = [
    "TUNED",
    "DeferredBaseline",
    "ExternalPolicy",
    "Policy",
    "PolicyRunner",
    "ZooAgent",
    "check_task",
    "from_torchrl",
    "load_onnx",
    "load_sb3",
    "load_zoo",
    "policy_label",
    "resolve",
]
