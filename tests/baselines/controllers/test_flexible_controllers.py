"""The laws of Li et al. 2023 for one spacecraft after another, against formulas written again from the paper."""

import numpy as np
import pytest
from helpers.flexible_cases import FLEXIBLE, LI, MOVING, drawn, each, free
from helpers.flexible_spacecraft import random_appendages
from helpers.fuzzy_laws import FixedTime, Integral, Law
from helpers.laws import NominalModel
from hypothesis import given, settings
from hypothesis import strategies as st

from ftac_gym import baselines
from ftac_gym.baselines import synthesis
from ftac_gym.spacecraft.spacecraft import Spacecraft
from ftac_gym.task.measurement import Measurement

SEEDS = st.integers(0, 2**32 - 1)


def gains_of(scenario, design="published"):
    return synthesis.gains(scenario.spacecraft, design).controller.feedback


def close(command, expected):
    np.testing.assert_allclose(command, expected, rtol=0.0, atol=1e-11 * np.abs(expected).max())


MEMORYLESS = {
    "fuzzy_smc": ("fuzzy_smc", {"faults": "none", "observer": None}, {}, {}),
    "fuzzy_smc, other numbers": (
        "fuzzy_smc",
        {"faults": "none", "observer": None, "slope": 0.7, "linear": 3.0, "switching": 2.0, "layer": 0.05},
        {"beta": 0.7}, {"sigma1": 3.0, "sigma2": 2.0, "layer": 0.05},
    ),
    "fuzzy_smc, short way": (
        "fuzzy_smc", {"faults": "none", "observer": None, "short_way": True}, {"short_way": True}, {},
    ),
    "fuzzy_pd": ("fuzzy_pd", {"faults": "none", "observer": None}, {}, {}),
    "fuzzy_pd, other numbers": (
        "fuzzy_pd",
        {"faults": "none", "observer": None, "slope": 0.3, "position_gain": 7.0, "rate_gain": 11.0, "short_way": True},
        {"beta": 0.3, "short_way": True}, {"kp": 7.0, "kd": 11.0},
    ),
    "fuzzy_pd_gyroscopic": ("fuzzy_pd_gyroscopic", {"faults": "none", "observer": None}, {}, {"whole": False}),
}  # fmt: skip


@pytest.mark.parametrize("reference", [MOVING, LI.reference], ids=["moving", "at rest"])
@pytest.mark.parametrize("case", MEMORYLESS)
@settings(deadline=None, max_examples=15)
@given(seed=SEEDS, rate=st.sampled_from([0.05, 0.6, 2.0]))
def test_torque_is_that_of_the_printed_law(case, reference, seed, rate):
    name, options, theirs, numbers = MEMORYLESS[case]
    scenario = free(reference)
    measurement = drawn(scenario, seed, rate=rate)
    law = baselines.make(name, scenario, num_spacecraft=6, **options)
    again = Law(scenario.spacecraft, feedback=gains_of(scenario), **theirs)
    torque = again.fuzzy_smc if name == "fuzzy_smc" else again.fuzzy_pd
    expected = np.array([torque(*state, **numbers) for state in each(measurement)])
    close(law.act(measurement), expected)
    close(law.sliding_variable(measurement), np.array([again.variable(*state) for state in each(measurement)]))


def test_feedback_can_be_a_share_and_need_not_be_scheduled():
    scenario = free()
    measurement, feedback = drawn(scenario, 3), gains_of(scenario)
    for options, theirs in (
        ({"feedback_share": 2.5}, 2.5 * feedback),
        ({"scheduled": False}, np.tile(feedback.mean(axis=0), (8, 1, 1))),
    ):
        law = baselines.make("fuzzy_smc", scenario, num_spacecraft=6, faults="none", observer=None, **options)
        again = Law(scenario.spacecraft, feedback=theirs)
        close(law.act(measurement), np.array([again.fuzzy_smc(*state) for state in each(measurement)]))


@pytest.mark.parametrize("name", ["aismc", "raftsmc_class"])
@pytest.mark.parametrize("short_way", [False, True])
@pytest.mark.parametrize("reference", [MOVING, LI.reference], ids=["moving", "at rest"])
def test_laws_with_a_memory_along_random_walks(name, short_way, reference):
    scenario, count = free(reference), 4
    law = baselines.make(name, scenario, num_spacecraft=count, short_way=short_way)
    kind, others = (Integral, {"feedback": gains_of(scenario)}) if name == "aismc" else (FixedTime, {})
    again = [kind(scenario.spacecraft, short_way=short_way, period=0.05, **others) for _ in range(count)]
    for step in range(40):
        measurement = drawn(scenario, step, count)
        if step == 25:  # one of them starts anew
            law.reset(np.array([False, True, False, False]))
            again[1] = kind(scenario.spacecraft, short_way=short_way, period=0.05, **others)
        expected = np.array([one.torque(*state) for one, state in zip(again, each(measurement), strict=True)])
        # The slope of the surface comes from differences there.
        tolerance = (1e-11 if name == "aismc" else 1e-7) * np.abs(expected).max()
        variable = np.array([one.variable(*state) for one, state in zip(again, each(measurement), strict=True)])
        close(law.sliding_variable(measurement), variable)
        np.testing.assert_allclose(law.act(measurement), expected, rtol=0.0, atol=tolerance)
    if name == "aismc":
        integral = np.array([np.trapezoid(one.slopes, dx=0.05, axis=0) for one in again])
        np.testing.assert_allclose(law.memory["integral"], integral, rtol=0.0, atol=1e-12)
    else:
        np.testing.assert_allclose(law.memory["bounds"], [one.bounds for one in again], rtol=1e-12)


