"""The isolation of faulty wheels: false alarms, each kind on each wheel, faults that end, batches and copies."""

import copy
import dataclasses
import pickle

import numpy as np
import pytest
from helpers.isolated import FLAGSHIP, Watched, exciting

from ftac_gym import baselines, scenarios
from ftac_gym.baselines import observers
from ftac_gym.baselines.estimate import WheelCondition
from ftac_gym.baselines.memory import Memory
from ftac_gym.dynamics import Simulator
from ftac_gym.faults import (
    Bias,
    CommandDelay,
    DriftingEffectiveness,
    FaultSchedule,
    HardOver,
    LockInPlace,
    LossOfEffectiveness,
    Outage,
)
from ftac_gym.spacecraft import Spacecraft, WheelArray
from ftac_gym.task import InertiaUncertainty, InitialState

BOTH = ("multiple_model", "multiple_model_telemetry")
ONSET = 10.0
AT = 100
"""Onset in seconds and control periods."""

EFFECTIVENESS, BIAS, LOCK = WheelCondition.EFFECTIVENESS, WheelCondition.BIAS, WheelCondition.LOCK
OUTAGE, DELAY, UNKNOWN = WheelCondition.OUTAGE, WheelCondition.DELAY, WheelCondition.UNKNOWN

CASES = {
    "effectiveness 0.3": (LossOfEffectiveness(onset=ONSET, wheel=0, effectiveness=0.3), EFFECTIVENESS),
    "effectiveness 0.7": (LossOfEffectiveness(onset=ONSET, wheel=1, effectiveness=0.7), EFFECTIVENESS),
    "bias": (Bias(onset=ONSET, wheel=2, constant=-0.05), BIAS),
    "swinging bias": (Bias(onset=ONSET, wheel=2, amplitude=0.05, frequency=0.3), BIAS),
    "lock": (LockInPlace(onset=ONSET, wheel=3), LOCK),
    "hard over": (HardOver(onset=ONSET, wheel=0, fraction=0.4), LOCK),
    "outage": (Outage(onset=ONSET, wheel=1), OUTAGE),
    **{f"delay {k}": (CommandDelay(onset=ONSET, wheel=2, periods=k), DELAY) for k in range(1, 6)},
}


def others(values, wheel):
    return np.delete(values, wheel, axis=2)


# --------------------------------------------------------------------------------------------------------- false alarms


@pytest.mark.parametrize("name", BOTH)
@pytest.mark.parametrize("task", ["flagship", "flagship_plant", "flagship_unseen", "flagship_tracking"])
def test_healthy_wheels_raise_no_alarm(task, name):
    """Over 3 1/3 hours in closed loop, with uncertain inertia, stored momentum, and friction on ``flagship_unseen``."""
    healthy = scenarios.get(task).replace(faults=None)
    watched = Watched(task=healthy, count=100, duration=120.0, seed=31, name=name, law="pd_dob")
    assert not watched.alarm.any()
    assert (watched.condition == WheelCondition.HEALTHY).all() and (watched.effectiveness == 1.0).all()
    assert (watched.bias == 0.0).all() and (watched.delay == 0).all()


