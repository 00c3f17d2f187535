"""PD about a shaped slew: the modes are left at rest, and everything that is asked of every law."""

import numpy as np
import pytest
from helpers.units import in_units
from hypothesis import given, settings
from hypothesis import strategies as st

from ftac_gym import baselines, scenarios
from ftac_gym.attitude import angle_between
from ftac_gym.baselines.controllers.pd_shaped import ShapedPD
from ftac_gym.dynamics import Simulator
from ftac_gym.faults import FaultSchedule, LossOfEffectiveness, Outage
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.references import SetPoints

FLEXIBLE, FLAGSHIP = scenarios.get("flexible"), scenarios.get("flagship")
QUIET = {"faults": None, "sensors": None, "disturbance": None, "inertia_uncertainty": None}
CERTAIN = FLEXIBLE.replace(**QUIET, appendage_uncertainty=None)
COUNT = 8


def fly(scenario, law, duration=70.0, seed=0):
    """Return the modal energies [J] and errors [deg], (steps, N), and the commands [N m]."""
    simulator = Simulator(scenario, law.num_spacecraft)
    simulator.reset(scenario.draw(seed, law.num_spacecraft))
    energies, errors, commands = [], [], []
    for _ in range(round(duration / scenario.control_period)):
        command = law.act(simulator.measurement())
        simulator.step(command)
        energies.append(simulator.modal_energy)
        errors.append(np.degrees(angle_between(simulator.state.attitude, simulator.reference_attitude)))
        commands.append(command)
    return np.array(energies), np.array(errors), np.array(commands)


def left(energies, scenario=CERTAIN, seconds=10.0):
    """Return the mean energy of each spacecraft over the last seconds [J]."""
    return energies[-round(seconds / scenario.control_period) :].mean(axis=0)


def recorded(scenario, steps=20, seed=1):
    """Return measurements along flights of a few spacecraft under random commands."""
    simulator, random = Simulator(scenario, COUNT), np.random.default_rng(seed)
    simulator.reset(scenario.draw(seed, COUNT))
    limits, measurements = scenario.spacecraft.wheels.torque_limits, []
    for _ in range(steps):
        measurements.append(simulator.measurement())
        simulator.step(limits * random.uniform(-1.0, 1.0, (COUNT, len(limits))))
    return measurements


# ----------------------------------------------------------------------------------------------------------- vibration


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("start", [None, InitialState(max_rate=0.02, angle=0.0), InitialState()])
def test_the_modes_are_left_at_rest(order, start):
    """After a turn with and without a first rate, and after a mere stop."""
    scenario = CERTAIN if start is None else CERTAIN.replace(initial_state=start)
    shaped, errors, _ = fly(scenario, ShapedPD(scenario, COUNT, order=order))
    assert errors[-1].max() < 1e-3
    for name in ("pd", "pd_dob"):
        usual, _, _ = fly(scenario, baselines.make(name, scenario, COUNT, prediction=False, calm_share=0.0))
        assert left(shaped).mean() < 1e-3 * left(usual).mean()
        assert (left(shaped) < 0.1 * left(usual)).all()


def test_it_is_the_shaper_that_does_it():
    energies = {modes: left(fly(CERTAIN, ShapedPD(CERTAIN, COUNT, shaped_modes=modes))[0]) for modes in (0, 1, None)}
    assert energies[None].mean() < 1e-3 * energies[1].mean()
    assert energies[1].mean() < 0.5 * energies[0].mean()


def test_wrong_frequencies_and_faults_are_borne():
    """Modes within 20 %, noise, disturbance, faults: in most spacecraft a hundredth of the vibration is left."""
    shaped, _, _ = fly(FLEXIBLE, ShapedPD(FLEXIBLE, 32), 90.0)
    usual, _, _ = fly(FLEXIBLE, baselines.make("pd_dob", FLEXIBLE, 32), 90.0)
    assert np.median(left(shaped)) < 1e-2 * np.median(left(usual))


def test_a_new_set_point_is_a_new_turn():
    """The maneuvers of Li et al. 2023, the second from where the first has led."""
    scenario = scenarios.get("li_2023").replace(faults=None, disturbance=None)
    shaped, errors, _ = fly(scenario, ShapedPD(scenario), 140.0)
    usual, _, _ = fly(scenario, baselines.make("pd_dob", scenario), 140.0)
    # The reference is that of the end of the step.
    first = round(80.0 / scenario.control_period) - 2
    assert errors[first, 0] < 1e-3 < 10.0 < errors[first + 1, 0]
    assert errors[-1, 0] < 1e-3
    assert left(shaped, scenario)[0] < 1e-2 * left(usual, scenario)[0]