def test_surface_of_raftsmc_near_zero():
    """On both sides of the bound, where the parabola takes over; its coefficients are the printed 8.8 and -252."""
    scenario, phi = free(LI.reference), 0.01
    law = baselines.make("raftsmc_class", scenario, num_spacecraft=7)
    x = phi * np.array([-1.001, -1.0, -0.3, 0.0, 0.5, 0.999, 1.001])
    value, slope = law._surface(np.tile(x[:, None], (1, 3)))
    expected = FixedTime.surface(x)
    np.testing.assert_allclose(value, np.tile(expected[:, None], (1, 3)), rtol=1e-12, atol=1e-15)
    step = 1e-9
    steep = (FixedTime.surface(x + step) - FixedTime.surface(x - step)) / (2.0 * step)
    steep[3] = 0.2 * 1.4 * phi**-0.4  # the power 1.2 has no second derivative at zero: differences are poor there
    np.testing.assert_allclose(slope[:, 0], steep, rtol=1e-5)
    rounded = 0.2 * (8.8 * 0.005 - 252.0 * 0.005**2) + 0.2 * 0.005**1.2
    assert value[4, 0] == pytest.approx(rounded, rel=5e-3)


@pytest.mark.parametrize("name", ["fuzzy_smc", "fuzzy_pd", "fuzzy_pd_gyroscopic", "fuzzy_smc_ilo_class"])
def test_estimates_are_taken_off(name):
    scenario = free()
    law, plain = (
        baselines.make(name, scenario, num_spacecraft=6, **options)
        for options in ({}, {"faults": "none", "observer": None})
    )
    for seed in range(10):
        measurement = drawn(scenario, seed, rate=0.05)
        command, without = law.act(measurement), plain.act(measurement)
    estimate = law.estimate
    off = estimate.disturbance + (0.0 if estimate.vibration is None else estimate.vibration)
    assert np.abs(estimate.disturbance).max() > 0.1
    assert (estimate.vibration is None) == (name == "fuzzy_smc_ilo_class")
    np.testing.assert_allclose(command, without - off, rtol=0.0, atol=1e-9 * np.abs(without).max())


@pytest.mark.parametrize("name", ["fuzzy_smc_solved", "aismc", "raftsmc_class"])
def test_four_wheels_share_the_torque_evenly(name):
    """The smallest largest wheel torque, and all scaled alike at the limit."""
    options = {"fuzzy_smc_solved": {"faults": "none"}, "aismc": {"design": "solved"}}.get(name, {})
    law = baselines.make(name, FLEXIBLE, num_spacecraft=6, filter="none", prediction=False, **options)
    model, limited = NominalModel(FLEXIBLE), 0
    kinds = {
        "fuzzy_smc_solved": (Law, {}),
        "aismc": (Integral, {"period": 0.1}),
        "raftsmc_class": (FixedTime, {"period": 0.1}),
    }
    kind, theirs = kinds[name]
    feedback = gains_of(FLEXIBLE, "solved")
    again = [
        kind(FLEXIBLE.spacecraft, short_way=options.get("short_way", name != "aismc"), feedback=feedback, **theirs)
        for _ in range(6)
    ]
    for seed, (rate, turn) in enumerate([(1e-3, 1e-3), (1e-4, 1e-4), (0.02, 0.5)]):
        measurement = drawn(FLEXIBLE, seed, rate=rate, turn=turn)
        command = law.act(measurement)
        for one, sent, state in zip(again, command, each(measurement), strict=True):
            torque = one.fuzzy_smc(*state) if kind is Law else one.torque(*state)
            wheels = model.minimax(torque)
            wheels = wheels * min(1.0, 0.2 / np.abs(wheels).max())
            limited += np.abs(wheels).max() > 0.2 - 1e-12
            np.testing.assert_allclose(sent, wheels, rtol=0.0, atol=1e-8)
    assert 3 <= limited <= 15


LIMITED = {
    "fuzzy_smc": LI, "fuzzy_smc_ilo_class": LI, "fuzzy_pd": LI, "fuzzy_pd_gyroscopic": LI, "aismc": LI,
    "raftsmc_class": LI, "fuzzy_smc_solved": FLEXIBLE,
}  # fmt: skip


