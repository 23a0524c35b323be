"""What pitch design returns: local solutions, one Design per profile, one Tradeoff per curve."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pitchopt.aero.curves import LOADS, RotorLoads
from pitchopt.design.multipliers import Multipliers

if TYPE_CHECKING:
    from pitchopt.design.proof import Certificate

__all__ = ["Compared", "Design", "LocalSolution", "Status", "Tradeoff"]

FloatArray = NDArray[np.float64]


class Status(StrEnum):
    """How a computation ended; only ``CONVERGED`` and ``EXACT`` are answers in full."""

    EXACT = "exact"
    """Global optimum to solver tolerance, with a bound that proves it."""
    CONVERGED = "converged"
    """Local optimum: no step of the model and no neighbouring segment improves it."""
    ITERATION_LIMIT = "iteration limit"
    """Feasible and improved, but stopped before it converged."""
    INFEASIBLE = "infeasible"
    """No profile near the starts satisfies the torque limits or the blade cap."""
    SOLVER_FAILED = "solver failed"
    """Every fallback of the cone solver failed; the profile is the last good one."""

    @property
    def ok(self) -> bool:
        """True when the profile may be used as the answer."""
        return self in (Status.EXACT, Status.CONVERGED)


@dataclass(frozen=True, kw_only=True, eq=False)
class LocalSolution:
    """A local optimum: profile, loads, value, multipliers of the last convex subproblem."""

    profile: FloatArray
    loads: RotorLoads
    value: float
    multipliers: Multipliers
    status: Status
    message: str
    iterations: int
    seconds: float
    solver_seconds: float
    history: tuple[float, ...]


@dataclass(frozen=True, kw_only=True, eq=False)
class Design:
    """One pitch profile, its loads, and how it was found.

    Attributes
    ----------
    kind : str
        ``constant``, ``power_max``, ``mu``, ``max_power_loss`` or ``mean_torque``.
    mu : float
        Price of the weighted RMS against mean torque [-]; for ``max_power_loss`` and
        ``mean_torque`` the inverse of the torque constraint's multiplier, NaN where the
        constraint has none (it does not bind, or binds only through the outer search of a
        frozen wake).
    target : float or None
        The loss asked for (a share) or the mean torque asked for [N m].
    azimuth, profile : ndarray (N,)
        Stations and pitch of the profile over one turn [rad].
    loads : RotorLoads
        Loads at the stations.
    between : RotorLoads or None
        Loads of the linearly interpolated profile at ``between_positions`` rotor positions;
        None where no rotor model stands behind the curves.
    rms_weighted, rms_weighted_between : float
        Weighted sum of RMS values [N m], with the weights of the task.
    objective, upper_bound, gap : float
        Value of mean torque - mu x weighted RMS (and penalties), the proven bound on it over
        all feasible profiles, and (bound - objective) / largest mean torque [-].  For
        ``max_power_loss`` feasible means that the loss is kept as well.  For ``mean_torque``, and
        where mu is NaN, of minus the weighted RMS under the torque limits.
    rms_lower_bound : float or None
        Proven lower bound on the weighted RMS at the torque limit, for the kinds that have one.
    certificate : Certificate or None
        What proves the bound.
    mean_pitch : float or None
        The mean at which the wake is frozen [rad]; the bound holds for this mean.
    proof_ended : str
        Why the branch and bound ended; empty where there was none.
    """

    kind: str
    mu: float
    target: float | None
    azimuth: FloatArray
    profile: FloatArray
    loads: RotorLoads
    between: RotorLoads | None
    rms_weighted: float
    rms_weighted_between: float | None
    objective: float
    upper_bound: float | None
    gap: float | None
    rms_lower_bound: float | None
    certificate: Certificate | None
    mean_pitch: float | None
    status: Status
    message: str
    start: str
    iterations: int
    seconds: float
    history: tuple[float, ...] = ()
    proof_ended: str = ""

    @property
    def mean_torque(self) -> float:
        """Mean torque over the stations [N m]."""
        return float(self.loads.mean[0])

    @property
    def rms(self) -> dict[str, float]:
        """RMS of torque, tilt, yaw [N m] and thrust [N] at the stations."""
        return dict(zip(LOADS, map(float, self.loads.rms), strict=True))

    @property
    def rms_sum(self) -> float:
        """Plain sum of the four RMS values, the paper's 1'J."""
        return float(self.loads.rms.sum())

    @property
    def rms_sum_between(self) -> float | None:
        """The plain sum, judged between the stations as well."""
        return None if self.between is None else float(self.between.rms.sum())

    @property
    def pitch_travel(self) -> float:
        """Pitch travel of one revolution [rad]."""
        return float(np.abs(np.roll(self.profile, -1) - self.profile).sum())


@dataclass(frozen=True, kw_only=True, eq=False)
class Compared:
    """One design beside what it is judged by.

    Attributes
    ----------
    design : Design
    constant : Design
        Constant pitch that cuts and the blade cap count from: of the same mean torque where one
        is held, else of largest mean torque.
    power_max : Design
        Profile that losses count from.
    """

    design: Design
    constant: Design
    power_max: Design


@dataclass(frozen=True, kw_only=True, eq=False)
class Tradeoff:
    """Power maximum, best constant pitch and the points between torque and RMS.

    Attributes
    ----------
    points : tuple of Design
        Ordered by falling mean torque; the designs for a given loss among them.
    knee : int
        Index of the knee in ``points``: the point farthest from the chord between the ends
        of the curve, both axes scaled to the unit square.  It depends on where the curve ends.
    constant_pitch, constant_torque, constant_rms : ndarray (P,)
        The constant pitches, their mean torque and their weighted RMS.
    constant_pareto : bool ndarray (P,)
        Which of them no other constant pitch beats in both.
    """

    constant: Design
    power_max: Design
    points: tuple[Design, ...]
    knee: int
    constant_pitch: FloatArray
    constant_torque: FloatArray
    constant_rms: FloatArray
    constant_pareto: NDArray[np.bool_]
    settings: dict[str, Any] = field(default_factory=dict)
    seconds: float = 0.0

    def loss(self, point: Design) -> float:
        """Mean torque lost against the power maximum, as a share."""
        return 1.0 - point.mean_torque / self.power_max.mean_torque

    def cut(self, point: Design) -> float:
        """Weighted RMS cut against the best constant pitch, as a share."""
        return 1.0 - point.rms_weighted / self.constant.rms_weighted

    def cut_between(self, point: Design) -> float | None:
        """The same cut judged between the stations, both profiles at the fine positions."""
        if point.rms_weighted_between is None or self.constant.rms_weighted_between is None:
            return None
        return 1.0 - point.rms_weighted_between / self.constant.rms_weighted_between
