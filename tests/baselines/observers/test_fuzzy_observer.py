"""The fuzzy observer of Li et al. 2023 against one that was written again, and against what its design promises."""

import json
from importlib import resources

import numpy as np
import pytest
from helpers.flexible_spacecraft import li_spacecraft, random_appendages
from helpers.fuzzy_laws import CORNERS, FlexibleCraft, ReferenceObserver, firing
from helpers.observed import seen
from scipy.integrate import solve_ivp

from ftac_gym import scenarios
from ftac_gym.baselines import observers, synthesis
from ftac_gym.baselines.components.takagi_sugeno import TakagiSugenoModel
from ftac_gym.baselines.memory import Memory
from ftac_gym.baselines.synthesis import error_dynamics, error_inputs
from ftac_gym.dynamics import Simulator
from ftac_gym.faults import Bias, FaultSchedule, LossOfEffectiveness
from ftac_gym.spacecraft.spacecraft import Spacecraft
from ftac_gym.spacecraft.wheel_array import WheelArray
from ftac_gym.task.initial_state import InitialState

LI, FLEXIBLE = scenarios.get("li_2023"), scenarios.get("flexible")
TIGHT = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-14}
DESIGNS = ("published", "solved")


def gains_of(design, spacecraft=LI.spacecraft):
    return synthesis.gains(spacecraft, design).observer


def make(scenario, count=1, **options):
    memory = Memory(count)
    return observers.make("fafeo", scenario, memory, **options), memory


def watched(scenario, rates, commands, **options):
    """f^ and the torque of vibration (T, N, 6) that the package's observer makes of rates and commands (T, N, .)."""
    observer, _ = make(scenario, rates.shape[1], **options)
    results = []
    for rate, command in zip(rates, commands, strict=True):
        estimate = observer.update(seen(rate, command), command, scenario.control_period)
        results.append(np.concatenate([estimate.disturbance, estimate.vibration], axis=1))
    return np.array(results)


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
    for craft in range(3):
        again = ReferenceObserver(scenario.spacecraft, gains, **bounds)
        path = rates[:, craft], commands[:, craft], scenario.control_period
        expected = again.history(*path, **{**substeps, **theirs})
        np.testing.assert_allclose(mine[:, craft], expected, rtol=0.0, atol=1e-10 * np.abs(expected).max())
    if options.get("torque_bound"):
        held = np.abs(mine[:, :, :3]) == options["torque_bound"]
        assert 0.02 < held.mean() < 0.98  # on the bound and off it


@pytest.mark.parametrize("modes", [1, 2, 6])
def test_agrees_for_other_numbers_of_modes(monkeypatch, modes):
    """Any gains that are stable: those of the paper for w and f, nothing for the vibration."""
    inertia = np.diag([350.0, 270.0, 190.0])
    craft = Spacecraft(inertia, LI.spacecraft.wheels, appendages=random_appendages(modes, 3, 0.3, damping=(0.02, 0.05)))
    rng, whole = np.random.default_rng(modes), gains_of("published")
    gains = synthesis.ObserverGains(
        whole.rate, whole.fault, 0.1 * rng.normal(size=(8, 2 * modes, 3)), whole.fault_proportional,
        0.1 * rng.normal(size=(2 * modes, 3)),
    )  # fmt: skip
    both = synthesis.DesignGains(gains, synthesis.published().controller)
    monkeypatch.setattr(synthesis, "gains", lambda spacecraft, design: both)
    scenario = LI.replace(spacecraft=craft)
    rates, commands = flight(scenario, 40, 1, 1, 0.1)
    expected = ReferenceObserver(craft, gains).history(rates[:, 0], commands[:, 0], 0.05)
    mine = watched(scenario, rates, commands)[:, 0]
    np.testing.assert_allclose(mine, expected, rtol=0.0, atol=1e-10 * np.abs(expected).max())


