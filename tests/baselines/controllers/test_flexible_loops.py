"""Continuous loops of the fuzzy sliding-mode controller: the designed motion of s."""

import numpy as np
import pytest
from helpers.flexible_cases import LI, drawn, each, free
from helpers.fuzzy_laws import FlexibleModel, Law, firing
from helpers.laws import relative, rotation
from scipy.integrate import solve_ivp

from ftac_gym import baselines
from ftac_gym.baselines import synthesis
from ftac_gym.task.measurement import Measurement

# -------------------------------------------------------------------------------------------------- continuous loop


@pytest.mark.parametrize(("name", "short_way"), [("fuzzy_smc", False), ("fuzzy_smc_solved", True)])
def test_fuzzy_smc_gives_s_the_designed_motion(name, short_way):
    """s' = (A + B K) s - B (sigma_1 + sigma_2 / (|s| + layer)) s along a flight, the true vibration compensated."""
    scenario, layer = free(), 0.05
    design = "published" if name == "fuzzy_smc" else "solved"
    kept = synthesis.gains(LI.spacecraft, design)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(synthesis, "gains", lambda spacecraft, source: kept)
        law = baselines.make(name, scenario, faults="none", observer=None, layer=layer, short_way=short_way)
    model, again = FlexibleModel(LI.spacecraft), Law(LI.spacecraft, short_way=short_way)
    frequency = np.array([0.5, 0.8, 1.1])

    def target(time):
        return 0.05 * np.sin(frequency * time), 0.05 * frequency * np.cos(frequency * time)

    def turning(q, w):
        return 0.5 * np.append(-q[1:] @ w, q[0] * w + np.cross(q[1:], w))

    def split(state):
        return state[:4], state[4:7], state[7:11], state[11:15], state[15:]

    def derivative(time, state):
        q, w, eta, swing, aim = split(state)
        rate, acceleration = target(time)
        measurement = Measurement(
            np.array([time]), q[None], w[None], np.zeros((1, 3)), np.zeros((1, 3)), np.ones(1, bool), aim[None],
            rate[None], acceleration[None],
        )  # fmt: skip
        law.reset()  # the integrator asks at times of its own
        torque = law.act(measurement)[0] - model.vibration_torque(w, eta, swing)
        turn, bend = model.accelerations(w, torque, eta, swing)
        return np.concatenate([turning(q, w), turn, swing, bend, turning(aim, rate)])

    def variable(time, state):
        q, w, _, _, aim = split(state)
        return again.variable(q, w, (aim, *target(time)))

    start = np.concatenate([[0.9, 0.2, -0.3, 0.1], [0.05, -0.1, 0.08], 0.1 * np.ones(8), [1.0, 0.0, 0.0, 0.0]])
    start[:4] /= np.linalg.norm(start[:4])
    options = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-13}
    step, count = 1e-3, 0
    times = np.arange(0.5, 10.0, 0.5)
    samples = np.sort(np.concatenate([times + k * step for k in (-2, -1, 0, 1, 2)]))
    path = solve_ivp(derivative, (0.0, 10.5), start, t_eval=samples, **options).y.T.reshape(len(times), 5, -1)
    for time, near in zip(times, path, strict=True):
        far, back, s, ahead, farther = (variable(time + k * step, near[k + 2]) for k in (-2, -1, 0, 1, 2))
        slope = (8.0 * (ahead - back) - (farther - far)) / (12.0 * step)
        w = near[2, 4:7]
        gain = sum(share * matrix for share, matrix in zip(firing(w), kept.controller.feedback, strict=True))
        robust = 0.2 + 0.15 / (np.linalg.norm(s) + layer)
        expected = (model.state(w) + model.input @ gain) @ s - robust * model.input @ s
        np.testing.assert_allclose(slope, expected, rtol=0.0, atol=1e-8 * max(1.0, np.abs(expected).max()))
        count += np.abs(expected).max() > 1e-3
    assert count > 5


def test_variable_of_the_law_is_that_of_the_kinematics():
    """C(q_e) of the helper and of the law turn a reference rate alike."""
    scenario = free()
    measurement = drawn(scenario, 5)
    law = baselines.make("fuzzy_pd", scenario, num_spacecraft=6, slope=0.0)
    for s, (q, w, reference) in zip(law.sliding_variable(measurement), each(measurement), strict=True):
        matrix = rotation(q) @ rotation(reference[0]).T
        np.testing.assert_allclose(s, w - matrix @ reference[1], rtol=0.0, atol=1e-14)
        np.testing.assert_allclose(matrix, rotation(relative(q, reference[0])), rtol=0.0, atol=1e-14)
