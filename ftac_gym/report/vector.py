"""Figures as SVG: files that stand alone, and parts of a page that follow its light or dark colours."""

from __future__ import annotations

import io
import re
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from html import escape
from typing import Any

import matplotlib
from matplotlib.figure import Figure

from ftac_gym.plots.style import COLORS, FAINT, GRID, INK, MUTED

# Like the colours of the text and the lines, one that the page replaces by its own. No other thing in a figure may have
# exactly these.
PAPER = "#fffffe"

_SERIES = {color.lower(): f"series-{number}" for number, color in enumerate(COLORS[:-1])}
_VARIABLES = {PAPER: "paper", INK: "ink", MUTED: "muted", FAINT: "faint", GRID: "grid", **_SERIES}

_STYLE: dict[Any, Any] = {
    "figure.facecolor": PAPER,
    "axes.facecolor": "none",
    "axes.edgecolor": FAINT,
    "axes.labelcolor": MUTED,
    "axes.titlecolor": INK,
    "axes.titlesize": 10.0,
    "axes.titlelocation": "left",
    "axes.labelsize": 9.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "font.size": 9.0,
    "grid.color": GRID,
    "grid.linewidth": 0.8,
    "text.color": INK,
    "xtick.color": MUTED,
    "ytick.color": MUTED,
    "xtick.labelsize": 8.5,
    "ytick.labelsize": 8.5,
    "xtick.major.size": 0.0,
    "ytick.major.size": 0.0,
    # Names of policies are text, whatever characters they have.
    "text.parse_math": False,
    "svg.fonttype": "none",
    # The same figure gives the same file.
    "svg.hashsalt": "ftac_gym",
}


@contextmanager
def drawing() -> Iterator[None]:
    """Draw and save figures inside this: it sets the style, for the time being."""
    with matplotlib.rc_context(_STYLE), warnings.catch_warnings():
        # The reader's fonts show the text, not those that are here to measure it.
        warnings.filterwarnings("ignore", message="Glyph .* missing from font")
        yield


def svg(figure: Figure) -> str:
    """Return a figure as an SVG document."""
    buffer = io.StringIO()
    figure.savefig(buffer, format="svg", metadata=dict.fromkeys(("Creator", "Date", "Format", "Type")))
    return re.sub(r" ?\n(?=[LMCQz\"])", " ", buffer.getvalue())


def inline(document: str, name: str, description: str) -> str:
    """Turn an SVG document into an element of a page.

    Parameters
    ----------
    document
        What :func:`svg` returned.
    name
        Prefix of its identifiers, which must differ from those of the page's other figures.
    description
        What there is to see, for those who cannot.
    """
    opening = re.search(r'<svg[^>]* viewBox="0 0 ([\d.]+) ([\d.]+)"[^>]*>', document)
    assert opening is not None
    width, height = (float(size) for size in opening.groups())
    body = document[opening.end() :]
    body = re.sub(r"<metadata>.*?</metadata>|<style.*?</style>", "", body, flags=re.DOTALL)
    body = re.sub(r' id="', f' id="{name}-', body)
    body = re.sub(r"(url\(#|xlink:href=\"#)", rf"\g<1>{name}-", body)
    for color, variable in _VARIABLES.items():
        body = body.replace(color, f"var(--{variable})")
    # Points are three quarters of a pixel.
    size = f"width:{width / 0.75:.0f}px;min-width:{min(width / 0.75, 680.0):.0f}px"
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" role="img" '
        f'aria-label="{escape(description)}" viewBox="0 0 {width:g} {height:g}" style="{size}">{body}'
    )
