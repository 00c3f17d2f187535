"""Evaluation from the command line, tiny."""

import csv
import json
from dataclasses import replace

import numpy as np
import pytest
from helpers.scripts import module_of, run
from matplotlib.figure import Figure

from ftac_gym import scenarios
from ftac_gym.agents.agent import Agent
from ftac_gym.agents.shipped import SHIPPED
from ftac_gym.evaluation import rollout
from ftac_gym.evaluation.episodes import judging_episodes
from ftac_gym.evaluation.metrics import UNITS
from ftac_gym.evaluation.rows import HEADLINES, TABLE_METRICS
from ftac_gym.report import comparison
from ftac_gym.scenarios import frozen


def write(folder, name, trials=7, **gains):
    provenance = {"trials": trials, "scenario": "flagship"}
    (folder / f"{name}.json").write_text(json.dumps({"gains": gains, "provenance": provenance}))


def test_evaluate(tmp_path):
    arguments = ("--policies", "pd", "pd_dob", "--reference", "pd", "--episodes", 6, "--output", tmp_path / "results")
    result = run("evaluate.py", *arguments, "--splits", "flagship_unseen", folder=tmp_path)
    assert result.returncode == 0, result.stderr
    assert "by split" in result.stdout and "flagship_unseen" in result.stdout
    folder = tmp_path / "results" / "flagship"
    for name in ("error_bands.png", "episode.png", "fault_kinds.png"):
        assert (folder / name).read_bytes().startswith(b"\x89PNG") and (folder / name).stat().st_size > 10_000
    report = (folder / "report.md").read_text()
    assert report.startswith("# flagship: pd, pd_dob")
    assert "![episode](episode.png)" in report and "![error bands](error_bands.png)" in report
    assert "![fault kinds](fault_kinds.png)" in report and "| flagship_unseen | 6 feasible |" in report
    with (folder / "episodes.csv").open() as file:
        rows = list(csv.DictReader(file))
    episodes = frozen.load("flagship", 6)
    assert [(row["policy"], int(row["episode"])) for row in rows] == [
        (p, k) for p in ("pd", "pd_dob") for k in range(len(episodes))
    ]
    metrics = rollout("flagship", "pd", episodes).metrics()
    for metric in UNITS:
        written = [float(row[metric]) for row in rows[: len(episodes)]]
        np.testing.assert_allclose(written, metrics[metric], rtol=1e-4, atol=1e-9, err_msg=metric)
    with (folder / "summary.csv").open() as file:
        summary = {(row["policy"], row["metric"], row["kind"]): float(row["value"]) for row in csv.DictReader(file)}
    absent = ("bound_kept", "bound_margin", "jitter", "modal_energy", "residual_energy", "vibration_torque")
    shown = [metric for metric in TABLE_METRICS if metric not in absent]
    assert {metric for _, metric, _ in summary} == set(shown) and len(summary) == 3 * len(shown) + 2 * len(HEADLINES)
    assert summary["pd", "success", "estimate"] == pytest.approx(metrics["success"][episodes.feasible].mean())
    assert summary["pd", "success", "all drawn"] == pytest.approx(metrics["success"].mean())
    with (folder / "recoveries.csv").open() as file:
        faults = list(csv.DictReader(file))
    counted = rollout("flagship", "pd", episodes).recoveries().counted
    assert [int(row["episode"]) for row in faults if row["policy"] == "pd"] == np.argwhere(counted)[:, 0].tolist()
    with (tmp_path / "results" / "flagship_unseen" / "episodes.csv").open() as file:
        assert {row["policy"] for row in csv.DictReader(file)} == {"pd", "pd_dob"}
    # A second call reads the finished batches and gives the same tables.
    batches = {path: path.stat().st_mtime_ns for path in (folder / "batches").iterdir()}
    evaluation = module_of("evaluate")
    evaluation.main(
        evaluation.Config(
            policies=("pd", "pd_dob"),
            reference="pd",
            splits=("flagship_unseen",),
            episodes=6,
            output=tmp_path / "results",
        )
    )
    assert {path: path.stat().st_mtime_ns for path in (folder / "batches").iterdir()} == batches and len(batches) == 2
    assert (folder / "report.md").read_text() == report


def test_evaluate_with_a_seed_draws_other_episodes(tmp_path):
    evaluation = module_of("evaluate")
    drawn = evaluation.draw(evaluation.Config(seed=3, episodes=5), "flagship")
    assert drawn.feasible.sum() == 5
    np.testing.assert_array_equal(drawn.faults, scenarios.get("flagship").draw(3, len(drawn)).faults)
    with pytest.raises(SystemExit, match=r"--episodes: feasible must be within \[1, 500\], got 501"):
        evaluation.draw(evaluation.Config(episodes=501), "flagship")


