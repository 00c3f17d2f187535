"""The report of a benchmark: one HTML file that needs nothing else, CSV files, and figures."""

from __future__ import annotations

from pathlib import Path

from ftac_gym.evaluation.benchmark import Benchmark
from ftac_gym.report.csv_files import write_csv
from ftac_gym.report.page import render
from ftac_gym.report.pictures import draw
from ftac_gym.report.results import gather

__all__ = ["write_report"]

PAGE, FIGURES = "report.html", "figures"


def write_report(benchmark: Benchmark, folder: str | Path) -> Path:
    """Write the report of a benchmark.

    Parameters
    ----------
    benchmark
        The benchmark.
    folder
        Target: ``report.html``, ``summary.csv``, ``differences.csv``, ``improvement.csv``, ``by_fault.csv``,
        ``episodes.csv`` and the folder ``figures``. An earlier report there is replaced.

    Returns
    -------
    The path of ``report.html``.

    Raises
    ------
    ValueError
        If the reference is not among the entries, or two entries have one name.
    """
    results = gather(benchmark)
    folder = Path(folder)
    pictures = draw(results)
    (folder / FIGURES).mkdir(parents=True, exist_ok=True)
    for stale in (folder / FIGURES).glob("*.svg"):
        stale.unlink()
    for name, picture in pictures.items():
        (folder / FIGURES / f"{name}.svg").write_text(picture, encoding="utf-8")
    write_csv(results, folder)
    path = folder / PAGE
    path.write_text(render(results, pictures), encoding="utf-8")
    return path
