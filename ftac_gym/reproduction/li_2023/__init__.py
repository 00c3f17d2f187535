"""Reproduction of Li, Xu and Chang 2023."""

from ftac_gym.reproduction.li_2023 import claims, plans, report

__all__ = ["claims", "plans", "report"]
