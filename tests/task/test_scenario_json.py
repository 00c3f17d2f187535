"""Scenarios as JSON: every class survives, other data is refused."""

import json

import numpy as np
import pytest

from ftac_gym import faults, scenarios
from ftac_gym.spacecraft import Friction, Spacecraft, WheelArray
from ftac_gym.task import (
    Disturbance,
    Gyro,
    Harmonic,
    InertiaUncertainty,
    InitialState,
    LowOrbitTorque,
    ModalTelemetry,
    MRPSinusoid,
    RateProfile,
    RewardWeights,
    SampledReference,
    Scenario,
    SensorErrors,
    SensorSuite,
    SetPoints,
    StarTracker,
    SuccessCriterion,
    WheelTelemetry,
)

FLAGSHIP = scenarios.get("flagship")
AXES = ((0.1, 0.2), -0.3, (0.0, 0.5))
TIMING = {"onset": (1.0, 2.0), "recovery": (3.0, 4.0), "period": 0.5, "on_time": (0.1, 0.2)}
SHAPE = {"onset": (1.0, 2.0), "duration": (3.0, 4.0), "rise": (0.1, 0.2), "fall": (0.3, 0.4)}
CHAIN = {"onset": (1.0, 2.0), "mean_acting": 2.0, "mean_resting": 7.0}
FRICTIONS = (Friction(0.01, 0.02, 0.3, 1e-4), None, Friction(0.03), Friction(0.04, viscous=1e-5))
REAL = WheelArray(np.eye(3), 1, 2, False, (0.1, 0.2, 0.3), (4, 5, 6), FRICTIONS[:3], 0.03, (0.01, 0.02, 0.03), 60)
RUBBING = WheelArray(FLAGSHIP.spacecraft.wheels.axes, 0.2, 12.0, spin_inertia=0.02, friction=FRICTIONS)
PARTS = [  # every class with no field at its default
    {"spacecraft": Spacecraft(np.diag([1.0, 1.0, 9.0]), WheelArray(np.eye(3), (1, 2, 3), 4, False), True)},
    {"spacecraft": Spacecraft(np.diag([1.0, 1.0, 1.0]), REAL)},
    {"initial_state": InitialState((0.6, 0.8, 0.0, 0.0), (0.1, 0.2), (0.1, 0.2, 0.3), 0.4, 0.0, (1.0, 2.0, 3.0, 4.0))},
    {"initial_state": InitialState(angle=1.0, max_rate=0.1, wheel_momentum=(-1.0, 1.0))},
    {"reference": SetPoints(((1.0, 0.0, 0.0, 0.0), (0.0, 0.6, 0.8, 0.0)), (0.0, 5.0))},
    {"reference": MRPSinusoid(AXES, AXES, AXES, AXES)},
    {"reference": RateProfile(AXES, AXES, AXES, AXES, (0.0, 0.0, 0.6, 0.8))},
    {"reference": SampledReference((0.0, 200.0), ((1.0, 0.0, 0.0, 0.0), (0.8, 0.6, 0.0, 0.0)))},
    {
        "faults": faults.FaultDistribution(
            (faults.Outage(**TIMING), faults.HardOver(fraction=(-0.5, 0.5))), (0.3, 0.7), (0.1, 0.6, 0.3)
        )
    },
    {
        "faults": faults.FaultSchedule(
            (faults.LossOfEffectiveness(wheel=1, effectiveness=0.5, amplitude=0.1, frequency=2, phase=3),)
        )
    },
    {
        "faults": faults.FaultSchedule(
            (faults.Bias(wheel=0, constant=1, slope=2, amplitude=3, exponent=1.5, frequency=5, phase=6),)
        )
    },
    {
        "faults": faults.FaultSchedule(
            (faults.LockInPlace(wheel=2, **TIMING), faults.HardOver(wheel=3, random_sign=False))
        )
    },
    {
        "faults": faults.FaultDistribution(
            (faults.Outage(**CHAIN), faults.Bias(**SHAPE)), (0.3, 0.7), (0.1, 0.6, 0.3), severity=0.4
        )
    },
    {
        "faults": faults.FaultDistribution(
            (faults.GyroBiasStep(size=(0.1, 0.2), **SHAPE), faults.StarTrackerOutage(**TIMING))
        )
    },
    {
        "faults": faults.FaultSchedule(
            (faults.AttitudeSpike(angle=(0.1, 3.0), **CHAIN), faults.CommandDelay(wheel=1, periods=(2, 4), onset=3))
        )
    },
    {
        "faults": faults.FaultSchedule(
            (faults.Seizure(wheel=0, brake=(1.1, 9.0), **CHAIN), faults.IntermittentShutdown(wheel=1, **CHAIN))
        )
    },
    {
        "spacecraft": Spacecraft(np.diag([1.0, 1.0, 1.0]), RUBBING),
        "faults": faults.FaultSchedule(
            (
                faults.FrictionRise(wheel=0, factor=(3, 4), direction="either", **SHAPE),
                faults.DriftingEffectiveness(
                    wheel=0, effectiveness=(0.1, 0.3), onset=1.0, duration=8.0, rise=3.0, fall=2.0
                ),
            )
        ),
    },
    {"disturbance": LowOrbitTorque(500e3, (0.1, 0.2), 1, 2, (3, 4), 0.5, 0.06, (0.7, 0.8), 0.9)},
    {"disturbance": Disturbance(AXES, (Harmonic(AXES, (0.1, 0.2), AXES), Harmonic(AXES, 0.3)), rate_offset=0.1)},
    {"sensors": SensorErrors(1e-4, 1e-5, (-1e-6, 1e-6), 1e-8, (0.001, 0.002))},
    {
        "sensors": SensorSuite(
            star_tracker=StarTracker(latency=(0.1, 0.2), cross_noise=6.0, boresight=(0.6, 0.0, 0.8)),
            gyro=Gyro(angle_random_walk=(0.01, 0.02), bias=(-1.0, 1.0), misalignment=0.1),
            wheels=WheelTelemetry(noise=1e-3, quantum=1e-3),
            modes=ModalTelemetry(rate_noise=1e-4),
        )
    },
    {"sensors": SensorSuite()},
    {"inertia_uncertainty": InertiaUncertainty(0.1, np.eye(3), (1, 2, 3), (4, 5, 6), (7, 8, 9), True)},
    {
        "reward": RewardWeights(1, 0.1, 0.2, 0.3, 0.4, 6, 7, 8, 9, 0.5),
        "success": SuccessCriterion(0.1, 0.2, 0.3, 0.5, None),
        "tumble_rate": 2,
    },
    {"control_period": 0.2, "physics_step": 0.05, "duration": 10, "name": "Prüfung"},
    {"faults": None, "disturbance": None, "sensors": None, "inertia_uncertainty": None, "tumble_rate": None},
]


