"""Rollouts: the truth along an episode, the same however episodes are grouped."""

import dataclasses
from itertools import pairwise

import numpy as np
import pytest
from helpers.names import fitting

from ftac_gym import baselines, scenarios
from ftac_gym.attitude import angle_between
from ftac_gym.dynamics import Simulator
from ftac_gym.evaluation import Rollout, rollout
from ftac_gym.policies import DeferredBaseline, resolve
from ftac_gym.task.initial_state import InitialState

SHORT = scenarios.get("flagship").replace(duration=6.0)
TRACKING = scenarios.get("flagship_tracking").replace(duration=6.0)
NO_HISTORY = ("scenario", "episodes", "time", "estimates")
HISTORIES = [item.name for item in dataclasses.fields(Rollout) if item.name not in NO_HISTORY]


class Constant:
    """A policy that holds one action, and notes what it is given."""

    tier = "telemetry"

    def __init__(self, action):
        self.action, self.observations, self.starts = action, [], []

    def attach(self, env):
        self.env = env
        return env

    def predict(self, observation, state, episode_start, deterministic):
        self.observations.append(observation.copy())
        self.starts.append(np.array(episode_start))
        assert deterministic
        return np.tile(self.action, (len(observation), 1)), (state or 0) + 1


@pytest.mark.parametrize(
    ("name", "scenario"),
    [(name, scenario) for scenario in (SHORT, TRACKING) for name in fitting(scenario)],
    ids=lambda value: getattr(value, "name", value),
)
def test_together_or_one_at_a_time(scenario, name):
    episodes = scenario.draw(4, 6)
    together = rollout(scenario, name, episodes)
    for index in range(6):
        alone = rollout(scenario, name, episodes[index])
        for history in HISTORIES:
            expected = getattr(together, history)[:, index : index + 1]
            np.testing.assert_allclose(getattr(alone, history), expected, rtol=1e-9, atol=1e-10, err_msg=history)


@pytest.mark.parametrize("split", [[2, 3, 1], [5, 1]])
def test_metrics_do_not_depend_on_the_split(split):
    episodes = SHORT.draw(4, 6)
    whole = rollout(SHORT, "pd_dob", episodes).metrics()
    edges = np.cumsum([0, *split])
    parts = [rollout(SHORT, "pd_dob", episodes[a:b]).metrics() for a, b in pairwise(edges)]
    for metric, values in whole.items():
        np.testing.assert_allclose(np.concatenate([part[metric] for part in parts]), values, rtol=1e-8, atol=1e-9)


def test_against_the_simulator():
    """The same flight by hand: baseline and simulator, no environment."""
    episodes = TRACKING.draw(2, 3)
    history = rollout(TRACKING, "pd", episodes)
    simulator, baseline = Simulator(TRACKING, 3), baselines.make("pd", TRACKING, 3)
    simulator.reset(episodes)
    assert history.time.shape == (61,) and history.time[-1] == pytest.approx(6.0)
    for step in range(61):
        angle = angle_between(simulator.state.attitude, simulator.reference_attitude)
        np.testing.assert_allclose(history.attitude_error[step], angle, atol=1e-9)
        np.testing.assert_allclose(history.attitude[step], simulator.state.attitude, atol=1e-12)
        np.testing.assert_allclose(history.rate[step], simulator.state.rate, atol=1e-12)
        np.testing.assert_allclose(history.wheel_momentum[step], simulator.state.wheel_momentum, atol=1e-12)
        if step < 60:
            command, before = baseline.act(simulator.measurement()), simulator.state.wheel_momentum.copy()
            np.testing.assert_allclose(history.command[step], command, atol=1e-12)
            simulator.step(command)
            applied = (before - simulator.state.wheel_momentum) / TRACKING.control_period
            np.testing.assert_allclose(history.applied_torque[step], applied, atol=1e-12)


def test_applied_torque_differs_from_the_command_where_a_wheel_is_faulty():
    prompt = SHORT.replace(loop_delay=0.0)
    healthy, faulty = prompt.replace(faults=None), prompt.replace(duration=90.0)
    history = rollout(healthy, "pd", seed=0, count=4)
    np.testing.assert_allclose(history.applied_torque, history.command, atol=1e-9)
    history = rollout(faulty, "pd", seed=0, count=8)
    struck = (history.episodes.faults["kind"] > 0).any(axis=2) & (history.episodes.faults["onset"] < 80.0).any(axis=2)
    differs = np.abs(history.applied_torque - history.command).max(axis=0) > 1e-6
    np.testing.assert_array_equal(differs, struck)
    assert struck.any() and not struck.all()


def test_draws_what_it_is_asked_for():
    by_seed, by_episodes = rollout(SHORT, "pd", seed=9, count=3), rollout(SHORT, "pd", SHORT.draw(9, 3))
    for history in HISTORIES:
        np.testing.assert_array_equal(getattr(by_seed, history), getattr(by_episodes, history))
    assert by_seed.episodes.digest() == SHORT.draw(9, 3).digest()
    default = rollout("flagship", "pd")
    assert default.scenario == scenarios.get("flagship") and default.attitude_error.shape == (1201, 1)
    assert default.episodes.digest() == scenarios.get("flagship").draw(0, 1).digest()


