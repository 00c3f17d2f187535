"""Write a page of the API reference for every module of the package."""

from __future__ import annotations

import ast
import pkgutil
import re
from pathlib import Path

from pages import remove_strangers, write_if_changed

import ftac_gym

FOLDER = "api/generated"
INTERNAL = re.compile(r"ftac_gym\.evaluation\.reproduction\.\w+_\d{4}")
"""Modules that have no page: what one paper's report is made of."""


def modules() -> list[str]:
    """Return the names of all public modules, packages before what they hold."""
    found = [
        item.name
        for item in pkgutil.walk_packages(ftac_gym.__path__, "ftac_gym.")
        if not any(part.startswith("_") for part in item.name.split(".")) and not INTERNAL.match(item.name)
    ]
    return ["ftac_gym", *sorted(found)]


def source_file(module: str) -> Path:
    """Return the file of a module."""
    base = Path(ftac_gym.__file__).parent.parent.joinpath(*module.split("."))
    package = base / "__init__.py"
    return package if package.exists() else base.with_suffix(".py")


def passed_on(tree: ast.Module) -> list[str]:
    """Return the names in ``__all__`` that the module does not define itself."""
    listed: list[str] = []
    own = set()
    for node in tree.body:
        if isinstance(node, ast.Assign) and any(isinstance(t, ast.Name) and t.id == "__all__" for t in node.targets):
            listed = [str(name) for name in ast.literal_eval(node.value)]
        if isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            own |= {target.id for target in targets if isinstance(target, ast.Name)}
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            own.add(node.name)
    return sorted(set(listed) - own, key=str.lower)


def summary(tree: ast.Module) -> str:
    """Return the first sentence of a module's docstring, without its full stop."""
    return (ast.get_docstring(tree) or "").split("\n\n")[0].replace("\n", " ").removesuffix(".").replace("|", r"\|")


def page(module: str, known: list[str]) -> str:
    """Return the page of a module as reStructuredText.

    The pages are orphans: two hundred of them would bury everything else in the navigation. Each begins with the way
    back instead, and a package lists what it holds.
    """
    tree = ast.parse(source_file(module).read_text(encoding="utf-8"))
    parents = module.split(".")[:-1]
    way = [":doc:`API reference </api/index>`"]
    way += [f":doc:`{name} <{'.'.join(parents[: index + 1])}>`" for index, name in enumerate(parents)]
    lines = [":orphan:", "", " / ".join(way), "", module, "=" * len(module), "", f".. automodule:: {module}", ""]
    if names := passed_on(tree):
        lines += [".. rubric:: Names to import from here", ""]
        lines += [", ".join(f":py:obj:`~{module}.{name}`" for name in names), ""]
    children = [name for name in known if name.startswith(f"{module}.") and name.count(".") == module.count(".") + 1]
    if children:
        lines += [".. rubric:: Modules", ""]
        for name in children:
            about = summary(ast.parse(source_file(name).read_text(encoding="utf-8")))
            lines += [f":doc:`{name}`", f"   {about}", ""]
    return "\n".join(lines)


def write(source: Path) -> None:
    """Write the pages of all modules below ``docs``."""
    known = modules()
    written = []
    for module in known:
        written.append(source / FOLDER / f"{module}.rst")
        write_if_changed(written[-1], page(module, known))
    remove_strangers(source / FOLDER, written)


if __name__ == "__main__":
    write(Path(__file__).parents[1])
