"""The tutorials are notebooks without results, in the index of the tutorials."""

import json
from pathlib import Path

import pytest

TUTORIALS = Path(__file__).parents[2] / "docs" / "tutorials"
NOTEBOOKS = sorted(TUTORIALS.glob("*.ipynb"))


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_holds_no_results(path):
    text = path.read_text(encoding="utf-8")
    cells = json.loads(text)["cells"]
    code = [cell for cell in cells if cell["cell_type"] == "code"]
    assert code and all(cell["outputs"] == [] and cell["execution_count"] is None for cell in code)
    assert cells[0]["source"][0].startswith("# ")
    assert "{py:" not in text  # a role of the site is no text in a notebook


def test_every_notebook_is_in_the_index():
    index = (TUTORIALS / "index.md").read_text(encoding="utf-8")
    assert NOTEBOOKS and all(f"({path.name})" in index and f"\n{path.stem}\n" in index for path in NOTEBOOKS)
