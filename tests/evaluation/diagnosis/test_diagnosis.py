"""Diagnoses of flights: of estimators made for the test, of baselines, and of agents on a base."""

import re

import numpy as np
import pytest
from helpers.untrained_agents import write_agent

from ftac_gym import scenarios
from ftac_gym.agents.interface import Interface
from ftac_gym.baselines import Baseline, FaultEstimate
from ftac_gym.evaluation import AlarmRule, diagnose, diagnosis_of, rollout
from ftac_gym.evaluation.diagnosis import detection_rows, diagnosis_rows, diagnosis_table, kinds_table
from ftac_gym.evaluation.diagnosis.result import MEASURES
from ftac_gym.faults import Bias, FaultDistribution, HardOver, LossOfEffectiveness
from ftac_gym.policies import DeferredBaseline, ExternalPolicy, PolicyRunner, resolve

ONSET = (1.0, 8.0)
FAULTS = FaultDistribution(
    (
        HardOver(onset=ONSET, fraction=0.5),
        Bias(onset=ONSET, constant=0.1, duration=(3.0, 6.0)),
        LossOfEffectiveness(onset=ONSET, effectiveness=0.3),
    ),
    fault_counts=(0.2, 0.5, 0.3),
)
TASK = scenarios.get("flagship").replace(duration=20.0, faults=FAULTS)
EPISODES = TASK.draw(0, 6)


class _Told(Baseline):
    """A controller that does nothing, with alarms that are the truth."""

    information = "oracle"

    def _build(self):
        self._alarm = np.zeros((self.num_spacecraft, 4), dtype=bool)

    def act(self, measurement):
        truth = measurement.truth
        self._alarm = (truth.effectiveness < 1.0) | (np.abs(truth.bias) > 0.0)
        return np.zeros((len(measurement), 4))

    @property
    def estimate(self):
        return FaultEstimate(alarm=self._alarm)


class _Quiet(_Told):
    """The same without any alarm."""

    information = "attitude"

    def act(self, measurement):
        return np.zeros((len(measurement), 4))


def test_an_estimator_that_is_told_is_perfect_and_refused():
    history = rollout(TASK, _Told, EPISODES, estimates=True)
    found = diagnosis_of(history)
    measures = found.estimates()
    assert len(found.detections) == (EPISODES.faults["kind"] > 0).sum() > 4
    assert measures["detected"].value == measures["isolated"].value == 1.0
    assert measures["detection_delay"].high < TASK.control_period
    assert measures["false_alarms"].value == measures["false_alarm_time"].value == 0.0
    with pytest.raises(ValueError, match=r"policy must estimate faults from measurements.*got 'nftsm_oracle'"):
        diagnose(TASK, "nftsm_oracle", EPISODES)


def test_an_estimator_without_alarms_misses_everything():
    found = diagnose(TASK, _Quiet, EPISODES)
    measures = found.estimates()
    assert measures["detected"].value == 0.0 and measures["detection_delay"].value == np.inf
    assert np.isnan(measures["isolated"].value) and measures["false_alarms"].value == 0.0
    assert not np.isinf(found.detections["watched"]).any()


@pytest.mark.parametrize("policy", ["pd", "zero", "nftsm"])
def test_policies_that_do_not_estimate_are_refused_by_name(policy):
    with pytest.raises(ValueError, match=f"policy must estimate faults to be judged by a diagnosis, got '{policy}'"):
        diagnose(TASK, policy, EPISODES)
    with pytest.raises(ValueError, match="rule must be an AlarmRule or None, got 5"):
        diagnose(TASK, "nftsm_observer", EPISODES, rule=5)
    with pytest.raises(ValueError, match=f"policy must estimate faults where estimates are recorded, got '{policy}'"):
        rollout(TASK, policy, EPISODES, estimates=True)


@pytest.mark.parametrize(
    ("part", "shape", "wanted"),
    [("disturbance", (3,), "(6, 3)"), ("bias", (1, 4), "(6, 4)"), ("alarm", (6, 3), "(6, 4)")],
)
def test_an_estimate_of_another_shape_is_refused_by_name(part, shape, wanted):
    class Own:
        def predict(self, observation, state=None, episode_start=None, deterministic=True):
            self.estimate = FaultEstimate(**{part: np.zeros(shape)})
            return np.zeros((len(observation), 4)), None

    with pytest.raises(ValueError, match=re.escape(f"estimate.{part} must have shape {wanted}, got {shape}")):
        rollout(TASK, Own(), EPISODES, estimates=True)


def test_estimates_are_recorded_when_asked_for_and_change_nothing():
    plain, recorded = (rollout(TASK, "nftsm_observer", EPISODES, estimates=asked) for asked in (False, True))
    assert plain.estimates is None
    np.testing.assert_array_equal(plain.attitude_error, recorded.attitude_error)
    assert recorded.estimates.effectiveness.shape == recorded.command.shape
    assert recorded.estimates.identifiable.dtype == bool and recorded.estimates.alarm is None
    with pytest.raises(ValueError, match="history must have estimates"):
        diagnosis_of(plain)


def test_the_estimate_is_the_one_of_the_measurement_that_the_command_answers():
    runner = PolicyRunner(TASK, resolve("nftsm_telemetry"), len(EPISODES))
    runner.reset(EPISODES)
    rows = []
    for _ in range(30):
        runner.step()
        rows.append(runner.estimate.bias.copy())
    history = rollout(TASK, "nftsm_telemetry", EPISODES, estimates=True)
    np.testing.assert_array_equal(history.estimates.bias[:30], rows)
    assert not rows[0].any() and rows[1].any()


