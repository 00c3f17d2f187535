"""Reproduction of Chen, Chen, He and Sun 2018."""

from ftac_gym.reproduction.chen_2018 import claims, plans, report

__all__ = ["claims", "plans", "report"]
