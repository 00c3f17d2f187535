"""The benchmark: who takes part, and the same numbers wherever and however often interrupted it is flown."""

import csv
import dataclasses
import time
from importlib import import_module

import numpy as np
import pytest
from stable_baselines3 import PPO
from stable_baselines3.common.vec_env import VecNormalize

from ftac_gym import baselines, scenarios
from ftac_gym.agents.agent import Interface
from ftac_gym.envs import SpacecraftFTCVectorEnv
from ftac_gym.evaluation import evaluate
from ftac_gym.evaluation.benchmark import Entry, entries_of, fly, frozen_episodes
from ftac_gym.evaluation.timing import step_cost
from ftac_gym.training.callbacks import save_agent
from ftac_gym.wrappers import SB3VecEnv

FLAGSHIP, SEVERE = (scenarios.get(name).replace(duration=3.0) for name in ("flagship", "flagship_severe"))
EPISODES = {"flagship": FLAGSHIP.draw(3, 5), "flagship_severe": SEVERE.draw(4, 2)}
LAWS = ("pd_dob tuned", "nftsm_oracle")
TOTAL = 7  # episodes for each training seed


def write_agent(folder, interface=Interface(), seed=0, scenario="flagship"):  # noqa: B008
    """Write an agent that has not learned anything, with its normaliser and card."""
    native = SpacecraftFTCVectorEnv(
        num_envs=2, scenario=scenario, observation=interface.observation, autoreset_mode="SameStep"
    )
    env = VecNormalize(SB3VecEnv(interface.wrap(native), interface.hold))
    model = PPO("MlpPolicy", env, n_steps=8, batch_size=16, policy_kwargs={"net_arch": [8]}, seed=seed, device="cpu")
    save_agent(folder, model, {"interface": dataclasses.asdict(interface), "normalized": True, "seed": seed})
    return folder


def write_curve(folder, steps):
    with (folder / "evaluations.csv").open("w", newline="") as file:
        csv.writer(file).writerows([("steps", "mean_return"), *((step, 0.5 * step) for step in steps)])


@pytest.fixture(scope="module")
def agent(tmp_path_factory):
    """Two training seeds of an agent: one as it was handed on, one in its run."""
    folder = tmp_path_factory.mktemp("agents") / "direct"
    write_curve(write_agent(folder / "seed_2", Interface("telemetry", hold=2), seed=2), [10, 20])
    write_agent(folder / "seed_10" / "agent", Interface("telemetry", hold=2), seed=10)
    write_curve(folder / "seed_10", [30])
    return str(folder)


@pytest.fixture(scope="module")
def entries(agent):
    return entries_of([*LAWS, agent], FLAGSHIP)


@pytest.fixture
def small_batches(monkeypatch):
    monkeypatch.setattr(import_module("ftac_gym.evaluation.batches"), "BATCH", 2)


