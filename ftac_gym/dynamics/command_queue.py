"""Commands on their way to the wheels of N spacecraft."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ftac_gym.utils.parameters import FloatArray


class CommandQueue:
    """The latest commands of N spacecraft, of which each takes effect after the loop delay.

    A delay that is no whole number of control periods divides each period in two parts, with a command each.

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
        self.commands = np.zeros((1, count, wheels))
        """(D, N, m) commands [N m]: the latest, then those before it, as far back as any wheel needs them."""
        self.lag = np.full(count, self._periods, dtype=np.int64)
        """(N,) position of the command that takes effect in the last part of a period."""
        self.parts = ((1, 0, late), (0, late, substeps - late)) if late else ((0, 0, substeps),)
        """Parts of a period: further lag of the command in effect, first physics step, number of steps."""
        self._reach(self._periods + len(self.parts) if delay else 0)

    @property
    def latest(self) -> FloatArray:
        """(N, m) the command given last [N m]: a view, to be written to before each period."""
        return self.commands[0]

    @property
    def in_effect(self) -> FloatArray:
        """(N, m) mean command in effect over the period that has ended [N m], by the nominal delay."""
        if not self._periods and not self._late:
            return self.latest
        held = self.commands[self._periods + 1]
        if not self._late:
            return held
        mean: FloatArray = held + self._late * (self.commands[self._periods + 2] - held)
        return mean

    def begin(self, rows: npt.NDArray[np.int64], extra: npt.NDArray[np.int64], fault: int) -> None:
        """Start the listed spacecraft without a command.

        Parameters
        ----------
        rows
            Their numbers (n,).
        extra
            (n,) delay beyond the nominal one, in control periods.
        fault
            Longest delay by a fault, in control periods.
        """
        self.lag[rows] = self._periods + extra
        self.allow(fault)
        self.commands[:, rows] = 0.0

    def allow(self, fault: int) -> None:
        """Store from now on the commands that a fault needs which delays them by some control periods."""
        longest = int(self.lag.max()) + fault
        if longest or len(self.parts) > 1:
            # One more is that of the period before, which the next command must not overwrite.
            self._reach(longest + len(self.parts))

    def shift(self) -> None:
        """End a period: each command becomes that of one period before."""
        if len(self.commands) > 1:
            self.commands[1:] = self.commands[:-1].copy()

    def _reach(self, back: int) -> None:
        """Store the commands of so many periods back; those of before are taken to equal the oldest."""
        missing = back + 1 - len(self.commands)
        if missing > 0:
            self.commands = np.concatenate([self.commands, np.repeat(self.commands[-1:], missing, axis=0)])
