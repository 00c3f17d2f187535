import pytest

pytest.importorskip("skrl", reason="needs the extra libraries")

import numpy as np
from helpers.library_pages import assert_flown, run


def arrays(agent):
    """Return the agent's memory as arrays (T, N, size) by name."""
    names = ("observations", "actions", "rewards", "terminated", "truncated")
    return {name: agent.memory.get_tensor_by_name(name).numpy() for name in names}


def test_ppo_on_a_single_environment_trains_on_true_transitions(short_episodes):
    assert_trained_on(arrays(run("skrl")["single"]), 0)


def test_ppo_on_the_vector_environment_trains_on_true_transitions_and_steps_that_reset(short_episodes):
    kept = arrays(run("skrl")["vector"])
    for spacecraft in range(8):
        flight = {name: values[:, spacecraft : spacecraft + 1] for name, values in kept.items()}
        ended = (flight["terminated"] | flight["truncated"]).ravel()
        resets = np.append(False, ended[:-1])
        assert resets.any() and not ended[resets].any() and (flight["rewards"][resets] == 0.0).all()
        assert_trained_on({name: values[~resets] for name, values in flight.items()}, spacecraft)


def assert_trained_on(flight, seed):
    """Assert that the transitions (T, 1, size) of a memory are those that its actions lead to."""
    stored = {"observation": flight["observations"], **{name: flight[name] for name in ("terminated", "truncated")}}
    expected = assert_flown(flight["actions"], stored, seed)
    # To the reward of a step that runs out of time skrl adds the value of the last observation.
    inside = ~expected["truncated"]
    np.testing.assert_allclose(flight["rewards"][..., 0][inside], expected["reward"][inside], atol=1e-5)
