"""Write a page for every environment id: its docstring, and what its scenario holds."""

from __future__ import annotations

import inspect
import re
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import scenario_facts as facts
import yaml
from docstring_parts import document, markdown_sections, to_markdown
from matplotlib.image import imsave
from pages import markdown_table, remove_strangers, write_if_changed

import ftac_gym
from ftac_gym import baselines, scenarios
from ftac_gym.envs import SpacecraftFTCEnv
from ftac_gym.envs.observation import TIERS, observation_layout
from ftac_gym.task.scenario import Scenario

FOLDER = "environments/generated"
PICTURE_TIME = 8.0
"""When the picture is taken [s]: the craft is on its way."""
TASKS = {
    "SpacecraftFTC-v0": "slew from any attitude, then fine pointing, with random hidden faults: the flagship",
    "SpacecraftFTCTracking-v0": "the same craft follows slow sinusoids",
    "SpacecraftFTCFlexible-v0": "the first task for a craft with two long panels that bend",
}
"""What the ids that belong to no paper are about."""


def ids() -> dict[str, str]:
    """Return the environment ids of the package, each with the name of its scenario, in the order of registration."""
    return {
        name: entry.kwargs["default_scenario"]
        for name, entry in gym.registry.items()
        if str(entry.entry_point).startswith(f"{ftac_gym.__name__}.")
    }


def paper(scenario: str, citation: Path) -> str | None:
    """Return the reference of the paper that a scenario is named after, from ``CITATION.cff``, if any."""
    match = re.search(r"_(\d{4})(_|$)", scenario)
    for entry in yaml.safe_load(citation.read_text(encoding="utf-8"))["references"]:
        families = [author["family-names"] for author in entry["authors"]]
        if match and int(match[1]) == entry["year"] and scenario.startswith(families[0].lower()):
            names = " and ".join([", ".join(families[:-1]), families[-1]] if len(families) > 1 else families)
            pages = f", {entry['start']}" + (f"-{entry['end']}" if "end" in entry else "") if "start" in entry else ""
            volume = f" {entry['volume']}" if "volume" in entry else ""
            issue = f"({entry['issue']})" if "issue" in entry else ""
            doi = f", <https://doi.org/{entry['doi']}>" if "doi" in entry else ""
            return f"{names} {entry['year']}: {entry['title'].strip()}. *{entry['journal']}*{volume}{issue}{pages}{doi}"
    return None


def picture(environment_id: str, path: Path) -> bool:
    """Draw a craft in flight under a plain controller.

    Returns
    -------
    Whether there is a picture now; there is none without the extra ``render``.
    """
    try:
        environment: Any = gym.make(environment_id, render_mode="rgb_array", width=960, height=540)
    except (ImportError, gym.error.DependencyNotInstalled):
        return False
    scenario = environment.unwrapped.scenario
    environment.unwrapped.policy_name = "pd"
    policy = baselines.make("pd", scenario).as_policy(environment)
    observation, _ = environment.reset(seed=0)
    for _ in range(round(PICTURE_TIME / scenario.control_period)):
        observation, _, terminated, truncated, _ = environment.step(policy.predict(observation)[0])
        if terminated or truncated:
            break
    frame = np.asarray(environment.render())
    environment.close()
    path.parent.mkdir(parents=True, exist_ok=True)
    imsave(path, frame)
    return True


def _at_a_glance(scenario: Scenario) -> str:
    wheels = scenario.spacecraft.wheels
    modes = f", {scenario.spacecraft.modes} vibration modes" if scenario.spacecraft.modes else ""
    sizes = ", ".join(f"{observation_layout(scenario, tier).size} (`{tier}`)" for tier in TIERS)
    tumble = (
        "never ended before"
        if scenario.tumble_rate is None
        else f"ended by turning faster than {scenario.tumble_rate:.4g} rad/s"
    )
    success = scenario.success
    rows = [
        ("scenario", f"`{scenario.name}`"),
        ("craft", f"{wheels.count} wheels of {facts.show(wheels.torque_limits.tolist()[0])} N m{modes}"),
        ("action", f"`Box(-1, 1, ({wheels.count},), float32)`"),
        ("observation", f"`Box` of {sizes} numbers"),
        ("control period", f"{scenario.control_period:.4g} s"),
        ("physics step", f"{scenario.physics_step:.4g} s, RK4"),
        ("episode", f"{scenario.duration:.4g} s, {scenario.horizon} steps; {tumble}"),
        (
            "success",
            f"within {np.degrees(success.angle):.4g} deg and {np.degrees(success.rate):.4g} deg/s for the last"
            f" {success.hold:.4g} s",
        ),
    ]
    return markdown_table(("", ""), rows)


