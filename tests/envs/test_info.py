"""Entries of ``info``: availability, cost, and the true faults."""

import numpy as np
import pytest

from ftac_gym import scenarios
from ftac_gym.attitude import mrp_from_quaternion, quaternion_error
from ftac_gym.envs import SpacecraftFTCEnv, SpacecraftFTCVectorEnv
from ftac_gym.faults import AttitudeSpike, Bias, FaultKind, FaultSchedule, LossOfEffectiveness, Outage
from ftac_gym.faults.description import acting_faults
from ftac_gym.faults.live import add_fault
from ftac_gym.task import CostBounds, InitialState, Scenario, SuccessCriterion

QUIET = {"faults": None, "sensors": None, "disturbance": None, "inertia_uncertainty": None}
MIXED = FaultSchedule(
    (
        Outage(wheel=2, onset=3.0, duration=1.0),
        AttitudeSpike(onset=1.0, duration=0.5, angle=0.1),
        Bias(wheel=0, onset=0.5, constant=0.01, period=1.0, on_time=0.3),
        LossOfEffectiveness(wheel=2, onset=2.0, effectiveness=0.5),
    )
)


def test_availability_is_the_share_of_the_periods_so_far():
    """A break ends a success, not the share."""
    cone = SuccessCriterion(angle=0.01, rate=0.5, hold=1.0)
    env = SpacecraftFTCEnv(success=cone, initial_state=InitialState.fixed(), duration=30.0, **QUIET)
    assert env.reset(seed=0)[1]["availability"] == 0.0
    inside = []
    for step in range(60):
        info = env.step(np.array([1.0, -1.0, -1.0, 1.0]) * (1.0 if step < 30 else -1.0))[4]
        inside.append(np.radians(info["attitude_error"]) < cone.angle)
        assert info["availability"] == np.mean(inside) and type(info["availability"]) is float
    assert not info["is_success"] and 0.0 < info["availability"] < 1.0
    assert env.reset()[1]["availability"] == 0.0


@pytest.mark.parametrize(
    ("bounds", "push", "cost"),
    [
        (CostBounds(angle=0.2), 0.5, 0.1),
        (CostBounds(angle=0.4), 0.5, 0.0),
        (CostBounds(angle=0.4), 1.0, 0.1),
        (CostBounds(angle=0.4, torque=0.4), 0.5, 0.1),
        (CostBounds(angle=0.4, torque=0.6), 0.5, 0.0),
        (CostBounds(), 0.5, 0.1),
    ],
)
def test_cost_is_the_time_outside_the_bounds(bounds, push, cost):
    start = InitialState.fixed((np.cos(0.15), np.sin(0.15), 0.0, 0.0))
    env = SpacecraftFTCEnv(cost_bounds=bounds, initial_state=start, **QUIET)
    assert env.reset(seed=0)[1]["cost"] == 0.0
    assert env.step(np.array([0.0, 0.0, push, 0.0]))[4]["cost"] == cost


def test_a_prescribed_bound_is_the_bound_of_the_cost():
    task = scenarios.get("chen_2018").replace(duration=30.0, control_period=0.05)
    env = SpacecraftFTCVectorEnv(1, scenario=task)
    env.reset(seed=0)
    costs = []
    for _ in range(400):
        simulator = env.batch.simulator
        costs.append(env.step(np.zeros((1, 3)))[4]["cost"][0])
        error = quaternion_error(simulator.state.attitude, simulator.reference_attitude)
        margin = task.prescribed_bound.margin(mrp_from_quaternion(error), simulator.time).min()
        assert costs[-1] == (0.05 if margin < 0.0 else 0.0)
    assert len(set(costs)) == 2
    wide = SpacecraftFTCEnv(scenario=task, cost_bounds=CostBounds(angle=3.0))
    wide.reset(seed=0)
    assert wide.step(np.zeros(3))[4]["cost"] == 0.0


def test_bounds_of_the_cost_are_written_where_they_are_set():
    task = scenarios.get("flagship")
    assert "cost_bounds" not in task.to_dict()
    other = task.replace(cost_bounds=CostBounds(0.1, 0.5))
    assert Scenario.from_json(other.to_json()) == other
    for field in ("angle", "torque"):
        with pytest.raises(ValueError, match=f"{field} must be positive"):
            CostBounds(**{field: 0.0})


def test_the_faults_are_those_of_the_episode_in_the_order_of_their_onsets():
    env = SpacecraftFTCEnv(faults=MIXED, duration=6.0)
    _, info = env.reset(seed=0)
    kinds = [FaultKind(kind).label for kind in info["fault/kind"]]
    assert kinds == ["bias", "attitude spike", "loss of effectiveness", "outage"]
    assert info["fault/wheel"].tolist() == [0, -1, 2, 2]
    assert info["fault/onset"].tolist() == [0.5, 1.0, 2.0, 3.0]
    acting = np.array([env.step(np.zeros(4))[4]["fault/active"] for _ in range(55)]).T
    time = np.arange(1, 56) / 10
    expected = [((time - 0.5) % 1.0 < 0.299) & (time > 0.49), (time > 0.99) & (time < 1.49)]
    expected += [time > 1.99, (time > 2.99) & (time < 3.99)]
    np.testing.assert_array_equal(acting[1:], expected[1:])
    assert (acting[0] != expected[0]).sum() <= 5  # Where rounding decides whether a period has begun.


@pytest.mark.parametrize("name", ["flagship", "flagship_unseen", "flagship_double"])
def test_active_faults_are_those_that_frames_name(name):
    env = SpacecraftFTCVectorEnv(64, scenario=name, duration=60.0, tumble_rate=None)
    env.reset(seed=1)
    seen = 0
    for _ in range(30):
        for _ in range(19):
            env.step(np.zeros((64, 4)))
        infos = env.step(np.zeros((64, 4)))[4]
        simulator = env.batch.simulator
        acting = [len(item.descriptions) for item in acting_faults(simulator.faults, simulator.time)]
        np.testing.assert_array_equal(infos["fault/active"].sum(axis=1), acting)
        seen += sum(acting)
    assert seen > 100


def test_a_healthy_spacecraft_has_an_entry_without_a_fault_and_then_the_one_that_is_added():
    env = SpacecraftFTCEnv(**QUIET)
    _, info = env.reset(seed=0)
    assert [info[f"fault/{part}"].tolist() for part in ("kind", "wheel", "onset", "active")] == [
        [0], [-1], [-1.0], [False],
    ]  # fmt: skip
    simulator = env.batch.simulator
    simulator.set_faults(
        add_fault(simulator.faults, 0, Outage(wheel=1), 0.0, np.full(4, 0.2), np.random.default_rng(0))
    )
    info = env.step(np.zeros(4))[4]
    assert [info[f"fault/{part}"].tolist() for part in ("kind", "wheel", "onset", "active")] == [
        [3], [1], [0.0], [True],
    ]  # fmt: skip
    env.reset()
    assert env.step(np.zeros(4))[4]["fault/kind"].tolist() == [0]


def test_infos_of_faults_are_the_callers():
    env = SpacecraftFTCEnv(faults=MIXED)
    _, info = env.reset(seed=0)
    for name in ("kind", "wheel", "onset", "active"):
        info[f"fault/{name}"][:] = 1
    again = env.step(np.zeros(4))[4]
    assert again["fault/wheel"].tolist() == [0, -1, 2, 2] and again["fault/onset"].tolist() == [0.5, 1.0, 2.0, 3.0]
