"""Compare policies on identical episodes: tables by fault kind and by split, CSV files, plots and a report.

The flagship and its splits are flown on their frozen test episodes. With --benchmark, all baselines that fit and all
shipped agents fly all splits in parallel. Baselines have default and tuned gains, agents all their training seeds. The
result is an HTML report with ranks and paired differences.

Finished batches are stored in the output folder, and a killed evaluation continues after them.

For example:

    python train/evaluate.py
    python train/evaluate.py --policies agent pd_dob --episodes 200
    python train/evaluate.py --policies agent pd_dob "nftsm tuned" "nftsm_observer tuned"
    python train/evaluate.py --benchmark
    python train/evaluate.py --benchmark --policies agent pd_dob runs/five --episodes 100 --backend ray
    python train/evaluate.py --policies runs/my_run/agent agent pd_dob --reference agent
    python train/evaluate.py --seed 3 --episodes 100
"""

from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Literal

import numpy as np
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from ftac_gym import baselines, scenarios
from ftac_gym.agents.shipped import designs
from ftac_gym.baselines import tuned
from ftac_gym.evaluation import Evaluation, compare, evaluate, fault_classes, rollout
from ftac_gym.evaluation.benchmark import fly, frozen_episodes
from ftac_gym.evaluation.entries import ALL, check_fit, entries_of
from ftac_gym.evaluation.files import write_episodes, write_summary
from ftac_gym.evaluation.tables import Cells, kind_table, markdown, metric_tables, split_table
from ftac_gym.plots import episode as draw_episode
from ftac_gym.plots import error_bands, prescribed_bound
from ftac_gym.plots.fault_gallery import fault_gallery
from ftac_gym.policies import Policy, resolve
from ftac_gym.policies.resolve import TUNED
from ftac_gym.report import write_report
from ftac_gym.scenarios import SPLITS, frozen
from ftac_gym.task.episodes import Episodes
from ftac_gym.utils.console import exit_on, run_program, show_table

CLOSE = ("agent", "flagship_telemetry", "flagship_direct", "pd_dob", "pd", "nftsm_observer tuned", "nftsm tuned")
"""The shipped agents of the flagship, and the baselines that come closest to them."""


@dataclass(frozen=True)
class Config:
    """A comparison."""

    policies: tuple[str, ...] = ()
    """Policies to compare: a shipped agent or a baseline by name, "NAME tuned" for its tuned gains, "module:Class" for
    a custom baseline, the path of an agent. "agent" is the shipped residual of the scenario
    or of the flagship. By default the shipped agents and the baselines that come closest."""
    benchmark: bool = False
    """Fly all baselines and agents through the flagship and its splits, and write an HTML report."""
    backend: Literal["local", "ray"] = "local"
    """Backend of the benchmark: processes of this machine, or a Ray cluster (extra "cluster")."""
    workers: int = -1
    """Parallel processes of the benchmark; -1 for all cores."""
    gains: Literal["default", "tuned"] = "default"
    """Gains of the baselines among the policies; agents have the base that they were trained with."""
    reference: str = "pd_dob"
    """The policy that the others are compared with, episode by episode."""
    scenario: str = "flagship"
    """Scenario of the tables of metrics and of the figures."""
    splits: tuple[str, ...] = SPLITS[1:]
    """Further scenarios for the tables by split and by fault kind; none if given without names."""
    episodes: int = 500
    """Feasible episodes of each scenario; infeasible ones between them are flown too and counted apart."""
    count_infeasible: bool = False
    """Count every episode as feasible: the label is conservative, and some papers' examples do not have it."""
    seed: int | None = None
    """Seed of the episodes; by default the frozen lists of the flagship's splits, and 10000 for other scenarios."""
    detail: int | None = None
    """Episode to draw in detail; by default the first feasible one with the onset of a bias on target."""
    output: Path = Path("results")
    """Folder for the results; each scenario has a folder in it, or in the folder "tuned" in it with tuned gains."""

    @property
    def reports(self) -> Path:
        """Folder of tables and figures: those of tuned gains do not replace those of default ones."""
        return self.output if self.gains == "default" else self.output / self.gains

    @property
    def first_seed(self) -> int:
        """Seed of drawn episodes."""
        return frozen.FIRST_SEED if self.seed is None else self.seed

    @property
    def contenders(self) -> tuple[str, ...]:
        """The policies, or those of the default."""
        if self.policies:
            return self.policies
        if self.benchmark:
            return (ALL, *(name for name in designs() if name.startswith("flagship")))
        return CLOSE if self.scenario in SPLITS else ("agent", "pd_dob", "pd")


