"""The check of the prose finds planted offences, and nothing in code, equations and tables."""

import json

import prose
import pytest

LONG = "one two three four five six seven eight nine ten " * 3


def found(tmp_path, name, text):
    """Return the complaints about a file, without its path."""
    path = tmp_path / name
    path.write_text(text)
    return [line.removeprefix(f"{path}:") for line in prose.complaints(path)]


@pytest.mark.parametrize(
    ("source", "complaint"),
    [
        ('def f():\n    """What comes out."""\n', "2: a docstring opens with 'what'"),
        ('"""A module.\n\nThe wheel is struck.\n"""\n', "3: 'struck': write occurs, acts or affected"),
        ('x = 1\n"""A craft."""\n', "2: 'craft': write spacecraft"),
        ("# The law knows\n# the fault.\n", "1: 'knows'"),
        ("raise ValueError('nobody gave a number')\n", "1: 'nobody': write the thing itself"),
        ("require(ok, 'x', f'{y} shall be set', x)\n", "1: 'shall': write plain words"),
        (f"# {LONG}.\n", "1: a sentence of 30 words: at most 25: 'one two"),
    ],
)
def test_a_planted_offence_in_code_is_found(tmp_path, source, complaint):
    (line,) = found(tmp_path, "module.py", source)
    assert line.startswith(complaint)


@pytest.mark.parametrize(
    "source",
    [
        "text = 'a craft in data is no message'\n",
        f'"""A law.\n\nIt has the form\n\n    {LONG}\n\nand ends.\n"""\n',
        f'"""A law::\n\n    {LONG}\n\nand ends.\n"""\n',
        '"""Do it.\n\nParameters\n----------\n'
        + "".join(f"name{number}\n    A number that has its own unit.\n" for number in range(6))
        + '"""\n',
        f'"""A table.\n\n====  ====\nname  {LONG}\n====  ====\n"""\n',
    ],
)
def test_equations_sections_and_tables_are_no_sentences(tmp_path, source):
    assert found(tmp_path, "module.py", source) == []


def test_a_page_is_read_without_its_code(tmp_path):
    page = f"---\nkey: craft\n---\n\n# Title\n\n```python\n# {LONG}\n```\n\n$$\n{LONG}\n$$\n\n| {LONG} |\n"
    assert found(tmp_path, "page.md", page) == []
    assert found(tmp_path, "page.md", f"{page}\n- A craft: `craft`,\n  [here](craft.md).\n- {LONG}\n") == [
        "17: 'craft': write spacecraft",
        f"19: a sentence of 30 words: at most 25: {LONG[:60]!r}",
    ]


def test_items_of_a_list_are_counted_apart(tmp_path):
    half = " ".join(["word"] * 20)
    assert found(tmp_path, "page.md", f"- {half}\n- {half}\n") == []
    assert len(found(tmp_path, "page.md", f"- {half}\n  {half}\n")) == 1


def test_the_text_cells_of_a_notebook_are_read(tmp_path):
    code, page = ["craft = 1"], ["# Title\n", "A craft."]
    cells = [{"cell_type": "code", "source": code}, {"cell_type": "markdown", "source": page}]
    assert found(tmp_path, "page.ipynb", json.dumps({"cells": cells})) == ["2: 'craft': write spacecraft"]


def test_the_program_fails_on_an_offence(tmp_path, capsys):
    (tmp_path / "page.md").write_text("Nobody.\n")
    assert prose.main([str(tmp_path)]) == 1
    (tmp_path / "page.md").write_text("A page.\n")
    assert prose.main([str(tmp_path)]) == 0
    assert capsys.readouterr().out.endswith("0 complaints about the prose of 1 files\n")
