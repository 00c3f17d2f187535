"""Divergence of the plant: an error that names the spacecraft, the time and the quantity."""

import numpy as np
import numpy.typing as npt

from ftac_gym.utils.parameters import FloatArray

MOVED = ("wheel_momentum", "modal_displacement", "modal_rate", "rate", "attitude")
"""Arrays of the state, causes before effects."""

SEEN = ("measured_rate", "measured_attitude", "reference_rate", "reference_acceleration", "reference_attitude")
"""Arrays of the measurement, after those of the state."""


class DivergenceError(ArithmeticError):
    """A spacecraft in a state of no body: not finite, or too fast for the physics step.

    The other spacecraft of the simulator have completed the control period. The spacecraft itself flies again after its
    next reset.

    Attributes
    ----------
    spacecraft
        Indices of all spacecraft that have diverged.
    """

    spacecraft: tuple[int, ...] = ()


def divergence(
    state: dict[str, FloatArray],
    seen: dict[str, FloatArray],
    time: FloatArray,
    rows: npt.NDArray[np.int64],
    largest: float,
) -> DivergenceError:
    """Return the error of the listed rows, of which at least one has diverged.

    Parameters
    ----------
    state, seen
        Arrays (N, .) of the state and of the measurement, by name: :data:`MOVED` and :data:`SEEN`.
    time
        (N,) time since the start of each episode [s].
    rows
        Spacecraft to look at.
    largest
        Largest rate that the physics step integrates [rad/s].
    """
    with np.errstate(over="ignore", invalid="ignore"):
        speed = np.linalg.norm(state["rate"], axis=1)
    finite = "must stay finite"
    causes = [(name, finite, array, np.isfinite(array)) for name, array in state.items()]
    rule = f"must stay below {largest:.4g} rad/s for this physics_step"
    causes.append(("rate", rule, speed[:, None], (speed <= largest)[:, None]))
    causes += [(name, finite, array, np.isfinite(array)) for name, array in seen.items()]
    lost = [row for row in rows.tolist() if not all(sound[row].all() for *_, sound in causes)]
    first = lost[0]
    name, rule, array, sound = next(cause for cause in causes if not cause[-1][first].all())
    value = array[first][~sound[first]][0]
    others = f" and {len(lost) - 1} more" if len(lost) > 1 else ""
    error = DivergenceError(
        f"{name} {rule}, got {value:.4g} on spacecraft {first}{others} at {time[first]:.6g} s; "
        "a smaller physics_step, smaller torques or a tumble_rate keep it within"
    )
    error.spacecraft = tuple(lost)
    return error
