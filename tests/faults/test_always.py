"""Faults that a distribution has in every episode, beside the random ones."""

import dataclasses
import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import ftac_gym
from ftac_gym import scenarios
from ftac_gym.evaluation import fault_classes, rollout
from ftac_gym.evaluation.tables import ordered
from ftac_gym.faults import (
    AttitudeSpike,
    Bias,
    FaultDistribution,
    FaultSchedule,
    GyroBiasStep,
    HardOver,
    IntermittentShutdown,
    LossOfEffectiveness,
    Outage,
    StarTrackerOutage,
)
from ftac_gym.task import Scenario
from ftac_gym.task.fitting import fitted

FLAGSHIP = scenarios.get("flagship")
KINDS = (Outage(onset=(1.0, 9.0)), IntermittentShutdown(onset=2.0), AttitudeSpike(onset=3.0, duration=1.0))
RANDOM = FaultDistribution(KINDS, fault_counts=(0.2, 0.4, 0.4))
WEAK = LossOfEffectiveness(wheel=1, effectiveness=(0.4, 0.6))
DRIFTED = GyroBiasStep(size=1e-4)
BOTH = FaultDistribution(KINDS, fault_counts=(0.2, 0.4, 0.4), always=(WEAK, DRIFTED))


def drawn(source, seed=4, count=400):
    return FLAGSHIP.replace(faults=source).draw(seed, count)


def test_they_are_in_every_episode_and_the_random_ones_are_as_before():
    with_them, without = drawn(BOTH), drawn(RANDOM)
    assert with_them.faults.shape == (400, 4, 2) and with_them.sensor_faults.shape == (400, 3)
    np.testing.assert_array_equal(with_them.faults[:, :, 0], without.faults[:, :, 0])
    np.testing.assert_array_equal(with_them.sensor_faults[:, :2], without.sensor_faults)
    np.testing.assert_array_equal(with_them.switches, without.switches)
    always = with_them.faults[:, 1, 1]
    assert np.all(always["kind"] == WEAK.kind) and np.all(always["onset"] == 0.0)
    assert 0.4 < always["effectiveness"].min() < 0.42 and 0.58 < always["effectiveness"].max() < 0.6
    assert np.all(with_them.faults["kind"][:, [0, 2, 3], 1] == 0)
    assert np.all(with_them.sensor_faults["kind"][:, 2] == DRIFTED.kind)


def test_counts():
    kinds = np.concatenate([drawn(BOTH).faults["kind"].reshape(400, -1), drawn(BOTH).sensor_faults["kind"]], axis=1)
    counts = (kinds > 0).sum(axis=1)
    assert set(counts) == {2, 3, 4}
    np.testing.assert_allclose(np.bincount(counts, minlength=5)[2:] / 400, [0.2, 0.4, 0.4], atol=0.07)
    assert BOTH.most_faults == 4


def test_severity_is_about_the_random_ones():
    episodes = drawn(dataclasses.replace(BOTH, severity=0.0))
    assert np.all((episodes.faults["kind"] > 0).sum(axis=(1, 2)) == 1)
    np.testing.assert_array_equal(episodes.faults[:, 1, 1], drawn(BOTH).faults[:, 1, 1])


def test_random_chains_of_both_sorts_have_rows_of_their_own():
    shut = IntermittentShutdown(wheel=3, mean_acting=2.0, mean_resting=9.0)
    episodes = drawn(FaultDistribution(KINDS, always=(WEAK, shut)))
    # One slot, and a row for each of the two faults that are always there.
    assert episodes.switches.shape[1] == 3
    assert np.all(episodes.faults["chain"][:, 3, 1] == 2)
    flips = episodes.switches[:, 2]
    assert np.all(np.diff(flips, axis=1) >= 0.0) and np.all(flips[:, 0] > 0.0)
    assert np.mean(np.diff(flips[:, :2], axis=1)) == pytest.approx(9.0, rel=0.2)


def test_a_distribution_without_random_faults_flies_as_the_schedule():
    task = FLAGSHIP.replace(duration=20.0, sensors=None)
    faults = (HardOver(wheel=2, onset=3.0, fraction=0.3, random_sign=False), StarTrackerOutage(onset=5.0))
    healthy = FaultDistribution((Outage(),), fault_counts=(1.0, 0.0), always=faults)
    flights = [rollout(task.replace(faults=source), "pd_dob", seed=2) for source in (healthy, FaultSchedule(faults))]
    np.testing.assert_array_equal(flights[0].attitude, flights[1].attitude)


def test_faults_of_one_wheel_act_together():
    source = FaultDistribution((Bias(constant=0.05),), always=tuple(LossOfEffectiveness(wheel=j) for j in range(4)))
    episodes = drawn(source, count=100)
    # The random fault lies on a wheel that has another one.
    assert np.all(((episodes.faults["kind"] > 0).sum(axis=2) == 2).sum(axis=1) == 1)