def unit_vectors(count, length, seed=0):
    vectors = np.random.default_rng(seed).normal(size=(count, length))
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


@pytest.mark.parametrize("name", scenarios.names())
def test_library_scenarios_survive_json(name):
    scenario = scenarios.get(name)
    assert scenario.name == name
    again = Scenario.from_json(scenario.to_json())
    assert again == scenario and again.to_json() == scenario.to_json()
    assert again.draw(1, 3).digest() == scenario.draw(1, 3).digest()


@pytest.mark.parametrize("changes", PARTS)
def test_every_class_survives_json(changes):
    scenario = FLAGSHIP.replace(**{"faults": None, "initial_state": InitialState(), **changes})
    again = Scenario.from_dict(json.loads(scenario.to_json()))
    assert again == scenario and again.to_json() == scenario.to_json()


@pytest.mark.parametrize("source", ["distribution", "schedule"])
def test_every_fault_kind_survives_json(source):
    wheels = WheelArray(FLAGSHIP.spacecraft.wheels.axes, 0.2, 12.0, spin_inertia=0.02, friction=Friction(0.01))
    placed = [
        {"wheel": index % 4} if issubclass(kind, faults.WheelFault) else {} for index, kind in enumerate(faults.KINDS)
    ]
    listed = (
        faults.FaultDistribution(
            tuple(kind(onset=(1.0, 9.0)) for kind in faults.KINDS), fault_counts=(0.0, 0.0, 1.0), severity=0.7
        )
        if source == "distribution"
        else faults.FaultSchedule(
            tuple(kind(onset=2.0, **where) for kind, where in zip(faults.KINDS, placed, strict=True))
        )
    )
    spacecraft = Spacecraft(FLAGSHIP.spacecraft.inertia, wheels)
    scenario = FLAGSHIP.replace(spacecraft=spacecraft, faults=listed, disturbance=LowOrbitTorque())
    again = Scenario.from_dict(json.loads(scenario.to_json()))
    assert again == scenario and again.to_json() == scenario.to_json()
    assert again.draw(2, 30).digest() == scenario.draw(2, 30).digest()


def test_rounding_does_not_change_a_scenario_in_json():
    for quaternion in unit_vectors(200, 4):
        scenario = FLAGSHIP.replace(
            initial_state=InitialState.fixed(attitude=quaternion), reference=SetPoints((tuple(quaternion),), (0.0,))
        )
        assert Scenario.from_json(scenario.to_json()) == scenario
    for weights in np.random.default_rng(0).random((200, 2)):
        scenario = FLAGSHIP.replace(
            faults=faults.FaultDistribution((faults.Outage(), faults.Bias()), weights=tuple(weights))
        )
        assert Scenario.from_json(scenario.to_json()) == scenario


def test_numpy_numbers_survive_json():
    listed = faults.FaultSchedule((faults.Outage(wheel=np.int64(1), onset=np.float64(2.0)),))
    scenario = FLAGSHIP.replace(faults=listed, duration=np.float64(60.0))
    assert Scenario.from_json(scenario.to_json()) == scenario


@pytest.mark.parametrize(
    ("data", "message"),
    [
        ({"type": "Craft"}, "type must be one of"),
        ({"name": "x"}, "type must be one of"),
        ({"type": "Outage", "wheel": 1}, "scenario must describe a Scenario"),
        ([1, 2], "scenario must describe a Scenario"),
        ({**FLAGSHIP.to_dict(), "color": "red"}, "Scenario has no field 'color'"),
        ({**FLAGSHIP.to_dict(), "sensors": {"type": "SensorErrors", "drift": 1}}, "SensorErrors has no field 'drift'"),
        ({**FLAGSHIP.to_dict(), "sensors": {"type": "Nothing"}}, "type must be one of"),
        ({"type": "Scenario", "name": "x"}, "spacecraft"),
        ({**FLAGSHIP.to_dict(), "disturbance": {"type": "Disturbance", "harmonics": [{"type": "Harmonic"}]}}, "Harm"),
    ],
)
def test_other_data_is_refused(data, message):
    with pytest.raises(ValueError, match=message):
        Scenario.from_json(json.dumps(data))


def test_text_that_is_no_json_is_refused():
    with pytest.raises(ValueError):
        Scenario.from_json("no scenario")