@pytest.mark.parametrize("name", LIMITED)
@settings(deadline=None, max_examples=12)
@given(seed=SEEDS, rate=st.floats(1e-6, 3.0), turn=st.floats(1e-6, 10.0))
def test_limits(name, seed, rate, turn):
    scenario = LIMITED[name]
    limit, measurement = scenario.spacecraft.wheels.torque_limits, drawn(scenario, seed, rate=rate, turn=turn)
    each_one, together = (
        baselines.make(name, scenario, num_spacecraft=6, limit=kind).act(measurement) for kind in ("each", "sum")
    )
    assert (np.abs(each_one) <= limit * (1.0 + 1e-12)).all()
    assert (np.abs(together).sum(axis=1) <= limit.min() * (1.0 + 1e-12)).all()
    # What is within both limits is the same, and the sum is kept by scaling, not by clipping.
    small = np.abs(each_one).sum(axis=1) < limit.min()
    np.testing.assert_allclose(together[small], each_one[small], rtol=1e-12)
    unsaturated = (np.abs(each_one) < limit).all(axis=1)
    for whole, part in zip(each_one[unsaturated], together[unsaturated], strict=True):
        np.testing.assert_allclose(part * np.linalg.norm(whole), whole * np.linalg.norm(part), rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("name", ["fuzzy_smc", "fuzzy_pd", "fuzzy_pd_gyroscopic", "aismc", "raftsmc_class"])
def test_the_short_way_does_not_care_for_the_sign_of_the_quaternion(name):
    scenario = free()
    measurement = drawn(scenario, 1)
    turned = Measurement(**{**measurement.__dict__, "attitude": -measurement.attitude})
    for short_way in (True, False):
        one, other = (
            baselines.make(name, scenario, num_spacecraft=6, short_way=short_way).act(given)
            for given in (measurement, turned)
        )
        assert (np.abs(one - other).max() < 1e-12 * np.abs(one).max()) == short_way


# ----------------------------------------------------------------------------------------------------------- refusals


def rigid():
    return LI.replace(spacecraft=Spacecraft(LI.spacecraft.inertia, LI.spacecraft.wheels))


def two_modes():
    spacecraft = LI.spacecraft
    return LI.replace(spacecraft=Spacecraft(spacecraft.inertia, spacecraft.wheels, appendages=random_appendages(2)))


@pytest.mark.parametrize(
    ("name", "scenario", "options", "message"),
    [
        ("fuzzy_smc", rigid, {}, "appendages must be given"),
        ("fuzzy_smc_ilo_class", rigid, {}, "appendages must be given"),
        ("fuzzy_pd", rigid, {}, "appendages must be given"),
        ("aismc", rigid, {}, "appendages must be given"),
        ("aismc", two_modes, {}, "design must be 'solved' for a spacecraft with 2 modes"),
        ("fuzzy_smc", lambda: FLEXIBLE, {}, "design must leave a stable"),
        ("fuzzy_smc", lambda: LI, {"limit": "all"}, "limit must be one of"),
        ("fuzzy_smc", lambda: LI, {"slope": -1.0}, "slope must not be negative"),
        ("fuzzy_smc", lambda: LI, {"feedback_share": 0.0}, "feedback_share must be positive"),
        ("fuzzy_smc", lambda: LI, {"linear": -1.0}, "linear must not be negative"),
        ("fuzzy_smc", lambda: LI, {"switching": -1.0}, "switching must not be negative"),
        ("fuzzy_smc", lambda: LI, {"layer": 0.0}, "layer must be positive"),
        ("fuzzy_pd", lambda: LI, {"compensation": "none"}, "compensation must be one of"),
        ("fuzzy_pd", lambda: LI, {"position_gain": 0.0}, "position_gain must be positive"),
        ("fuzzy_pd", lambda: LI, {"rate_gain": 0.0}, "rate_gain must be positive"),
        ("aismc", lambda: LI, {"margin": -1.0}, "margin must not be negative"),
        ("aismc", lambda: LI, {"layer": 0.0}, "layer must be positive"),
        ("raftsmc_class", lambda: LI, {"first_exponent": 0.9}, "first_exponent must be at least 1"),
        ("raftsmc_class", lambda: LI, {"high_exponent": 0.9}, "high_exponent must be at least 1"),
        ("raftsmc_class", lambda: LI, {"second_exponent": 1.0}, "second_exponent must lie within"),
        ("raftsmc_class", lambda: LI, {"low_exponent": 1.0}, "low_exponent must lie within"),
        ("raftsmc_class", lambda: LI, {"second": -1.0}, "second must not be negative"),
        ("raftsmc_class", lambda: LI, {"bound": 0.0}, "bound must be positive"),
        ("raftsmc_class", lambda: LI, {"adaptation": 300.0}, "adaptation times forgetting must be at most"),
    ],
)
def test_refusals(name, scenario, options, message):
    with pytest.raises(ValueError, match=message):
        baselines.make(name, scenario(), **options)