def test_classes_are_those_of_the_random_faults():
    classes, before = fault_classes(drawn(BOTH)), fault_classes(drawn(RANDOM))
    np.testing.assert_array_equal(classes == "always-on only", before == "healthy")
    np.testing.assert_array_equal(classes[before != "healthy"], before[before != "healthy"])
    assert ordered(classes)[0] == "always-on only"
    # Episodes of another source are classed by all of their faults.
    source = FaultSchedule((Outage(wheel=0), Outage(wheel=1)))
    others = fitted(drawn(source, count=2), FLAGSHIP.replace(faults=BOTH))
    assert fault_classes(others).tolist() == ["2 faults"] * 2


def test_the_first_onset_is_that_of_a_fault_that_begins_in_the_episode():
    found, before = drawn(BOTH).first_onset, drawn(RANDOM).first_onset
    np.testing.assert_array_equal(found, np.where(np.isinf(before), 0.0, before))
    late = FaultDistribution(KINDS, always=(Outage(wheel=0, onset=0.5),))
    assert np.all(drawn(late).first_onset == 0.5)


def test_infos_list_them_first():
    env = ftac_gym.SpacecraftFTCVectorEnv(num_envs=30, scenario=FLAGSHIP.replace(faults=BOTH), render_mode=None)
    _, info = env.reset(seed=3)
    assert info["fault/kind"].shape == (30, 4)
    first = np.sort(info["fault/kind"][:, :2], axis=1)
    assert np.all(first == sorted([WEAK.kind, DRIFTED.kind])) and np.all(info["fault/onset"][:, :2] == 0.0)
    assert info["fault/active"][:, :2].all() and not info["fault/active"][:, 2:].any()


def test_the_label_knows_them():
    two = tuple(Outage(wheel=j) for j in (0, 1))
    assert not drawn(FaultDistribution(KINDS, fault_counts=(1.0, 0.0), always=two)).feasible.any()


def test_the_text_of_a_distribution_without_them_is_as_before():
    assert "always" not in FLAGSHIP.to_json()


placed = st.one_of(
    st.builds(LossOfEffectiveness, wheel=st.integers(0, 3), effectiveness=st.floats(0.1, 0.9)),
    st.builds(IntermittentShutdown, wheel=st.integers(0, 3)),
    st.builds(GyroBiasStep, size=st.floats(0.0, 1e-3)),
)


@settings(max_examples=30, deadline=None, derandomize=True)
@given(st.lists(placed, max_size=6))
def test_any_of_them_survive_json_and_a_file(always):
    scenario = FLAGSHIP.replace(faults=FaultDistribution(KINDS, always=always))
    again = Scenario.from_dict(json.loads(scenario.to_json()))
    assert again == scenario and again.draw(1, 3).digest() == scenario.draw(1, 3).digest()


def test_saved_episodes_load(tmp_path):
    episodes = drawn(BOTH, count=5)
    episodes.save(tmp_path / "episodes.npz")
    assert type(episodes).load(tmp_path / "episodes.npz").digest() == episodes.digest()


def test_short_forms():
    task = FLAGSHIP.replace(faults=RANDOM)
    assert task.replace(faults="+loss_of_effectiveness:1,effectiveness=0.4..0.6").faults.always == (WEAK,)
    added = task.replace(faults={"always": [WEAK]}).replace(faults="+gyro_bias_step@0,size=1e-4")
    assert added.faults == BOTH
    assert task.replace(faults=FaultSchedule((DRIFTED,))).replace(faults="+outage:0").faults.faults == (
        DRIFTED,
        Outage(wheel=0),
    )
    assert task.replace(faults=None).replace(faults="+outage:0@5").faults == FaultSchedule(
        (Outage(wheel=0, onset=5.0),)
    )


@pytest.mark.parametrize(
    ("always", "message"),
    [
        ((Outage(),), "always must each name a wheel"),
        (Outage(wheel=0), "always must be a tuple of Fault objects"),
        ((3,), "always must hold Fault objects of a concrete kind"),
    ],
)
def test_what_is_refused(always, message):
    with pytest.raises(ValueError, match=message):
        FaultDistribution(KINDS, always=always)


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        (Outage(wheel=4), r"faults\.always\[0\]\.wheel must be below the number of wheels, 4"),
        (Bias(wheel=1, constant=1e13), r"faults\.always\[0\]\.constant must be within"),
        (GyroBiasStep(size=1e3), r"faults\.always\[0\]\.size must be at most"),
    ],
)
def test_what_a_scenario_refuses(fault, message):
    with pytest.raises(ValueError, match=message):
        FLAGSHIP.replace(faults=FaultDistribution(KINDS, always=(fault,)))
