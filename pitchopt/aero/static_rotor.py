"""StaticRotor: a rotor turning steadily in a wind field that does not change in time.

Three ways to treat the induced velocity:

``none``
    No induction; every section has the concave fit of its polar, and pitch is limited where the
    first section would leave its fit.
``frozen``
    Momentum balance of every section and azimuth at one mean pitch (tables of the polars), then
    held while pitch moves within the turn.  Fitted sections are anchored at the mean pitch, so
    loads at constant mean pitch are exactly those of ``equilibrium``.  Offsets of the
    aerodynamic centre are projected at the mean pitch.
``equilibrium``
    Every azimuth and pitch in its own momentum balance with the tables, as quasi-steady
    blade-element momentum codes do; curves are sampled and torque need not be concave.

Signs and frames: see `rotor` and `loads`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pitchopt.aero.balanced_limits import attached_pitch, balanced_limits
from pitchopt.aero.breakpoints import sample_points
from pitchopt.aero.curves import BladeCurves
from pitchopt.aero.fits import PolarFit
from pitchopt.aero.fixed_inflow import FixedInflow
from pitchopt.aero.frozen_errors import FrozenErrors, frozen_errors
from pitchopt.aero.induction import Momentum
from pitchopt.aero.loads import BladeLoads
from pitchopt.aero.rotor import Inflow, Rotor
from pitchopt.aero.section_flow import SectionFlow
from pitchopt.aero.stall import StallLimits, check_alpha_limits, stall_limits
from pitchopt.checks import FloatArray, finite_number, whole_number
from pitchopt.errors import InputError

__all__ = ["StaticRotor"]

_MODES = ("none", "frozen", "equilibrium")
_RATE_STEP = 0.02  # [rad/s] for the central difference in pitch rate: as real rates are
_MIN_RANGE = 1e-6  # [rad]


@dataclass(frozen=True, kw_only=True, eq=False)
class StaticRotor:
    """Rotor, wind and rotor speed.

    Parameters
    ----------
    rotor : Rotor
    wind : object with ``velocity(x, y, z, t=0.0) -> (..., 3)``
        Wind field in the global frame [m/s].
    rotor_speed : float
        Angular speed [rad/s], positive.
    air_density : float
        [kg/m^3].
    yaw : float
        Nacelle yaw, positive about the vertical (counter-clockwise from above) [rad].
    induction : {"none", "frozen", "equilibrium"}
        See the module.
    pitch_range : (float, float)
        Limits of the pitch actuator [rad].
    alpha_limits : (float or None, float or None)
        Angle-of-attack limits of fitted sections [rad].  None above: the stall angle of each
        polar.  None below: `Polar.concave_range`, with ``frozen`` extended to 6 degrees below
        the angles at the mean pitch where a coarser fit reaches that far.
    segments : int
        Linear pieces d of each polar fit.
    pitch_rate_terms, radial_moment, skew : bool
        Loads due to pitch rate; the moment about the blade's own axis; redistribution of the
        induction in a skewed wake.
    samples : int
        Pitches per station of ``equilibrium`` curves: within 9 degrees of the mean pitch if
        there is one (fewer, wider apart, follow outside), else over the whole interval.
    stall_share : float
        Attached sections at or beyond this share of the rotor radius restrict the pitch range
        by their limits (``frozen`` and ``equilibrium``; with ``none`` all sections do).
    momentum : Momentum, optional
        Options of the momentum balance.

    Raises
    ------
    InputError
        On values out of range.
    """

    rotor: Rotor
    wind: Inflow
    rotor_speed: float
    air_density: float = 1.225
    yaw: float = 0.0
    induction: Literal["none", "frozen", "equilibrium"] = "none"
    pitch_range: tuple[float, float] = (float(np.deg2rad(-5.0)), float(np.deg2rad(45.0)))
    alpha_limits: tuple[float | None, float | None] = (None, None)
    segments: int = 40
    pitch_rate_terms: bool = True
    radial_moment: bool = True
    skew: bool = True
    samples: int = 121
    stall_share: float = 0.3
    momentum: Momentum | None = None

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        set_(self, "rotor_speed", finite_number("rotor_speed", self.rotor_speed, above=0.0))
        set_(self, "air_density", finite_number("air_density", self.air_density, above=0.0))
        half = float(np.pi / 2)
        set_(self, "yaw", finite_number("yaw", self.yaw, at_least=-half, at_most=half))
        set_(self, "stall_share", finite_number("stall_share", self.stall_share, at_least=0.0))
        if self.induction not in _MODES:
            raise InputError(f"induction: got {self.induction!r}, expected one of {_MODES}")
        for name in ("pitch_range", "alpha_limits"):
            pair = getattr(self, name)
            if not isinstance(pair, (tuple, list)) or len(pair) != 2:
                raise InputError(f"{name}: got {pair!r}, expected two angles (lower, upper)")
        low = finite_number("pitch_range[0]", self.pitch_range[0], at_least=-np.pi)
        high = finite_number("pitch_range[1]", self.pitch_range[1], at_most=np.pi)
        if not low < high:
            raise InputError(f"pitch_range: got {low} to {high} rad, the first must be smaller")
        set_(self, "pitch_range", (low, high))
        limits = tuple(
            None if value is None else finite_number(f"alpha_limits[{i}]", value)
            for i, value in enumerate(self.alpha_limits)
        )
        if None not in limits and not limits[0] < limits[1]:  # type: ignore[operator]
            raise InputError(f"alpha_limits: got {self.alpha_limits}, expected (lower, upper)")
        set_(self, "alpha_limits", limits)
        for name, least in (("segments", 1), ("samples", 2)):
            set_(self, name, whole_number(name, getattr(self, name), at_least=least))
        check_alpha_limits(self.rotor.blade.polars, self.alpha_limits)

    # ---- sections and their flow ---------------------------------------------------------

    @cached_property
    def _sections(self) -> SectionFlow:
        return SectionFlow(
            rotor=self.rotor,
            wind=self.wind,
            rotor_speed=self.rotor_speed,
            air_density=self.air_density,
            yaw=self.yaw,
            alpha_limits=self.alpha_limits,
            segments=self.segments,
            radial_moment=self.radial_moment,
            skew=self.skew,
            momentum=self.momentum,
        )

    def section_fits(
        self, positions: int = 24, mean_pitch: float | None = None
    ) -> tuple[PolarFit | None, ...]:
        """Polar fits that the curves use, one per section; None marks a linear section."""
        return self.fixed_inflow(positions, mean_pitch).fits

    def fixed_inflow(self, positions: int, mean_pitch: float | None = None) -> FixedInflow:
        """Sections in the held flow at the stations, which the curves are made of.

        Parameters
        ----------
        positions, mean_pitch
            As in `curves`.

        Raises
        ------
        InputError
            With ``equilibrium``, where the flow answers to pitch, or if `mean_pitch` is missing
            or out of range.
        """
        if self.induction == "equilibrium":
            raise InputError("induction: got 'equilibrium', expected none or frozen for held flow")
        mean = self._mean(mean_pitch) if self.induction == "frozen" else None
        return self._sections.held(self._stations(positions), mean)

    def _restricting(self) -> NDArray[np.bool_]:
        span = self.rotor.blade.span
        if self.induction == "none":
            return np.ones(span.size, dtype=bool)
        return np.asarray((self.rotor.hub_radius + span) / self.rotor.radius >= self.stall_share)

    def _mean(self, mean_pitch: float | None) -> float:
        if mean_pitch is None:
            raise InputError("mean_pitch: induction 'frozen' needs the pitch to freeze the wake at")
        low, high = self.pitch_range
        slack = 1e-9  # a limit converted twice may differ in its last digit
        mean = finite_number("mean_pitch", mean_pitch, at_least=low - slack, at_most=high + slack)
        return float(np.clip(mean, low, high))

    def blade_loads(
        self,
        azimuth: ArrayLike,
        pitch: ArrayLike,
        pitch_rate: ArrayLike = 0.0,
        mean_pitch: float | None = None,
    ) -> BladeLoads:
        """Loads of one blade by direct evaluation of the model that the curves stand for.

        Parameters
        ----------
        azimuth, pitch, pitch_rate : array_like, broadcast to (...)
            [rad], [rad], [rad/s].  The rate enters the relative wind exactly (curves are linear
            in it) and is ignored without `pitch_rate_terms`.
        mean_pitch : float, optional
            Pitch at which the wake is frozen [rad]; needed with ``frozen``.

        Returns
        -------
        BladeLoads
            Moments about the rotor apex, each of shape (...).

        Raises
        ------
        InputError
            With ``frozen`` if `mean_pitch` is missing or outside the pitch range.
        """
        psi, beta, rate = np.broadcast_arrays(
            *(np.asarray(a, dtype=np.float64) for a in (azimuth, pitch, pitch_rate))
        )
        shape = psi.shape
        psi, beta, rate = (np.array(a).reshape(-1) for a in (psi, beta, rate))
        if not self.pitch_rate_terms:
            rate = np.zeros_like(rate)
        if self.induction == "equilibrium":
            reference = beta if mean_pitch is None else np.asarray(mean_pitch)
            loads = self._sections.table_loads(
                self._sections.balanced(psi, beta, rate, reference), beta
            )
        else:
            mean = self._mean(mean_pitch) if self.induction == "frozen" else None
            loads = self._sections.held(psi, mean, rate if np.any(rate) else None).loads(beta)
        return BladeLoads(*loads.reshape(4, *shape))

    # ---- curves --------------------------------------------------------------------------

    def _stations(self, positions: int) -> FloatArray:
        count = self.rotor.blades * whole_number("positions", positions, at_least=1)
        return np.asarray(2 * np.pi * np.arange(count) / count)

    def _clip(
        self, psi: FloatArray, low: FloatArray, high: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        low = np.maximum(low, self.pitch_range[0])
        high = np.minimum(high, self.pitch_range[1])
        if np.any(high - low < _MIN_RANGE):
            row = int(np.argmin(high - low))
            raise InputError(
                "pitch_range, alpha_limits: no pitch is left at azimuth "
                f"{np.rad2deg(psi[row]):.1f} deg (from {np.rad2deg(low[row]):.3f} to "
                f"{np.rad2deg(high[row]):.3f} deg); widen the pitch range or the limits"
            )
        return low, high

    def curves(self, positions: int, mean_pitch: float | None = None) -> BladeCurves:
        """Loads over pitch at the stations of `positions` rotor positions.

        Parameters
        ----------
        positions : int
            Rotor positions m of one blade passage; N = blades * m stations over the turn.
        mean_pitch : float, optional
            Pitch at which the wake is frozen and pitch-rate terms are linearised [rad]; needed
            with ``frozen``.  With ``equilibrium`` its default is the middle of the interval.

        Returns
        -------
        BladeCurves
            Exact with ``none`` and ``frozen``; with ``equilibrium`` sampled, the mean pitch
            among the samples.

        Raises
        ------
        InputError
            If no pitch is left at some azimuth, or `mean_pitch` is missing or out of range.
        """
        psi = self._stations(positions)
        if self.induction == "equilibrium":
            beta, loads = self._sampled(psi, mean_pitch)
            centre = 0.5 * (beta[:, 0] + beta[:, -1])
            rate_pitch = centre if mean_pitch is None else np.full(psi.size, mean_pitch)
            rates = self._rates(psi, rate_pitch, None)
            mean = None
        else:
            mean = self._mean(mean_pitch) if self.induction == "frozen" else None
            model = self._sections.held(psi, mean)
            low, high = self._clip(psi, *model.limits(self._restricting()))
            beta, loads = model.breakpoints(low, high)
            at = 0.5 * (low + high) if mean is None else np.full(psi.size, mean)
            rates = self._rates(psi, at, mean)
        return BladeCurves(
            blades=self.rotor.blades,
            azimuth=psi,
            beta=beta,
            torque=loads[0],
            bending=loads[1],
            radial=loads[2],
            thrust=loads[3],
            torque_rate=rates[0],
            bending_rate=rates[1],
            radial_rate=rates[2],
            thrust_rate=rates[3],
            mean_pitch=mean,
        )

    def _rates(self, psi: FloatArray, pitch: FloatArray, mean: float | None) -> FloatArray:
        """Loads (4, N) per unit d beta / d psi."""
        if not self.pitch_rate_terms:
            return np.zeros((4, psi.size))
        up, down = (
            np.stack(self.blade_loads(psi, pitch, sign * _RATE_STEP, mean_pitch=mean))
            for sign in (1.0, -1.0)
        )
        return np.asarray((up - down) * (self.rotor_speed / (2 * _RATE_STEP)))

    def _sampled(self, psi: FloatArray, mean_pitch: float | None) -> tuple[FloatArray, FloatArray]:
        """Samples (N, K) of pitch and loads (4, N, K) in momentum balance."""
        low = np.full(psi.size, self.pitch_range[0])
        high = np.full(psi.size, self.pitch_range[1])
        if mean_pitch is not None:
            low, high = self._balanced_limits(psi, mean_pitch)
        low, high = self._clip(psi, low, high)
        beta = sample_points(low, high, mean_pitch, self.samples)
        reference = np.full((psi.size, 1), 0.0 if mean_pitch is None else mean_pitch)
        loads = np.empty((4, *beta.shape))
        for rows in self._sections.chunks(psi.size, beta.shape[1]):
            flow = self._sections.balanced(
                psi[rows, None], beta[rows], np.zeros(()), reference[rows]
            )
            loads[:, rows] = self._sections.table_loads(flow, beta[rows])
        return beta, loads

    def _balanced_limits(self, psi: FloatArray, mean_pitch: float) -> tuple[FloatArray, FloatArray]:
        mean = self._mean(mean_pitch)
        return balanced_limits(self._sections, psi, mean, self.pitch_range, self._stall_limits())

    def attached_pitch(self, positions: int = 24) -> tuple[float, float]:
        """Constant pitches at which no outboard section stalls at any azimuth.

        The restricting sections are the lifting ones at or beyond `stall_share`, without those
        whose loss factor vanishes; each azimuth is in its own momentum balance.  Of several
        such intervals the longest counts.

        Returns
        -------
        low, high : float
            Ends of the interval within the pitch range [rad], to 0.01 degrees.

        Raises
        ------
        InputError
            If every constant pitch stalls somewhere.
        """
        psi = self._stations(positions)
        return attached_pitch(self._sections, psi, self.pitch_range, self._stall_limits())

    def _stall_limits(self) -> StallLimits:
        restricting = self._restricting() & ~self._sections.blocked
        return stall_limits(self.rotor.blade.polars, self.alpha_limits, restricting)

    def pitch_limits(
        self, azimuth: ArrayLike, mean_pitch: float | None = None
    ) -> tuple[FloatArray, FloatArray]:
        """Lowest and highest pitch at azimuths (N,) [rad], as `curves` has them."""
        psi = np.atleast_1d(np.asarray(azimuth, dtype=np.float64))
        if self.induction == "equilibrium":
            if mean_pitch is None:
                ones = np.ones(psi.size)
                return self._clip(psi, -np.inf * ones, np.inf * ones)
            return self._clip(psi, *self._balanced_limits(psi, mean_pitch))
        mean = self._mean(mean_pitch) if self.induction == "frozen" else None
        return self._clip(psi, *self._sections.held(psi, mean).limits(self._restricting()))

    def frozen_errors(
        self, positions: int, mean_pitch: float, window: float = float(np.deg2rad(3.0))
    ) -> FrozenErrors:
        """Errors that frozen curves make at mean pitch -/+ `window` [rad]."""
        psi = self._stations(positions)
        mean = self._mean(mean_pitch)
        return frozen_errors(self._sections, psi, mean, window)
