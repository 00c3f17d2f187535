"""The 3-D view: what a frame shows, and that it follows the spacecraft."""

import os
import subprocess
import sys
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from gymnasium.error import DependencyNotInstalled

from ftac_gym import scenarios
from ftac_gym.attitude import quaternion_from_rotation_vector
from ftac_gym.envs import SpacecraftFTCVectorEnv
from ftac_gym.envs.rendering import Renderer, snapshots
from ftac_gym.envs.rendering.camera import VIEW_FROM, Camera
from ftac_gym.envs.rendering.mesh import EXAGGERATION, REACH, body_faces, panel_faces, panel_turn
from ftac_gym.envs.rendering.readouts import FARTHEST, NEAREST, logarithmic


def snapshot_of(name, **changes):
    env = SpacecraftFTCVectorEnv(1, scenario=name)
    env.reset(seed=1)
    return env.scenario, replace(snapshots(env.batch, "somebody")[0], **changes)


@pytest.mark.parametrize("size", [(320, 240), (640, 480), (1280, 720), (480, 480)])
@pytest.mark.parametrize("name", ["flagship_double", "flexible", "li_2023", "chen_2018", "shen_2019"])
def test_frames_have_their_size_and_are_the_same_again(name, size):
    scenario, snapshot = snapshot_of(name)
    frame = Renderer(scenario, *size).frame(snapshot)
    assert frame.shape == (size[1], size[0], 3) and frame.dtype == np.uint8
    np.testing.assert_array_equal(frame, Renderer(scenario, *size).frame(snapshot))


def test_what_changes_is_seen():
    scenario, snapshot = snapshot_of("flexible")
    quarter = quaternion_from_rotation_vector(np.array([0.3, 0.0, 0.0]))
    changes = [
        {"attitude": quarter},
        {"policy": "another"},
        {"time": 3.0},
        {"faults": ("wheel 1: seizure at 2.0 s",)},
        {"faulty": np.array([False, True, False, False])},
        {"wheel_torque": np.full(4, 0.1)},
        {"wheel_momentum": np.full(4, 5.0)},
        {"modal_displacement": np.array([0.3, 0.0, 0.0, 0.0])},
        {"reference_attitude": quarter},
    ]
    first = Renderer(scenario).frame(snapshot)
    for change in changes:
        assert (Renderer(scenario).frame(replace(snapshot, **change)) != first).any(), change


def test_long_lists_of_faults_are_not_cut_off():
    scenario, snapshot = snapshot_of("flagship")
    words = tuple(f"wheel {wheel}: drifting effectiveness at {10 * wheel}.0 s" for wheel in range(4))
    frames = [Renderer(scenario, 320, 240).frame(replace(snapshot, faults=words[:count])) for count in range(5)]
    for shorter, longer in pairwise(frames):
        assert (shorter != longer).any()


def test_the_trail_grows_with_the_boresight_and_ends_with_the_episode():
    scenario, snapshot = snapshot_of("flagship")
    renderer = Renderer(scenario)
    start = renderer.frame(replace(snapshot, time=0.0))
    turned = replace(snapshot, time=5.0, attitude=quaternion_from_rotation_vector(np.array([1.0, 0.0, 0.0])))
    with_trail = renderer.frame(turned)
    assert (with_trail != Renderer(scenario).frame(turned)).any()
    np.testing.assert_array_equal(renderer.frame(replace(snapshot, time=0.0)), start)


def test_the_camera_is_a_pinhole():
    camera = Camera((320.0, 200.0), 150.0)
    right, up, toward = camera.axes
    np.testing.assert_allclose(camera.axes @ camera.axes.T, np.eye(3), atol=1e-14)
    pixels, depth = camera.project(np.stack([np.zeros(3), right, up, toward]))
    np.testing.assert_allclose(pixels[0], (320.0, 200.0))
    assert pixels[1, 0] > 320.0 and pixels[1, 1] == pytest.approx(200.0)
    assert pixels[2, 1] < 200.0 and pixels[2, 0] == pytest.approx(320.0)
    assert depth[3] == pytest.approx(1.0)
    # Everything on one ray from the camera falls on one point.
    ray = np.array(VIEW_FROM) + np.outer([1.0, 2.5], [-0.5, 0.9, -0.4])
    np.testing.assert_allclose(*camera.project(ray)[0])