def resolved(config: Config) -> dict[str, Policy]:
    """Return the policies by their names in the tables; refuse those that do not fit before any flight."""
    tasks = [scenarios.get(name) for name in (config.scenario, *config.splits) if name in scenarios.names()]
    found = {}
    try:
        for name in config.contenders:
            found[name] = resolve(name, config.scenario, config.gains)
    except ValueError as error:
        raise SystemExit(f"--{'gains' if str(error).startswith('gains') else 'policies'}: {error}") from None
    for name, policy in found.items():
        try:
            check_fit(policy, tasks)
        except ValueError as error:
            raise SystemExit(f"--policies: {name}: {error}") from None
    return found


def gains_used(config: Config) -> str:
    """Return a line with the gains of the baselines, and the origin of tuned ones."""
    found = []
    for policy in sorted(set(config.contenders)):
        name = policy.removesuffix(TUNED)
        if name not in baselines.names():
            continue
        if policy == name and config.gains == "default":
            found.append(f"{name} default")
        else:
            source = tuned.record(name)["provenance"]
            found.append(f"{name} tuned by {source['trials']} trials on {source['scenario']}")
    return f"gains of the baselines: {', '.join(found) or 'none among the policies'}"


def draw(config: Config, name: str) -> Episodes:
    """Return the episodes of a scenario."""
    try:
        if config.count_infeasible:
            return scenarios.get(name).draw(config.first_seed, config.episodes)
        if config.seed is None and name in SPLITS:
            return frozen.load(name, config.episodes)
        return frozen.draw_feasible(scenarios.get(name), config.first_seed, config.episodes)
    except ValueError as error:
        hint = " (--count-infeasible counts them all)" if "feasible episodes" in str(error) else ""
        raise SystemExit(f"--episodes: {error}{hint}") from None


def counted(config: Config, episodes: Episodes) -> Episodes:
    """Return the episodes as the tables count them."""
    return replace(episodes, feasible=np.ones_like(episodes.feasible)) if config.count_infeasible else episodes


