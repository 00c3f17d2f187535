"""The tuning script, end to end and tiny, and evaluations with the gains that it stores."""

import importlib.util
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from matplotlib.figure import Figure

from ftac_gym import baselines, scenarios
from ftac_gym.baselines import tuned
from ftac_gym.evaluation.tuning import JOURNAL, open_study
from ftac_gym.evaluation.tuning_objective import Search, fly

SCRIPTS = Path(__file__).parents[2] / "train"
FEW = ("--baseline", "pd", "--episodes", "2")


def command(*arguments):
    return [sys.executable, str(SCRIPTS / "tune.py"), *map(str, arguments)]


def module_of(script):
    """Import a script without running it."""
    spec = importlib.util.spec_from_file_location(f"script_{script}", SCRIPTS / f"{script}.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def stored(tmp_path, monkeypatch):
    """A folder for tuned gains, empty."""
    folder = tmp_path / "tuned_gains"
    folder.mkdir()
    monkeypatch.setattr(tuned, "FOLDER", folder)
    return folder


def write(folder, name, trials=7, **gains):
    provenance = {"trials": trials, "scenario": "flagship"}
    (folder / f"{name}.json").write_text(json.dumps({"gains": gains, "provenance": provenance}))


def finished(journal):
    """Return how many trials are finished, as a reader of the file sees it."""
    lines = journal.read_text().splitlines() if journal.exists() else []
    return sum('"state":1' in line for line in lines)


def alive(process):
    """Whether a process runs; one that has ended and that nobody has asked for does not."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


# ---------------------------------------------------------------------------------------------------------------- tune


def test_a_killed_search_goes_on_and_keeps_its_trials(tmp_path, capsys):
    folder = tmp_path / "runs" / "tuning" / "pd"  # where it lies if nothing is said
    process = subprocess.Popen(command(*FEW, "--trials", 10_000), cwd=tmp_path, stderr=subprocess.DEVNULL)
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
    assert f"{budget}/{budget}" in printed.err and "mean_return=" in printed.err
    # The default number of workers made the first ones, one worker the rest.
    assert finished(folder / JOURNAL) == budget
    search = Search("pd", scenarios.get("flagship"), episodes=2)
    trials = [item for item in open_study(search, folder).get_trials() if item.state.is_finished()]
    assert [item.number for item in trials] == list(range(budget))
    best = search.gains_at(max(trials, key=lambda item: item.value).params)
    assert f"gains: {json.dumps(best)}" in printed.out


def test_it_stores_what_it_finds(stored, tmp_path, capsys, monkeypatch):
    script = module_of("tune")
    config = script.Config("pd", trials=2, episodes=2, workers=1, folder=tmp_path / "study", store=True)
    script.main(config)
    printed = capsys.readouterr().out
    search = Search("pd", scenarios.get("flagship"), episodes=2)
    record = tuned.record("pd")
    gains, provenance = record["gains"], record["provenance"]
    assert baselines.make("pd", scenarios.get("flagship"), gains="tuned")._rate_gain == gains["rate_gain"]
    assert f"gains: {json.dumps(gains)}" in printed and "default on fresh episodes: success" in printed
    assert provenance["command"] == "python train/tune.py --baseline pd --trials 2 --episodes 2 --store"
    assert provenance["trials"] == 2 and provenance["commit"] == script.commit()
    metrics = fly(search, gains, 800_001)
    assert provenance["fresh_mean_return"].keys() == {"tuned", "default"}
    assert provenance["fresh_mean_return"]["tuned"] == pytest.approx(metrics["return"].mean())
    assert str(tmp_path) not in (stored / "pd.json").read_text()
    monkeypatch.setattr(script, "fly", lambda *arguments: metrics)
    # Nothing is stored unless it is asked for, and a finished study is not flown again.
    (stored / "pd.json").unlink()
    script.main(script.Config("pd", trials=1, episodes=2, workers=1, folder=tmp_path / "study"))
    printed = capsys.readouterr().out
    assert "holds more than 1 trials: all of them count" in printed and "flew 2 trials" in printed
    assert not list(stored.iterdir())


def test_the_command_finds_the_same_gains():
    script = module_of("tune")
    assert script.command(script.Config()) == "python train/tune.py --baseline pd_dob --trials 300 --store"
    changed = script.Config("pd", "flagship_tracking", 5, 20, 3, 4, workers=9, folder=Path("/somewhere"))
    assert script.command(changed) == (
        "python train/tune.py --baseline pd --scenario flagship_tracking --trials 5 --episodes 20 --seed 3 "
        "--sampler-seed 4 --store"
    )


def test_the_commit_is_none_outside_a_checkout(monkeypatch):
    script = module_of("tune")

    def missing(*arguments, **options):
        raise FileNotFoundError("git")

    monkeypatch.setattr(subprocess, "run", missing)
    assert script.commit() is None


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"baseline": "nobody"}, "--baseline must be one of .*'pd'.*, got 'nobody'"),
        ({"scenario": "nowhere"}, "--scenario must be one of .*'flagship'.*, got 'nowhere'"),
        ({"trials": 0}, "--trials must be positive, got 0"),
        ({"workers": 0}, "--workers must be positive, got 0"),
        ({"episodes": 0}, "--episodes must be positive, got 0"),
        ({"seed": 10_000}, "--seed and the next must not be of the frozen test episodes"),
    ],
)
def test_tune_refuses_before_any_work(changes, message, tmp_path):
    script = module_of("tune")
    with pytest.raises(SystemExit, match=message):
        script.main(script.Config(**{"baseline": "pd", "folder": tmp_path / "study", **changes}))
    assert not list(tmp_path.iterdir())


def test_tune_refuses_a_study_of_another_setting(tmp_path):
    script = module_of("tune")
    open_study(Search("pd", scenarios.get("flagship"), episodes=2), tmp_path)
    with pytest.raises(SystemExit, match=r"--folder must hold a study of the same setting.*episodes \(2, now 3\)"):
        script.main(script.Config("pd", episodes=3, folder=tmp_path))


# ------------------------------------------------------------------------------------------------------------ evaluate


def test_evaluate_with_tuned_gains(stored, tmp_path, capsys, monkeypatch):
    evaluation = module_of("evaluate")
    judged = []
    # The gallery flies every kind of fault, which is long; that it can is tested elsewhere.
    monkeypatch.setattr(evaluation, "fault_gallery", lambda scenario, policy: judged.append(policy) or Figure())
    write(stored, "pd", rate_gain=3.0, position_gain=1.0)
    write(stored, "pd_dob", bandwidth=1.0)
    output = tmp_path / "results"
    arguments = {
        "policies": ("pd", "pd_dob"), "reference": "pd", "splits": (), "episodes": 1, "output": output, "detail": 0
    }  # fmt: skip
    evaluation.main(evaluation.Config(**arguments, gains="tuned"))
    line = "gains of the baselines: pd tuned by 7 trials on flagship, pd_dob tuned by 7 trials on flagship"
    assert line in " ".join(capsys.readouterr().out.split())
    folder = output / "tuned" / "flagship"
    report = (folder / "report.md").read_text()
    assert line in report and [policy.fingerprint for policy in judged] == [
        '["pd", {"position_gain": 1.0, "rate_gain": 3.0}]'
    ]
    assert {item.name for item in folder.iterdir()} == {
        "report.md", "episodes.csv", "summary.csv", "error_bands.png", "episode.png", "fault_kinds.png"
    }  # fmt: skip
    batches = output / "flagship" / "batches"
    assert [item.name for item in (output / "flagship").iterdir()] == ["batches"] and len(list(batches.iterdir())) == 2
    # Default gains fly anew and lie elsewhere; so do gains that are tuned again, but only those.
    run = evaluation.run
    console = evaluation.Console(quiet=True)
    default = evaluation.Config(**arguments)
    drawn = {"flagship": evaluation.draw(default, "flagship")}
    assert evaluation.gains_used(default) == "gains of the baselines: pd default, pd_dob default"
    assert default.reports == output
    results = [run(default, evaluation.contestants(default), drawn, console)]
    assert len(list(batches.iterdir())) == 4
    write(stored, "pd", rate_gain=3.5, position_gain=1.0)
    anew = evaluation.Config(**arguments, gains="tuned")
    results.append(run(anew, evaluation.contestants(anew), drawn, console))
    assert len(list(batches.iterdir())) == 5
    returns = [[float(item.metrics["return"][0]) for item in result["flagship"]] for result in results]
    assert returns[0][0] != returns[1][0] and returns[0][1] != returns[1][1]
    assert (folder / "report.md").read_text() == report


def test_evaluate_refuses_gains_that_are_not_there(stored, tmp_path):
    evaluation = module_of("evaluate")
    write(stored, "pd", rate_gain=3.0)
    config = evaluation.Config(policies=("agent", "pd", "pd_dob"), gains="tuned", output=tmp_path / "results")
    with pytest.raises(
        SystemExit, match=r"--gains: gains must be tuned first: .*pd_dob --store.*\['pd'\], got 'pd_dob'"
    ):
        evaluation.main(config)
    assert not (tmp_path / "results").exists()


def test_agents_keep_the_gains_of_their_base(stored):
    evaluation = module_of("evaluate")
    write(stored, "pd_dob", bandwidth=1.0)
    flown = evaluation.contestants(evaluation.Config(policies=("agent", "pd_dob"), gains="tuned"))
    assert flown["agent"].endswith("flagship_residual/seed_0")
    assert flown["pd_dob"].fingerprint == '["pd_dob", {"bandwidth": 1.0}]'
    alone = evaluation.Config(policies=("agent",), gains="tuned")
    assert evaluation.gains_used(alone) == "gains of the baselines: none among the policies"
