"""The fuzzy observer of Li et al. 2023 against one that was written again, and against what its design promises."""

import numpy as np
import pytest
from helpers.flexible_spacecraft import li_spacecraft, random_appendages
from helpers.fuzzy_cases import FLEXIBLE, LI, gains_of, make, watched
from helpers.fuzzy_laws import CORNERS, FlexibleModel, ReferenceObserver
from helpers.observed import seen
from scipy.integrate import solve_ivp

from ftac_gym.baselines import observers, synthesis
from ftac_gym.baselines.components.takagi_sugeno import TakagiSugenoModel
from ftac_gym.baselines.memory import Memory
from ftac_gym.spacecraft.spacecraft import Spacecraft

TIGHT = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-14}
DESIGNS = ("published", "solved")


def flight(scenario, steps, count, seed, size, noise=1e-4):
    """Measured rates (T, N, 3) that wander smoothly, with noise, and commands (T, N, m)."""
    rng, times = np.random.default_rng(seed), scenario.control_period * np.arange(steps)[:, None, None]
    rates = size * np.sin(times * rng.uniform(0.3, 2.0, (count, 3)) + rng.uniform(0.0, 6.0, (count, 3)))
    rates = rates + noise * rng.normal(size=rates.shape)
    return rates, rng.uniform(-1.0, 1.0, (steps, count, scenario.spacecraft.wheels.count))


PARITY = {
    # scenario, what flies, options of the package, options of the other
    "published": (LI, 0.1, {"design": "published"}, {}),
    "solved": (LI, 0.1, {}, {}),
    "four wheels": (FLEXIBLE, 0.02, {}, {}),
    "beyond the sector": (LI, 1.5, {"design": "published"}, {}),
    "start at zero": (LI, 0.1, {"design": "published", "start": "zero"}, {"know_rate": False}),
    "rate held": (LI, 0.1, {"interpolate": False}, {"interpolate": False}),
    "euler": (LI, 0.1, {"method": "euler", "longest_step": 0.01}, {"euler": True, "substeps": 5}),
    "euler, held": (
        LI, 0.1, {"method": "euler", "interpolate": False, "longest_step": 0.025},
        {"euler": True, "interpolate": False, "substeps": 2},
    ),
    "substeps": (FLEXIBLE, 0.02, {"longest_step": 0.04}, {"substeps": 3}),
    "torque bound": (LI, 0.1, {"design": "published", "torque_bound": 3.0}, {}),
    "vibration bound": (LI, 0.1, {"design": "published", "vibration_bound": 0.5}, {}),
    "both bounds": (LI, 0.1, {"torque_bound": 3.0, "vibration_bound": 0.5, "start": "zero"}, {"know_rate": False}),
    "not scheduled": (LI, 0.4, {"design": "published", "scheduled": False}, {}),
}  # fmt: skip


@pytest.mark.parametrize("case", PARITY)
def test_agrees_with_an_independent_implementation(case):
    scenario, size, options, theirs = PARITY[case]
    rates, commands = flight(scenario, 60, 3, 7, size)
    mine = watched(scenario, rates, commands, **options)
    gains = gains_of(options.get("design", "solved"), scenario.spacecraft)
    gains = gains if options.get("scheduled", True) else gains.mean()
    bounds = {name: options.get(name) for name in ("torque_bound", "vibration_bound")}
    substeps = {"substeps": 2} if scenario is FLEXIBLE else {}
    for row in range(3):
        again = ReferenceObserver(scenario.spacecraft, gains, **bounds)
        path = rates[:, row], commands[:, row], scenario.control_period
        expected = again.history(*path, **{**substeps, **theirs})
        np.testing.assert_allclose(mine[:, row], expected, rtol=0.0, atol=1e-10 * np.abs(expected).max())
    if options.get("torque_bound"):
        held = np.abs(mine[:, :, :3]) == options["torque_bound"]
        assert 0.02 < held.mean() < 0.98  # on the bound and off it


