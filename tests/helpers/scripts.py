"""Scripts of ``train/``, as processes and as modules."""

import importlib
import subprocess
import sys
from pathlib import Path

SCRIPTS = Path(__file__).parents[2] / "train"
RARELY = ("--checkpoint-every", "512", "--evaluate-every", "100000000", "--torch-threads", "1")
"""Options of short trainings: evaluations at the end alone."""
TINY = (
    *("--critic-warmup", "0", "--num-envs", "8", "--hyperparameters", "n_steps=32", "batch_size=128"),
    *RARELY,
)
"""Options of tiny trainings: 8 spacecraft and rollouts of 32 steps, 256 steps to a rollout."""


def command(script, *arguments):
    """Return the command line of a script."""
    return [sys.executable, str(SCRIPTS / script), *map(str, arguments)]


def run(script, *arguments, folder):
    """Run a script to its end in a folder."""
    return subprocess.run(command(script, *arguments), cwd=folder, capture_output=True, text=True, timeout=120)


def module_of(script):
    """Return the program of a script as a module."""
    return importlib.import_module(f"ftac_gym.cli.{script}")
