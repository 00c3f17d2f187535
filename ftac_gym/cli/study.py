"""Study of agents: {direct, residual, gain scheduling} x {no memory, history, observer estimate, oracle}.

The script trains every combination with several seeds; finished agents are reused, killed runs resumed. All agents fly
the frozen test episodes of the flagship. The tables have success, settling time and chatter as differences to the base,
with intervals over seeds and episodes.

For example:

    ftac-study --seeds 3 --workers 2
    ftac-study --seeds 3 --workers 2 --actions residual --memories none estimate
"""

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

from rich.console import Console
from tqdm import tqdm

from ftac_gym import scenarios
from ftac_gym.evaluation.benchmark import Benchmark, entries_of, fly, frozen_episodes
from ftac_gym.evaluation.files import write_rows
from ftac_gym.evaluation.rows import statistic_of
from ftac_gym.evaluation.statistics import estimate, paired_difference
from ftac_gym.evaluation.tables import Cells, markdown, number, verdict
from ftac_gym.training.checkpoints import CONTENT_FILE, checkpoints
from ftac_gym.utils.console import alone_in
from ftac_gym.utils.files import write_text
from ftac_gym.utils.parameters import FloatArray
from ftac_gym.utils.processes import run_script

PROGRAMS = Path(__file__).parent / "__main__.py"
BASE = "pd_dob"
METRICS = ("success", "settling_time", "integrated_error", "chatter")

_ALONE = [
    *("--scenario", "flagship", "--hold", "2", "--critic-warmup", "0", "--hyperparameters", "gamma=0.98"),
    *("gae_lambda=0.95", "policy_kwargs.log_std_init=-1.2", "n_steps=32", "batch_size=4096"),
]
"""Options of direct agents, which must learn to slew and to point. Agents on a base train with configs/ppo.yml, on the
response to faults of a spacecraft on target, the only part to gain."""

ACTIONS: dict[str, tuple[str | None, list[str]]] = {
    "direct": (None, _ALONE),
    "residual": (f"ResidualPolicy base={BASE} authority=1.0 authority_angle=100.0 torque_threshold=0.03", []),
    "gains": (f"GainScheduling base={BASE} ranges={{rate_gain: [0.6, 1.9], bandwidth: [0.07, 10.0]}}", []),
}
"""Wrapper and training options for each meaning of the action."""

MEMORIES: dict[str, str | None] = {
    "none": None,
    "history": "ObservationHistory steps=4",
    "estimate": "FaultEstimateObservation source=dob bandwidth=10.0",
    "oracle": "FaultEstimateObservation source=truth",
}
"""Wrapper for each addition to the observation. The oracle is a reference with the truth about the faults."""


@dataclass(frozen=True)
class Config:
    """Agents to train, and the episodes to compare them on."""

    seeds: int = 3
    """Agents of each combination."""
    workers: int = 2
    """Trainings side by side, one thread each."""
    steps: int = 1_000_000
    """Decisions of each agent on a base."""
    direct_steps: int = 6_000_000
    """Decisions of each direct agent."""
    episodes: int = 500
    """Feasible test episodes."""
    actions: tuple[Literal["direct", "residual", "gains"], ...] = ("direct", "residual", "gains")
    """Meanings of the action."""
    memories: tuple[Literal["none", "history", "estimate", "oracle"], ...] = ("none", "history", "estimate", "oracle")
    """Additions to the observation."""
    folder: Path = Path("runs/study")
    """Folder of the runs."""
    output: Path = Path("results/study")
    """Folder of the tables."""

    def steps_of(self, action: str) -> int:
        """Return the number of decisions of an agent with this meaning of the action."""
        return self.direct_steps if action == "direct" else self.steps


