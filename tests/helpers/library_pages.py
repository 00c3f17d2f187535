"""The snippets of docs/libraries.md, and the transitions that a library has to have stored."""

import re
from pathlib import Path

import gymnasium as gym
import numpy as np

PAGE = Path(__file__).parents[2] / "docs" / "libraries.md"
ID = "ftac_gym:SpacecraftFTC-v0"


def snippets(heading, language="python"):
    """Return the code blocks of a section of the page."""
    section = re.split(r"^## ", PAGE.read_text(encoding="utf-8"), flags=re.MULTILINE)
    (text,) = (part for part in section if part.startswith(f"{heading}\n"))
    return re.findall(rf"^```{language}\n(.*?)^```", text, flags=re.MULTILINE | re.DOTALL)


def run(heading, number=0):
    """Run a snippet as a user would, and return its names."""
    names = {"__name__": "__main__"}
    exec(compile(snippets(heading)[number], f"{PAGE.name}: {heading}", "exec"), names)
    return names


def assert_flown(actions, stored, seed=0):
    """Assert that stored arrays are those of the transitions that actions (T, N, wheels) lead to, and of no others.

    N single environments fly the actions once more, each reset at the end of an episode. Their first episode is that
    which starts with the first stored observation, for a library may have taken some before. Returns what the actions
    lead to, by name.
    """
    actions = np.asarray(actions)
    stored = {name: np.asarray(values) for name, values in stored.items()}
    first = stored["observation"][0]
    flights = [_flown(actions[:, k], first[k], seed + k) for k in range(actions.shape[1])]
    expected = {name: np.stack([flight[name] for flight in flights], axis=1) for name in flights[0]}
    for name, values in stored.items():
        np.testing.assert_allclose(values.reshape(expected[name].shape), expected[name], atol=1e-5, err_msg=name)
    expected["ended"] = expected["terminated"] | expected["truncated"]
    assert expected["ended"].any(axis=0).all(), "every spacecraft must reach the end of an episode here"
    assert actions.shape[1] == 1 or (expected["terminated"].any() and expected["truncated"].any())
    return expected


def _flown(actions, first, seed, episodes=100):
    env = gym.make(ID)
    observation, _ = env.reset(seed=seed)
    while not np.allclose(observation, first, atol=1e-6):
        episodes -= 1
        assert episodes, "the first observation must be that of an episode of this seed"
        observation, _ = env.reset()
    rows = []
    for action in actions:
        following, reward, terminated, truncated, _ = env.step(np.clip(action, -1.0, 1.0))
        rows.append((observation, following, reward, terminated, truncated))
        observation = env.reset()[0] if terminated or truncated else following
    names = ("observation", "next_observation", "reward", "terminated", "truncated")
    return {name: np.array(column) for name, column in zip(names, zip(*rows, strict=True), strict=True)}


def returns_and_lengths(rewards, ended):
    """Return the return and the length of every ended episode from rewards (T, N) and ends (T, N), sorted."""
    episodes = []
    for spacecraft in range(ended.shape[1]):
        stops = np.flatnonzero(ended[:, spacecraft]) + 1
        parts = np.split(rewards[:, spacecraft], stops)[: len(stops)]
        episodes += [(part.sum(), len(part)) for part in parts]
    return np.array(sorted(episodes))