def test_a_set_point_that_changes_on_the_way():
    turns = SetPoints(((1.0, 0.0, 0.0, 0.0), (0.6, 0.0, 0.8, 0.0)), (0.0, 15.0))
    scenario = CERTAIN.replace(reference=turns)
    shaped, errors, _ = fly(scenario, ShapedPD(scenario, COUNT), 90.0)
    assert errors[-1].max() < 1e-2
    # What the first turn had stirred up stays, but no more than a turn of the usual kind leaves.
    usual, _, _ = fly(scenario, baselines.make("pd_dob", scenario, COUNT), 90.0)
    assert left(shaped).mean() < 0.3 * left(usual).mean()


# ------------------------------------------------------------------------------------------------------------ the turn


def test_the_plan_is_kept_to_the_end():
    """A healthy hub stays within hundredths of a degree of a plan that starts where it is and ends at the target."""
    law, simulator = ShapedPD(CERTAIN, COUNT), Simulator(CERTAIN, COUNT)
    simulator.reset(CERTAIN.draw(0, COUNT))
    attitude, rate = simulator.state.attitude.copy(), simulator.state.rate.copy()
    for step in range(700):
        measurement = simulator.measurement()
        planned = law._planned(measurement)
        if step == 0:
            np.testing.assert_allclose(angle_between(planned.reference_attitude, attitude), 0.0, atol=1e-7)
            np.testing.assert_allclose(planned.reference_rate, rate, atol=1e-12)
        away = np.degrees(angle_between(planned.reference_attitude, measurement.attitude))
        assert away.max() < 0.05
        simulator.step(law.act(measurement))
    np.testing.assert_allclose(
        angle_between(planned.reference_attitude, measurement.reference_attitude), 0.0, atol=1e-7
    )
    np.testing.assert_allclose(planned.reference_rate, 0.0, atol=1e-9)
    np.testing.assert_allclose(planned.reference_acceleration, 0.0, atol=1e-9)


def test_planned_rates_are_those_of_the_planned_attitudes():
    law, measurement = ShapedPD(CERTAIN, COUNT), recorded(CERTAIN, 1)[0]
    arrays = {key: array for key, array in vars(measurement).items() if key != "time"}
    law.act(measurement)

    def planned(time):
        return law._planned(type(measurement)(time=np.full(COUNT, time), **arrays))

    for time in (0.35, 4.0, 9.7, 16.2, 31.0):
        small = 1e-4
        before, now, after = (planned(time + shift) for shift in (-small, 0.0, small))
        turned = np.einsum("ni,ni->n", before.reference_attitude, after.reference_attitude)
        np.testing.assert_allclose(np.abs(turned), 1.0, atol=1e-6)
        rate = angle_between(before.reference_attitude, after.reference_attitude) / (2.0 * small)
        np.testing.assert_allclose(rate, np.linalg.norm(now.reference_rate, axis=1), rtol=1e-4, atol=1e-6)
        step = CERTAIN.control_period
        gained = planned(time + step).reference_rate - now.reference_rate
        np.testing.assert_allclose(gained / step, now.reference_acceleration, atol=1e-12)


def test_a_rigid_craft_turns_without_a_shaper():
    scenario = FLAGSHIP.replace(**QUIET)
    _, errors, _ = fly(scenario, ShapedPD(scenario, COUNT), 60.0)
    assert errors[-1].max() < 1e-3
    slow = ShapedPD(scenario, COUNT, acceleration_share=0.2)
    assert (fly(scenario, slow, 20.0)[1][-1] > errors[200]).all()


def test_at_rest_on_target_nothing_is_commanded():
    start = CERTAIN.replace(initial_state=InitialState.fixed())
    energies, errors, commands = fly(start, ShapedPD(start), 5.0)
    for array in (energies, errors, commands):
        np.testing.assert_allclose(array, 0.0, atol=1e-12)


def test_the_rate_limit_is_kept():
    scenario = CERTAIN.replace(initial_state=InitialState(angle=(2.5, 3.0)))
    law, simulator = (
        ShapedPD(scenario, COUNT, **in_units("pd_shaped", scenario, rate_limit=0.05)),
        Simulator(scenario, COUNT),
    )
    simulator.reset(scenario.draw(0, COUNT))
    fastest = np.zeros(COUNT)
    for _ in range(700):
        simulator.step(law.act(simulator.measurement()))
        fastest = np.maximum(fastest, np.linalg.norm(simulator.state.rate, axis=1))
    np.testing.assert_allclose(fastest, 0.05, rtol=0.02)


