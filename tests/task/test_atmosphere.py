"""Density of the air."""

import math

import numpy as np
import pytest

from ftac_gym.task.atmosphere import ATMOSPHERE, atmospheric_density


def test_density_is_that_of_the_table_and_falls_without_a_step():
    for altitude, density in ((200e3, 2.789e-10), (400e3, 3.725e-12), (500e3, 6.967e-13), (1000e3, 3.019e-15)):
        assert atmospheric_density(np.array([altitude]))[0] == pytest.approx(density, rel=1e-14)
    middle = 3.725e-12 * math.exp(-30.0 / 58.515)
    assert atmospheric_density(np.array([430e3]))[0] == pytest.approx(middle, rel=1e-12)
    assert np.all(np.diff(atmospheric_density(np.linspace(200e3, 1000e3, 20_001))) < 0.0)
    seams = ATMOSPHERE[1:, 0]
    np.testing.assert_allclose(atmospheric_density(seams - 1e-3), atmospheric_density(seams), rtol=2e-3)
