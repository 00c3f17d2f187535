"""Compare policies on identical episodes: tables by fault kind and by split, CSV files, plots and a report.

The flagship and its splits are flown on their frozen test episodes, another scenario on episodes of a seed. Choose by
--episodes-of validation. With --benchmark, all baselines that fit and all shipped agents fly all splits in parallel.
Baselines have default and tuned gains, agents all their training seeds. The result is an HTML report with ranks and
paired differences.

Finished batches are stored in the output folder, and a killed evaluation continues after them. A policy that fails in
flight is named with its episode and left out of the tables; the others go on, and the exit status says that one failed.

For example:

    ftac-evaluate
    ftac-evaluate --policies agent pd_dob --episodes 200
    ftac-evaluate --policies agent pd_dob "nftsm tuned" "nftsm_observer tuned"
    ftac-evaluate --benchmark
    ftac-evaluate --benchmark --policies agent pd_dob runs/five --episodes 100 --backend ray
    ftac-evaluate --policies runs/my_run/agent agent pd_dob --reference agent
    ftac-evaluate --policies my_module:my_policy "sb3:model.zip hold=5" pd_dob
    ftac-evaluate --policies runs/one/agent runs/two/agent pd_dob --episodes-of validation
    ftac-evaluate --policies "nftsm_observer tuned" nftsm_telemetry pd_dob --diagnosis
    ftac-evaluate --seed 3 --episodes 100
    ftac-evaluate --scenario my_satellite.json --policies pd_dob "pd_dob runs/tuning/my_satellite/pd_dob/gains.json"
"""

from concurrent.futures import BrokenExecutor
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Literal

import numpy as np
from rich.console import Console

from ftac_gym import baselines
from ftac_gym.agents.shipped import designs
from ftac_gym.baselines import tuned
from ftac_gym.cli.diagnosis import diagnosed, estimating
from ftac_gym.cli.tasks import is_own, scenario_of, short_name
from ftac_gym.evaluation import Evaluation, evaluate, tabulate
from ftac_gym.evaluation.batches import FlightError
from ftac_gym.evaluation.benchmark import fly
from ftac_gym.evaluation.entries import ALL, check_fit, entries_of
from ftac_gym.policies import Policy, resolve
from ftac_gym.policies.policy import named_gains
from ftac_gym.report import write_report
from ftac_gym.report.comparison import drawings, tables, write_comparison
from ftac_gym.scenarios import SPLITS, frozen
from ftac_gym.task.episodes import Episodes
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.console import exit_on, one_line_warnings, print_line, progress_bar, show_table

CLOSE = (
    "agent", "pd_dob tuned", "pd_dob_robust", "lqr", "indi", "nftsm tuned", "predefined_time tuned",
    "predefined_time_observer tuned",
)  # fmt: skip
"""The shipped residual of the flagship and its rivals; the last one is on the corrected learning observer."""

REFUSED = {
    True: {
        "gains": 'write "NAME tuned" among the policies for tuned gains',
        "count_infeasible": "its episodes are labelled, and infeasible ones are counted apart",
        "seed": "its episodes are the frozen ones",
        "detail": "its report has commands that draw single episodes",
        "diagnosis": "its report has none: a comparison without it has",
    },
    False: {"backend": "one process flies a comparison", "workers": "one process flies a comparison"},
}
"""Options without an effect, with --benchmark and without, and the reason."""


