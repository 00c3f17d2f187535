import pytest

pytest.importorskip("skrl", reason="needs the extra libraries")

import numpy as np
from helpers.library_pages import assert_flown, run


def arrays(agent):
    """Return the agent's memory as arrays (T, N, size) by name."""
    names = ("observations", "actions", "rewards", "terminated", "truncated")
    return {name: agent.memory.get_tensor_by_name(name).numpy() for name in names}


def test_ppo_trains_on_single_and_vector_environment(duration):
    names = run("skrl")
    single = arrays(names["single"])
    stored = {"observation": single["observations"], "truncated": single["truncated"]}
    expected = assert_flown(single["actions"], stored, duration)
    inside = ~expected["truncated"]
    np.testing.assert_allclose(single["rewards"][..., 0][inside], expected["reward"][inside], atol=1e-5)

    vector = arrays(names["vector"])
    ended = vector["truncated"][..., 0]
    assert np.flatnonzero(ended[:, 0]).tolist() == [19, 40, 61]
    resetting = np.roll(ended, 1, axis=0)
    assert (vector["rewards"][resetting] == 0.0).all()
    rows = ~resetting[:, 0]
    stored = {"observation": vector["observations"][rows], "truncated": vector["truncated"][rows]}
    expected = assert_flown(vector["actions"][rows], stored, duration)
    inside = ~expected["truncated"]
    np.testing.assert_allclose(vector["rewards"][rows][..., 0][inside], expected["reward"][inside], atol=1e-5)