def test_side_by_side_or_one_by_one():
    together = diagnose(TASK, "nftsm_observer", EPISODES)
    singles = [diagnose(TASK, "nftsm_observer", EPISODES[index]) for index in range(len(EPISODES))]
    for index, one in enumerate(singles):
        own = together.detections[together.detections["episode"] == index].copy()
        own["episode"] = 0
        _assert_same(own, one.detections)
    for name in ("false_alarms", "healthy_time", "alarm_time"):
        np.testing.assert_array_equal(getattr(together, name), np.concatenate([getattr(one, name) for one in singles]))
    for part, sums in together.errors.items():
        for values, name in zip(sums, sums._fields, strict=True):
            parts = [getattr(one.errors[part], name) for one in singles]
            np.testing.assert_allclose(values, np.concatenate(parts), rtol=1e-12, atol=1e-20)


def _assert_same(first, second):
    assert first.dtype == second.dtype and len(first) == len(second)
    for name in first.dtype.names:  # Records with NaN are not equal to themselves.
        np.testing.assert_array_equal(first[name], second[name])


def test_batches_are_joined(monkeypatch):
    whole, counts = diagnose(TASK, "pd_dob", EPISODES), []
    monkeypatch.setattr("ftac_gym.evaluation.diagnosis.BATCH", 4)
    parts = diagnose(TASK, "pd_dob", EPISODES, progress=counts.append)
    assert counts == [4, 2]
    _assert_same(whole.detections, parts.detections)
    np.testing.assert_array_equal(whole.alarm_time, parts.alarm_time)


@pytest.mark.parametrize(
    "wrapper",
    [
        ("ResidualPolicy", {"base": "nftsm_observer", "authority": 0.5}),
        ("FaultEstimateObservation", {"source": "asmo"}),
    ],
)
def test_agents_have_the_estimates_of_base_and_wrapper(tmp_path, wrapper):
    path = write_agent(tmp_path / "agent", Interface("attitude", wrappers=(wrapper,)))
    found = diagnose(TASK, path, EPISODES)
    assert found.names_wheels and set(found.errors) == {"effectiveness", "bias", "torque"}


def test_a_residual_of_zero_has_the_estimates_of_its_base():
    zero = ExternalPolicy(lambda _: np.zeros(4), wrappers=[("ResidualPolicy", {"base": "nftsm_observer"})])
    own, base = (rollout(TASK, policy, EPISODES, estimates=True) for policy in (zero, "nftsm_observer"))
    np.testing.assert_array_equal(own.estimates.bias, base.estimates.bias)
    np.testing.assert_array_equal(own.estimates.disturbance, base.estimates.disturbance)
    scheduled = ExternalPolicy(lambda _: np.zeros(5), wrappers=[("GainScheduling", {"base": "pd_dob"})])
    own, base = (rollout(TASK, policy, EPISODES, estimates=True) for policy in (scheduled, "pd_dob"))
    np.testing.assert_array_equal(own.estimates.disturbance, base.estimates.disturbance)


def test_an_object_with_estimates_of_its_own():
    class Estimating:
        estimate = None

        def predict(self, observation, state=None, episode_start=None, deterministic=True):
            flags = np.zeros((len(observation), 4), dtype=bool)
            flags[:, 2] = True
            self.estimate = FaultEstimate(alarm=flags)
            return np.zeros((len(observation), 4)), None

    found = diagnose(TASK, Estimating(), EPISODES, name="mine")
    assert found.policy == "mine"
    np.testing.assert_array_equal(found.false_alarms, 1 + _stands_again())
    assert found.estimates()["detected"].value == 0.0


def _stands_again():
    """Return 1 for episodes in which all faults end, so that a standing alarm is wrong a second time."""
    ends = EPISODES.faults["recovery"] + AlarmRule().grace
    last = np.where(EPISODES.faults["kind"] > 0, ends, 0.0).max(axis=(1, 2))
    return ((last > 0.0) & (last < TASK.duration - TASK.control_period)).astype(int)


def test_tables_have_counts_and_only_measures_of_the_estimator():
    first = diagnose(TASK, DeferredBaseline("pd_dob", isolation="none"), EPISODES)
    second = diagnose(TASK, "nftsm_telemetry", EPISODES)
    cells = diagnosis_table([first, second])
    assert cells[0] == ["measure", "pd_dob", "nftsm_telemetry"]
    rows = {row[0]: row[1:] for row in cells[1:]}
    assert list(rows) == [
        "detected [share]", "detection delay [s]", "isolated [share]", "false alarms [1/h]", "false alarm time [share]",
        "bias error [N m]", "torque error [N m]",
    ]  # fmt: skip
    assert rows["isolated [share]"][0] == "-" and rows["bias error [N m]"][0] == "-"
    assert rows["detected [share]"][1].endswith(f"({len(second.detections)})")
    kinds = kinds_table([first, second])
    assert [row[0] for row in kinds[1:]] == ["loss of effectiveness", "bias", "hard over"]
    assert sum(int(row[1]) for row in kinds[1:]) == len(first.detections)
    assert "| measure | pd_dob |" in str(first) and "| fault | faults | pd_dob |" in first._repr_markdown_()
    lines = diagnosis_rows([first, second])
    assert {line[2] for line in lines[1:]} <= set(MEASURES) and all(len(line) == 9 for line in lines)
    faults = detection_rows([first, second])
    assert len(faults) == 1 + 2 * len(first.detections) and all(len(line) == 8 for line in faults)
