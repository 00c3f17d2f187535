"""Reproduction of Li et al. 2023."""
