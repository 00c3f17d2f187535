"""Write a page for every baseline: what it is, its gains, what reproduces, and a flight."""

from __future__ import annotations

import re
from pathlib import Path

import matplotlib
from baseline_claims import reproduction
from baseline_facts import About, about
from baseline_flights import SEED, Result, picture, results, task
from baseline_gains import provenance, schedulable, table
from docstring_parts import document, to_markdown
from environments import ids
from pages import markdown_table, remove_strangers, write_if_changed

from ftac_gym import baselines, scenarios
from ftac_gym.baselines import observers, tuned
from ftac_gym.utils.parameters import require

FOLDER = "baselines/generated"
OWN_SOURCES = {
    "PDDisturbanceObserver": "its disturbance observer",
    "ShapedPD": "its disturbance observer",
    "ShenClass": "its own monitor of the rate",
    "HSFC": "nowhere: it counts on a bound of the loss",
}
"""Where laws without an observer of the registry have what they know of faults from."""


LOST = 10.0
"""From this final error on a flight has not come to its target at all [deg]."""


def families(source: Path) -> dict[str, str]:
    """Return the page with the equations of each baseline: the one whose list of variants it is in.

    Raises
    ------
    ValueError
        If a baseline is in none or several.
    """
    found: dict[str, list[str]] = {name: [] for name in baselines.names()}
    for path in sorted((source / "baselines").glob("*.md")):
        for name in re.findall(r"^generated/(\w+)$", path.read_text(encoding="utf-8"), flags=re.M):
            require(name in found, f"baseline in {path.name}", f"must be one of {baselines.names()}", name)
            found[name].append(path.stem)
    for name, pages in found.items():
        require(len(pages) == 1, name, "must be in the list of exactly one page of docs/baselines", pages)
    return {name: pages[0] for name, pages in found.items()}


def in_words(scenario: str) -> str:
    """Return a scenario by name, with a link to the page of its environment."""
    name = {made_for: environment_id for environment_id, made_for in ids().items()}.get(scenario)
    return f"`{scenario}`" if name is None else f"[`{scenario}`](../../environments/generated/{name}.md)"


def fault_source(name: str) -> str:
    """Return where a baseline has its faults from, in words."""
    kind = baselines.defaults(name).get("faults", "none")
    if kind in observers.names():
        return f"the observer [`{kind}`](../observers.md)"
    if kind == "oracle":
        return "the truth"
    return OWN_SOURCES.get(baselines.baseline_class(name).__name__, "nowhere: it takes every wheel for healthy")


def _at_a_glance(name: str, known: About, family: str) -> str:
    law = baselines.baseline_class(name)
    made = baselines.make(name, task(known.flown))
    gains = (
        f"tuned on `{tuned.record(name)['provenance']['scenario']}`, or default" if name in tuned.names() else "default"
    )
    rows = [
        ("equations and corrections", f"[{family}](../{family}.md)"),
        ("class", f"{{py:class}}`~{law.__module__}.{law.__name__}`"),
        ("information", f"the {made.information} tier"),
        ("faults from", fault_source(name)),
        ("made for", ", ".join(in_words(scenario) for scenario in known.made_for)),
        ("gains", gains),
    ]
    return markdown_table(("", ""), rows)


def outcome(result: Result) -> str:
    """Return how a flight ended, in a sentence."""
    metrics = result.metrics
    gains = f"With {result.gains} gains it"
    final = f"{metrics['final_error']:.2g} deg off (root mean square of the last {result.hold:g} s)"
    if metrics["success"] > 0.0:
        return f"{gains} is on target to stay from {metrics['settling_time']:.1f} s on, and ends {final}: a success."
    if metrics["final_error"] > LOST:
        return f"{gains} is lost: it ends {metrics['final_error']:.0f} deg off."
    if result.error < result.angle:
        return (
            f"{gains} points well, {final}, but too restlessly: its rate error reaches {result.rate_error:.2g} deg/s."
        )
    # A flight that was cut short may yet arrive.
    cut = result.duration < scenarios.get(result.scenario).duration
    failed = f"is not on target after {result.duration:g} s" if cut else "fails"
    return f"{gains} {failed}: in the last {result.hold:g} s it is up to {result.error:.3g} deg off."


def _length(result: Result) -> str:
    whole = scenarios.get(result.scenario).duration
    return f"{whole:g} s" if result.duration >= whole else f"The first {result.duration:g} of {whole:g} s"


