"""Evaluation from the command line: options without an effect, policies that fail, folders that others use."""

import csv

import pytest
from helpers.scripts import module_of
from matplotlib.figure import Figure

from ftac_gym import scenarios
from ftac_gym.evaluation import diagnose
from ftac_gym.report import comparison
from ftac_gym.utils.files import locked

CUSTOM = """
import numpy as np
from ftac_gym.baselines import Baseline

class {name}(Baseline):
    def act(self, measurement):
        late = measurement.time[:, None] > 0.5
        return np.where(late, np.nan, np.zeros((len(measurement), 4)))
"""


@pytest.fixture
def script():
    return module_of("evaluate")


@pytest.fixture
def no_gallery(monkeypatch):
    """Leave out the flights of every kind of fault, which take long."""
    monkeypatch.setattr(comparison, "fault_gallery", lambda scenario, policy: Figure())


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"policies": ("pd", "sb3:no.zip")}, r"--policies: sb3 must be the zip file of a model, got 'no\.zip'"),
        ({"policies": ("pd", "helpers.user_policies:act speed=3")}, "--policies: arguments of .* must be among"),
        ({"policies": ("pd", "helpers.user_policies:Short()")}, "--policies: helpers.user_policies:Short.*: action"),
        ({"benchmark": True, "policies": ("onnx:no.onnx size=3",)}, "--benchmark: arguments of .* must be among"),
        ({"benchmark": True, "gains": "tuned"}, "--gains has no effect with --benchmark: "),
        ({"benchmark": True, "seed": 3}, "--seed has no effect with --benchmark: "),
        ({"benchmark": True, "detail": 0}, "--detail has no effect with --benchmark: "),
        ({"benchmark": True, "diagnosis": True}, "--diagnosis has no effect with --benchmark: "),
        (
            {"diagnosis": True, "policies": ("pd", "nftsm_oracle"), "seed": 3},
            "--diagnosis: none of the policies has estimates to judge\n"
            "no diagnosis: policy must estimate faults .*'pd'\nno diagnosis: .*measurements.*'nftsm_oracle'",
        ),
        ({"benchmark": True, "count_infeasible": True}, "--count-infeasible has no effect with --benchmark: "),
        ({"benchmark": True, "episodes": 501}, r"--episodes: feasible must be within \[1, 500\], got 501"),
        ({"benchmark": True, "splits": (), "reference": "nftsm"}, "--benchmark: reference must be one of"),
        ({"workers": 2}, "--workers has no effect without --benchmark: "),
        ({"backend": "ray"}, "--backend has no effect without --benchmark: "),
        ({"splits": ("nowhere",)}, "--splits must be one of .*'flagship'.*, got 'nowhere'"),
    ],
)
def test_options_are_obeyed_or_refused(changes, message, script, tmp_path):
    arguments = {"policies": ("pd", "pd_dob"), "reference": "pd", "episodes": 1, "output": tmp_path, **changes}
    with pytest.raises(SystemExit, match=f"^{message}"):
        script.main(script.Config(**arguments))
    assert not list(tmp_path.iterdir())


def test_a_policy_that_fails_is_left_out_and_named_at_the_end(script, no_gallery, tmp_path, monkeypatch, capsys):
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "diverging.py").write_text(CUSTOM.format(name="Late"))
    output = tmp_path / "results"
    config = script.Config(
        policies=("pd", "diverging:Late", "pd_dob"),
        reference="pd",
        splits=("flagship_unseen",),
        episodes=1,
        output=output,
    )
    line = "left out of the tables: diverging:Late in flagship: episode 0: action must be finite"
    with pytest.raises(SystemExit, match=f"^{line}") as caught:
        script.main(config)
    assert "\n" not in str(caught.value.code)
    assert "diverging:Late in flagship: episode 0: action must be finite" in capsys.readouterr().out
    report = (output / "flagship" / "report.md").read_text()
    assert report.startswith("# flagship: pd, pd_dob\n") and f"- {line}" in report
    for split in ("flagship", "flagship_unseen"):
        assert "Late" not in (output / split / "episodes.csv").read_text()
        assert "pd_dob" in (output / split / "summary.csv").read_text()
    with pytest.raises(SystemExit, match=r"^diverging:Late in .*\n--reference: diverging:Late failed"):
        script.main(script.Config(**{**vars(config), "reference": "diverging:Late"}))


def test_reports_of_two_processes_are_not_mixed(script, no_gallery, tmp_path, monkeypatch):
    monkeypatch.setattr(comparison, "PATIENCE", 0.1)
    config = script.Config(policies=("pd",), reference="pd", splits=(), episodes=1, output=tmp_path)
    with locked(tmp_path), pytest.raises(SystemExit, match=r"^--output: folder must be used by one process at a time"):
        script.main(config)
    assert [item.name for item in (tmp_path / "flagship").iterdir()] == ["batches"]
    script.main(config)
    assert (tmp_path / "flagship" / "report.md").exists()


def test_a_diagnosis_is_of_the_policies_that_estimate(script, no_gallery, tmp_path, capsys):
    policies = ("pd", "pd_dob", "nftsm_telemetry")
    script.main(
        script.Config(policies=policies, episodes=3, seed=3, splits=(), output=tmp_path, diagnosis=True, reference="pd")
    )
    shown, folder = capsys.readouterr().out, tmp_path / "flagship"
    assert "diagnosis of faults" in shown and "diagnosis.csv" in shown
    report = (folder / "report.md").read_text()
    assert "| measure | pd_dob | nftsm_telemetry |" in report
    assert "- no diagnosis: policy must estimate faults to be judged by a diagnosis, got 'pd'" in report
    found = diagnose("flagship", "pd_dob", scenarios.frozen.draw_feasible(scenarios.get("flagship"), 3, 3))
    with (folder / "diagnosis.csv").open() as file:
        rows = [row for row in csv.DictReader(file) if row["policy"] == "pd_dob" and row["faults"] == "all"]
    written = {row["measure"]: float(row["value"] or "nan") for row in rows}
    for name, value in found.estimates().items():
        assert written[name] == pytest.approx(value.value, rel=1e-5, nan_ok=True), name
    with (folder / "diagnosed_faults.csv").open() as file:
        faults = list(csv.DictReader(file))
    assert [row["policy"] for row in faults].count("pd_dob") == len(found.detections)
