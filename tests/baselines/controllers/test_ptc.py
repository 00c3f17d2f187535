"""The predefined-time controller of Cao, Gong and Han: its times, its switching term, and what h1 = 0.5 does."""

import numpy as np
import pytest
from helpers.laws import kinematic_matrix
from helpers.observed import seen, task

from ftac_gym import baselines
from ftac_gym.attitude import angle_between, mrp_from_quaternion, quaternion_from_mrp
from ftac_gym.baselines.components.predefined_time_gain import PredefinedTime
from ftac_gym.dynamics import Simulator
from ftac_gym.spacecraft.layouts import three_orthogonal
from ftac_gym.spacecraft.spacecraft import Spacecraft
from ftac_gym.spacecraft.wheel_array import WheelArray
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.references import MRPSinusoid

INERTIA = ((36.0, 0.0, 0.0), (0.0, 17.0, 0.0), (0.0, 0.0, 26.0))  # kg m^2
UNLIMITED = Spacecraft(INERTIA, WheelArray(three_orthogonal(), None, momentum_coupling=False))
START = InitialState.fixed(quaternion_from_mrp(np.array([0.3, -0.2, 0.2])).tolist())  # 89.6 deg


def fly(scenario, name, count, duration, **gains):
    """Return |z1|, |s|, (steps + 1, N), commands (steps, N, m) and final errors [deg]."""
    simulator, law = Simulator(scenario, count), baselines.make(name, scenario, count, **gains)
    simulator.reset(scenario.draw(2, count))
    errors, variables, commands = [], [], []
    for _ in range(round(duration / scenario.control_period)):
        measurement = simulator.measurement(truth=law.information == "oracle")
        difference = mrp_from_quaternion(measurement.attitude) - mrp_from_quaternion(measurement.reference_attitude)
        errors.append(np.linalg.norm(difference, axis=1))
        variables.append(np.linalg.norm(law.sliding_variable(measurement), axis=1))
        commands.append(law.act(measurement))
        simulator.step(commands[-1])
    final = np.degrees(angle_between(simulator.state.attitude, simulator.reference_attitude))
    return np.array(errors), np.array(variables), np.array(commands), final


@pytest.mark.parametrize("moving", [False, True], ids=["at rest", "moving"])
def test_reaching_times_are_the_closed_forms(moving):
    """On the nominal plant with a command every millisecond, to 5 ms, for six starts."""
    position, rate, period = PredefinedTime(0.25, 1.5), PredefinedTime(0.3, 1.0), 1e-3
    reference = {"reference": MRPSinusoid((0.2, 0.1, -0.1), (0.3, 0.2, 0.4), constant=(0.05, 0.0, 0.0))}
    scenario = task(
        3, period, None, spacecraft=UNLIMITED, initial_state=InitialState(angle=(0.2, 2.0), max_rate=0.4),
        **(reference if moving else {}),
    )  # fmt: skip
    errors, variables, _, _ = fly(
        scenario, "ptc_no_observer", 6, 2.5, switching_gain=0.0, position_time=1.5, rate_time=1.0
    )
    expected = rate.reaching_time(0.5 * variables[0] ** 2)
    for row in range(6):
        # What is left of a time below a small energy is known too.
        on_surface = np.argmax(variables[:, row] < 3e-5)
        arrived = on_surface * period + rate.reaching_time(0.5 * 3e-5**2)
        assert arrived == pytest.approx(expected[row], abs=5e-3)
        start = round(expected[row] / period)
        left = position.reaching_time(0.5 * errors[start, row] ** 2)
        at_target = np.argmax(errors[:, row] < 1e-5) * period + position.reaching_time(0.5 * 1e-5**2)
        assert at_target == pytest.approx(expected[row] + left, abs=5e-3)
        assert at_target < 2.5  # T1 + T2 bounds it
    assert np.ptp(expected) > 0.05  # it does depend on the start
    assert errors[-1].max() < 1e-5


