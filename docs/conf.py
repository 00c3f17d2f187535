"""Sphinx configuration.

Pages that follow from the code are written by ``docs/scripts`` before anything is read. Their output, and the site, are
not kept in the repository.
"""

from __future__ import annotations

import importlib
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE / "extensions"), str(HERE / "scripts")]

import ftac_gym  # noqa: E402

if TYPE_CHECKING:
    from sphinx.application import Sphinx

# The site is built the same with and without a screen.
os.environ.setdefault("SDL_VIDEODRIVER", "dummy")
os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")

project = "ftac_gym"
author = "The ftac_gym authors"
project_copyright = "the ftac_gym authors, MIT licence"
release = version = ftac_gym.__version__
language = "en"
highlight_language = "text"

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.viewcode",
    "sphinx_copybutton",
    "sphinx_design",
    "docstrings",
    "mathml",
    "references",
]
exclude_patterns = ["_build", "extensions", "scripts", "environments/generated/table.md", "**/.ipynb_checkpoints"]
nitpicky = True

html_theme = "furo"
html_title = "ftac_gym"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_math_renderer = "mathml"
html_show_sphinx = False

autodoc_default_options = {"members": True, "show-inheritance": True, "ignore-module-all": True}
viewcode_follow_imported_members = False
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_preserve_defaults = True
python_use_unqualified_type_names = True
maximum_signature_line_length = 100
napoleon_attr_annotations = False
napoleon_google_docstring = False
napoleon_use_ivar = True

myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath", "fieldlist"]
myst_heading_anchors = 4

nb_execution_mode = "force"
nb_execution_timeout = 600
nb_execution_raise_on_error = True
nb_execution_show_tb = True
nb_output_stderr = "remove"
nb_merge_streams = True

copybutton_exclude = ".linenos, .gp, .go"

GENERATORS = ("api", "environments", "baselines")
"""Scripts with a function ``write`` that writes pages below the folder that it is given."""


def _write_pages(app: Sphinx) -> None:
    for name in GENERATORS:
        if (HERE / "scripts" / f"{name}.py").exists():
            importlib.import_module(name).write(Path(app.srcdir))


def setup(app: Sphinx) -> None:
    """Write pages before anything is read."""
    app.connect("builder-inited", _write_pages)
