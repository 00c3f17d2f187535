"""Films: frames in a file that is complete or absent."""

from __future__ import annotations

import errno
import logging
import os
import secrets
from contextlib import suppress
from itertools import pairwise
from pathlib import Path
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from ftac_gym.utils.extras import require_extra
from ftac_gym.utils.files import PARTIAL, replacing
from ftac_gym.utils.parameters import require

SUFFIXES = (".mp4", ".gif")


class Film:
    """A film that is written frame by frame; a context manager, which discards the film after an error.

    Until it is closed, its file has a name of its own, so that several films of one path do not share it.

    Parameters
    ----------
    path
        File to write, ``.mp4`` (H.264) or ``.gif``; missing folders are created. An older file is replaced when the
        film is closed.
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
        self._shape, self.frames, self._closed = (height, width, 3), 0, False
        self._rate, self._images = frames_per_second, list[Any]()
        # The suffix of ffmpeg's file tells it the format.
        self._partial = self.path.with_name(f".{self.path.stem}.{secrets.token_hex(8)}{PARTIAL}{self.path.suffix}")
        self._writer: Any = None
        gif = self.path.suffix == ".gif"
        rule = "must be at most 50 for a .gif"
        require(not gif or frames_per_second <= 50, "frames_per_second", rule, frames_per_second)
        self.path.parent.mkdir(parents=True, exist_ok=True)
        require_extra("PIL", "imageio", "imageio_ffmpeg")
        from imageio.v2 import get_writer
        from PIL.Image import fromarray

        self._image = fromarray
        if not gif:
            # Its warnings, of which some depend on when ffmpeg ends, say less than the errors of the film.
            logging.getLogger("imageio_ffmpeg").setLevel(logging.ERROR)
            options: dict[str, Any] = {"fps": frames_per_second, "codec": "libx264", "quality": 8}
            self._writer = get_writer(self._partial, macro_block_size=2, ffmpeg_log_level="quiet", **options)

    def add(self, frame: npt.NDArray[np.uint8]) -> None:
        """Add a frame (height, width, 3).

        Raises
        ------
        ValueError
            If it has another size.
        OSError
            If it cannot be written, for example to a full disk. The film is discarded.
        """
        require(frame.shape == self._shape, "frame", f"must have shape {self._shape}", frame.shape)
        self.frames += 1
        if self._writer is None:
            # 64 colours are enough for the flat shading of the view.
            self._images.append(self._image(frame).quantize(colors=64))
            return
        try:
            self._writer.append_data(frame)
        except OSError:
            error = self._failure()
            self.discard()
            raise error from None

    def close(self) -> None:
        """Finish the file; a second call does nothing, and a film without frames is absent.

        Raises
        ------
        OSError
            If it cannot be written. An older file is as it was.
        """
        if self._closed:
            return
        try:
            if self._images:
                self._write_gif()
            elif self.frames:
                self._name_mp4()
        finally:
            self.discard()

    def _write_gif(self) -> None:
        # A GIF counts hundredths of a second: whole ones for each frame, without an error that adds up.
        ends = [round(100.0 * count / self._rate) for count in range(self.frames + 1)]
        durations = [10 * (end - start) for start, end in pairwise(ends)]
        first, *others = self._images
        more = (
            {"save_all": True, "append_images": others, "duration": durations} if others else {"duration": durations[0]}
        )
        with replacing(self.path) as file:
            first.save(file, format="GIF", loop=0, bits=6, optimize=True, **more)

    def _name_mp4(self) -> None:
        """Give the film its name if all frames can be read back: imageio hides the status of ffmpeg."""
        from imageio_ffmpeg import count_frames_and_secs  # type: ignore[import-untyped]

        self._writer.close()
        try:
            count, _ = count_frames_and_secs(str(self._partial))
        except RuntimeError:
            count = None
        if count != self.frames:
            raise self._failure()
        with self._partial.open("rb+") as file:
            os.fsync(file.fileno())
        self._partial.replace(self.path)

    def _failure(self) -> OSError:
        """Return the reason why ffmpeg failed: what an attempt to write to its file says."""
        try:
            with self._partial.open("ab") as file:
                file.write(bytes(2**20))
        except OSError as error:
            return OSError(error.errno, error.strerror, str(self.path))
        return OSError(errno.EIO, "ffmpeg did not finish the film", str(self.path))

    def discard(self) -> None:
        """Leave the film unfinished: an older file is as it was. After :meth:`close` it does nothing."""
        self._closed = True
        if self._writer is not None:
            with suppress(OSError):
                self._writer.close()
        with suppress(OSError):
            self._partial.unlink(missing_ok=True)

    def __enter__(self) -> Self:
        """Return the film."""
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        """Finish the file, or discard it after an error."""
        if kind is None:
            self.close()
        else:
            self.discard()
