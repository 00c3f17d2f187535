"""Help of every script."""

import pytest
from helpers.scripts import run


@pytest.mark.parametrize("script", ["train", "evaluate", "tune", "study"])
def test_help(script, tmp_path):
    result = run(f"{script}.py", "--help", folder=tmp_path)
    assert result.returncode == 0 and "usage" in result.stdout.lower()
    assert not list(tmp_path.iterdir())
