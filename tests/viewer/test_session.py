"""Viewer: the same episode for all policies, keys, and films."""

import numpy as np
import pytest
from imageio.v3 import immeta, imread

from ftac_gym import scenarios
from ftac_gym.evaluation import rollout
from ftac_gym.faults import KINDS
from ftac_gym.faults.specification import name_of
from ftac_gym.policies import DeferredBaseline
from ftac_gym.viewer import Film, LiveEpisode, Screen, Session
from ftac_gym.viewer.keys import press

FLAGSHIP = scenarios.get("flagship").replace(duration=40.0)


def test_a_live_episode_is_the_rollout_of_its_episode():
    episode = FLAGSHIP.draw(5, 1)
    live = LiveEpisode(FLAGSHIP, "nftsm", "nftsm")
    live.reset(episode)
    history = rollout(FLAGSHIP, "nftsm", episode)
    for step in range(FLAGSHIP.horizon):
        live.step()
        np.testing.assert_array_equal(live.snapshot().attitude, history.attitude[step + 1, 0])
    assert live.over
    live.step()
    assert live.time == pytest.approx(40.0)


def test_one_policy_object_in_two_episodes_at_once():
    policy = DeferredBaseline("pd_dob")
    session = Session(FLAGSHIP, {"a": policy, "b": policy, "c": "pd_dob"}, seed=3)
    session.run(5.0)
    first, second, third = (live.snapshot().attitude for live in session.live)
    np.testing.assert_array_equal(first, third)
    np.testing.assert_array_equal(second, third)


def test_an_episode_with_live_faults_replays():
    session = Session(FLAGSHIP.replace(faults=None), {"a": "pd_dob", "b": "nftsm"}, seed=3)
    session.kind = "seizure"
    session.run(5.0)
    assert press(session, "2") == "seizure"
    assert all(live.snapshot().faults == ("wheel 2: seizure at 5.0 s",) for live in session.live)
    session.run(10.0)
    assert press(session, "2", shift=True) == "wheel 2: faults cleared"
    assert all(live.snapshot().faults == () for live in session.live)
    session.run(100.0)
    assert session.over
    last = session.live[0].snapshot().attitude
    history = rollout(FLAGSHIP, "pd_dob", session.live[0].episode)
    np.testing.assert_array_equal(history.attitude[-1, 0], last)
    session.restart()
    assert session.time == 0.0 and not session.over
    session.run(100.0)
    assert np.abs(session.live[0].snapshot().attitude - last).max() > 1e-9, "the live fault is gone"


def test_keys():
    session = Session(FLAGSHIP, {"pd": "pd"})
    names = [name_of(kind) for kind in KINDS]
    assert session.kind == names[0]
    press(session, "tab")
    assert session.kind == names[1]
    press(session, "tab", shift=True)
    press(session, "tab", shift=True)
    assert session.kind == names[-1]
    press(session, "space")
    session.run(10.0)
    assert session.paused and session.time == 0.0
    press(session, "right")
    assert session.time == pytest.approx(0.1)
    press(session, "space")
    press(session, "up")
    session.run(1.0)
    assert session.speed == 2.0 and session.time == pytest.approx(2.1)
    for _ in range(20):
        press(session, "down")
    assert session.speed == 0.125
    assert press(session, "9") == f"{names[-1].replace('_', ' ')} does not fit wheel 9"
    assert press(session, "9", shift=True) == "there is no wheel 9"
    assert press(session, "n") == "the next episode" and session.episode == 1 and session.time == 0.0
    assert press(session, "r") == "the same episode again" and session.episode == 1
    assert press(session, "") == "" and press(session, "z") == ""


def test_every_kind_can_be_added_and_cleared():
    session = Session(FLAGSHIP.replace(faults=None), {"pd": "pd"})
    added = 0
    for _ in session.kinds:
        added += session.add_fault(1)
        press(session, "tab")
        session.run(0.5)
    # Friction needs a friction model, which the flagship's wheels do not have.
    assert added == len(KINDS) - 1
    assert press(session, "backspace") == "all faults cleared"
    session.run(0.2)
    assert session.live[0].snapshot().faults == ()


def test_slow_viewers_lose_no_time():
    session = Session(FLAGSHIP, {"pd": "pd"})
    for _ in range(300):
        session.run(1.0 / 30.0)
    assert session.time == pytest.approx(10.0)


def test_a_screen_shows_all_policies():
    session = Session(FLAGSHIP, {"pd": "pd", "nftsm": "nftsm"})
    screen = Screen(session, 1000, 480)
    screen.draw()
    frame = screen.frame()
    assert frame.shape == (480, 1000, 3)
    session.run(8.0)
    screen.draw()
    later = screen.frame()
    assert (later[:, :500] != frame[:, :500]).any() and (later[:, 500:] != frame[:, 500:]).any()


@pytest.mark.parametrize(("suffix", "magic"), [(".mp4", b"ftyp"), (".gif", b"GIF89a")])
def test_films(tmp_path, suffix, magic):
    path = tmp_path / "new" / f"film{suffix}"
    with Film(path, 64, 48, 10) as film:
        for value in range(12):
            film.add(np.full((48, 64, 3), 20 * value, dtype=np.uint8))
        with pytest.raises(ValueError, match=r"frame must have shape \(48, 64, 3\)"):
            film.add(np.zeros((64, 48, 3), dtype=np.uint8))
    film.close()
    assert film.frames == 12 and magic in path.read_bytes()[:12]


@pytest.mark.parametrize("rate", [15, 24, 30, 50])
@pytest.mark.parametrize("suffix", [".mp4", ".gif"])
def test_films_last_as_long_as_their_frames_say(tmp_path, suffix, rate):
    path = tmp_path / f"film{suffix}"
    with Film(path, 64, 48, rate) as film:
        for value in range(2 * rate):
            film.add(np.full((48, 64, 3), 2 * value, dtype=np.uint8))
    if suffix == ".mp4":
        length = immeta(path, plugin="FFMPEG")["duration"]
    else:
        length = sum(immeta(path, index=index)["duration"] for index in range(len(imread(path)))) / 1000.0
    assert length == pytest.approx(2.0, abs=0.01)


def test_a_gif_that_viewers_would_slow_down_is_refused(tmp_path):
    with pytest.raises(ValueError, match=r"frames_per_second must be at most 50 for a \.gif, got 60"):
        Film(tmp_path / "a.gif", 64, 48, 60)


@pytest.mark.parametrize(
    ("path", "size", "message"),
    [("a.avi", (64, 48), r"film must end in one of \['.mp4', '.gif'\]"), ("a.mp4", (65, 48), "must be even numbers")],
)
def test_impossible_films_are_refused(tmp_path, path, size, message):
    with pytest.raises(ValueError, match=message):
        Film(tmp_path / path, *size, 10)


def test_sessions_check_what_they_get():
    with pytest.raises(ValueError, match="policies must be one at least"):
        Session(FLAGSHIP, {})
    with pytest.raises(ValueError, match="seed must not be negative"):
        Session(FLAGSHIP, {"pd": "pd"}, seed=-1)
