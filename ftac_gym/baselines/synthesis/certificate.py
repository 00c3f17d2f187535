"""Certificate of gains from the gains and a Lyapunov matrix alone: plain linear algebra, independent of the solver."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ftac_gym.baselines.synthesis.regions import Disc, poles
from ftac_gym.utils.parameters import FloatArray

SLACK = 1e-6
"""Relative tolerance of a bound, for rounding: the optimum lies on it."""


@dataclass(frozen=True, eq=False)
class Certificate:
    """A bound that holds for every blend of the rules, and the properties of each rule by itself.

    Attributes
    ----------
    gamma
        Level from the disturbance to the whole error that V = e'Pe proves, for the same P at all rules; infinite if V
        does not decrease.
    contraction
        (8,) the norm of A_i - centre in the metric of P; at most the radius proves that the poles are in the disc.
    reach
        (8,) the largest distance of a pole of each rule from the centre.
    poles
        (8, n) [1/s].
    peak_gain
        (8,) largest gain of each rule's transfer function on a grid of frequencies; at most gamma.
    disc
        The required region.
    lyapunov
        P (n, n).
    """

    gamma: float
    contraction: FloatArray
    reach: FloatArray
    poles: npt.NDArray[np.complex128]
    peak_gain: FloatArray
    disc: Disc | None
    lyapunov: FloatArray

    @property
    def in_disc(self) -> bool:
        """True if every pole of every rule lies in the disc, or without a disc."""
        return self.disc is None or bool((self.reach <= self.disc.radius * (1.0 + SLACK)).all())

    @property
    def holds(self) -> bool:
        """True if the one P proves level and disc."""
        proved = self.disc is None or bool((self.contraction <= self.disc.radius * (1.0 + SLACK)).all())
        return bool(np.isfinite(self.gamma)) and proved and self.in_disc


def certificate(
    closed: FloatArray, inputs: FloatArray, lyapunov: FloatArray, disc: Disc | None, scale: FloatArray
) -> Certificate:
    """Certify e' = A_i e + B_i d with output e.

    Parameters
    ----------
    closed
        A_i (8, n, n).
    inputs
        B_i (8, n, m).
    lyapunov
        P (n, n).
    disc
        Region for the poles; None for no region.
    scale
        (n,) magnitudes of the entries of e, which balance the rounding errors.
    """
    weight = scale[:, None] * lyapunov * scale
    moved = closed / scale[:, None] * scale
    driven = inputs / scale[:, None]
    decrease = weight @ moved
    decrease = decrease + decrease.transpose(0, 2, 1) + np.diag(scale**2)
    gamma = float("inf")
    if np.linalg.eigvalsh(weight)[0] > 0.0 and np.linalg.eigvalsh(decrease)[:, -1].max() < 0.0:
        driven_weight = weight @ driven
        gamma = float(
            np.sqrt(
                np.linalg.eigvalsh(driven_weight.transpose(0, 2, 1) @ np.linalg.solve(-decrease, driven_weight)).max()
            )
        )
    centre, found = 0.0 if disc is None else disc.centre, poles(moved)
    return Certificate(
        gamma=gamma,
        contraction=_contraction(moved - centre * np.eye(len(scale)), weight),
        reach=np.abs(found - centre).max(axis=1),
        poles=found,
        peak_gain=peak_gain(closed, inputs),
        disc=disc,
        lyapunov=lyapunov,
    )


def _contraction(matrices: FloatArray, weight: FloatArray) -> FloatArray:
    """Return the norms (8,) of matrices in the metric of a positive definite weight; infinite if it is none."""
    values, vectors = np.linalg.eigh(weight)
    if values[0] <= 0.0:
        return np.full(len(matrices), np.inf)
    root = vectors * np.sqrt(values) @ vectors.T
    inverse = vectors / np.sqrt(values) @ vectors.T
    norms: FloatArray = np.linalg.norm(root @ matrices @ inverse, ord=2, axis=(1, 2))
    return norms


def peak_gain(closed: FloatArray, inputs: FloatArray) -> FloatArray:
    """Return the largest gain (8,) from d to e of e' = A_i e + B_i d, over frequencies from 0 to 1,000 rad/s."""
    size = np.eye(closed.shape[-1])
    gains = [
        np.linalg.norm(np.linalg.solve(1j * frequency * size - closed, inputs.astype(complex)), ord=2, axis=(1, 2))
        for frequency in (0.0, *np.logspace(-3.0, 3.0, 300))
    ]
    peak: FloatArray = np.max(gains, axis=0)
    return peak
