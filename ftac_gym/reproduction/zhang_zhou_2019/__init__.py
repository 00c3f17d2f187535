"""Reproduction of Zhang and Zhou 2019."""
