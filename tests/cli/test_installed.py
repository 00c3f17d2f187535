"""The package as users install it: wheel and source archive, and the commands without a checkout."""

import os
import re
import subprocess
import sys
import sysconfig
import tarfile
import zipfile
from pathlib import Path

import pytest
from helpers.installations import build

pytest.importorskip("hatchling", reason="needs the extra dev")

ROOT = Path(__file__).parents[2]
CUSTOM = """
import numpy as np
from ftac_gym.baselines import Baseline

class Mine(Baseline):
    def act(self, measurement):
        return np.zeros((len(measurement), 4))
"""
TINY = ("--num-envs", 8, "--hyperparameters", "n_steps=32", "batch_size=128", "--critic-warmup", 0)


@pytest.fixture(scope="module")
def archives(tmp_path_factory):
    """Return wheel and source archive."""
    return build(ROOT, tmp_path_factory.mktemp("dist"))


@pytest.fixture(scope="module")
def installed(archives, tmp_path_factory):
    """Return an environment with the wheel, and with the dependencies of this one but not its checkout."""
    home = tmp_path_factory.mktemp("installed")
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", home], check=True)
    pip = [sys.executable, "-m", "pip", "--python", home / "bin" / "python", "--disable-pip-version-check"]
    subprocess.run([*pip, "install", "--quiet", "--no-deps", "--no-index", archives[0]], check=True)
    (site,) = home.glob("lib/python*/site-packages")
    # A folder that a .pth file adds has no .pth files of its own, such as that of the checkout.
    (site / "dependencies.pth").write_text(sysconfig.get_path("purelib") + "\n")
    return home


def run(home, name, *arguments, folder):
    environment = {key: value for key, value in os.environ.items() if key not in ("PYTHONPATH", "PYTHONHOME")}
    command = [home / "bin" / name, *map(str, arguments)]
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_wheel_has_its_data(archives):
    with zipfile.ZipFile(archives[0]) as wheel:
        names = set(wheel.namelist())
    for path in (ROOT / "ftac_gym").rglob("*"):
        if path.is_file() and "__pycache__" not in path.parts:
            assert path.relative_to(ROOT).as_posix() in names
    assert all(name.startswith("ftac_gym") for name in names)


def test_the_source_archive_has_what_the_readme_starts_with(archives, tmp_path):
    with tarfile.open(archives[1]) as archive:
        archive.extractall(tmp_path, filter="data")
    (folder,) = tmp_path.iterdir()
    text = (folder / "README.md").read_text(encoding="utf-8")
    links = re.findall(r"\]\((?!https?:)([^)#]+)", text)
    assert len(links) > 15 and all((folder / link).exists() for link in links)
    constraints = set(re.findall(r"constraints[-\w]*\.txt", (folder / "Makefile").read_text(encoding="utf-8")))
    assert len(constraints) == 2
    for name in (*constraints, "train/evaluate.py", "tests/helpers/scripts.py", "docs/conf.py"):
        assert (folder / name).is_file()
    # The wheel of the archive is that of the checkout.
    again, _ = build(folder, tmp_path / "again")
    contents = []
    for path in (archives[0], again):
        with zipfile.ZipFile(path) as wheel:
            contents.append({item.filename: item.CRC for item in wheel.infolist()})
    assert contents[0] == contents[1]


def test_the_commands_need_no_checkout(installed, tmp_path):
    def command(name, *arguments):
        return run(installed, f"ftac-{name}", *arguments, folder=tmp_path)

    where = run(installed, "python", "-c", "import ftac_gym; print(ftac_gym.__file__)", folder=tmp_path)
    assert Path(where.strip()).is_relative_to(installed)
    before = {path for path in installed.rglob("*") if "__pycache__" not in path.parts}
    (tmp_path / "controllers.py").write_text(CUSTOM)
    command("tune", "--baseline", "pd", "--trials", 2, "--episodes", 4, "--workers", 1)
    gains = "runs/tuning/pd/gains.json"
    base = f"ResidualPolicy base=pd gains={gains}"
    sizes = ("--total-steps", 2000, "--evaluation-episodes", 4, "--torch-threads", 1)
    command("train", "--run-folder", "runs/mine", "--wrappers", base, *TINY, *sizes)
    policies = ("pd", f"pd {gains}", "runs/mine/agent", "controllers:Mine")
    shown = command("evaluate", "--policies", *policies, "--reference", "pd", "--splits", "--episodes", 2)
    assert "controllers:Mine" in shown and (tmp_path / "results/flagship/report.md").is_file()
    assert "usage: ftac-reproduce" in command("reproduce", "--help")
    film = ("--policy", "pd", "--seconds", 0.5, "--width", 320, "--height", 240, "--output", "film.gif")
    command("play", *film)
    assert (tmp_path / "film.gif").read_bytes()[:3] == b"GIF"
    # What is compiled apart, nothing is written into the package.
    assert {path for path in installed.rglob("*") if "__pycache__" not in path.parts} == before
