"""Everything that can be seen of a simulator, at a moment and along commands."""

import numpy as np


def snapshot(simulator):
    """Measurement and state of N spacecraft, (N, values)."""
    measured, state = simulator.measurement(), simulator.state
    parts = [array for name, array in vars(measured).items() if name != "truth"]
    parts += vars(state).values()
    return np.concatenate([np.asarray(part, dtype=float).reshape(len(measured), -1) for part in parts], axis=1)


def history(simulator, orders):
    """Snapshots (T + 1, N, values) before and after each command."""
    rows = [snapshot(simulator)]
    for order in orders:
        simulator.step(order)
        rows.append(snapshot(simulator))
    return np.array(rows)
