"""Spectral radius and margins of the linear loop: against closed forms, and against flights on both sides."""

import dataclasses

import numpy as np
import pytest
from scipy.signal import cont2discrete

from ftac_gym import Simulator, baselines, scenarios
from ftac_gym.attitude import angle_between, quaternion_from_rotation_vector, quaternion_product
from ftac_gym.baselines import Baseline, LoopMargins, NoLinearLoopError, loop_margins
from ftac_gym.baselines.components.allocation import pseudo_inverse
from ftac_gym.baselines.linear_loop import LinearLoop, linearise
from ftac_gym.baselines.linear_loop.spacecraft import spacecraft_model
from ftac_gym.baselines.linear_loop.system import held_parts
from ftac_gym.task.initial_state import InitialState

FLAGSHIP = scenarios.get("flagship")
POSITION, RATE = 0.3, 1.2
"""Gains of the controller under test [1/s^2, 1/s]."""


class PlainPD(Baseline):
    """Proportional-derivative control without memory: J (-kp theta - kd w)."""

    position, rate = POSITION, RATE

    def act(self, measurement):
        angle = 2.0 * measurement.attitude[:, 1:] * np.sign(measurement.attitude[:, :1])
        torque = -(self.position * angle + self.rate * measurement.rate) @ self._inertia
        return torque @ pseudo_inverse(self.scenario.spacecraft.wheels.axis_matrix).T


class Damper(PlainPD):
    """Damping of the rate alone."""

    position = 0.0


class Sign(PlainPD):
    """A law whose gain near rest is not bounded."""

    def act(self, measurement):
        torque = -np.sign(measurement.rate)
        return torque @ pseudo_inverse(self.scenario.spacecraft.wheels.axis_matrix).T


class Structured(PlainPD):
    """A filtered rate in a structured array, with a counter and a flag beside it."""

    def __init__(self, scenario, num_spacecraft=1):
        super().__init__(scenario, num_spacecraft)
        kind = np.dtype([("rate", "f8", (3,)), ("count", "i8"), ("on", "?")])
        self.memory.add("filter", (), 0.0)
        self.memory["filter"] = np.zeros(num_spacecraft, kind)

    def act(self, measurement):
        state = self.memory["filter"].copy()
        state["rate"] += 0.5 * (measurement.rate - state["rate"])
        state["count"] += 1
        self.memory["filter"] = state
        return super().act(dataclasses.replace(measurement, rate=state["rate"]))


def by_hand(period, delay, gain=1.0, blend=1.0):
    """Return the spectral radius of one axis: double integrator, filtered rate, any delay, the queue written out."""
    periods, late = divmod(round(delay / period * 1e9), 10**9)
    late *= period / 1e9
    parts = [
        cont2discrete((np.eye(2, k=1), np.eye(2)[:, 1:], np.eye(2), np.zeros((2, 1))), time)
        for time in (period - late, late)
    ]
    (a_last, b_last), (_, b_first) = parts[0][:2], parts[1][:2]
    size = 3 + periods + 1
    matrix = np.zeros((size, size))
    matrix[:2, :2] = np.array([[1, period], [0, 1]])
    # Filtered rate f+ = f + blend (w - f), command u = -kp theta - kd f+.
    matrix[2, 1], matrix[2, 2] = blend, 1.0 - blend
    now = np.zeros(size)
    now[:3] = -POSITION, -RATE * blend, -RATE * (1.0 - blend)
    given = [now, *np.eye(size)[3:]]
    matrix[:2] += gain * np.outer(b_last[:, 0], given[periods])
    matrix[:2] += gain * np.outer(a_last @ b_first[:, 0], given[periods + 1])
    matrix[3:] = given[:-1]
    return np.abs(np.linalg.eigvals(matrix)).max()


