"""Tests of `low_orbit`: the records against the models in inertial axes, closed forms, sizes and rules."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from ftac_gym.task import InertiaUncertainty, LowOrbitTorque
from ftac_gym.task.low_orbit import (
    ATMOSPHERE,
    EARTH_RADIUS,
    GRAVITATIONAL_PARAMETER,
    MAGNETIC_MOMENT,
    atmospheric_density,
)

NOMINAL = np.array([[10.0, 1.2, 0.5], [1.2, 19.0, 1.5], [0.5, 1.5, 25.0]])  # kg m^2
SPHERE = np.eye(3)  # an inertia without gravity gradient [kg m^2]
ORBIT = np.linspace(0.0, 2.0 * math.pi, 49)  # n t over one orbit
TORQUE = LowOrbitTorque()
GRADIENT = LowOrbitTorque(drag_area=0.0, solar_area=0.0, residual_dipole=0.0)  # gravity gradient alone
MAGNETIC = LowOrbitTorque(drag_area=0.0, solar_area=0.0)  # on a sphere: residual dipole alone
DRAG = LowOrbitTorque(solar_area=0.0, residual_dipole=0.0)  # on a sphere: drag alone
SUNLIGHT = LowOrbitTorque(drag_area=0.0, residual_dipole=0.0)  # on a sphere: sunlight alone

# Two square metres, 15 cm off centre.
PANELS = LowOrbitTorque(drag_area=2.0, solar_area=2.0, pressure_offset=0.15, density_factor=1.0, residual_dipole=0.0)


def deviates(count=500, seed=0):
    return np.random.default_rng(seed).random((count, TORQUE.uniform_count))


def inertias(count, seed=1):
    """Inertias (N, 3, 3) spread by 30 % around the nominal one."""
    uncertainty = InertiaUncertainty(relative=0.3)
    return uncertainty.draw(NOMINAL, np.random.default_rng(seed).random((count, 6)))["constant"]


def same(inertia, count):
    return np.tile(inertia, (count, 1, 1))


def history(steady, harmonics):
    """Evaluate drawn records (N,), (N, 2) over one orbit of each spacecraft: (N, times, 3)."""
    time = ORBIT / harmonics["frequency"][:, :1]
    angle = harmonics["frequency"][:, None, :, None] * time[:, :, None, None]
    part = harmonics["sine"][:, None] * np.sin(angle) + harmonics["cosine"][:, None] * np.cos(angle)
    return steady["constant"][:, None] + part.sum(axis=2)


def peak(torque, inertia, uniform):
    """Largest torque over an orbit, (N,)."""
    return np.linalg.norm(history(*torque.draw(uniform, same(inertia, len(uniform)))), axis=2).max(axis=1)


def size(vectors):
    return np.linalg.norm(vectors, axis=-1)


# ----------------------------------------------------------------------------------------------------------- models


def reference(torque, geometry, craft, inertia, time):
    """Torque (3,) on one spacecraft, body axes, from positions and fields in inertial axes with z the Earth's axis."""
    inclination = geometry.inclination[craft]
    radius = 6378.137e3 + geometry.altitude[craft]
    rate = math.sqrt(3.986004418e14 / radius**3)
    latitude = geometry.latitude_argument[craft] + rate * time
    # The ascending node lies along x.
    position = np.array([
        math.cos(latitude),
        math.sin(latitude) * math.cos(inclination),
        math.sin(latitude) * math.sin(inclination),
    ])  # fmt: skip
    velocity = radius * rate * np.array([
        -math.sin(latitude),
        math.cos(latitude) * math.cos(inclination),
        math.cos(latitude) * math.sin(inclination),
    ])  # fmt: skip
    orbit = np.array([
        [1.0, 0.0, 0.0],
        [0.0, math.cos(inclination), math.sin(inclination)],
        [0.0, -math.sin(inclination), math.cos(inclination)],
    ])  # fmt: skip
    body = np.array([geometry.node[craft], geometry.transverse[craft], geometry.normal[craft]]).T @ orbit

    offset, dipole = body.T @ geometry.pressure_offset[craft], body.T @ geometry.residual_dipole[craft]
    sunlight = body.T @ geometry.sunlight[craft]
    gradient = 3.0 * rate**2 * np.cross(position, body.T @ inertia @ body @ position)
    earth = np.array([0.0, 0.0, -7.71e15])  # the dipole of the Earth points south
    field = (3.0 * (earth @ position) * position - earth) / radius**3
    pull = -0.5 * geometry.density[craft] * torque.drag_coefficient * geometry.drag_area[craft]
    drag = np.cross(offset, pull * np.linalg.norm(velocity) * velocity)
    push = 4.56e-6 * (1.0 + torque.reflectivity) * geometry.solar_area[craft]
    return body @ (gradient + np.cross(dipole, field) + drag + np.cross(offset, push * sunlight))


