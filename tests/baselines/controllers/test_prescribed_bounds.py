"""Prescribed bounds in controllers: flights beyond them, starts outside of them, and mirrored ones."""

import numpy as np
import pytest

from ftac_gym import baselines, scenarios
from ftac_gym.attitude import (
    mrp_from_quaternion,
    quaternion_error,
    quaternion_from_mrp,
    quaternion_from_rotation_vector,
    quaternion_product,
)
from ftac_gym.dynamics import Simulator
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.measurement import Measurement

CHEN = scenarios.get("chen_2018")


# ---------------------------------------------------------------------------------------- flights beyond their bounds


def flown(name, scenario, steps, disturb, **gains):
    """Return margins (steps, N) and commands (steps, N, wheels); ``disturb(step, simulator)`` may change the truth."""
    simulator, law = Simulator(scenario, 3), baselines.make(name, scenario, 3, **gains)
    simulator.reset(scenario.draw(4, 3))
    margins, commands = [], []
    for step in range(steps):
        disturb(step, simulator)
        seen = simulator.measurement()
        error = mrp_from_quaternion(quaternion_error(seen.attitude, seen.reference_attitude))
        margins.append(law.bound.margin(error, seen.time).min(axis=1))
        commands.append(law.act(seen))
        simulator.step(commands[-1])
    return np.array(margins), np.array(commands)


def turned(at_step, rotations):
    """Replace the attitudes at a step by these."""

    def disturb(step, simulator):
        if step == at_step:
            simulator.state.attitude[:] = quaternion_from_rotation_vector(np.array(rotations))
            simulator.measured_attitude[:] = simulator.state.attitude

    return disturb


def pushed(begin, end, change):
    """Add to the rates at some steps [rad/s], as a strong torque would."""

    def disturb(step, simulator):
        if begin <= step < end:
            simulator.state.rate[:] += np.array(change)
            simulator.measured_rate[:] = simulator.state.rate

    return disturb


