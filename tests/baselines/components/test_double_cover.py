"""The error on the double cover: continuous whatever the sensor's sign, and turned the short way round."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from ftac_gym import baselines, scenarios
from ftac_gym.attitude import quaternion_from_rotation_vector, random_quaternion_from_uniforms
from ftac_gym.baselines.components.double_cover import HybridError
from ftac_gym.baselines.memory import Memory
from ftac_gym.dynamics import Simulator
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.references import fixed_attitude

ETA = 0.1


def normalised(numbers):
    return np.array(numbers) / np.linalg.norm(numbers)


quaternions = (
    st.lists(st.floats(-1.0, 1.0), min_size=4, max_size=4).filter(lambda q: np.linalg.norm(q) > 0.1).map(normalised)
)
etas = st.floats(0.01, 0.99)
paths = st.lists(quaternions, min_size=1, max_size=15)


def hybrid(eta, count=1):
    return HybridError(Memory(count), eta)


def followed(eta, path):
    """Lifted errors (T, 4) and h (T,) along errors (T, 4) of one spacecraft."""
    error = hybrid(eta)
    results = [error.update(np.array(q)[None]) for q in path]
    return np.array([lifted[0] for lifted, _ in results]), np.array([logic[0, 0] for _, logic in results])


@given(eta=etas, path=paths)
def test_the_lifted_error_is_the_one_of_the_two_nearer_to_the_last(eta, path):
    lifted, _ = followed(eta, path)
    np.testing.assert_array_equal(lifted[0], path[0])
    for last, now, given_one in zip(lifted[:-1], lifted[1:], path[1:], strict=True):
        assert np.array_equal(now, given_one) or np.array_equal(now, -given_one)
        assert np.linalg.norm(now - last) <= np.linalg.norm(now + last) + 1e-12


@given(eta=etas, path=paths)
def test_h_jumps_in_the_jump_set_and_nowhere_else(eta, path):
    lifted, logic = followed(eta, path)
    assert (np.abs(logic) == 1.0).all()
    last = np.append(1.0, logic[:-1])
    np.testing.assert_array_equal(logic != last, last * lifted[:, 0] <= -eta)
    assert (logic * lifted[:, 0] > -eta).all()


def test_the_edge_of_the_jump_set_belongs_to_it():
    rest = math.sqrt(0.75)
    assert followed(0.5, [[-0.5, rest, 0.0, 0.0]])[1] == -1.0
    assert followed(0.5, [[-np.nextafter(0.5, 0.0), rest, 0.0, 0.0]])[1] == 1.0
    lifted, logic = followed(0.5, [[0.3, rest, 0.5, 0.0], [-0.5, rest, 0.0, 0.0], [0.4, rest, 0.4, 0.0]])
    np.testing.assert_array_equal(logic, [1.0, -1.0, -1.0])
    np.testing.assert_array_equal(lifted[:, 0], [0.3, -0.5, 0.4])


@given(eta=st.none() | etas, path=paths, data=st.data())
def test_the_sign_of_the_sensor_only_matters_at_the_first_call(eta, path, data):
    for last, now in pairwise(path):
        assume(abs(last @ now) > 1e-9)  # half a turn between two calls has no nearer sign
    signs = data.draw(st.lists(st.sampled_from([1.0, -1.0]), min_size=len(path), max_size=len(path)), label="signs")
    signs[0] = 1.0
    lifted, logic = followed(eta, path)
    flipped, same = followed(eta, [sign * q for sign, q in zip(signs, path, strict=True)])
    np.testing.assert_array_equal(flipped, lifted)
    np.testing.assert_array_equal(same, logic)
    if eta is not None and abs(path[0][0]) > eta:  # and with a hysteresis, outside of it, not even there
        other, opposite = followed(eta, [-q for q in path])
        np.testing.assert_array_equal(opposite[:, None] * other, logic[:, None] * lifted)


@given(eta=etas, path=paths)
def test_the_way_that_h_e_v_takes_is_at_most_4_asin_eta_longer_than_the_short_one(eta, path):
    lifted, logic = followed(eta, path)
    way, short = 2.0 * np.arccos(logic * lifted[:, 0]), 2.0 * np.arccos(np.abs(lifted[:, 0]))
    assert (way <= short + 4.0 * math.asin(eta) + 1e-7).all()


def test_without_a_hysteresis_h_stays_one():
    path = [quaternion_from_rotation_vector(np.array([angle, 0.0, 0.0])) for angle in np.linspace(0.0, 12.0, 60)]
    lifted, logic = followed(None, path)
    np.testing.assert_array_equal(logic, 1.0)
    assert np.linalg.norm(np.diff(lifted, axis=0), axis=1).max() < 0.11  # through two signs of e_4 without a jump
    assert lifted[:, 0].min() < -0.99
    _, logic = followed(ETA, path)
    assert (np.diff(logic) != 0.0).sum() == 2  # at 191 and 551 degrees


def test_peeking_is_what_the_next_update_says_and_changes_nothing():
    random = np.random.default_rng(0)
    error = hybrid(ETA, 20)
    for _ in range(10):
        q = random_quaternion_from_uniforms(random.random((20, 3))) * random.choice([-1.0, 1.0], (20, 1))
        peeked, again, updated = error.peek(q), error.peek(q), error.update(q)
        for first, second, third in zip(peeked, again, updated, strict=True):
            np.testing.assert_array_equal(first, second)
            np.testing.assert_array_equal(first, third)


def test_a_reset_craft_takes_the_sign_it_is_given_and_the_others_go_on():
    memory = Memory(3)
    error = HybridError(memory, ETA)
    error.update(np.tile([-0.8, 0.6, 0.0, 0.0], (3, 1)))
    memory.reset(np.array([False, True, False]))
    lifted, logic = error.update(np.tile([0.8, -0.6, 0.0, 0.0], (3, 1)))
    np.testing.assert_array_equal(logic[:, 0], [-1.0, 1.0, -1.0])
    np.testing.assert_array_equal(lifted[:, 0], [-0.8, 0.8, -0.8])


@pytest.mark.parametrize("eta", [0.0, 1.0, -0.1, 1.5])
def test_a_hysteresis_outside_its_range(eta):
    with pytest.raises(ValueError, match=r"^hysteresis must lie within \(0, 1\), got "):
        hybrid(eta)


def test_a_hysteresis_that_is_no_number():
    with pytest.raises(ValueError, match=r"^hysteresis must be finite"):
        hybrid(math.nan)


# ----------------------------------------------------------------------------------------------------------- flights

COUNT, STEPS = 60, 400
RESTING = scenarios.get("ma_2023_unwinding").replace(
    reference=fixed_attitude(), disturbance=None, initial_state=InitialState(), control_period=0.05, physics_step=0.025
)
ONE = {"smallest_effectiveness": 1.0}
LAWS = {
    "hsfc": ("hsfc", ONE),
    "hsfc, wider": ("hsfc", {**ONE, "hysteresis": 0.4}),
    "hsfc_floor": ("hsfc_floor", {}),
    "shopd_plus": ("shopd_plus", {}),
    "shopd_plus_zero_filter": ("shopd_plus_zero_filter", {}),
    "afntsmc": ("afntsmc", {"hysteresis": ETA}),
}


def flown(name, **gains):
    """True q_e (T, N, 4), continuous in time, of spacecraft that start at rest, their quaternions of both signs."""
    simulator, law = Simulator(RESTING, COUNT), baselines.make(name, RESTING, COUNT, **gains)
    episodes = RESTING.draw(3, COUNT)
    episodes.initial["attitude"] = random_quaternion_from_uniforms(np.random.default_rng(4).random((COUNT, 3)))
    episodes.initial["attitude"][: COUNT // 2] *= -1.0
    simulator.reset(episodes)
    path = [simulator.state.attitude.copy()]
    for _ in range(STEPS):
        simulator.step(law.act(simulator.measurement()))
        now, last = simulator.state.attitude, path[-1]
        path.append(np.where((now * last).sum(axis=1, keepdims=True) < 0.0, -now, now))
    return np.array(path)


def stays_on_the_short_way(path):
    """(N,) whether a spacecraft is never further from the nearer of the two goals than it was at its start at rest.

    That is stronger than h e_4 > -eta: h e_4 is a potential energy, and at rest there is no other. A damped spacecraft
    therefore returns neither to its start nor to the jump set of h.
    """
    nearer = np.sign(path[0, :, 0]) * path[:, :, 0]
    return (nearer >= nearer[0] - 1e-9).all(axis=0) & (nearer[1] > nearer[0])


@pytest.mark.parametrize("case", LAWS)
def test_a_craft_at_rest_goes_the_short_way_whatever_its_quaternion_s_sign(case):
    name, gains = LAWS[case]
    path = flown(name, **gains)
    outside = np.abs(path[0, :, 0]) > gains.get("hysteresis", ETA)
    negative = path[0, :, 0] < 0.0
    assert (outside & negative).sum() > 10 and (outside & ~negative).sum() > 10
    assert stays_on_the_short_way(path)[outside].all()


@pytest.mark.parametrize("case", LAWS)
def test_without_a_hysteresis_a_craft_goes_the_long_way_if_its_quaternion_says_so(case):
    """The check of the last test fails for a law whose h is frozen: for every spacecraft that starts with e_4 < 0."""
    name, gains = LAWS[case]
    path = flown(name, **{**gains, "hysteresis": None})
    negative = path[0, :, 0] < 0.0
    fine = stays_on_the_short_way(path)
    assert fine[~negative].all() and not fine[negative].any()


@pytest.mark.parametrize("hysteresis", [ETA, None])
def test_unwinding_is_the_long_way_round(hysteresis):
    """From 60 degrees to the attitude that it is 60 degrees from, by way of 180."""
    scenario = RESTING.replace(initial_state=InitialState.fixed((-math.sqrt(0.75), 0.5, 0.0, 0.0)))
    simulator, law = Simulator(scenario, 1), baselines.make("shopd_plus", scenario, hysteresis=hysteresis)
    simulator.reset(scenario.draw(0, 1))
    angles, turned = [], 0.0
    for _ in range(800):
        angles.append(2.0 * math.degrees(math.acos(min(1.0, abs(simulator.state.attitude[0, 0])))))
        simulator.step(law.act(simulator.measurement()))
        turned += math.degrees(np.linalg.norm(simulator.state.rate)) * scenario.control_period
    assert angles[0] == pytest.approx(60.0) and angles[-1] < 10.0
    if hysteresis is None:
        assert max(angles) > 178.0 and turned > 300.0
    else:
        assert max(angles) < 60.01 and turned < 240.0


@pytest.mark.parametrize("name", ["hsfc", "hsfc_componentwise", "afntsmc", "shopd_plus", "shopd_plus_zero_filter"])
@pytest.mark.parametrize("filter_time", [0.0, 0.3])
def test_a_sensor_that_changes_its_sign_changes_no_command(name, filter_time):
    scenario = scenarios.get("ma_2023_faulty").replace(control_period=0.05)
    gains = {"attitude_filter_time": filter_time}
    law, other = (baselines.make(name, scenario, **gains) for _ in range(2))
    simulator, random, flips = Simulator(scenario, 1), np.random.default_rng(5), 0
    simulator.reset(scenario.draw(0, 1))
    for step in range(40):
        measurement = simulator.measurement()
        sign = random.choice([-1.0, 1.0]) if step else 1.0
        flips += sign < 0.0
        command = law.act(measurement)
        seen = replace(measurement, attitude=sign * measurement.attitude)
        np.testing.assert_allclose(other.act(seen), command, rtol=0.0, atol=1e-11)
        simulator.step(command)
    assert flips > 10
