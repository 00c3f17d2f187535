"""Watching policies fly: live, with faults that come and go at the press of a key, or to a film."""

from ftac_gym.viewer.film import Film
from ftac_gym.viewer.flight import Flight
from ftac_gym.viewer.screen import Screen
from ftac_gym.viewer.session import Session

__all__ = ["Film", "Flight", "Screen", "Session"]
