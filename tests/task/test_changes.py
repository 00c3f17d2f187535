"""Short forms of the changes of a scenario."""

import dataclasses
import json

import gymnasium as gym
import pytest
from gymnasium.envs.registration import EnvSpec

import ftac_gym  # noqa: F401  registers the environments
from ftac_gym import scenarios
from ftac_gym.faults import Bias, FaultSchedule, LockInPlace, Outage, StarTrackerOutage
from ftac_gym.faults.specification import parse_all
from ftac_gym.spacecraft import WheelArray
from ftac_gym.task import Gyro, InertiaUncertainty, LowOrbitTorque, RewardWeights, SensorErrors, SensorSuite
from ftac_gym.utils.serialization import to_plain

FLAGSHIP = scenarios.get("flagship")
OUTAGE = Outage(wheel=0, onset=5.0)
REWARD = dataclasses.replace(FLAGSHIP.reward, effort=0.0)


def test_a_dict_changes_the_fields_of_the_part_that_is_there():
    task = FLAGSHIP.replace(reward=REWARD)
    assert task.replace(reward={"on_target": 1.0}).reward == dataclasses.replace(REWARD, on_target=1.0)
    assert task.replace(reward={}).reward == REWARD
    # With a type it is a new part.
    assert task.replace(reward={"type": "RewardWeights", "on_target": 1.0}).reward == RewardWeights(on_target=1.0)
    faster = task.replace(success={"hold": 5.0}, faults={"severity": 0.5}, initial_state={"max_rate": (0.01, 0.02)})
    assert faster.success == dataclasses.replace(task.success, hold=5.0)
    assert faster.faults == dataclasses.replace(task.faults, severity=0.5)
    assert faster.initial_state == dataclasses.replace(task.initial_state, max_rate=(0.01, 0.02))


def test_a_dict_changes_parts_of_parts():
    wheels = FLAGSHIP.spacecraft.wheels
    weaker = FLAGSHIP.replace(spacecraft={"wheels": {"torque_limit": 0.15}}).spacecraft
    assert weaker == dataclasses.replace(FLAGSHIP.spacecraft, wheels=dataclasses.replace(wheels, torque_limit=0.15))
    six = WheelArray(tuple(row * 2 for row in wheels.axes), 0.2, 12.0)
    assert FLAGSHIP.replace(spacecraft={"wheels": six}).spacecraft.wheels == six


def test_a_dict_for_an_absent_part_changes_its_defaults():
    bare = FLAGSHIP.replace(sensors=None, inertia_uncertainty=None, disturbance=None)
    assert bare.replace(sensors={"rate_noise": 1e-5}).sensors == SensorErrors(rate_noise=1e-5)
    assert bare.replace(sensors={"gyro": {"bias": 1.0}}).sensors == SensorSuite(gyro=Gyro(bias=1.0))
    assert bare.replace(inertia_uncertainty={"relative": 0.2}).inertia_uncertainty == InertiaUncertainty(relative=0.2)
    torque = LowOrbitTorque()
    assert bare.replace(disturbance=to_plain(torque)).disturbance == torque


@pytest.mark.parametrize(
    "given",
    [
        OUTAGE, [OUTAGE], (OUTAGE,), "outage:0@5", ["outage:0@5"], to_plain(OUTAGE), [to_plain(OUTAGE)],
        FaultSchedule((OUTAGE,)), to_plain(FaultSchedule((OUTAGE,))),
    ],
)  # fmt: skip
def test_faults_in_short(given):
    assert FLAGSHIP.replace(faults=given).faults == FaultSchedule((OUTAGE,))
    assert FLAGSHIP.replace(faults=None).replace(faults=given).faults == FaultSchedule((OUTAGE,))


def test_no_faults_in_short():
    assert FLAGSHIP.replace(faults="none").faults is None


def test_several_faults_as_text():
    text = "outage:0@5, bias:2@10..20, constant=0.05, random_sign=true, star_tracker_outage@3,lock-in-place:1"
    found = parse_all(text)
    assert [type(fault) for fault in found] == [Outage, Bias, StarTrackerOutage, LockInPlace]
    assert found[1] == Bias(wheel=2, onset=(10.0, 20.0), constant=0.05, random_sign=True)
    assert FLAGSHIP.replace(faults=text).faults == FaultSchedule(found)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"reward": {"beauty": 1.0}}, r"reward: RewardWeights has no field 'beauty'; its fields are .*'effort'"),
        ({"reward": {"effort": -1.0}}, "reward.effort must not be negative"),
        ({"reward": {"type": "Outage"}}, "reward must describe a RewardWeights, got 'Outage'"),
        ({"spacecraft": {"wheels": {"torque": 0.1}}}, "spacecraft.wheels: WheelArray has no field 'torque'"),
        ({"sensors": {"gyro": {"bias": {}}}}, "sensors.gyro.bias must not be an object"),
        ({"sensors": {"rate_noise": 1e-5}}, "sensors: SensorSuite has no field 'rate_noise'; its fields are .*'gyro'"),
        ({"name": {"a": 1}}, "name must not be an object"),
        ({"faults": {"onset": 1.0}}, "faults: FaultDistribution has no field 'onset'"),
        ({"faults": "seizzure:2"}, "fault must have the form"),
        ({"faults": "outage:9"}, r"faults\.faults\[0\]\.wheel must be below the number of wheels, 4"),
        ({"faults": "outage:0@5,colour=1"}, "outage has the fields"),
        ({"faults": Outage()}, "faults must each name a wheel"),
        ({"faults": [OUTAGE, 3]}, "faults must hold Fault objects of a concrete kind, got 3"),
        ({"faults": [{"type": "Outage", "colour": 1}]}, r"faults\[0\]: Outage has no field 'colour'"),
    ],
)
def test_what_is_refused(changes, message):
    with pytest.raises(ValueError, match=message):
        FLAGSHIP.replace(**changes)


def test_a_part_of_several_kinds_that_is_absent_needs_a_type():
    bare = FLAGSHIP.replace(faults=None, disturbance=None)
    for name in ("faults", "disturbance"):
        with pytest.raises(ValueError, match=rf"{name}\.type must be one of"):
            bare.replace(**{name: {"severity": 0.5}})


@pytest.mark.parametrize("make", [gym.make, gym.make_vec])
def test_environments_take_the_short_forms_and_their_specification_keeps_them(make):
    changes = {
        "faults": [OUTAGE], "reward": {"on_target": 1.0}, "success": {"hold": 5.0},
        "spacecraft": {"wheels": WheelArray.sign_pyramid(0.1, 12.0)},
    }  # fmt: skip
    env = make("SpacecraftFTC-v0", **changes)
    assert env.unwrapped.scenario == FLAGSHIP.replace(**changes)
    spec = env.spec.to_json()
    json.loads(spec)
    assert make(EnvSpec.from_json(spec)).unwrapped.scenario == env.unwrapped.scenario
