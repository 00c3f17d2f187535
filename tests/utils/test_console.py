"""Shared pieces of the scripts: errors, command lines and tables."""

import io
from dataclasses import dataclass

import pytest
from rich.console import Console

from ftac_gym.utils.console import command_line, exit_on, show_table


@dataclass(frozen=True)
class Config:
    name: str = "pd"
    trials: int = 300
    names: tuple[str, ...] = ()
    store: bool = False


def test_errors_end_the_program_with_their_message():
    with pytest.raises(SystemExit, match=r"^--trials must be positive$"), exit_on(ValueError):
        raise ValueError("trials must be positive")
    with pytest.raises(TypeError), exit_on(ValueError):
        raise TypeError


def test_a_command_line_leaves_out_the_defaults():
    assert command_line("run.py", Config()) == "python run.py"
    assert command_line("run.py", Config(trials=5, store=True, names=("a", "b c"))) == (
        "python run.py --trials 5 --names a 'b c' --store"
    )
    assert command_line("run.py", Config(trials=5), always=("name",), never=("trials",)) == "python run.py --name pd"


@pytest.mark.parametrize("lines", [False, True])
def test_cells_are_shown_as_they_are(lines):
    console = Console(width=60, record=True, file=io.StringIO())
    show_table(console, [["policy", "success [-]"], ["pd", "0.91 [0.9, 0.92]"]], "title", lines)
    text = console.export_text()
    assert "title" in text and "success [-]" in text and "0.91 [0.9, 0.92]" in text
