"""Reproduction of Ma, Wang and Wang 2023."""

from ftac_gym.reproduction.ma_2023 import claims, plans, report

__all__ = ["claims", "plans", "report"]
