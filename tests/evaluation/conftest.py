"""Entries of benchmarks, and flights of tuning by a formula."""

import pytest
from helpers.short_benchmarks import BASELINES, FLAGSHIP
from helpers.tuning_cases import judge
from helpers.untrained_agents import write_agent, write_curve

from ftac_gym.agents.interface import Interface
from ftac_gym.evaluation import tuning
from ftac_gym.evaluation.benchmark import entries_of


@pytest.fixture(scope="session")
def agent(tmp_path_factory):
    """Return the path of an agent with two training seeds: one in a folder of its own, one in its run."""
    folder = tmp_path_factory.mktemp("agents") / "direct"
    write_curve(write_agent(folder / "seed_2", Interface("telemetry", hold=2), seed=2), [10, 20])
    write_agent(folder / "seed_10" / "agent", Interface("telemetry", hold=2), seed=10)
    write_curve(folder / "seed_10", [30])
    return str(folder)


@pytest.fixture(scope="session")
def entries(agent):
    return entries_of([*BASELINES, agent], FLAGSHIP)


@pytest.fixture
def flown(monkeypatch):
    """Replace flying by a formula; return the list of gains."""
    calls = []
    monkeypatch.setattr(tuning, "value_of", lambda task, gains: calls.append(gains) or judge(task, gains))
    return calls
