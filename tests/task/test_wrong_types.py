"""Values of wrong types in every field of every class of a scenario, from JSON and from Python."""

import dataclasses
import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ftac_gym import Simulator, faults, scenarios
from ftac_gym.spacecraft import FlexibleAppendages, Friction, Spacecraft, WheelArray, catalogue, layouts
from ftac_gym.task import (
    AppendageUncertainty,
    CostBounds,
    Disturbance,
    Gyro,
    Harmonic,
    InertiaUncertainty,
    InitialState,
    LowOrbitTorque,
    ModalTelemetry,
    MRPSinusoid,
    PrescribedBound,
    RateProfile,
    RewardWeights,
    SampledReference,
    Scenario,
    SensorErrors,
    SensorSuite,
    StarTracker,
    SuccessCriterion,
    WheelTelemetry,
)
from ftac_gym.task.orbit import orbital_rate
from ftac_gym.utils.serialization import TYPE_KEY, classes, to_plain

FLEXIBLE = scenarios.get("flexible")
FRICTION = Friction(0.01, 0.02, 0.3, 1e-4)
WHEELS = WheelArray(np.eye(3), 0.2, 2.0, False, 0.1, 30.0, (FRICTION, None, FRICTION), 0.3, 1e-4, 60.0)
PANELS = FlexibleAppendages((2.0, 3.0), (0.01, 0.02), ((0.1, 0.2, 0.3), (0.3, 0.2, 0.1)))
RUBBING = dataclasses.replace(WheelArray.sign_pyramid(0.2, 12.0), spin_inertia=0.02, friction=FRICTION)
TASK = Scenario(name="task", spacecraft=Spacecraft(np.diag([9.0, 9.0, 9.0]), RUBBING))
LONG = "integer of 5000 digits"
AXES = (0.1, (0.1, 0.2), 0.3)
STILL = (0.0, 0.0, 0.0)
TIMING = {"onset": 1.0, "duration": 3.0, "rise": 0.1, "fall": 0.1}


def timed(kind, **changes):
    """Return a fault of a kind with as many fields set as it can have."""
    ramps = {} if kind.gradual else {"rise": 0.0, "fall": 0.0}
    return kind(**{**TIMING, **ramps, **changes})


def placed(kind, **changes):
    """Return a schedule with one fault of a kind."""
    wheel = {"wheel": 0} if issubclass(kind, faults.WheelFault) else {}
    return faults.FaultSchedule((timed(kind, **wheel, **changes),))


PARTS = [
    {"cost_bounds": CostBounds(angle=0.1), "success": SuccessCriterion(share=0.9, limit=5.0)},
    {"loop_delay": 0.02, "extra_delay": (1.0, 2.0)},
    {"reward": RewardWeights(vibration=0.1, vibration_scale=0.1)},
    {"spacecraft": Spacecraft(np.diag([9.0, 9.0, 9.0]), WHEELS, False, PANELS)},
    {"initial_state": InitialState((1.0, 0.0, 0.0, 0.0), 1.0, (0.1, 0.2, 0.3), 0.4, 0.0, (0.1, 0.2, 0.3, 0.4))},
    {"reference": MRPSinusoid(AXES, AXES, AXES, AXES), "misalignment": np.zeros((3, 4))},
    {"reference": RateProfile(AXES, AXES, AXES, AXES)},
    {"reference": SampledReference((0.0, 200.0), ((1.0, 0.0, 0.0, 0.0), (0.8, 0.6, 0.0, 0.0)))},
    {"faults": faults.FaultDistribution((faults.Outage(),), (1.0,), (0.5, 0.5), always=(faults.Outage(wheel=1),))},
    *({"faults": placed(kind)} for kind in faults.KINDS),
    {"disturbance": Disturbance(AXES, (Harmonic(AXES, 0.2, AXES),), 0.1)},
    {"disturbance": LowOrbitTorque()},
    {
        "disturbance": LowOrbitTorque(altitude=500e3, nadir=(0.0, 0.0, 1.0), orbit_normal=(0.0, -1.0, 0.0)),
        "reference": RateProfile(STILL, STILL, constant=(0.0, -orbital_rate(500e3), 0.0)),
    },
    {"sensors": SensorErrors(), "tumble_rate": 1.0},
    {"sensors": SensorSuite(star_tracker=StarTracker(), gyro=Gyro(), wheels=WheelTelemetry(), modes=ModalTelemetry())},
    {"inertia_uncertainty": InertiaUncertainty(0.1, np.eye(3), (1.0, 2.0, 3.0), AXES[:1] * 3, AXES[:1] * 3, True)},
    {"prescribed_bound": PrescribedBound(initial_factor=9.0)},
]
WRONG = {
    "truth value": True,
    "text": "1.0",
    "long text": "x" * 10_000,
    "object": {"value": 1.0},
    "object of another class": {TYPE_KEY: "Harmonic"},
    "unknown object": {TYPE_KEY: "y" * 10_000},
    "integer": 10**400,
    "long integer": LONG,
    "nan": float("nan"),
    "infinity": float("inf"),
    "lists": [[[[1.0]]]],
    "no list": [None, {}, [True]],
}