@pytest.mark.parametrize("design", DESIGNS)
def test_is_the_printed_law_with_its_derivative(design):
    """f^' = sum F e + theta F_2 e' and the like, integrated by SciPy along the same polygon of rates."""
    rates, commands = flight(LI, 30, 1, 2, 0.2, noise=0.0)
    rates, commands = rates[:, 0], commands[:, 0]
    again = ReferenceObserver(LI.spacecraft, gains_of(design))
    count, delta, period = again.craft.count, again.craft.delta, LI.control_period
    state = np.concatenate([rates[0], np.zeros(3 + count), delta @ rates[0]])
    expected = []
    for step, rate in enumerate(rates):
        if step:
            before, slope = rates[step - 1], (rate - rates[step - 1]) / period
            torque = again.craft.axes @ commands[step]

            def derivative(time, x, before=before, slope=slope, torque=torque):
                return again.derivative(x, before + time * slope, slope, torque)

            state = solve_ivp(derivative, (0.0, period), state, **TIGHT).y[:, -1]
        pull = again.craft.vibration_torque(rate, state[6 : 6 + count], state[6 + count :] - delta @ rate)
        expected.append(np.append(state[3:6], pull))
    mine = watched(LI, rates[:, None], commands[:, None], design=design, longest_step=0.0025)[:, 0]
    assert np.abs(expected).max() > 1.0
    np.testing.assert_allclose(mine, expected, rtol=0.0, atol=1e-7 * np.abs(expected).max())


# ---------------------------------------------------------------------------------------------------- error dynamics


def smooth(rng, size, fastest=2.0):
    """A random vector function of time, and its derivative."""
    amplitude, frequency = size * rng.normal(size=(3, 3)), rng.uniform(0.1, fastest, (3, 3))
    phase = rng.uniform(0.0, 6.0, (3, 3))
    return (
        lambda time: (amplitude * np.sin(frequency * time + phase)).sum(axis=0),
        lambda time: (amplitude * frequency * np.cos(frequency * time + phase)).sum(axis=0),
    )


@pytest.mark.parametrize(("scenario", "design"), [(LI, "published"), (LI, "solved"), (FLEXIBLE, "solved")])
@pytest.mark.parametrize("constant", [False, True])
def test_error_follows_the_designed_dynamics(scenario, design, constant):
    """Plant, continuous observer and the linear error system, integrated together; e = truth - estimate."""
    rng, spacecraft = np.random.default_rng(4), scenario.spacecraft
    gains, model = gains_of(design, spacecraft), TakagiSugenoModel(spacecraft)
    closed, driven = error_dynamics(model, gains), error_inputs(model, gains)
    again, craft = ReferenceObserver(spacecraft, gains), FlexibleCraft(spacecraft)
    count, size = craft.count, 6 + 2 * craft.count
    scale = np.trace(craft.inertia) / 800.0
    (fault, fault_rate), (disturbance, _), (torque, _) = (smooth(rng, scale * part) for part in (1.0, 0.3, 3.0))
    if constant:
        lasting, pushing = fault(1.0), disturbance(2.0)
        fault, fault_rate, disturbance = lambda t: lasting, lambda t: np.zeros(3), lambda t: pushing

    def derivative(time, state):
        w, eta, swing = state[:3], state[3 : 3 + count], state[3 + count : 3 + 2 * count]
        observer, error = state[3 + 2 * count : -size], state[-size:]
        turn, bend = craft.accelerations(w, torque(time) + fault(time) + disturbance(time), eta, swing)
        change = again.proportional_integral(observer, w, torque(time))
        matrix = sum(share * part for share, part in zip(firing(w), closed, strict=True))
        moved = matrix @ error + driven @ np.append(disturbance(time), fault_rate(time))
        return np.concatenate([turn, swing, bend, change, moved])

    def error(time, state):
        w, eta, swing = state[:3], state[3 : 3 + count], state[3 + count : 3 + 2 * count]
        observer = state[3 + 2 * count : -size]
        _, found, whole, _ = again.outputs(observer, w)
        return np.concatenate([w - observer[:3], fault(time) - found, np.append(eta, swing + craft.delta @ w) - whole])

    plant = np.concatenate([(0.2, -0.3, 0.1), 0.1 * rng.normal(size=2 * count)])
    start = np.concatenate([plant, again.begin(plant[:3] + 0.01), np.zeros(size)])
    start[-size:] = error(0.0, start)
    times = np.linspace(0.0, 20.0, 41)
    path = solve_ivp(derivative, (0.0, 20.0), start, t_eval=times, **TIGHT).y.T
    assert np.abs(path[:, :3]).max() < 0.7
    errors = np.array([error(time, state) for time, state in zip(times, path, strict=True)])
    largest = np.abs(errors).max(axis=0)
    np.testing.assert_allclose(path[:, -size:] / largest, errors / largest, rtol=0.0, atol=1e-6)
    if constant:  # f^ comes to f + d, so that the error of f is -d
        late = errors[-1, 3:6] + disturbance(0.0)
        assert np.linalg.norm(late) < 0.15 * np.linalg.norm(errors[0, 3:6] + disturbance(0.0))


