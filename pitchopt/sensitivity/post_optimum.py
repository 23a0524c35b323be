"""Estimates of how an optimal value changes with a frozen parameter, from one solved problem.

For  min or max f(x, c)  s.t.  g(x, c) <= 0, h(x, c) = 0 and cones, solved at c_r with optimum x*
and multipliers lambda*, the change of the optimal value for a change dc is, with x* and lambda*
frozen,

    first-order    dz = grad_c L(x*, c_r, lambda*) . dc
    high-order     dz = L(x*, c_r + dc, lambda*) - L(x*, c_r, lambda*)

L = f + lambda . g + nu . h for a minimum and f - lambda . g - nu . h for a maximum, lambda >= 0.
The first is exact as dc -> 0 (envelope theorem); for a minimum that is jointly convex in (x, c) it
is a lower bound of the change, for a maximum jointly concave an upper bound.  The second keeps
how f and g curve in c, and is exact if L is linear in x, x and c do not couple and the active set
stays.  What looks broken of that is reported with every estimate.

References: J. Iori, C. L. Bottasso, M. K. McWilliam, eqs. (8) and (9); E. Castillo, R. Minguez,
C. Castillo, Reliab. Eng. Syst. Saf. 93, 2008.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pitchopt.checks import FloatArray
from pitchopt.errors import InputError
from pitchopt.sensitivity import assumptions as judging
from pitchopt.sensitivity.estimate import Estimate, Thresholds
from pitchopt.sensitivity.functions import Function, FunctionModel, GradientsOf, parameter_array
from pitchopt.sensitivity.local import (
    Local,
    check_optimum,
    rows_without_gradients,
)
from pitchopt.sensitivity.model import Counts, Model, Values
from pitchopt.sensitivity.rows import listed
from pitchopt.sensitivity.table import TableModel

__all__ = ["PostOptimum"]


class PostOptimum:
    """A solved problem, ready for estimates.

    Made by `from_functions`, `from_table` or `from_cvxpy`.

    Parameters
    ----------
    model : Model
    thresholds : Thresholds, optional
        Of the verdicts.
    """

    def __init__(self, model: Model, *, thresholds: Thresholds | None = None) -> None:
        self._model = model
        self._thresholds = thresholds or Thresholds()
        self._start = model.values(model.reference)
        self._local: Local | None = None
        gradients = model.gradients(model.reference)
        if gradients is not None:
            self._local = Local(model, self._start, gradients, self._thresholds)
        if self._local is None:
            self._rows = rows_without_gradients(model, self._start, self._thresholds)
        else:
            self._rows = self._local.rows
            smooth = isinstance(model, FunctionModel)
            check_optimum(self._local, model, self._start, self._thresholds.wrong, smooth=smooth)

    @classmethod
    def from_functions(
        cls,
        f: Function,
        g: Function | None = None,
        h: Function | None = None,
        *,
        x: ArrayLike,
        c: ArrayLike,
        multipliers: ArrayLike | None = None,
        equality_multipliers: ArrayLike | None = None,
        sense: Literal["min", "max"] = "min",
        names: str | Sequence[str] | None = None,
        equality_names: str | Sequence[str] | None = None,
        c_gradients: GradientsOf | None = None,
        x_gradients: GradientsOf | Literal["differences", "none"] = "differences",
        step: float | None = None,
        x_scale: ArrayLike | None = None,
        thresholds: Thresholds | None = None,
    ) -> PostOptimum:
        """From functions of (x, c).

        A point is evaluated once, however often it is needed; `evaluations` counts.

        Parameters
        ----------
        f, g, h : callable
            (x, c) -> number, (m,) at most zero, (p,) equal to zero.  x arrives as (n,), c as a
            float if the reference is a number, otherwise in its shape.
        x : (n,) array_like
            Optimum x*.
        c : number or array_like
            Reference c_r, of any shape.
        multipliers : (m,) array_like
            lambda >= 0 of g.
        equality_multipliers : (p,) array_like
            nu of h.
        sense : {"min", "max"}
        names, equality_names : str or sequence of str, optional
            Of the rows of g and h: one each, or one that is numbered.
        c_gradients : callable, optional
            (x, c) -> gradients in c of f (k,), g (m, k), h (p, k), for those given, not checked;
            without it, differences along dc whose step is checked, three or more evaluations a
            direction.
        x_gradients : callable, "differences" or "none"
            (x, c) -> gradients in x of f (n,), g (m, n), h (p, n).  Differences take 4 n
            evaluations at c_r and at every dc; "none" evaluates no other x and leaves the
            assumptions that need them unjudged.
        step : float, optional
            Prescribed length of a forward step in c for first_order: one evaluation a direction,
            none if that dc is estimated too, and no estimate of its error.
        x_scale : (n,) array_like, optional
            Sizes of the variables; otherwise their absolute values, and where these are below
            1e-12 of the largest the size of that.
        thresholds : Thresholds, optional

        Raises
        ------
        InputError
            If something does not fit together, or x and the multipliers are no optimum.
        ComputationError
            If differences do not settle.
        """
        model = FunctionModel(
            f, g, h, x=x, c=c, sense=sense, multipliers=multipliers,
            equality_multipliers=equality_multipliers, names=names, equality_names=equality_names,
            c_gradients=c_gradients, x_gradients=x_gradients, step=step, x_scale=x_scale,
        )  # fmt: skip
        return cls(model, thresholds=thresholds)

    @classmethod
    def from_table(
        cls,
        dcs: ArrayLike,
        f: ArrayLike,
        g: ArrayLike | None = None,
        h: ArrayLike | None = None,
        *,
        multipliers: ArrayLike | None = None,
        equality_multipliers: ArrayLike | None = None,
        c: ArrayLike = 0.0,
        sense: Literal["min", "max"] = "min",
        names: str | Sequence[str] | None = None,
        equality_names: str | Sequence[str] | None = None,
        step: float | None = None,
        thresholds: Thresholds | None = None,
    ) -> PostOptimum:
        """From values at (x*, c_r + dc) alone; nothing is evaluated.

        Parameters
        ----------
        dcs : (K,) or (K, ...) array_like
            Changes of c, one of them zero.
        f : (K,) array_like
        g : (K, m) array_like
            At most zero.
        h : (K, p) array_like
            Equal to zero.
        multipliers, equality_multipliers : array_like
            lambda >= 0 (m,) and nu (p,).
        c : number or array_like
            Reference c_r.
        sense, names, equality_names, thresholds
            As in `from_functions`.
        step : float, optional
            Length of the dc of the table that first_order is taken with; otherwise the two
            shortest of the direction of dc, extrapolated.

        Raises
        ------
        InputError
            If something does not fit together; later, for a dc that is not in the table.
        """
        model = TableModel(
            dcs, f, g, h, c=c, sense=sense, multipliers=multipliers,
            equality_multipliers=equality_multipliers, names=names, equality_names=equality_names,
            step=step,
        )  # fmt: skip
        return cls(model, thresholds=thresholds)

    @classmethod
    def from_cvxpy(
        cls,
        problem: Any,
        parameter: Any,
        *,
        names: Mapping[Any, str] | Sequence[str] | None = None,
        x_scale: Mapping[Any, ArrayLike] | None = None,
        thresholds: Thresholds | None = None,
    ) -> PostOptimum:
        """From a solved cvxpy problem; it is not solved again and left as it was.

        Later changes of the problem's values do not reach the estimates.

        Parameters
        ----------
        problem : cvxpy.Problem
            Convex (DCP; it need not be DPP), solved to optimality by a solver that gives duals.
        parameter : cvxpy.Parameter
            Of any shape, with its value c_r.
        names : mapping of constraint to str, or sequence of str, optional
            Of the constraints; cvxpy's own labels or texts otherwise.
        x_scale : mapping of variable to array_like, optional
            Sizes of variables; otherwise the absolute values at the optimum, and where these are
            below 1e-5 of the largest entry of the same variable, as a solver leaves zeros, its
            size; of a variable below 1e-7 that of the largest of all.
        thresholds : Thresholds, optional

        Raises
        ------
        InputError
            If the problem is not solved, not convex or has no duals, or the parameter is not its.
        """
        from pitchopt.sensitivity.convex import ConvexModel

        model = ConvexModel(problem, parameter, names=names, x_scale=x_scale)
        return cls(model, thresholds=thresholds)

    @property
    def reference(self) -> float:
        """Optimal value z* at c_r."""
        return self._model.sense * self._start.objective

    @property
    def evaluations(self) -> Counts:
        """Evaluations so far."""
        return self._model.counts

    @property
    def stationarity(self) -> float | None:
        """Norm of grad_x L over that of grad_x f, scaled; None without gradients."""
        return None if self._local is None else self._local.stationarity

    def estimates(
        self,
        dcs: Sequence[ArrayLike] | NDArray[np.float64],
        *,
        check_feasible: bool = True,
        judge: bool = True,
    ) -> tuple[Estimate, ...]:
        """An estimate for each dc; derivatives are taken where dc is smallest."""
        changes = [self._change(dc) for dc in dcs]
        if self._model.keeps_slopes:
            for i in np.argsort([np.linalg.norm(dc) for dc in changes], kind="stable"):
                self._model.slope(changes[i])
        return tuple(
            self.estimate(dc, check_feasible=check_feasible, judge=judge) for dc in changes
        )

    def estimate(
        self, dc: ArrayLike, *, check_feasible: bool = True, judge: bool = True
    ) -> Estimate:
        """Estimated change of the optimal value.

        Parameters
        ----------
        dc : number or array_like
            Change of the parameter, of its shape.
        check_feasible : bool
            Where the old design violates constraints at c_r + dc and the predicted one does not
            repair them, ask whether any design does: a convex feasibility problem for cvxpy, a
            linear program to first order for functions, nothing for a table.
        judge : bool
            Judge the assumptions and whether the change can be met at all; without it numbers
            alone, some times faster.

        Raises
        ------
        InputError
            If dc has another shape, leaves the domain of the functions or the attributes of the
            parameter, or leaves constraints that cannot be met.
        ComputationError
            If differences or the feasibility problem fail.
        """
        change = self._change(dc)
        model, start, sense = self._model, self._start, self._model.sense
        c = model.reference + change
        there = model.values(c)
        slope = model.slope(change)
        lam, layout = model.multipliers, model.layout
        first_rows = sense * layout.sums(lam * slope.entries)
        high_rows = sense * layout.sums(lam * (there.entries - start.entries))
        first_f = sense * slope.objective
        high_f = sense * (there.objective - start.objective)
        high = high_f + float(np.sum(high_rows))
        if judge:
            parts = self._judged(c, there, high, check_feasible)
        else:
            parts = self._not_judged("it was not asked for")
        for array in (change, first_rows, high_rows):
            array.setflags(write=False)
        return Estimate(
            dc=change,
            reference=self.reference,
            first_order=first_f + float(np.sum(first_rows)),
            high_order=high,
            first_order_error=slope.error,
            step=slope.step,
            row_first_order=first_rows,
            row_high_order=high_rows,
            row_multipliers=layout.multiplier(lam),
            objective_first_order=first_f,
            objective_high_order=high_f,
            layout=layout,
            **parts,
        )

    # -- inside ---------------------------------------------------------------------------------

    def _change(self, dc: ArrayLike) -> NDArray[np.float64]:
        change = parameter_array("dc", dc)
        if change.shape != self._model.reference.shape:
            raise InputError(
                f"dc: got shape {change.shape}, expected {self._model.reference.shape} as the "
                "parameter"
            )
        return change

    def _judged(
        self, c: NDArray[np.float64], there: Values, high: float, check_feasible: bool
    ) -> dict[str, Any]:
        model, local, limits = self._model, self._local, self._thresholds
        if local is None:
            parts = self._not_judged("there are no gradients in x")
            parts["active_set"] = judging.active_set(model, self._rows, there, limits)
            if check_feasible:
                self._feasible(c, there)
            return parts
        step, left_over = local.step(there.entries - self._start.entries)
        moved = self._moved(c, step)
        attained = None if moved is None else self._attained(moved)
        if check_feasible and attained is None:
            self._feasible(c, there)
        step.setflags(write=False)
        return {
            "active_set": judging.active_set(
                model, self._rows, there, limits, local=local, step=step, left_over=left_over
            ),
            "coupling": judging.coupling(local, model.gradients(c), limits),
            "linearity": judging.linearity(model, local, self._start, step, moved, high, limits),
            "stationarity": judging.stationarity(local, limits),
            "attained": attained,
            "predicted_step": step,
        }

    def _not_judged(self, reason: str) -> dict[str, Any]:
        limits = self._thresholds
        return {
            "active_set": judging.not_judged(judging.A3, reason, 0.0),
            "coupling": judging.not_judged(judging.A2, reason, limits.coupling),
            "linearity": judging.not_judged(judging.A1, reason, limits.linearity),
            "stationarity": judging.not_judged(judging.KKT, reason, limits.stationarity),
            "attained": None,
        }

    def _exceeds(self, values: Values) -> bool:
        """Whether a row is above its limit, and more so than at x* and c_r."""
        excess = self._model.layout.excess(values.entries) / self._rows.length
        allowed = np.maximum(-self._rows.distance, 0.0) + self._thresholds.feasible
        return bool((excess > allowed).any())

    def _moved(self, c: NDArray[np.float64], step: FloatArray) -> Values | None:
        try:
            return self._model.values(c, step)
        except InputError:  # the predicted design is outside the domain of the functions
            return None

    def _attained(self, moved: Values) -> float | None:
        if self._exceeds(moved):
            return None
        return float(self._model.sense * (moved.objective - self._start.objective))

    def _feasible(self, c: NDArray[np.float64], there: Values) -> None:
        if not self._exceeds(there):
            return
        unmet = self._model.unmet(c, self._thresholds.feasible)
        if unmet is not None and unmet.names:
            note = f" {unmet.note}" if unmet.note else ""
            raise InputError(
                f"dc: with {(c - self._model.reference).tolist()} no design meets all "
                f"constraints{note}; in the way: {listed(unmet.names)}; expected a smaller dc"
            )
