"""Convert an agent that is stored as pickles, of an older version or Stable-Baselines3's own, to files without code.

Converting reads the pickles once, and reading a pickle runs the code in it. Convert only files that you trust.

For example:

    ftac-convert runs/old_agent runs/agent --trust
    ftac-convert logs/ppo/SpacecraftFTC-v0_1/best_model.zip runs/zoo --trust
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from tyro.conf import Positional

from ftac_gym.agents.conversion import convert
from ftac_gym.utils.console import exit_on


@dataclass(frozen=True)
class Config:
    """The old agent and the folder of the new one."""

    old: Positional[Path]
    """Folder with model.zip, folder with one for each seed (seed_*), folder of a run, or a zip of Stable-Baselines3."""
    new: Positional[Path]
    """Folder for the converted agent."""
    trust: bool = False
    """Run the code that the old files hold. Without it nothing is read."""


def main(config: Config) -> None:
    """Convert, and print what was written."""
    if not config.trust:
        raise SystemExit(
            f"{config.old}: reading its pickles runs the code in them. If you trust their author, add --trust"
        )
    print(f"reading the pickles of {config.old}, which runs the code in them")
    with exit_on(ValueError):
        converted = convert(config.old, config.new)
    for folder, normalized in converted.items():
        note = "with its normaliser" if normalized else "without a normaliser: it takes raw observations"
        print(f"wrote {folder}, {note}; it acts as the old one on random observations")
