"""Episodes of one scenario in another: the same plant and reference, and labels of the scenario that flies them."""

import dataclasses

import numpy as np
import pytest

from ftac_gym import Simulator, scenarios
from ftac_gym.envs import SpacecraftFTCEnv
from ftac_gym.evaluation import rollout
from ftac_gym.faults import CustomKind, FaultSchedule, WheelFault, register
from ftac_gym.faults.live import add_fault
from ftac_gym.faults.wheel_faults import Outage
from ftac_gym.spacecraft import Spacecraft
from ftac_gym.task import InertiaUncertainty, RewardWeights, SetPoints, SuccessCriterion
from ftac_gym.task.fitting import fitted
from ftac_gym.utils import serialization

TASK = scenarios.get("flagship")
COUNT = 300


@pytest.fixture(scope="module")
def episodes():
    return TASK.draw(5, COUNT)


@pytest.mark.parametrize(
    "changes",
    [
        {"duration": 40.0},
        {"duration": 300.0},
        {"success": SuccessCriterion(hold=90.0)},
        {"success": SuccessCriterion(angle=1e-6, rate=1e-8)},
        {"success": SuccessCriterion(angle=3.0, rate=1.0)},
    ],
)
def test_labels_are_those_of_the_scenario_that_flies(changes, episodes):
    other = TASK.replace(**changes)
    own = other.draw(5, COUNT)
    assert (own.feasible != episodes.feasible).any()
    assert fitted(episodes, other).digest() == own.digest()
    simulator = Simulator(other, COUNT)
    simulator.reset(episodes)
    np.testing.assert_array_equal(simulator.feasible, own.feasible)
    assert simulator.episodes.digest() == own.digest()


def test_environments_and_rollouts_use_these_labels(episodes):
    other = TASK.replace(duration=4.0, success=SuccessCriterion(hold=1.0))
    changed = int(np.flatnonzero(fitted(episodes, other).feasible != episodes.feasible)[0])
    expected = not episodes.feasible[changed]
    env = SpacecraftFTCEnv(other)
    assert env.reset(options={"episodes": episodes[changed]})[1]["feasible"] == expected
    history = rollout(other, "pd", episodes[changed])
    assert history.episodes.feasible[0] == expected
    assert len(history.feasible_metrics()["success"]) == int(expected)


@pytest.mark.parametrize(
    "changes",
    [
        {"reward": RewardWeights(progress=1.0)},
        {"faults": None, "tumble_rate": None, "name": "other"},
        {"control_period": 0.02},
        {"success": SuccessCriterion(angle=0.1)},
    ],
)
def test_labels_stay_where_nothing_of_them_changes(changes, episodes):
    simulator = Simulator(TASK, 2)
    simulator.reset(episodes[:2])
    faults = add_fault(simulator.faults, 0, Outage(wheel=0), 0.0, np.full(4, 0.2), np.random.default_rng(0))
    simulator.set_faults(faults)
    live = simulator.episodes
    kept = fitted(live, TASK.replace(**changes))
    np.testing.assert_array_equal(kept.feasible, episodes.feasible[:2])
    assert kept.scenario_json == TASK.replace(**changes).to_json()
    assert fitted(live, TASK) is live


def heavier():
    inertia = 1.1 * TASK.spacecraft.inertia_matrix
    return TASK.replace(spacecraft=Spacecraft(inertia, TASK.spacecraft.wheels))


@pytest.mark.parametrize(
    ("other", "part"),
    [
        (heavier(), "spacecraft"),
        (TASK.replace(reference=SetPoints(((0.0, 1.0, 0.0, 0.0),))), "reference"),
        (TASK.replace(misalignment=np.full((3, 4), 1e-3)), "misalignment"),
        (TASK.replace(inertia_uncertainty=InertiaUncertainty(rate_torque=True)), "rate_torque"),
    ],
)
def test_episodes_of_another_plant_or_reference_are_refused(other, part):
    foreign, env = other.draw(0, 1), SpacecraftFTCEnv(TASK)
    for use in (
        lambda: Simulator(TASK, 1).reset(foreign),
        lambda: env.reset(seed=0, options={"episodes": foreign}),
        lambda: rollout(TASK, "pd", foreign),
        lambda: fitted(foreign, TASK),
    ):
        with pytest.raises(ValueError, match=f"^episodes must be drawn for the same {part} as flagship's, got 'flag"):
            use()


