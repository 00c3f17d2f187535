"""Live views of policies, with faults added and cleared by keys, and films of them."""

from ftac_gym.viewer.film import Film
from ftac_gym.viewer.live_episode import LiveEpisode
from ftac_gym.viewer.screen import Screen
from ftac_gym.viewer.session import Session

__all__ = ["Film", "LiveEpisode", "Screen", "Session"]
