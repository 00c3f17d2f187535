import pytest

pytest.importorskip("sb3_contrib", reason="needs the extra train or libraries")

from helpers.library_pages import run
from helpers.sb3_buffers import assert_replay_flown, assert_rollout_flown


def test_tqc_on_a_single_environment_stores_true_transitions(short_episodes):
    assert_replay_flown(run("sb3-contrib", 0)["model"])


def test_recurrent_ppo_on_the_vector_environment_trains_on_true_transitions(short_episodes):
    assert_rollout_flown(run("sb3-contrib", 1)["model"])