def run(
    config: Config, flown: dict[str, Policy], drawn: dict[str, Episodes], console: Console
) -> dict[str, list[Evaluation]]:
    """Fly all policies through all scenarios, with progress."""
    columns = (TextColumn("{task.description:>18}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    evaluations: dict[str, list[Evaluation]] = {}
    with Progress(*columns, console=console) as progress:
        for scenario, episodes in drawn.items():
            bar = progress.add_task(scenario, total=len(episodes) * len(flown))
            task, folder = scenarios.get(scenario), config.output / scenario / "batches"
            evaluations[scenario] = [
                evaluate(task, policy, episodes, name, folder, partial(progress.advance, bar))
                for name, policy in flown.items()
            ]
    return evaluations


def onset_on_target(evaluations: list[Evaluation], episodes: Episodes) -> int:
    """Return the first feasible episode with the onset of a bias while the spacecraft is on target."""
    on_target = ~np.isnan(evaluations[0].metrics["peak_after_fault"])
    candidates = np.flatnonzero(on_target & episodes.feasible & (fault_classes(episodes) == "bias"))
    return int(candidates[0]) if candidates.size else 0


def run_benchmark(config: Config, console: Console) -> None:
    """Fly the policies through the flagship and its splits."""
    scenario, folder = scenarios.get("flagship"), config.output / "benchmark"
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with exit_on(ValueError, ImportError, prefix="--benchmark: "):
        episodes = frozen_episodes(dict.fromkeys((config.scenario, *config.splits)), config.episodes)
        entries = entries_of(config.contenders, scenario)
        flights = sum(len(entry.policies) for entry in entries) * sum(map(len, episodes.values()))
        console.print(f"{len(entries)} entries, {len(episodes)} splits, {flights} episodes")
        with Progress(*columns, console=console) as progress:
            task = progress.add_task("flying", total=flights)
            result = fly(
                entries, episodes, config.reference, folder, config.backend, config.workers,
                lambda _split, _entry, count: progress.advance(task, count),
            )  # fmt: skip
    if result.episodes_flown:
        rate = result.episodes_flown / result.seconds
        console.print(f"flew {result.episodes_flown} episodes in {result.seconds:.0f} s: {rate:.0f} episodes/s")
    console.print("bootstrap intervals, figures and report ...")
    console.print(f"wrote {write_report(result, folder)}, CSV files and figures beside it")


def origin(config: Config, drawn: dict[str, Episodes]) -> list[str]:
    """Return lines with the origin of the episodes and of the gains."""
    source = "frozen" if config.seed is None and not config.count_infeasible else f"seed {config.first_seed}"
    lines = [
        f"{name}: {len(item)} episodes ({source}), {int(item.feasible.sum())} of them feasible, "
        f"digest {item.digest()[:12]}"
        for name, item in drawn.items()
    ]
    return [*lines, gains_used(config)]


def tabulated(config: Config, evaluations: dict[str, list[Evaluation]], drawn: dict[str, Episodes]) -> dict[str, Cells]:
    """Return the tables by title, and write the CSV files."""
    shown = {name: counted(config, item) for name, item in drawn.items()}
    rows = {name: compare(items, config.reference, shown[name].feasible) for name, items in evaluations.items()}
    for name, items in evaluations.items():
        (config.reports / name).mkdir(parents=True, exist_ok=True)
        write_episodes(config.reports / name / "episodes.csv", items, drawn[name])
        write_summary(config.reports / name / "summary.csv", rows[name])
    which = "all" if config.count_infeasible else "feasible"
    estimates, differences = metric_tables(rows[config.scenario], config.reference)
    first = f"{config.scenario}, {which} episodes: mean of success, interquartile mean of the rest, 95 % intervals"
    return {
        first: estimates,
        f"mean paired difference to {config.reference}, 95 % intervals": differences,
        f"by split, {which} episodes: success, settling time, integrated error": split_table(rows, shown),
        "by what is wrong: mean success, median settling time": kind_table(evaluations, shown),
    }


def draw_figures(
    config: Config, flown: dict[str, Policy], evaluations: list[Evaluation], episodes: Episodes
) -> dict[str, str]:
    """Write the figures of the scenario; return their headings in the report, by name."""
    scenario, folder = scenarios.get(config.scenario), config.reports / config.scenario
    cone = float(np.degrees(scenario.success.angle))
    figure = error_bands(evaluations, scenario.control_period, cone, counted(config, episodes).feasible)
    figure.savefig(folder / "error_bands.png", dpi=120)
    detail = config.detail if config.detail is not None else onset_on_target(evaluations, episodes)
    histories = {name: rollout(scenario, policy, episodes[detail]) for name, policy in flown.items()}
    draw_episode(histories).savefig(folder / "episode.png", dpi=110)
    headings = {"error_bands": "## Pointing error", "episode": f"## Episode {detail}"}
    if scenario.prescribed_bound is not None:
        prescribed_bound(histories).savefig(folder / "prescribed_bound.png", dpi=110)
        headings["prescribed_bound"] = ""
    fault_gallery(scenario, flown[config.reference]).savefig(folder / "fault_kinds.png", dpi=80)
    return {**headings, "fault_kinds": f"## Every fault kind under {config.reference}"}


def main(config: Config) -> None:
    """Compare the policies."""
    console = Console()
    if config.benchmark:
        run_benchmark(config, console)
        return
    flown = resolved(config)
    if config.reference not in flown:
        raise SystemExit(f"--reference: {config.reference!r} is not among the policies {list(flown)}")
    names = (config.scenario, *(name for name in config.splits if name != config.scenario))
    for name in names:
        if name not in scenarios.names():
            raise SystemExit(f"--scenario: {name!r} is none of {scenarios.names()}")
    drawn = {name: draw(config, name) for name in names}
    episodes = drawn[config.scenario]
    if config.detail is not None and not 0 <= config.detail < len(episodes):
        raise SystemExit(f"--detail: {config.detail} is none of the {len(episodes)} episodes")
    lines = origin(config, drawn)
    console.print("\n".join(lines))
    evaluations = run(config, flown, drawn, console)
    console.print("bootstrap intervals ...")
    tables = tabulated(config, evaluations, drawn)
    # A narrower table of many policies would cut off the kinds of faults.
    wide = Console(width=max(console.width, 130, 60 + 18 * len(flown)))
    for title, cells in tables.items():
        show_table(wide, cells, title)
    console.print("figures ...")
    figures = draw_figures(config, flown, evaluations[config.scenario], episodes)
    report = [
        f"# {config.scenario}: {', '.join(flown)}",
        "Same episodes for every policy; 95 % bootstrap intervals.",
        "\n".join(f"- {line}" for line in lines),
        *(part for title, cells in tables.items() for part in (f"## {title}", markdown(cells))),
        *(
            part
            for name, heading in figures.items()
            for part in (heading, f"![{name.replace('_', ' ')}]({name}.png)")
            if part
        ),
    ]
    folder = config.reports / config.scenario
    (folder / "report.md").write_text("\n\n".join(report) + "\n")
    pictures = ", ".join(f"{name}.png" for name in figures)
    console.print(f"wrote {folder}/report.md, {pictures}, and episodes.csv and summary.csv for each scenario")


if __name__ == "__main__":
    run_program(main, Config, __doc__)
