"""Evaluations in batches that survive a kill."""

from importlib import import_module

import numpy as np
import pytest

from ftac_gym import scenarios
from ftac_gym.evaluation import Evaluation, evaluate, rollout
from ftac_gym.policies import DeferredBaseline

SHORT = scenarios.get("flagship").replace(duration=5.0)
EPISODES = SHORT.draw(3, 7)


@pytest.fixture
def small_batches(monkeypatch):
    """Three episodes to a batch, so that seven episodes make three batches; counts the rollouts."""
    module = import_module("ftac_gym.evaluation.batches")
    calls = []

    def counted(scenario, policy, episodes):
        calls.append(len(episodes))
        return rollout(scenario, policy, episodes)

    monkeypatch.setattr(module, "BATCH", 3)
    monkeypatch.setattr(module, "rollout", counted)
    return calls


def assert_same(first, second, exact=True):
    assert first.policy == second.policy and list(first.metrics) == list(second.metrics)
    tolerance = {"rtol": 0.0, "atol": 0.0} if exact else {"rtol": 1e-7, "atol": 1e-9}
    for name, values in first.metrics.items():
        np.testing.assert_allclose(second.metrics[name], values, **tolerance, err_msg=name)
    for name in ("attitude_error", "relative_error"):
        values, others = getattr(first, name), getattr(second, name)
        np.testing.assert_allclose(others, values, rtol=0.0 if exact else 1e-5, atol=1e-7, err_msg=name)
    for name in ("kind", "onset", "time", "recovered", "peak"):
        values, others = (getattr(item.recoveries, name) for item in (first, second))
        np.testing.assert_allclose(others, values, **tolerance, err_msg=name)


def test_an_evaluation_is_a_rollout(small_batches):
    finished = []
    evaluation = evaluate(SHORT, "pd", EPISODES, progress=finished.append)
    history = rollout(SHORT, "pd", EPISODES)
    errors = np.degrees(history.attitude_error), np.degrees(history.relative_error)
    assert_same(evaluation, Evaluation("pd", history.metrics(), *errors, history.recoveries()), exact=False)
    assert evaluation.attitude_error.dtype == np.float32 and evaluation.attitude_error.shape == (51, 7)
    assert small_batches == finished == [3, 3, 1]


def test_finished_batches_are_not_run_again(small_batches, tmp_path):
    folder = tmp_path / "deep" / "batches"
    first = evaluate(SHORT, "pd", EPISODES, folder=folder)
    assert small_batches == [3, 3, 1]
    assert_same(evaluate(SHORT, "pd", EPISODES, folder=folder), first)
    assert_same(evaluate(SHORT, DeferredBaseline("pd"), EPISODES, name="pd", folder=folder), first)
    assert small_batches == [3, 3, 1]
    assert_same(evaluate(SHORT, "pd", EPISODES), first)


def test_a_kill_loses_only_the_batch_in_hand(small_batches, tmp_path):
    class KilledError(Exception):
        pass

    def kill(count):
        if len(small_batches) == 2:
            raise KilledError

    with pytest.raises(KilledError):
        evaluate(SHORT, "pd", EPISODES, folder=tmp_path, progress=kill)
    (tmp_path / "half_written.partial").write_bytes(b"PK")
    resumed = evaluate(SHORT, "pd", EPISODES, folder=tmp_path)
    assert small_batches == [3, 3, 1]
    assert_same(resumed, evaluate(SHORT, "pd", EPISODES))


def test_a_kill_while_writing_leaves_no_broken_batch(small_batches, tmp_path, monkeypatch):
    class KilledError(Exception):
        pass

    def half(file, **arrays):
        file.write(b"PK\x03\x04 half a file")
        raise KilledError

    with monkeypatch.context() as patch:
        patch.setattr(np, "savez_compressed", half)
        with pytest.raises(KilledError):
            evaluate(SHORT, "pd", EPISODES, folder=tmp_path)
    assert_same(evaluate(SHORT, "pd", EPISODES, folder=tmp_path), evaluate(SHORT, "pd", EPISODES))


@pytest.mark.parametrize(
    ("scenario", "policy", "episodes"),
    [
        (SHORT, "pd_dob", EPISODES),
        (SHORT, DeferredBaseline("pd", braking_share=0.33), EPISODES),
        (SHORT, "pd", SHORT.draw(4, 7)),
        (SHORT.replace(faults=None), "pd", SHORT.replace(faults=None).draw(3, 7)),
    ],
    ids=["policy", "gains", "seed", "scenario"],
)
def test_something_else_is_run(small_batches, tmp_path, scenario, policy, episodes):
    evaluate(SHORT, "pd", EPISODES, folder=tmp_path)
    evaluation = evaluate(scenario, policy, episodes, name="other", folder=tmp_path)
    assert small_batches == [3, 3, 1] * 2
    np.testing.assert_array_equal(evaluation.metrics["return"], evaluate(scenario, policy, episodes).metrics["return"])


def test_the_task_is_part_of_what_a_batch_was_made_by(small_batches, tmp_path):
    """The same episodes flown under another criterion, or for longer, are something else."""
    evaluate(SHORT, "pd", EPISODES, folder=tmp_path)
    longer = SHORT.replace(duration=6.0)
    evaluation = evaluate(longer, "pd", EPISODES, folder=tmp_path)
    assert evaluation.attitude_error.shape == (61, 7)
    assert_same(evaluation, evaluate(longer, "pd", EPISODES))


def test_a_policy_without_fingerprint_is_always_run(small_batches, tmp_path):
    class Idle:
        tier = "attitude"

        def attach(self, env):
            return env

        def predict(self, observation, state, episode_start, deterministic):
            return np.zeros((len(observation), 4)), None

    for _ in range(2):
        assert evaluate(SHORT, Idle(), EPISODES, name="idle", folder=tmp_path).policy == "idle"
    assert small_batches == [3, 3, 1] * 2 and list(tmp_path.iterdir()) == []
