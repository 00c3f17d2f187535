"""The bounds that the saturated laws prove: no component of the torque exceeds them, and some reach them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ftac_gym import baselines, scenarios
from ftac_gym.spacecraft.spacecraft import Spacecraft
from ftac_gym.spacecraft.wheel_array import WheelArray
from ftac_gym.task.measurement import Measurement

MA, SHEN = scenarios.get("ma_2023_faulty"), scenarios.get("shen_2019")
# Three wheels along the axes that give any torque: what is commanded is what the law demands.
FREE = MA.replace(spacecraft=Spacecraft(MA.spacecraft.inertia, WheelArray(np.eye(3).tolist(), 1e9)))
C1, C2 = 5e-2, 4.71e-3  # rad/s, rad/s^2, Eq. (44)
LARGEST_INERTIA = 22.7995  # kg m^2, J_M
COUNT = 6
HSFC = ("hsfc", "hsfc_componentwise", "hsfc_sliding", "hsfc_floor")


def make(name, count=COUNT, **gains):
    """A law for wheels without a limit; hsfc_sliding is hsfc with u2 along S."""
    if name == "hsfc_sliding":
        name, gains = "hsfc", {"compensation": "sliding", **gains}
    return baselines.make(name, FREE, count, **gains)


def seen(attitude, rate, reference_rate=(0.0, 0.0, 0.0), reference_acceleration=(0.0, 0.0, 0.0), wheels=3):
    """A measurement of spacecraft with these attitudes and rates; the reference is the identity and turns."""
    attitude = np.atleast_2d(np.array(attitude, dtype=float))
    count = len(attitude)
    identity, none = np.tile([1.0, 0.0, 0.0, 0.0], (count, 1)), np.zeros((count, wheels))
    rate, turning, change = (
        np.broadcast_to(np.array(part, dtype=float), (count, 3))
        for part in (rate, reference_rate, reference_acceleration)
    )
    return Measurement(np.zeros(count), attitude, rate, none, none, np.ones(count, bool), identity, turning, change)


def unit(random, columns, largest=1.0):
    """Vectors (COUNT, columns) of length ``largest``; the first along an axis, the second along a diagonal."""
    vectors = random.normal(size=(COUNT, columns))
    vectors[0] = np.eye(columns)[random.integers(columns)] * random.choice([-1.0, 1.0])
    vectors[1] = random.choice([-1.0, 1.0], columns)
    return largest * vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def logarithmic(low, high):
    return st.floats(np.log10(low), np.log10(high)).map(lambda power: float(10.0**power))


etas = st.none() | st.floats(0.01, 0.99)
hsfc_gains = st.fixed_dictionaries(
    {
        "gain": logarithmic(1e-2, 1e2), "attitude_gain": st.floats(0.0, 50.0), "adaptation": logarithmic(1e-4, 1.0),
        "smoothing": logarithmic(1e-3, 0.99), "smallest_effectiveness": st.floats(0.05, 1.0),
        "layer": st.just(0.0) | logarithmic(1e-6, 1.0), "initial_gamma": logarithmic(1e-3, 10.0), "hysteresis": etas,
        "gamma_floor": st.floats(0.0, 3.0),
    }
)  # fmt: skip
shopd_gains = st.fixed_dictionaries(
    {
        "gain": logarithmic(1e-2, 1e3), "damping": logarithmic(1e-2, 1e3), "filter_rate": logarithmic(1e-2, 1e2),
        "filter_gain": logarithmic(1e-2, 1e3), "hysteresis": etas,
    }
)  # fmt: skip
situations = st.fixed_dictionaries(
    {
        "seed": st.integers(0, 2**32 - 1), "calls": st.integers(1, 6), "speed": st.just(0.0) | logarithmic(1e-6, 30.0),
        "c1": st.just(0.0) | logarithmic(1e-3, 3.0), "c2": st.just(0.0) | logarithmic(1e-3, 3.0),
    }
)  # fmt: skip


def demands(law, seed, calls, speed, c1, c2):
    """Torques (calls, COUNT, 3) on the body, between errors that jump about."""
    random, torques = np.random.default_rng(seed), []
    for _ in range(calls):
        measurement = seen(
            unit(random, 4), speed * random.normal(size=(COUNT, 3)), unit(random, 3, c1), unit(random, 3, c2)
        )
        torques.append(law.act(measurement))
    return np.array(torques)


@pytest.mark.parametrize("name", HSFC)
@settings(deadline=None, max_examples=40)
@given(gains=hsfc_gains, situation=situations)
def test_hsfc_keeps_its_bound(name, gains, situation):
    law = make(name, **gains)
    bound = law.torque_bound(situation["c1"], situation["c2"])
    assert (np.abs(demands(law, **situation)) <= bound * (1.0 + 1e-9)).all()


@pytest.mark.parametrize("name", ["shopd_plus", "shopd_plus_zero_filter"])
@settings(deadline=None, max_examples=40)
@given(gains=shopd_gains, situation=situations)
def test_shopd_plus_keeps_its_bound(name, gains, situation):
    law = make(name, **gains)
    bound = law.torque_bound(situation["c1"], situation["c2"])
    assert (np.abs(demands(law, **situation)) <= bound * (1.0 + 1e-9)).all()


@settings(deadline=None, max_examples=40)
@given(
    situation=situations,
    gains=st.fixed_dictionaries(
        {
            "gain": logarithmic(1e-2, 1e4), "adaptation": logarithmic(1e-3, 1e2), "forgetting": st.floats(0.0, 10.0),
            "smoothing": logarithmic(1e-4, 1.0), "regularisation": logarithmic(1e-3, 1.0),
            "monitor_gain": st.just(0.0) | logarithmic(0.1, 1e3), "monitor_threshold": logarithmic(1e-6, 1.0),
        }
    ),
)  # fmt: skip
def test_shen_class_keeps_its_limit(gains, situation):
    """|u| <= u_max over all wheels together, and |D u| <= u_max / |D^+|."""
    wheels = SHEN.spacecraft.wheels
    limit, axes = wheels.torque_limits.min(), wheels.axis_matrix
    law, random = baselines.make("shen_class", SHEN, COUNT, **gains), np.random.default_rng(situation["seed"])
    for _ in range(situation["calls"]):
        rate = situation["speed"] * random.normal(size=(COUNT, 3))
        command = law.act(seen(unit(random, 4), rate, wheels=4))
        assert (np.linalg.norm(command, axis=1) <= limit * (1.0 + 1e-9)).all()
        reach = limit / np.linalg.norm(np.linalg.pinv(axes), 2)
        assert (np.linalg.norm(command @ axes.T, axis=1) <= reach * (1.0 + 1e-9)).all()


@pytest.mark.parametrize("name", HSFC)
def test_a_body_that_turns_fast_reaches_the_bound_of_hsfc(name):
    """All components of S and w_e far outside of their layers: the bound is no larger than it must be."""
    law = make(name, 1)
    reached = np.abs(law.act(seen([1.0, 0.0, 0.0, 0.0], [1e5, 1e5, 1e5])))
    np.testing.assert_allclose(reached, law.torque_bound(), rtol=1e-4)


def test_a_turned_body_whose_error_has_just_changed_reaches_the_bound_of_shopd_plus():
    """k4 |e_1| + k5 (|e_4| + |e_2| + |e_3|) is at most sqrt(k4^2 + 3 k5^2)."""
    sharpest = np.hypot(30.0, np.sqrt(3.0) * 8.0)
    small = 8.0 / sharpest
    now = np.array([small, 30.0 / sharpest, small, small])
    before = np.append(0.0, now[1:] - np.array([0.4, 0.4, -0.4]))  # 3 (e_v - e_v before) saturates
    before[0] = np.sqrt(1.0 - before[1:] @ before[1:])
    law = make("shopd_plus", 1)
    law.act(seen(before, np.zeros(3)))
    torque = law.act(seen(now, np.zeros(3)))[0]
    assert abs(torque[0]) == pytest.approx(sharpest, rel=1e-9)
    assert law.torque_bound() == pytest.approx(sharpest, rel=1e-12)


def printed(effectiveness, gain=5.0):
    """(21)."""
    return (gain + LARGEST_INERTIA * (C1**2 + C2)) / effectiveness


def test_the_numbers_of_the_paper_and_what_they_must_be():
    assert np.linalg.norm(MA.spacecraft.inertia_matrix, 2) == pytest.approx(LARGEST_INERTIA, abs=5e-5)
    assert printed(0.2) == pytest.approx(25.8, abs=0.05) and printed(0.6) == pytest.approx(8.607, abs=5e-4)
    bounds = [make("hsfc", smallest_effectiveness=share).torque_bound(C1, C2) for share in (0.2, 0.6, 1.0)]
    np.testing.assert_allclose(bounds, [40.5, 11.05, printed(1.0)], rtol=1e-3)
    assert make("hsfc").torque_bound(C1, C2) == bounds[0]  # printed is g0 = 0.2
    assert make("hsfc_sliding").torque_bound(C1, C2) == bounds[0]


@pytest.mark.parametrize("share", [0.05, 0.2, 0.6, 1.0])
def test_the_bound_of_the_componentwise_form_is_the_printed_one(share):
    law = make("hsfc_componentwise", smallest_effectiveness=share)
    assert law.torque_bound(C1, C2) == pytest.approx(printed(share), rel=1e-5)


def test_the_printed_law_exceeds_the_printed_bound():
    """At rates that a spacecraft has: all three wheels beyond (21), and beyond the 10 N m of the wheels."""
    measurement = seen([0.9, 0.25, 0.25, 0.25] / np.linalg.norm([0.9, 0.25, 0.25, 0.25]), [0.05, 0.05, 0.05])
    torque = np.abs(make("hsfc", 1).act(measurement))
    assert (torque > 1.25 * printed(0.2)).all()
    own = np.abs(make("hsfc_componentwise", 1, smallest_effectiveness=0.2).act(measurement))
    assert (own > 20.0).all() and (own < printed(0.2)).all()


@pytest.mark.parametrize("name", ["hsfc", "shopd_plus"])
@pytest.mark.parametrize(
    ("values", "message"), [((-1.0, 0.0), "rate must not be negative"), ((0.0, -1.0), "acceleration must not be")]
)
def test_a_bound_is_for_magnitudes(name, values, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        make(name).torque_bound(*values)
