"""The reward: its terms recomputed from the true state, their sum, the tumble, and when an episode is a success."""

import math

import numpy as np
import pytest

from ftac_gym import baselines, scenarios
from ftac_gym.attitude import angle_between, quaternion_error, rotate_to_body
from ftac_gym.envs import SpacecraftFTCEnv, SpacecraftFTCVectorEnv
from ftac_gym.envs.reward import TERMS
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.references import fixed_attitude
from ftac_gym.task.scenario import RewardWeights, SuccessCriterion

WEIGHTS = RewardWeights(
    pointing=0.7,
    effort=0.2,
    smoothness=0.3,
    rate=0.15,
    vibration=0.35,
    on_target=1.3,
    progress=3.0,
    rate_scale=0.02,
    vibration_scale=5e-5,
    discount=0.97,
)
QUIET = {"faults": None, "sensors": None, "disturbance": None, "inertia_uncertainty": None}


def state_of(env):
    """Return error [rad], rate error [rad/s], body rate [rad/s], wheel levels and modal energy [J], all true."""
    simulator = env.batch.simulator
    attitude, reference = simulator.state.attitude, simulator.reference_attitude
    error = quaternion_error(attitude, reference)
    slip = simulator.state.rate - rotate_to_body(error, simulator.reference_rate)
    level = simulator.last_command / env.scenario.spacecraft.wheels.torque_limits
    stiffness = simulator.episodes.modes["stiffness"][0]
    return (
        angle_between(attitude, reference)[0],
        np.linalg.norm(slip),
        np.linalg.norm(simulator.state.rate),
        level[0],
        0.5 * np.sum(simulator.state.modal_rate[0] ** 2 + stiffness * simulator.state.modal_displacement[0] ** 2),
    )


def expected_terms(weights, scenario, before, now):
    angle_before, _, _, level_before, _ = before
    angle, slip, spin, level, energy = now
    on_target = angle < scenario.success.angle and slip < scenario.success.rate
    scale = scenario.success.angle / 5.0
    pointing = weights.pointing * (1.0 - np.log(1.0 + angle / scale) / np.log(1.0 + np.pi / scale))
    ratio = slip**2 / weights.rate_scale**2
    phi = 0.0 if spin > scenario.tumble_rate else np.pi - angle
    return {
        "pointing": pointing,
        "effort": -weights.effort * pointing * np.mean(level**2),
        "smoothness": -weights.smoothness * pointing * np.mean((level - level_before) ** 2) / 4.0,
        "rate": -weights.rate * pointing * ratio / (1.0 + ratio),
        "vibration": -weights.vibration * pointing * energy / (weights.vibration_scale + energy),
        "on_target": weights.on_target * on_target,
        "progress": weights.progress * (weights.discount * phi - (np.pi - angle_before)),
    }


@pytest.mark.parametrize("name", scenarios.names())
@pytest.mark.parametrize("weights", [None, WEIGHTS], ids=["own weights", "other weights"])
def test_terms(name, weights):
    changes = {} if weights is None else {"reward": weights}
    if not scenarios.get(name).reference.moving:
        changes["reference"] = fixed_attitude()
    # A wide cone, so that the spacecraft goes in and out of it.
    cone = SuccessCriterion(angle=0.3, rate=0.05, hold=1.0)
    start = InitialState(angle=(0.2, 0.5), max_rate=0.03)
    env = SpacecraftFTCEnv(scenario=name, success=cone, tumble_rate=0.06, initial_state=start, duration=8.0, **changes)
    seen = dict.fromkeys(TERMS, 0)
    random = np.random.default_rng(0)
    for episode in range(6):
        env.reset(seed=5 if episode == 0 else None)
        before, ended = state_of(env), False
        push = random.uniform(-1.0, 1.0, env.action_space.shape)
        while not ended:
            _, reward, terminated, truncated, info = env.step(push + random.uniform(-0.5, 0.5, env.action_space.shape))
            ended = terminated or truncated
            now = state_of(env)
            wanted = expected_terms(env.scenario.reward, env.scenario, before, now)
            assert [name for name in info if name.startswith("reward/")] == [f"reward/{term}" for term in TERMS]
            for term, value in wanted.items():
                assert info[f"reward/{term}"] == pytest.approx(value, rel=1e-9, abs=1e-12), term
                seen[term] += value != 0.0
            assert reward == pytest.approx(sum(wanted.values()), rel=1e-9, abs=1e-12)
            assert reward == pytest.approx(sum(info[f"reward/{term}"] for term in TERMS), rel=1e-12)
            assert terminated == (now[2] > 0.06)
            before = now
    used = {term for term in TERMS if getattr(env.scenario.reward, term) > 0.0}
    if env.scenario.spacecraft.appendages is None:
        used -= {"vibration"}
    if name.startswith("zhang_zhou") and env.scenario.reference.moving:
        used -= {"on_target"}  # A spacecraft slow enough not to tumble is left behind by this reference.
    assert {term for term, count in seen.items() if count} == used


