"""Extras: their modules, and one line about what is missing."""

import ast
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from gymnasium.error import DependencyNotInstalled
from helpers.installations import link_packages

from ftac_gym.utils.extras import EXTRAS, MissingExtra, naming_extra, require_extra

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
DISTRIBUTIONS = {"pyyaml": "yaml", "pygame-ce": "pygame", "pillow": "PIL"}
BROUGHT = {"imageio_ffmpeg"}  # by imageio[ffmpeg]


def modules(requirements):
    names = [re.match(r"[\w.-]+", text)[0] for text in requirements]
    return {DISTRIBUTIONS.get(name, name.replace("-", "_")) for name in names}


@pytest.mark.parametrize("extra", EXTRAS)
def test_the_modules_of_an_extra_are_those_of_the_project(extra):
    assert set(EXTRAS[extra]) - BROUGHT == modules(PROJECT["optional-dependencies"][extra])


def imported(path):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and not node.level:
            yield node.module


def test_every_import_of_the_package_is_a_dependency_or_of_an_extra():
    needed = modules(PROJECT["dependencies"])
    known = {*sys.stdlib_module_names, "ftac_gym", *needed, *(item for extra in EXTRAS.values() for item in extra)}
    found = {name.partition(".")[0] for path in (ROOT / "ftac_gym").rglob("*.py") for name in imported(path)}
    # A part of matplotlib, and the library of an actor that is given.
    assert found - {"mpl_toolkits", "tensordict"} <= known


def test_a_missing_package_is_named_with_its_install_line(monkeypatch):
    monkeypatch.setitem(sys.modules, "cvxpy", None)
    line = r'^cvxpy is missing: pip install "ftac_gym\[lmi\]"$'
    for kind in (ImportError, DependencyNotInstalled, MissingExtra):
        with pytest.raises(kind, match=line):
            require_extra("clarabel", "cvxpy")
        with pytest.raises(kind, match=line), naming_extra():
            import cvxpy  # noqa: F401
    with pytest.raises(ModuleNotFoundError, match="no_such_module") as caught, naming_extra():
        import no_such_module  # noqa: F401
    assert not isinstance(caught.value, MissingExtra)


BARE = """
import contextlib, importlib, io, sys
from ftac_gym.utils.extras import MissingExtra
from ftac_gym.cli.commands import NAMES, run
for name in NAMES:
    sys.argv, text = [f"ftac-{name}", "--help"], io.StringIO()
    with contextlib.redirect_stderr(text):
        try:
            run(name)
        except SystemExit as end:
            print(name, end.code, text.getvalue(), end="")
for name in ("plots", "report", "reproduction", "training", "evaluation.benchmark", "evaluation.tuning"):
    try:
        importlib.import_module(f"ftac_gym.{name}")
    except MissingExtra as error:
        print(name, error)
import ftac_gym.evaluation, ftac_gym.envs, ftac_gym.wrappers, ftac_gym.policies
from ftac_gym.agents.shipped import SHIPPED, best_agent
for call in (lambda: ftac_gym.wrappers.SB3VecEnv, lambda: ftac_gym.policies.resolve("agent")):
    try:
        call()
    except MissingExtra as error:
        print(error)
"""


def test_a_bare_installation_says_what_is_missing(tmp_path):
    packages = link_packages(modules(PROJECT["dependencies"]), tmp_path / "packages")
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(packages), str(ROOT)])}
    command = [sys.executable, "-S", "-c", BARE]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stderr) == (0, "")
    lines = done.stdout.splitlines()
    assert len(lines) == 16
    for line in lines[:8]:
        assert re.fullmatch(r'\w+ 1 \w+ is missing: pip install "ftac_gym\[(train|render)\]"', line), line
    for line in lines[8:]:
        assert re.fullmatch(r'([\w.]+ )?\w+ is missing: pip install "ftac_gym\[train\]"', line), line


INTERRUPTED = """
import sys
class Interruption:
    def find_spec(self, name, *_):
        if name == "tyro":
            raise KeyboardInterrupt
sys.meta_path.insert(0, Interruption())
from ftac_gym.cli.commands import train
train()
"""


def test_ctrl_c_during_imports_is_one_line(tmp_path):
    done = subprocess.run([sys.executable, "-c", INTERRUPTED], cwd=tmp_path, capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "interrupted\n")
