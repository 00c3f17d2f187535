"""Processes that end with the one that started them, however that ends."""

from __future__ import annotations

import os
import runpy
import sys
import threading
import time
from collections.abc import Sequence
from multiprocessing import get_context, parent_process
from pathlib import Path

_PATIENCE = 0.5
"""Time between two looks at the parent [s]."""


def end_with_parent() -> None:
    """Make this process end as soon as its parent does, even if that is killed.

    The parent has started it by ``multiprocessing``, or by joblib.

    A pool takes the function as its ``initializer``: an orphaned worker would otherwise wait for work forever, and a
    script would write on beside its successor.
    """
    threading.Thread(target=_wait_for_parent, daemon=True).start()


def _wait_for_parent() -> None:
    parent = parent_process()
    assert parent is not None
    if getattr(parent, "_sentinel", None) is not None:
        parent.join()
    # Workers of joblib get no handle of their parent.
    while os.getppid() == parent.pid:
        time.sleep(_PATIENCE)
    os._exit(1)


def run_script(script: Path, arguments: Sequence[str], log: Path) -> int | None:
    """Run a Python script to its end, in a process that ends with this one, and return its exit status.

    Parameters
    ----------
    script
        The script.
    arguments
        Its command line.
    log
        File to which its output is appended.
    """
    # Spawned, not forked: a fork copies locks that other threads may hold.
    process = get_context("spawn").Process(target=_be_script, args=(str(script), list(arguments), str(log)))
    process.start()
    process.join()
    return process.exitcode


def _be_script(script: str, arguments: list[str], log: str) -> None:
    end_with_parent()
    with open(log, "ab") as file:
        for stream in (sys.stdout, sys.stderr):
            os.dup2(file.fileno(), stream.fileno())
    sys.argv = [script, *arguments]
    runpy.run_path(script, run_name="__main__")