@pytest.mark.parametrize("delay", [0.0, 0.04, 0.1, 0.26])
@pytest.mark.parametrize(("kind", "blend"), [(PlainPD, 1.0), (Structured, 0.5)])
def test_the_radius_of_a_double_integrator(delay, kind, blend):
    scenario = FLAGSHIP.replace(loop_delay=delay)
    loop = LinearLoop(linearise(kind(scenario)), scenario)
    for gain, further in ((1.0, 0.0), (0.3, 0.0), (2.5, 0.0), (1.0, 0.03), (1.0, 0.1), (1.0, 0.57), (2.0, 0.31)):
        assert loop.radius(gain, further) == pytest.approx(by_hand(0.1, delay + further, gain, blend), abs=1e-6)


def test_margins_of_a_characteristic_polynomial():
    """Without delay z^2 + (T^2 kp / 2 + T kd - 2) z + T^2 kp / 2 - T kd + 1: by Jury, unstable from T kd = 2."""
    found = loop_margins(PlainPD(FLAGSHIP.replace(loop_delay=0.0)))
    assert found.largest_gain == pytest.approx(2.0 / (0.1 * RATE), rel=1e-3)
    assert found.smallest_gain == 0.0
    assert found.stable and not found.unstable


def test_the_delay_margin_of_a_slow_loop_is_that_in_continuous_time():
    """Crossover and phase of (kd s + kp) / s^2, of which sampling takes half a period."""
    scenario = FLAGSHIP.replace(control_period=0.02, loop_delay=0.0)
    square = 0.5 * (RATE**2 + np.sqrt(RATE**4 + 4.0 * POSITION**2))
    crossover = np.sqrt(square)
    expected = np.arctan(RATE * crossover / POSITION) / crossover
    found = loop_margins(PlainPD(scenario)).delay_margin
    assert found == pytest.approx(expected - 0.01, abs=1e-3)
    assert found > 20 * scenario.control_period  # By phase alone; and a shorter period needs no longer queue.
    assert by_hand(0.02, np.floor(found / 0.02) * 0.02) < 1.0 < by_hand(0.02, np.ceil(found / 0.02) * 0.02)


def grows(name, **changes):
    """Tell whether the error grows in a flight near the target, in a scenario that the baseline is not told.

    The baseline is told the command in effect by its own delay, one control period.
    """
    quiet = dict.fromkeys(("faults", "disturbance", "sensors", "inertia_uncertainty"))
    task = FLAGSHIP.replace(initial_state=InitialState.fixed(), **quiet, **changes)
    baseline, simulator, episodes = baselines.make(name, FLAGSHIP, 3), Simulator(task, 3), task.draw(0, 3)
    simulator.reset(episodes)
    turned = quaternion_from_rotation_vector(1e-3 * FLAGSHIP.success.angle * np.eye(3))
    episodes.initial["attitude"] = quaternion_product(simulator.reference_attitude, turned)
    simulator.reset(episodes)
    errors, before = [], np.zeros_like(simulator.last_command)
    for _ in range(400):
        told = dataclasses.replace(simulator.measurement(), command_in_effect=before)
        before = simulator.last_command.copy()
        simulator.step(baseline.act(told))
        errors.append(angle_between(simulator.state.attitude, simulator.reference_attitude).max())
    # An estimator of the inertia learns from a motion that grows, and may end it later.
    return bool(max(errors[50:]) > 0.5 * errors[0])


@pytest.mark.parametrize("name", ["pd", "pd_dob", "nftsm_observer", "predefined_time"])
def test_flights_on_both_sides_of_the_gain_margin(name):
    """All inertia divided by a factor is all torque times it."""
    edge = loop_margins(baselines.make(name, FLAGSHIP)).largest_gain
    for factor, expected in ((0.93 * edge, False), (1.2 * edge, True)):
        inertia = (FLAGSHIP.spacecraft.inertia_matrix / factor).tolist()
        assert grows(name, spacecraft=dataclasses.replace(FLAGSHIP.spacecraft, inertia=inertia)) == expected


@pytest.mark.parametrize("name", ["pd", "pd_dob", "nftsm_observer", "predefined_time"])
def test_flights_on_both_sides_of_the_delay_margin(name):
    edge = loop_margins(baselines.make(name, FLAGSHIP)).delay_margin
    assert edge > 0.02
    inside = 0.02 * np.floor(edge / 0.02)
    for further, expected in ((inside, False), (inside + 0.02, True)):
        assert grows(name, loop_delay=round(FLAGSHIP.loop_delay + further, 6)) == expected