@dataclass(frozen=True)
class Config:
    """A comparison."""

    policies: tuple[str, ...] = ()
    """Policies to compare. Shipped agents and baselines have names, an agent has a path.
    "NAME tuned" has tuned gains, "NAME FILE.json" those of ftac-tune.
    "agent" is the shipped residual of the scenario or of the flagship. A custom baseline or any other policy is
    "module:name", or "module:name()" for what it returns. Models of other libraries are "sb3:PATH", "zoo:FOLDER" and
    "onnx:PATH"; the first two run code of the file. Arguments may follow: "sb3:PATH hold=5 observation=telemetry". By
    default the shipped agents and the baselines that come closest."""
    benchmark: bool = False
    """Fly all baselines and agents through the scenario and the splits, and write an HTML report."""
    backend: Literal["local", "ray"] = "local"
    """Backend of the benchmark: processes of this machine, or a Ray cluster (extra "cluster")."""
    workers: int = -1
    """Parallel processes of the benchmark; -1 for all cores."""
    gains: Literal["default", "tuned"] = "default"
    """Gains of the baselines among the policies; agents have the base that they were trained with."""
    reference: str = "pd_dob"
    """The policy that the others are compared with, episode by episode. The default stands for "pd_dob tuned" where
    that flies and "pd_dob" does not."""
    scenario: str = "flagship"
    """Scenario of the tables of metrics and of the figures: NAME, FILE.json or module:function."""
    splits: tuple[str, ...] | None = None
    """Further scenarios for the tables by split and by fault kind; none if given without names. By default the splits
    of the flagship, and none of another scenario."""
    episodes: int = 500
    """Feasible episodes of each scenario; infeasible ones between them are flown too and counted apart."""
    count_infeasible: bool = False
    """Count every episode as feasible: the label is not exact, and some papers' examples do not have it."""
    episodes_of: Literal["validation", "test"] = "test"
    """Frozen lists of the flagship's splits: those of the validation are for every choice, those of the test for the
    last table alone. For other scenarios the same with drawn episodes, of seed 20000 and 10000."""
    seed: int | None = None
    """Seed of the episodes, instead of those of --episodes-of."""
    detail: int | None = None
    """Episode to draw in detail; by default the first feasible one with the onset of a bias on target."""
    diagnosis: bool = False
    """Judge the estimates of the faults too: detection delay, isolation, false alarms and errors. Policies that have
    estimates fly the episodes of the scenario once more for it."""
    output: Path = Path("results")
    """Folder for the results; each scenario has a folder in it, or in the folder "tuned" in it with tuned gains."""

    @property
    def reports(self) -> Path:
        """Folder of tables and figures: those of tuned gains do not replace those of default ones."""
        return self.output if self.gains == "default" else self.output / self.gains

    @property
    def scenarios(self) -> tuple[str, ...]:
        """All scenarios as they are named, that of the figures first."""
        usual = SPLITS[1:] if self.scenario == SPLITS[0] else ()
        return tuple(dict.fromkeys((self.scenario, *(usual if self.splits is None else self.splits))))

    @property
    def first_seed(self) -> int:
        """Seed of drawn episodes."""
        return frozen.FIRST_SEED[self.episodes_of] if self.seed is None else self.seed

    @property
    def contenders(self) -> tuple[str, ...]:
        """The policies, or those of the default."""
        if self.policies:
            return self.policies
        if self.benchmark:
            return (ALL, *(name for name in designs() if name.startswith("flagship") and self.scenario in SPLITS))
        if self.scenario in SPLITS:
            return CLOSE
        return ("pd_dob", "pd") if is_own(self.scenario) else ("agent", "pd_dob", "pd")

    @property
    def compared_with(self) -> str:
        """The reference among the policies."""
        tuned_one = f"{self.reference} tuned"
        swapped = self.reference == "pd_dob" and "pd_dob" not in self.contenders and tuned_one in self.contenders
        return tuned_one if swapped else self.reference


def check_options(config: Config) -> None:
    """Refuse options that would have no effect, unknown scenarios, and two of one name."""
    for name, reason in REFUSED[config.benchmark].items():
        if getattr(config, name) != getattr(Config, name):
            option, mode = name.replace("_", "-"), "with" if config.benchmark else "without"
            raise SystemExit(f"--{option} has no effect {mode} --benchmark: {reason}")
    if config.seed is not None and config.episodes_of != Config.episodes_of:
        raise SystemExit(f"--episodes-of has no effect with --seed: the episodes are those of seed {config.seed}")
    names: dict[str, str] = {}
    for text in config.scenarios:
        scenario_of(text, "scenario" if text == config.scenario else "splits")
        with exit_on(ValueError):
            other = names.setdefault(short_name(text), text)
        if other != text:
            raise SystemExit(f"--splits: {text!r} would have the same folder as {other!r}; rename one")


