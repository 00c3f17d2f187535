"""Tests of `task.pointing`: the torque of a low orbit holds near one attitude, and is refused elsewhere."""

import json
import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from ftac_gym import scenarios
from ftac_gym.task import (
    Disturbance,
    LowOrbitTorque,
    MRPSinusoid,
    RateProfile,
    SampledReference,
    Scenario,
    SetPoints,
)
from ftac_gym.task.orbit import orbital_rate

FLAGSHIP = scenarios.get("flagship").replace(faults=None)
LOW = LowOrbitTorque(altitude=500e3)
RATE = orbital_rate(500e3)
TURNING = LowOrbitTorque(altitude=500e3, nadir=(0.0, 0.0, 1.0), orbit_normal=(0.0, -1.0, 0.0))
STILL = ((0.0,) * 3, (0.0,) * 3)
NADIR = RateProfile(*STILL, constant=(0.0, -RATE, 0.0))


def sampled(rate, times):
    """A trajectory that turns about -y at a rate [rad/s]."""
    turns = Rotation.from_rotvec(np.outer(times, [0.0, -rate, 0.0]))
    return SampledReference.from_arrays(times, turns.as_quat(scalar_first=True))


def test_orbital_rate_is_that_of_the_known_period():
    # 500 km: 94.6 minutes.
    assert 2.0 * math.pi / RATE / 60.0 == pytest.approx(94.6, abs=0.05)


def test_set_points_are_inertial():
    turned = (math.cos(0.6), math.sin(0.6), 0.0, 0.0)
    FLAGSHIP.replace(disturbance=LOW, reference=SetPoints(((1.0, 0.0, 0.0, 0.0), turned), (0.0, 60.0)))


def test_small_motions_about_an_inertial_attitude_are_taken():
    # At most 4 * 0.04 rad = 9.2 deg for the first; 0.02 deg/s * 120 s = 2.4 deg for the second.
    FLAGSHIP.replace(disturbance=LOW, reference=MRPSinusoid((0.04, 0.0, 0.0), (0.05,) * 3))
    FLAGSHIP.replace(disturbance=LOW, reference=RateProfile((math.radians(0.02), 0.0, 0.0), (0.1,) * 3))
    # The orbit's own turning is 7.6 deg in two minutes.
    FLAGSHIP.replace(disturbance=LOW, reference=NADIR)
    FLAGSHIP.replace(disturbance=LOW, reference=sampled(RATE, np.linspace(0.0, 120.0, 13)))


@pytest.mark.parametrize("duration", [120.0, 5700.0])
def test_a_reference_that_turns_with_the_orbit_takes_the_torque_that_does(duration):
    for reference in (NADIR, sampled(RATE, np.linspace(0.0, duration, 100))):
        scenario = FLAGSHIP.replace(disturbance=TURNING, reference=reference, duration=duration)
        episodes = scenario.draw(0, 5)
        assert episodes.harmonics.shape == (5, 1)
        np.testing.assert_allclose(episodes.harmonics["frequency"], RATE, rtol=1e-12)


def test_the_torque_that_turns_survives_json_and_leaves_other_text_as_it_was():
    scenario = FLAGSHIP.replace(disturbance=TURNING, reference=NADIR)
    again = Scenario.from_dict(json.loads(scenario.to_json()))
    assert again == scenario and again.draw(1, 3).digest() == scenario.draw(1, 3).digest()
    assert "nadir" not in FLAGSHIP.replace(disturbance=LOW).to_json()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"disturbance": LOW, "reference": MRPSinusoid((0.05, 0.0, 0.0), (0.05,) * 3)},
            "reference must stay within 10",
        ),
        ({"disturbance": (Disturbance(), LOW), "reference": MRPSinusoid((0.1,) * 3, (0.1,) * 3)}, r"disturbance\[1\]"),
        ({"disturbance": LOW, "reference": NADIR, "duration": 300.0}, "it turns by, got 19.0"),
        (
            {"disturbance": LOW, "reference": sampled(RATE, np.linspace(0.0, 300.0, 31)), "duration": 300.0},
            "it turns by, got 19.0",
        ),
        (
            {"disturbance": TURNING},
            "reference must be a RateProfile or SampledReference at the orbital rate, .*SetPoints",
        ),
        (
            {"disturbance": TURNING, "reference": RateProfile(*STILL, constant=(0.0, RATE, 0.0)), "duration": 300.0},
            r"reference must turn at the orbital rate about disturbance\.orbit_normal",
        ),
        (
            {
                "disturbance": TURNING,
                "reference": RateProfile(*STILL, constant=(0.0, -2.0 * RATE, 0.0)),
                "duration": 300.0,
            },
            "off by, got 19.0",
        ),
    ],
)
def test_other_references_are_refused(changes, message):
    with pytest.raises(ValueError, match=message):
        FLAGSHIP.replace(**changes)


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"nadir": (0.0, 0.0, 1.0)}, "orbit_normal must come with nadir"),
        ({"orbit_normal": (0.0, 0.0, 1.0)}, "orbit_normal must come with nadir"),
        ({"nadir": (0.0, 0.0, 1.0), "orbit_normal": (0.0, 0.6, 0.8)}, "orbit_normal must be perpendicular to nadir"),
        ({"nadir": (0.0, 0.0, 2.0), "orbit_normal": (0.0, 1.0, 0.0)}, "nadir must be a unit vector"),
        ({"nadir": (0.0, 1.0), "orbit_normal": (0.0, 1.0, 0.0)}, "nadir must"),
    ],
)
def test_rules(fields, message):
    with pytest.raises(ValueError, match=message):
        LowOrbitTorque(**fields)