def _story(name: str) -> str:
    """Return what the scenario's function and its file say about it."""
    builder = scenarios._BUILDERS[name]
    own = document(builder).removeprefix("Return the scenario of ``").removeprefix("Return ")
    head = document(inspect.getmodule(builder))
    if not document(builder).startswith("Return the scenario of"):
        return to_markdown(f"{head}\n\n{own[0].upper()}{own[1:]}")
    _, _, rest = own.partition(":")
    return to_markdown(head + (f"\n\nThis scenario: {rest.strip()}" if rest else ""))


def page(environment_id: str, name: str, pictured: bool, reference: str | None) -> str:
    """Return the page of an id."""
    scenario = scenarios.get(name)
    text = {title: to_markdown(body) for title, body in markdown_sections(document(SpacecraftFTCEnv)).items()}
    craft = scenario.spacecraft
    blocks = [f"# {environment_id}", _story(name)]
    if pictured:
        about = f"{environment_id} in flight, {PICTURE_TIME:g} s after its start"
        blocks.append(f"```{{image}} {environment_id}.png\n:alt: {about}\n```")
    blocks += [f'```python\nimport gymnasium as gym\nimport ftac_gym\n\nenv = gym.make("{environment_id}")\n```']
    blocks += [_at_a_glance(scenario)]
    if reference:
        blocks += [f"Source: {reference}."]
    blocks += ["## Description", text.pop(""), text.pop("Description")]
    added = {
        "Action space": facts.fields(craft.wheels),
        "Observation space": facts.observations(scenario),
        "Rewards": facts.reward(scenario),
        "Starting state": facts.part(scenario.initial_state, ""),
        "Episode end": facts.fields(scenario.success),
    }
    options = text.pop("Arguments")
    for title, body in text.items():
        blocks += [f"## {title}", body, added.get(title, "")]
    uncertainty = facts.part(scenario.inertia_uncertainty, "The true inertia is the nominal one.")
    blocks += ["## Spacecraft", facts.fields(craft, skip=("wheels", "appendages"))]
    if craft.appendages is not None:
        blocks += ["### Appendages", facts.part(craft.appendages, "")]
        blocks += [facts.part(scenario.appendage_uncertainty, "The true modes are the nominal ones.")]
    if scenario.misalignment is not None:
        blocks += [
            f"The true wheel axes differ from the nominal ones by {facts.show(scenario.misalignment)} (rows of D)."
        ]
    blocks += ["### Uncertainty", uncertainty]
    blocks += ["## Reference", facts.part(scenario.reference, "")]
    blocks += [
        "## Faults",
        facts.faults(scenario),
        "What the kinds do: [wheels, sensors and faults](../../wheels_and_faults.md).",
    ]
    blocks += ["## Disturbance", facts.part(scenario.disturbance, "No external torque.")]
    blocks += ["## Sensors", facts.part(scenario.sensors, "Perfect: what is measured is true.")]
    if scenario.prescribed_bound is not None:
        blocks += ["## Prescribed bound", facts.part(scenario.prescribed_bound, "")]
    blocks += ["## Arguments", facts.arguments(options)]
    return "\n\n".join(block.strip() for block in blocks if block.strip()) + "\n"


def table(source: Path) -> str:
    """Return the table of all ids with their pages in the navigation, which ``environments/index.md`` includes."""
    rows = []
    for environment_id, name in ids().items():
        scenario = scenarios.get(name)
        reference = paper(name, source.parent / "CITATION.cff")
        task = TASKS.get(environment_id) or f"the example of {(reference or name).split(':')[0]}"
        rows.append(
            (
                f"[`{environment_id}`](generated/{environment_id}.md)",
                task,
                str(scenario.spacecraft.wheels.count),
                f"{1.0 / scenario.control_period:.4g}",
                f"{scenario.duration:.4g}",
            )
        )
    pages = "\n".join(f"generated/{environment_id}" for environment_id in ids())
    navigation = f"```{{toctree}}\n:hidden:\n\n{pages}\n```\n"
    return markdown_table(("id", "task", "wheels", "control [Hz]", "episode [s]"), rows) + "\n" + navigation


def write(source: Path) -> None:
    """Write the pages of all ids below ``docs``."""
    folder = source / FOLDER
    written = [folder / "table.md"]
    write_if_changed(written[0], table(source))
    for environment_id, name in ids().items():
        image = folder / f"{environment_id}.png"
        pictured = picture(environment_id, image)
        written += [folder / f"{environment_id}.md", image]
        reference = paper(name, source.parent / "CITATION.cff")
        write_if_changed(written[-2], page(environment_id, name, pictured, reference))
    remove_strangers(folder, written)


if __name__ == "__main__":
    write(Path(__file__).parents[1])
