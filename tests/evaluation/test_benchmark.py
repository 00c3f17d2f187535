"""Benchmarks: the same numbers in one process or several, after interruptions, and on a cluster."""

import os
import subprocess
import sys
import textwrap
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from helpers.rattle import RATTLE
from helpers.short_benchmarks import BASELINES, EPISODES, FLAGSHIP, SEVERE, TOTAL
from helpers.untrained_agents import write_agent

from ftac_gym import scenarios
from ftac_gym.evaluation import evaluate
from ftac_gym.evaluation.benchmark import entries_of, fly, frozen_episodes
from ftac_gym.utils import serialization


@pytest.fixture
def small_batches(monkeypatch):
    monkeypatch.setattr(import_module("ftac_gym.evaluation.batches"), "BATCH", 2)


@pytest.fixture(scope="module")
def alone(entries):
    """The benchmark as a single process flies it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(import_module("ftac_gym.evaluation.batches"), "BATCH", 2)
        return fly(entries, EPISODES, BASELINES[0], workers=1, measure=False)


def assert_same(benchmark, alone):
    """To the bit, for all entries of the first."""
    assert benchmark.evaluations.keys() == alone.evaluations.keys()
    for split, by_name in benchmark.evaluations.items():
        assert list(by_name) == [entry.name for entry in benchmark.entries]
        for name, seeds in by_name.items():
            for one, other in zip(seeds, alone.evaluations[split][name], strict=True):
                assert one.policy == other.policy == name
                np.testing.assert_array_equal(one.attitude_error, other.attitude_error)
                np.testing.assert_array_equal(one.relative_error, other.relative_error)
                np.testing.assert_array_equal(one.recoveries.time, other.recoveries.time)
                for metric, values in one.metrics.items():
                    np.testing.assert_array_equal(values, other.metrics[metric], err_msg=f"{split} {name} {metric}")


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


def test_stored_results_of_an_evaluation_are_used(entries, alone, small_batches, tmp_path):
    evaluate(SEVERE, entries[0].policies[0], EPISODES["flagship_severe"], folder=tmp_path / "flagship_severe/batches")
    benchmark = fly(entries, EPISODES, BASELINES[0], tmp_path, workers=1, measure=False)
    assert benchmark.episodes_flown == alone.episodes_flown - 2
    assert_same(benchmark, alone)


@pytest.mark.parametrize("workers", [1, 2])
def test_a_killed_benchmark_continues(entries, alone, small_batches, tmp_path, workers):
    laws = entries[:2]  # agents would load PyTorch in processes that are killed

    class KilledError(Exception):
        pass

    finished = []

    def kill(split, entry, episodes):
        finished.append(episodes)
        if len(finished) == 5:
            raise KilledError

    with pytest.raises(KilledError):
        fly(laws, EPISODES, BASELINES[0], tmp_path, workers=workers, progress=kill, measure=False)
    (tmp_path / "flagship" / "batches" / "half_written.partial").write_bytes(b"PK")
    reported = []
    benchmark = fly(
        laws, EPISODES, BASELINES[0], tmp_path, workers=1, progress=lambda *batch: reported.append(batch), measure=False
    )
    assert benchmark.episodes_flown == 2 * TOTAL - sum(finished)
    assert_same(benchmark, alone)
    for split, count in (("flagship", 5), ("flagship_severe", 2)):
        for entry in laws:
            flown = sum(number for where, who, number in reported if (where, who) == (split, entry.name))
            assert flown == count
    again = fly(laws, EPISODES, BASELINES[0], tmp_path, workers=1, measure=False)
    assert again.episodes_flown == 0
    assert_same(again, alone)


def test_two_processes_give_the_same_numbers(entries, alone, small_batches):
    assert_same(fly(entries, EPISODES, BASELINES[0], workers=2, measure=False), alone)


def test_a_ray_cluster_gives_the_same_numbers(entries, alone, small_batches, tmp_path):
    ray = pytest.importorskip("ray")
    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False, logging_level="ERROR")
    try:
        benchmark = fly(entries[:2], EPISODES, BASELINES[0], tmp_path, backend="ray", workers=2, measure=False)
    finally:
        ray.shutdown()
    assert_same(benchmark, alone)
    assert len(list(tmp_path.glob("*/batches/*.npz"))) == (3 + 1) * 2


def test_a_missing_ray_names_its_extra(entries, monkeypatch):
    monkeypatch.setitem(sys.modules, "ray", None)
    with pytest.raises(ImportError, match=r'ray is missing: pip install "ftac_gym\[cluster\]"'):
        fly(entries, EPISODES, BASELINES[0], backend="ray")


def test_entries_that_do_not_fit_are_refused_before_any_flight(entries, tmp_path):
    unfit = str(write_agent(tmp_path / "unfit", scenario="zhang_zhou_2019"))
    reported = []
    with pytest.raises(ValueError, match=r"unfit: agent must have been trained on .*train one for this"):
        fly(
            [*entries, *entries_of([unfit], FLAGSHIP)], EPISODES, BASELINES[0], tmp_path / "results",
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
        fly(entries, **{"episodes": EPISODES, "reference": BASELINES[0], **changes})


def test_entries_of_one_name(entries):
    with pytest.raises(ValueError, match="entries must have names that differ"):
        fly([entries[0], entries[0]], EPISODES, BASELINES[0])


def test_frozen_episodes():
    drawn = frozen_episodes(["flagship_severe"], 3)
    assert drawn["flagship_severe"].feasible.sum() == 3
    with pytest.raises(ValueError, match=r"splits must be among \['flagship', .*\], got 'flagship_odd'"):
        frozen_episodes(["flagship", "flagship_odd"], 3)


def children(process):
    """Return the ids of a process's children that run."""
    path = Path(f"/proc/{process}/task/{process}/children")
    return {int(child) for child in path.read_text().split()} if path.exists() else set()