def test_the_papers_start_settles_as_the_page_says():
    """At h1 = 0.25, 10 ms: 4.27 s and 20.5 N m without a limit, 7.25 s with 5 N m."""
    for limit, settling, torque in ((None, 4.27, 20.5), (5.0, 7.25, 5.0)):
        wheels = WheelArray(three_orthogonal(), limit, momentum_coupling=False)
        scenario = task(3, 0.01, None, spacecraft=Spacecraft(INERTIA, wheels), initial_state=START)
        errors, _, commands, final = fly(scenario, "ptc_no_observer", 1, 9.0)
        degrees = np.degrees(4.0 * np.arctan(errors[:, 0]))
        settled = 0.01 * (np.flatnonzero(degrees > 1.0)[-1] + 1)
        assert settled == pytest.approx(settling, abs=0.3)
        assert np.abs(commands[:400]).max() == pytest.approx(torque, rel=0.02)  # near the target V^-h makes spikes
        assert final[0] < 0.01


def test_an_exponent_of_one_half_does_not_arrive():
    """h1 as in Table 1, with 20 N m: full speed on arrival, and a limit cycle; none if V is regularised."""
    wheels = WheelArray(three_orthogonal(), 20.0, momentum_coupling=False)
    scenario = task(3, 0.01, None, spacecraft=Spacecraft(INERTIA, wheels), initial_state=START)
    last = {}
    for regularisation in (0.0, 1e-4):
        errors, _, _, _ = fly(
            scenario, "ptc_no_observer", 1, 8.0, position_exponent=0.5, position_regularisation=regularisation
        )
        last[regularisation] = np.degrees(4.0 * np.arctan(errors[-200:])).max()
    assert 2.0 < last[0.0] < 10.0  # deg; the paper's page says 3.5, later on
    assert last[1e-4] < 1e-3


def accelerations(form, sigma, rate, gain):
    """Return s and what the switching term adds to s', each (N, 3), at rates (N, 3) and one attitude."""
    scenario = task(3, 0.01, None, spacecraft=UNLIMITED)
    measurement = seen(rate, np.zeros((len(rate), 3)))
    attitude = np.tile(quaternion_from_mrp(sigma), (len(rate), 1))
    measurement = Measurement(**{**vars(measurement), "attitude": attitude})
    with_it, without = (
        baselines.make("ptc_no_observer", scenario, len(rate), switching_form=form, switching_gain=value)
        for value in (gain, 0.0)
    )
    torque = with_it.act(measurement) - without.act(measurement)
    added = torque @ np.linalg.inv(INERTIA) @ kinematic_matrix(sigma).T
    return with_it.sliding_variable(measurement), added


def test_the_printed_switching_need_not_oppose_the_surface():
    """s'G J^-1 sgn(s) < 0 for some s at |sigma| = 0.412; as an acceleration it always opposes."""
    rate = np.random.default_rng(0).normal(size=(4000, 3))
    variable, added = accelerations("torque", np.array([0.3, -0.2, 0.2]), rate, 1.0)
    power = (variable * added).sum(axis=1)
    assert 0.0 < (power > 0.0).mean() < 0.5
    variable, added = accelerations("acceleration", np.array([0.3, -0.2, 0.2]), rate, 1.0)
    np.testing.assert_allclose(added, -np.sign(variable), atol=1e-9)


@pytest.mark.parametrize(
    ("gains", "message"),
    [
        ({"position_exponent": 0.0}, r"exponent must lie within \(0, 1\)"),
        ({"rate_exponent": 1.0}, r"exponent must lie within \(0, 1\)"),
        ({"position_time": 0.0}, "time must be positive"),
        ({"rate_time": -1.0}, "time must be positive"),
        ({"position_regularisation": -1.0}, "regularisation must not be negative"),
        ({"rate_regularisation": np.nan}, "regularisation must be finite"),
        ({"switching_gain": -1.0}, "switching_gain must not be negative"),
        ({"switching_form": "force"}, r"switching_form must be one of \['torque', 'acceleration'\], got 'force'"),
        ({"layer": -1.0}, "layer must not be negative"),
    ],
)
def test_bad_gains(gains, message):
    with pytest.raises(ValueError, match=f"^ptc: .*{message}"):
        baselines.make("ptc", task(3, 0.01, None), **gains)


def test_as_printed_it_is_for_three_wheels():
    believed = baselines.make("ptc_printed", task(3, 0.01, None)).estimate
    assert (believed.effectiveness == 1.0).all() and not believed.identifiable.any()
    with pytest.raises(
        ValueError, match=r"^ptc_printed: first must have one row for each of the 4 wheels, got '3 rows'"
    ):
        baselines.make("ptc_printed", task(4, 0.01, None))
