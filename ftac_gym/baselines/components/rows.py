"""Products of rows: one number for each spacecraft, as a column."""

from __future__ import annotations

import numpy as np

from ftac_gym.utils.parameters import FloatArray


def dot(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return the scalar products (N, 1) of the rows (N, k) of two arrays."""
    products: FloatArray = np.einsum("ni,ni->n", first, second)[:, None]
    return products


def length(rows: FloatArray) -> FloatArray:
    """Return the lengths (N, 1) of rows (N, k)."""
    return np.sqrt(dot(rows, rows))