@pytest.fixture(scope="module")
def alone(entries):
    """The benchmark as a single process flies it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(import_module("ftac_gym.evaluation.batches"), "BATCH", 2)
        return fly(entries, EPISODES, LAWS[0], workers=1, measure=False)


def assert_same(benchmark, alone):
    """To the bit, for all entries of the first."""
    assert benchmark.evaluations.keys() == alone.evaluations.keys()
    for split, by_name in benchmark.evaluations.items():
        assert list(by_name) == [entry.name for entry in benchmark.entries]
        for name, seeds in by_name.items():
            for one, other in zip(seeds, alone.evaluations[split][name], strict=True):
                assert one.policy == other.policy == name
                np.testing.assert_array_equal(one.attitude_error, other.attitude_error)
                for metric, values in one.metrics.items():
                    np.testing.assert_array_equal(values, other.metrics[metric], err_msg=f"{split} {name} {metric}")


def test_every_baseline_that_fits():
    found = {entry.name: entry for entry in entries_of(["all"], SEVERE)}
    assert {"pd", "pd tuned", "nftsm_oracle", "pd_shaped"} <= found.keys()
    assert "fuzzy_smc" not in found and "pd_shaped tuned" not in found  # for flexible craft
    for name, entry in found.items():
        law = name.removesuffix(" tuned")
        assert entry.tier == baselines.make(law, FLAGSHIP).information
        assert entry.role == ("bound" if entry.tier == "oracle" else "contestant")
        assert (entry.kind, entry.gains) == ("baseline", "default" if name == law else "tuned")
        assert bool(entry.provenance) == (entry.gains == "tuned") and not entry.curves
    assert found["pd tuned"].provenance["trials"] > 0
    assert found["pd tuned"].policies[0].fingerprint != found["pd"].policies[0].fingerprint
    flexible = {entry.name for entry in entries_of(["all"], scenarios.get("flexible"))}
    assert "pd_shaped tuned" in flexible and "pd tuned" not in flexible


def test_a_law_that_commands_nonsense_is_none_of_all(monkeypatch):
    law = baselines.baseline_class("pd_shaped")
    monkeypatch.setattr(law, "act", lambda self, measurement: np.full((len(measurement), 4), np.nan))
    found = {entry.name for entry in entries_of(["all"], FLAGSHIP)}
    assert "pd" in found and "pd_shaped" not in found


def test_names_are_taken_once_and_in_order():
    assert [entry.name for entry in entries_of(["pd tuned", "hsfc", "pd tuned"], FLAGSHIP)] == ["pd tuned", "hsfc"]


def test_an_agent_over_its_seeds(agent, entries):
    entry = entries[-1]
    assert (entry.name, entry.role, entry.tier, entry.kind, entry.gains) == (
        "direct", "contestant", "telemetry", "agent", "",
    )  # fmt: skip
    assert [card["seed"] for card in entry.provenance["cards"]] == [2, 10]
    assert [[row["steps"] for row in curve] for curve in entry.curves] == [[10, 20], [30]]
    assert [policy.removeprefix(agent) for policy in entry.policies] == ["/seed_2", "/seed_10/agent"]
    (single,) = entries_of([f"{agent}/seed_10"], FLAGSHIP)
    (inner,) = entries_of([f"{agent}/seed_10/agent"], FLAGSHIP)
    assert single == inner and single.policies == entry.policies[1:] and single.name == "seed_10"


def test_an_agent_that_is_told_the_truth_is_a_bound(tmp_path):
    interface = Interface(wrappers=(("FaultEstimateObservation", {"source": "truth"}),))
    (entry,) = entries_of([str(write_agent(tmp_path / "told", interface))], FLAGSHIP)
    assert (entry.role, entry.tier) == ("bound", "oracle")


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
    with pytest.raises(ValueError, match=r"agent must be a folder with model.zip"):
        entries_of([str(tmp_path / "empty")], FLAGSHIP)
    (tmp_path / "other" / "seed_0" / "normalizer.pkl").unlink()
    with pytest.raises(ValueError, match=r"agent must have normalizer.pkl beside it.*copy it"):
        entries_of(same[1:], FLAGSHIP)


def test_a_benchmark_is_one_evaluation_each(entries, alone, small_batches):
    assert alone.episodes_flown == TOTAL * 4 and alone.seconds > 0.0 and alone.step_cost == {}
    for split, scenario in (("flagship", FLAGSHIP), ("flagship_severe", SEVERE)):
        for entry in entries:
            for policy, found in zip(entry.policies, alone.evaluations[split][entry.name], strict=True):
                expected = evaluate(scenario, policy, EPISODES[split])
                for metric, values in expected.metrics.items():
                    np.testing.assert_array_equal(found.metrics[metric], values)
    first, second = (item.metrics["return"] for item in alone.evaluations["flagship"]["direct"])
    assert (first != second).all()


def test_what_an_evaluation_has_flown_is_not_flown_again(entries, alone, small_batches, tmp_path):
    evaluate(SEVERE, entries[0].policies[0], EPISODES["flagship_severe"], folder=tmp_path / "flagship_severe/batches")
    benchmark = fly(entries, EPISODES, LAWS[0], tmp_path, workers=1, measure=False)
    assert benchmark.episodes_flown == alone.episodes_flown - 2
    assert_same(benchmark, alone)


@pytest.mark.parametrize("workers", [1, 2])
def test_a_killed_benchmark_goes_on_where_it_stopped(entries, alone, small_batches, tmp_path, workers):
    laws = entries[:2]  # agents would load PyTorch in processes that are killed

    class KilledError(Exception):
        pass

    finished = []

    def kill(split, entry, episodes):
        finished.append(episodes)
        if len(finished) == 5:
            raise KilledError

    with pytest.raises(KilledError):
        fly(laws, EPISODES, LAWS[0], tmp_path, workers=workers, progress=kill, measure=False)
    (tmp_path / "flagship" / "batches" / "half_written.partial").write_bytes(b"PK")
    reported = []
    benchmark = fly(
        laws, EPISODES, LAWS[0], tmp_path, workers=1, progress=lambda *batch: reported.append(batch), measure=False
    )
    assert benchmark.episodes_flown == 2 * TOTAL - sum(finished)
    assert_same(benchmark, alone)
    for split, count in (("flagship", 5), ("flagship_severe", 2)):
        for entry in laws:
            flown = sum(number for where, who, number in reported if (where, who) == (split, entry.name))
            assert flown == count
    again = fly(laws, EPISODES, LAWS[0], tmp_path, workers=1, measure=False)
    assert again.episodes_flown == 0
    assert_same(again, alone)


def test_two_processes_give_the_same_numbers(entries, alone, small_batches):
    assert_same(fly(entries, EPISODES, LAWS[0], workers=2, measure=False), alone)


def test_a_ray_cluster_gives_the_same_numbers(entries, alone, small_batches, tmp_path):
    ray = pytest.importorskip("ray")
    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False, logging_level="ERROR")
    try:
        benchmark = fly(entries[:2], EPISODES, LAWS[0], tmp_path, backend="ray", workers=2, measure=False)
    finally:
        ray.shutdown()
    assert_same(benchmark, alone)
    assert len(list(tmp_path.glob("*/batches/*.npz"))) == (3 + 1) * 2


def test_ray_is_asked_for_by_its_extra(entries, monkeypatch):
    module = import_module("ftac_gym.evaluation.benchmark")

    def missing(name):
        raise ImportError(name)

    monkeypatch.setattr(module, "import_module", missing)
    with pytest.raises(ImportError, match=r"pip install 'ftac-gym\[cluster\]'"):
        fly(entries, EPISODES, LAWS[0], backend="ray")


def test_who_does_not_fit_is_refused_before_anything_flies(entries, tmp_path):
    stranger = str(write_agent(tmp_path / "stranger", scenario="zhang_zhou_2019"))
    reported = []
    with pytest.raises(ValueError, match=r"stranger: agent must have been trained on .*train one for this"):
        fly(
            [*entries, *entries_of([stranger], FLAGSHIP)], EPISODES, LAWS[0], tmp_path / "results",
            workers=1, progress=lambda *batch: reported.append(batch),
        )  # fmt: skip
    assert not reported and not (tmp_path / "results").exists()
    resting, moving = entries_of(["zhang_zhou_stabilisation"], FLAGSHIP), scenarios.get("zhang_zhou_2019").draw(0, 1)
    with pytest.raises(ValueError, match=r"^zhang_zhou_stabilisation: reference must be at rest"):
        fly(resting, {"moving": moving}, "zhang_zhou_stabilisation")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"reference": "pd"}, r"reference must be one of \['pd_dob tuned', 'nftsm_oracle', 'direct'\], got 'pd'"),
        ({"backend": "cloud"}, r"backend must be one of \['local', 'ray'\], got 'cloud'"),
        ({"workers": 0}, "workers must be positive, or -1 for all cores, got 0"),
        ({"episodes": {}}, r"episodes must be given for a split at least, got \[\]"),
    ],
)
def test_bad_arguments(entries, changes, message):
    with pytest.raises(ValueError, match=message):
        fly(entries, **{"episodes": EPISODES, "reference": LAWS[0], **changes})


def test_entries_of_one_name(entries):
    with pytest.raises(ValueError, match="entries must have names that differ"):
        fly([entries[0], entries[0]], EPISODES, LAWS[0])


def test_frozen_episodes():
    drawn = frozen_episodes(["flagship_severe"], 3)
    assert drawn["flagship_severe"].feasible.sum() == 3
    with pytest.raises(ValueError, match=r"splits must be among \['flagship', .*\], got 'flagship_odd'"):
        frozen_episodes(["flagship", "flagship_odd"], 3)


class Slow(baselines.Baseline):
    """A law of one's own that takes its time."""

    def act(self, measurement):
        time.sleep(0.002)
        return np.zeros((len(measurement), 4))


