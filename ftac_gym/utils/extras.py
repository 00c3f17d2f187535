"""Packages of the extras: which extra brings them, and the error that names its install line."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec

from gymnasium.error import DependencyNotInstalled

EXTRAS = {
    "train": (
        *("stable_baselines3", "torch", "tensorboard", "tyro", "tqdm", "rich", "matplotlib", "cmaes", "sb3_contrib"),
        *("yaml", "joblib", "jinja2", "filelock", "safetensors"),
    ),
    "cluster": ("ray",),
    "onnx": ("onnxruntime",),
    "lmi": ("cvxpy", "clarabel"),
    "render": ("pygame", "moviepy", "imageio", "imageio_ffmpeg", "PIL"),
}
"""Modules of each extra of ``pyproject.toml``."""


class MissingExtra(DependencyNotInstalled, ImportError):
    """Error of a package that is not installed; its message is the line that installs it."""


def require_extra(*packages: str) -> None:
    """Refuse to go on without some packages, before they are imported.

    Parameters
    ----------
    packages
        Names of modules, all in :data:`EXTRAS`.

    Raises
    ------
    MissingExtra
        If one is not installed.
    """
    for package in packages:
        if find_spec(package) is None:
            raise missing(package)


@contextmanager
def naming_extra() -> Iterator[None]:
    """Raise a :class:`MissingExtra` in the place of an import's error in the block, if an extra has the module."""
    try:
        yield
    except ModuleNotFoundError as error:
        package = (error.name or "").partition(".")[0]
        if not any(package in known for known in EXTRAS.values()):
            raise
        raise missing(package) from None


def missing(package: str) -> MissingExtra:
    """Return the error of a module of :data:`EXTRAS` that is not installed."""
    extra = next(extra for extra, known in EXTRAS.items() if package in known)
    return MissingExtra(f'{package} is missing: pip install "ftac_gym[{extra}]"')