SCRIPT = f"""{RATTLE}
from ftac_gym import scenarios
from ftac_gym.faults import FaultDistribution

faults = FaultDistribution((Rattle(onset=1.0),), fault_counts=(0.0, 1.0))
task = scenarios.get("flagship").replace(duration=3.0, faults=faults)
"""


def test_workers_have_kinds_of_faults_of_a_script_and_leave_with_the_benchmark(small_batches, monkeypatch):
    """A class of a script or notebook, whose module no worker can import; afterwards no process is idle."""
    monkeypatch.setattr(serialization, "_CLASSES", serialization.classes())
    script = {"__name__": "__main__"}
    exec(SCRIPT, script)
    episodes = {"rattling": script["task"].draw(0, 4)}
    before = children(os.getpid())
    results = [fly(entries_of(["pd"], FLAGSHIP), episodes, "pd", workers=count, measure=False) for count in (1, 2)]
    (one,), (two,) = (result.evaluations["rattling"]["pd"] for result in results)
    np.testing.assert_equal(two.metrics, one.metrics)
    workers = {process for process in children(os.getpid()) - before if "loky" in command_of(process)}
    assert not {process for process in workers if "tracker" not in command_of(process)}


def command_of(process):
    return Path(f"/proc/{process}/cmdline").read_text().replace("\0", " ")


def test_workers_end_with_a_killed_benchmark():
    program = """
        import os, time
        from ftac_gym import scenarios
        from ftac_gym.evaluation.benchmark import entries_of, fly

        task = scenarios.get("flagship").replace(duration=3.0)
        fly(entries_of(["pd"], task), {"flagship": task.draw(0, 200)}, "pd", workers=2, measure=False,
            progress=lambda *_: print("flown", flush=True) or time.sleep(60.0))
    """
    process = subprocess.Popen([sys.executable, "-c", textwrap.dedent(program)], stdout=subprocess.PIPE)
    assert process.stdout.readline() == b"flown\n"
    workers = {child for child in children(process.pid) if "tracker" not in command_of(child)}
    process.kill()
    # The output is closed as soon as all workers have ended.
    assert process.communicate(timeout=30.0)[0] == b"" and (workers or not Path("/proc").exists())
