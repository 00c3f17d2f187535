"""Tests of `ftac_gym.task.scenario` and the scenario library: JSON, changes, rules, and what an episode depends on."""

import json
import math

import numpy as np
import pytest

from ftac_gym import scenarios
from ftac_gym.faults import (
    KINDS,
    AttitudeSpike,
    Bias,
    CommandDelay,
    DriftingEffectiveness,
    FaultDistribution,
    FaultSchedule,
    FrictionRise,
    GyroBiasStep,
    HardOver,
    IntermittentShutdown,
    LockInPlace,
    LossOfEffectiveness,
    Outage,
    Seizure,
    StarTrackerOutage,
    WheelFault,
)
from ftac_gym.spacecraft import Friction, Spacecraft, WheelArray
from ftac_gym.task import (
    Disturbance,
    Harmonic,
    InertiaUncertainty,
    InitialState,
    LowOrbitTorque,
    MRPSinusoid,
    RateProfile,
    RewardWeights,
    Scenario,
    SensorErrors,
    SetPoints,
    SuccessCriterion,
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
    {"faults": FaultDistribution((Outage(**TIMING), HardOver(fraction=(-0.5, 0.5))), (0.3, 0.7), (0.1, 0.6, 0.3))},
    {"faults": FaultSchedule((LossOfEffectiveness(wheel=1, effectiveness=0.5, amplitude=0.1, frequency=2, phase=3),))},
    {"faults": FaultSchedule((Bias(wheel=0, constant=1, slope=2, amplitude=3, exponent=4, frequency=5, phase=6),))},
    {"faults": FaultSchedule((LockInPlace(wheel=2, **TIMING), HardOver(wheel=3, random_sign=False)))},
    {"faults": FaultDistribution((Outage(**CHAIN), Bias(**SHAPE)), (0.3, 0.7), (0.1, 0.6, 0.3), severity=0.4)},
    {"faults": FaultDistribution((GyroBiasStep(size=(0.1, 0.2), **SHAPE), StarTrackerOutage(**TIMING)))},
    {
        "faults": FaultSchedule(
            (AttitudeSpike(angle=(0.1, 3.0), **CHAIN), CommandDelay(wheel=1, periods=(2, 4), onset=3))
        )
    },
    {"faults": FaultSchedule((Seizure(wheel=0, brake=(1.1, 9.0), **CHAIN), IntermittentShutdown(wheel=1, **CHAIN)))},
    {
        "spacecraft": Spacecraft(np.diag([1.0, 1.0, 1.0]), RUBBING),
        "faults": FaultSchedule(
            (
                FrictionRise(wheel=0, factor=(3, 4), direction="either", **SHAPE),
                DriftingEffectiveness(wheel=0, effectiveness=(0.1, 0.3), onset=1.0, duration=8.0, rise=3.0, fall=2.0),
            )
        ),
    },
    {"disturbance": LowOrbitTorque(500e3, (0.1, 0.2), 1, 2, (3, 4), 0.5, 0.06, (0.7, 0.8), 0.9)},
    {"disturbance": Disturbance(AXES, (Harmonic(AXES, (0.1, 0.2), AXES), Harmonic(AXES, 0.3)), rate_offset=0.1)},
    {"sensors": SensorErrors(1e-4, 1e-5, (-1e-6, 1e-6), 1e-8, (0.001, 0.002))},
    {"inertia_uncertainty": InertiaUncertainty(0.1, np.eye(3), (1, 2, 3), (4, 5, 6), (7, 8, 9), True)},
    {"reward": RewardWeights(1, 2, 3, 4, 5, 6, 7), "success": SuccessCriterion(0.1, 0.2, 0.3), "tumble_rate": 2},
    {"control_period": 0.2, "physics_step": 0.05, "duration": 10, "name": "Prüfung"},
    {"faults": None, "disturbance": None, "sensors": None, "inertia_uncertainty": None, "tumble_rate": None},
]


def unit_vectors(count, length, seed=0):
    vectors = np.random.default_rng(seed).normal(size=(count, length))
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


# ------------------------------------------------------------------------------------------------------------- JSON


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
    placed = [{"wheel": index % 4} if issubclass(kind, WheelFault) else {} for index, kind in enumerate(KINDS)]
    faults = (
        FaultDistribution(tuple(kind(onset=(1.0, 9.0)) for kind in KINDS), fault_counts=(0.0, 0.0, 1.0), severity=0.7)
        if source == "distribution"
        else FaultSchedule(tuple(kind(onset=2.0, **where) for kind, where in zip(KINDS, placed, strict=True)))
    )
    spacecraft = Spacecraft(FLAGSHIP.spacecraft.inertia, wheels)
    scenario = FLAGSHIP.replace(spacecraft=spacecraft, faults=faults, disturbance=LowOrbitTorque())
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
        scenario = FLAGSHIP.replace(faults=FaultDistribution((Outage(), Bias()), weights=tuple(weights)))
        assert Scenario.from_json(scenario.to_json()) == scenario


