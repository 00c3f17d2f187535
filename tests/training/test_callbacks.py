"""Schedules of runs."""

import pytest

from ftac_gym.training.callbacks import Schedule

GOOD = {
    "evaluate_every": 1,
    "checkpoint_every": 1,
    "evaluation_episodes": 1,
    "critic_warmup": 0,
}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"evaluate_every": 0}, "evaluate_every must be a positive integer, got 0"),
        ({"checkpoint_every": -1}, "checkpoint_every must be a positive integer, got -1"),
        ({"evaluation_episodes": 0}, "evaluation_episodes must be a positive integer, got 0"),
        ({"severity_start": 2.0}, "severity_start must"),
    ],
)
def test_bad_schedules(changes, message):
    with pytest.raises(ValueError, match=message):
        Schedule(**{**GOOD, **changes})