@pytest.mark.parametrize("modes", [1, 2, 6])
def test_agrees_for_other_numbers_of_modes(monkeypatch, modes):
    """Any gains that are stable: those of the paper for w and f, nothing for the vibration."""
    inertia = np.diag([350.0, 270.0, 190.0])
    spacecraft = Spacecraft(
        inertia, LI.spacecraft.wheels, appendages=random_appendages(modes, 3, 0.3, damping=(0.02, 0.05))
    )
    rng, whole = np.random.default_rng(modes), gains_of("published")
    gains = synthesis.ObserverGains(
        whole.rate, whole.fault, 0.1 * rng.normal(size=(8, 2 * modes, 3)), whole.fault_proportional,
        0.1 * rng.normal(size=(2 * modes, 3)),
    )  # fmt: skip
    both = synthesis.DesignGains(gains, synthesis.published().controller)
    monkeypatch.setattr(synthesis, "gains", lambda spacecraft, design: both)
    scenario = LI.replace(spacecraft=spacecraft)
    rates, commands = flight(scenario, 40, 1, 1, 0.1)
    expected = ReferenceObserver(spacecraft, gains).history(rates[:, 0], commands[:, 0], 0.05)
    mine = watched(scenario, rates, commands)[:, 0]
    np.testing.assert_allclose(mine, expected, rtol=0.0, atol=1e-10 * np.abs(expected).max())


@pytest.mark.parametrize("design", DESIGNS)
def test_is_the_printed_law_with_its_derivative(design):
    """f^' = sum F e + theta F_2 e' and the like, integrated by SciPy along the same polygon of rates."""
    rates, commands = flight(LI, 30, 1, 2, 0.2, noise=0.0)
    rates, commands = rates[:, 0], commands[:, 0]
    again = ReferenceObserver(LI.spacecraft, gains_of(design))
    count, delta, period = again.model.count, again.model.delta, LI.control_period
    state = np.concatenate([rates[0], np.zeros(3 + count), delta @ rates[0]])
    expected = []
    for step, rate in enumerate(rates):
        if step:
            before, slope = rates[step - 1], (rate - rates[step - 1]) / period
            torque = again.model.axes @ commands[step]

            def derivative(time, x, before=before, slope=slope, torque=torque):
                return again.derivative(x, before + time * slope, slope, torque)

            state = solve_ivp(derivative, (0.0, period), state, **TIGHT).y[:, -1]
        pull = again.model.vibration_torque(rate, state[6 : 6 + count], state[6 + count :] - delta @ rate)
        expected.append(np.append(state[3:6], pull))
    mine = watched(LI, rates[:, None], commands[:, None], design=design, longest_step=0.0025)[:, 0]
    assert np.abs(expected).max() > 1.0
    np.testing.assert_allclose(mine, expected, rtol=0.0, atol=1e-7 * np.abs(expected).max())


# ----------------------------------------------------------------------------------------------------------- bounds


@pytest.mark.parametrize("design", DESIGNS)
def test_torque_bound_is_kept_and_does_not_wind_up(design):
    """A command that nothing answers to counts as a fault against it: 5 N m for 20 s, then one of 1 N m."""
    torque = np.concatenate([np.full(400, 5.0), np.full(200, 1.0)])
    commands = -torque[:, None, None] * np.array([1.0, -1.0, 1.0])
    rates = np.zeros((600, 1, 3))
    bounded = watched(LI, rates, commands, design=design, torque_bound=2.0)[:, 0, :3]
    assert np.abs(bounded).max() == 2.0
    assert (np.abs(bounded[200:400]) == 2.0).any(axis=0).all()
    # As soon as an observer that has seen no more than its bound, it is at what acts now.
    mild = np.concatenate([np.full(400, 2.0), np.full(200, 1.0)])
    calm = watched(LI, rates, -mild[:, None, None] * np.array([1.0, -1.0, 1.0]), design=design)[:, 0, :3]
    truth = np.array([1.0, -1.0, 1.0])
    late, soon = (np.abs(found[-1] - truth).max() for found in (bounded, calm))
    assert late < 5.0 * soon and late < 0.05
    memory = Memory(1)
    observer = observers.make("fafeo", LI, memory, design=design, torque_bound=2.0)
    for rate, command in zip(rates[:400], commands[:400], strict=True):
        observer.update(seen(rate, command), command, 0.05)
    assert np.abs(memory["fuzzy_state"][0, 3:6]).max() < 1.2 * 2.0