@pytest.mark.parametrize(("scenario", "words"), [("flagship", "frozen validation"), ("easy", "seed 20000")])
def test_evaluate_chooses_on_validation_episodes_if_told_to(scenario, words):
    evaluation = module_of("evaluate")
    config = evaluation.Config(scenario=scenario, splits=(), episodes=5, episodes_of="validation")
    drawn = evaluation.draw(config, scenario)
    assert drawn.digest() == judging_episodes(scenarios.get(scenario), 5, "validation").digest()
    assert (
        f"{scenario}: {len(drawn)} episodes ({words}), 5 of them feasible"
        in evaluation.origin(config, {scenario: drawn})[0]
    )
    with pytest.raises(
        SystemExit, match=r"^--episodes-of has no effect with --seed: the episodes are those of seed 3$"
    ):
        evaluation.main(replace(config, seed=3))


@pytest.mark.parametrize(
    ("policies", "reference", "message"),
    [
        (("pd", "nobody"), "pd", r"--policies: policy must be 'agent', .*baselines\.names\(\), .*, got 'nobody'"),
        (("pd", "pd_dob"), "agent", r"--reference: 'agent' is not among the policies \['pd', 'pd_dob'\]"),
    ],
)
def test_evaluate_refuses_before_any_work(policies, reference, message, tmp_path):
    evaluation = module_of("evaluate")
    with pytest.raises(SystemExit, match=message):
        evaluation.main(evaluation.Config(policies=policies, reference=reference, output=tmp_path))
    assert not list(tmp_path.iterdir())


def test_evaluate_counts_what_is_not_surely_feasible_if_told_to():
    """The label is conservative: the example of Zhang and Zhou is not feasible."""
    evaluation = module_of("evaluate")
    config = evaluation.Config(scenario="zhang_zhou_2019", episodes=2, seed=0)
    with pytest.raises(SystemExit, match=r"--episodes: scenario must have more feasible.*--count-infeasible"):
        evaluation.draw(config, "zhang_zhou_2019")
    told = replace(config, count_infeasible=True)
    episodes = evaluation.draw(told, "zhang_zhou_2019")
    assert episodes.digest() == scenarios.get("zhang_zhou_2019").draw(0, 2).digest() and not episodes.feasible.any()
    assert evaluation.counted(told, episodes).feasible.all()
    assert evaluation.counted(config, episodes) is episodes
    with pytest.raises(SystemExit, match=r"--episodes: count must be a positive integer, got 0$"):
        evaluation.draw(replace(told, episodes=0), "zhang_zhou_2019")


def test_evaluate_refuses_an_unknown_scenario(tmp_path):
    evaluation = module_of("evaluate")
    with pytest.raises(SystemExit, match=r"--scenario must be one of .*'flagship'.*, got 'nowhere'"):
        evaluation.main(evaluation.Config(policies=("pd",), reference="pd", scenario="nowhere", output=tmp_path))


def test_evaluate_with_tuned_gains(stored, tmp_path, capsys, monkeypatch):
    evaluation = module_of("evaluate")
    judged = []
    # The gallery flies every kind of fault, which takes long; it has tests of its own.
    monkeypatch.setattr(comparison, "fault_gallery", lambda scenario, policy: judged.append(policy) or Figure())
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
        "report.md", "episodes.csv", "summary.csv", "recoveries.csv", "error_bands.png", "episode.png",
        "fault_kinds.png",
    }  # fmt: skip
    batches = output / "flagship" / "batches"
    assert [item.name for item in (output / "flagship").iterdir()] == ["batches"] and len(list(batches.iterdir())) == 2
    # Default gains are flown and stored separately; of gains that are tuned again, only those are flown.
    run = evaluation.run
    console = evaluation.Console(quiet=True)
    default = evaluation.Config(**arguments)
    drawn = {"flagship": evaluation.draw(default, "flagship")}
    assert evaluation.gains_used(default) == "gains of the baselines: pd default, pd_dob default"
    assert default.reports == output
    results = [run(default, evaluation.resolved(default), drawn, console)[0]]
    assert len(list(batches.iterdir())) == 4
    write(stored, "pd", rate_gain=3.5, position_gain=1.0)
    anew = evaluation.Config(**arguments, gains="tuned")
    results.append(run(anew, evaluation.resolved(anew), drawn, console)[0])
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
    flown = evaluation.resolved(evaluation.Config(policies=("agent", "pd_dob"), gains="tuned"))
    assert flown["agent"].fingerprint == Agent.load(SHIPPED / "flagship_residual" / "seed_1").fingerprint
    assert flown["pd_dob"].fingerprint == '["pd_dob", {"bandwidth": 1.0}]'
    alone = evaluation.Config(policies=("agent",), gains="tuned")
    assert evaluation.gains_used(alone) == "gains of the baselines: none among the policies"
