"""References between the prose, the sources and the API pages.

The Markdown files link to sources by relative paths, which work on a code host. On the site the same links lead to the
page of the module. Names are documented where they are defined; a reference to a name that a package passes on, such as
``ftac_gym.faults.Bias``, leads there. Names of other packages stay text, since the build has no network.
"""

from __future__ import annotations

import ast
import builtins
import functools
import importlib
import posixpath
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sphinx.addnodes import pending_xref

if TYPE_CHECKING:
    from docutils import nodes
    from sphinx.application import Sphinx
    from sphinx.environment import BuildEnvironment

PACKAGE = "ftac_gym"
API_PAGES = "api/generated"
ROOT_PAGES = {
    "README.md": "index.md",
    "CHANGELOG.md": "changelog.md",
    "CITATION.cff": "citation.md",
    "LICENSE": "licence.md",
}
"""Pages of the site that stand for files of the repository's root."""

_LINK = re.compile(r"\]\((?P<path>(?:\.\./)+[^)#\s]+)(?P<anchor>#[^)\s]*)?\)")


def site_target(path: str, folder: str) -> str | None:
    """Return the page of the site that stands for a linked file of the repository.

    Parameters
    ----------
    path
        Relative path, as the link has it.
    folder
        Folder of the linking page, relative to ``docs``; empty for ``docs`` itself.

    Returns
    -------
    Path of the page relative to that folder; None where the link stays as it is.
    """
    inside = posixpath.normpath(posixpath.join("docs", folder, path))
    if inside in ROOT_PAGES:
        page = ROOT_PAGES[inside]
    elif inside == PACKAGE or inside.startswith(f"{PACKAGE}/"):
        page = f"{API_PAGES}/{inside.removesuffix('.py').removesuffix('/__init__').replace('/', '.')}.rst"
    else:
        return None
    return posixpath.relpath(page, folder or ".")


def redirect_links(text: str, folder: str) -> str:
    """Return Markdown whose links to files of the repository lead to the pages that stand for them."""

    def redirect(match: re.Match[str]) -> str:
        target = site_target(match["path"], folder)
        # An anchor of the file is none of the page that stands for it.
        return match[0] if target is None else f"]({target})"

    return _LINK.sub(redirect, text)


def _redirect(app: Sphinx, document: str, content: list[str]) -> None:
    if Path(app.env.doc2path(document)).suffix == ".md":
        content[0] = redirect_links(content[0], posixpath.dirname(document))


@functools.cache
def imported_names(module: str) -> dict[str, str]:
    """Return what a module imports, by the names it uses, also for its annotations alone."""
    base = Path(importlib.import_module(PACKAGE).__file__ or "").parents[1].joinpath(*module.split("."))
    # Read, not imported: a module that cannot be imported is for autodoc to complain of.
    path = base / "__init__.py" if base.is_dir() else base.with_name(f"{base.name}.py")
    tree = ast.parse(path.read_text(encoding="utf-8"))
    imports = [node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and node.module]
    return {alias.asname or alias.name: f"{node.module}.{alias.name}" for node in imports for alias in node.names}


def find(target: str) -> tuple[str, str] | None:
    """Return the module through which a dotted name is reached, and where the object is defined.

    Returns
    -------
    Module and full name; None if there is no such object.
    """
    parts = target.split(".")
    for length in range(len(parts), 0, -1):
        module = ".".join(parts[:length])
        try:
            owner: Any = importlib.import_module(module)
        except ImportError:
            continue
        for attribute in parts[length:]:
            if not hasattr(owner, attribute):
                return None
            owner = getattr(owner, attribute)
        home, name = getattr(owner, "__module__", None), getattr(owner, "__qualname__", None)
        return module, f"{home}.{name}" if home and name else target
    return None


def _qualify(app: Sphinx, doctree: nodes.document) -> None:
    """Let names that a module imports mean what it imports, before Sphinx looks for whatever is called so."""
    for node in doctree.findall(pending_xref):
        target = str(node.get("reftarget"))
        # What autodoc makes of an alias of a type does not know its module; its page does.
        module = node.get("py:module") or app.env.docname.removeprefix(f"{API_PAGES}/")
        ours = node.get("refdomain") == "py" and module.startswith(PACKAGE)
        if ours and (full := imported_names(module).get(target)):
            node["reftarget"], node["refspecific"] = full, False


def _resolve(
    app: Sphinx, environment: BuildEnvironment, node: pending_xref, content: nodes.TextElement
) -> nodes.Element | None:
    if node.get("refdomain") != "py":
        return None
    target, module, owner = str(node["reftarget"]), node.get("py:module"), node.get("py:class")
    if module and module.startswith(PACKAGE) and "." not in target:
        inner = [f"{module}.{owner}.{target}", f"{module}.{target}"] if owner else [f"{module}.{target}"]
        target = next(filter(find, inner), target)
    domain = environment.domains["py"]
    if not target.startswith(f"{PACKAGE}."):
        if "." in target or hasattr(builtins, target):
            return content
        # A neighbour that the module speaks of without importing it: found if its name is unique.
        node["refspecific"] = True
        return domain.resolve_xref(environment, node["refdoc"], app.builder, node["reftype"], target, node, content)
    found = find(target)
    if found is None:
        return None
    reached, defined = found
    # What has no entry of its own, such as a private base or a plain constant, is found on the page of its module.
    for candidate in (defined, reached):
        places = domain.resolve_any_xref(environment, node["refdoc"], app.builder, candidate, node, content)
        if places:
            return places[0][1]
    return content if any(part.startswith("_") for part in target.split(".")) else None


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect the transforms."""
    app.connect("source-read", _redirect)
    app.connect("doctree-read", _qualify)
    app.connect("missing-reference", _resolve)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
