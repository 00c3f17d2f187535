"""The study of agents, on agents that are trained already."""

import os
import shutil

import numpy as np
import pytest
from helpers.scripts import module_of

from ftac_gym.agents.shipped import SHIPPED
from ftac_gym.evaluation import rollout
from ftac_gym.scenarios import frozen
from ftac_gym.training.checkpoints import CONTENT_FILE
from ftac_gym.utils.files import locked


def with_checkpoint(run):
    """Add what tells that a run is finished: a checkpoint of its last step."""
    folder = run / "checkpoints" / "0001000000"
    folder.mkdir(parents=True)
    (folder / CONTENT_FILE).touch()


def test_the_study_tabulates_agents_that_are_trained(tmp_path):
    """A combination has three seeds, from two shipped agents; the study uses the first two."""
    study = module_of("study")
    for seed in range(3):
        home = tmp_path / "runs" / "residual_none" / f"seed_{seed}"
        shutil.copytree(SHIPPED / "flagship_residual" / f"seed_{seed % 2}", home / "agent")
        with_checkpoint(home)
    study.main(
        study.Config(
            seeds=2,
            workers=1,
            episodes=4,
            actions=("residual",),
            memories=("none",),
            folder=tmp_path / "runs",
            output=tmp_path / "study",
        )
    )
    report = (tmp_path / "study" / "report.md").read_text()
    episodes = frozen.load("flagship", 4)
    chatter = [
        rollout("flagship", str(SHIPPED / "flagship_residual" / f"seed_{seed}"), episodes).metrics()["chatter"]
        for seed in range(2)
    ]
    base = rollout("flagship", "pd_dob", episodes).metrics()["chatter"]
    feasible = episodes.feasible
    (row,) = [
        line for line in report.split("Mean paired")[1].splitlines() if line.startswith("| residual | none | 2 |")
    ]
    expected = np.mean([item[feasible].mean() for item in chatter]) - base[feasible].mean()
    assert float(row.split("|")[7].split()[0]) == pytest.approx(expected, rel=5e-3)


def test_two_studies_do_not_share_a_folder(tmp_path):
    study = module_of("study")
    with (
        locked(tmp_path),
        pytest.raises(SystemExit, match=f"--folder must be used by one process .* {os.getpid()} uses"),
    ):
        study.main(study.Config(folder=tmp_path))


def test_a_stray_folder_is_no_finished_training(tmp_path, monkeypatch):
    study = module_of("study")
    script = tmp_path / "train.py"
    script.write_text("import sys; print(sys.argv[1:])")
    monkeypatch.setattr(study, "PROGRAMS", script)
    config = study.Config(folder=tmp_path / "runs")
    for seed in range(2):
        home = config.folder / "residual_none" / f"seed_{seed}"
        (home / "checkpoints" / "9999999999").mkdir(parents=True)
        if seed:
            with_checkpoint(home)
        study.train(config, "residual", "none", seed)
        assert (home / "log.txt").exists() == (seed == 0)