def test_inertia_and_momentum_are_learned_without_an_alarm():
    """30 % of error in the inertia and 6 N m s in the wheels, in a loop that slews."""
    task = FLAGSHIP.replace(
        inertia_uncertainty=InertiaUncertainty(relative=0.3),
        initial_state=InitialState(max_rate=0.02, wheel_momentum=(-6.0, 6.0)),
    )
    watched = Watched(task=task, count=60, duration=60.0, amplitude=0.06)
    assert not watched.alarm.any()
    parameters, simulator = watched.memory["plant"]["parameters"], watched.simulator
    spacecraft, state = task.spacecraft, simulator.state
    true = simulator.episodes.inertia["constant"]
    found = parameters[:, [0, 3, 4, 3, 1, 5, 4, 5, 2]].reshape(-1, 3, 3)
    nominal = spacecraft.inertia_matrix
    error = np.linalg.norm(found - true, axis=(1, 2)) / np.linalg.norm(true - nominal, axis=(1, 2))
    assert np.median(error) < 0.15
    # The momentum is kept in inertial axes.
    q, (w, x, y, z) = state.attitude, state.attitude.T
    rotation = np.array(
        [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
         [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
         [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]
    )  # fmt: skip
    body = np.einsum("nij,nj->ni", true, state.rate) + state.wheel_momentum @ spacecraft.wheels.axis_matrix.T
    stored = np.einsum("ijn,nj->ni", rotation, body)
    assert q.shape == (60, 4)
    missed = np.linalg.norm(parameters[:, 6:] - stored, axis=1) / np.linalg.norm(stored, axis=1)
    assert np.median(missed) < 0.1


# ----------------------------------------------------------------------------------------------------- wheels and kinds


@pytest.mark.parametrize("name", BOTH)
@pytest.mark.parametrize("case", CASES)
def test_each_kind_is_found_on_its_wheel(case, name):
    """Within 2.5 s of the onset the right wheel alarms and no other; within 10 s the kind is right in all episodes."""
    fault, kind = CASES[case]
    watched = Watched(fault, duration=30.0, name=name)
    assert not watched.alarm[:AT].any() and not others(watched.alarm, fault.wheel).any()
    assert watched.alarm[AT + 25, :, fault.wheel].all()
    assert (watched.condition[AT + 100 :, :, fault.wheel] == kind).mean() > 0.98


@pytest.mark.parametrize("periods", range(1, 6))
def test_the_length_of_a_delay_is_found(periods):
    watched = Watched(CommandDelay(onset=ONSET, wheel=1, periods=periods), duration=30.0)
    assert (watched.delay[AT + 100 :, :, 1] == periods).mean() > 0.98
    assert (others(watched.delay, 1) == 0).all()


@pytest.mark.parametrize("effectiveness", [0.2, 0.5, 0.8])
def test_effectiveness_is_estimated(effectiveness):
    watched = Watched(LossOfEffectiveness(onset=ONSET, wheel=0, effectiveness=effectiveness), duration=30.0)
    np.testing.assert_allclose(watched.effectiveness[-1, :, 0], effectiveness, atol=0.03)
    assert (others(watched.effectiveness, 0) == 1.0).all()


@pytest.mark.parametrize("constant", [0.02, 0.1, -0.06])
def test_bias_is_estimated(constant):
    watched = Watched(Bias(onset=ONSET, wheel=3, constant=constant), duration=30.0)
    np.testing.assert_allclose(watched.bias[-1, :, 3], constant, atol=4e-3)


def test_a_locked_wheel_has_its_torque_as_bias_and_no_effectiveness():
    watched = Watched(HardOver(onset=ONSET, wheel=0, fraction=0.4, random_sign=False), duration=30.0)
    np.testing.assert_allclose(watched.bias[-1, :, 0], 0.08, atol=4e-3)
    assert (watched.effectiveness[-1, :, 0] == 0.0).all()


def test_a_drifting_effectiveness_alarms_on_its_wheel_alone():
    """While the loss grows no kind of constant parameters is right; the missing torque is followed all the same."""
    watched = Watched(DriftingEffectiveness(onset=ONSET, wheel=1, effectiveness=0.2, rise=20.0), duration=40.0)
    assert watched.alarm[AT + 50 :, :, 1].all() and not others(watched.alarm, 1).any()
    assert not np.isin(watched.condition[:, :, 1], (LOCK, DELAY)).any()


@pytest.mark.parametrize("name", BOTH)
def test_two_faulty_wheels_are_told_apart(name):
    first = LossOfEffectiveness(onset=ONSET, wheel=0, effectiveness=0.3)
    second = HardOver(onset=20.0, wheel=2, fraction=0.3)
    watched = Watched(first, second, duration=45.0, name=name)
    assert not watched.alarm[:, :, [1, 3]].any()
    assert watched.alarm[230:, :, 0].all() and watched.alarm[230:, :, 2].all()
    assert (watched.condition[350:, :, 0] == EFFECTIVENESS).mean() > 0.95
    assert (watched.condition[350:, :, 2] == LOCK).mean() > 0.95


# -------------------------------------------------------------------------------------------------- not identifiable


STILL = FLAGSHIP.replace(initial_state=InitialState.fixed())
"""A body at rest: without commands it stays there, so that no angular momentum has to be learned."""


@pytest.mark.parametrize(
    "fault",
    [
        LossOfEffectiveness(onset=ONSET, wheel=1, effectiveness=0.5),
        Outage(onset=ONSET, wheel=1),
        CommandDelay(onset=ONSET, wheel=1, periods=3),
    ],
)
def test_a_fault_without_a_command_does_not_show(fault):
    """A wheel that has nothing to do gives what a healthy one gives."""
    assert not Watched(fault, task=STILL, amplitude=0.0).alarm.any()


def test_a_constant_torque_without_excitation_is_not_identifiable():
    """Bias and lock are the same thing where the command is constant: the kind stays open, the torque is estimated."""
    watched = Watched(Bias(onset=ONSET, wheel=1, constant=0.05), task=STILL, duration=20.0, amplitude=0.0)
    assert (watched.condition[AT + 10 :, :, 1] == UNKNOWN).all() and not watched.identifiable[AT + 10 :, :, 1].any()
    assert others(watched.identifiable, 1).all() and not others(watched.alarm, 1).any()
    # The body turns faster and faster, about an axis whose moment of inertia is uncertain.
    np.testing.assert_allclose(watched.bias[-1, :, 1], 0.05, rtol=0.3)


@pytest.mark.parametrize("name", BOTH)
@pytest.mark.parametrize("kind", [BIAS, LOCK, DELAY])
def test_no_wrong_kind_is_told_in_a_quiet_loop(kind, name):
    """At rest on target the commands are small; a kind is right there, or it is left open."""
    fault = {
        BIAS: Bias(onset=60.0, wheel=1, constant=0.05, random_sign=True),
        LOCK: HardOver(onset=60.0, wheel=1, fraction=0.3),
        DELAY: CommandDelay(onset=60.0, wheel=1, periods=4),
    }[kind]
    watched = Watched(fault, count=60, duration=90.0, name=name, law="pd_dob")
    told = watched.condition[600:, :, 1]
    assert np.isin(told, (WheelCondition.HEALTHY, UNKNOWN, kind)).mean() > 0.97
    assert others(watched.alarm, 1).any(axis=(0, 2)).mean() < 0.05


# ------------------------------------------------------------------------------------------------------- end of a fault


@pytest.mark.parametrize(
    "fault",
    [
        LossOfEffectiveness(onset=ONSET, wheel=1, effectiveness=0.3, duration=15.0),
        Bias(onset=ONSET, wheel=1, constant=0.08, duration=15.0),
        Outage(onset=ONSET, wheel=1, duration=15.0),
        HardOver(onset=ONSET, wheel=1, fraction=0.4, duration=15.0),
        CommandDelay(onset=ONSET, wheel=1, periods=3, duration=15.0),
    ],
)
def test_a_fault_that_ends_is_let_go(fault):
    watched = Watched(fault, duration=75.0)
    assert watched.alarm[200:250, :, 1].all() and not others(watched.alarm, 1).any()
    assert not watched.alarm[-50:].any()
    assert (watched.effectiveness[-1] == 1.0).all() and (watched.bias[-1] == 0.0).all()


# ---------------------------------------------------------------------------------------------- batches, copies, resets


def measurements(scenario, count, steps=160, seed=5):
    """Return the measurements of a flight."""
    simulator = Simulator(scenario, count)
    simulator.reset(scenario.draw(seed, count))
    found = []
    for step in range(steps):
        found.append(simulator.measurement())
        simulator.step(exciting(0.1 * step, count))
    return found


FAULTY = FLAGSHIP.replace(faults=FaultSchedule((HardOver(onset=4.0, wheel=1, fraction=0.3),)))


def states(memory):
    return {name: array.tobytes() for name, array in memory.copy().items()}


@pytest.mark.parametrize("name", BOTH)
def test_a_batch_is_its_spacecraft_one_by_one_to_the_bit(name):
    seen = measurements(FAULTY, 6, steps=90)
    memory = Memory(6)
    batch = observers.make(name, FAULTY, memory)
    singles = [Memory(1) for _ in range(6)]
    alone = [observers.make(name, FAULTY, single) for single in singles]
    for measurement in seen:
        batch.update(measurement, measurement.last_command, 0.1)
        for k, observer in enumerate(alone):
            one = measurement.take(np.array([k]))
            observer.update(one, one.last_command, 0.1)
    assert batch.estimate.alarm[:, 1].all()
    for key, array in memory.copy().items():
        for k, single in enumerate(singles):
            assert array[k : k + 1].tobytes() == single[key].tobytes(), key


def test_a_reset_by_mask_leaves_the_others_untouched():
    memory = Memory(4)
    observer = observers.make("multiple_model", FAULTY, memory)
    fresh = states(memory)
    for measurement in measurements(FAULTY, 4):
        observer.update(measurement, measurement.last_command, 0.1)
    before = memory.copy()
    memory.reset(np.array([True, False, True, False]))
    initial = Memory(4)
    observers.make("multiple_model", FAULTY, initial)
    assert states(initial) == fresh
    for name, array in memory.copy().items():
        assert array[[0, 2]].tobytes() == initial[name][[0, 2]].tobytes(), name
        assert array[[1, 3]].tobytes() == before[name][[1, 3]].tobytes(), name
    assert observer.estimate.alarm[:, 1].tolist() == [False, True, False, True]


@pytest.mark.parametrize("law", ["pd_dob", "nftsm"])
def test_a_reset_spacecraft_flies_like_a_new_one(law):
    """The second episode of a spacecraft whose wheel was faulty in the first one is the first of a new spacecraft."""
    count, seen = 3, measurements(FAULTY, 3)
    used, new = (baselines.make(law, FAULTY, count, isolation="rate") for _ in range(2))
    for measurement in seen:
        used.act(measurement)
    assert used.estimate.alarm.any()
    used.reset()
    for measurement in seen[:60]:
        np.testing.assert_array_equal(used.act(measurement), new.act(measurement))
    assert states(used.memory) == states(new.memory)


def test_acting_for_some_keeps_the_memory_of_the_others():
    seen = measurements(FAULTY, 4)
    baseline, whole = (baselines.make("pd_dob", FAULTY, 4, isolation="rate") for _ in range(2))
    for measurement in seen[:80]:
        baseline.act(measurement)
        whole.act(measurement)
    before = baseline.memory.copy()
    mask = np.array([True, False, False, True])
    command = baseline.act_only(seen[80], mask)
    np.testing.assert_array_equal(command[mask], whole.act(seen[80])[mask])
    for name, array in baseline.memory.copy().items():
        assert array[~mask].tobytes() == before[name][~mask].tobytes(), name
        assert array[mask].tobytes() == whole.memory[name][mask].tobytes(), name


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda item: pickle.loads(pickle.dumps(item))])
def test_copies_go_on_alike(copied):
    seen = measurements(FAULTY, 2)
    baseline = baselines.make("pd_dob", FAULTY, 2, isolation="telemetry")
    for measurement in seen[:60]:
        baseline.act(measurement)
    other = copied(baseline)
    kept = states(other.memory)
    for measurement in seen[60:100]:
        baseline.act(measurement)
    assert states(other.memory) == kept != states(baseline.memory)
    for measurement in seen[60:100]:
        other.act(measurement)
    assert states(other.memory) == states(baseline.memory)


