"""A library's own prediction loop on given episodes, and what this package scores for the same policy."""

import gymnasium as gym
import numpy as np

from ftac_gym import scenarios
from ftac_gym.evaluation import evaluate, rollout
from ftac_gym.wrappers import ActionHold

SHORT = scenarios.get("flagship").replace(duration=3.0)
EPISODES = SHORT.draw(5, 3)


def make(observation="attitude", hold=1):
    """Return one environment of the task."""
    env = gym.make("SpacecraftFTC-v0", observation=observation, duration=3.0)
    return ActionHold(env, hold) if hold > 1 else env


def flown_by(act, observation="attitude", hold=1):
    """Return the returns (N,) and actions (T, N, k) of a function of single observations in single environments."""
    returns, actions = [], []
    for number in range(len(EPISODES)):
        env = make(observation, hold)
        seen, _ = env.reset(options={"episodes": EPISODES[number : number + 1]})
        total, own, done = 0.0, [], False
        while not done:
            own.append(np.asarray(act(seen)))
            seen, reward, terminated, truncated, _ = env.step(own[-1])
            total, done = total + reward, terminated or truncated
        returns.append(total)
        actions.append(np.repeat(own, hold, axis=0)[: SHORT.horizon])
    return np.array(returns), np.stack(actions, axis=1)


def flown_by_sb3(model, vec_env, hold=1):
    """Return the same of a model in a VecEnv with an environment for each episode, all of them predicted at once."""
    vec_env.set_options([{"episodes": EPISODES[number : number + 1]} for number in range(len(EPISODES))])
    seen, state, start = vec_env.reset(), None, np.ones(len(EPISODES), dtype=bool)
    total, actions, done = np.zeros(len(EPISODES)), [], np.zeros(len(EPISODES), dtype=bool)
    while not done.any():
        action, state = model.predict(seen, state=state, episode_start=start, deterministic=True)
        seen, rewards, done, _ = vec_env.step(action)
        start = done
        total += rewards
        actions.append(action)
    assert done.all()
    return total, np.repeat(actions, hold, axis=0)[: SHORT.horizon]


def assert_scored_alike(policy, returns, actions, tolerance=1e-6):
    """Check that this package flies a policy with the same actions and returns."""
    history = rollout(SHORT, policy, EPISODES)
    fractions = history.command / SHORT.spacecraft.wheels.torque_limits
    np.testing.assert_allclose(fractions, np.clip(actions, -1.0, 1.0), rtol=0.0, atol=tolerance)
    assert np.ptp(actions, axis=0).max() > 10.0 * tolerance  # a constant would agree with everything
    np.testing.assert_allclose(evaluate(SHORT, policy, EPISODES).metrics["return"], returns, rtol=1e-6, atol=1e-6)
