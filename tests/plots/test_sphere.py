"""The boresight on the sphere: where it points, and how far off its target that is."""

import numpy as np
import pytest

from ftac_gym import scenarios
from ftac_gym.attitude import angle_between, rotation_matrix
from ftac_gym.evaluation import rollout
from ftac_gym.plots import boresight_paths
from ftac_gym.plots.sphere import directions, offsets

AXIS = np.array([0.6, 0.0, 0.8])


@pytest.fixture(scope="module", params=["flagship", "flagship_tracking", "flexible"])
def histories(request):
    scenario = scenarios.get(request.param).replace(duration=10.0)
    return {name: rollout(scenario, name, seed=2) for name in ("pd", "pd_dob")}


def test_a_boresight_points_where_the_attitude_says():
    quarter = np.array([[np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)]])  # A quarter turn about z: body x is inertial y.
    np.testing.assert_allclose(directions(quarter, np.array([1.0, 0.0, 0.0])), [[0.0, 1.0, 0.0]], atol=1e-12)


def test_paths_lie_on_the_sphere_and_start_together(histories):
    for history in histories.values():
        path = directions(history.attitude[:, 0], AXIS)
        np.testing.assert_allclose(np.linalg.norm(path, axis=1), 1.0)
        turned = np.einsum("tij,i->tj", rotation_matrix(history.attitude[:, 0]), AXIS)
        np.testing.assert_allclose(path, turned, atol=1e-12)


def test_offsets_have_the_length_of_the_angle_to_the_target(histories):
    for history in histories.values():
        path, target = directions(history.attitude[:, 0], AXIS), directions(history.reference_attitude[:, 0], AXIS)
        cosine = np.clip(np.einsum("ti,ti->t", path, target), -1.0, 1.0)
        length = np.linalg.norm(offsets(history, AXIS), axis=1)
        np.testing.assert_allclose(length, np.degrees(np.arccos(cosine)), atol=2e-5)
        # The boresight is never farther off than the whole attitude.
        whole = np.degrees(angle_between(history.attitude[:, 0], history.reference_attitude[:, 0]))
        assert np.all(length <= whole + 1e-6)


def test_what_is_drawn_is_what_was_flown(histories, tmp_path):
    figure = boresight_paths(histories, AXIS)
    globe, flat = figure.axes
    for number, history in enumerate(histories.values()):
        np.testing.assert_allclose(flat.lines[2 * number].get_xydata(), offsets(history, AXIS), atol=1e-12)
        path = directions(history.attitude[:, 0], AXIS)
        assert any(
            len(line.get_data_3d()[0]) == len(path) and np.allclose(np.transpose(line.get_data_3d()), path)
            for line in globe.lines
        )
    assert [text.get_text() for text in figure.legends[0].get_texts()][:2] == list(histories)
    assert flat.get_xlabel().endswith("[deg]") and flat.get_ylabel().endswith("[deg]")
    figure.savefig(tmp_path / "sphere.png", dpi=30)


def test_the_length_of_the_boresight_does_not_matter(histories):
    first, second = (boresight_paths(histories, scale * AXIS).axes[1].lines[0].get_xydata() for scale in (1.0, 30.0))
    np.testing.assert_allclose(first, second, atol=1e-9)


def test_refused(histories):
    with pytest.raises(ValueError, match="boresight must not be zero"):
        boresight_paths(histories, (0.0, 0.0, 0.0))
    with pytest.raises(ValueError, match="boresight must have 3 numbers"):
        boresight_paths(histories, (0.0, 1.0))
    with pytest.raises(ValueError, match="histories must hold at least one rollout"):
        boresight_paths({})
