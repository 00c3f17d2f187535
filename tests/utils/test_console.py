"""Shared pieces of the scripts: errors, command lines and tables."""

import io
import os
import subprocess
import sys
import textwrap
import warnings
from dataclasses import dataclass

import pytest
from helpers.small_disk import on_small_disk
from rich.console import Console

from ftac_gym.baselines import SampledInstability
from ftac_gym.utils.console import command_line, exit_on, one_line_warnings, show_table


@dataclass(frozen=True)
class Config:
    name: str = "pd"
    trials: int = 300
    names: tuple[str, ...] = ()
    store: bool = False


@pytest.mark.parametrize(
    ("message", "shown"),
    [
        ("num_envs must be positive", "--num_envs must be positive"),
        ("policies[0]: no such", "--policies[0]: no such"),
        ("gains.json cannot be read", "gains.json cannot be read"),
        ("runs/gains cannot be read", "runs/gains cannot be read"),
        ("ResidualPolicy: base must be", "ResidualPolicy: base must be"),
    ],
)
def test_dashes_are_for_options(message, shown):
    with pytest.raises(SystemExit) as end, exit_on(ValueError):
        raise ValueError(message)
    assert str(end.value) == shown


def test_errors_end_the_program_with_their_message():
    with pytest.raises(SystemExit, match=r"^--trials must be positive$"), exit_on(ValueError):
        raise ValueError("trials must be positive")
    with pytest.raises(TypeError), exit_on(ValueError):
        raise TypeError


def test_warnings_of_the_package_are_lines_and_others_are_not(monkeypatch):
    lines, others = [], []
    monkeypatch.setattr(warnings, "showwarning", lambda message, category, *place: others.append(category))
    with one_line_warnings(lines.append):
        warnings.simplefilter("always")
        for category in (UserWarning, SampledInstability, RuntimeWarning):
            warnings.warn("too slow", category, stacklevel=1)
    assert lines == ["warning: too slow"] * 2 and others == [RuntimeWarning]


def test_a_command_line_leaves_out_the_defaults():
    assert command_line("run", Config()) == "run"
    assert command_line("run", Config(trials=5, store=True, names=("a", "b c"))) == (
        "run --trials 5 --names a 'b c' --store"
    )
    assert command_line("run", Config(trials=5), always=("name",), never=("trials",)) == "run --name pd"


@pytest.mark.parametrize("lines", [False, True])
def test_cells_are_shown_as_they_are(lines):
    console = Console(width=60, record=True, file=io.StringIO())
    show_table(console, [["policy", "success [-]"], ["pd", "0.91 [0.9, 0.92]"]], "title", lines)
    text = console.export_text()
    assert "title" in text and "success [-]" in text and "0.91 [0.9, 0.92]" in text


PROGRAM = """
from dataclasses import dataclass
from pathlib import Path

from ftac_gym.utils.console import run_program
from ftac_gym.utils.files import write_text

@dataclass(frozen=True)
class Config:
    folder: Path = Path()

def main(config: Config) -> None:
    {body}

run_program(main, Config, "Text.")
"""


def program(body, *arguments):
    return [sys.executable, "-c", PROGRAM.format(body=body), *map(str, arguments)]


def run(command, **options):
    return subprocess.run(command, capture_output=True, text=True, timeout=60, check=False, **options)


def test_a_program_that_ends_well():
    done = run(program("print(config.folder)", "--folder", "a"))
    assert (done.returncode, done.stdout, done.stderr) == (0, "a\n", "")


@pytest.mark.parametrize(
    ("body", "status", "line"),
    [
        ("raise KeyboardInterrupt", 130, "interrupted\n"),
        ("Path('/dev/full').write_text('text')", 1, "No space left on device\n"),
        ("raise PermissionError(13, 'Permission denied', 'results/report.md')", 1,
         "Permission denied: results/report.md\n"),
        ("open('absent.txt')", 1, "No such file or directory: absent.txt\n"),
        ("open('.')", 1, "Is a directory: .\n"),
        ("raise OSError('[Errno 36] some library')", 1, "[Errno 36] some library\n"),
        ("raise SystemExit('--seeds must be positive')", 1, "--seeds must be positive\n"),
    ],
)  # fmt: skip
def test_the_surroundings_end_a_program_with_one_line(body, status, line):
    done = run(program(body))
    assert (done.returncode, done.stdout, done.stderr) == (status, "", line)


def test_other_errors_keep_their_traceback():
    assert "ZeroDivisionError" in run(program("1 / 0")).stderr
    assert "RuntimeError" in run(program("raise RuntimeError")).stderr


@pytest.mark.parametrize("lines", [1, 100_000])
def test_a_closed_pipe_ends_a_program_in_silence(lines):
    reader, writer = os.pipe()
    os.close(reader)
    with os.fdopen(writer, "w") as closed:
        command = program(f"[print('line') for _ in range({lines})]")
        done = subprocess.run(command, stdout=closed, stderr=subprocess.PIPE, text=True, timeout=60, check=False)
    assert (done.returncode, done.stderr) == (141, "")


@pytest.mark.parametrize("lines", [1, 100_000])
def test_output_to_a_full_disk_ends_a_program_with_one_line(lines):
    with open("/dev/full", "w") as full:
        command = program(f"[print('line') for _ in range({lines})]")
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, timeout=60, check=False)
    assert (done.returncode, done.stderr) == (1, "No space left on device\n")


def test_a_full_disk_is_named_with_the_file_and_leaves_the_old_one(tmp_path):
    body = textwrap.dedent("""\
        path = config.folder / "report.md"
            write_text(path, "old")
            try:
                write_text(path, 100_000 * "new")
            finally:
                print(path.read_text(), [item.name for item in config.folder.iterdir()])
    """)
    done = run(on_small_disk(program(body, "--folder", tmp_path), tmp_path, 64))
    assert done.stdout == "old ['report.md']\n"
    assert (done.returncode, done.stderr) == (1, f"No space left on device: {tmp_path / 'report.md'}\n")


def test_a_terminal_without_the_characters_shows_escapes():
    ascii_only = {**os.environ, "LC_ALL": "C", "PYTHONCOERCECLOCALE": "0", "PYTHONUTF8": "0", "PYTHONIOENCODING": ""}
    done = run(program(r"print('12 \N{MICRO SIGN}s')"), env=ascii_only)
    assert (done.returncode, done.stdout, done.stderr) == (0, r"12 \xb5s" + "\n", "")
