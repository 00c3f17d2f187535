"""The README and the site show the same results and code."""

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def rows(text):
    """Return the rows of tables that hold intervals."""
    return {line for line in text.splitlines() if line.startswith("| ") and "[0." in line}


def first_program(text):
    """Return the lines of the first Python block, without comments."""
    return re.sub(r"\s+#.*", "", re.search(r"```python\n(.*?)```", text, re.DOTALL)[1]).splitlines()


def test_the_results_of_the_readme_are_those_of_the_site():
    shown = rows(README)
    assert shown and shown <= rows((ROOT / "docs" / "results.md").read_text(encoding="utf-8"))


def test_the_ten_lines_are_the_same():
    assert first_program(README) == first_program((ROOT / "docs" / "index.md").read_text(encoding="utf-8"))


def test_the_ten_lines_are_those_that_mypy_checks():
    checked = Path(__file__).with_name("ten_lines.py")
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["mypy"]
    assert settings["strict"] and checked.relative_to(ROOT).as_posix() in settings["files"]
    assert first_program(README) == re.sub(r"\s+#.*", "", checked.read_text(encoding="utf-8")).splitlines()


def test_the_readme_is_short_and_names_the_two_commands():
    assert len(README.splitlines()) <= 150
    assert "make evaluate" in README and "make test" in README