def test_numpy_numbers_survive_json():
    faults = FaultSchedule((Outage(wheel=np.int64(1), onset=np.float64(2.0)),))
    scenario = FLAGSHIP.replace(faults=faults, duration=np.float64(60.0))
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


# ---------------------------------------------------------------------------------------------------------- changes


def test_replace_changes_a_copy():
    shorter = FLAGSHIP.replace(duration=60.0, faults=None)
    assert (shorter.duration, shorter.faults) == (60.0, None)
    assert FLAGSHIP.duration == 120.0 and FLAGSHIP.faults is not None
    assert shorter.replace(duration=120.0, faults=FLAGSHIP.faults) == FLAGSHIP


def test_replace_takes_plain_data():
    changes = {"faults": {"type": "FaultSchedule", "faults": [{"type": "Outage", "wheel": 1}]}}
    assert FLAGSHIP.replace(**changes).faults == FaultSchedule((Outage(wheel=1),))


@pytest.mark.parametrize("part", ["faults", "disturbance", "sensors", "inertia_uncertainty"])
def test_none_switches_a_part_off(part):
    episodes = FLAGSHIP.replace(**{part: None}).draw(0, 50)
    if part == "faults":
        assert np.all(episodes.faults["kind"] == 0)
    elif part == "disturbance":
        assert np.all(episodes.disturbance["constant"] == 0.0) and episodes.harmonics.size == 0
    elif part == "sensors":
        assert np.all(episodes.sensors == np.zeros(1, episodes.sensors.dtype))
    else:
        assert np.all(episodes.inertia["constant"] == FLAGSHIP.spacecraft.inertia_matrix)


def test_timing_in_steps():
    scenario = FLAGSHIP.replace(control_period=0.3, physics_step=0.1, duration=6.0)
    assert scenario.substeps == 3 and scenario.horizon == 20


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"colour": "red"}, "scenario change must be one of .* got 'colour'"),
        ({"name": 5}, "name must be a str"),
        ({"spacecraft": None}, "spacecraft must be a Spacecraft"),
        ({"initial_state": None}, "initial_state must be a InitialState"),
        ({"reference": Outage(wheel=0)}, "reference must be a SetPoints or MRPSinusoid or RateProfile"),
        ({"faults": Outage(wheel=0)}, "faults must be a FaultDistribution or FaultSchedule or None"),
        ({"disturbance": 0.1}, "disturbance must be a Disturbance or LowOrbitTorque or None"),
        ({"sensors": {"type": "Harmonic", "amplitude": [0, 0, 0], "frequency": 1}}, "sensors must be a SensorErrors"),
        ({"inertia_uncertainty": 0.1}, "inertia_uncertainty must be a InertiaUncertainty or None"),
        ({"reward": {"type": "Craft"}}, "type must be one of"),
        ({"reward": None}, "reward must be a RewardWeights"),
        ({"success": None}, "success must be a SuccessCriterion"),
        ({"control_period": 0.0}, "control_period must be positive"),
        ({"control_period": math.nan}, "control_period must be finite"),
        ({"control_period": 0.11}, "control_period must be a multiple of physics_step"),
        ({"control_period": 0.01}, "control_period must be a multiple of physics_step"),
        ({"physics_step": -0.02}, "physics_step must be positive"),
        ({"physics_step": "fast"}, "physics_step must be a number"),
        ({"physics_step": 0.03}, "control_period must be a multiple of physics_step"),
        ({"duration": math.inf}, "duration must be finite"),
        ({"duration": 60.05}, "duration must be a multiple of control_period"),
        ({"tumble_rate": 0.0}, "tumble_rate must be positive"),
        ({"faults": FaultSchedule((Outage(wheel=4),))}, "wheel must be below the number of wheels, 4"),
        (
            {"faults": FaultDistribution((Outage(),), fault_counts=(0.0,) * 5 + (1.0,))},
            "fault_counts must not exceed the 4 wheels",
        ),
        (
            {"faults": FaultSchedule((Outage(wheel=0, mean_acting=2.0, mean_resting=5.4),))},
            r"mean_acting with mean_resting must add up to at least 7.5 s for this duration, got 2\.0",
        ),
        (
            {"faults": FaultDistribution((AttitudeSpike(mean_acting=1.0, mean_resting=1.0),))},
            "mean_acting with mean_re",
        ),
        ({"faults": FaultDistribution((Outage(), IntermittentShutdown())), "duration": 330.0}, "mean_acting with mean"),
        ({"faults": FaultSchedule((FrictionRise(wheel=0),))}, "friction must be given"),
        ({"faults": FaultDistribution((Outage(), FrictionRise()))}, "friction must be given"),
    ],
)
def test_rules(changes, message):
    with pytest.raises(ValueError, match=message):
        FLAGSHIP.replace(**changes)


