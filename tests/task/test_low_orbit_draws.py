"""Tests of `task.low_orbit`: sizes of the total torque, draws, and rules."""

import dataclasses
import math

import numpy as np
import pytest
from helpers.low_orbit import (
    GRADIENT,
    MAGNETIC,
    NOMINAL,
    PANELS,
    SPHERE,
    TORQUE,
    deviates,
    history,
    inertias,
    peak,
    same,
    size,
)
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from ftac_gym.task import LowOrbitTorque
from ftac_gym.task.atmosphere import atmospheric_density
from ftac_gym.task.orbit import GRAVITATIONAL_PARAMETER, MAGNETIC_MOMENT

# ------------------------------------------------------------------------------------------------------------ sizes


def test_total_torque_of_the_defaults_has_the_size_of_a_small_craft():
    uniform = deviates(20_000)
    torques = size(history(*TORQUE.draw(uniform, inertias(20_000))))
    assert torques.max() < 2e-4 and torques.max(axis=1).min() > 1e-6
    assert 1e-5 < np.median(torques) < 1e-4


@pytest.mark.parametrize(
    ("torque", "inertia", "expected"),
    [
        # A body of about 30 kg m^2 whose moments differ by 0.3 of that.
        (dataclasses.replace(GRADIENT, altitude=500e3), np.diag([21.0, 26.0, 30.0]), 2e-5),
        (dataclasses.replace(MAGNETIC, altitude=500e3, residual_dipole=1.0), SPHERE, 5e-5),
        (dataclasses.replace(PANELS, altitude=500e3, solar_area=0.0), SPHERE, 1.3e-5),
        (dataclasses.replace(PANELS, altitude=400e3, solar_area=0.0), SPHERE, 8e-5),
        (dataclasses.replace(PANELS, drag_area=0.0), SPHERE, 3e-6),
    ],
    ids=["gravity gradient", "residual dipole", "drag at 500 km", "drag at 400 km", "sunlight"],
)
def test_largest_torques_have_the_known_order_of_magnitude(torque, inertia, expected):
    largest = peak(torque, inertia, deviates(1000)).max()
    assert expected / 2.0 < largest < expected * 2.0


@st.composite
def distributions(draw):
    """Any distribution that the rules allow, with ranges or fixed values."""

    def size(low, high):
        first, second = sorted((draw(st.floats(low, high)), draw(st.floats(low, high))))
        return first if draw(st.booleans()) else (first, second)

    return LowOrbitTorque(
        altitude=size(200e3, 1000e3),
        inclination=size(0.0, math.pi),
        drag_area=size(0.0, 20.0),
        drag_coefficient=draw(st.floats(0.0, 4.0)),
        solar_area=size(0.0, 20.0),
        reflectivity=draw(st.floats(0.0, 1.0)),
        pressure_offset=size(0.0, 1.0),
        residual_dipole=size(0.0, 20.0),
        density_factor=size(0.0, 20.0),
    )


@settings(max_examples=60, deadline=None, derandomize=True)
@given(distributions(), st.integers(0, 10_000))
def test_total_torque_stays_below_the_sum_of_the_largest_of_each_model(torque, seed):
    uniform, inertia = deviates(20, seed), inertias(20, seed)
    geometry, moments = torque.geometry(uniform), np.linalg.eigvalsh(inertia)
    dynamic_pressure = 0.5 * geometry.density * GRAVITATIONAL_PARAMETER / geometry.radius
    drag = dynamic_pressure * torque.drag_coefficient * geometry.drag_area
    bound = (
        1.5 * GRAVITATIONAL_PARAMETER / geometry.radius**3 * (moments[:, 2] - moments[:, 0])
        + 2.0 * MAGNETIC_MOMENT / geometry.radius**3 * size(geometry.residual_dipole)
        + (drag + 4.56e-6 * (1.0 + torque.reflectivity) * geometry.solar_area) * size(geometry.pressure_offset)
    )
    assert np.all(size(history(*torque.draw(uniform, inertia))) <= bound[:, None] * (1.0 + 1e-9))


# ------------------------------------------------------------------------------------------------------------ draws


