"""The true plant, compiled and batched over craft."""

from ftac_gym.dynamics.simulator import Simulator, State

__all__ = ["Simulator", "State"]