@pytest.mark.parametrize("friction", [Friction(viscous=1e-4), (Friction(0.01), None, Friction(0.01), Friction(0.01))])
def test_friction_can_rise_only_where_it_is_dry(friction):
    axes = FLAGSHIP.spacecraft.wheels.axes
    rubbing = Spacecraft(FLAGSHIP.spacecraft.inertia, WheelArray(axes, 0.2, spin_inertia=0.02, friction=friction))
    for faults in (FaultDistribution((FrictionRise(),)), FaultSchedule((FrictionRise(wheel=1),))):
        with pytest.raises(ValueError, match="friction must be given, with a dry part, for the wheels"):
            FLAGSHIP.replace(spacecraft=rubbing, faults=faults)
    if isinstance(friction, tuple):
        FLAGSHIP.replace(spacecraft=rubbing, faults=FaultSchedule((FrictionRise(wheel=0),)))


def test_chains_at_the_edge_of_the_rule_are_accepted():
    FLAGSHIP.replace(faults=FaultSchedule((Outage(wheel=0, mean_acting=2.0, mean_resting=5.5),)))
    FLAGSHIP.replace(faults=FaultSchedule((Outage(wheel=0, mean_acting=1.0, mean_resting=1.0),)), duration=32.0)


@pytest.mark.parametrize(("kind", "rule"), [(RewardWeights, "must not be negative"), (SuccessCriterion, "positive")])
def test_rules_of_reward_and_success(kind, rule):
    for field in kind.__dataclass_fields__:
        with pytest.raises(ValueError, match=f"{field} .*{rule}"):
            kind(**{field: -1.0})
        with pytest.raises(ValueError, match=f"{field} must be finite"):
            kind(**{field: math.nan})


def test_unknown_scenario():
    with pytest.raises(ValueError, match=r"scenario must be one of \[.*'flagship'.*got 'flagchip'"):
        scenarios.get("flagchip")


# ---------------------------------------------------------------------------------------------------------- drawing


def test_first_episodes_do_not_depend_on_how_many_are_drawn():
    for name in scenarios.names():
        assert scenarios.get(name).draw(3, 5).digest() == scenarios.get(name).draw(3, 500)[:5].digest()


def test_episodes_and_seeds_differ_in_every_random_part():
    episodes, others = FLAGSHIP.draw(0, 200), FLAGSHIP.draw(1, 200)
    for part in ("initial", "inertia", "disturbance", "harmonics"):
        rows = {row.tobytes() for drawn in (episodes, others) for row in drawn.arrays()[part]}
        assert len(rows) == 400, part
    biases = np.concatenate([episodes.sensors["gyro_bias"], others.sensors["gyro_bias"]])
    assert len(np.unique(biases, axis=0)) == 400
    onsets = np.concatenate([episodes.faults["onset"], others.faults["onset"]])
    struck = onsets[np.isfinite(onsets)]
    assert len(struck) > 300 and len(np.unique(struck)) == len(struck)


def test_one_part_does_not_change_the_numbers_of_another():
    before, after = FLAGSHIP.draw(0, 5), FLAGSHIP.replace(faults=None, initial_state=InitialState()).draw(0, 5)
    for part in ("inertia", "disturbance", "harmonics", "sensors"):
        np.testing.assert_array_equal(before.arrays()[part], after.arrays()[part])


@pytest.mark.parametrize(
    ("seed", "count", "message"),
    [
        (-1, 5, "seed must be a non-negative integer"),
        (1.5, 5, "seed must be a non-negative integer"),
        (None, 5, "seed must be a non-negative integer"),
        (0, 0, "count must be a positive integer"),
        (0, -3, "count must be a positive integer"),
        (0, 2.0, "count must be a positive integer"),
    ],
)
def test_drawing_rules(seed, count, message):
    with pytest.raises(ValueError, match=message):
        FLAGSHIP.draw(seed, count)


def test_seed_may_be_large():
    assert FLAGSHIP.draw(2**100, 1).digest() != FLAGSHIP.draw(2**100 + 1, 1).digest()
