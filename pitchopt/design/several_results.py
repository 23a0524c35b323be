"""What designs for several winds return: one result for all, one entry for each wind."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pitchopt.aero.curves import RotorLoads
from pitchopt.design.joint import JointMultipliers
from pitchopt.design.results import Design, Status
from pitchopt.errors import InputError

__all__ = ["Several", "WindResult"]

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class WindResult:
    """What a design for several winds gives in one of them.

    Attributes
    ----------
    label : str
    weight : float
        p_w; for the largest regret the multiplier of this wind's regret.
    constant : Design
        Best constant pitch in this wind alone.
    loads : RotorLoads
        At the stations.
    rms_weighted : float
        Weighted sum of RMS values [N m].
    objective, own_objective, regret : float
        V_w of the profile, V*_w of this wind's own optimum and the difference [N m].
    own_profile : ndarray (N,)
        Own optimum [rad].
    """

    label: str
    weight: float
    constant: Design
    loads: RotorLoads
    rms_weighted: float
    objective: float
    own_objective: float
    own_profile: FloatArray

    @property
    def regret(self) -> float:
        """What this wind loses against its own optimum [N m]."""
        return self.own_objective - self.objective

    @property
    def mean_torque(self) -> float:
        """Mean torque over the stations [N m]."""
        return float(self.loads.mean[0])

    @property
    def cut(self) -> float | None:
        """Weighted RMS cut against this wind's best constant pitch, as a share."""
        before = self.constant.rms_weighted
        return 1.0 - self.rms_weighted / before if before > 0 else None


@dataclass(frozen=True, kw_only=True, eq=False)
class Several:
    """A profile for several winds, or one for each with a bounded change between neighbours.

    Attributes
    ----------
    goal : str
        ``mean`` or ``regret`` (one profile), or ``schedule``.
    azimuth : ndarray (N,)
    profiles : ndarray (S, N)
        One row for a robust design, one for each wind in a schedule [rad].
    change : float
        Largest change asked for between neighbouring profiles [rad]; infinite for none.
    winds : tuple of WindResult
    objective : float
        Weighted sum of the winds' objectives, or minus the largest regret [N m].
    upper_bound, gap : float or None
        Proven bound on it over all feasible profiles, and (bound - objective) / weighted mean
        torque of the winds' best constant pitches (the largest of them for the regret) [-].
    certificate : JointMultipliers or None
        What proves the bound.
    status, message, start, iterations, seconds, history
        How the joint solve ended, from which start, after how many subproblems.
    """

    goal: str
    azimuth: FloatArray
    profiles: FloatArray
    change: float
    winds: tuple[WindResult, ...]
    objective: float
    upper_bound: float | None
    gap: float | None
    certificate: JointMultipliers | None
    status: Status
    message: str
    start: str
    iterations: int
    seconds: float
    history: tuple[float, ...]
    settings: dict[str, Any] = field(default_factory=dict)

    @property
    def profile(self) -> FloatArray:
        """The one profile of a robust design [rad].

        Raises
        ------
        InputError
            For a schedule, which has several.
        """
        if self.profiles.shape[0] > 1:
            raise InputError(f"profile: this schedule has {self.profiles.shape[0]}, see profiles")
        return np.asarray(self.profiles[0])

    @property
    def largest_regret(self) -> float:
        """Largest loss of any wind against its own optimum [N m]."""
        return max(wind.regret for wind in self.winds)

    @property
    def largest_change(self) -> float:
        """Largest change of pitch between neighbouring profiles at any station [rad]."""
        return float(np.abs(np.diff(self.profiles, axis=0)).max(initial=0.0))
