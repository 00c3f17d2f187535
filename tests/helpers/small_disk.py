"""Commands on a disk that is soon full."""

import shutil
import subprocess
from functools import cache

import pytest


def on_small_disk(command, folder, kilobytes):
    """Return a command line that runs a command with a small file system of its own at a folder.

    It skips the test where the machine does not allow it.
    """
    folder.mkdir(parents=True, exist_ok=True)
    if not _allowed(folder):
        pytest.skip("the machine does not allow a process to mount a file system of its own")
    script = f'mount -t tmpfs -o size={kilobytes}k tmpfs "$0" && exec "$@"'
    return ["unshare", "--user", "--map-root-user", "--mount", "sh", "-c", script, str(folder), *command]


@cache
def _allowed(folder):
    if shutil.which("unshare") is None:
        return False
    words = ["unshare", "--user", "--map-root-user", "--mount", "mount", "-t", "tmpfs", "tmpfs", str(folder)]
    return subprocess.run(words, capture_output=True, check=False).returncode == 0
