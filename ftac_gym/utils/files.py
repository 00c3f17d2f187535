"""Files that are complete or absent, locks of folders, and one line about a damaged file."""

from __future__ import annotations

import os
import secrets
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

from ftac_gym.utils.extras import require_extra
from ftac_gym.utils.parameters import in_one_line, require

if TYPE_CHECKING:
    from filelock import BaseFileLock

LOCK_FILE = ".lock"
"""File in a folder that one process at a time may use. It stays; the lock on it ends with its process."""

PARTIAL = ".partial"
"""Suffix of a file or folder while it is written. A killed process leaves it behind; it is never read."""

LONGEST_REASON = 200
"""Characters of an error that becomes part of another message."""


@contextmanager
def replacing(path: Path) -> Iterator[IO[bytes]]:
    """Open a new file that takes the place of ``path`` at the end of the block, or not at all.

    Until then its name is its own, so that several writers of one path do not share it. After an error, for example of
    a full disk, the old file is as it was.

    Parameters
    ----------
    path
        The file; its folder is created. Errors of the operating system name it.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_name(f"{path.name}.{secrets.token_hex(8)}{PARTIAL}")
    try:
        with partial.open("xb") as file:
            yield file
            file.flush()
            os.fsync(file.fileno())
        partial.replace(path)
    except BaseException as error:
        if isinstance(error, OSError) and error.filename in (None, str(partial)):
            error.filename = str(path)
        with suppress(OSError):
            partial.unlink(missing_ok=True)
        raise


def write_text(path: Path, text: str) -> None:
    """Write a text file in UTF-8 that is complete or absent."""
    with replacing(path) as file:
        file.write(text.encode())


@contextmanager
def appearing(folder: Path) -> Iterator[Path]:
    """Make a new folder that has its name at the end of the block, or never.

    Parameters
    ----------
    folder
        The folder, which must not exist. The block writes into the one that it is given.
    """
    partial = folder.with_name(folder.name + PARTIAL)
    shutil.rmtree(partial, ignore_errors=True)
    partial.mkdir(parents=True)
    try:
        yield partial
        partial.rename(folder)
    except BaseException:
        shutil.rmtree(partial, ignore_errors=True)
        raise


def remove_partials(folder: Path) -> None:
    """Remove what killed processes left in a folder and those below; no other process may be writing there."""
    for path in list(folder.rglob(f"*{PARTIAL}")):
        if path.is_dir():
            shutil.rmtree(path, ignore_errors=True)
        else:
            path.unlink(missing_ok=True)


@contextmanager
def reading(path: Path, remedy: str, *errors: type[Exception]) -> Iterator[None]:
    """Turn an error from reading a file into one line.

    Parameters
    ----------
    path
        The file.
    remedy
        Advice to the user, in the imperative.
    *errors
        Further errors that a damaged file causes, beside those of values, keys, types and early ends.

    Raises
    ------
    ValueError
        If the block raises one of the errors: the message names file, reason and remedy.
    """
    damaged: tuple[type[Exception], ...] = (
        ValueError,
        TypeError,
        LookupError,
        AttributeError,
        EOFError,
        OSError,
        RecursionError,
        *errors,
    )
    try:
        yield
    except damaged as error:
        raise ValueError(damage(path, error, remedy)) from error


def damage(path: Path, error: object, remedy: str) -> str:
    """Return one line about a damaged file: its path, the reason and the remedy."""
    return f"{path} cannot be read: {reason_of(error)}; {remedy}"


def reason_of(error: object) -> str:
    """Return the message of an error as one line of limited length."""
    return in_one_line(str(error).strip() or type(error).__name__, LONGEST_REASON)


@contextmanager
def locked(folder: Path, patience: float = 0.0) -> Iterator[None]:
    """Keep other processes out of a folder during the block; needs the ``train`` extra.

    The lock is the operating system's: it ends with the process, however that ends.

    Parameters
    ----------
    folder
        The folder, which is created.
    patience
        Time to wait for another process [s].

    Raises
    ------
    ValueError
        If another process, or this one, has the folder already; the message names the process.
    """
    lock = _lock(folder, patience)
    try:
        yield
    finally:
        lock.release()


def _lock(folder: Path, patience: float) -> BaseFileLock:
    require_extra("filelock")
    from filelock import FileLock, Timeout

    folder.mkdir(parents=True, exist_ok=True)
    path = folder / LOCK_FILE
    lock = FileLock(path, timeout=patience, thread_local=False)
    try:
        lock.acquire()
    except Timeout:
        user = _holder(path)
        require(False, "folder", f"must be used by one process at a time; process {user} uses it", str(folder))
    with suppress(OSError):  # Windows refuses to write to a locked file, which then names no process.
        path.write_text(f"{os.getpid()}\n", encoding="utf-8")
    return lock


def _holder(path: Path) -> Any:
    try:
        return int(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return "of another user"
