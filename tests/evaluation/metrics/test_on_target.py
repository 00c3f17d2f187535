"""Time on target against histories made by hand, and against the environment's own verdict."""

import numpy as np
import pytest
from helpers.histories import FLAGSHIP, WHEELS, errors, one

from ftac_gym.envs import SpacecraftFTCVectorEnv
from ftac_gym.evaluation import rollout
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.scenario import SuccessCriterion

COUNT = 500
"""Spacecraft that drift."""


@pytest.mark.parametrize(
    ("pieces", "success", "settling"),
    [
        ([(0, 0.5)], 1.0, 0.0),
        ([(0, 5.0), (30, 0.5)], 1.0, 3.0),
        ([(0, 5.0), (30, 0.5), (50, 2.0), (60, 0.1)], 1.0, 6.0),  # the first time inside does not count
        ([(0, 5.0), (81, 0.5)], 1.0, 8.1),  # exactly the last 20 samples
        ([(0, 5.0), (82, 0.5)], 1.0, 8.2),  # 19 of them: 95 %
        ([(0, 5.0), (83, 0.5)], 0.0, 8.3),
        ([(0, 0.5), (100, 2.0)], 1.0, 10.0),  # lost at the last sample
        ([(0, 0.5), (99, 2.0)], 0.0, 10.0),
        ([(0, 0.5), (90, 10.0), (91, 0.5)], 1.0, 9.1),  # ten cones, and more than ten
        ([(0, 0.5), (90, 10.001), (91, 0.5)], 0.0, 9.1),
        ([(0, 0.5), (80, 10.001), (81, 0.5)], 1.0, 8.1),  # before the window
        ([(0, 5.0)], 0.0, 10.0),
        ([(0, 1.0001)], 0.0, 10.0),
    ],
)
def test_success_and_settling_time(pieces, success, settling):
    assert one("success", error=errors(pieces)) == success
    assert one("settling_time", error=errors(pieces)) == pytest.approx(settling)


def test_on_target_means_slow_too():
    fast = errors([(0, 0.02), (40, 0.001)])  # used as a rate error [rad/s]
    assert one("settling_time", rate_error=fast) == pytest.approx(4.0)
    assert one("success", rate_error=fast) == 1.0
    assert one("success", rate_error=errors([(0, 0.0), (95, 0.02), (96, 0.0)])) == 1.0
    assert one("success", rate_error=errors([(0, 0.0), (95, 0.02), (97, 0.0)])) == 0.0


def test_availability_is_the_share_of_control_periods_that_end_on_target():
    assert one("availability", error=errors([(0, 0.5)])) == 1.0
    assert one("availability", error=errors([(0, 5.0), (1, 0.5)])) == 1.0  # the start ends no period
    assert one("availability", error=errors([(0, 5.0), (31, 0.5), (50, 2.0), (60, 0.1)])) == pytest.approx(0.6)
    assert one("availability", error=errors([(0, 0.5)]), rate_error=errors([(0, 0.0), (91, 0.02)])) == 0.9


class Idle:
    """A policy that lets the spacecraft drift, in and out of the cone."""

    tier = "attitude"

    def attach(self, env):
        return env

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        return np.zeros((len(observation), WHEELS)), None


# Also where the hold is no multiple of the control period, or shorter than one, or as long as the episode, or longer.
@pytest.mark.parametrize("hold", [0.1, 0.5, 2.0, 0.25, 0.45, 3.0, 0.04, 5.0])
@pytest.mark.parametrize(("share", "limit"), [(1.0, None), (0.6, 1.1), (0.9, None)])
def test_success_and_availability_are_what_the_environment_says_at_the_end(hold, share, limit):
    scenario = FLAGSHIP.replace(
        faults=None, duration=3.0, tumble_rate=None, initial_state=InitialState(angle=(0.006, 0.014), max_rate=0.004),
        success=SuccessCriterion(angle=0.01, rate=0.003, hold=hold, share=share, limit=limit),
    )  # fmt: skip
    drawn = scenario.draw(0, COUNT)
    metrics = rollout(scenario, Idle(), drawn).metrics()
    success = metrics["success"]
    env = SpacecraftFTCVectorEnv(COUNT, scenario=scenario, autoreset_mode="Disabled")
    env.reset(options={"episodes": drawn})
    for _ in range(scenario.horizon):
        *_, info = env.step(np.zeros((COUNT, WHEELS)))
    np.testing.assert_array_equal(success, info["is_success"])
    np.testing.assert_array_equal(metrics["availability"], info["availability"])
    assert 0 < success.sum() < COUNT
