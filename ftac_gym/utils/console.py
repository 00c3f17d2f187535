"""Pieces that the command-line scripts share: errors, provenance and tables; needs the ``train`` extra."""

import dataclasses
import re
import shlex
import subprocess
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, TypeVar

import tyro
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from ftac_gym.utils.endings import one_line_ends
from ftac_gym.utils.files import locked
from ftac_gym.utils.parameters import fields_named

Config = TypeVar("Config")


def run_program(main: Callable[[Config], None], config: type[Config], description: str | None) -> None:
    """Run a program with the configuration of its command line; see :func:`~ftac_gym.utils.endings.one_line_ends`.

    Parameters
    ----------
    main
        The program.
    config
        Dataclass of its options.
    description
        Help text.
    """
    with one_line_ends():
        main(tyro.cli(config, prog=Path(sys.argv[0]).name, description=description))


@contextmanager
def exit_on(*errors: type[Exception], prefix: str = "--") -> Iterator[None]:
    """End the program with the message of an error, after a prefix, instead of a traceback.

    The prefix ``--`` is for messages that begin with the name of an option; one of a file or a class stays as it is.
    """
    try:
        yield
    except errors as error:
        bare = prefix == "--" and re.match(r"[a-z][a-z_-]*(\[\d+\])?[ :]", str(error)) is None
        raise SystemExit(f"{'' if bare else prefix}{error}") from None


@contextmanager
def one_line_warnings(write: Callable[[str], Any]) -> Iterator[None]:
    """Hand this package's warnings to a function that prints a line, without their place in the code."""
    with warnings.catch_warnings():
        usual = warnings.showwarning

        def show(message: Any, category: type[Warning], *place: Any, **more: Any) -> None:
            if category is UserWarning or category.__module__.startswith("ftac_gym."):
                write(f"warning: {message}")
            else:
                usual(message, category, *place, **more)

        warnings.showwarning = show
        yield


@contextmanager
def alone_in(folder: Path, option: str) -> Iterator[None]:
    """Keep other processes out of a folder during the block; end the program if one is there already.

    Parameters
    ----------
    folder
        The folder, which is created.
    option
        Option of the command line that names it.
    """
    with ExitStack() as stack:
        with exit_on(ValueError), fields_named(folder=option):
            stack.enter_context(locked(folder))
        yield


def command_line(program: str, config: Any, always: Sequence[str] = (), never: Sequence[str] = ()) -> str:
    """Return the command line that makes a configuration, a dataclass.

    Parameters
    ----------
    program
        Name of the command.
    config
        The configuration; fields at their defaults are left out.
    always, never
        Fields that are stated, or left out, whatever their value.
    """
    words, default = [program], type(config)()
    for item in dataclasses.fields(config):
        value = getattr(config, item.name)
        if item.name in never or (value == getattr(default, item.name) and item.name not in always):
            continue
        words.append("--" + item.name.replace("_", "-"))
        if not isinstance(value, bool):
            words += map(str, value) if isinstance(value, tuple) else [str(value)]
    return shlex.join(words)


def checkout() -> Path | None:
    """Return the folder of the git checkout of which this package is a part; None for an installed package."""
    folder = Path(__file__).parents[2]
    return folder if (folder / ".git").exists() and (folder / "pyproject.toml").is_file() else None


def commit() -> str | None:
    """Return the git commit of this package's checkout, with "-dirty" if its code has changed; None without git."""
    folder = checkout()

    def git(*words: str) -> str:
        return subprocess.run(["git", *words], capture_output=True, text=True, check=True, cwd=folder).stdout.strip()

    code = (":(top)ftac_gym", ":(top)train", ":(top,exclude)ftac_gym/baselines/tuned_gains")
    if folder is None:
        return None  # A repository around an installed package has other code.
    try:
        return git("rev-parse", "HEAD") + ("-dirty" if git("status", "--porcelain", "--", *code) else "")
    except (OSError, subprocess.CalledProcessError):
        return None


def check_store(store: bool) -> None:
    """End the program if it is to write into a package that is installed."""
    if store and checkout() is None:
        raise SystemExit("--store writes into a checkout of the package; this one is installed, and stays as it is")


def print_line(console: Console, line: str) -> None:
    """Print a line as it is."""
    console.print(line, markup=False, highlight=False, soft_wrap=True)


def progress_bar(console: Console) -> Progress:
    """Return a bar that counts what is done, beside a description and the time that remains."""
    columns = (TextColumn("{task.description:>18}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    return Progress(*columns, console=console)


def show_table(console: Console, cells: Sequence[Sequence[str]], title: str, lines: bool = False) -> None:
    """Print a table.

    Parameters
    ----------
    console
        Output.
    cells
        Rows of text, the headings first.
    title
        Text above the table.
    lines
        Whether to draw a line between rows.
    """
    table = Table(title=title, title_justify="left", show_lines=lines)
    for index, heading in enumerate(cells[0]):
        table.add_column(escape(heading), no_wrap=index == 0, overflow="fold")
    for row in cells[1:]:
        table.add_row(*(escape(cell) for cell in row))
    console.print(table)
