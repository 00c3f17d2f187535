"""Compiled entry points that inline functions of several files."""

import hashlib
import warnings
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from types import ModuleType
from typing import Any

from numba import njit
from numba.core.caching import FunctionCache

CONTRACT = {"contract"}
"""Fused multiply-add only: it is as exact as separate operations, and no reordering is allowed."""

inlined = njit(inline="always", error_model="numpy", fastmath=CONTRACT)
"""Decorator of a function that is compiled into the entry points that call it."""


class _StoredCode(FunctionCache):
    """Numba's compiled code on disk, without which a process only compiles anew.

    Numba checks the file of the function alone. After a change in another file it would still run the old machine code
    of the functions inlined from there.
    """

    def __init__(self, function: Any, sources: str) -> None:
        super().__init__(function)
        self._cache_file._source_stamp = (self._cache_file._source_stamp, sources)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return stored code, or None if there is none or its file is damaged."""
        try:
            return super().load_overload(sig, target_context)
        except Exception:  # A torn file raises whatever its bytes happen to mean.
            with suppress(OSError):
                self.flush()
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Store compiled code; without space or rights for it, warn."""
        try:
            super().save_overload(sig, data)
        except OSError as error:
            _warn(str(error.strerror))


def _warn(reason: str) -> None:
    """Say that code is not stored; Python shows the same words of the same line once a process."""
    remedy = "set NUMBA_CACHE_DIR to a folder that can be written"
    warnings.warn(f"compiled code is not stored, so every start compiles anew ({reason}); {remedy}", stacklevel=1)


def entry_point(*modules: ModuleType, contract: bool = True) -> Callable[[Callable[..., Any]], Any]:
    """Return a decorator that compiles a function and stores the result on disk until a source file changes.

    Parameters
    ----------
    *modules
        The other modules of this package with inlined functions that the function calls, directly or not.
    contract
        Whether multiplications and additions may be fused.

    Warns
    -----
    UserWarning
        If no folder for compiled code can be written; the function is then compiled in every process.
    """

    def decorate(function: Callable[..., Any]) -> Any:
        fastmath = CONTRACT if contract else False
        dispatcher: Any = njit(nogil=True, error_model="numpy", fastmath=fastmath)(function)
        if dispatcher is not function:  # With NUMBA_DISABLE_JIT there is nothing to store.
            # This file too: it has the compiler options.
            files = (__file__, *(str(module.__file__) for module in modules))
            sources = b"".join(Path(file).read_bytes() for file in files)
            try:
                dispatcher._cache = _StoredCode(function, hashlib.sha256(sources).hexdigest())
            except RuntimeError:
                _warn("neither the package nor the cache folder of the user can be written")
        return dispatcher

    return decorate
