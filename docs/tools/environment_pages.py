"""Pages of the environment ids: the docstring of the environment with the numbers of each scenario."""

from __future__ import annotations

import dataclasses
import inspect
import re
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
from matplotlib.image import imsave
from page_parts import class_link, field_table, field_values, markdown, section, show, table, table_rows, write_pages

from ftac_gym import baselines, scenarios
from ftac_gym.envs import SpacecraftFTCEnv, observation, reward
from ftac_gym.faults import FaultSchedule
from ftac_gym.scenarios import library
from ftac_gym.task.scenario import Scenario

PICTURE_TIME = 8.0
"""Time of the picture [s], during the slew."""


def ids() -> dict[str, str]:
    """Return the environment ids of the package with the names of their scenarios, in the order of registration."""
    ours = {name: entry for name, entry in gym.registry.items() if str(entry.entry_point).startswith("ftac_gym.")}
    return {name: entry.kwargs["default_scenario"] for name, entry in ours.items()}


def draw_picture(environment_id: str, path: Path) -> None:
    """Draw a spacecraft in flight under ``pd``."""
    environment: Any = gym.make(environment_id, render_mode="rgb_array", width=960, height=540)
    environment.unwrapped.policy_name = "pd"
    policy = baselines.make("pd", environment.unwrapped.scenario).as_policy(environment)
    sample, info = environment.reset(seed=0)
    while info["time"] < PICTURE_TIME - 1e-9:
        sample, _, _, _, info = environment.step(policy.predict(sample)[0])
    path.parent.mkdir(parents=True, exist_ok=True)
    imsave(path, np.asarray(environment.render()))
    environment.close()


def observation_table(scenario: Scenario) -> str:
    """Return the slices of the observation in each tier as a table."""
    meanings = {row[0]: row[-1] for row in table_rows(observation.observation_layout.__doc__ or "")}
    layouts = {tier: observation.observation_layout(scenario, tier) for tier in observation.TIERS}
    rows = []
    for name, place in layouts["oracle"].slices.items():
        found = [layout.slices.get(name) for layout in layouts.values()]
        where = [f"{item.start}:{item.stop}" if item else "" for item in found]
        bound = f"±{layouts['oracle'].high[place.start]:.4g}"
        rows.append((f"`{name}`", str(place.stop - place.start), *where, bound, meanings[name]))
    return table(("slice", "length", *layouts, "bound", "meaning"), rows)


def fault_table(scenario: Scenario) -> str:
    """Return the faults of a scenario, with their shares where they are drawn."""
    drawn = scenario.faults
    if drawn is None:
        return "None."
    if isinstance(drawn, FaultSchedule):
        wheels = [getattr(fault, "wheel", None) for fault in drawn.faults]
        firsts = ["sensors" if wheel is None else f"wheel {wheel}" for wheel in wheels]
        text, head, faults = "The same in every episode.", "affects", drawn.faults
    else:
        shares = [f"{share:.0%} have {count}" for count, share in enumerate(drawn.fault_counts) if share > 0.0]
        text, head, faults = f"Number of faults: of the episodes, {', '.join(shares)}.", "share", drawn.kinds
        firsts = [f"{weight:.1%}" for weight in drawn.weights or ()]
        faults = (*faults, *drawn.always)
        firsts += ["always"] * len(drawn.always)
    rows = []
    for first, fault in zip(firsts, faults, strict=True):
        drop = ("wheel",) if first != "always" else ()
        fields = [f"`{name}` {text}" for name, text in field_values(fault, changed=True).items() if name not in drop]
        rows.append((first, class_link(fault), ", ".join(fields)))
    note = "Times in [s], torques in [N m]; a range is drawn from uniformly."
    return f"{text} {note}\n\n" + table((head, "kind", "magnitudes"), rows)


def page(environment_id: str, name: str) -> str:
    """Return the page of an environment id."""
    scenario, builder = scenarios.get(name), inspect.getmodule(library.BUILDERS[name])
    parts = {item.name: getattr(scenario, item.name) for item in dataclasses.fields(scenario)}
    off = ", ".join(f"`{part}`" for part, value in parts.items() if value is None)
    parts = {part: value for part, value in parts.items() if dataclasses.is_dataclass(value)}
    glance = field_table(scenario, *parts) + f"\n\nFields that are `None`, which is off: {off}."
    head, *texts = re.split(r"^## (.*)\n", inspect.getdoc(SpacecraftFTCEnv) or "", flags=re.M)
    arguments = [(f"`{argument}`", text) for argument, text in section(SpacecraftFTCEnv, "Parameters").items()]
    terms = [
        (f"`{row[0]}`", show(getattr(scenario.reward, row[0])), row[-1]) for row in table_rows(reward.__doc__ or "")
    ]
    tables = {
        "Action space": field_table(scenario.spacecraft.wheels),
        "Observation space": observation_table(scenario),
        "Rewards": table(("term", "weight", "value in each step"), terms),
        "Starting state": field_table(parts.pop("initial_state")),
        "Episode end": field_table(parts.pop("success")),
        "Arguments": table(("argument", "meaning"), arguments),
    }
    picture = f"```{{image}} {environment_id}.png\n:alt: {environment_id}, {PICTURE_TIME:g} s after the start\n```"
    code = f'```python\nimport gymnasium as gym\nimport ftac_gym\n\nenv = gym.make("{environment_id}")\n```'
    blocks = [f"# {environment_id}", markdown(inspect.getdoc(builder) or ""), picture, code, glance]
    for title, text in zip(["Task", *texts[::2]], [head, *texts[1::2]], strict=True):
        # The NumPy sections at the end of the docstring are a table here.
        blocks += [f"## {title}", markdown(text.split("Parameters\n---")[0]), tables.get(title, "")]
    for part, value in parts.items():
        if part != "reward":
            text = fault_table(scenario) if part == "faults" else field_table(value, "wheels", "appendages")
            blocks += [f"## {part.replace('_', ' ').capitalize()}", f"{class_link(value)}:", text]
    if isinstance(scenario.disturbance, tuple):
        blocks += ["## Disturbance", "The sum of several."]
        for torque in scenario.disturbance:
            blocks += [f"{class_link(torque)}:", field_table(torque)]
    if scenario.faults is None:
        blocks += ["## Faults", fault_table(scenario)]
    if scenario.spacecraft.appendages is not None:
        blocks += ["## Appendages", field_table(scenario.spacecraft.appendages)]
    return "\n\n".join(block.strip() for block in blocks if block.strip()) + "\n"


def write(source: Path) -> None:
    """Write the pages and pictures of all ids below the folder of the documentation."""
    folder = source / "environments"
    pages = {f"{environment_id}.md": page(environment_id, name) for environment_id, name in ids().items()}
    write_pages(folder / "generated", pages)
    for environment_id in ids():
        draw_picture(environment_id, folder / "generated" / f"{environment_id}.png")
