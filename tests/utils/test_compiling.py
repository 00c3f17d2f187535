"""Tests of `compiling`: compiled code is kept on disk until one of the files that it comes from changes."""

import ast
import inspect
import json
import os
import subprocess
import sys
import warnings

import pytest
from helpers.small_disk import on_small_disk
from numba.extending import is_jitted

from ftac_gym.dynamics import plant, sensing
from ftac_gym.utils import compiling

PIECES = """
from parts.compiling import inlined


@inlined
def scaled(value):
    return {factor} * value
"""

KERNEL = """
import numpy as np

from parts import pieces
from parts.compiling import entry_point
from parts.pieces import scaled


@entry_point(pieces)
def fill(out):
    for i in range(len(out)):
        out[i] = scaled(i)
"""

REPORT = """
import json

import numpy as np

from parts.kernel import fill

out = np.zeros(3)
fill(out)
stats = getattr(fill, "stats", None)
hits, misses = (sum(stats.cache_hits.values()), sum(stats.cache_misses.values())) if stats else (None, None)
print(json.dumps([out.tolist(), hits, misses]))
"""


@pytest.fixture
def run(tmp_path):
    """A package of a kernel, its pieces and a copy of the module under test; running it tells what was compiled."""
    package = tmp_path / "parts"
    package.mkdir()
    (package / "__init__.py").touch()
    (package / "compiling.py").write_text(source_of(compiling))
    (package / "kernel.py").write_text(KERNEL)

    def call(factor, disk=0, first="", last="", **environment):
        (package / "pieces.py").write_text(PIECES.format(factor=factor))
        command = [sys.executable, "-c", f"{first}\n{REPORT}\n{last}"]
        finished = subprocess.run(
            on_small_disk(command, tmp_path / "cache", disk) if disk else command,
            env={**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache"), "PYTHONPATH": str(tmp_path), **environment},
            capture_output=True, text=True, check=True,
        )  # fmt: skip
        lines = finished.stderr.splitlines()
        call.announced = [line for line in lines if line.startswith("ftac_gym: ")]
        # The last line of a warning is the source.
        for line in [line for line in lines if line not in call.announced][::2]:
            warnings.warn(line, stacklevel=1)
        return json.loads(finished.stdout)

    return call


def source_of(module):
    with open(module.__file__, encoding="utf-8") as file:
        return file.read()


def test_a_change_in_any_file_recompiles_and_no_change_does_not(run, tmp_path):
    assert run(2.0) == [[0.0, 2.0, 4.0], 0, 1]
    assert run(2.0) == [[0.0, 2.0, 4.0], 1, 0]
    assert run(3.0) == [[0.0, 3.0, 6.0], 0, 1]  # the file of the kernel itself is as it was
    assert run(3.0) == [[0.0, 3.0, 6.0], 1, 0]
    with (tmp_path / "parts" / "compiling.py").open("a") as file:
        file.write("# Compiled in another way.\n")
    assert run(3.0) == [[0.0, 3.0, 6.0], 0, 1]


def test_a_process_that_compiles_says_so_once_and_one_that_loads_is_silent(run):
    twice = "fill(np.zeros(3, np.float32)); assert sum(fill.stats.cache_misses.values()) == {}"
    assert run(2.0, last=twice.format(2)) == [[0.0, 2.0, 4.0], 0, 1]
    assert run.announced == ["ftac_gym: compiling the simulation for this machine, about 30 s, once"]
    assert run(2.0, last=twice.format(0)) == [[0.0, 2.0, 4.0], 1, 0]
    assert run.announced == []


def test_the_line_is_silenced_as_any_of_pythons_logging(run):
    assert run(2.0, first="import logging; logging.getLogger('ftac_gym').setLevel(logging.ERROR)")[2] == 1
    assert run.announced == []


@pytest.mark.parametrize(("number", "state"), [(1, "enable"), (2, "disable")])
def test_only_the_first_worker_says_so_and_compiling_leaves_the_garbage_collector_as_it_was(run, number, state):
    worker = f"import gc, multiprocessing; multiprocessing.current_process().name = 'SpawnProcess-{number}'"
    collects = f"assert gc.isenabled() == {state == 'enable'}"
    assert run(2.0, first=f"{worker}; gc.{state}()", last=collects)[2] == 1
    assert len(run.announced) == (number == 1)


def test_without_compilation_the_functions_are_plain_python(run, tmp_path):
    assert run(2.0, NUMBA_DISABLE_JIT="1") == [[0.0, 2.0, 4.0], None, None]
    assert not (tmp_path / "cache").exists()


def test_without_a_folder_for_compiled_code_every_process_compiles(run, tmp_path):
    file = tmp_path / "file"
    file.touch()
    (tmp_path / "parts" / "__pycache__").touch()
    elsewhere = {name: str(file / "home") for name in ("HOME", "XDG_CACHE_HOME", "NUMBA_CACHE_DIR")}
    with pytest.warns(UserWarning, match="so every start compiles anew .*; set NUMBA_CACHE_DIR to a folder"):
        assert run(2.0, PYTHONDONTWRITEBYTECODE="1", **elsewhere) == [[0.0, 2.0, 4.0], 0, 1]


@pytest.mark.parametrize("suffix", [".nbi", ".nbc"])
@pytest.mark.parametrize("share", [0.0, 0.5])
def test_torn_files_of_compiled_code_are_replaced(run, tmp_path, suffix, share):
    assert run(2.0) == [[0.0, 2.0, 4.0], 0, 1]
    (torn,) = (tmp_path / "cache").rglob(f"*{suffix}")
    content = torn.read_bytes()
    torn.write_bytes(content[: int(share * len(content))])
    assert run(2.0) == [[0.0, 2.0, 4.0], 0, 1]
    assert run(2.0) == [[0.0, 2.0, 4.0], 1, 0]


def test_a_full_disk_only_costs_the_storing(run, tmp_path):
    with pytest.warns(UserWarning, match=r"\(No space left on device\); set NUMBA_CACHE_DIR to a folder"):
        assert run(2.0, disk=8) == [[0.0, 2.0, 4.0], 0, 1]


def imports(module):
    """Modules of the package that a module imports, or imports names from, at its top."""
    found = set()
    for node in ast.parse(source_of(module)).body:
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("ftac_gym"):
            for alias in node.names:
                whole = f"{node.module}.{alias.name}"
                found.add(whole if whole in sys.modules else node.module)
    return found - {compiling.__name__}


@pytest.mark.parametrize("kernel", [plant.advance, sensing.sense], ids=["plant", "sensing"])
def test_every_file_that_a_kernel_is_made_of_is_watched(kernel):
    """Compiled code must be renewed after a change of any file with its functions or constants."""
    home = sys.modules[kernel.py_func.__module__]
    (decorator,) = ast.parse(inspect.getsource(kernel.py_func)).body[0].decorator_list
    watched = {getattr(home, argument.id).__name__ for argument in decorator.args}
    compiled = [module for module in map(sys.modules.get, watched) if any(map(is_jitted, vars(module).values()))]
    for module in (home, *compiled):
        assert imports(module) - {home.__name__} <= watched, module.__name__
    assert len(compiled) >= 2