def options(config: Config, action: str, memory: str) -> list[str]:
    """Return the arguments of ``ftac-train`` for a combination."""
    acting, training = ACTIONS[action]
    # The estimate is below the wrapper that acts; the history is above it and contains the base's actions.
    order = (acting, MEMORIES[memory]) if memory == "history" else (MEMORIES[memory], acting)
    wrappers = [wrapper for wrapper in order if wrapper is not None]
    steps = config.steps_of(action)
    amounts = ["--total-steps", str(steps), "--evaluate-every", str(steps // 2), "--evaluation-episodes", "300"]
    return ["--wrappers", *wrappers, *amounts, *training]


def train(config: Config, action: str, memory: str, seed: int) -> None:
    """Train one agent, resume it, or do nothing if it is finished."""
    folder = config.folder / f"{action}_{memory}" / f"seed_{seed}"
    # A stray folder with the name of a checkpoint is none.
    steps, done = config.steps_of(action), [path for path in checkpoints(folder) if (path / CONTENT_FILE).is_file()]
    if done and int(done[-1].name) >= steps:
        return
    arguments = [*options(config, action, memory), "--seed", str(seed), "--torch-threads", "1"]
    arguments += ["--run-folder", str(folder), "--checkpoint-every", str(max(steps // 3, 1))]
    folder.mkdir(parents=True, exist_ok=True)
    if run_script(PROGRAMS, ["train", *arguments, *(["--resume"] if done else [])], folder / "log.txt"):
        raise SystemExit(f"training {folder} failed; see {folder / 'log.txt'}")


def flown(config: Config, names: list[str]) -> Benchmark:
    """Fly the base and all agents through the frozen episodes."""
    episodes = frozen_episodes(["flagship"], config.episodes)
    listed = entries_of([BASE, *(str(config.folder / name) for name in names)], scenarios.get("flagship"))
    # There may be more seeds on disk than this study asks for.
    entries = [replace(entry, policies=entry.policies[: config.seeds]) for entry in listed]
    total = sum(len(entry.policies) for entry in entries) * len(episodes["flagship"])
    with tqdm(total=total, desc="flying", unit="episode") as bar:
        return fly(
            entries, episodes, BASE, config.output, workers=config.workers, measure=False,
            progress=lambda _split, _entry, count: bar.update(count),
        )  # fmt: skip


def minutes(cards: Sequence[Mapping[str, Any]]) -> str:
    """Return the mean minutes of training of agents with these cards, each for its whole run."""
    if not cards:
        return "-"
    seconds = [card.get("run_seconds", card["training_seconds"]) for card in cards]
    return f"{sum(seconds) / 60.0 / len(seconds):.1f}"


def main(config: Config) -> None:
    """Train what is missing, fly, and tabulate, alone in the folder of the runs."""
    with alone_in(config.folder, "folder"):
        study(config)


def study(config: Config) -> None:
    """Train what is missing, fly, and tabulate."""
    combinations = [(action, memory) for action in config.actions for memory in config.memories]
    jobs = [(action, memory, seed) for seed in range(config.seeds) for action, memory in combinations]
    with ThreadPoolExecutor(config.workers) as pool:
        futures = [pool.submit(train, config, *job) for job in jobs]
        for future in tqdm(futures, desc="training", unit="agent"):
            try:
                future.result()
            except SystemExit:
                pool.shutdown(cancel_futures=True)
                raise
    names = [f"{action}_{memory}" for action, memory in combinations]
    result = flown(config, names)
    feasible = result.episodes["flagship"].feasible

    def values(name: str, metric: str) -> list[FloatArray]:
        return [item.metrics[metric][feasible] for item in result.evaluations["flagship"][name]]

    heading = ["action", "memory", "seeds", *METRICS, "steps", "minutes of training"]
    estimates: Cells = [heading]
    differences: Cells = [[*heading[:3], *METRICS]]
    for entry in result.entries:
        name = entry.name
        action, memory = (BASE, "-") if name == BASE else name.split("_", maxsplit=1)
        label = [action, memory, str(len(entry.policies))]
        row, change = list(label), list(label)
        for metric in METRICS:
            row.append(number(estimate(values(name, metric), statistic_of(metric))))
            if name != BASE:
                difference = paired_difference(values(name, metric), values(BASE, metric))
                change.append(verdict(metric, difference))
        cards = entry.provenance.get("cards", [])[: config.seeds]
        row.append(str(max((card.get("run_steps", card["steps"]) for card in cards), default="-")))
        row.append(minutes(cards))
        estimates.append(row)
        if name != BASE:
            differences.append(change)
    left_out = [f"left out of the tables: {line}" for line in result.failures.values()]
    report = [f"# The study: {config.seeds} seeds each, frozen test episodes of the flagship", markdown(estimates),
              f"Mean paired differences to {BASE}", markdown(differences), *left_out]  # fmt: skip
    write_text(config.output / "report.md", "\n\n".join(report) + "\n")
    write_rows(config.output / "differences.csv", differences)
    console = Console()
    console.print("\n\n".join(report), markup=False, soft_wrap=True)
    console.print(f"wrote {config.output / 'report.md'}")
    if left_out:
        raise SystemExit("\n".join(left_out))
