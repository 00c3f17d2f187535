"""Rollouts, metrics, statistics and plots."""