def test_a_mode_of_the_appendages_is_in_the_loop():
    """The plant in discrete time against SciPy, from the equations with the acceleration of the body."""
    scenario = scenarios.get("flexible")
    plant, names = spacecraft_model(scenario)
    body, panels = scenario.spacecraft, scenario.spacecraft.appendages
    modes, wheels = body.modes, body.wheels.count
    mass = np.block([[body.inertia_matrix, panels.coupling_matrix.T], [panels.coupling_matrix, np.eye(modes)]])
    stiffness = np.diag(np.r_[np.zeros(3), panels.stiffness])
    damping = np.diag(np.r_[np.zeros(3), panels.damping])
    zero, eye = np.zeros((3 + modes, 3 + modes)), np.eye(3 + modes)
    a = np.block([[zero, eye], [-np.linalg.solve(mass, stiffness), -np.linalg.solve(mass, damping)]])
    b = np.concatenate(
        [
            np.zeros((3 + modes, wheels)),
            np.linalg.solve(mass, np.concatenate([body.wheels.axis_matrix, np.zeros((modes, wheels))])),
        ]
    )
    whole, entry = cont2discrete((a, b, np.eye(len(a)), np.zeros_like(b)), 0.1)[:2]
    order = np.r_[
        np.arange(3),
        np.arange(3) + names["rate"].start,
        np.arange(modes) + names["modal_displacement"].start,
        np.arange(modes) + names["modal_rate"].start,
    ]
    mine = np.r_[order[:3], order[6 : 6 + modes], order[3:6], order[6 + modes :]]
    transition, _, rest = held_parts(plant, 0.1, 0.0)
    np.testing.assert_allclose(transition[np.ix_(mine, mine)], whole, atol=1e-9)
    np.testing.assert_allclose(rest[mine], entry, atol=1e-9)


def test_loops_that_are_neutral_or_not_linear():
    found = loop_margins(Damper(FLAGSHIP.replace(loop_delay=0.0)))
    assert not found.stable and not found.unstable
    assert "neutral" in str(found)
    assert found.largest_gain == pytest.approx(2.0 / (0.1 * RATE), rel=1e-3)
    stiff = loop_margins(PlainPD(FLAGSHIP.replace(control_period=2.0, sensors=None)))
    assert stiff.unstable and np.isnan([stiff.largest_gain, stiff.smallest_gain, stiff.delay_margin]).all()
    assert str(stiff).endswith(": unstable")
    with pytest.raises(NoLinearLoopError, match="depend on the size of the error"):
        loop_margins(Sign(FLAGSHIP))


@pytest.mark.parametrize("name", ["pd_dob", "nftsm_observer", "predefined_time", "pd_shaped"])
def test_margins_enclose_the_loop_and_change_no_baseline(name):
    baseline = baselines.make(name, FLAGSHIP, 2)
    before = baseline.memory.copy()
    found = loop_margins(baseline)
    assert isinstance(found, LoopMargins) and found == loop_margins(baselines.make(name, FLAGSHIP))
    assert found.spectral_radius < 1.0 and found.delay_margin > 0.0
    assert 0.0 <= found.smallest_gain < 1.0 < found.largest_gain
    for key, array in baseline.memory.copy().items():
        np.testing.assert_array_equal(array, before[key])


def test_a_description():
    text = baselines.describe("pd_dob", FLAGSHIP, "tuned", rate_gain=1.5)
    assert text.splitlines()[0] == "pd_dob in flagship, tuned gains"
    loop = "0.1 s with a delay of 0.1 s: spectral radius 0.9"
    for part in ("information: attitude", "rate_gain = 1.5 1/L = 7.5 1/s", loop):
        assert part in text
    assert "no linear loop: its gains near rest" in baselines.describe("afntsmc", FLAGSHIP)
    assert "position" not in baselines.describe(PlainPD, FLAGSHIP)
    with pytest.raises(ValueError, match="baseline must be one of"):
        baselines.describe("pid", FLAGSHIP)
