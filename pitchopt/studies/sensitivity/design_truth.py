"""A pitch design solved again with a parameter changed: the truth that estimates stand beside.

Local solves find local optima.  So the changed problem is solved from the present design and from
each of the starts that `pitchopt.design` uses, in full, and the best counts.  Where that is
another optimum than the one that the present design moves to, the change of the value is not all
the parameter's doing, and the present problem is solved from there as well: what it gains is taken
off, so that

    truth = best value with the change - best value known without it.

Torque limit, cap on the blade load and the mean pitch of a frozen wake are held as numbers.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pitchopt.checks import FloatArray
from pitchopt.design.constant_pitch import best_constant
from pitchopt.design.goals import power_max
from pitchopt.design.points import PointFinder
from pitchopt.design.results import LocalSolution, Status
from pitchopt.design.scp import solve_local
from pitchopt.design.search import Start, valued
from pitchopt.errors import InfeasibleError, InputError

if TYPE_CHECKING:
    from pitchopt.design.problem import DesignProblem, Objective
    from pitchopt.studies.sensitivity.design_point import Changed, DesignPoint

__all__ = ["Truth", "resolved"]

_ROUNDING = 3e-8  # share of the largest torque, or of the RMS, that a local solve leaves
_SAME = 5e-6  # the same within which optima count as equal
_RELEVANT = 5e-3  # share of the change, as well


@dataclass(frozen=True, kw_only=True, eq=False)
class Truth:
    """The changed problem, solved again.

    Attributes
    ----------
    change : float
        Of the optimal value [N m].
    near : float
        The same of the optimum that the present design moves to alone [N m].
    profile : ndarray (N,)
        The best profile with the change [rad].
    moved : float
        Largest change of pitch against the present design [rad].
    start : str
        From where it was found.
    other : bool
        True where it is another optimum than the one that the present design moves to.
    missed : float
        What the present design turned out to be below the best known of its own problem [N m].
    status : Status
    """

    change: float
    near: float
    profile: FloatArray
    moved: float
    start: str
    other: bool
    missed: float
    status: Status


def resolved(
    point: DesignPoint,
    changed: Changed,
    *,
    starts: int = 5,
    seed: int = 0,
    warm: FloatArray | None = None,
) -> Truth:
    """Solve a changed problem.

    Parameters
    ----------
    point : DesignPoint
    changed : Changed
        As :meth:`DesignPoint.changed` makes it.
    starts : int
        Profiles that the search starts from, beside the present design; 0 for none.
    seed : int
        Of random starts, beyond the first seven.
    warm : array (N,), optional
        Profile of a smaller change, to start from as well.

    Raises
    ------
    InfeasibleError
        If no profile keeps the limits.
    """
    objective = changed.objective
    problem = changed.task.problem(point.design.mean_pitch)
    own = solve_local(problem, objective, point.design.profile)
    best, label = own, "present design"
    others: list[tuple[str, LocalSolution]] = []
    if warm is not None:
        others.append(("smaller change", solve_local(problem, objective, warm)))
    if starts and not problem.constant_only:
        others += [
            (start.label, solve_local(problem, objective, start.profile))
            for start in _starts(point, changed, starts, seed)
        ]
    for name, solution in others:
        if _rank(problem, objective, solution) > _rank(problem, objective, best):
            best, label = solution, name
    if not _feasible(problem, objective, best):
        raise InfeasibleError(
            f"no profile keeps the limits with the change: {' '.join(best.message.split())}"
        )
    value = point.stationary.value
    scale = point.largest_torque if point.by_torque else max(-value, 1.0)
    near = own.value if _feasible(problem, objective, own) else -np.inf
    apart, missed = best.value - near, 0.0
    if apart > _ROUNDING * scale:
        back = solve_local(point.problem, point.objective, best.profile)
        if _feasible(point.problem, point.objective, back):
            missed = max(back.value - value, 0.0)
    change = best.value - value - missed
    return Truth(
        change=change,
        near=near - value,
        profile=best.profile,
        moved=float(np.max(np.abs(best.profile - point.design.profile))),
        start=label,
        other=apart > max(_SAME * scale, _RELEVANT * abs(change)),
        missed=missed,
        status=best.status,
    )


def _rank(problem: DesignProblem, objective: Objective, solution: LocalSolution) -> float:
    if solution.status is Status.SOLVER_FAILED:
        return -np.inf
    return valued(problem, objective, solution.profile)


def _feasible(problem: DesignProblem, objective: Objective, solution: LocalSolution) -> bool:
    """Whether torque limits and blade cap are kept, to a millionth."""
    torque, blade = problem.excess(solution.loads, objective)
    scale = max(abs(float(solution.loads.mean[0])), 1.0)
    return torque <= 2e-6 * scale and (blade <= 2e-6 * objective.blade_cap or blade == 0.0)


def _starts(point: DesignPoint, changed: Changed, count: int, seed: int) -> list[Start]:
    """The usual starts, made for the changed problem; none where they cannot be made."""
    task = changed.task
    try:
        reference = best_constant(task)
        power = power_max(task, reference=reference)
        finder = PointFinder(task, reference, power, count, False, seed, None, total=1)
        starts = finder.first_starts(changed.objective)
    except InputError:
        return []
    if task.frozen:
        assert point.design.mean_pitch is not None
        starts = [
            Start(label=s.label, profile=s.profile - s.profile.mean() + point.design.mean_pitch)
            for s in starts
        ]
    return starts
