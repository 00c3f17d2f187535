"""Check that every link of the built site that stays within the site leads somewhere, anchors included.

Example
-------
    python docs/scripts/check_links.py docs/_build/html
"""

from __future__ import annotations

import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

LINKING = {"href", "src", "data", "poster", "action"}
"""Attributes that hold a link."""


class Page(HTMLParser):
    """What a page links to, and what in it can be linked to.

    Parameters
    ----------
    text
        The HTML.
    """

    def __init__(self, text: str) -> None:
        super().__init__()
        self.links: list[str] = []
        self.anchors: set[str] = set()
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Take note of links and anchors."""
        for name, value in attrs:
            if name == "id" or (tag == "a" and name == "name"):
                self.anchors.add(value or "")
            elif name in LINKING and value:
                self.links.append(value)
            elif name == "srcset" and value:
                self.links += [entry.split()[0] for entry in value.split(",") if entry.strip()]


def broken_links(site: Path) -> list[str]:
    """Return what is wrong with the links within a site, one line each.

    Parameters
    ----------
    site
        Folder of the built HTML.

    Raises
    ------
    ValueError
        If there is no page in it.
    """
    site = site.resolve()
    pages = {path: Page(path.read_text(encoding="utf-8")) for path in sorted(site.rglob("*.html"))}
    if not pages:
        raise ValueError(f"site must hold HTML files, got {str(site)!r}")
    wrong = []
    for path, page in pages.items():
        for link in dict.fromkeys(page.links):
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = path if not parts.path else (path.parent / unquote(parts.path)).resolve()
            if target.is_dir():
                target /= "index.html"
            where = path.relative_to(site)
            if not target.is_relative_to(site):
                wrong.append(f"{where}: {link} leads out of the site")
            elif not target.exists():
                wrong.append(f"{where}: {link} leads to no file")
            elif parts.fragment and target in pages and unquote(parts.fragment) not in pages[target].anchors:
                wrong.append(f"{where}: {link} leads to no anchor")
    return wrong


def main(site: Path) -> None:
    """Print what is wrong and fail, or say where the site lies."""
    wrong = broken_links(site)
    if wrong:
        raise SystemExit("\n".join([*wrong, f"{len(wrong)} broken links"]))
    print(f"The site is whole: {site / 'index.html'}")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
