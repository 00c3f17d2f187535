"""The tuning script, end to end and tiny."""

import json
import os
import signal
import subprocess
import time
from pathlib import Path

import pytest
from helpers.scripts import command, module_of

from ftac_gym import baselines, scenarios
from ftac_gym.baselines import tuned
from ftac_gym.evaluation.tuning import JOURNAL, Study
from ftac_gym.evaluation.tuning_objective import Search, fly
from ftac_gym.scenarios import frozen
from ftac_gym.utils.console import commit

FEW = ("--baseline", "pd", "--episodes", "2")


def finished(journal):
    """Return the number of finished trials in a journal."""
    return journal.read_bytes().count(b'"value"') if journal.exists() else 0


def alive(process):
    """Return whether a process runs; one that has ended but has not been waited for does not."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def test_a_killed_search_goes_on_and_keeps_its_trials(tmp_path, capsys):
    folder = tmp_path / "runs" / "tuning" / "pd"  # where it lies if nothing is said
    process = subprocess.Popen(command("tune.py", *FEW, "--trials", 10_000), cwd=tmp_path, stderr=subprocess.DEVNULL)
    try:
        deadline = time.monotonic() + 60.0
        while finished(folder / JOURNAL) < 2:
            assert process.poll() is None and time.monotonic() < deadline
            time.sleep(0.05)
        children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
        workers = children.read_text().split() if children.exists() else []
    finally:
        os.kill(process.pid, signal.SIGKILL)
        process.wait()
    budget = finished(folder / JOURNAL) + 2
    deadline = time.monotonic() + 20.0
    while any(alive(worker) for worker in workers):
        assert time.monotonic() < deadline, "workers outlive the search"
        time.sleep(0.05)
    script = module_of("tune")
    script.main(script.Config("pd", trials=budget, episodes=2, workers=1, folder=folder))
    printed = capsys.readouterr()
    assert f"flew {budget} trials on 2 episodes; 0 could not be flown" in printed.out
    assert f"{budget}/{budget}" in printed.err and "availability=" in printed.err
    # The default number of workers made the first ones, one worker the rest.
    assert finished(folder / JOURNAL) == budget
    search = Search("pd", scenarios.get("flagship"), episodes=2)
    trials = Study(search, folder).trials
    assert len(trials) == budget
    best = max(trials, key=lambda trial: trial.value)
    assert f"gains: {json.dumps(best.gains)}" in printed.out


def test_it_stores_what_it_finds(stored, tmp_path, capsys, monkeypatch):
    script = module_of("tune")
    config = script.Config("pd", trials=2, episodes=2, workers=1, folder=tmp_path / "study", store=True)
    script.main(config)
    printed = capsys.readouterr().out
    search = Search("pd", scenarios.get("flagship"), episodes=2)
    record = tuned.record("pd")
    gains, provenance = record["gains"], record["provenance"]
    assert baselines.make("pd", scenarios.get("flagship"), gains="tuned").gains.rate_gain == gains["rate_gain"]
    assert f"gains: {json.dumps(gains)}" in printed and "default on 2 validation episodes: mean availability" in printed
    assert provenance["command"] == "ftac-tune --baseline pd --trials 2 --episodes 2 --store"
    assert provenance["trials"] == 2 and provenance["commit"] == commit()
    metrics = fly(search, gains, frozen.load("flagship", 2, kind="validation"))
    assert provenance["validation_values"].keys() == {"tuned", "default"}
    assert provenance["validation_values"]["tuned"] == pytest.approx(metrics["availability"].mean())
    assert str(tmp_path) not in (stored / "pd.json").read_text()
    monkeypatch.setattr(script, "fly", lambda *arguments: metrics)
    # Nothing is stored without --store, and a finished study is not flown again.
    (stored / "pd.json").unlink()
    script.main(script.Config("pd", trials=1, episodes=2, workers=1, folder=tmp_path / "study"))
    printed = capsys.readouterr().out
    assert "holds more than 1 trials: all of them count" in printed and "flew 2 trials" in printed
    assert not list(stored.iterdir())


def test_the_command_finds_the_same_gains():
    script = module_of("tune")
    assert script.command(script.Config()) == "ftac-tune --baseline pd_dob --trials 300"
    changed = script.Config("pd", "flagship_tracking", "success", 5, 20, 3, 4, workers=9, folder=Path("/somewhere"))
    assert script.command(changed) == (
        "ftac-tune --baseline pd --scenario flagship_tracking --objective success --trials 5 --episodes 20 --seed 3"
        " --sampler-seed 4"
    )


def test_the_commit_is_none_outside_a_checkout(monkeypatch):

    def missing(*arguments, **options):
        raise FileNotFoundError("git")

    monkeypatch.setattr(subprocess, "run", missing)
    assert commit() is None


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"baseline": "unknown"}, "--baseline must be one of .*'pd'.*, got 'unknown'"),
        ({"scenario": "nowhere"}, "--scenario must be one of .*'flagship'.*, got 'nowhere'"),
        ({"objective": "energy"}, "--objective must be one of .*'availability'.*, got 'energy'"),
        ({"trials": 0}, "--trials must be positive, got 0"),
        ({"workers": 0}, "--workers must be positive, got 0"),
        ({"episodes": 0}, "--episodes must be a whole number, 1 or more, got 0"),
        ({"seed": 10_000}, r"--seed must not be within \[10000, 29999\], the seeds of frozen validation and test"),
    ],
)
def test_tune_refuses_before_any_work(changes, message, tmp_path):
    script = module_of("tune")
    with pytest.raises(SystemExit, match=message):
        script.main(script.Config(**{"baseline": "pd", "folder": tmp_path / "study", **changes}))
    assert not list(tmp_path.iterdir())


def test_tune_refuses_a_study_of_another_setting(tmp_path):
    script = module_of("tune")
    Study(Search("pd", scenarios.get("flagship"), episodes=2), tmp_path)
    with pytest.raises(SystemExit, match=r"--folder must hold a study of the same setting.*episodes \(2, now 3\)"):
        script.main(script.Config("pd", episodes=3, folder=tmp_path))
