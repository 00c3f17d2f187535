"""The compiled signals of the plant and `fault_effect` read the same tables alike, for any kind and profile."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import njit

from ftac_gym import faults
from ftac_gym.faults.effect import presence
from ftac_gym.faults.signals import acts, constant_signals, part_at, step_signals, untouched
from ftac_gym.faults.table import FLIPS
from ftac_gym.spacecraft import Friction, WheelArray

FRICTION = Friction(0.01, 0.012, viscous=1e-4)
WHEELS = WheelArray(np.eye(3)[:, :2], 0.2, spin_inertia=0.02, friction=FRICTION)
END = 12.0  # s
SIGNALS = 8


def numbers(low, high):
    """Uniform numbers, or an interval of them."""
    pairs = st.tuples(st.floats(low, high), st.floats(low, high)).map(lambda pair: tuple(sorted(pair)))
    return st.one_of(st.floats(low, high), pairs)


MAGNITUDES = {
    faults.LossOfEffectiveness: {
        "effectiveness": numbers(0.4, 0.6), "amplitude": numbers(-0.4, 0.4), "frequency": numbers(0.0, 4.0),
        "phase": numbers(-3.0, 3.0),
    },
    faults.DriftingEffectiveness: {"effectiveness": numbers(0.0, 1.0), "rise": numbers(0.1, 8.0)},
    faults.Bias: {
        "constant": numbers(-0.1, 0.1), "slope": numbers(-0.1, 0.1), "amplitude": numbers(-0.1, 0.1),
        "exponent": numbers(0.0, 2.0), "frequency": numbers(0.0, 4.0), "phase": numbers(-3.0, 3.0),
        "random_sign": st.booleans(),
    },
    faults.Outage: {},
    faults.LockInPlace: {},
    faults.HardOver: {"fraction": numbers(-1.0, 1.0), "random_sign": st.booleans()},
    faults.FrictionRise: {
        "factor": numbers(1.0, 20.0), "direction": st.sampled_from(["both", "forward", "backward", "either"]),
        "rise": numbers(0.0, 8.0),
    },
    faults.Seizure: {"brake": numbers(1.1, 4.0)},
    faults.IntermittentShutdown: {"mean_acting": st.floats(0.1, 5.0), "mean_resting": st.floats(0.1, 5.0)},
    faults.CommandDelay: {"periods": st.sampled_from([1.0, 3.0, (1.0, 5.0)])},
    faults.GyroBiasStep: {"size": numbers(0.0, 0.1)},
    faults.StarTrackerOutage: {},
    faults.AttitudeSpike: {"angle": numbers(0.0, 1.0)},
}  # fmt: skip


@st.composite
def faults_of(draw, kind):
    """Faults of a kind: abrupt or incipient, permanent or recovering, steady or intermittent in either way."""
    values = {name: draw(strategy) for name, strategy in MAGNITUDES[kind].items()}
    values["onset"] = draw(numbers(0.0, 4.0))
    if kind.gradual and "rise" not in values:
        values["rise"] = draw(st.one_of(st.just(0.0), numbers(0.0, 4.0)))
    end = draw(st.sampled_from(["never", "recovery", "duration"]))
    if end != "never":
        values[end] = draw(numbers(4.5, 9.0) if end == "recovery" else numbers(0.1, 6.0))
        values["fall"] = draw(st.one_of(st.just(0.0), numbers(0.0, 4.0))) if kind.gradual else 0.0
    rhythm = draw(st.sampled_from(["steady", "periodic", "random"]))
    if rhythm == "random":
        values |= {"mean_acting": draw(st.floats(0.1, 3.0)), "mean_resting": draw(st.floats(0.1, 3.0))}
    elif rhythm == "periodic" and kind is not faults.IntermittentShutdown:
        values |= {"period": draw(numbers(1.0, 3.0)), "on_time": draw(numbers(0.1, 1.0))}
    return kind(**values, **({"wheel": draw(st.sampled_from([0, 1]))} if issubclass(kind, faults.WheelFault) else {}))


def drawn_at_times(listed, seed):
    """Fault tables of one episode, repeated at random times and at all times when a fault of it changes."""
    random, source = np.random.default_rng(seed), faults.FaultSchedule(tuple(listed))
    source.check(WHEELS)
    uniform = random.random((1, source.uniform_count(2)))
    drawn = source.draw(uniform, random.random((1, source.switching_count)), WHEELS.torque_limits)
    events = [drawn.switches.ravel()]
    for table in (drawn.wheels.ravel(), drawn.sensors.ravel()):
        periods = table["onset"] + table["period"] * np.arange(5)[:, None]
        grown, falling = table["onset"] + table["rise"], table["recovery"] - table["fall"]
        events += [periods, periods + table["on_time"], grown, falling, table["recovery"]]
    known = np.concatenate([np.ravel(event) for event in events])
    times = np.concatenate([random.uniform(0.0, END, 20), known[(known >= 0.0) & (known < END)]])
    return drawn.take(np.zeros(len(times), dtype=int)), times


@njit
def compiled_presence(records, switches, time, part):
    for i in range(records.shape[0]):
        for k in range(records.shape[1]):
            fault = records[i, k]
            part[i, k] = part_at(fault, time[i]) if acts(fault, switches, i, time[i]) else 0.0


@njit
def compiled_signals(listed, switches, time, out):
    """Locked, delay, effectiveness, bias, friction factors and brake at each time, as a step without length."""
    for i in range(listed.shape[0]):
        for j in range(listed.shape[1]):
            locked, delay, start, _, _, bias, _, _, forward, backward, brake = step_signals(
                listed, switches, i, j, time[i], 0.0
            )
            out[i, j, 0], out[i, j, 1], out[i, j, 2], out[i, j, 3] = 1.0 if locked else 0.0, delay, start, bias
            out[i, j, 4], out[i, j, 5], out[i, j, 6] = forward, backward, brake


@njit
def compiled_constants(listed, begin, end, out):
    """The same for the time between two moments, with a flag in the last column that says whether it holds."""
    for i in range(listed.shape[0]):
        for j in range(listed.shape[1]):
            constant, locked, delay, effectiveness, bias, forward, backward, brake = constant_signals(
                listed, i, j, begin[i], end[i]
            )
            out[i, j, 0], out[i, j, 1], out[i, j, 2], out[i, j, 3] = 1.0 if locked else 0.0, delay, effectiveness, bias
            out[i, j, 4], out[i, j, 5], out[i, j, 6] = forward, backward, brake
            out[i, j, 7] = 2.0 if untouched(listed, i, j, begin[i], end[i]) else (1.0 if constant else 0.0)


def assert_same_effect(signals, effect, momentum, torque, where):
    """Compare compiled signals (T, m, SIGNALS) with effects, where a mask (T, m) says so."""
    locked, delay, effectiveness, bias, forward, backward, brake = np.moveaxis(signals[:, :, :7], 2, 0)
    stuck = (locked > 0.5) | (brake > 0.0)
    dry = FRICTION.dry(momentum / 0.02)
    excess = (np.where(momentum > 0.0, forward, backward) - 1.0) * dry
    expected = np.where(stuck, 0.0, effectiveness), np.where(stuck, torque, bias + excess), delay
    for name, value in zip(("effectiveness", "bias", "delay"), expected, strict=True):
        np.testing.assert_allclose(getattr(effect, name)[where], value[where], rtol=1e-11, atol=1e-12, err_msg=name)


def test_the_strategies_cover_every_kind():
    assert set(MAGNITUDES) == set(faults.KINDS)


@pytest.mark.parametrize("kind", faults.KINDS, ids=lambda kind: kind.__name__)
@settings(max_examples=20, deadline=None, derandomize=True)
@given(data=st.data(), seed=st.integers(0, 2**32))
def test_every_kind_acts_alike(kind, data, seed):
    check(data.draw(st.lists(faults_of(kind), min_size=1, max_size=2)), seed)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(data=st.data(), seed=st.integers(0, 2**32))
def test_any_faults_together_act_alike(data, seed):
    kinds = data.draw(st.lists(st.sampled_from(faults.KINDS), min_size=2, max_size=5))
    check([data.draw(faults_of(kind)) for kind in kinds], seed)


def check(listed, seed):
    drawn, times = drawn_at_times(listed, seed)
    count = len(times)
    for records in (drawn.wheels.reshape(count, -1), drawn.sensors):
        part = np.zeros(records.shape)
        compiled_presence(records, drawn.switches, times, part)
        np.testing.assert_allclose(presence(records, drawn.switches, times), part, rtol=0.0, atol=1e-12)
    random = np.random.default_rng(seed + 1)
    momentum, torque = random.uniform(-4.0, 4.0, (count, 2)), random.uniform(-0.2, 0.2, (count, 2))
    effect = faults.fault_effect(drawn, times, WHEELS, momentum, torque)
    everywhere = np.ones((count, 2), dtype=bool)
    signals = np.zeros((count, 2, SIGNALS))
    compiled_signals(drawn.wheels, drawn.switches, times, signals)
    assert_same_effect(signals, effect, momentum, torque, everywhere)
    # `part` is that of the sensors' faults.
    np.testing.assert_allclose(effect.rate_bias, np.einsum("nk,nki->ni", part, drawn.sensors["rate_bias"]), atol=1e-12)
    turn = np.einsum("nk,nki->ni", part, drawn.sensors["attitude_turn"])
    np.testing.assert_allclose(effect.attitude_turn, turn, atol=1e-12)
    out = ((part > 0.0) & (drawn.sensors["outage"] > 0.5)).any(axis=1)
    np.testing.assert_array_equal(effect.star_tracker_out, out)
    # Shortcuts of the plant: a time span without a change, and one without any fault.
    length = random.uniform(0.0, 1.0, count)
    share = random.random(count)
    compiled_constants(drawn.wheels, times - share * length, times + (1.0 - share) * length, signals)
    assert_same_effect(signals, effect, momentum, torque, signals[:, :, 7] > 0.0)
    healthy = signals[:, :, 7] == 2.0
    assert np.all(effect.effectiveness[healthy] == 1.0) and np.all(effect.bias[healthy] == 0.0)


def test_a_chain_that_has_run_out_of_flips_acts_alike():
    drawn, times = drawn_at_times([faults.Outage(wheel=0, mean_acting=1.0, mean_resting=1.0)], 3)
    assert drawn.switches.shape[2] == FLIPS
    drawn.switches[:] = np.linspace(0.0, 3.0, FLIPS)
    part = np.zeros((len(times), 2))
    compiled_presence(drawn.wheels.reshape(len(times), -1), drawn.switches, times, part)
    np.testing.assert_array_equal(part, presence(drawn.wheels, drawn.switches, times)[:, :, 0])
    assert set(part[:, 0]) == {0.0, 1.0}
