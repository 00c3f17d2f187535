"""The viewer from the command line."""

from dataclasses import replace

import pytest
from helpers.scripts import module_of, run

from ftac_gym import scenarios
from ftac_gym.faults import Bias, FaultSchedule, Seizure


def test_a_seizure_under_two_policies_becomes_a_film(tmp_path):
    words = "--policy nftsm --against pd_dob --fault seizure:2@1 --seconds 3 --speed 4 --width 640 --height 320"
    done = run("play.py", *words.split(), "--output", "out/film.mp4", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "out" / "film.mp4").read_bytes()[4:8] == b"ftyp"


def test_faults_replace_those_of_the_scenario_or_come_on_top_with_a_plus():
    module, flagship = module_of("play"), scenarios.get("flagship")
    seizure, bias = Seizure(wheel=2, onset=15.0, brake=2.0), Bias(wheel=1, onset=0.0, amplitude=0.08, frequency=0.3)
    for words, expected in (
        ((), flagship.faults),
        (("none",), None),
        (("seizure:2@15", "bias:1"), FaultSchedule((seizure, bias))),
        (("+seizure:2@15", "+bias:1"), replace(flagship.faults, always=(seizure, bias))),
    ):
        assert module.task(module.Config(fault=words)).faults == expected
    with pytest.raises(ValueError, match="KIND"):
        module.task(module.Config(fault=("seizure:2@15", "+bias:1")))


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["--policy", "nftms"], ["policy must be", "nftsm_observer", "flagship_residual", "'nftsm tuned'"]),
        (["--fault", "seizzure:2@15"], ["seizure:2@15", "lock_in_place", "KIND:WHEEL@ONSET"]),
        (["--fault", "seizure:7@15"], ["wheel must be below the number of wheels, 4, got 7"]),
        (["--scenario", "flagshop"], ["flagship_hardware"]),
    ],
)
def test_errors_list_the_known_names(tmp_path, words, expected):
    done = run("play.py", *words, "--output", "film.mp4", folder=tmp_path)
    assert done.returncode == 1
    for text in expected:
        assert text in done.stderr
    assert "Traceback" not in done.stderr


def test_keys_of_the_window_add_faults_and_film(tmp_path, monkeypatch):
    pygame = pytest.importorskip("pygame")
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    module = module_of("play")
    config = module.Config(policy="pd", fault=("none",), width=640, height=480, films=tmp_path)
    session = module.begin(config)
    keys = [pygame.K_v, pygame.K_TAB, pygame.K_1, pygame.K_RIGHT, pygame.K_z, pygame.K_v, pygame.K_q]
    waiting = [pygame.event.Event(pygame.KEYDOWN, key=key, mod=0) for key in keys]
    monkeypatch.setattr(module.Window, "events", lambda window: [waiting.pop(0)] if waiting else [])
    module.watch(config, session)
    assert session.live[0].snapshot().faults[0].startswith("wheel 1: drifting effectiveness at")
    assert session.paused and not waiting
    films = list(tmp_path.glob("*.mp4"))
    assert len(films) == 1 and films[0].read_bytes()[4:8] == b"ftyp"
