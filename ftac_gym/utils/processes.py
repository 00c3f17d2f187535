"""Processes that end with the one that started them, however that ends."""

from __future__ import annotations

import os
import runpy
import signal
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import active_children, get_context, parent_process, resource_tracker
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


@contextmanager
def worker_pool(workers: int) -> Iterator[ProcessPoolExecutor]:
    """Yield a pool of processes that end with this one, and with the block after an error or Ctrl-C.

    Ctrl-C in a terminal reaches all processes. The workers leave it to this one, which ends them.

    Parameters
    ----------
    workers
        Number of processes.
    """
    before = active_children()

    def end_workers() -> None:
        for process in active_children():
            if process not in before:
                process.terminate()

    # Spawned, not forked: a fork copies locks that other threads may hold.
    with ProcessPoolExecutor(workers, get_context("spawn"), end_with_parent) as pool:
        try:
            with _interrupts_waiting():
                for _ in range(workers):  # A call starts a worker if none is idle.
                    pool.submit(os.getpid)
            yield pool
        except BaseException:
            # By then the pool's thread has forgotten what is cancelled; it would complain of a worker that ends sooner.
            timer = threading.Timer(_PATIENCE, end_workers)
            timer.start()
            pool.shutdown(cancel_futures=True)
            timer.cancel()
            raise


@contextmanager
def _interrupts_waiting() -> Iterator[None]:
    """Let Ctrl-C wait for the end of the block, and never reach processes that are started in it."""
    main = threading.current_thread() is threading.main_thread()
    if not main or not hasattr(signal, "pthread_sigmask"):  # Other threads get no interrupts; Windows has no masks.
        yield
        return
    resource_tracker.ensure_running()  # Its own start would let the signal through.
    interrupts: list[int] = []
    # The mask is for the processes; another thread of this one may still receive the signal.
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    handler = signal.signal(signal.SIGINT, lambda number, _: interrupts.append(number))
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        signal.signal(signal.SIGINT, handler)
    if interrupts:
        raise KeyboardInterrupt


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
