"""Formulas as MathML, written when the site is built: they need neither a script nor the network to be seen."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from docutils import nodes
from latex2mathml.converter import convert

if TYPE_CHECKING:
    from sphinx.application import Sphinx
    from sphinx.writers.html5 import HTML5Translator


def formula(latex: str, display: str) -> str:
    """Return a formula as MathML.

    Parameters
    ----------
    latex
        The formula in LaTeX.
    display
        ``"inline"`` or ``"block"``.

    Raises
    ------
    ValueError
        If a command of LaTeX is unknown, which the converter would leave standing.
    """
    markup = str(convert(latex.strip(), display=display))
    if "\\" in markup:
        raise ValueError(f"formula must use known commands of LaTeX only, got {latex!r}")
    return markup


def _visit_inline(translator: HTML5Translator, node: nodes.math) -> None:
    translator.body.append(formula(node.astext(), "inline"))
    raise nodes.SkipNode


def _visit_block(translator: HTML5Translator, node: nodes.math_block) -> None:
    translator.body.append(translator.starttag(node, "div", CLASS="math"))
    translator.body.append(formula(node.astext(), "block"))
    translator.body.append("</div>\n")
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the renderer under the name ``mathml``."""
    app.add_html_math_renderer("mathml", inline_renderers=(_visit_inline, None), block_renderers=(_visit_block, None))
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
