"""Tests of `task.external_torque`: several disturbances are their sum, in the records and in flight."""

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ftac_gym import Simulator, scenarios
from ftac_gym.task import Disturbance, Harmonic, LowOrbitTorque, Scenario
from ftac_gym.task.external_torque import ExternalTorque

FLAGSHIP = scenarios.get("flagship")
CALM = FLAGSHIP.replace(faults=None, sensors=None, inertia_uncertainty=None, duration=10.0)
FIRST = Disturbance((1e-3, -2e-3, 0.0), (Harmonic((1e-3, 2e-3, 3e-3), 0.7, (0.1, 0.2, 0.3)),))
SECOND = Disturbance((0.0, 5e-3, 1e-3), (Harmonic((2e-3,) * 3, 1.3), Harmonic((0.0, 0.0, 1e-3), 2.0)))
SUM = Disturbance((1e-3, 3e-3, 1e-3), (*FIRST.harmonics, *SECOND.harmonics))
RANDOM = Disturbance(((-1e-3, 1e-3),) * 3, (Harmonic(((0.0, 1e-3),) * 3, (0.1, 1.0), ((0.0, 6.0),) * 3),))


def flown(scenario, seed=3, count=4):
    """Attitude and rate at the end of a flight without commands."""
    simulator = Simulator(scenario, count)
    simulator.reset(scenario.draw(seed, count))
    for _ in range(scenario.horizon):
        simulator.step(np.zeros((count, 4)))
    measured = simulator.measurement()
    return np.concatenate([measured.attitude, measured.rate], axis=1)


def test_the_sum_by_hand():
    episodes = CALM.replace(disturbance=(FIRST, SECOND)).draw(0, 2)
    np.testing.assert_allclose(episodes.disturbance["constant"], [[1e-3, 3e-3, 1e-3]] * 2, rtol=1e-15)
    np.testing.assert_array_equal(episodes.harmonics["frequency"], [[0.7, 1.3, 2.0]] * 2)
    np.testing.assert_allclose(episodes.harmonics["sine"][0, 0], [1e-3, 2e-3, 3e-3] * np.cos([0.1, 0.2, 0.3]))


def test_two_disturbances_fly_as_one_with_the_summed_torque():
    apart, together = flown(CALM.replace(disturbance=(FIRST, SECOND))), flown(CALM.replace(disturbance=SUM))
    np.testing.assert_allclose(apart, together, rtol=0.0, atol=1e-15)
    assert np.abs(together - flown(CALM.replace(disturbance=FIRST))).max() > 1e-4


def test_a_disturbance_is_drawn_the_same_with_and_without_others_behind_it():
    for first in (RANDOM, LowOrbitTorque()):
        alone = FLAGSHIP.replace(disturbance=first).draw(5, 20)
        more = FLAGSHIP.replace(disturbance=(first, RANDOM)).draw(5, 20)
        kept = alone.harmonics.shape[1]
        np.testing.assert_array_equal(more.harmonics[:, :kept], alone.harmonics)
        assert more.harmonics.shape[1] == kept + 1
        # The second one draws numbers of its own.
        added = more.disturbance["constant"] - alone.disturbance["constant"]
        assert np.abs(added).max() < 1e-3
        assert np.abs(np.corrcoef(added.ravel(), alone.disturbance["constant"].ravel())[0, 1]) < 0.4


def test_one_disturbance_in_a_tuple_is_the_disturbance():
    single = FLAGSHIP.replace(disturbance=(RANDOM,))
    assert single.disturbance == RANDOM
    assert single.draw(1, 3).digest() == FLAGSHIP.replace(disturbance=RANDOM).draw(1, 3).digest()


def test_equal_factors_of_the_rate_add_up():
    first, second = (Disturbance((size, 0.0, 0.0), rate_offset=0.5) for size in (1e-3, 2e-3))
    summed = Disturbance((3e-3, 0.0, 0.0), rate_offset=0.5)
    apart, together = (flown(CALM.replace(disturbance=torque)) for torque in ((first, second), summed))
    np.testing.assert_allclose(apart, together, rtol=0.0, atol=1e-15)