@pytest.mark.parametrize("torque", [TORQUE, GRADIENT, MAGNETIC, DRAG, SUNLIGHT, LowOrbitTorque(inclination=1.7)])
def test_records_are_the_models_over_a_whole_orbit(torque):
    uniform, inertia = deviates(20), inertias(20)
    steady, harmonics = torque.draw(uniform, inertia)
    drawn, geometry = history(steady, harmonics), torque.geometry(uniform)
    for craft in range(20):
        time = ORBIT / harmonics["frequency"][craft, 0]
        expected = np.array([reference(torque, geometry, craft, inertia[craft], now) for now in time])
        np.testing.assert_allclose(drawn[craft], expected, rtol=0.0, atol=1e-12 * size(expected).max())


def test_records_are_those_of_a_disturbance():
    steady, harmonics = TORQUE.draw(deviates(7), inertias(7))
    assert steady.shape == (7,) and harmonics.shape == (7, 2)
    assert np.all(steady["rate_scaled"] == 0.0) and np.all(steady["rate_offset"] == 0.0)
    rate = np.sqrt(GRAVITATIONAL_PARAMETER / (EARTH_RADIUS + TORQUE.geometry(deviates(7)).altitude) ** 3)
    np.testing.assert_allclose(harmonics["frequency"], rate[:, None] * [1.0, 2.0], rtol=1e-14)
    period = 2.0 * math.pi / rate / 60.0
    assert np.all((period > 92.0) & (period < 97.0))  # minutes, 400-600 km


# ----------------------------------------------------------------------------------------------------- closed forms


@settings(max_examples=60, deadline=None, derandomize=True)
@given(st.integers(0, 10_000))
def test_gravity_gradient_never_exceeds_its_bound(seed):
    uniform, inertia = deviates(10, seed), inertias(10, seed)
    steady, harmonics = GRADIENT.draw(uniform, inertia)
    moments = np.linalg.eigvalsh(inertia)
    bound = 1.5 * harmonics["frequency"][:, 0] ** 2 * (moments[:, 2] - moments[:, 0])
    assert np.all(size(history(steady, harmonics)) <= bound[:, None] * (1.0 + 1e-9))
    assert np.all(harmonics["sine"][:, 0] == 0.0) and np.all(harmonics["cosine"][:, 0] == 0.0)


def test_gravity_gradient_attains_its_bound():
    uniform = deviates(20)
    geometry = GRADIENT.geometry(uniform)
    # The orbit lies in the plane of the least and the largest principal axis.
    axes = np.stack([geometry.node, geometry.normal, geometry.transverse], axis=2)
    inertia = axes @ np.diag([12.0, 20.0, 24.0]) @ np.swapaxes(axes, 1, 2)
    steady, harmonics = GRADIENT.draw(uniform, inertia)
    bound = 1.5 * geometry.orbital_rate**2 * 12.0
    np.testing.assert_allclose(steady["constant"], 0.0, atol=1e-9 * bound.max())
    amplitude = np.sqrt(size(harmonics["sine"][:, 1]) ** 2 + size(harmonics["cosine"][:, 1]) ** 2)
    np.testing.assert_allclose(amplitude, bound, rtol=1e-12)
    direction = history(steady, harmonics) / bound[:, None, None]
    np.testing.assert_allclose(np.abs(np.einsum("nti,ni->nt", direction, geometry.normal)), size(direction), atol=1e-9)


def test_gravity_does_not_turn_a_sphere():
    steady, harmonics = GRADIENT.draw(deviates(20), same(20.0 * SPHERE, 20))
    np.testing.assert_allclose(history(steady, harmonics), 0.0, atol=1e-19)


