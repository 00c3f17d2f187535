import re
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("rl_zoo3", reason="needs the extra libraries")

from helpers.library_pages import snippets


def test_the_zoo_trains_evaluates_and_shows(tmp_path):
    (tmp_path / "zoo.yml").write_text(snippets("RL Baselines3 Zoo", "yaml")[0])
    train, enjoy = snippets("RL Baselines3 Zoo", "console")[0].replace("duration:60.0", "duration:4.0").splitlines()
    text = output(train, tmp_path)
    assert "Using 4 environments" in text and re.search(r"total_timesteps *\| 1024 ", text)
    assert re.findall(r"mean_ep_length *\| (\d+)", text)[0] == "40"
    assert Path(tmp_path, "logs/ppo/SpacecraftFTC-v0_1/SpacecraftFTC-v0.zip").is_file()
    text = output(enjoy, tmp_path)
    assert "30 Episodes" in text and "Mean episode length: 40.00 +/- 0.00" in text and "Success rate: " in text


def output(command, folder):
    """Return what a command of the page prints, with this Python."""
    program, *arguments = command.split()
    assert program == "python"
    done = subprocess.run([sys.executable, *arguments], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    return done.stdout