def test_a_tumbling_spacecraft_is_flown_to_the_end():
    wild = SHORT.replace(tumble_rate=0.05, initial_state=InitialState(rate=(0.3, 0.0, 0.0)))
    history = rollout(wild, Constant(np.zeros(4)), seed=0, count=2)
    assert (np.linalg.norm(history.rate, axis=2) > 0.05).all()
    assert np.isfinite(history.reward).all() and len(history.reward) == wild.horizon
    assert history.scenario == wild


def test_threads_do_not_matter(monkeypatch):
    from ftac_gym.dynamics import simulator

    monkeypatch.setattr(simulator, "THREAD_BATCH", 2)
    first, second = (rollout(SHORT, "pd", seed=1, count=8, threads=threads) for threads in (1, 3))
    for history in HISTORIES:
        np.testing.assert_array_equal(getattr(first, history), getattr(second, history))


def test_inputs_of_a_custom_policy():
    policy = Constant(np.array([0.5, -0.5, 2.0, 0.0]))
    history = rollout(SHORT, policy, seed=0, count=3)
    assert len(policy.observations) == SHORT.horizon
    assert policy.observations[0].shape == policy.env.observation_space.shape
    assert "wheel_momentum" in policy.env.observation_slices and "fault_bias" not in policy.env.observation_slices
    assert policy.starts[0].all() and not np.any(policy.starts[1:])
    np.testing.assert_allclose(history.command, np.broadcast_to([0.1, -0.1, 0.2, 0.0], history.command.shape))


def test_a_policy_can_be_used_again():
    policy = DeferredBaseline("pd_dob", bandwidth=0.14)
    first, second = (rollout(SHORT, policy, seed=3, count=2) for _ in range(2))
    np.testing.assert_array_equal(first.command, second.command)
    other = rollout(SHORT, DeferredBaseline("pd_dob", bandwidth=0.5), seed=3, count=2)
    assert (other.command != first.command).any()


def test_a_recorder_is_called_at_every_control_period():
    steps, estimates, rates = [], [], []

    def recorder(step, runner):
        steps.append(step)
        rates.append(runner.env.batch.simulator.state.rate.copy())
        estimates.append(runner.policy.baseline.estimate.disturbance.copy())

    history = rollout(SHORT, "pd_dob", seed=3, count=2, recorder=recorder)
    assert steps == list(range(SHORT.horizon + 1))
    np.testing.assert_array_equal(rates, history.rate)
    # What the baseline estimates in a period is there at the start of the next.
    assert not estimates[0].any() and np.any(estimates[1:])
    np.testing.assert_array_equal(rollout(SHORT, "pd_dob", seed=3, count=2).command, history.command)


def test_resolution():
    policy = Constant(np.zeros(4))
    assert resolve(policy) is policy
    assert isinstance(resolve("pd"), DeferredBaseline)
    with pytest.raises(
        ValueError, match=r"policy must be .*baselines\.names\(\), .* or the path of an agent, got 'nobody'"
    ):
        resolve("nobody")
    with pytest.raises(ValueError, match=r"baseline must be one of .*, got 'nobody'"):
        DeferredBaseline("nobody")


def test_fingerprints_tell_policies_apart():
    prints = [
        DeferredBaseline("pd").fingerprint,
        DeferredBaseline("pd_dob").fingerprint,
        DeferredBaseline("pd", braking_share=0.4).fingerprint,
        DeferredBaseline("pd", braking_share=0.5).fingerprint,
    ]
    assert len(set(prints)) == 4
    one = DeferredBaseline("pd", braking_share=0.4, rate_limit=0.1).fingerprint
    assert one == DeferredBaseline("pd", rate_limit=0.1, braking_share=0.4).fingerprint


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"scenario": "nowhere"}, "scenario must be one of .*'nowhere'"),
        ({"policy": "nobody"}, "policy must be .*'nobody'"),
        ({"count": 0}, "count must be a positive integer, got 0"),
        ({"seed": -1}, "seed must be a non-negative integer, got -1"),
        ({"episodes": TRACKING.draw(0, 1)}, "episodes must be drawn for the same reference as flagship's"),
        ({"policy": 3}, "policy must be a name, a path, an Agent or a Baseline class"),
    ],
)
def test_bad_arguments(arguments, message):
    with pytest.raises(ValueError, match=message):
        rollout(**{"scenario": SHORT, "policy": "pd", **arguments})


def test_episodes_that_fit_are_welcome_whichever_scenario_drew_them():
    episodes = SHORT.replace(faults=None).draw(0, 2)
    assert rollout(SHORT.replace(duration=0.2), "pd", episodes).attitude_error.shape == (3, 2)


class Brake(baselines.Baseline):
    """Custom baseline."""

    def act(self, measurement):
        wheels = self.scenario.spacecraft.wheels
        return (-20.0 * measurement.rate @ wheels.axis_matrix).clip(-wheels.torque_limits, wheels.torque_limits)


def test_a_custom_baseline_flies():
    history = rollout(SHORT.replace(faults=None), Brake, seed=3, count=4)
    speed = np.linalg.norm(history.rate, axis=2)
    assert (speed[-1] < 0.1 * speed[0]).all()
    with pytest.raises(ValueError, match="not an instance"):
        rollout(SHORT, Brake(SHORT, 4), seed=3, count=4)