def test_bounds_add_up():
    low = LowOrbitTorque()
    torque = ExternalTorque.of((FIRST, SECOND, low))
    expected = FIRST.largest_torque(20.0) + SECOND.largest_torque(20.0) + low.largest_torque(20.0)
    assert torque.largest_torque(20.0) == pytest.approx(expected, rel=1e-15)
    assert ExternalTorque.of((FIRST, SECOND)).swing(9.0) == pytest.approx(FIRST.swing(9.0) + SECOND.swing(9.0))
    nothing = ExternalTorque.of(None)
    assert nothing.largest_torque(20.0) == 0.0 and nothing.swing(9.0) == 0.0 and nothing.rate_offset is None


def test_the_label_knows_the_sum():
    half, whole = (Disturbance((size, 0.0, 0.0)) for size in (0.15, 0.3))  # of 27.7 N m s, they need 18 and 36
    both = CALM.replace(duration=120.0, disturbance=(half, half)).draw(0, 50)
    one = CALM.replace(duration=120.0, disturbance=whole).draw(0, 50)
    np.testing.assert_array_equal(both.feasible, one.feasible)
    assert both.feasible.sum() < CALM.replace(duration=120.0, disturbance=half).draw(0, 50).feasible.sum()


sizes = st.floats(-1e-3, 1e-3)
sources = st.one_of(
    st.builds(LowOrbitTorque, residual_dipole=st.floats(0.0, 2.0)),
    st.builds(
        lambda size, waves: Disturbance((size, 0.0, size), tuple(Harmonic((wave,) * 3, 0.5) for wave in waves)),
        sizes,
        st.lists(sizes, max_size=3),
    ),
)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(st.lists(sources, min_size=1, max_size=4))
def test_any_list_of_disturbances_survives_json(listed):
    scenario = FLAGSHIP.replace(disturbance=listed)
    again = Scenario.from_dict(json.loads(scenario.to_json()))
    assert again == scenario and again.to_json() == scenario.to_json()
    assert again.draw(1, 2).digest() == scenario.draw(1, 2).digest()


def test_short_forms():
    listed = FLAGSHIP.replace(disturbance=[FIRST, {"type": "LowOrbitTorque", "altitude": 500e3}])
    assert listed.disturbance == (FIRST, LowOrbitTorque(altitude=500e3))
    assert listed.replace(disturbance=None).disturbance is None
    with pytest.raises(ValueError, match=r"disturbance\.type must be one of \['Disturbance', 'LowOrbitTorque'\]"):
        listed.replace(disturbance={"constant": (0.0, 0.0, 0.0)})


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ((), "disturbance must hold one disturbance or more; None is for none"),
        ("drag", "disturbance must be a Disturbance or LowOrbitTorque or None, or a tuple"),
        ((FIRST, 0.1), r"disturbance\[1\] must be a Disturbance or LowOrbitTorque, got 0.1"),
        ((FIRST, None), r"disturbance\[1\] must be"),
        ([FIRST, {"type": "Outage"}], r"disturbance\[1\] must describe a Disturbance or LowOrbitTorque"),
        ((FIRST, Disturbance(rate_offset=0.1)), r"disturbance\[1\]\.rate_offset must be None, as that of"),
        ((Disturbance(rate_offset=0.1), LowOrbitTorque()), r"disturbance\[1\]\.rate_offset must be 0\.1"),
        (
            (FIRST, Disturbance(harmonics=(Harmonic((1e-3,) * 3, 1e3),))),
            r"disturbance\[1\]\.harmonics\[0\]\.frequency must be at most",
        ),
        ((FIRST, Disturbance((1e6, 0.0, 0.0))), "physics_step must be at most"),
    ],
)
def test_what_is_refused(value, message):
    with pytest.raises(ValueError, match=message):
        FLAGSHIP.replace(disturbance=value)


def test_saved_episodes_with_several_disturbances_load(tmp_path):
    episodes = FLAGSHIP.replace(disturbance=(RANDOM, LowOrbitTorque())).draw(2, 5)
    episodes.save(tmp_path / "episodes.npz")
    assert type(episodes).load(tmp_path / "episodes.npz").digest() == episodes.digest()