def test_episodes_without_the_tables_of_the_task_are_refused_at_once():
    """Later the environment's own episodes would not fit."""
    with pytest.raises(ValueError, match=r"episodes must fit the scenario: harmonics must have shape \(1, 1\)"):
        Simulator(TASK, 1).reset(TASK.replace(disturbance=None).draw(0, 1))


def test_text_that_is_no_scenario_is_refused(episodes):
    for text in ("", "{}", '{"type": "Scenario"}', None, 3):
        with pytest.raises(ValueError, match=r"^scenario"):
            fitted(dataclasses.replace(episodes, scenario_json=text), TASK)
    with pytest.raises(ValueError, match="episodes must be an Episodes object, got None"):
        Simulator(TASK, 1).reset(None)


@pytest.mark.parametrize(
    ("field", "number", "rule"),
    [("delay", 99, r"within \[0, 5\], got 99"), ("bias", np.nan, "finite, got nan"), ("onset", -1.0, "finite and not")],
)
def test_draws_of_a_kind_from_outside_are_checked(field, number, rule, monkeypatch):
    monkeypatch.setattr(serialization, "_CLASSES", serialization.classes())

    @register
    @dataclasses.dataclass(frozen=True, kw_only=True)
    class Wild(WheelFault):
        kind = CustomKind(100, "wild")

        def _fill(self, rows, uniform, torque_limit):
            rows[field] = number

    with pytest.raises(ValueError, match=rf"^Wild\.{field} must be {rule}"):
        TASK.replace(faults=FaultSchedule((Wild(wheel=0),))).draw(0, 2)


def edited(name, table, field, place, number):
    """An episode of a scenario with one number changed."""
    scenario = scenarios.get(name)
    drawn = scenario.draw(0, 1)
    changed = getattr(drawn, table).copy()
    changed[field][(0, *place)] = number
    return scenario, dataclasses.replace(drawn, **{table: changed})


@pytest.mark.parametrize(
    ("name", "table", "field", "place", "numbers"),
    [
        ("flagship", "disturbance", "constant", (0,), (1e308, 1e8, 1e3, -1e3)),
        ("flagship", "harmonics", "sine", (0, 1), (1e308, 1e6)),
        ("flagship", "harmonics", "cosine", (0, 2), (-1e308, 1e6)),
        ("flagship", "harmonics", "frequency", (0,), (1e308, 1e3)),
        ("flagship", "inertia", "constant", (2, 2), (1e308, 1e6, 1e4)),
        ("chen_2018", "disturbance", "rate_offset", (), (1e308, 2147483647.0)),
        ("chen_2018", "disturbance", "constant", (0,), (1e308, 1e8, 1e3)),
        ("flagship_tracking", "reference", "amplitude", (0,), (-1e308, 1e6)),
        ("ma_2023_faulty", "reference", "amplitude", (0,), (-1e308, 1e6)),
        ("ma_2023_faulty", "reference", "constant", (0,), (-1e308, 1e3)),
        ("li_2023", "initial", "wheel_momentum", (0,), (1e308, 1e14)),
        ("flagship", "sensors", "gyro_bias", (0,), (1e308, 1e14)),
        ("ma_2023_faulty", "sensors", "rate_noise", (), (1e308, 1e14)),
    ],
)
def test_numbers_that_the_plant_cannot_integrate_are_refused(name, table, field, place, numbers):
    for number in numbers:
        scenario, attacked = edited(name, table, field, place, number)
        with pytest.raises(ValueError, match=rf"^episodes\.{table}\.\w+ ") as caught:
            fitted(attacked, scenario)
        assert "must" in str(caught.value) and ", got " in str(caught.value)


@pytest.mark.parametrize("name", scenarios.names())
def test_every_scenario_flies_its_own_episodes(name):
    scenario = scenarios.get(name)
    drawn = scenario.draw(11, 50)
    assert fitted(drawn, scenario) is drawn


@pytest.mark.parametrize("number", [0.1, 1.0, -2.0])
def test_a_larger_torque_that_the_plant_integrates_is_accepted(number):
    scenario, pushed = edited("flagship", "disturbance", "constant", (0,), number)
    assert fitted(pushed, scenario) is pushed
