"""Reproduction of Chen et al. 2018."""
