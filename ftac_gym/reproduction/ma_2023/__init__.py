"""Reproduction of Ma et al. 2023."""