def resolved(config: Config) -> dict[str, Policy]:
    """Return the policies by their names in the tables; refuse those that do not fit before any flight."""
    tasks = [scenario_of(text) for text in config.scenarios]
    found = {}
    try:
        for name in config.contenders:
            found[name] = resolve(name, short_name(config.scenario), config.gains)
    except ValueError as error:
        raise SystemExit(f"--{'gains' if str(error).startswith('gains') else 'policies'}: {error}") from None
    for name, policy in found.items():
        with exit_on(ValueError, prefix=f"--policies: {name}: "):
            check_fit(policy, tasks)
    return found


def gains_used(config: Config) -> str:
    """Return a line with the gains of the baselines, and the origin of tuned ones."""
    found = []
    for policy in sorted(set(config.contenders)):
        name, named = named_gains(policy)
        gains = config.gains if named is None else named
        if name not in baselines.names():
            continue
        if gains == "default":
            found.append(f"{name} default")
        else:
            source = tuned.record(name, gains)["provenance"]
            found.append(f"{name} tuned by {source['trials']} trials on {source['scenario']}")
    return f"gains of the baselines: {', '.join(found) or 'none among the policies'}"


def draw(config: Config, name: str) -> Episodes:
    """Return the episodes of a scenario, as the command line names it."""
    scenario = scenario_of(name)
    try:
        if config.count_infeasible:
            return scenario.draw(config.first_seed, config.episodes)
        if config.seed is None and name in SPLITS:
            return frozen.load(name, config.episodes, config.episodes_of)
        return frozen.draw_feasible(scenario, config.first_seed, config.episodes)
    except ValueError as error:
        hint = " (--count-infeasible counts them all)" if "feasible episodes" in str(error) else ""
        raise SystemExit(f"--episodes: {error}{hint}") from None


def counted(config: Config, episodes: Episodes) -> Episodes:
    """Return the episodes as the tables count them."""
    return replace(episodes, feasible=np.ones_like(episodes.feasible)) if config.count_infeasible else episodes


def all_drawn(config: Config) -> dict[str, Episodes]:
    """Return the episodes of all scenarios by their short names, that of the figures first."""
    return {short_name(text): draw(config, text) for text in config.scenarios}


def run(
    config: Config, flown: dict[str, Policy], drawn: dict[str, Episodes], console: Console
) -> tuple[dict[str, list[Evaluation]], list[str]]:
    """Fly all policies through all scenarios, with progress.

    Returns
    -------
    Evaluations by scenario of the policies that did not fail, and a line about each other one.
    """
    found: dict[str, dict[str, Evaluation]] = {}
    failures: dict[str, str] = {}
    with progress_bar(console) as progress, one_line_warnings(partial(print_line, progress.console)):
        for scenario, episodes in drawn.items():
            bar = progress.add_task(scenario, total=len(episodes) * len(flown))
            task, folder = Scenario.from_json(episodes.scenario_json), config.output / scenario / "batches"
            found[scenario] = {}
            for name, policy in flown.items():
                if name in failures:
                    continue
                try:
                    found[scenario][name] = evaluate(
                        task, policy, episodes, name, folder, partial(progress.advance, bar)
                    )
                except FlightError as error:
                    failures[name] = str(error)
                    print_line(progress.console, failures[name])
    remaining = {name: [item for key, item in items.items() if key not in failures] for name, items in found.items()}
    return remaining, list(failures.values())


def run_benchmark(config: Config, console: Console) -> None:
    """Fly the policies through the scenario and the splits, and write the report."""
    folder, episodes = config.output / "benchmark", all_drawn(config)
    written = one_line_warnings(partial(print_line, console))
    with exit_on(ValueError, prefix="--benchmark: "), exit_on(BrokenExecutor, prefix="not finished: "), written:
        entries = entries_of(config.contenders, scenario_of(config.scenario))
        flights = sum(len(entry.policies) for entry in entries) * sum(map(len, episodes.values()))
        console.print(f"{len(entries)} entries, {len(episodes)} splits, {flights} episodes")
        with progress_bar(console) as progress:
            task = progress.add_task("flying", total=flights)
            result = fly(
                entries, episodes, config.reference, folder, config.backend, config.workers,
                lambda _split, _entry, count: progress.advance(task, count),
            )  # fmt: skip
    if result.episodes_flown:
        rate = result.episodes_flown / result.seconds
        console.print(f"flew {result.episodes_flown} episodes in {result.seconds:.0f} s: {rate:.0f} episodes/s")
    console.print("bootstrap intervals, figures and report ...")
    with exit_on(ValueError, prefix="--output: "):
        console.print(f"wrote {write_report(result, folder)}, CSV files and figures beside it")
    end(list(result.failures.values()))


