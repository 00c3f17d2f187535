"""Cost of a control step."""

import time
from importlib import import_module

import numpy as np
from helpers.short_benchmarks import EPISODES, FLAGSHIP, entry_of
from helpers.untrained_agents import write_agent

from ftac_gym import baselines
from ftac_gym.agents.interface import Interface
from ftac_gym.envs import SpacecraftFTCVectorEnv
from ftac_gym.evaluation.benchmark import entries_of, fly
from ftac_gym.evaluation.timing import step_cost


class Slow(baselines.Baseline):
    """Slow custom baseline."""

    def act(self, measurement):
        time.sleep(0.002)
        return np.zeros((len(measurement), 4))


def test_the_cost_of_a_step_is_that_of_the_controller(monkeypatch):
    timing = import_module("ftac_gym.evaluation.timing")
    monkeypatch.setattr(timing, "GROUPS", 5)
    monkeypatch.setattr(timing, "STEPS", 4)
    step = SpacecraftFTCVectorEnv.step

    def slow_step(self, actions):
        time.sleep(0.03)
        return step(self, actions)

    with monkeypatch.context() as patch:
        patch.setattr(SpacecraftFTCVectorEnv, "step", slow_step)
        assert 2000.0 < step_cost(entry_of(Slow), FLAGSHIP) < 20_000.0
    (measured,) = fly([entry_of(Slow)], {"flagship": EPISODES["flagship"][0]}, "slow", workers=1).step_cost.values()
    assert measured > 2000.0


def test_the_cost_of_a_residual_includes_its_base(monkeypatch, tmp_path):
    timing = import_module("ftac_gym.evaluation.timing")
    monkeypatch.setattr(timing, "GROUPS", 3)
    monkeypatch.setattr(timing, "STEPS", 4)
    monkeypatch.setattr(baselines.baseline_class("shen_class"), "act", Slow.act)
    interface = Interface(wrappers=(("ResidualPolicy", {"base": "shen_class"}),))
    (entry,) = entries_of([str(write_agent(tmp_path / "residual", interface))], FLAGSHIP)
    assert step_cost(entry, FLAGSHIP) > 2000.0