def level_of(scenario, design):
    if design == "published":
        return 1.6563
    kept = resources.files("ftac_gym.baselines.synthesis") / "stored" / f"{scenario.name}.json"
    return json.loads(kept.read_text())["gamma_1"]


@pytest.mark.parametrize(("scenario", "design"), [(LI, "published"), (LI, "solved"), (FLEXIBLE, "solved")])
def test_energy_of_the_error_keeps_to_the_level(scenario, design):
    """From zero error, along any rates within the sector; inputs are smooth, with and without a mean."""
    gains, model = gains_of(design, scenario.spacecraft), TakagiSugenoModel(scenario.spacecraft)
    closed, driven = error_dynamics(model, gains), error_inputs(model, gains)
    size, level, ratios = len(driven), level_of(scenario, design), []
    for seed in range(4):
        rng = np.random.default_rng(seed)
        (rate, _), (first, _), (second, _) = smooth(rng, 0.15), smooth(rng, 1.0, 4.0), smooth(rng, float(seed > 1), 4.0)
        mean = (seed % 2) * 3.0 * rng.normal(size=3)

        def derivative(time, state, rate=rate, first=first, second=second, mean=mean):
            pushed = np.append(first(time) + mean, second(time))
            matrix = sum(share * part for share, part in zip(firing(rate(time)), closed, strict=True))
            slope = matrix @ state[:size] + driven @ pushed
            return np.concatenate([slope, [state[:size] @ state[:size], pushed @ pushed]])

        options = {"method": "RK45", "rtol": 1e-7, "atol": 1e-9, "t_eval": np.linspace(0.5, 25.0, 50)}
        energies = solve_ivp(derivative, (0.0, 25.0), np.zeros(size + 2), **options).y[-2:]
        ratios.append(np.sqrt(energies[0] / energies[1]))
    assert np.max(ratios) <= level
    assert np.max(ratios) > 0.7  # the bound is not an idle one: a lasting d_1 counts whole


def test_level_is_that_of_the_files():
    """Certified here again for what is kept."""
    proof = synthesis.certify_observer(TakagiSugenoModel(FLEXIBLE.spacecraft), gains_of("solved", FLEXIBLE.spacecraft))
    assert proof.gamma <= level_of(FLEXIBLE, "solved") * 1.001 and proof.gamma >= 1.0


def still(scenario, biases=(), effectiveness=(), **changes):
    """A scenario of a spacecraft at rest, whose wheels have these faults from the start."""
    faults = [Bias(wheel=wheel, constant=value) for wheel, value in enumerate(biases)]
    faults += [LossOfEffectiveness(wheel=wheel, effectiveness=value) for wheel, value in enumerate(effectiveness)]
    wheels = scenario.spacecraft.wheels
    still_wheels = WheelArray(wheels.axes, wheels.torque_limit, None, momentum_coupling=False)
    craft = Spacecraft(
        scenario.spacecraft.inertia, still_wheels, scenario.spacecraft.allow_unphysical_inertia,
        scenario.spacecraft.appendages,
    )  # fmt: skip
    return scenario.replace(
        spacecraft=craft, initial_state=InitialState.fixed(), faults=FaultSchedule(tuple(faults)), disturbance=None,
        sensors=None, misalignment=None, inertia_uncertainty=None, appendage_uncertainty=None,
        **changes,
    )  # fmt: skip


@pytest.mark.parametrize("start", ["measured", "zero"])
@pytest.mark.parametrize("design", DESIGNS)
def test_lasting_torque_and_disturbance_are_found_exactly(design, start):
    """A spacecraft that a command keeps at rest: f^ is the torque that the command balances."""
    torque = np.array([0.7, -1.3, 0.4])
    rates, commands = np.tile([0.0, 0.0, 0.0], (2400, 1, 1)), np.tile(-torque, (2400, 1, 1))
    found = watched(LI, rates, commands, design=design, start=start)
    np.testing.assert_allclose(found[-1, 0], np.append(torque, np.zeros(3)), rtol=0.0, atol=1e-8)
    assert np.abs(found[100, 0, :3] - torque).max() > 1e-6  # it took its time


