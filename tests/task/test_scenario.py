"""Scenarios: changes, rules, and the independence of episodes."""

import math

import numpy as np
import pytest

from ftac_gym import scenarios
from ftac_gym.faults import (
    AttitudeSpike,
    FaultDistribution,
    FaultSchedule,
    FrictionRise,
    IntermittentShutdown,
    Outage,
)
from ftac_gym.spacecraft import Friction, Spacecraft, WheelArray
from ftac_gym.task import (
    InitialState,
    RewardWeights,
    SuccessCriterion,
)

FLAGSHIP = scenarios.get("flagship")


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
    scenario = FLAGSHIP.replace(control_period=0.3, physics_step=0.1, duration=6.0, loop_delay=0.3, sensors=None)
    assert scenario.substeps == 3 and scenario.horizon == 20 and scenario.delay_steps == 3


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"name": 5}, "name must be a str"),
        ({"spacecraft": None}, "spacecraft must be a Spacecraft"),
        ({"initial_state": None}, "initial_state must be a InitialState"),
        ({"reference": Outage(wheel=0)}, "reference must be a SetPoints or MRPSinusoid or RateProfile"),
        ({"faults": 3}, "faults must be a FaultDistribution or FaultSchedule or None"),
        (
            {"initial_state": InitialState(wheel_momentum=13.0)},
            r"initial_state.wheel_momentum must stay within the lim",
        ),
        (
            {"initial_state": InitialState(fixed_wheel_momentum=(0.0,) * 3)},
            "initial_state.fixed_wheel_momentum must have 4",
        ),
        ({"disturbance": 0.1}, "disturbance must be a Disturbance or LowOrbitTorque or None"),
        (
            {"sensors": {"type": "Harmonic", "amplitude": [0, 0, 0], "frequency": 1}},
            "sensors must describe a SensorErrors or SensorSuite",
        ),
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


@pytest.mark.parametrize(
    ("kind", "rule"), [(RewardWeights, "must (not be negative|be positive)"), (SuccessCriterion, "positive")]
)
def test_rules_of_reward_and_success(kind, rule):
    for field in kind.__dataclass_fields__:
        with pytest.raises(ValueError, match=f"{field} .*{rule}"):
            kind(**{field: -1.0})
        with pytest.raises(ValueError, match=f"{field} must be finite"):
            kind(**{field: math.nan})


@pytest.mark.parametrize(("field", "value"), [("share", 1.01), ("share", 0.0), ("limit", 0.99), ("limit", math.inf)])
def test_the_share_of_success_is_at_most_one_and_its_limit_at_least_the_cone(field, value):
    with pytest.raises(ValueError, match=f"^{field} must"):
        SuccessCriterion(**{field: value})


def test_old_json_of_success_means_the_rule_of_today_and_the_old_rule_can_be_written():
    assert set(FLAGSHIP.to_dict()["success"]) == {"type", "angle", "rate", "hold"}
    strict = SuccessCriterion(share=1.0, limit=None)
    assert {"share": 1.0, "limit": None}.items() <= FLAGSHIP.replace(success=strict).to_dict()["success"].items()


def test_an_unknown_field_is_a_type_error_in_a_call_and_a_value_error_in_data():
    with pytest.raises(
        TypeError, match=r"Scenario\.replace\(\) got an unexpected keyword argument 'colour'; fields of"
    ):
        FLAGSHIP.replace(colour="red")
    with pytest.raises(ValueError, match="Scenario has no field 'colour'"):
        type(FLAGSHIP).from_dict({**FLAGSHIP.to_dict(), "colour": "red"})


def test_unknown_scenario():
    with pytest.raises(ValueError, match=r"scenario must be one of \[.*'flagship'.*got 'flagchip'"):
        scenarios.get("flagchip")


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
    finite = onsets[np.isfinite(onsets)]
    assert len(finite) > 300 and len(np.unique(finite)) == len(finite)


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
