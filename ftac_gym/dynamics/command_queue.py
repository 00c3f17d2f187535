"""Commands on their way to the wheels of N spacecraft."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ftac_gym.faults.table import LONGEST_DELAY
from ftac_gym.utils.parameters import FloatArray

_ROOM = 4
"""Length of the buffer over that of the queue: the larger, the less often the commands are moved."""


class CommandQueue:
    """The latest commands of N spacecraft, of which each takes effect after the loop delay.

    A delay that is no whole number of control periods divides each period in two parts, with a command each. There are
    always as many old commands as a fault of the wheels may need, which can come at any time.

    Parameters
    ----------
    count, wheels
        Number of spacecraft N, and of their wheels m.
    delay
        Nominal loop delay in physics steps.
    substeps
        Physics steps of a control period.
    """

    def __init__(self, count: int, wheels: int, delay: int, substeps: int) -> None:
        self._periods, late = divmod(delay, substeps)
        self._late = late / substeps
        self.lag = np.full(count, self._periods, dtype=np.int64)
        """(N,) position of the command that takes effect in the last part of a period, where no fault delays it."""
        self.parts = ((1, 0, late), (0, late, substeps - late)) if late else ((0, 0, substeps),)
        """Parts of a period: further lag of the command in effect, first physics step, number of steps."""
        self._length = self._periods + LONGEST_DELAY + len(self.parts)
        # The queue is a window of the buffer that moves towards its start, by one command a period.
        self._buffer = np.zeros((_ROOM * self._length, count, wheels))
        self._head = len(self._buffer) - self._length

    @property
    def commands(self) -> FloatArray:
        """(D, N, m) commands [N m]: the latest, then those before it, as far back as any wheel needs them."""
        return self._buffer[self._head : self._head + self._length]

    @property
    def latest(self) -> FloatArray:
        """(N, m) the command given last [N m]: a view, to be written to before each period."""
        latest: FloatArray = self._buffer[self._head]
        return latest

    @property
    def in_effect(self) -> FloatArray:
        """(N, m) mean command in effect over the period that has ended [N m], by the nominal delay."""
        commands = self.commands
        if not self._periods and not self._late:
            return self.latest
        held: FloatArray = commands[self._periods + 1]
        if not self._late:
            return held
        mean: FloatArray = held + self._late * (commands[self._periods + 2] - held)
        return mean

    def begin(self, rows: npt.NDArray[np.int64], extra: npt.NDArray[np.int64]) -> None:
        """Start the listed spacecraft without a command.

        Parameters
        ----------
        rows
            Their numbers (n,).
        extra
            (n,) delay beyond the nominal one, in control periods.
        """
        self.lag[rows] = self._periods + extra
        missing = int(self.lag.max()) + LONGEST_DELAY + len(self.parts) - self._length
        if missing > 0:
            # No other spacecraft needs commands as old as those that are added.
            commands = self.commands
            self._length += missing
            self._buffer = np.zeros((_ROOM * self._length, *commands.shape[1:]))
            self._head = len(self._buffer) - self._length
            self._buffer[self._head : self._head + len(commands)] = commands
        self.commands[:, rows] = 0.0

    def shift(self) -> None:
        """End a period: each command becomes that of one period before."""
        if self._head == 0:
            self._head = len(self._buffer) - self._length + 1
            self._buffer[self._head :] = self._buffer[: self._length - 1]
        self._head -= 1
        self._buffer[self._head] = self._buffer[self._head + 1]