FAR = ((1.0, -0.9, 0.8), (-1.4, 0.1, 0.3), (0.2, 2.4, -0.5))  # rad
QUIET = scenarios.get("flagship").replace(faults=None, sensors=None, duration=300.0)
HEAVY = CHEN.replace(control_period=0.1, physics_step=0.02, duration=300.0)
BREACHES = {
    "sampled law, turned": ("prescribed_performance", QUIET, 1300, turned(600, FAR), 600, {"final": 0.02}),
    "sampled law, pushed": (
        "prescribed_performance", QUIET, 1300, pushed(600, 650, (0.003, -0.003, 0.003)), 600, {"final": 0.02},
    ),
    "paper's law, turned": ("chen_m1_sampled", HEAVY, 1500, turned(300, FAR), 300, {"final": 0.05}),
    "paper's law, pushed": (
        "chen_m1_sampled", HEAVY, 1700, pushed(300, 350, (0.0025, -0.0025, 0.0025)), 300, {"final": 0.05},
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", BREACHES)
def test_a_craft_comes_back_from_far_outside(case):
    """The rule for a breached bound: finite commands within the limits, and the way back inside.

    The paper's law, whose tangent is steep, comes to the bound as exp(-k1 t): it takes up to 120 s for that.
    """
    name, scenario, steps, disturb, begin, bound = BREACHES[case]
    margins, commands = flown(name, scenario, steps, disturb, bound=bound)
    limits = scenario.spacecraft.wheels.torque_limits
    assert np.isfinite(commands).all() and (np.abs(commands) <= limits * (1.0 + 1e-12)).all()
    assert (margins[:begin] > 0.0).all()
    assert (margins[begin:].min(axis=0) < -0.2).all()
    assert (margins[-100:] > 0.0).all()


# ----------------------------------------------------------------------------------------------------- starts outside


def measured(*errors, time=0.0):
    """The measurement of spacecraft at rest whose attitudes are these MRPs away from the reference."""
    count = len(errors)
    attitude = quaternion_from_mrp(np.array(errors, dtype=float))
    identity, three = np.tile([1.0, 0.0, 0.0, 0.0], (count, 1)), np.zeros((count, 3))
    return Measurement(
        np.full(count, time), attitude, three, three, three, np.ones(count, bool), identity, three, three
    )  # fmt: skip


TIGHT = {"initial_factor": None}  # the bounds of Table 1 from the start: (-.4, -.5, -.1) to (.1, .1, .4)
PAPERS = (-0.3, -0.4, 0.2)


@pytest.mark.parametrize("name", ["chen_m1", "chen_m1_sampled", "prescribed_performance"])
@pytest.mark.parametrize("method", ["act", "sliding_variable"])
def test_a_start_outside_is_refused(name, method):
    law = baselines.make(name, CHEN, 2, bound=TIGHT)
    pattern = (
        r"attitude of spacecraft 1, which starts at 0 s, must be within its prescribed bound, "
        r"\(-0\.4, 0\.1\) for MRP axis 0, got 0\.3, outside by 0\.2; mirror=True, or "
        r"bound\.lower and bound\.upper exchanged on axes \[0, 2\], would hold this"
    )
    with pytest.raises(ValueError, match=pattern):
        getattr(law, method)(measured(PAPERS, (0.3, -0.4, -0.15)))
    getattr(baselines.make(name, CHEN, 2, bound=TIGHT), method)(measured(PAPERS, PAPERS))


def test_a_start_on_the_bound_is_outside():
    law = baselines.make("chen_m1", CHEN, bound={"lower": (1.0,) * 3, "upper": (1.0,) * 3, **TIGHT})
    with pytest.raises(ValueError, match=r"MRP axis 1, got 0\.5, outside by"):
        law.act(measured((0.1, 0.5000000001, 0.0)))
    law.act(measured((0.1, 0.4999999999, 0.0)))


@pytest.mark.parametrize("mirror", [False, True])
def test_what_no_mirror_would_hold_is_said(mirror):
    law = baselines.make("prescribed_performance", CHEN, bound=TIGHT, mirror=mirror)
    with pytest.raises(ValueError, match=r"axis 1, got 0\.6.* mirrored bounds would not hold it either: bound\.in"):
        law.act(measured((-0.3, 0.6, 0.2)))
    # One axis could be mirrored, the other not: mirroring is no remedy.
    law = baselines.make("prescribed_performance", CHEN, bound=TIGHT)
    with pytest.raises(ValueError, match="mirrored bounds would not hold it either"):
        law.act(measured((0.3, -0.6, 0.2)))


@pytest.mark.parametrize("factors", ["constant", "varying"])
@pytest.mark.parametrize("name", ["chen_m1", "chen_m1_sampled", "prescribed_performance"])
def test_each_craft_of_a_batch_has_its_own_mirrors(name, factors):
    """Chosen at its start and kept when the signs change: the same as spacecraft of their own with exchanged bounds.

    Varying factors, which are those of the paper's example, are equal on both sides at the start.
    """
    changes = TIGHT if factors == "constant" else {}
    starts = [(-0.3, -0.4, 0.2), (0.3, 0.4, -0.2), (0.3, -0.4, 0.2), (-0.01, 0.4, 0.01)]
    later = [(-0.05, 0.06, 0.1), (-0.05, 0.05, 0.04), (-0.02, 0.03, -0.02), (0.05, -0.06, 0.07)]
    flips = [(0, 0, 0), (1, 1, 1), (1, 0, 0), (0, 1, 0)]
    task = CHEN.replace(control_period=1.0)
    together = baselines.make(name, task, 4, bound=changes, mirror=True)
    moments = [measured(*starts), measured(*later, time=1.0), measured(*later[::-1], time=2.0)]
    commands = [together.act(moment) for moment in moments]
    sliding = together.sliding_variable(moments[1])
    lower, upper = np.array(CHEN.prescribed_bound.lower), np.array(CHEN.prescribed_bound.upper)
    for row, flip in enumerate(flips):
        mask = np.array(flip) == 1
        exchanged = {"lower": np.where(mask, upper, lower), "upper": np.where(mask, lower, upper)}
        alone = baselines.make(name, task, bound={**changes, **exchanged})
        for moment, expected in zip(moments, commands, strict=True):
            one = moment.take(np.array([row]))
            np.testing.assert_allclose(alone.act(one), expected[[row]], rtol=1e-12, atol=1e-12)
        one = moments[1].take(np.array([row]))
        np.testing.assert_allclose(alone.sliding_variable(one)[0], sliding[row], atol=1e-12)
    assert (np.abs(commands[2]).max(axis=1) > 0.01).all()  # N m: there is something to compare


@pytest.mark.parametrize("mirror", [False, True])
def test_only_fresh_craft_are_checked_and_a_reset_makes_them_fresh(mirror):
    outside = (0.1, 0.6, 0.1)
    law = baselines.make("chen_m1_sampled", CHEN, 3, bound=TIGHT, mirror=mirror)
    later = CHEN.control_period
    law.act(measured(PAPERS, PAPERS, PAPERS))
    assert np.isfinite(law.act(measured(PAPERS, outside, PAPERS, time=later))).all()
    law.reset(np.array([True, False, False]))
    assert np.isfinite(law.act(measured(PAPERS, outside, PAPERS, time=(0.0, 2 * later, 2 * later)))).all()
    law.reset(np.array([False, True, True]))
    law.act(measured(PAPERS, PAPERS, PAPERS))
    law.reset(np.array([False, True, False]))
    with pytest.raises(ValueError, match=r"got 0\.6"):
        law.act(measured(PAPERS, outside, PAPERS))
    with pytest.raises(ValueError, match=r"got 0\.6"):  # still fresh
        law.act(measured(PAPERS, outside, PAPERS))
    law.act(measured(PAPERS, PAPERS, outside))


def test_a_reset_chooses_mirrors_anew_for_its_craft_only():
    """The other spacecraft, whose signs have changed since its start, keeps its mirrors."""
    opposite, crossed = tuple(-value for value in PAPERS), (0.05, 0.04, -0.03)
    law, first, fresh = (baselines.make("chen_m1_sampled", CHEN, n, bound=TIGHT, mirror=True) for n in (2, 1, 1))
    law.act(measured(PAPERS, PAPERS))
    first.act(measured(PAPERS))
    law.reset(np.array([False, True]))
    law.act(measured(crossed, opposite))
    variable = law.sliding_variable(measured(crossed, opposite))
    first.act(measured(crossed)), fresh.act(measured(opposite))
    np.testing.assert_array_equal(variable[0], first.sliding_variable(measured(crossed))[0])
    np.testing.assert_array_equal(variable[1], fresh.sliding_variable(measured(opposite))[0])
    turned = baselines.make("chen_m1_sampled", CHEN, bound=TIGHT, mirror=True).sliding_variable(measured(crossed))
    assert np.abs(variable[0] - turned[0]).max() > 0.01  # rad/s: its mirrors matter


def test_the_start_is_relative_to_the_reference():
    """sigma of the error, whatever the attitude is, and on the short branch whatever the quaternion's sign."""
    seen = measured(PAPERS)
    reference = quaternion_from_rotation_vector(np.array([[1.0, 2.0, -0.5]]))
    moved = {**vars(seen), "reference_attitude": reference, "attitude": -quaternion_product(reference, seen.attitude)}
    commands = [
        baselines.make("chen_m1", CHEN, bound=TIGHT).act(measurement) for measurement in (seen, Measurement(**moved))
    ]
    np.testing.assert_allclose(commands[1], commands[0], atol=1e-9)


def test_a_mirrored_start_flies_and_stays_within_mirrored_bounds():
    """From -sigma(0), which the paper's bounds hold at the start, with delta(0) = 2, but not half a second later."""
    start = InitialState.fixed(quaternion_from_mrp(-np.array(PAPERS)).tolist())
    scenario = HEAVY.replace(initial_state=start, faults=None)
    exchanged = {"lower": CHEN.prescribed_bound.upper, "upper": CHEN.prescribed_bound.lower}
    errors = {}
    for case, gains in {
        "mirrored": {"mirror": True}, "exchanged": {"bound": exchanged}, "neither": {},
    }.items():  # fmt: skip
        simulator, law = Simulator(scenario, 1), baselines.make("chen_m1_sampled", scenario, **gains)
        simulator.reset(scenario.draw(0, 1))
        errors[case] = []
        for _ in range(200):
            seen = simulator.measurement()
            errors[case].append(mrp_from_quaternion(seen.attitude[0]))
            simulator.step(law.act(seen))
    times, bound = np.arange(200) * 0.1, CHEN.prescribed_bound
    assert bound.mirrored([True] * 3).margin(np.array(errors["exchanged"]), times).min() > 0.0
    assert bound.margin(np.array(errors["neither"]), times).min() < -0.2
    np.testing.assert_array_equal(errors["mirrored"], errors["exchanged"])
