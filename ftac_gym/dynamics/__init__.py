"""True plant, compiled and batched over N spacecraft."""

from ftac_gym.dynamics.divergence import DivergenceError
from ftac_gym.dynamics.simulator import Simulator
from ftac_gym.dynamics.state import State

__all__ = ["DivergenceError", "Simulator", "State"]
