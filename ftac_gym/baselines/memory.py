"""State of a baseline between two calls, in one place."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

BoolArray = npt.NDArray[np.bool_]


class Memory:
    """Named arrays with the spacecraft on the first axis.

    A baseline and its observers store all their state here. Resetting some spacecraft, or acting for some only, then
    needs no code in any of them.

    Parameters
    ----------
    num_spacecraft
        Number of spacecraft N.
    """

    def __init__(self, num_spacecraft: int) -> None:
        self._num_spacecraft = num_spacecraft
        self._initial: dict[str, npt.NDArray[Any]] = {}
        self._arrays: dict[str, npt.NDArray[Any]] = {}

    def add(self, name: str, shape: tuple[int, ...], initial: float | bool | npt.NDArray[Any] = 0.0) -> None:
        """Add an array (N, ...) that a reset fills with ``initial``, a number or a record.

        Raises
        ------
        ValueError
            If the name is taken.
        """
        if name in self._arrays:
            raise ValueError(f"memory name must be new, got {name!r}")
        self._initial[name] = np.full((self._num_spacecraft, *shape), initial)
        self._arrays[name] = self._initial[name].copy()

    def has(self, name: str) -> bool:
        """Tell whether there is an array of this name."""
        return name in self._arrays

    def __getitem__(self, name: str) -> npt.NDArray[Any]:
        """Return an array; only one of records may be written to in place."""
        return self._arrays[name]

    def __setitem__(self, name: str, array: npt.NDArray[Any]) -> None:
        """Replace an array."""
        self._arrays[name] = array

    def reset(self, mask: BoolArray) -> None:
        """Set the rows of the spacecraft in the mask (N,) to their initial values."""
        self.restore(self._initial, mask)

    def copy(self) -> dict[str, npt.NDArray[Any]]:
        """Return the present arrays, with copies of those of records, which are written to in place."""
        return {name: array.copy() if array.dtype.names else array for name, array in self._arrays.items()}

    def restore(self, arrays: dict[str, npt.NDArray[Any]], mask: BoolArray) -> None:
        """Set the rows of the spacecraft in the mask (N,) to those of ``arrays``."""
        for name, array in self._arrays.items():
            chosen = mask.reshape(-1, *(1,) * (array.ndim - 1))
            self._arrays[name] = np.where(chosen, arrays[name], array)
