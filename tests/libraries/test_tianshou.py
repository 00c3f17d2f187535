import pytest

pytest.importorskip("tianshou", reason="needs the extra libraries")

from helpers.library_pages import assert_flown, run


def test_ppo_collects_true_transitions(short_episodes):
    names = run("Tianshou")
    buffer = names["collector"].buffer
    fields = {
        "observation": "obs",
        "next_observation": "obs_next",
        "reward": "rew",
        "terminated": "terminated",
        "truncated": "truncated",
    }
    stored = {name: getattr(buffer, field).reshape(4, 64, -1).swapaxes(0, 1) for name, field in fields.items()}
    expected = assert_flown(buffer.act.reshape(4, 64, -1).swapaxes(0, 1), stored)
    assert names["result"].train_episode == expected["ended"].sum()
    assert buffer.info.is_success.shape == (256,)
