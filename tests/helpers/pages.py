"""A parser of report pages."""

from html.parser import HTMLParser

from ftac_gym.report import write_report


class Page(HTMLParser):
    """A page as elements with attributes, texts, and tables as rows of cells."""

    def __init__(self, text):
        super().__init__()
        self.elements, self.tables, self.heading, self._open = [], {}, "", []
        self.rows, self.cell, self.texts = None, None, []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        self.elements.append((tag, attributes))
        if tag in ("h2", "h3", "summary"):
            self.heading = ""
            self._open.append(tag)
        elif tag == "table":
            self.rows = self.tables.setdefault(self.heading, [])
        elif tag == "tr":
            self.rows.append([])
        elif tag in ("th", "td"):
            self.cell = {
                "text": "",
                "note": "",
                "class": attributes.get("class", ""),
                "key": attributes.get("data-key"),
            }
            self.rows[-1].append(self.cell)
        elif tag == "small" and self.cell is not None:
            self._open.append(tag)

    def handle_startendtag(self, tag, attributes):
        self.elements.append((tag, dict(attributes)))

    def handle_endtag(self, tag):
        if self._open and self._open[-1] == tag:
            self._open.pop()
        if tag in ("th", "td"):
            self.cell = None

    def handle_data(self, data):
        self.texts.append(data)
        if self.cell is not None:
            self.cell["note" if self._open and self._open[-1] == "small" else "text"] += data
        elif self._open:
            self.heading += data

    def table(self, heading):
        """Return a table as cells by row heading and column heading."""
        columns, *rows = self.tables[heading]
        names = [cell["text"].strip() for cell in columns]
        return {
            row[0]["text"].strip(): dict(zip(names[1:], row[1:], strict=True)) for row in rows
        }  # fmt: skip


def page_of(benchmark, folder):
    return Page(write_report(benchmark, folder).read_text())


def shown(cell):
    """Return the number in a cell."""
    return float(cell["text"].split()[0].replace("\N{MINUS SIGN}", "-"))
