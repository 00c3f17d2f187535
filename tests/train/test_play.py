"""Watching from the command line."""

import subprocess
import sys
from pathlib import Path

import pytest

PLAY = str(Path(__file__).parents[2] / "train" / "play.py")


def play(*words, cwd):
    return subprocess.run([sys.executable, PLAY, *words], cwd=cwd, capture_output=True, text=True, check=False)


def test_a_seizure_under_two_policies_becomes_a_film(tmp_path):
    words = "--policy nftsm --against pd_dob --fault seizure:2@1 --seconds 3 --speed 4 --width 640 --height 320"
    done = play(*words.split(), "--output", "out/film.mp4", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "out" / "film.mp4").read_bytes()[4:8] == b"ftyp"


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--policy", "nftms"], ["policy must be", "nftsm_observer", "flagship_residual", "'nftsm tuned'"]),
        (["--fault", "seizzure:2@15"], ["seizure:2@15", "lock_in_place", "KIND:WHEEL@ONSET"]),
        (["--fault", "seizure:7@15"], ["wheel must be below the number of wheels, 4, got 7"]),
        (["--scenario", "flagshop"], ["flagship_hardware"]),
    ],
)
def test_what_is_unknown_lists_what_is_known(tmp_path, words, told):
    done = play(*words, "--output", "film.mp4", cwd=tmp_path)
    assert done.returncode == 1
    for text in told:
        assert text in done.stderr
    assert "Traceback" not in done.stderr
