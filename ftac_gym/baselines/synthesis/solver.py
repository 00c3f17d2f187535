"""Matrix inequalities handed to CVXPY and Clarabel."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from importlib import import_module
from typing import Any

from ftac_gym.utils.extras import require_extra

Groups = Mapping[str, Sequence[Any]]
"""Constraints by their purpose."""


def cvxpy() -> Any:
    """Return the CVXPY module; raise a MissingExtra without it or its solver."""
    require_extra("cvxpy", "clarabel")
    return import_module("cvxpy")


def negative(matrix: Any) -> Any:
    """Return the constraint that a matrix, symmetric up to rounding, is negative definite."""
    return matrix + matrix.T << 0


def minimised(objective: Any, groups: Groups) -> bool:
    """Minimise under all constraints, and return whether there is a result, which the caller certifies.

    Clarabel alone: first-order solvers report points as optimal that are far from it.
    """
    module = cvxpy()
    problem = module.Problem(module.Minimize(objective), [item for group in groups.values() for item in group])
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # "inaccurate": judged by the certificate
            problem.solve(solver=module.CLARABEL)
    except module.error.SolverError:
        return False
    return problem.status in ("optimal", "optimal_inaccurate")


def unsolvable(objective: Any, groups: Groups, field: str, value: object) -> ValueError:
    """Return the error of a problem without a solution, with the constraints whose removal gives one."""
    excluding = [
        name for name in groups if minimised(objective, {other: groups[other] for other in groups if other != name})
    ]
    where = " or without ".join(excluding)
    rule = f"it has one without {where}" if excluding else "whichever of its constraints is left out"
    return ValueError(f"{field} must leave a solution, which there is not: {rule}; got {value!r}")