class Broken(baselines.Baseline):
    """A law of one's own that fails in flight."""

    def act(self, measurement):
        return np.where(measurement.time[:, None] > 1.0, np.nan, np.zeros((len(measurement), 4)))


def own(law):
    return Entry(law.__name__.lower(), (law,), "contestant", "attitude", "baseline", "default", {})


def test_who_fails_in_flight_is_named():
    with pytest.raises(ValueError, match=r"broken in flagship: .*finite"):
        fly([own(Broken)], {"flagship": EPISODES["flagship"]}, "broken", workers=1)


def test_the_cost_of_a_step_is_the_controller_s_alone(monkeypatch):
    timing = import_module("ftac_gym.evaluation.timing")
    monkeypatch.setattr(timing, "GROUPS", 5)
    monkeypatch.setattr(timing, "STEPS", 4)
    step = SpacecraftFTCVectorEnv.step

    def slow_step(self, actions):
        time.sleep(0.03)
        return step(self, actions)

    with monkeypatch.context() as patch:
        patch.setattr(SpacecraftFTCVectorEnv, "step", slow_step)
        assert 2000.0 < step_cost(own(Slow), FLAGSHIP) < 20_000.0
    (measured,) = fly([own(Slow)], {"flagship": EPISODES["flagship"][0]}, "slow", workers=1).step_cost.values()
    assert measured > 2000.0


def test_the_cost_of_a_residual_includes_its_base(monkeypatch, tmp_path):
    timing = import_module("ftac_gym.evaluation.timing")
    monkeypatch.setattr(timing, "GROUPS", 3)
    monkeypatch.setattr(timing, "STEPS", 4)
    monkeypatch.setattr(baselines.baseline_class("shen_class"), "act", Slow.act)
    interface = Interface(wrappers=(("ResidualPolicy", {"base": "shen_class"}),))
    (entry,) = entries_of([str(write_agent(tmp_path / "residual", interface))], FLAGSHIP)
    assert step_cost(entry, FLAGSHIP) > 2000.0
