"""The quadratic programs that show what the estimators rest on: true optimum beside both estimates.

    min over x   y' P y + q' y + z0,   y = (x, c)
    s.t.         G x <= g2 c^2 + g1 c + g0,     H x <= h0

with x of two entries, z0 such that the optimum at c = 0 is zero, and dc from 0 to 1.  There is no
one half before P.  Reference: J. Iori, C. L. Bottasso, M. K. McWilliam, appendix C.  Two remarks on
its numbers.  (C4) prints h0 = 0, which binds at c = 0; the text's switch of constraints at c = 0.2
asks for h0 = 2, which is used here.  In (C2) the first constraint binds for b = 0.1 alone: its
minimiser without it is x1 = 5 / b, inside for b = 20 and on the limit with a multiplier of zero for
b = 5, so that both estimates are zero there.  With one half before P that would be 10 / b: inside
for b = 20 still, with a multiplier of 5 for b = 5 (`halved`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from pitchopt.checks import FloatArray, finite_array, finite_number
from pitchopt.errors import ComputationError, InputError
from pitchopt.sensitivity import Estimate, PostOptimum

__all__ = [
    "OptimumCurve",
    "QuadraticProgram",
    "active_set_program",
    "coupling_programs",
    "estimated_curve",
    "linearity_programs",
    "quadratic_record",
]

ACCURATE = {"tol_gap_abs": 1e-10, "tol_gap_rel": 1e-10, "tol_feas": 1e-10}
POINTS = 51


@dataclass(frozen=True, kw_only=True)
class QuadraticProgram:
    """A program of the module's form.

    Parameters
    ----------
    name : str
    P : (3, 3) array_like
        Symmetric; its block of x positive semidefinite.
    q : (3,) array_like
    G : (2,) array_like
    g : (3,) array_like
        g2, g1, g0.
    H : (2,) array_like or None
    h0 : float

    Raises
    ------
    InputError
        If P is not symmetric, or not positive semidefinite in x.
    """

    name: str
    P: FloatArray
    q: FloatArray
    G: FloatArray
    g: FloatArray
    H: FloatArray | None = None
    h0: float = 0.0

    def __post_init__(self) -> None:
        for key, shape in (("P", (3, 3)), ("q", (3,)), ("G", (2,)), ("g", (3,))):
            object.__setattr__(self, key, finite_array(key, getattr(self, key), shape=shape))
        if self.H is not None:
            object.__setattr__(self, "H", finite_array("H", self.H, shape=(2,)))
        object.__setattr__(self, "h0", finite_number("h0", self.h0))
        if not np.allclose(self.P, self.P.T):
            raise InputError("P: expected a symmetric matrix")
        least = float(np.linalg.eigvalsh(self.P[:2, :2])[0])
        if least < -1e-12:
            raise InputError(
                f"P: the block of x has the eigenvalue {least:.3g}, expected none below zero"
            )

    def halved(self) -> QuadraticProgram:
        """The same with one half before P."""
        return replace(self, P=0.5 * self.P)

    def objective(self, x1: ArrayLike, x2: ArrayLike, c: float) -> FloatArray:
        """Objective without z0 over a plane, of the shape of x1 and x2."""
        x1, x2 = np.broadcast_arrays(np.asarray(x1, dtype=float), np.asarray(x2, dtype=float))
        y = np.stack([x1, x2, np.full(x1.shape, float(c))], axis=-1)
        return np.asarray(np.einsum("...i,ij,...j->...", y, self.P, y) + y @ self.q)

    def limit(self, c: float) -> float:
        """What G x is at most."""
        g2, g1, g0 = self.g
        return float(g2 * c**2 + g1 * c + g0)

    def problem(self) -> tuple[Any, Any, Any]:
        """cvxpy problem, its parameter c at zero, and x."""
        import cvxpy as cp

        x = cp.Variable(2, name="x")
        c = cp.Parameter(name="c", value=0.0)
        # c^2 as a parameter of its own, so that cvxpy compiles the problem once
        square = cp.CallbackParam(callback=lambda: c.value**2)
        f = cp.quad_form(x, self.P[:2, :2]) + 2.0 * c * (self.P[:2, 2] @ x) + self.q[:2] @ x
        f += self.P[2, 2] * square + self.q[2] * c
        constraints = [self.G @ x <= self.g[0] * square + self.g[1] * c + self.g[2]]
        if self.H is not None:
            constraints.append(self.H @ x <= self.h0)
        return cp.Problem(cp.Minimize(f), constraints), c, x


@dataclass(frozen=True, kw_only=True)
class OptimumCurve:
    """Change of the optimum over dc: re-solved, and estimated from dc = 0 alone.

    Attributes
    ----------
    program : QuadraticProgram
    dc : (K,) ndarray
    truth : (K,) ndarray
        Of re-solved problems.
    designs : (K, 2) ndarray
        Their x.
    estimates : tuple of Estimate
    """

    program: QuadraticProgram
    dc: FloatArray
    truth: FloatArray
    designs: FloatArray
    estimates: tuple[Estimate, ...]

    @property
    def name(self) -> str:
        """That of the program."""
        return self.program.name

    @property
    def first_order(self) -> FloatArray:
        """First-order estimates (K,)."""
        return np.array([estimate.first_order for estimate in self.estimates])

    @property
    def high_order(self) -> FloatArray:
        """High-order estimates (K,)."""
        return np.array([estimate.high_order for estimate in self.estimates])

    @property
    def broken(self) -> tuple[tuple[str, float], ...]:
        """Assumptions that look broken somewhere, with the first dc where they do."""
        found: dict[str, float] = {}
        for dc, estimate in zip(self.dc, self.estimates, strict=True):
            for assumption in estimate.broken:
                found.setdefault(assumption.name, float(dc))
        return tuple(found.items())


def linearity_programs(b: Sequence[float] = (20.0, 5.0, 0.1)) -> tuple[QuadraticProgram, ...]:
    """(C2): the objective curves in x, the more the larger b."""
    return tuple(
        QuadraticProgram(
            name=f"b = {value:g}",
            P=np.diag([value, value, 0.0]),
            q=np.array([-10.0, 1.0, 0.0]),
            G=np.array([1.0, 0.0]),
            g=np.array([-4.0, 3.0, 1.0]),
        )
        for value in b
    )


def coupling_programs(b: Sequence[float] = (10.0, 5.0, 0.1)) -> tuple[QuadraticProgram, ...]:
    """(C3): the objective couples x2 and c, the more the larger b."""
    return tuple(
        QuadraticProgram(
            name=f"b = {value:g}",
            P=np.array([[0.1, 0.0, 0.0], [0.0, 0.1, -value], [0.0, -value, 0.0]]),
            q=np.array([-10.0, 0.0, 0.0]),
            G=np.array([1.0, 0.0]),
            g=np.array([-5.0, 6.0, 1.0]),
        )
        for value in b
    )


def active_set_program(h0: float = 2.0) -> QuadraticProgram:
    """(C4): a constraint that does not depend on c becomes active at c = 0.2 (for h0 = 2)."""
    return QuadraticProgram(
        name="a second constraint",
        P=np.diag([0.1, 0.1, 0.0]),
        q=np.array([-5.0, 5.0, 0.0]),
        G=np.array([1.0, 0.0]),
        g=np.array([-5.0, 6.0, 1.0]),
        H=np.array([1.0, 0.0]),
        h0=h0,
    )


def estimated_curve(program: QuadraticProgram, dc: ArrayLike | None = None) -> OptimumCurve:
    """Both estimates from the optimum at c = 0 beside re-solved optima.

    Parameters
    ----------
    program : QuadraticProgram
    dc : (K,) array_like, optional
        0 to 1 otherwise.

    Raises
    ------
    InputError
        If a dc leaves no design.
    ComputationError
        If a program is not solved.
    """
    changes = finite_array("dc", np.linspace(0.0, 1.0, POINTS) if dc is None else dc)
    problem, c, x = program.problem()
    start = _solved(problem, program, 0.0)
    names = ["G x <= limit(c)", "H x <= h0"][: len(problem.constraints)]
    estimates = PostOptimum.from_cvxpy(problem, c, names=names).estimates(changes)
    truth, designs = np.zeros(changes.size), np.zeros((changes.size, 2))
    for i, value in enumerate(changes):
        c.value = float(value)
        truth[i] = _solved(problem, program, float(value)) - start
        designs[i] = x.value
    for array in (truth, designs):
        array.setflags(write=False)
    return OptimumCurve(
        program=program, dc=changes, truth=truth, designs=designs, estimates=estimates
    )


def quadratic_record(curve: OptimumCurve) -> dict[str, Any]:
    """A curve as plain data."""
    return {
        "name": curve.name,
        "dc": curve.dc,
        "truth": curve.truth,
        "first_order": curve.first_order,
        "high_order": curve.high_order,
        "broken": dict(curve.broken),
    }


def _solved(problem: Any, program: QuadraticProgram, value: float) -> float:
    import cvxpy as cp

    try:
        problem.solve(solver=cp.CLARABEL, **ACCURATE)
    except cp.error.SolverError as error:
        raise ComputationError(f"{program.name} at c = {value:g}: {error}") from error
    if problem.status != cp.OPTIMAL:
        raise ComputationError(f"{program.name} at c = {value:g}: {problem.status}")
    return float(problem.value)
