"""Linear sampled loop of a baseline and its nominal spacecraft near rest on target.

A baseline is a black box with a measurement, commands and a memory: :mod:`.controller` gets its linear model from small
changes. :mod:`.spacecraft` has the spacecraft and :mod:`.margins` closes the loop.
"""

from ftac_gym.baselines.linear_loop.controller import LinearController, NoLinearLoopError, linearise
from ftac_gym.baselines.linear_loop.margins import LinearLoop, LoopMargins, linear_loop, loop_margins

__all__ = [
    "LinearController",
    "LinearLoop",
    "LoopMargins",
    "NoLinearLoopError",
    "linear_loop",
    "linearise",
    "loop_margins",
]