def test_progress_only_counts_where_the_craft_ends():
    env = SpacecraftFTCEnv(duration=5.0, tumble_rate=None, reward=RewardWeights(progress=2.0))
    env.reset(seed=4)
    start = state_of(env)[0]
    total = sum(env.step(np.full(4, 0.5))[4]["reward/progress"] for _ in range(50))
    assert total == pytest.approx(2.0 * (start - state_of(env)[0]), rel=1e-9)


def test_discounted_progress_adds_up_to_the_potential_of_start_and_end():
    """Whatever happens between: that is what leaves the optimal policy as it is."""
    env = SpacecraftFTCEnv(duration=5.0, tumble_rate=None, reward=RewardWeights(progress=2.0, discount=0.9))
    env.reset(seed=4)
    start = state_of(env)[0]
    total = sum(0.9**k * env.step(np.full(4, 0.5))[4]["reward/progress"] for k in range(50))
    assert total == pytest.approx(2.0 * (0.9**50 * (np.pi - state_of(env)[0]) - (np.pi - start)), rel=1e-9)


def test_every_decade_of_the_error_counts_nearly_the_same():
    cone = SuccessCriterion().angle
    rewards = []
    for angle in (2.0 * cone, 20.0 * cone, 200.0 * cone):
        quaternion = (np.cos(angle / 2.0), np.sin(angle / 2.0), 0.0, 0.0)
        env = SpacecraftFTCEnv(**QUIET, initial_state=InitialState.fixed(quaternion), control_period=0.02)
        env.reset(seed=0)
        rewards.append(env.step(np.zeros(4))[4]["reward/pointing"])
    np.testing.assert_allclose(np.diff(rewards), -1.0 / np.log10(1.0 + 5.0 * np.pi / cone), rtol=0.05)


@pytest.mark.parametrize(("angle", "value"), [(0.0, 1.0), (np.pi, 0.0)])
def test_the_pointing_term_goes_from_one_to_zero(angle, value):
    start = InitialState.fixed((np.cos(angle / 2.0), np.sin(angle / 2.0), 0.0, 0.0))
    env = SpacecraftFTCEnv(**QUIET, initial_state=start)
    env.reset(seed=0)
    assert env.step(np.zeros(4))[4]["reward/pointing"] == pytest.approx(value, abs=1e-9)


@pytest.mark.parametrize(
    ("weights", "message"),
    [
        ({"effort": 0.5}, r"effort \+ smoothness \+ rate \+ vibration must add up to at most 1, .*'effort': 0.5"),
        ({"vibration": 0.3}, "must add up to at most 1"),
        ({"progress": -1.0}, "progress must not be negative"),
        ({"rate_scale": 0.0}, "rate_scale must be positive"),
        ({"vibration_scale": -1.0}, "vibration_scale must be positive"),
        ({"discount": 1.5}, r"discount must lie within \(0, 1\], got 1.5"),
        ({"discount": 0.0}, "discount must be positive"),
    ],
)
def test_weights_that_could_make_a_step_negative_are_refused(weights, message):
    with pytest.raises(ValueError, match=message):
        RewardWeights(**weights)


@pytest.mark.parametrize("name", [*scenarios.names()])
def test_no_step_is_negative(name):
    """For any commands, from their limits to nothing, whatever the spacecraft does."""
    env = SpacecraftFTCVectorEnv(24, scenario=name)
    env.reset(seed=3)
    random = np.random.default_rng(1)
    wheels = env.single_action_space.shape[0]
    push = random.choice([-1.0, 0.0, 1.0], (24, wheels))
    least = np.inf
    for step in range(150):
        chatter = random.choice([-2.0, 0.0, 2.0], (8, wheels))
        actions = np.concatenate([push[:8], push[8:16] + chatter, push[16:] * (-1.0) ** step]).clip(-1.0, 1.0)
        least = min(least, env.step(actions)[1].min())
    assert least >= 0.0


