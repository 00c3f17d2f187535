"""Processes that end with their parent, which is killed without a chance to end them."""

import os
import signal
import subprocess
import sys
import time

import psutil
import pytest

CHILD = """
import pathlib, sys, time
print("begun", flush=True)
while True:
    pathlib.Path(sys.argv[1]).write_text(str(time.monotonic()))
    time.sleep(0.05)
"""

PARENT = """
import sys
from pathlib import Path
from concurrent.futures import ThreadPoolExecutor
from ftac_gym.utils.processes import run_script

if __name__ == "__main__":
    folder = Path(sys.argv[1])
    with ThreadPoolExecutor(1) as pool:  # as a study does
        pool.submit(run_script, folder / "child.py", [str(folder / "beat")], folder / "log.txt").result()
"""


def test_a_script_ends_with_its_killed_parent(tmp_path):
    (tmp_path / "child.py").write_text(CHILD)
    (tmp_path / "parent.py").write_text(PARENT)
    parent = subprocess.Popen([sys.executable, tmp_path / "parent.py", tmp_path])
    beat = tmp_path / "beat"
    try:
        deadline = time.monotonic() + 30.0
        while not beat.exists():
            assert parent.poll() is None and time.monotonic() < deadline
            time.sleep(0.02)
    finally:
        os.kill(parent.pid, signal.SIGKILL)
        parent.wait()
    time.sleep(0.5)
    last = beat.stat().st_mtime_ns
    time.sleep(0.5)
    assert beat.stat().st_mtime_ns == last, "the child lives on"
    assert (tmp_path / "log.txt").read_text() == "begun\n"


def test_a_script_has_its_arguments_status_and_log(tmp_path):
    (tmp_path / "script.py").write_text("import sys\nprint(sys.argv[1:], __name__)\nraise SystemExit('no')\n")
    starter = "import sys; from pathlib import Path; from ftac_gym.utils.processes import run_script\n"
    starter += "if __name__ == '__main__':\n    f = Path(sys.argv[1])\n"
    starter += "    raise SystemExit(10 + run_script(f / 'script.py', ['a', '--b'], f / 'log.txt'))\n"
    (tmp_path / "starter.py").write_text(starter)
    for _ in range(2):
        assert subprocess.run([sys.executable, tmp_path / "starter.py", tmp_path]).returncode == 11
    assert (tmp_path / "log.txt").read_text() == 2 * "['a', '--b'] __main__\nno\n"


FLYING = """
import sys, time
from dataclasses import dataclass
from pathlib import Path
from ftac_gym.utils.console import run_program
from ftac_gym.utils.processes import worker_pool

@dataclass(frozen=True)
class Config:
    folder: Path = Path()

def fly(folder, seconds):
    (folder / "begun").touch()
    time.sleep(seconds)

def main(config: Config) -> None:
    with worker_pool(2) as pool:
        list(pool.map(fly, [config.folder] * 50, [60.0] * 50))

if __name__ == "__main__":
    run_program(main, Config, None)
"""


@pytest.mark.parametrize("moment", ["begun", "started"])
def test_ctrl_c_ends_a_pool_with_one_line(tmp_path, moment):
    (tmp_path / "parent.py").write_text(FLYING)
    command = [sys.executable, tmp_path / "parent.py", "--folder", tmp_path]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, start_new_session=True)
    deadline = time.monotonic() + 60.0
    workers = 0
    while not (tmp_path / "begun").exists() and not (moment == "started" and workers > 0):
        assert process.poll() is None and time.monotonic() < deadline
        time.sleep(0.01)
        workers = len(psutil.Process(process.pid).children())
    os.killpg(process.pid, signal.SIGINT)
    _, text = process.communicate(timeout=20)
    assert (process.returncode, text) == (130, "interrupted\n")
