"""Rules for every registered baseline: limits, batches, resets, its search space and its error messages."""

import dataclasses

import numpy as np
import pytest
from helpers.observed import task
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from ftac_gym import baselines, scenarios
from ftac_gym.baselines import observers
from ftac_gym.dynamics import Simulator
from ftac_gym.faults import Bias, FaultSchedule, LossOfEffectiveness
from ftac_gym.task.disturbances import Disturbance
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.measurement import Measurement

NAMES = baselines.names()
FLAGSHIP = scenarios.get("flagship")
FAULTS = FaultSchedule((LossOfEffectiveness(wheel=0, onset=0.4, effectiveness=0.4), Bias(wheel=1, constant=0.1)))
THREE = task(
    3, 0.1, FAULTS, initial_state=InitialState(max_rate=0.1), disturbance=Disturbance((0.05, -0.02, 0.01)),
    physics_step=0.02,
)  # fmt: skip
COUNT, STEPS = 4, 20


def fits(name, scenario):
    """Tell whether a baseline suits a scenario: the printed learning observer has three wheels, fuzzy models bend.

    Published gains are for a heavy spacecraft.
    """
    if name.startswith(("fuzzy", "aismc")):
        published = name not in ("fuzzy_smc_solved",)
        return scenario.name == "li_2023" or (scenario.spacecraft.modes > 0 and not published)
    return name != "ptc_printed" or scenario.spacecraft.wheels.count == 3


FLEXIBLE, LI = scenarios.get("flexible"), scenarios.get("li_2023")
BENDING = [name for name in NAMES if name.startswith(("fuzzy", "aismc", "raftsmc", "pd"))]
CASES = [(name, scenario) for scenario in (FLAGSHIP, THREE) for name in NAMES if fits(name, scenario)]
CASES += [(name, scenario) for scenario in (FLEXIBLE, LI) for name in BENDING if fits(name, scenario)]
every = pytest.mark.parametrize(
    ("name", "scenario"), CASES, ids=[f"{name}-{scenario.name}" for name, scenario in CASES]
)  # fmt: skip


def recorded(scenario, steps=STEPS, seed=1):
    """Return measurements, with the truth, along flights of a few spacecraft under random commands."""
    simulator, random = Simulator(scenario, COUNT), np.random.default_rng(seed)
    simulator.reset(scenario.draw(seed, COUNT))
    limits, measurements = scenario.spacecraft.wheels.torque_limits, []
    for _ in range(steps):
        measurements.append(simulator.measurement(truth=True))
        simulator.step(limits * random.uniform(-1.0, 1.0, (COUNT, len(limits))))
    return measurements


def one_of(measurement, index):
    """Return the measurement of one spacecraft."""
    arrays = {key: array[[index]] for key, array in vars(measurement).items() if key != "truth"}
    truth = type(measurement.truth)(*(part[[index]] for part in measurement.truth))
    return Measurement(**arrays, truth=truth)


def fitting(name):
    """Return the first scenario that a baseline fits."""
    return next(scenario for scenario in (FLAGSHIP, THREE, FLEXIBLE, LI) if fits(name, scenario))


@every
def test_acts_within_the_limits(name, scenario):
    """In closed loop from random starts; ptc_printed too, whose estimate sinks to nothing."""
    simulator, law = Simulator(scenario, COUNT), baselines.make(name, scenario, COUNT)
    simulator.reset(scenario.draw(0, COUNT))
    limits = scenario.spacecraft.wheels.torque_limits
    for _ in range(50):
        command = law.act(simulator.measurement(truth=law.information == "oracle"))
        assert command.shape == (COUNT, len(limits)) and np.isfinite(command).all()
        assert (np.abs(command) <= limits * (1.0 + 1e-12)).all()
        simulator.step(command)
    for array in law.memory.copy().values():
        parts = [array] if array.dtype.names is None else [array[name] for name in array.dtype.names]
        assert all(np.isfinite(part).all() for part in parts)


@pytest.mark.parametrize("field", ["attitude", "rate", "reference_attitude", "command_in_effect", "attitude_age"])
@pytest.mark.parametrize("name", ["pd", "pd_dob", "lqr", "indi", "super_twisting", "nftsm", "nftsm_isolation"])
def test_no_measurement_that_is_not_a_number_becomes_a_command(name, field):
    """For the spacecraft that it is of; the others fly on."""
    law, measurements = baselines.make(name, FLAGSHIP, COUNT), recorded(FLAGSHIP)
    for measurement in measurements[:10]:
        law.act(measurement)
    values = getattr(measurements[10], field).copy()
    values[1] = np.nan
    law.act(dataclasses.replace(measurements[10], **{field: values}))
    # A torque of the period before counts from the next command on at the latest.
    values = getattr(measurements[11], field).copy()
    values[1] = np.nan
    finite = np.isfinite(law.act(dataclasses.replace(measurements[11], **{field: values}))).all(axis=1)
    assert finite.tolist() == [True, False, True, True]


@every
def test_a_batch_equals_single_baselines_and_resets_by_mask(name, scenario):
    measurements = recorded(scenario)
    together, alone = baselines.make(name, scenario, COUNT), [baselines.make(name, scenario) for _ in range(COUNT)]
    mask = np.array([True, False, False, True])
    for step, measurement in enumerate(measurements):
        if step == 10:
            together.reset(mask)
            alone[0].reset()
            alone[3].reset(np.array([True]))
        command = together.act(measurement)
        for row, single in enumerate(alone):
            np.testing.assert_allclose(command[[row]], single.act(one_of(measurement, row)), rtol=1e-9, atol=1e-12)