@pytest.mark.parametrize(
    "faults",
    [
        FaultSchedule((Outage(wheel=0, onset=0.0),)),
        FaultSchedule(tuple(LossOfEffectiveness(wheel=wheel, effectiveness=0.4) for wheel in range(4))),
    ],
    ids=["outage", "all weak"],
)
def test_a_craft_that_falls_behind_comes_to_the_target(faults):
    """Wheels too weak for the plan: for a while they give all they have, but nothing winds up."""
    scenario = CERTAIN.replace(faults=faults)
    law = ShapedPD(scenario, COUNT)
    _, errors, commands = fly(scenario, law, 200.0)
    limits = scenario.spacecraft.wheels.torque_limits
    assert (np.abs(commands) / limits).max() == pytest.approx(1.0)
    assert errors[-1].max() < 0.05
    assert np.abs(law.estimate.disturbance).max() < limits.sum()


# ------------------------------------------------------------------------------------------- what all laws have to keep


@pytest.mark.parametrize("scenario", [FLEXIBLE, FLAGSHIP], ids=lambda scenario: scenario.name)
def test_acts_within_the_limits(scenario):
    law = ShapedPD(scenario, COUNT)
    _, _, commands = fly(scenario.replace(initial_state=InitialState(max_rate=0.2)), law, 20.0)
    assert np.isfinite(commands).all()
    assert (np.abs(commands) <= scenario.spacecraft.wheels.torque_limits * (1.0 + 1e-12)).all()
    for array in law.memory.copy().values():
        parts = [array] if array.dtype.names is None else [array[name] for name in array.dtype.names]
        assert all(np.isfinite(part).all() for part in parts)


def test_a_batch_equals_single_craft_and_resets_by_mask():
    turns = SetPoints(((1.0, 0.0, 0.0, 0.0), (0.6, 0.0, 0.8, 0.0)), (0.0, 1.5))
    scenario = FLEXIBLE.replace(reference=turns)
    together, alone = ShapedPD(scenario, COUNT), [ShapedPD(scenario) for _ in range(COUNT)]
    mask = np.arange(COUNT) % 3 == 0
    for step, measurement in enumerate(recorded(scenario)):
        if step == 10:
            together.reset(mask)
            for row in np.flatnonzero(mask):
                alone[row].reset()
        command = together.act(measurement)
        singly = [single.act(measurement.take(np.array([row]))) for row, single in enumerate(alone)]
        np.testing.assert_allclose(command, np.concatenate(singly), rtol=1e-9, atol=1e-12)


def test_a_reset_forgets_the_plan():
    measurements, law = recorded(FLEXIBLE), ShapedPD(FLEXIBLE, COUNT)
    first = [law.act(measurement) for measurement in measurements]
    law.reset()
    for command, measurement in zip(first, measurements, strict=True):
        np.testing.assert_array_equal(law.act(measurement), command)


def test_acting_for_some_leaves_the_plans_of_others():
    measurements, law, mask = recorded(FLEXIBLE), ShapedPD(FLEXIBLE, COUNT), np.arange(COUNT) < 3
    law.act_only(measurements[0], mask)
    np.testing.assert_array_equal(law.memory["slew_unplanned"], ~mask)


@settings(max_examples=10, deadline=None)
@given(data=st.data())
def test_every_point_of_the_search_space_makes_the_law(data):
    point = {key: data.draw(st.floats(item.low, item.high), label=key) for key, item in ShapedPD.space().items()}
    gains = ShapedPD.gains_at(point)
    assert ShapedPD.point_of(gains) == pytest.approx(point)
    assert np.isfinite(ShapedPD(FLEXIBLE, COUNT, **gains).act(recorded(FLEXIBLE, 1)[0])).all()


@pytest.mark.parametrize(
    ("gains", "message"),
    [
        ({"acceleration_share": 0.0}, "acceleration_share must be positive"),
        ({"acceleration_share": 1.1}, "acceleration_share must not exceed 1, got 1.1"),
        ({"order": 0}, "order must be a whole number, 1 or more, got 0"),
        ({"shaped_modes": -1}, "shaped_modes must be a whole number, 0 or more, got -1"),
        ({"rate_limit": -0.1}, "rate_limit must be positive"),
        ({"bandwidth": 0.0}, "bandwidth must be positive"),
    ],
)
def test_bad_gains(gains, message):
    with pytest.raises(ValueError, match=message):
        ShapedPD(FLEXIBLE, **gains)


def test_a_moving_reference_is_refused():
    with pytest.raises(ValueError, match=r"reference must be at rest.*'MRPSinusoid'"):
        ShapedPD(scenarios.get("flagship_tracking"))
