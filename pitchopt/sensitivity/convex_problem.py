"""What a cvxpy problem has to be for its duals to tell anything; whether functions are defined."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pitchopt.errors import InputError
from pitchopt.sensitivity.model import solid

__all__ = ["checked_problem", "domain_conditions", "in_domain"]

ADVICE = {
    "infeasible": "there is no optimum to start from; relax what cannot be met and solve again",
    "infeasible_inaccurate": "there is no optimum to start from",
    "unbounded": "there is no optimum to start from; bound the variables and solve again",
    "unbounded_inaccurate": "there is no optimum to start from; bound the variables",
    "optimal_inaccurate": "multipliers of an inaccurate solution mislead; tighten or change the "
    "solver and solve again",
}
DOMAIN = 1e-7


def checked_problem(problem: Any, parameter: Any) -> None:
    """`InputError` unless the problem is convex, solved, and has this parameter."""
    import cvxpy as cp

    if not isinstance(problem, cp.Problem):
        raise InputError(f"problem: got {type(problem).__name__}, expected a cvxpy.Problem")
    if not isinstance(parameter, cp.Parameter):
        raise InputError(f"parameter: got {type(parameter).__name__}, expected a cvxpy.Parameter")
    if hasattr(parameter, "_callback"):
        raise InputError(
            "parameter: got a CallbackParam, whose value cannot be set; expected the parameter "
            "that it is computed from"
        )
    if not any(p is parameter for p in _all_parameters(problem)):
        have = ", ".join(p.name() for p in problem.parameters()) or "none"
        raise InputError(
            f"parameter: {parameter.name()} is not in the problem, whose parameters are: {have}"
        )
    _checked_leaves(problem, parameter)
    if problem.is_mixed_integer():
        raise InputError(
            "problem: has integer or boolean variables, whose solutions have no duals; fix them "
            "and solve the continuous problem"
        )
    if not problem.is_dcp():
        raise InputError(
            "problem: is not convex by the rules of cvxpy (not DCP), so its multipliers bound "
            "nothing; write it as a convex problem or use from_functions"
        )
    _checked_status(problem)


def _checked_leaves(problem: Any, parameter: Any) -> None:
    if parameter.sparse_idx is not None or parameter.is_complex():
        raise InputError(
            f"parameter: {parameter.name()} is sparse or complex, expected a real, dense parameter"
        )
    for variable in problem.variables():
        if variable.is_complex():
            raise InputError(
                f"problem: variable {variable.name()} is complex; write real and imaginary parts"
            )
        if variable.sparse_idx is not None or len(variable.shape) > 2:
            raise InputError(
                f"problem: variable {variable.name()} is sparse or has more than two dimensions; "
                "use a dense vector or matrix"
            )


def _checked_status(problem: Any) -> None:
    status = problem.status
    if status is None:
        raise InputError("problem: is not solved; call problem.solve() first")
    if status != "optimal":
        advice = ADVICE.get(status, "solve it to optimality first")
        raise InputError(f"problem: its status is {status}, expected optimal: {advice}")
    for leaf in [*problem.parameters(), *problem.variables()]:
        if leaf.value is None:
            raise InputError(
                f"problem: {leaf.name()} has no value; set the parameters and solve it again"
            )


def _all_parameters(problem: Any) -> list[Any]:
    """Parameters of the problem and of the bounds of its variables."""
    found = list(problem.parameters())
    for variable in problem.variables():
        for bound in variable.bounds or ():
            if hasattr(bound, "parameters"):
                found += bound.parameters()
    return found


def domain_conditions(expression: Any) -> list[Any]:
    """Constraints under which the functions in an expression are defined.

    Without those that are attributes of variables, which are constraints of the problem.
    """
    if not expression.args:
        return []
    own = list(getattr(expression, "_domain", list)())
    return own + [found for part in expression.args for found in domain_conditions(part)]


def in_domain(conditions: Sequence[tuple[Any, str]], dc: NDArray[np.float64]) -> None:
    """`InputError` if a function is evaluated outside its domain at the present values."""
    for condition, name in conditions:
        violation = float(np.max(np.asarray(condition.violation()), initial=0.0))
        size = max((_size(arg) for arg in condition.args), default=0.0)
        if not violation <= DOMAIN * max(size, 1.0):
            raise InputError(
                f"dc: with {dc.tolist()} {name} leaves the domain of its functions ({condition} "
                f"is off by {violation:.3g}); expected a smaller dc"
            )


def _size(expression: Any) -> float:
    return float(np.max(np.abs(solid(expression.value)), initial=0.0))