def test_panels_bend_in_proportion_and_the_right_way():
    appendages = scenarios.get("flexible").spacecraft.appendages
    displacement = np.array([0.002, -0.001, 0.003, 0.001])
    turn = panel_turn(appendages, displacement)
    np.testing.assert_allclose(panel_turn(appendages, 2.0 * displacement), 2.0 * turn)
    still = panel_faces(np.zeros(3))
    tip = panel_faces(np.array([0.0, 0.001, 0.0])) - still
    # A turn about y lowers what lies at +x and raises what lies at -x.
    at_tips = tip[np.abs(still[..., 0]) == np.abs(still[..., 0]).max()]
    sides = still[np.abs(still[..., 0]) == np.abs(still[..., 0]).max()][:, 0]
    np.testing.assert_allclose(at_tips[:, 2], -np.sign(sides) * EXAGGERATION * 0.001 * REACH, rtol=1e-12)
    assert panel_turn(None, np.zeros(0)).tolist() == [0.0, 0.0, 0.0]


def test_sides_of_the_body_look_outwards():
    for face in body_faces():
        normal = np.cross(face[1] - face[0], face[2] - face[1])
        assert normal @ face.mean(axis=0) > 0.0


def test_the_inset_is_logarithmic():
    assert logarithmic(0.0) == 0.0 and logarithmic(NEAREST) == 0.0 and logarithmic(FARTHEST) == 1.0
    assert logarithmic(np.sqrt(NEAREST * FARTHEST)) == pytest.approx(0.5)


@pytest.mark.parametrize(("width", "height"), [(319, 480), (640, 100), (640.5, 480), (True, 480), (-640, 480)])
def test_bad_sizes_are_refused(width, height):
    with pytest.raises(ValueError, match=r"(width|height) must be an integer, (320|240) or more \[pixels\], got"):
        Renderer(scenarios.get("flagship"), width, height)


def test_a_missing_library_names_the_extra(monkeypatch):
    monkeypatch.setitem(sys.modules, "pygame", None)
    with pytest.raises(DependencyNotInstalled, match=r'pygame is missing: pip install "ftac_gym\[render\]"'):
        SpacecraftFTCVectorEnv(1, render_mode="human")
    # Stable-Baselines3 asks for arrays whenever it makes an environment.
    env = SpacecraftFTCVectorEnv(1, render_mode="rgb_array")
    env.reset(seed=0)
    env.step(env.action_space.sample())
    with pytest.raises(DependencyNotInstalled, match=r'pygame is missing: pip install "ftac_gym\[render\]"'):
        env.render()


def test_an_environment_refuses_a_bad_size_before_the_first_frame():
    with pytest.raises(ValueError, match=r"width must be an integer, 320 or more \[pixels\], got 10"):
        SpacecraftFTCVectorEnv(1, render_mode="rgb_array", width=10)


def test_no_screen_is_needed_and_pygame_is_imported_late():
    code = """
import sys, gymnasium as gym, ftac_gym, ftac_gym.envs.rendering
env = gym.make("SpacecraftFTC-v0")
assert "pygame" not in sys.modules
env = gym.make("SpacecraftFTC-v0", render_mode="rgb_array")
env.reset(seed=0)
print(env.render().shape)
"""
    clean = {name: value for name, value in os.environ.items() if name not in ("DISPLAY", "SDL_VIDEODRIVER")}
    done = subprocess.run([sys.executable, "-c", code], env=clean, capture_output=True, text=True, check=False)
    assert "(480, 640, 3)" in done.stdout, done.stderr


def test_closing_twice_is_closing_once():
    scenario, snapshot = snapshot_of("flagship")
    renderer = Renderer(scenario)
    renderer.frame(snapshot)
    renderer.close()
    renderer.close()
