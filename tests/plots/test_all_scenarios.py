"""Every figure of an episode can be drawn in every kind of scenario."""

import numpy as np
import pytest

from ftac_gym import scenarios
from ftac_gym.evaluation import rollout
from ftac_gym.plots import boresight_paths, episode, estimates_along, polytopes_along, torque_estimates, wheel_envelope

# One of each family: three or four wheels, with and without limits, at rest or moving, rigid or flexible.
NAMES = (
    "cao_2022", "chen_2018", "flagship_double", "flagship_hardware", "flagship_tracking", "flexible", "li_2023",
    "ma_2023_faulty", "shen_2019", "zhang_zhou_2019",
)  # fmt: skip


@pytest.mark.parametrize("name", NAMES)
def test_figures_of_an_episode(name):
    scenario = scenarios.get(name)
    scenario = scenario.replace(duration=40.0 * scenario.control_period)
    histories = {policy: rollout(scenario, policy, seed=1) for policy in ("pd", "pd_dob")}
    estimates = estimates_along(histories["pd_dob"], "pd_dob")
    figures = [
        episode(histories),
        boresight_paths(histories),
        torque_estimates({"pd_dob": estimates}),
        wheel_envelope(polytopes_along(histories["pd"], (0.0, scenario.duration))),
    ]
    for figure in figures:
        figure.draw_without_rendering()
        for panel in figure.axes:
            for line in panel.lines:
                values = np.asarray(line.get_xydata(), dtype=float)
                assert np.isfinite(values).any()
