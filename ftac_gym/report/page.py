"""The page, rendered from the template."""

from __future__ import annotations

from collections.abc import Mapping

from jinja2 import Environment, PackageLoader, StrictUndefined

from ftac_gym import __version__
from ftac_gym.evaluation.rows import COLUMN_UNITS, HEADLINES
from ftac_gym.report import cells, provenance, results, worst
from ftac_gym.report.results import Results
from ftac_gym.report.svg import data_uri


def render(found: Results, pictures: Mapping[str, str]) -> str:
    """Return the page.

    Parameters
    ----------
    found
        The numbers.
    pictures
        The figures as SVG documents, by name.
    """
    environment = Environment(
        loader=PackageLoader("ftac_gym.report", ""),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["words"] = lambda name: name.replace("_", " ")
    return environment.get_template("page.html.jinja").render(
        found=found,
        benchmark=found.benchmark,
        reference=found.benchmark.reference,
        images={name: data_uri(document) for name, document in pictures.items()},
        worst_episodes=worst.worst_episodes(found),
        version=__version__,
        units=COLUMN_UNITS,
        headlines=HEADLINES,
        cells=cells,
        provenance=provenance,
        results=results,
        worst=worst,
    )