@pytest.mark.parametrize("design", DESIGNS)
def test_bounds_that_are_not_reached_change_nothing(design):
    rates, commands = flight(LI, 80, 2, 11, 0.05)
    free = watched(LI, rates, commands, design=design)
    largest = np.abs(free[:, :, :3]).max()
    bounded = watched(LI, rates, commands, design=design, torque_bound=1.5 * largest, vibration_bound=1e6)
    np.testing.assert_array_equal(bounded, free)


def test_start_believes_no_fault_and_still_appendages():
    rate = np.array([[0.1, -0.2, 0.05]])
    command = np.full((1, 3), 3.0)
    model = FlexibleModel(LI.spacecraft)
    for start, expected in (
        ("measured", np.zeros(3)),
        # varpi^ = 0 is a swing of -delta w.
        ("zero", model.vibration_torque(rate[0], np.zeros(4), -model.delta @ rate[0])),
    ):
        observer, _ = make(LI, start=start, design="published")
        assert not observer.estimate.disturbance.any()
        estimate = observer.update(seen(rate, command), command, 0.05)  # the command before the start means nothing
        np.testing.assert_allclose(estimate.disturbance, 0.0, atol=1e-14)
        np.testing.assert_allclose(estimate.vibration[0], expected, rtol=0.0, atol=1e-14)


def test_reset_forgets_the_craft_in_the_mask_alone():
    rates, commands = flight(LI, 40, 3, 12, 0.1)
    whole = watched(LI, rates, commands)
    observer, memory = make(LI, 3)
    for step, (rate, command) in enumerate(zip(rates, commands, strict=True)):
        if step == 20:
            memory.reset(np.array([False, True, False]))
        estimate = observer.update(seen(rate, command), command, 0.05)
        found = np.concatenate([estimate.disturbance, estimate.vibration], axis=1)
        np.testing.assert_array_equal(found[[0, 2]], whole[step, [0, 2]])
    again = watched(LI, rates[20:], commands[20:])
    np.testing.assert_array_equal(found[1], again[-1, 1])
    assert np.abs(found[1] - whole[-1, 1]).max() > 1e-3


def test_scheduling_is_the_mean_rule_at_rest_and_not_elsewhere():
    commands = np.random.default_rng(0).normal(size=(30, 1, 3))
    for rate, same in (((0.0, 0.0, 0.0), True), ((0.4, -0.3, 0.5), False)):
        rates = np.tile(rate, (30, 1, 1))
        pair = [watched(LI, rates, commands, design="published", scheduled=value) for value in (True, False)]
        assert (np.abs(pair[0] - pair[1]).max() < 1e-12) == same


def test_rules_are_those_of_the_paper():
    assert np.array_equal(np.array(CORNERS), TakagiSugenoModel(li_spacecraft()).corners)


# ----------------------------------------------------------------------------------------------------------- refusals


def rigid():
    return LI.replace(spacecraft=Spacecraft(LI.spacecraft.inertia, LI.spacecraft.wheels))


def two_modes():
    spacecraft = LI.spacecraft
    return LI.replace(spacecraft=Spacecraft(spacecraft.inertia, spacecraft.wheels, appendages=random_appendages(2)))


@pytest.mark.parametrize(
    ("scenario", "options", "message"),
    [
        (rigid, {}, "appendages must be given"),
        (rigid, {"design": "published"}, "appendages must be given"),
        (two_modes, {"design": "published"}, "design must be 'solved' for a spacecraft with 2 modes"),
        (lambda: FLEXIBLE, {"design": "published"}, "design must leave a stable error; the slowest pole is"),
        (lambda: LI, {"design": "printed"}, "design must be one of"),
        (lambda: LI, {"torque_bound": 0.0}, "torque_bound must be positive"),
        (lambda: LI, {"vibration_bound": -1.0}, "vibration_bound must be positive"),
        (lambda: LI, {"start": "nowhere"}, "start must be one of"),
        (lambda: LI, {"method": "rk2"}, "method must be one of"),
        (lambda: LI, {"longest_step": 0.0}, "longest_step must be positive"),
    ],
)
def test_refusals(scenario, options, message):
    with pytest.raises(ValueError, match=message):
        make(scenario(), **options)
