"""Frames to a file."""

from __future__ import annotations

from collections.abc import Generator
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
import numpy.typing as npt
from gymnasium.error import DependencyNotInstalled

from ftac_gym.utils.parameters import require

SUFFIXES = (".mp4", ".gif")


class Film:
    """A film that is written frame by frame; a context manager.

    Parameters
    ----------
    path
        Where to: ``.mp4`` (H.264) or ``.gif``. Folders are made.
    width, height
        Of a frame [pixels]; even numbers.
    frames_per_second
        [1/s].

    Raises
    ------
    ValueError
        If the suffix is another one or a size is odd.
    gymnasium.error.DependencyNotInstalled
        If the extra ``render`` is missing.
    """

    def __init__(self, path: str | Path, width: int, height: int, frames_per_second: float) -> None:
        self.path = Path(path)
        require(self.path.suffix in SUFFIXES, "film", f"must end in one of {list(SUFFIXES)}", str(path))
        even = width % 2 == 0 and height % 2 == 0
        require(even, "width and height", "must be even numbers: H.264 has no others", (width, height))
        self.size = (width, height)
        self.frames_per_second = frames_per_second
        self.frames = 0
        """How many have been added."""
        self.path.parent.mkdir(parents=True, exist_ok=True)
        self._pictures: list[Any] = []
        self._writer: Generator[None, Any, None] | None = None
        try:
            if self.path.suffix == ".mp4":
                import imageio_ffmpeg

                self._writer = imageio_ffmpeg.write_frames(
                    str(self.path), self.size, fps=frames_per_second, codec="libx264", quality=8, macro_block_size=2
                )
                self._writer.send(None)
            else:
                from PIL import Image

                self._image = Image
        except ImportError as error:
            text = 'a film needs the extra "render": pip install "ftac-gym[render]"'
            raise DependencyNotInstalled(text) from error

    def add(self, frame: npt.NDArray[np.uint8]) -> None:
        """Add a frame (height, width, 3).

        Raises
        ------
        ValueError
            If it has another size.
        """
        wanted = (self.size[1], self.size[0], 3)
        require(frame.shape == wanted, "frame", f"must have shape {wanted}", frame.shape)
        if self._writer is not None:
            self._writer.send(np.ascontiguousarray(frame))
        else:
            picture = self._image.fromarray(frame)
            self._pictures.append(picture.quantize(colors=64, dither=self._image.Dither.NONE))
        self.frames += 1

    def close(self) -> None:
        """Finish the file; a second call does nothing."""
        if self._writer is not None:
            self._writer.close()
            self._writer = None
        if self._pictures:
            first, *others = self._pictures
            duration = round(1000.0 / self.frames_per_second)
            first.save(self.path, save_all=True, append_images=others, duration=duration, loop=0, optimize=True)
            self._pictures = []

    def __enter__(self) -> Self:
        """Return the film."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Finish the file."""
        self.close()
