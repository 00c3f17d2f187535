"""Reproduction of Zhang and Zhou 2019."""

from ftac_gym.reproduction.zhang_zhou_2019 import claims, plans, report

__all__ = ["claims", "plans", "report"]
