"""Fly a paper's scenario with its schemes and comparators, and judge the paper's claims.

The claim table and the studies behind it are printed, and written as a report with figures.

For example:

    ftac-reproduce --paper zhang_zhou_2019
"""

from __future__ import annotations

import time
from concurrent.futures import as_completed
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console
from tqdm import tqdm

from ftac_gym.evaluation.files import write_figure
from ftac_gym.evaluation.tables import markdown
from ftac_gym.reproduction import PAPERS
from ftac_gym.reproduction.recorder import record
from ftac_gym.reproduction.recordings import Plan, Recordings
from ftac_gym.reproduction.verdicts import claim_table
from ftac_gym.utils.console import exit_on, show_table
from ftac_gym.utils.files import write_text
from ftac_gym.utils.parameters import require
from ftac_gym.utils.processes import worker_pool


@dataclass(frozen=True)
class Config:
    """Settings of a reproduction."""

    paper: str
    """The paper: zhang_zhou_2019, cao_2022, ma_2023, chen_2018 or li_2023."""
    output: Path = Path("results")
    """Folder for the report, which is written to a folder of the paper in it."""
    workers: int = 2
    """Processes; they do not change the result."""


def run(plans: dict[str, Plan], workers: int) -> Recordings:
    """Fly all plans, the longest first, with progress."""
    order = sorted(plans, key=lambda name: -plans[name].scenario.horizon)
    flights = Recordings()
    total = sum(plan.scenario.horizon for plan in plans.values())
    with worker_pool(workers) as pool, tqdm(total=total) as bar:
        jobs = {pool.submit(record, plans[name]): name for name in order}
        for job in as_completed(jobs):
            name = jobs[job]
            flights[name] = job.result()
            bar.set_description(f"{name:>40.40}")
            bar.update(plans[name].scenario.horizon)
    return flights.chosen(plans)


def main(config: Config) -> None:
    """Reproduce a paper."""
    if config.paper not in PAPERS:
        raise SystemExit(f"--paper: {config.paper!r} is none of {sorted(PAPERS)}")
    with exit_on(ValueError):
        require(config.workers > 0, "workers", "must be positive", config.workers)
    start = time.perf_counter()
    paper = PAPERS[config.paper]
    result = paper.evaluate(run(paper.plans(), config.workers))
    console = Console()
    wide = Console(width=max(console.width, 150))
    for title, cells in result.studies.items():
        show_table(wide, cells, title)
    show_table(wide, claim_table(result.claims), f"Claims of {config.paper}", lines=True)
    folder = config.output / config.paper
    for name, figure in result.figures.items():
        write_figure(folder / f"{name}.png", figure, 90)
    report = [f"# {config.paper}", "## Claims", markdown(claim_table(result.claims))]
    report += [part for title, cells in result.studies.items() for part in (f"## {title}", markdown(cells))]
    report += [part for name in result.figures for part in (f"## {name.capitalize()}", f"![{name}]({name}.png)")]
    write_text(folder / "report.md", "\n\n".join(report) + "\n")
    console.print(f"wrote {folder}/report.md and {len(result.figures)} figures "
                  f"in {time.perf_counter() - start:.0f} s")  # fmt: skip