@pytest.mark.parametrize("kind", ["bias", "weak, against each other"])
def test_with_four_wheels_the_torque_is_found(kind):
    """A spacecraft in motion. With wheels that oppose each other, the single wheels' faults are far larger than f."""
    axes = FLEXIBLE.spacecraft.wheels.axis_matrix
    null = np.linalg.svd(axes)[2][3]
    null = null / np.abs(null).max()
    if kind == "bias":
        biases = np.array([0.02, -0.03, 0.05, -0.01])
        command = -np.linalg.pinv(axes) @ (axes @ biases) + 0.1 * null
        expected, scenario = axes @ biases, still(FLEXIBLE, biases=biases)
    else:
        weak = np.array([0.9, 0.6, 0.5, 0.8])
        command = 0.1 * null / weak
        expected, scenario = -axes @ command, still(FLEXIBLE, effectiveness=weak)
        assert np.abs((weak - 1.0) * command).max() > 0.04
    kept = synthesis.gains(FLEXIBLE.spacecraft, "solved")
    simulator, memory = Simulator(scenario, 1), Memory(1)
    with pytest.MonkeyPatch.context() as patch:  # the kept gains: what differs is the coupling of the wheels
        patch.setattr(synthesis, "gains", lambda spacecraft, design: kept)
        observer = observers.make("fafeo", scenario, memory)
    simulator.reset(scenario.draw(0, 1))
    for _ in range(1200):
        measurement = simulator.measurement()
        estimate = observer.update(measurement, measurement.last_command, scenario.control_period)
        simulator.step(command[None])
    assert np.abs(simulator.state.rate).max() < 1e-6
    np.testing.assert_allclose(estimate.disturbance[0], expected, rtol=0.0, atol=1e-6)
    np.testing.assert_allclose(estimate.vibration[0], 0.0, atol=1e-6)


# -------------------------------------------------------------------------------------------------------- sampling


@pytest.mark.parametrize(
    ("options", "ratio"),
    [
        ({"longest_step": 0.005}, 4.0),
        ({"longest_step": 0.005, "interpolate": False}, 2.0),
        ({"longest_step": 1.0, "method": "euler"}, 2.0),
    ],
)
def test_a_shorter_period_converges_to_the_continuous_observer(options, ratio):
    """To second order where the rate is interpolated, to first where it is held or Euler's rule is used."""
    rate, _ = smooth(np.random.default_rng(8), 0.05)
    again = ReferenceObserver(LI.spacecraft, gains_of("published"))
    torque = np.array([0.5, -0.2, 0.3])
    slope = lambda time, state: again.proportional_integral(state, rate(time), torque)  # noqa: E731
    end = solve_ivp(slope, (0.0, 4.0), again.begin(rate(0.0)), **TIGHT).y[:, -1]
    _, expected, _, _ = again.outputs(end, rate(4.0))
    errors = []
    for period in (0.04, 0.02, 0.01):
        scenario = LI.replace(control_period=period, physics_step=0.01)
        rates = np.array([rate(period * step) for step in range(round(4.0 / period) + 1)])[:, None]
        found = watched(scenario, rates, np.tile(torque, (len(rates), 1, 1)), design="published", **options)
        errors.append(np.linalg.norm(found[-1, 0, :3] - expected))
    np.testing.assert_allclose(np.array(errors[:-1]) / errors[1:], ratio, rtol=0.15)
    assert errors[-1] < 0.05 * np.linalg.norm(expected)


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
    craft = FlexibleCraft(LI.spacecraft)
    for start, expected in (
        ("measured", np.zeros(3)),
        # varpi^ = 0 is a swing of -delta w.
        ("zero", craft.vibration_torque(rate[0], np.zeros(4), -craft.delta @ rate[0])),
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
    craft = LI.spacecraft
    return LI.replace(spacecraft=Spacecraft(craft.inertia, craft.wheels, appendages=random_appendages(2)))


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
        (lambda: LI, {"gain": 1.0}, "gains of fafeo"),
    ],
)
def test_refusals(scenario, options, message):
    with pytest.raises(ValueError, match=message):
        make(scenario(), **options)
