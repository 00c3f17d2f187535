"""Entry points of the programs, for the console commands and the scripts of ``train/``."""

from importlib import import_module

from ftac_gym.utils.endings import one_line_ends

NAMES = ("train", "evaluate", "tune", "reproduce", "play", "study", "synthesize", "convert")
"""Names of the programs, which are modules of this folder."""


def run(name: str) -> None:
    """Run a program of this package with the arguments of the command line.

    Parameters
    ----------
    name
        One of :data:`NAMES`.
    """
    with one_line_ends():
        program, console = import_module(f"ftac_gym.cli.{name}"), import_module("ftac_gym.utils.console")
        console.run_program(program.main, program.Config, program.__doc__)


def train() -> None:
    """Train an agent."""
    run("train")


def evaluate() -> None:
    """Compare policies on identical episodes."""
    run("evaluate")


def tune() -> None:
    """Tune the gains of a baseline."""
    run("tune")


def reproduce() -> None:
    """Reproduce a paper."""
    run("reproduce")


def play() -> None:
    """Show a policy."""
    run("play")


def study() -> None:
    """Train and compare a grid of agents."""
    run("study")


def synthesize() -> None:
    """Solve the matrix inequalities of Li et al. 2023."""
    run("synthesize")


def convert() -> None:
    """Convert an old agent."""
    run("convert")
