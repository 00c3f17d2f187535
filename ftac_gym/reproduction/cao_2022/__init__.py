"""Reproduction of Cao et al. 2022."""
