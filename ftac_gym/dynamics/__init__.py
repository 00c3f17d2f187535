"""True plant, compiled and batched over N spacecraft."""

from ftac_gym.dynamics.simulator import Simulator
from ftac_gym.dynamics.state import State

__all__ = ["Simulator", "State"]