def test_field_on_the_equator_is_that_of_the_geomagnetic_reference():
    # IGRF-13, 2020: g10, g11, h11 [nT] at the reference radius of 6371.2 km.
    expected = math.sqrt(29404.8**2 + 1450.9**2 + 4652.5**2) * 1e-9
    strength = MAGNETIC_MOMENT / 6371.2e3**3
    assert strength == pytest.approx(expected, rel=1e-3)


def test_equatorial_orbit_feels_a_constant_field_along_its_normal():
    torque = dataclasses.replace(MAGNETIC, inclination=0.0, residual_dipole=0.7)
    geometry = torque.geometry(deviates(20))
    steady, harmonics = torque.draw(deviates(20), same(SPHERE, 20))
    field = (MAGNETIC_MOMENT / geometry.radius**3)[:, None] * geometry.normal
    np.testing.assert_allclose(steady["constant"], np.cross(geometry.residual_dipole, field), rtol=0.0, atol=1e-19)
    np.testing.assert_allclose(size(geometry.residual_dipole), 0.7, rtol=1e-14)
    for part in ("sine", "cosine"):
        np.testing.assert_allclose(harmonics[part], 0.0, atol=1e-19)


def test_polar_orbit_feels_twice_the_equatorial_field_over_the_poles():
    torque = dataclasses.replace(MAGNETIC, inclination=0.5 * math.pi)
    uniform = deviates(20)
    field = (MAGNETIC_MOMENT / torque.geometry(uniform).radius ** 3)[:, None]
    # North at the node, down at the north pole, where north is the transverse axis and down its opposite.
    for start, factor in ((0.0, 1.0), (0.25, -2.0), (0.5, 1.0), (0.75, -2.0)):
        uniform[:, 5] = start
        geometry = torque.geometry(uniform)
        expected = np.cross(geometry.residual_dipole, factor * field * geometry.transverse)
        now = history(*torque.draw(uniform, same(SPHERE, 20)))[:, 0]
        np.testing.assert_allclose(now, expected, rtol=0.0, atol=1e-18)


def test_drag_turns_the_craft_at_the_orbital_rate_only():
    steady, harmonics = DRAG.draw(deviates(20), same(SPHERE, 20))
    np.testing.assert_allclose(steady["constant"], 0.0, atol=1e-19)
    np.testing.assert_allclose(harmonics["sine"][:, 1], 0.0, atol=1e-19)
    np.testing.assert_allclose(harmonics["cosine"][:, 1], 0.0, atol=1e-19)
    torques, half = history(steady, harmonics), len(ORBIT) // 2
    # The flow comes from the other side half an orbit later.
    np.testing.assert_allclose(torques[:, half], -torques[:, 0], rtol=0.0, atol=1e-18)


def test_sunlight_is_constant_and_grows_with_the_reflectivity():
    uniform = deviates(20)
    black = dataclasses.replace(SUNLIGHT, reflectivity=0.0).draw(uniform, same(SPHERE, 20))
    mirror = dataclasses.replace(SUNLIGHT, reflectivity=1.0).draw(uniform, same(SPHERE, 20))
    for _, harmonics in (black, mirror):
        assert np.abs(harmonics["sine"]).max() < 1e-19 and np.abs(harmonics["cosine"]).max() < 1e-19
    np.testing.assert_allclose(mirror[0]["constant"], 2.0 * black[0]["constant"], rtol=0.0, atol=1e-19)


# ------------------------------------------------------------------------------------------------------- atmosphere


def test_density_is_that_of_the_table_and_falls_without_a_step():
    for altitude, density in ((200e3, 2.789e-10), (400e3, 3.725e-12), (500e3, 6.967e-13), (1000e3, 3.019e-15)):
        assert atmospheric_density(np.array([altitude]))[0] == pytest.approx(density, rel=1e-14)
    middle = 3.725e-12 * math.exp(-30.0 / 58.515)
    assert atmospheric_density(np.array([430e3]))[0] == pytest.approx(middle, rel=1e-12)
    assert np.all(np.diff(atmospheric_density(np.linspace(200e3, 1000e3, 20_001))) < 0.0)
    seams = ATMOSPHERE[1:, 0]
    np.testing.assert_allclose(atmospheric_density(seams - 1e-3), atmospheric_density(seams), rtol=2e-3)


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
