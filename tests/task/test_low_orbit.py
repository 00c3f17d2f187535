"""Tests of `low_orbit`: the records against the models in inertial axes, closed forms, sizes and rules."""

import dataclasses
import math

import numpy as np
import pytest
from helpers.low_orbit import (
    DRAG,
    GRADIENT,
    MAGNETIC,
    ORBIT,
    SPHERE,
    SUNLIGHT,
    TORQUE,
    deviates,
    history,
    inertias,
    same,
    size,
)
from hypothesis import given, settings
from hypothesis import strategies as st

from ftac_gym.task import LowOrbitTorque
from ftac_gym.task.orbit import (
    EARTH_RADIUS,
    GRAVITATIONAL_PARAMETER,
    MAGNETIC_MOMENT,
)

# ----------------------------------------------------------------------------------------------------------- models


def reference(torque, geometry, craft, inertia, time):
    """Torque (3,) on one spacecraft, body axes, from positions and fields in inertial axes with z the Earth's axis.

    The body is inertial, or turns with the orbit.
    """
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
    axes = np.array([geometry.node[craft], geometry.transverse[craft], geometry.normal[craft]]).T
    body = axes @ orbit
    sunlight = body.T @ geometry.sunlight[craft]
    if torque.turning:
        body = axes @ np.array([position, velocity / np.linalg.norm(velocity), orbit[2]])
    offset, dipole = body.T @ geometry.pressure_offset[craft], body.T @ geometry.residual_dipole[craft]
    gradient = 3.0 * rate**2 * np.cross(position, body.T @ inertia @ body @ position)
    earth = np.array([0.0, 0.0, -7.71e15])  # the dipole of the Earth points south
    field = (3.0 * (earth @ position) * position - earth) / radius**3
    pull = -0.5 * geometry.density[craft] * torque.drag_coefficient * geometry.drag_area[craft]
    drag = np.cross(offset, pull * np.linalg.norm(velocity) * velocity)
    push = 4.56e-6 * (1.0 + torque.reflectivity) * geometry.solar_area[craft]
    return body @ (gradient + np.cross(dipole, field) + drag + np.cross(offset, push * sunlight))


TURNING = {"nadir": (0.6, 0.0, 0.8), "orbit_normal": (0.0, -1.0, 0.0)}


@pytest.mark.parametrize(
    "torque",
    [
        *(TORQUE, GRADIENT, MAGNETIC, DRAG, SUNLIGHT, LowOrbitTorque(inclination=1.7)),
        *(dataclasses.replace(torque, **TURNING) for torque in (TORQUE, GRADIENT, MAGNETIC, DRAG, SUNLIGHT)),
    ],
)
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


def test_gravity_and_drag_are_constant_on_a_body_that_turns_with_the_orbit():
    for torque in (GRADIENT, DRAG):
        steady, harmonics = dataclasses.replace(torque, **TURNING).draw(deviates(20), inertias(20))
        assert harmonics.shape == (20, 1) and size(steady["constant"]).min() > 0.0
        assert np.all(harmonics["sine"] == 0.0) and np.all(harmonics["cosine"] == 0.0)


def test_gravity_gradient_of_a_nadir_pointing_body_by_hand():
    moments = np.diag([12.0, 20.0, 24.0])
    # A principal axis to the Earth: none. Half way between x and z: 3/2 n^2 (Jz - Jx) about y.
    for nadir, factor in (((0.0, 0.0, 1.0), 0.0), ((math.sqrt(0.5), 0.0, math.sqrt(0.5)), -18.0)):
        torque = dataclasses.replace(GRADIENT, altitude=500e3, nadir=nadir, orbit_normal=(0.0, -1.0, 0.0))
        steady, _ = torque.draw(deviates(1), moments[None])
        expected = factor * GRAVITATIONAL_PARAMETER / (EARTH_RADIUS + 500e3) ** 3
        np.testing.assert_allclose(steady["constant"][0], [0.0, expected, 0.0], rtol=1e-12, atol=1e-22)


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
