"""Observers, one per file."""