def every_scenario():
    yield FLEXIBLE.replace(
        faults=None,
        appendage_uncertainty=AppendageUncertainty(),
        initial_state=InitialState(modal_displacement=[0.1] * 4, modal_rate=[0.1] * 4),
    )
    for changes in PARTS:
        yield TASK.replace(**changes)


def fields_of(value, keys=(), path="scenario"):
    """Yield (class, field, keys, path) of every field in plain data."""
    if isinstance(value, dict):
        for name, item in value.items():
            if name != TYPE_KEY:
                yield value[TYPE_KEY], name, (*keys, name), f"{path}.{name}"
                yield from fields_of(item, (*keys, name), f"{path}.{name}")
    elif isinstance(value, list):
        for index, item in enumerate(value):
            yield from fields_of(item, (*keys, index), f"{path}[{index}]")


def found():
    """Return by (class, field) a scenario that has it, as plain data, with the keys and the path of the field."""
    places = {}
    for scenario in every_scenario():
        data = scenario.to_dict()
        for owner, name, keys, path in fields_of(data):
            places.setdefault((owner, name), (scenario, data, keys, path))
    return places


PLACES = found()
PACKAGE = {name: cls for name, cls in classes().items() if cls.__module__.startswith("ftac_gym.")}


def value_at(data, keys):
    for key in keys:
        data = data[key]
    return data


def with_value(data, keys, value):
    """Return plain data with another value at a place."""
    if not keys:
        return value
    copy = dict(data) if isinstance(data, dict) else list(data)
    copy[keys[0]] = with_value(copy[keys[0]], keys[1:], value)
    return copy


def refused(kind):
    """Yield the places where a kind of value is wrong: scenario, plain data, keys, path, name of the field."""
    for (_, name), (scenario, data, keys, path) in PLACES.items():
        truth = kind == "truth value" and isinstance(value_at(data, keys), bool)
        text = "text" in kind and name == "name"
        number = "integer" in kind and name == "wheel"
        if not (truth or text or number):
            yield scenario, data, keys, path, name


def as_json(data):
    """Return JSON text with integers of any length, which Python reads but does not write."""
    return json.dumps(data).replace(json.dumps(LONG), "9" * 5000)


def assert_one_line(error):
    message = str(error.value)
    assert "\n" not in message and len(message) <= 500
    return message


def test_every_field_of_every_class_is_tried():
    assert set(PLACES) == {(name, item.name) for name, cls in PACKAGE.items() for item in dataclasses.fields(cls)}


@pytest.mark.parametrize("kind", WRONG)
def test_wrong_values_in_json_are_refused_with_the_path_of_the_field(kind):
    for _, data, keys, path, _ in refused(kind):
        text = as_json(with_value(data, keys, WRONG[kind]))
        with pytest.raises(ValueError) as error:
            Scenario.from_json(text)
        assert assert_one_line(error).startswith(path), path


@pytest.mark.parametrize("kind", WRONG)
def test_wrong_values_in_python_are_refused_with_the_name_of_the_field(kind):
    value = 10**5000 if WRONG[kind] is LONG else WRONG[kind]
    for scenario, _, keys, path, name in refused(kind):
        part = scenario
        for key in keys[:-1]:
            part = getattr(part, key) if isinstance(key, str) else part[key]
        with pytest.raises(ValueError) as error:
            dataclasses.replace(part, **{name: value})
        assert assert_one_line(error).startswith(name), path


# ------------------------------------------------------------------------------------------------------------- JSON


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"lag": null', '"lag": 1.0, "lag": 2.0', r"scenario\.spacecraft\.wheels must have every key once, got 'lag'"),
        ('"duration": 120.0', '"duration": NaN', r"scenario\.duration must be finite, got nan"),
        ('"duration": 120.0', '"duration": 1e999', r"scenario\.duration must be finite, got inf"),
        ('"duration": 120.0', '"duration": ' + "9" * 5000, r"scenario\.duration must be finite, got inf"),
        ('"duration": 120.0', '"duration": ' + "9" * 400, r"scenario\.duration must be finite, got 9999"),
        ('"duration": 120.0', '"duration": ' + "[" * 50 + "]" * 50, r"scenario\.duration must be a number"),
        ('"duration": 120.0', '"duration": ' + "[" * 90_000, "scenario must not be nested so deeply"),
        ('"duration": 120.0', '"duration"', "scenario must be JSON text: Expecting ':'"),
        (
            '"viscous": 0.0001',
            '"viscous": -1',
            r"scenario\.spacecraft\.wheels\.friction\[0\]\.viscous must not be negative",
        ),
        ('"viscous": 0.0001', '"viscous": "1"', r"friction\[0\]\.viscous must be a number, got '1'"),
        (
            '"sensors": null',
            '"sensors": {"type": "Friction"}',
            "must describe a SensorErrors or SensorSuite, got",
        ),
        (
            '"sensors": null',
            '"sensors": {"type": "Star"}',
            r"scenario\.sensors\.type must be one of \['SensorErrors', 'SensorSuite'\]",
        ),
        ('"sensors": null', '"sensors": {"type": ["Star"]}', r"scenario\.sensors\.type must be one of"),
        (
            '"sensors": null',
            '"sensors": {"type": "SensorErrors", "x": 1}',
            "scenario.sensors: SensorErrors has no field",
        ),
        ('"sensors": null', '"sensors": {}', r"sensors\.type must be one of \['SensorErrors', 'SensorSuite'\], got"),
        ('"duration": 120.0', '"duration": {}', r"scenario\.duration must not be an object"),
    ],
)
def test_bad_json_is_refused_with_the_path(old, new, message):
    text = TASK.to_json()
    assert old in text
    with pytest.raises(ValueError, match=message) as error:
        Scenario.from_json(text.replace(old, new, 1))
    assert_one_line(error)