@pytest.mark.parametrize("vibration", [0.0, 0.2])
def test_rounding_makes_no_step_negative(vibration):
    """Costs that are all at their bounds leave nothing, and not less."""
    weights = RewardWeights(
        effort=0.7, smoothness=0.1, rate=0.2 - vibration, vibration=vibration, on_target=0.0, rate_scale=1e-14,
        vibration_scale=1e-14,
    )  # fmt: skip
    start = InitialState(modal_rate=(3.0,) * 4)
    env = SpacecraftFTCVectorEnv(64, scenario="flexible", reward=weights, tumble_rate=None, initial_state=start)
    env.reset(seed=3)
    rewards = np.array([env.step(np.full((64, 4), (-1.0) ** step))[1] for step in range(60)])
    assert rewards.min() >= 0.0
    assert rewards[1:].max() < 1e-7


def test_a_tumble_ends_the_episode_and_its_potential_is_zero():
    env = SpacecraftFTCEnv(
        tumble_rate=0.02, initial_state=InitialState.fixed(rate=(0.0, 0.03, 0.0)), reward=WEIGHTS, **QUIET
    )
    _, info = env.reset(seed=0)
    assert "reward/pointing" not in info
    angle = state_of(env)[0]
    _, _, terminated, truncated, info = env.step(np.zeros(4))
    assert terminated and not truncated
    assert info["reward/progress"] == pytest.approx(-WEIGHTS.progress * (np.pi - angle))


def test_without_a_tumble_rate_nothing_terminates():
    start = InitialState.fixed(rate=(2.0, -3.0, 1.0))
    env = SpacecraftFTCEnv(tumble_rate=None, initial_state=start, duration=1.0, **QUIET)
    env.reset(seed=0)
    results = [env.step(np.zeros(4)) for _ in range(10)]
    assert not any(result[2] for result in results) and results[-1][3]


@pytest.mark.parametrize(("hold", "steps"), [(0.1, 1), (0.5, 5), (0.45, 5), (2.0, 20), (0.04, 1), (3.0, 30), (4.0, 30)])
def test_success_after_holding(hold, steps):
    env = SpacecraftFTCEnv(
        success=SuccessCriterion(hold=hold), initial_state=InitialState.fixed(), duration=3.0, **QUIET
    )
    assert not env.reset(seed=0)[1]["is_success"]
    successes = [env.step(np.zeros(4))[4]["is_success"] for _ in range(30)]
    assert successes == [False] * (steps - 1) + [True] * (31 - steps)


@pytest.mark.parametrize(("share", "limit"), [(1.0, None), (0.6, None), (0.4, 1.2), (0.81, 20.0)])
def test_success_is_lost_outside_the_cone_and_forgotten_at_a_reset(share, limit):
    criterion = SuccessCriterion(angle=0.01, rate=0.5, hold=0.5, share=share, limit=limit)
    needed = math.ceil(5 * share)
    env = SpacecraftFTCEnv(success=criterion, initial_state=InitialState.fixed(), duration=30.0, **QUIET)
    env.reset(seed=0)
    history = []
    for step in range(150):
        # Push away, then let go and come back with the opposite torque.
        action = np.array([1.0, -1.0, -1.0, 1.0]) * (1.0 if step < 30 else -1.0 if step < 90 else 0.0)
        info = env.step(action)[4]
        history.append((np.radians(info["attitude_error"]), info["is_success"]))
    error = np.array([item[0] for item in history])
    assert not (error < 0.01).all() and (error[:5] < 0.01).all()
    for step, (_, success) in enumerate(history):
        window = error[max(step - 4, 0) : step + 1]
        held = (window < 0.01).sum() >= needed and (limit is None or (window <= 0.01 * limit).all())
        assert success == (step >= 4 and held)
    assert not env.reset()[1]["is_success"]


def test_success_needs_a_small_rate():
    criterion = SuccessCriterion(angle=3.0, rate=0.01, hold=0.2)
    for speed, success in ((0.009, True), (0.011, False)):
        env = SpacecraftFTCEnv(
            success=criterion, initial_state=InitialState.fixed(rate=(speed, 0.0, 0.0)), duration=1.0, **QUIET
        )
        env.reset(seed=0)
        for _ in range(3):
            info = env.step(np.zeros(4))[4]
        assert info["is_success"] is success
        assert info["rate_error"] == pytest.approx(np.degrees(speed), rel=1e-2)


def test_a_controller_earns_more_than_doing_nothing():
    env = SpacecraftFTCVectorEnv(8, faults=None, duration=60.0, autoreset_mode="Disabled")
    returns = {}
    policy = baselines.make("pd", env.scenario, 8).as_policy(env)
    for name in ("controller", "nothing"):
        observation, _ = env.reset(seed=1)
        total = np.zeros(8)
        for _ in range(600):
            action = policy.predict(observation)[0] if name == "controller" else np.zeros((8, 4))
            observation, reward, terminated, *_ = env.step(action)
            total += reward
            assert not terminated.any()
        returns[name] = total
    assert (returns["controller"] > returns["nothing"]).all()
