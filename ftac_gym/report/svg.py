"""Figures as SVG: files that stand alone, and images of a page that follow its light or dark colours."""

from __future__ import annotations

import io
import re
import warnings
from base64 import b64encode
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import matplotlib
from matplotlib.figure import Figure

from ftac_gym.plots.style import COLORS, FAINT, GRID, INK, MUTED

PAPER = "#fffffe"
"""Background: like the other colours of :data:`DARK`, one that nothing else in a figure has."""

_DARK_SERIES = ("#3d9fdc", "#ff8236", "#2cc79b", "#e39cc4", "#f2b632", "#93d3f8")
DARK = {
    **{PAPER: "#151518", INK: "#ececef", MUTED: "#a3a3ad", FAINT: "#5c5c66", GRID: "#313138"},
    **{light.lower(): dark for light, dark in zip(COLORS, _DARK_SERIES, strict=False)},
}
"""Colours on a dark page, by those on a light one."""


@contextmanager
def drawing() -> Iterator[None]:
    """Apply the settings with which figures are drawn and saved."""
    # Names of policies are text, whatever characters they have; the salt makes equal figures equal files.
    settings: dict[Any, Any] = {"text.parse_math": False, "svg.fonttype": "none", "svg.hashsalt": "ftac_gym"}
    with matplotlib.rc_context(settings), warnings.catch_warnings():
        # The fonts of the reader's browser show the text, not those that measure it here.
        warnings.filterwarnings("ignore", message="Glyph .* missing from font")
        yield


def svg(figure: Figure) -> str:
    """Return a figure as an SVG document."""
    buffer = io.StringIO()
    nothing = dict.fromkeys(("Creator", "Date", "Format", "Type"))
    figure.savefig(buffer, format="svg", metadata=nothing, facecolor=PAPER)
    return re.sub(r" ?\n(?=[LMCQz\"])", " ", buffer.getvalue())


def data_uri(document: str) -> str:
    """Return an SVG document as the source of an image that is dark on a dark page."""
    dark = ""
    for number, (light, instead) in enumerate(DARK.items()):
        document = document.replace(light, f"var(--c{number}, {light})")
        dark += f"--c{number}: {instead}; "
    style = (
        f"<style>svg {{ color-scheme: light dark; }} text {{ font-family: system-ui, sans-serif !important; }} "
        f"@media screen and (prefers-color-scheme: dark) {{ svg {{ {dark}}} }}</style>"
    )
    document = re.sub(r"(<svg[^>]*>)", rf"\1{style}", document, count=1)
    return f"data:image/svg+xml;base64,{b64encode(document.encode()).decode()}"
