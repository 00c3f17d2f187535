"""The sphere of directions."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ftac_gym.utils.directions import across, circle, graticule

AXES = st.tuples(*[st.integers(-9, 9)] * 3).filter(any).map(lambda item: np.array(item) / np.linalg.norm(item))


@given(AXES)
def test_a_unit_vector_across_an_axis(axis):
    assert np.linalg.norm(across(axis)) == pytest.approx(1.0)
    assert across(axis) @ axis == pytest.approx(0.0, abs=1e-12)


@given(AXES)
def test_a_great_circle_is_closed_and_goes_round_once(axis):
    ring = circle(axis, 49)
    np.testing.assert_allclose(np.linalg.norm(ring, axis=1), 1.0)
    np.testing.assert_allclose(ring @ axis, 0.0, atol=1e-12)
    np.testing.assert_allclose(ring[0], ring[-1], atol=1e-12)
    swept = np.arcsin(np.clip(np.cross(ring[:-1], ring[1:]) @ axis, -1.0, 1.0)).sum()
    assert swept == pytest.approx(2.0 * np.pi)


def test_circles_of_latitude_and_longitude():
    lines = graticule(25)
    assert len(lines) == 5 + 6
    for line in lines:
        np.testing.assert_allclose(np.linalg.norm(line, axis=1), 1.0)
    heights = [line[:, 2] for line in lines[:5]]
    np.testing.assert_allclose([np.degrees(np.arcsin(height[0])) for height in heights], [-60, -30, 0, 30, 60])
    assert all(np.ptp(height) < 1e-12 for height in heights)
    for line in lines[5:]:
        np.testing.assert_allclose(line[6], (0.0, 0.0, 1.0), atol=1e-12)
