"""Compiled entry points that inline functions of several files."""

import hashlib
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

from numba import njit

CONTRACT = {"contract"}
"""Fused multiply-add only: it is as exact as separate operations, and no reordering is allowed."""

inlined = njit(inline="always", error_model="numpy", fastmath=CONTRACT)
"""Decorator of a function that is compiled into the entry points that call it."""


def entry_point(*modules: ModuleType, contract: bool = True) -> Callable[[Callable[..., Any]], Any]:
    """Return a decorator that compiles a function and stores the result on disk until a source file changes.

    Numba's own cache checks the file of the function alone. After a change in another file it would still run the old
    machine code of the functions inlined from there.

    Parameters
    ----------
    *modules
        The other modules of this package with inlined functions that the function calls, directly or not.
    contract
        Whether multiplications and additions may be fused.
    """

    def decorate(function: Callable[..., Any]) -> Any:
        fastmath = CONTRACT if contract else False
        dispatcher = njit(cache=True, nogil=True, error_model="numpy", fastmath=fastmath)(function)
        index = getattr(getattr(dispatcher, "_cache", None), "_cache_file", None)
        if index is not None:  # With NUMBA_DISABLE_JIT there is nothing to cache.
            # This file too: it has the compiler options.
            files = (__file__, *(str(module.__file__) for module in modules))
            sources = b"".join(Path(file).read_bytes() for file in files)
            index._source_stamp = (index._source_stamp, hashlib.sha256(sources).hexdigest())
        return dispatcher

    return decorate
