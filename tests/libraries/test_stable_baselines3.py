import pytest

pytest.importorskip("stable_baselines3", reason="needs the extra train or libraries")

from helpers.library_pages import run
from helpers.sb3_buffers import assert_rollout_flown


@pytest.mark.parametrize("number", [0, 1], ids=["single", "vector"])
def test_ppo_trains_on_true_transitions(short_episodes, number):
    assert_rollout_flown(run("Stable-Baselines3", number)["model"])
