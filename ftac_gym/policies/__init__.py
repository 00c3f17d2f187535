"""Policies: resolved from names, paths, classes and callables, and run on environments."""
