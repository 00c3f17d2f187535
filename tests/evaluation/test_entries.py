"""Entries of benchmarks: baselines by name, and agents over their training seeds."""

import numpy as np
import pytest
from helpers.short_benchmarks import FLAGSHIP, SEVERE
from helpers.untrained_agents import write_agent

from ftac_gym import baselines, scenarios
from ftac_gym.agents.interface import Interface
from ftac_gym.evaluation.benchmark import entries_of
from ftac_gym.report.provenance import policy_name


def test_every_baseline_that_fits():
    found = {entry.name: entry for entry in entries_of(["all"], SEVERE)}
    assert {"pd", "pd tuned", "nftsm_oracle", "pd_shaped"} <= found.keys()
    assert "fuzzy_smc" not in found and "pd_shaped tuned" not in found  # for flexible spacecraft
    for name, entry in found.items():
        law = name.removesuffix(" tuned")
        assert entry.tier == baselines.make(law, FLAGSHIP).information
        assert entry.role == ("oracle" if entry.tier == "oracle" else "policy")
        assert (entry.kind, entry.gains) == ("baseline", "default" if name == law else "tuned")
        assert bool(entry.provenance) == (entry.gains == "tuned") and not entry.curves
    assert found["pd tuned"].provenance["trials"] > 0
    assert found["pd tuned"].policies[0].fingerprint != found["pd"].policies[0].fingerprint
    flexible = {entry.name for entry in entries_of(["all"], scenarios.get("flexible"))}
    assert "pd_shaped tuned" in flexible and "pd tuned" not in flexible


def test_a_baseline_with_commands_that_are_not_finite_is_left_out_of_all(monkeypatch):
    law = baselines.baseline_class("pd_shaped")
    monkeypatch.setattr(law, "act", lambda self, measurement: np.full((len(measurement), 4), np.nan))
    found = {entry.name for entry in entries_of(["all"], FLAGSHIP)}
    assert "pd" in found and "pd_shaped" not in found


@pytest.mark.parametrize("name", ["zero", "random"])
def test_policies_without_skill_are_entries_that_the_report_names(name):
    (entry,) = entries_of([name], FLAGSHIP)
    assert (entry.name, entry.policies, entry.tier) == (name, (name,), "attitude")
    assert policy_name(entry, 0) == name


def test_names_are_taken_once_and_in_order():
    assert [entry.name for entry in entries_of(["pd tuned", "hsfc", "pd tuned"], FLAGSHIP)] == ["pd tuned", "hsfc"]


def test_an_agent_over_its_seeds(agent, entries):
    entry = entries[-1]
    assert (entry.name, entry.role, entry.tier, entry.kind, entry.gains) == (
        "direct", "policy", "telemetry", "agent", "",
    )  # fmt: skip
    assert [card["seed"] for card in entry.provenance["cards"]] == [2, 10]
    assert [[row["steps"] for row in curve] for curve in entry.curves] == [[10, 20], [30]]
    assert [policy.removeprefix(agent) for policy in entry.policies] == ["/seed_2", "/seed_10/agent"]
    (single,) = entries_of([f"{agent}/seed_10"], FLAGSHIP)
    (inner,) = entries_of([f"{agent}/seed_10/agent"], FLAGSHIP)
    assert single == inner and single.policies == entry.policies[1:] and single.name == "seed_10"


def test_an_agent_with_the_truth_is_a_bound(tmp_path):
    interface = Interface(wrappers=(("FaultEstimateObservation", {"source": "truth"}),))
    (entry,) = entries_of([str(write_agent(tmp_path / "told", interface))], FLAGSHIP)
    assert (entry.role, entry.tier) == ("oracle", "oracle")


@pytest.mark.parametrize(
    ("names", "message"),
    [
        (["nobody"], r"policies \(beside 'all'\) must be .*pd_dob, .*'nftsm tuned'.*, or the path .*got 'nobody'"),
        (["fuzzy_pd"], "fuzzy_pd: appendages must be given"),
        (["chen_m2 tuned"], "gains must be tuned first"),
        (["pd_shaped tuned"], "gains of pd_shaped tuned must be tuned on flagship, got 'flexible'"),
    ],
)
def test_names_that_are_refused(names, message):
    with pytest.raises(ValueError, match=message):
        entries_of(names, FLAGSHIP)


def test_agents_that_are_refused(tmp_path):
    write_agent(tmp_path / "mixed" / "seed_0")
    write_agent(tmp_path / "mixed" / "seed_1", Interface("telemetry"))
    with pytest.raises(ValueError, match="agent must have seeds of one design"):
        entries_of([str(tmp_path / "mixed")], FLAGSHIP)
    write_agent(tmp_path / "other" / "seed_0")
    same = [str(tmp_path / folder / "seed_0") for folder in ("mixed", "other")]
    with pytest.raises(ValueError, match=r"folders of different names, got \['seed_0', 'seed_0'\]"):
        entries_of(same, FLAGSHIP)
    (tmp_path / "empty").mkdir()
    with pytest.raises(ValueError, match=r"agent must be a folder with card.json"):
        entries_of([str(tmp_path / "empty")], FLAGSHIP)
    next((tmp_path / "other" / "seed_0").glob("*.safetensors")).unlink()
    with pytest.raises(ValueError, match=r"safetensors cannot be read: .*; restore the whole folder"):
        entries_of(same[1:], FLAGSHIP)
