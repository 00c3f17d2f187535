"""Matrix inequalities handed to CVXPY and Clarabel."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from typing import Any

Groups = Mapping[str, Sequence[Any]]
"""Constraints by what they are for."""


def cvxpy() -> Any:
    """Return the CVXPY module, or say what to install."""
    try:
        import cvxpy as module
    except ImportError:
        raise ImportError("solving matrix inequalities needs CVXPY and Clarabel: pip install 'ftac-gym[lmi]'") from None
    return module


def negative(matrix: Any) -> Any:
    """Return the constraint that a matrix, symmetric but for rounding, is negative definite."""
    return matrix + matrix.T << 0


def minimised(objective: Any, groups: Groups) -> bool:
    """Minimise under all constraints, and return whether there is anything to be had: its worth is to be certified.

    Clarabel alone: first-order solvers call points optimal that are far from it.
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
    """Return the error of a problem without a solution: which of its constraints, left out alone, leave it one."""
    blamed = [
        name for name in groups if minimised(objective, {other: groups[other] for other in groups if other != name})
    ]
    where = " or without ".join(blamed)
    rule = f"it has one without {where}" if blamed else "whichever of its constraints is left out"
    return ValueError(f"{field} must leave a solution, which there is not: {rule}; got {value!r}")
