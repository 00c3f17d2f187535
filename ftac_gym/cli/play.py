"""Show a policy, alone or beside a second one on the same episode, and add faults to its wheels.

In the window, Tab chooses a kind of fault. A digit adds it to that wheel (or to the sensors); Shift and a digit clears
the faults of the wheel, Backspace clears all. Space pauses, Right steps, Up and Down change the speed. R starts the
same episode again, N the next one. V starts and ends a film; Q quits. With --output, a film is written and no window
is opened.

For example:

    ftac-play --policy nftsm --fault seizure:2@15
    ftac-play --policy agent --against "nftsm tuned" --scenario flagship_hardware --episode 17
    ftac-play --policy nftsm --against pd_dob --fault seizure:2@15 --speed 4 --output results/seizure.mp4
"""

from dataclasses import dataclass
from pathlib import Path

from gymnasium.error import DependencyNotInstalled
from rich.progress import track

from ftac_gym.cli.tasks import scenario_of, short_name
from ftac_gym.envs.rendering import Window
from ftac_gym.envs.rendering.toolkit import pygame
from ftac_gym.faults.specification import NO_FAULTS
from ftac_gym.scenarios import frozen
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.console import exit_on
from ftac_gym.viewer import Film, Screen, Session
from ftac_gym.viewer.keys import press

STILL = 2.0
"""Time for which a film shows its last frame [s]."""


@dataclass(frozen=True)
class Config:
    """Policies to show, and their episode."""

    policy: str = "agent"
    """A baseline's name, "NAME tuned" or "NAME FILE.json" for tuned gains, the name or folder of an agent, or a zip of
    Stable-Baselines3. "agent" is the shipped residual of the scenario, or of the flagship."""
    against: str | None = None
    """A second policy, side by side on the same episode."""
    scenario: str = "flagship"
    """Scenario: NAME, FILE.json or module:function."""
    fault: tuple[str, ...] = ()
    """Faults instead of the scenario's own, such as seizure:2@15 (wheel 2, after 15 s) or
    loss_of_effectiveness:0@10,effectiveness=0.3; beside its own with a plus, +seizure:2@15; "none" for a healthy
    spacecraft."""
    seed: int | None = None
    """Seed of the episodes; by default that of the scenario's frozen test episodes, else 0."""
    episode: int = 0
    """Number of the episode within the seed."""
    speed: float = 1.0
    """Seconds of the episode per second."""
    frames_per_second: int = 30
    """Of the window and of films."""
    width: int = 1280
    """Of the picture [pixels]."""
    height: int = 640
    """Of the picture [pixels]."""
    output: Path | None = None
    """File of a film (.mp4 or .gif), written instead of opening a window."""
    seconds: float | None = None
    """Length of the film in seconds of the episode; None for all of it."""
    films: Path = Path("results/films")
    """Folder of films that are started in the window."""


def task(config: Config) -> Scenario:
    """Return the scenario with the faults of the command line."""
    scenario = scenario_of(config.scenario)
    if not config.fault:
        return scenario
    return scenario.replace(faults=NO_FAULTS if config.fault == (NO_FAULTS,) else config.fault)


def begin(config: Config) -> Session:
    """Return the session."""
    names = [config.policy] if config.against is None else [config.policy, config.against]
    policies = {}
    for name in names:
        policies[name if name not in policies else f"{name} again"] = name
    seed = config.seed if config.seed is not None else frozen.seeds().get(config.scenario, 0)
    session = Session(task(config), policies, seed, config.episode)
    session.speed = config.speed
    return session


def film(config: Config, session: Session, path: Path) -> None:
    """Write a film of an episode."""
    screen = Screen(session, config.width, config.height, strip=False)
    length = min(config.seconds or session.scenario.duration, session.scenario.duration)
    count = round(length / session.speed * config.frames_per_second)
    with Film(path, config.width, config.height, config.frames_per_second) as target:
        for _ in track(range(count), description=str(path)):
            screen.draw()
            target.add(screen.frame())
            session.run(1.0 / config.frames_per_second)
        screen.draw()
        for _ in range(round(STILL * config.frames_per_second)):
            target.add(screen.frame())


def watch(config: Config, session: Session) -> None:
    """Show a session in a window until it is closed."""
    screen, recording, taken = Screen(session, config.width, config.height), None, 0
    window = Window(config.width, config.height, "ftac_gym")
    names = {pygame.K_TAB: "tab", pygame.K_BACKSPACE: "backspace", pygame.K_SPACE: "space", pygame.K_RIGHT: "right"}
    names |= {pygame.K_UP: "up", pygame.K_DOWN: "down", pygame.K_r: "r", pygame.K_n: "n"}
    names |= {pygame.K_0 + digit: str(digit) for digit in range(10)}
    try:
        while window.open:
            screen.draw()
            window.show(screen.surface)
            if recording is not None:
                recording.add(screen.frame())
            for event in window.events():
                if event.type != pygame.KEYDOWN:
                    continue
                if event.key in (pygame.K_q, pygame.K_ESCAPE):
                    window.close()
                elif event.key == pygame.K_v and recording is None:
                    taken += 1
                    path = config.films / f"{short_name(config.scenario)}_{session.seed}_{taken}.mp4"
                    recording = Film(path, config.width, config.height, config.frames_per_second)
                    screen.notice = f"filming {path}"
                elif event.key == pygame.K_v and recording is not None:
                    recording.close()
                    screen.notice, recording = f"wrote {recording.path}", None
                else:
                    screen.notice = press(session, names.get(event.key, ""), bool(event.mod & pygame.KMOD_SHIFT))
            session.run(1.0 / config.frames_per_second)
            window.tick(config.frames_per_second)
    finally:
        window.close()
        if recording is not None:
            recording.close()


def main(config: Config) -> None:
    """Show a window, or write a film."""
    with exit_on(ValueError, RuntimeError, DependencyNotInstalled, prefix="play: "):
        session = begin(config)
        if config.output is not None:
            film(config, session, config.output)
            print(f"wrote {config.output}")
        else:
            watch(config, session)