def end(failures: list[str]) -> None:
    """End with a line about each failure, if there is one."""
    if failures:
        raise SystemExit("\n".join(left_out(failures)))


def left_out(failures: list[str]) -> list[str]:
    """Return lines about policies that are not in the tables."""
    return [f"left out of the tables: {line}" for line in failures]


def origin(config: Config, drawn: dict[str, Episodes]) -> list[str]:
    """Return lines with the origin of the episodes and of the gains."""
    frozen_lists, usual = SPLITS if config.seed is None and not config.count_infeasible else (), config.episodes_of
    lines = [
        f"{name}: {len(item)} episodes ({f'frozen {usual}' if name in frozen_lists else f'seed {config.first_seed}'}), "
        f"{int(item.feasible.sum())} of them feasible, digest {item.digest()[:12]}"
        for name, item in drawn.items()
    ]
    return [*lines, gains_used(config)]


def main(config: Config) -> None:
    """Compare the policies."""
    console = Console()
    check_options(config)
    if config.benchmark:
        run_benchmark(config, console)
        return
    reference = config.compared_with
    flown = resolved(config)
    if reference not in flown:
        raise SystemExit(f"--reference: {reference!r} is not among the policies {list(flown)}")
    judged, without = estimating(flown, scenario_of(config.scenario)) if config.diagnosis else ({}, [])
    drawn, scenario = all_drawn(config), short_name(config.scenario)
    episodes = drawn[scenario]
    if config.detail is not None and not 0 <= config.detail < len(episodes):
        raise SystemExit(f"--detail: {config.detail} is none of the {len(episodes)} episodes")
    lines = [*origin(config, drawn), *without]
    console.print("\n".join(lines))
    evaluations, failures = run(config, flown, drawn, console)
    flown = {item.policy: flown[item.policy] for item in evaluations[scenario]}
    if reference not in flown:
        raise SystemExit("\n".join([*failures, f"--reference: {reference} failed: there is nothing to compare with"]))
    shown = {name: counted(config, item) for name, item in drawn.items()}
    console.print("bootstrap intervals ...")
    rows = {name: tabulate(items, reference, shown[name].feasible) for name, items in evaluations.items()}
    found = tables(evaluations, rows, shown, reference, "all" if config.count_infeasible else "feasible")
    # A narrower table of many policies would cut off the kinds of faults.
    wide = Console(width=max(console.width, 130, 60 + 18 * len(flown)))
    for title, table in found.items():
        show_table(wide, table, title)
    judged = {name: policy for name, policy in judged.items() if name in flown}
    cells, files = diagnosed(judged, scenario_of(config.scenario), episodes, console)
    for title, table in cells.items():
        show_table(wide, table, title)
    console.print("figures ...")
    with one_line_warnings(partial(print_line, console)):
        figures = drawings(
            scenario_of(config.scenario), flown, reference, evaluations[scenario], episodes,
            shown[scenario].feasible, config.detail,
        )  # fmt: skip
    with exit_on(ValueError, prefix="--output: "):
        report = write_comparison(
            config.reports, evaluations, rows, drawn, [*lines, *left_out(failures)], {**found, **cells}, figures, files
        )
    pictures = ", ".join(f"{name}.png" for name in figures)
    tables_of_faults = "".join(f", {name}.csv" for name in files)
    console.print(f"wrote {report}, {pictures}{tables_of_faults}, and episodes.csv and summary.csv for each scenario")
    end(failures)
