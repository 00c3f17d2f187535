"""Sphinx configuration.

``docs/tools`` writes the pages of environments and baselines before Sphinx reads anything, apidoc the API pages.
"""

from __future__ import annotations

import contextlib
import os
import pkgutil
import re
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent / "tools"))
os.environ.setdefault("SDL_VIDEODRIVER", "dummy")  # frames are drawn without a screen
os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")

import baseline_pages
import environment_pages

import ftac_gym

project = html_title = "ftac_gym"
author = "The ftac_gym authors"
project_copyright = "the ftac_gym authors, MIT licence"
release = version = ftac_gym.__version__
highlight_language = "text"
extensions = [
    "myst_nb",
    "numpydoc",
    "sphinx.ext.apidoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.intersphinx",
    "sphinx.ext.mathjax",
    "sphinx.ext.viewcode",
    "sphinx_copybutton",
    "sphinx_design",
]
exclude_patterns = ["_build", "**/.ipynb_checkpoints", "api/generated/modules.rst"]

html_theme = "furo"
# MathJax is part of the site: formulas need no network.
html_static_path = ["_static", str(Path(find_spec("sphinx-mathjax-offline").origin).parent / "static")]
mathjax_path = "mathjax/tex-chtml.js"
html_css_files = ["site.css"]
html_show_sphinx = False

# Not autosummary: that takes the module ftac_gym.evaluation.compare for the function of its package.
apidoc_modules = [
    {"path": "../ftac_gym", "destination": "api/generated", "separate_modules": True, "module_first": True}
]
autodoc_default_options = {"members": True, "show-inheritance": True, "ignore-module-all": True}
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
python_use_unqualified_type_names = True
maximum_signature_line_length = 100
numpydoc_show_class_members = False
viewcode_follow_imported_members = False

myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath", "fieldlist"]
myst_heading_anchors = 4
nb_execution_mode = "force"
nb_execution_timeout = 600
nb_execution_raise_on_error = True
nb_output_stderr = "remove"
nb_merge_streams = True
copybutton_exclude = ".linenos, .gp, .go"

# An inventory that cannot be fetched is a warning: links to other packages are there with DOCS_INTERSPHINX=1 only.
INVENTORIES = {
    "python": "https://docs.python.org/3",
    "numpy": "https://numpy.org/doc/stable",
    "gymnasium": "https://gymnasium.farama.org",
    "stable_baselines3": "https://stable-baselines3.readthedocs.io/en/master",
    "matplotlib": "https://matplotlib.org/stable",
}
intersphinx_mapping = {name: (url, None) for name, url in INVENTORIES.items() if os.environ.get("DOCS_INTERSPHINX")}
nitpicky = True
nitpick_ignore_regex = [
    ("py:.*", r"(?!ftac_gym)[a-z_\d]+\..*|BaseAlgorithm|BasePolicy|VecNormalize")
]  # of other packages


def shorten(*event: Any) -> tuple[str | None, ...]:
    """Write array types in signatures as ``NDArray``, as the code does, and defaults such as ``<factory>`` as dots."""
    array = r"~?numpy\.ndarray\[~?tuple\[~?(?:typing\.)?Any, \.\.\.\], ~?numpy\.dtype\[~?([\w.]+)\]\]"
    texts = (part and re.sub(array, r"numpy.typing.NDArray[\1]", part) for part in event[-2:])
    return tuple(text and re.sub(r"<[^<>]*>", "...", text) for text in texts)


def mark_headings(*event: Any) -> None:
    """Turn the Markdown headings that Gymnasium has in docstrings of environments into rubrics."""
    event[-1][:] = [f".. rubric:: {line[3:]}" if line.startswith("## ") else line for line in event[-1]]


def follow_import(app: Any, env: Any, node: Any, content: Any) -> Any:
    """Lead a name that a module imports, such as ``ftac_gym.faults.Bias``, to the module that defines it."""
    for name in (node["reftarget"], f"{node.get('py:module')}.{node['reftarget']}"):
        if node.get("refdomain") == "py" and name.startswith("ftac_gym."):
            with contextlib.suppress(ImportError, AttributeError, ValueError):
                found = pkgutil.resolve_name(name)
                target = f"{getattr(found, '__module__', '')}.{getattr(found, '__qualname__', '')}"
                places = env.domains["py"].resolve_any_xref(env, node["refdoc"], app.builder, target, node, content)
                return places[0][1] if places else content  # a name without an entry of its own stays text
    return None


def setup(app: Any) -> None:
    """Write the pages, and connect the functions above."""
    environment_pages.write(Path(app.srcdir))
    baseline_pages.write(Path(app.srcdir))
    app.connect("autodoc-process-signature", shorten, priority=400)  # before numpydoc, which gives data a signature
    app.connect("autodoc-process-docstring", mark_headings)
    app.connect("missing-reference", follow_import)