def test_depth_without_end_is_refused():
    data = []
    data.append(data)
    with pytest.raises(ValueError, match="scenario must not be nested so deeply"):
        Scenario.from_dict({**TASK.to_dict(), "duration": data})
    with pytest.raises(ValueError, match="duration must be a number"):
        TASK.replace(duration=data)


@pytest.mark.parametrize(
    ("faulty", "message"),
    [
        (
            faults.FaultDistribution((faults.Outage(),), fault_counts=(0.0,) * 5 + (1.0,)),
            "faults.fault_counts must not",
        ),
        (
            faults.FaultSchedule((faults.Outage(wheel=0), faults.Outage(wheel=7))),
            r"faults.faults\[1\].wheel must be below",
        ),
    ],
)
def test_rules_between_parts_name_the_part(faulty, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        TASK.replace(faults=faulty)
    with pytest.raises(ValueError, match=f"^scenario.{message}"):
        Scenario.from_dict({**TASK.to_dict(), "faults": to_plain(faulty)})


def test_counts_are_no_truth_values():
    for build in (
        lambda: TASK.draw(True, 1),
        lambda: TASK.draw(0, True),
        lambda: Simulator(TASK, True),
        lambda: layouts.pyramid(0.5, True),
        lambda: faults.Outage(wheel=True),
    ):
        with pytest.raises(ValueError, match=r"must be an? .*integer.*, got True"):
            build()


@pytest.mark.parametrize("get", [scenarios.get, catalogue.get])
@pytest.mark.parametrize("name", [["flagship"], {}, None, 3, True])
def test_names_are_text(get, name):
    with pytest.raises(ValueError, match="must be one of"):
        get(name)


def test_numpy_values_are_accepted_and_converted():
    wheels = WheelArray(np.eye(3), np.float32(0.5), np.int64(2), np.bool_(False), np.array(0.1), lag=np.full(3, 0.2))
    assert wheels.momentum_coupling is False and wheels.momentum_limit == (2.0,) * 3 and wheels.lag == (0.2,) * 3
    start = InitialState.fixed(np.array([1.0, 0.0, 0.0, 0.0]), np.zeros(3), np.arange(3))
    plain = InitialState.fixed(wheel_momentum=(0.0, 1.0, 2.0))
    assert start == plain and json.dumps(to_plain(start)) == json.dumps(to_plain(plain))
    uncertain = InertiaUncertainty(np.float64(0.1), rate_torque=np.bool_(True))
    assert uncertain.rate_torque is True
    fault = faults.HardOver(wheel=np.int32(1), onset=np.float64(2.0), random_sign=np.bool_(False))
    scenario = TASK.replace(
        spacecraft=Spacecraft(np.eye(3, dtype=int), wheels), faults=faults.FaultSchedule([fault]), duration=np.int64(9)
    )
    assert Scenario.from_json(scenario.to_json()) == scenario


ATOMS = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-(10**400), 10**400),
    st.floats(),
    st.text(max_size=5),
    st.sampled_from(["both", "Outage", "SetPoints", "InitialState"]),
)
PLAIN = st.recursive(
    ATOMS,
    lambda inner: st.one_of(st.lists(inner, max_size=4), st.dictionaries(st.text(max_size=4) | st.just("type"), inner)),
    max_leaves=6,
)
LIBRARY = {name: scenarios.get(name).to_dict() for name in scenarios.names()}


def places_of(data, keys=()):
    """Return the keys of all places in plain data."""
    items = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    return [keys, *(place for key, item in items for place in places_of(item, (*keys, key)))]


@settings(max_examples=200, deadline=None)
@given(name=st.sampled_from(sorted(LIBRARY)), draw=st.data(), value=PLAIN)
def test_mutated_scenarios_are_refused_in_one_line_or_survive(name, draw, value):
    keys = draw.draw(st.sampled_from(places_of(LIBRARY[name])))
    try:
        scenario = Scenario.from_json(json.dumps(with_value(LIBRARY[name], keys, value)))
    except ValueError as error:
        message = str(error)
        assert message.startswith("scenario") and "\n" not in message and len(message) <= 500
    else:
        assert Scenario.from_json(scenario.to_json()).to_json() == scenario.to_json()