def test_an_update_writes_to_no_array_that_was_handed_out():
    memory = Memory(2)
    observer = observers.make("multiple_model", FAULTY, memory)
    seen = measurements(FAULTY, 2)
    for measurement in seen[:50]:
        observer.update(measurement, measurement.last_command, 0.1)
    earlier = memory.copy()
    held = {name: array.tobytes() for name, array in earlier.items()}
    for measurement in seen[50:]:
        observer.update(measurement, measurement.last_command, 0.1)
    assert {name: array.tobytes() for name, array in earlier.items()} == held


# ------------------------------------------------------------------------------------------------------------ bad input


@pytest.mark.parametrize("isolation", ["rate", "telemetry"])
def test_a_flexible_spacecraft_is_refused_by_name(isolation):
    flexible = scenarios.get("flexible")
    with pytest.raises(ValueError, match="spacecraft must be rigid for the isolation of faulty wheels"):
        baselines.make("nftsm", flexible, isolation=isolation)
    assert baselines.make("nftsm", flexible, isolation="none").memory.has("wheels") is False


def test_wheels_without_limits_are_refused_by_name():
    wheels = WheelArray(FLAGSHIP.spacecraft.wheels.axes, None, None)
    endless = FLAGSHIP.replace(spacecraft=Spacecraft(FLAGSHIP.spacecraft.inertia, wheels))
    with pytest.raises(ValueError, match="torque_limit must be finite for every wheel for the isolation of faulty"):
        observers.make("multiple_model", endless, Memory(1))


@pytest.mark.parametrize(("name", "value"), [("threshold", 0.0), ("margin", -1.0), ("gate", 0.0), ("gate", 1.5)])
def test_bad_gains_are_refused_by_name(name, value):
    with pytest.raises(ValueError, match=f"{name} must"):
        observers.make("multiple_model", FLAGSHIP, Memory(1), **{name: value})


def test_gains_are_those_of_the_dataclass():
    gains = {field.name for field in dataclasses.fields(observers.gains_of("multiple_model"))}
    assert gains == {"threshold", "margin", "gate"}