@every
def test_a_reset_gives_the_same_flight_again(name, scenario):
    measurements, law = recorded(scenario, 15), baselines.make(name, scenario, COUNT)
    first = [law.act(measurement) for measurement in measurements]
    law.reset()
    for command, measurement in zip(first, measurements, strict=True):
        np.testing.assert_array_equal(law.act(measurement), command)


@pytest.mark.parametrize("name", NAMES)
@settings(max_examples=3, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_every_point_of_the_search_space_makes_a_baseline(name, data):
    """Both ends, the middle, and anything in between."""
    scenario = fitting(name)
    space, law = baselines.search_space(name), baselines.baseline_class(name)
    drawn = {key: data.draw(st.floats(item.low, item.high), label=key) for key, item in space.items()}
    ends = [{key: getattr(item, end) for key, item in space.items()} for end in ("low", "high")]
    middle = {
        key: np.sqrt(item.low * item.high) if item.log else 0.5 * (item.low + item.high) for key, item in space.items()
    }
    measurement = recorded(scenario, 1)[0]
    for point in (*ends, middle, drawn):
        gains = law.gains_at(point)
        assert law.point_of(gains) == pytest.approx(point)
        command = baselines.make(name, scenario, COUNT, **gains).act(measurement)
        assert np.isfinite(command).all()


@pytest.mark.parametrize("name", NAMES)
def test_the_search_space_names_gains_of_the_baseline(name):
    scenario = fitting(name)
    space = baselines.search_space(name)
    middle = {key: np.sqrt(item.low * item.high) if item.log else 0.5 * (item.low + item.high)
              for key, item in space.items()}  # fmt: skip
    observed = any(key.startswith("observer.") for key in space)
    assert observed == (baselines.make(name, scenario).information != "oracle" and "observer" in _parts(name))
    for gain in baselines.baseline_class(name).gains_at(middle):
        assert gain in baselines.defaults(name)


def _parts(name):
    """Return the parts of a law that have something to search: the fuzzy observer's gains are solved for."""
    source = baselines.defaults(name).get("faults", "none")
    return ["observer"] if source not in ("none", "oracle", "fafeo") else []


def test_a_search_keeps_the_gains_of_the_observer_that_it_does_not_search():
    """At the point of its defaults, predefined_time_observer is itself."""
    name = "predefined_time_observer"
    ours = observers.defaults(baselines.defaults(name)["faults"])
    changed = baselines.make(name, FLAGSHIP, COUNT, observer={"first": ours["first"], "second": ours["second"]})
    itself, same = baselines.make(name, FLAGSHIP, COUNT), True
    for measurement in recorded(FLAGSHIP, 20):
        same = same and np.array_equal(changed.act(measurement), itself.act(measurement))
    assert same


@pytest.mark.parametrize("name", NAMES)
def test_defaults_make_the_baseline(name):
    scenario = fitting(name)
    first, second = baselines.make(name, scenario, COUNT), baselines.make(
        name, scenario, COUNT, **baselines.defaults(name)
    )  # fmt: skip
    for measurement in recorded(scenario, 3):
        np.testing.assert_array_equal(first.act(measurement), second.act(measurement))


@pytest.mark.parametrize("name", NAMES)
def test_an_unknown_gain_is_named(name):
    scenario = fitting(name)
    with pytest.raises(TypeError, match=f"unexpected keyword argument 'beauty'; gains of {name} are "):
        baselines.make(name, scenario, beauty=1.0)


@pytest.mark.parametrize(
    ("name", "gains", "message"),
    [
        ("tsmc_class", {"reaching_linear": -1.0}, "reaching_linear must not be negative"),
        ("ptc_oracle", {"rate_time": 0.0}, "rate_time must be positive"),
        ("predefined_time", {"position_exponent": 0.0}, r"position_exponent must lie within \(0, 1\)"),
        ("nftsm", {"reaching_linear": np.nan}, "reaching_linear must be finite"),
        ("nftsm", {"exponent": "big"}, "exponent must be a number"),
        ("nftsm", {"prediction": "no"}, "prediction must be True or False, got 'no'"),
        ("pd", {"telemetry": "off"}, "telemetry must be True or False, got 'off'"),
        (
            "nftsm_isolation",
            {"faults": "multiple_model"},
            "faults must be 'none' with an isolation of faulty wheels, got 'multiple_model'",
        ),
        ("zhang_zhou_tracking", {"reaching_power": np.inf}, "reaching_power must be finite"),
        ("zhang_zhou_tracking", {"initial_eta": np.inf}, "initial_eta must be finite"),
        ("zhang_zhou_tracking", {"coupling_high": np.inf}, "coupling_high must be finite"),
        ("zhang_zhou_tracking", {"anti_saturation": {"initial": np.nan}}, "anti_saturation.initial must be finite"),
    ],
)
def test_errors_name_the_fields_of_the_whole_law(name, gains, message):
    with pytest.raises(ValueError, match=f"^{name}: {message}"):
        baselines.make(name, FLAGSHIP, **gains)


@pytest.mark.parametrize(
    "name", [name for name in NAMES if hasattr(baselines.baseline_class(name), "sliding_variable")]
)
def test_the_sliding_variable_does_not_move_the_law_on(name):
    scenario = fitting(name)
    law, measurement = baselines.make(name, scenario, COUNT), recorded(scenario, 1)[0]
    before = law.memory.copy()
    variable = law.sliding_variable(measurement)
    assert variable.shape == (COUNT, 3) and np.isfinite(variable).all()
    for key, array in law.memory.copy().items():
        assert array.tobytes() == before[key].tobytes()
