"""Watching policies fly: live, with faults that come and go at the press of a key, or to a film."""

from ftac_gym.playing.film import Film
from ftac_gym.playing.flight import Flight
from ftac_gym.playing.screen import Screen
from ftac_gym.playing.session import Session

__all__ = ["Film", "Flight", "Screen", "Session"]
