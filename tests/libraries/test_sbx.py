import pytest

pytest.importorskip("sbx", reason="needs the extra libraries")

from helpers.library_pages import run
from helpers.sb3_buffers import assert_replay_flown, assert_rollout_flown


def test_ppo_on_a_single_environment_trains_on_true_transitions(short_episodes):
    # Its PPO does not tell the ends of episodes to the counter of successes.
    assert_rollout_flown(run("sbx", 0)["model"], counts_success=False)


def test_sac_on_the_vector_environment_stores_true_transitions(short_episodes):
    assert_replay_flown(run("sbx", 1)["model"])
