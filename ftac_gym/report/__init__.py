"""The report of a benchmark: one HTML file that needs nothing else, CSV files, and figures."""

from __future__ import annotations

from pathlib import Path

from ftac_gym.utils.extras import naming_extra

with naming_extra():
    from ftac_gym.evaluation.benchmark import Benchmark
    from ftac_gym.report.comparison import PATIENCE
    from ftac_gym.report.csv_files import write_csv
    from ftac_gym.report.page import render
    from ftac_gym.report.pictures import draw
    from ftac_gym.report.results import gather
    from ftac_gym.utils.files import locked, write_text

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
        ``episodes.csv`` and the folder ``figures``. An earlier report there is replaced; reports of several processes
        are not mixed.

    Returns
    -------
    The path of ``report.html``.

    Raises
    ------
    ValueError
        If the reference is not among the entries, or two entries have one name; or if another process keeps the folder
        for more than :data:`~ftac_gym.report.comparison.PATIENCE`.
    """
    results = gather(benchmark)
    folder = Path(folder)
    pictures = draw(results)
    page = render(results, pictures)
    path = folder / PAGE
    with locked(folder, PATIENCE):
        for name, picture in pictures.items():
            write_text(folder / FIGURES / f"{name}.svg", picture)
        for stale in set((folder / FIGURES).glob("*.svg")) - {folder / FIGURES / f"{name}.svg" for name in pictures}:
            stale.unlink()
        write_csv(results, folder)
        write_text(path, page)
    return path