def test_geometry_is_uniform_and_its_parts_independent():
    geometry = TORQUE.geometry(deviates(4000))
    frames = np.stack([geometry.node, geometry.transverse, geometry.normal], axis=1)
    np.testing.assert_allclose(frames @ np.swapaxes(frames, 1, 2), np.tile(np.eye(3), (4000, 1, 1)), atol=1e-14)
    np.testing.assert_allclose(np.linalg.det(frames), 1.0, rtol=1e-12)
    directions = [geometry.node, geometry.transverse, geometry.normal, geometry.sunlight]
    directions += [vectors / size(vectors)[:, None] for vectors in (geometry.pressure_offset, geometry.residual_dipole)]
    columns = [column for vectors in directions for column in vectors.T]
    # On the sphere each coordinate of a uniform direction is uniform.
    ranges = [(-1.0, 2.0)] * len(columns)
    factor = geometry.density / atmospheric_density(geometry.altitude)
    for column, bounds in (
        (geometry.altitude, TORQUE.altitude),
        (geometry.inclination, TORQUE.inclination),
        (geometry.latitude_argument, (0.0, 2.0 * math.pi)),
        (geometry.drag_area, TORQUE.drag_area),
        (geometry.solar_area, TORQUE.solar_area),
        (size(geometry.pressure_offset), TORQUE.pressure_offset),
        (size(geometry.residual_dipole), TORQUE.residual_dipole),
        (factor, TORQUE.density_factor),
    ):
        columns.append(column)
        ranges.append((bounds[0], bounds[1] - bounds[0]))
    for column, (low, width) in zip(columns, ranges, strict=True):
        assert stats.kstest(column, "uniform", (low, width)).pvalue > 1e-3
    assert np.abs(np.corrcoef(columns) - np.eye(len(columns))).max() < 0.08


def test_every_deviate_counts():
    uniform = deviates(1)
    before = history(*TORQUE.draw(uniform, NOMINAL[None]))
    for column in range(TORQUE.uniform_count):
        changed = uniform.copy()
        changed[0, column] = (changed[0, column] + 0.3) % 1.0
        assert not np.allclose(history(*TORQUE.draw(changed, NOMINAL[None])), before, rtol=1e-6, atol=0.0)


@pytest.mark.parametrize("count", [1, 2, 3, 50, 1999])
def test_a_craft_draws_the_same_alone_and_in_any_company(count):
    uniform, inertia = deviates(2000), inertias(2000)
    steady, harmonics = TORQUE.draw(uniform, inertia)
    again_steady, again_harmonics = TORQUE.draw(uniform[-count:], inertia[-count:])
    np.testing.assert_array_equal(steady[-count:], again_steady)
    np.testing.assert_array_equal(harmonics[-count:], again_harmonics)


def test_no_craft_draw_nothing():
    steady, harmonics = TORQUE.draw(deviates(0), np.zeros((0, 3, 3)))
    assert steady.shape == (0,) and harmonics.shape == (0, 2)


# ------------------------------------------------------------------------------------------------------------ rules


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: LowOrbitTorque(altitude=(199e3, 400e3)), "altitude must stay within"),
        (lambda: LowOrbitTorque(altitude=1001e3), "altitude must stay within"),
        (lambda: LowOrbitTorque(altitude=400.0), "altitude must stay within"),
        (lambda: LowOrbitTorque(altitude=(500e3, 400e3)), "altitude must have low <= high"),
        (lambda: LowOrbitTorque(altitude=None), "altitude must be a number"),
        (lambda: LowOrbitTorque(inclination=(-0.1, 1.0)), "inclination must stay within"),
        (lambda: LowOrbitTorque(inclination=98.0), "inclination must stay within"),
        (lambda: LowOrbitTorque(drag_area=-1.0), "drag_area must not be negative"),
        (lambda: LowOrbitTorque(drag_coefficient=-2.2), "drag_coefficient must not be negative"),
        (lambda: LowOrbitTorque(drag_coefficient=(2.0, 2.4)), "drag_coefficient must be a number"),
        (lambda: LowOrbitTorque(solar_area=(-1.0, 1.0)), "solar_area must not be negative"),
        (lambda: LowOrbitTorque(reflectivity=-0.1), "reflectivity must not be negative"),
        (lambda: LowOrbitTorque(reflectivity=1.1), "reflectivity must stay within"),
        (lambda: LowOrbitTorque(pressure_offset=(-0.1, 0.1)), "pressure_offset must not be negative"),
        (lambda: LowOrbitTorque(residual_dipole=float("inf")), "residual_dipole must be finite"),
        (lambda: LowOrbitTorque(density_factor=-1.0), "density_factor must not be negative"),
        (lambda: TORQUE.draw(np.zeros((2, 16)), same(NOMINAL, 2)), "uniform must have the shape"),
        (lambda: TORQUE.draw(np.zeros(17), same(NOMINAL, 1)), "uniform must have the shape"),
        (lambda: TORQUE.draw(np.ones((2, 17)), same(NOMINAL, 2)), "uniform must lie within"),
        (lambda: TORQUE.draw(np.full((2, 17), np.nan), same(NOMINAL, 2)), "uniform must lie within"),
        (lambda: TORQUE.draw(np.zeros((2, 17)), NOMINAL), "inertia must have the shape"),
        (lambda: TORQUE.draw(np.zeros((2, 17)), same(NOMINAL, 3)), "inertia must have the shape"),
        (lambda: TORQUE.draw(np.zeros((1, 17)), np.full((1, 3, 3), np.inf)), "inertia must be finite"),
    ],
)
def test_rules(build, message):
    with pytest.raises(ValueError, match=message):
        build()
