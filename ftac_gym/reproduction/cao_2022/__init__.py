"""Reproduction of Cao, Gong and Han 2022."""

from ftac_gym.reproduction.cao_2022 import claims, plans, report

__all__ = ["claims", "plans", "report"]
