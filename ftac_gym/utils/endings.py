"""Ends of programs: one line and a status instead of a traceback, from the first import on.

It imports nothing that takes time: Ctrl-C is handled while a program is still being imported.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import TextIO

from ftac_gym.utils.extras import MissingExtra, naming_extra

INTERRUPTED, PIPE_CLOSED = 130, 141
"""Statuses of a shell for programs that SIGINT and SIGPIPE end."""


@contextmanager
def one_line_ends() -> Iterator[None]:
    """End the program with one line about its surroundings, if they stop the block.

    These are Ctrl-C, a closed pipe, a missing package of an extra, and whatever the operating system refuses. A full
    disk is an example, or a file in the place of a folder. Characters that the terminal lacks are shown as
    escapes.
    """
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")
    try:
        with naming_extra():
            yield
        sys.stdout.flush()
    except KeyboardInterrupt:
        _end("interrupted", INTERRUPTED)
    except BrokenPipeError:
        _end("", PIPE_CLOSED)
    except OSError as error:
        _end(f"{error.strerror or error}{f': {error.filename}' if error.filename else ''}", 1)
    except MissingExtra as error:
        _end(str(error), 1)


def _end(message: str, status: int) -> None:
    """End the program with a message and a status, whether or not its streams still work."""
    if message:
        with suppress(OSError):
            sys.stderr.write(f"{message}\n")
    for stream in (sys.stdout, sys.stderr):
        _close(stream)
    raise SystemExit(status)


def _close(stream: TextIO) -> None:
    """Lead a stream that no longer works to nowhere: the interpreter would complain of it at its end."""
    try:
        stream.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
