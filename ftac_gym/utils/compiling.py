"""Compiled entry points that inline functions of several files."""

import gc
import hashlib
import logging
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from multiprocessing import current_process
from pathlib import Path
from types import ModuleType
from typing import Any

from numba import njit
from numba.core.caching import FunctionCache

COMPILE_TIME = 30
"""Time [s] that the first step of an environment takes to compile, on two cores of a small server."""

CONTRACT = {"contract"}
"""Fused multiply-add only: it is as exact as separate operations, and no reordering is allowed."""

inlined = njit(inline="always", error_model="numpy", fastmath=CONTRACT)
"""Decorator of a function whose statements become those of its callers, which compile them anew at every call.

The compiler's time grows faster than the number of statements: for small functions only.
"""

# Entrances from C, and from Python, take time to compile.
_NO_C: dict[str, Any] = {"no_cfunc_wrapper": True}
_NO_CALLS: dict[str, Any] = {**_NO_C, "no_cpython_wrapper": True}

merged = njit(forceinline=True, error_model="numpy", fastmath=CONTRACT, **_NO_CALLS)
"""Decorator of a function that is compiled once, and merged into its callers as machine code; not for Python to call.

It runs as fast as an inlined one. The order of its parameters can decide which products are fused in sums of products.
"""

called = njit(error_model="numpy", fastmath=CONTRACT, **_NO_CALLS)
"""Decorator of a large function that compiled ones call, as machine code of its own; not for Python to call."""


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


@cache
def _announce() -> None:
    """Say once a process that it compiles, by a record that Python's logging shows unless it is told otherwise.

    Of several worker processes only the first ones say so: their names end with their numbers.
    """
    if current_process().name.rpartition("-")[2] in ("MainProcess", "0", "1"):
        logging.getLogger("ftac_gym").warning(
            "ftac_gym: compiling the simulation for this machine, about %d s, once", COMPILE_TIME
        )


@contextmanager
def _collector_paused() -> Iterator[None]:
    """Keep Python's garbage collector from searching the many objects of the compiler, which takes a seventh longer."""
    collects = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collects:
            gc.enable()


def _announced(compile_signature: Callable[..., Any]) -> Callable[..., Any]:
    """Wrap the compiler of a function, which is not called for code that is loaded."""

    def call(*arguments: Any) -> Any:
        _announce()
        with _collector_paused():
            return compile_signature(*arguments)

    return call


def entry_point(*modules: ModuleType, contract: bool = True) -> Callable[[Callable[..., Any]], Any]:
    """Return a decorator that compiles a function and stores the result on disk until a source file changes.

    The first compilation of a process logs a line.

    Parameters
    ----------
    *modules
        The other modules of this package with inlined or merged functions that the function calls, directly or not.
    contract
        Whether multiplications and additions may be fused.

    Warns
    -----
    UserWarning
        If no folder for compiled code can be written; the function is then compiled in every process.
    """

    def decorate(function: Callable[..., Any]) -> Any:
        fastmath = CONTRACT if contract else False
        dispatcher: Any = njit(nogil=True, error_model="numpy", fastmath=fastmath, **_NO_C)(function)
        if dispatcher is not function:  # With NUMBA_DISABLE_JIT there is nothing to store.
            dispatcher._compiler.compile = _announced(dispatcher._compiler.compile)
            # This file too: it has the compiler options.
            files = (__file__, *(str(module.__file__) for module in modules))
            sources = b"".join(Path(file).read_bytes() for file in files)
            try:
                dispatcher._cache = _StoredCode(function, hashlib.sha256(sources).hexdigest())
            except RuntimeError:
                _warn("neither the package nor the cache folder of the user can be written")
        return dispatcher

    return decorate
