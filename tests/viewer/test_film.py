"""Films are complete or absent, whatever ends them."""

import subprocess
import sys

import numpy as np
import pytest
from helpers.scripts import command
from helpers.small_disk import on_small_disk
from imageio_ffmpeg import count_frames_and_secs

from ftac_gym.viewer import Film

FRAME = np.zeros((48, 64, 3), dtype=np.uint8)
suffixes = pytest.mark.parametrize("suffix", [".mp4", ".gif"])


@suffixes
def test_an_error_leaves_the_older_film(tmp_path, suffix):
    path = tmp_path / f"film{suffix}"
    path.write_bytes(b"older")
    film = Film(path, 64, 48, 10)

    def fail():
        with film:
            film.add(FRAME)
            assert path.read_bytes() == b"older"
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail()
    assert [item.name for item in tmp_path.iterdir()] == [path.name] and path.read_bytes() == b"older"


@suffixes
def test_films_of_one_path_are_written_apart(tmp_path, suffix):
    path = tmp_path / f"film{suffix}"
    with Film(path, 64, 48, 10) as first, Film(path, 64, 48, 10) as second:
        for _ in range(3):
            first.add(FRAME)
        second.add(FRAME)
    # The first is closed last.
    assert [item.name for item in tmp_path.iterdir()] == [path.name]
    if suffix == ".mp4":
        assert count_frames_and_secs(path)[0] == 3


@suffixes
def test_a_film_without_frames_is_absent(tmp_path, suffix):
    with Film(tmp_path / f"film{suffix}", 64, 48, 10):
        pass
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("rate", [7.3, 29.97])
@pytest.mark.parametrize("frames", [1, 2, 61])
def test_all_frames_of_a_film_can_be_read_back(tmp_path, rate, frames):
    with Film(tmp_path / "film.mp4", 64, 48, rate) as film:
        for _ in range(frames):
            film.add(FRAME)
    assert count_frames_and_secs(tmp_path / "film.mp4")[0] == frames


NOISE = """
import sys
import numpy as np
from ftac_gym.utils.console import run_program
from ftac_gym.viewer import Film
from dataclasses import dataclass

@dataclass
class Config:
    path: str
    frames: int

def main(config):
    open(config.path, "w").write("older")
    generator = np.random.default_rng(0)
    try:
        with Film(config.path, 128, 96, 30) as film:
            for _ in range(config.frames):
                film.add(generator.integers(0, 256, (96, 128, 3), dtype=np.uint8))
    finally:
        print(open(config.path).read())

run_program(main, Config, None)
"""


@pytest.mark.parametrize(("suffix", "frames"), [(".mp4", 8), (".mp4", 400), (".gif", 30)])
def test_a_full_disk_leaves_the_older_film_and_one_line(tmp_path, suffix, frames):
    """Few frames fail when ffmpeg ends, many while it takes frames."""
    path = tmp_path / "disk" / f"film{suffix}"
    words = [sys.executable, "-c", NOISE, "--path", str(path), "--frames", str(frames)]
    done = subprocess.run(
        on_small_disk(words, tmp_path / "disk", 40), capture_output=True, text=True, check=False, timeout=60
    )
    assert done.returncode == 1 and done.stdout == "older\n"
    assert done.stderr == f"No space left on device: {path}\n"


def test_the_viewer_names_a_full_disk(tmp_path):
    path = tmp_path / "disk" / "film.mp4"
    words = ["--seconds", "0.5", "--speed", "0.5", "--width", "640", "--height", "320", "--output", path]
    words = command("play.py", "--policy", "pd", *words)
    done = subprocess.run(
        on_small_disk(words, tmp_path / "disk", 8), capture_output=True, text=True, check=False, timeout=60
    )
    assert done.returncode == 1 and "wrote" not in done.stdout
    # The simulation may have to be compiled first, which a line of its own says.
    assert done.stderr.splitlines()[-1] == f"No space left on device: {path}"
