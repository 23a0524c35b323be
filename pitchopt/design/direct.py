"""The convex subproblem of one problem as cone data, handed to Clarabel directly.

Around a profile beta0, inside a box [low, high] of pitch per station,

    maximise   a sum_n t_n / m + (rate terms) - sum_l lambda_l s_l - kappa sum_n u_n - rho . slack
    subject to rate limits, box, torque limits, blade cap, mean pitch, Fourier basis,

one profile and one set of curves from :mod:`pitchopt.design.blocks`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pitchopt.design.blocks import CurveBlock, ProfileBlock, bend
from pitchopt.design.cones import ConeProgram
from pitchopt.design.linear import LinearModel, torque_lines
from pitchopt.design.multipliers import Multipliers
from pitchopt.design.problem import DesignProblem, Objective

__all__ = ["LinearModel", "Subproblem", "SubproblemSolution", "torque_lines"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]


@dataclass(frozen=True, kw_only=True, eq=False)
class SubproblemSolution:
    """Profile, model value [N m], multipliers and the solver's own word on them."""

    profile: FloatArray
    value: float
    multipliers: Multipliers
    status: str
    solved: bool
    iterations: int
    solve_seconds: float


class Subproblem:
    """The subproblem of one design problem; :meth:`solve` fills in numbers and solves it."""

    def __init__(self, problem: DesignProblem) -> None:
        self.problem = problem

    def solve(
        self,
        point: FloatArray,
        objective: Objective,
        *,
        low: FloatArray,
        high: FloatArray,
        penalty: tuple[float, float] = (0.0, 0.0),
        segments: IntArray | None = None,
        tight: bool = False,
        chord: float = 0.0,
        multipliers: Multipliers | None = None,
    ) -> SubproblemSolution:
        """Solve around ``point`` inside the box.

        Parameters
        ----------
        point : array (N,)
            beta0 [rad].
        objective : Objective
        low, high : array (N,)
            Box of the profile [rad]; cut at the pitch limits.
        penalty : (float, float)
            Exact-penalty weights of the torque limits [-] and of the blade cap [-].
        segments : int array (N,), optional
            Segments that the box stays on: torque is affine there, like the loads.  By default
            the loads are modelled by the segments that hold ``point``, torque by all in reach.
        tight : bool
            Scale by the loads' own size and accept less accuracy: the fallback.
        chord : float
            Half-width [rad] over which the curvature of the loads is taken; zero for none.
        multipliers : Multipliers, optional
            With a chord: the curvature of the loads, weighted by these, enters the objective
            where it is convex, as in sequential quadratic programming.
        """
        curves = self.problem.curves
        low, high = np.maximum(low, curves.lower), np.minimum(high, curves.upper)
        model = LinearModel(self.problem, point, segments, low, high, chord)
        program = ConeProgram()
        if model.curvature is not None and multipliers is not None:
            program.quadratic = bend(model, multipliers) * model.radius**2
        profile = ProfileBlock(program, self.problem, point, low, high, model.radius)
        block = CurveBlock(program, profile, model, objective, tight=tight)
        if objective.travel > 0:
            profile.add_travel(program)
        for columns, values in block.costs:
            program.add_cost(columns, values)
        profile.constrain(program)
        block.constrain(program, penalty)
        solution = program.solve(reduced=tight)
        x = solution.x if solution.solved else np.zeros(program.width)
        z = solution.z if solution.solved else np.zeros(program.height)
        value = block.constant - program.value(x)
        if objective.travel > 0 and not solution.solved:
            value = -np.inf
        return SubproblemSolution(
            profile=profile.profile(x),
            value=value,
            multipliers=replace(
                block.multipliers(z),
                rate=profile.rate(z),
                mean=profile.mean(z),
                basis=profile.basis(z),
            ),
            status=solution.status,
            solved=solution.solved,
            iterations=solution.iterations,
            solve_seconds=solution.seconds,
        )