def _flight(name: str, scenario: str, flown: list[Result]) -> str:
    first = flown[0]
    fine = task_success(first)
    header = ("gains", "success", "on target from", "final error [deg]", "at the limit", "chatter [N m/s]")
    rows = []
    for item in flown:
        metrics = item.metrics
        settled = metrics["settling_time"]
        when = f"{settled:.1f} s" if settled < item.duration else "never"
        cells = [f"{metrics['final_error']:.3g}", f"{100.0 * metrics['saturation']:.0f} %", f"{metrics['chatter']:.3g}"]
        rows.append((item.gains, "yes" if metrics["success"] > 0.0 else "no", when, *cells))
    about_it = f"{name} on {scenario}: errors, wheel torques, and what it believes of the faults"
    return "\n\n".join(
        [
            f"### On `{scenario}`",
            f"{_length(first)} of {in_words(scenario)}, seed {SEED}. Faults: {first.faults}. {fine}",
            " ".join(outcome(item) for item in flown),
            f"```{{image}} {picture(name, scenario)}\n:alt: {about_it}\n```",
            markdown_table(header, rows).strip(),
        ]
    )


def task_success(result: Result) -> str:
    """Return what counts as on target, in a sentence."""
    return (
        f"On target is within {result.angle:.3g} deg and {result.rate:.3g} deg/s, and success to be there for the last"
        f" {result.hold:g} s. Dotted lines are these limits, those of the torque, and the moments at which faults"
        f" strike."
    )


def _snippet(name: str, scenario: str) -> str:
    lines = [
        "from ftac_gym.evaluation import rollout",
        "",
        f'history = rollout("{scenario}", "{name}", seed={SEED})',
        'print(history.metrics()["final_error"])',
    ]
    return "\n".join(["```python", *lines, "```"])


def head(law: type[baselines.Baseline]) -> str:
    """Return the docstring of a class as Markdown, up to its parameters, which the table of gains has."""
    return to_markdown(re.split(r"^Parameters\n-+$", document(law), flags=re.M)[0]).strip()


def page(name: str, family: str, flown: list[Result], source: Path) -> str:
    """Return the page of a baseline."""
    known, law = about(name), baselines.baseline_class(name)
    scenario = known.flown.scenario
    blocks = [f"# {name}", f"{known.summary}.", _at_a_glance(name, known, family)]
    blocks += ["## In flight", _snippet(name, scenario)]
    for place in dict.fromkeys(item.scenario for item in flown):
        blocks += [_flight(name, place, [item for item in flown if item.scenario == place])]
    blocks += ["## What reproduces"]
    said = reproduction(known.reported, source) if known.reported else ""
    blocks += [said or "No claim of a paper is about this variant, and no flight of the reports is its own."]
    blocks += ["## Gains", table(name, task(known.flown)), provenance(name), schedulable(name)]
    path = f"{law.__module__}.{law.__name__}"
    blocks += ["## Class", f"{{py:class}}`{path}` says of itself:", head(law)]
    return "\n\n".join(block.strip() for block in blocks) + "\n"


def index(pages: dict[str, str], flown: dict[str, list[Result]]) -> str:
    """Return the table of all baselines, which ``baselines/README.md`` includes."""
    rows = []
    for name, _ in sorted(pages.items(), key=lambda item: (item[1], item[0])):
        known = about(name)
        made = baselines.make(name, task(known.flown))
        best = flown[name][-1]
        ends = f"{'success' if best.metrics['success'] > 0.0 else 'no success'}, {best.metrics['final_error']:.2g} deg"
        rows.append(
            (
                f"[`{name}`](generated/{name}.md)",
                made.information,
                ", ".join(f"`{item}`" for item in known.made_for),
                ends,
            )
        )
    return markdown_table(("name", "information", "made for", "its flight ends"), rows)


def write(source: Path) -> None:
    """Write the pages of all baselines below ``docs``."""
    matplotlib.use("agg")
    source = Path(source)
    folder = source / FOLDER
    pages = families(source)
    flown = results(folder, source / "_build" / "baseline_flights.json")
    written = [folder / "table.inc"]
    write_if_changed(written[0], index(pages, flown))
    for name, family in pages.items():
        written += [folder / f"{name}.md", *(folder / picture(name, item.scenario) for item in flown[name])]
        write_if_changed(folder / f"{name}.md", page(name, family, flown[name], source))
    remove_strangers(folder, written)


if __name__ == "__main__":
    write(Path(__file__).parents[1])
