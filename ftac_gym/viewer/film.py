"""Films: frames written to a file by imageio."""

from __future__ import annotations

from pathlib import Path
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
        File to write, ``.mp4`` (H.264) or ``.gif``; missing folders are created.
    width, height
        Size of a frame [pixels]; even numbers.
    frames_per_second
        Frame rate [1/s]; at most 50 for a ``.gif``, since viewers slow down shorter frames.

    Attributes
    ----------
    frames
        Number of frames so far.

    Raises
    ------
    ValueError
        If the suffix is another one, a size is odd, or the frame rate is too high.
    gymnasium.error.DependencyNotInstalled
        If the extra ``render`` is missing.
    """

    def __init__(self, path: str | Path, width: int, height: int, frames_per_second: float) -> None:
        self.path = Path(path)
        require(self.path.suffix in SUFFIXES, "film", f"must end in one of {list(SUFFIXES)}", str(path))
        even = width % 2 == 0 and height % 2 == 0
        require(even, "width and height", "must be even numbers: H.264 has no others", (width, height))
        self._shape, self.frames = (height, width, 3), 0
        options: dict[str, Any] = {"fps": frames_per_second, "codec": "libx264", "quality": 8, "macro_block_size": 2}
        self._rate, self._durations = frames_per_second, list[int]()
        if self.path.suffix == ".gif":
            require(frames_per_second <= 50, "frames_per_second", "must be at most 50 for a .gif", frames_per_second)
            # The writer reads the durations when it is closed. 64 colours are enough for the flat shading of the view.
            options = {"duration": self._durations, "loop": 0, "bits": 6, "optimize": True}
        self.path.parent.mkdir(parents=True, exist_ok=True)
        try:
            from imageio.v2 import get_writer

            self._writer = get_writer(self.path, **options)
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
        require(frame.shape == self._shape, "frame", f"must have shape {self._shape}", frame.shape)
        # A GIF counts hundredths of a second: whole ones for each frame, without an error that adds up.
        start, end = (round(100.0 * count / self._rate) for count in (self.frames, self.frames + 1))
        self._durations.append(10 * (end - start))
        self._writer.append_data(frame)
        self.frames += 1

    def close(self) -> None:
        """Finish the file; a second call does nothing."""
        self._writer.close()

    def __enter__(self) -> Self:
        """Return the film."""
        return self

    def __exit__(self, *_: object) -> None:
        """Finish the file."""
        self.close()
