"""A fuzzy logic system whose one adaptive number bounds the squared weights of all its rules."""

from __future__ import annotations

import numpy as np

from ftac_gym.baselines.components.adaptation import LeakyAdaptation
from ftac_gym.baselines.components.radial_basis import GaussianNodes
from ftac_gym.baselines.components.rows import dot
from ftac_gym.baselines.memory import Memory
from ftac_gym.utils.parameters import FloatArray, fields_named, positive, whole


class FuzzyApproximator:
    """theta P'P s / (2 h^2) with theta' = lambda ``|s|^2`` P'P / (2 h^2) - m1 theta.

    Eqs. (18), (42), (45) of Chen et al. 2018.

    P are the normalised memberships (18) of N rules, Gaussians of width 1 whose centres lie on the diagonal from -3 to
    3: neither is printed. All three axes have the same inputs, so that eta = P'P I. The choice of rules has little
    effect, since only P'P enters, which lies between 1/N and 1.

    Parameters
    ----------
    memory
        Store of theta.
    inputs
        Number of inputs.
    gain
        lambda; zero switches the system off.
    leak
        m1 [1/s].
    width
        h.
    period
        Control period [s].
    rules
        N.

    Raises
    ------
    ValueError
        If a value breaks a rule.
    """

    def __init__(
        self, memory: Memory, inputs: int, gain: float, leak: float, width: float, period: float, rules: int = 7
    ) -> None:
        self._nodes = GaussianNodes(whole(rules, 1, "rules"), 3.0, inputs, 1.0)
        self._half = 0.5 / positive(width, "fuzzy_width") ** 2
        with fields_named("fuzzy_"):
            self._bound = LeakyAdaptation(memory, "weight_bound", 1, gain, leak, period)
        self._active = gain > 0.0

    def memberships(self, inputs: FloatArray) -> FloatArray:
        """Return P (N, rules) for inputs (N, inputs)."""
        exponents = self._nodes.exponents(inputs)
        # Relative to the largest: far from all centres every Gaussian underflows, but not their shares.
        weights = np.exp(exponents - exponents.max(axis=1, keepdims=True))
        shares: FloatArray = weights / weights.sum(axis=1, keepdims=True)
        return shares

    def __call__(self, variable: FloatArray, *inputs: FloatArray) -> FloatArray:
        """Return theta P'P s / (2 h^2) (N, 3) for s (N, 3), then adapt."""
        if not self._active:
            return np.zeros_like(variable)
        shares = self.memberships(np.concatenate(inputs, axis=1))
        weight = self._half * dot(shares, shares)
        robust: FloatArray = self._bound.value * weight * variable
        self._bound.update(weight * dot(variable, variable))
        return robust
