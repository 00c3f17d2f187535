"""Fixtures of the tests of scripts."""

import pytest

from ftac_gym.baselines import tuned


@pytest.fixture
def stored(tmp_path, monkeypatch):
    """Return an empty folder for tuned gains."""
    folder = tmp_path / "tuned_gains"
    folder.mkdir()
    monkeypatch.setattr(tuned, "FOLDER", folder)
    return folder
