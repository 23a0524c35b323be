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
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pitchopt.aero.breakpoints import sample_points
from pitchopt.aero.curves import BladeCurves
from pitchopt.aero.fits import PolarFit, fit_polar
from pitchopt.aero.fixed_inflow import FixedInflow
from pitchopt.aero.flow import Flow, balanced_flow, free_flow, loss_constants
from pitchopt.aero.induction import Momentum, SectionPolars
from pitchopt.aero.loads import BladeLoads, load_map
from pitchopt.aero.rotor import Inflow, Rotor
from pitchopt.aero.section_limits import section_limits
from pitchopt.aero.stall import (
    StallLimits,
    attached_intervals,
    check_alpha_limits,
    check_coverage,
    longest_interval,
    stall_limits,
)
from pitchopt.checks import FloatArray, finite_number, whole_number
from pitchopt.errors import InputError

__all__ = ["FrozenErrors", "StaticRotor"]

_MODES = ("none", "frozen", "equilibrium")
_RATE_STEP = 0.02  # [rad/s] for the central difference in pitch rate: as real rates are
_MIN_RANGE = 1e-6  # [rad]
_CHUNK = 40_000  # sections solved at a time
_REACH = float(np.deg2rad(25.0))  # limits are looked for this far around the mean pitch


class FrozenErrors(NamedTuple):
    """How far frozen curves are from what they stand for, as shares of the mean load.

    Each is the largest over the stations at mean pitch -/+ the window, for torque, bending and
    thrust, divided by the mean over the stations at the mean pitch.

    Attributes
    ----------
    fit : ndarray (3,)
        Fits and tangents against the tables in the same held wake.
    projection : ndarray (3,)
        Offsets of the aerodynamic centres held at the mean pitch against turning with it.
    """

    fit: FloatArray
    projection: FloatArray


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

    # ---- polars and their fits ---------------------------------------------------------

    @cached_property
    def _polars(self) -> SectionPolars:
        return SectionPolars(self.rotor.blade.polars)

    @cached_property
    def _blocked(self) -> NDArray[np.bool_]:
        """Sections whose loss factor vanishes, (E,)."""
        options = self.momentum or Momentum()
        tip, hub = loss_constants(self.rotor)
        none = np.zeros(tip.size, dtype=bool)
        return (tip <= 0.0 if options.tip_loss else none) | (
            hub <= 0.0 if options.hub_loss else none
        )

    def _fits(self, alpha: FloatArray | None) -> tuple[PolarFit | None, ...]:
        """Fits of all sections (no `alpha`), or of those attached at angles (..., E)."""
        polars = self.rotor.blade.polars
        limits = section_limits(polars, self.alpha_limits, alpha, self._blocked)
        return tuple(
            None if pair is None else fit_polar(polar, pair, self.segments)
            for polar, pair in zip(polars, limits, strict=True)
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
        return self._fixed(self._stations(positions), mean)

    def _restricting(self) -> NDArray[np.bool_]:
        span = self.rotor.blade.span
        if self.induction == "none":
            return np.ones(span.size, dtype=bool)
        return np.asarray((self.rotor.hub_radius + span) / self.rotor.radius >= self.stall_share)

    # ---- flow and loads ------------------------------------------------------------------

    def _flow(
        self, psi: FloatArray, pitch: FloatArray, rate: FloatArray, mean_pitch: FloatArray
    ) -> Flow:
        """Flow in momentum balance."""
        return balanced_flow(
            self.rotor,
            self.wind,
            self.rotor_speed,
            psi,
            pitch,
            polars=self._polars,
            pitch_rate=rate,
            yaw=self.yaw,
            skew=self.skew,
            skew_pitch=mean_pitch,
            momentum=self.momentum,
        )

    def _raw_loads(self, flow: Flow, pitch: FloatArray) -> FloatArray:
        """Loads (4, ...) of a flow with the tables of the polars."""
        blade = self.rotor.blade
        mapping = load_map(
            flow.sections,
            blade.chord,
            self.rotor.cone,
            flow.phi,
            0.5 * self.air_density * flow.square,
            radial_moment=self.radial_moment,
        )
        alpha = flow.phi - blade.twist - pitch[..., None]
        check_coverage(blade.polars, alpha)
        return mapping.apply(*self._polars.coefficients(alpha))

    def _mean(self, mean_pitch: float | None) -> float:
        if mean_pitch is None:
            raise InputError("mean_pitch: induction 'frozen' needs the pitch to freeze the wake at")
        low, high = self.pitch_range
        slack = 1e-9  # a limit converted twice may differ in its last digit
        mean = finite_number("mean_pitch", mean_pitch, at_least=low - slack, at_most=high + slack)
        return float(np.clip(mean, low, high))

    def _fixed(
        self, psi: FloatArray, mean_pitch: float | None, rate: FloatArray | None = None
    ) -> FixedInflow:
        """Held flow at azimuths (...), for ``none`` (no mean pitch) and ``frozen``."""
        zero = np.zeros(())
        if mean_pitch is None:
            flow = free_flow(
                self.rotor, self.wind, self.rotor_speed, psi, zero, pitch_rate=rate, yaw=self.yaw
            )
            fits = self._fits(None)
        else:
            mean = np.asarray(mean_pitch)
            held = self._flow(psi, np.full(psi.shape, mean_pitch), zero, mean)
            fits = self._fits(held.phi - self.rotor.blade.twist - mean_pitch)
            flow = held
            if rate is not None:
                flow = free_flow(
                    self.rotor,
                    self.wind,
                    self.rotor_speed,
                    psi,
                    np.full(psi.shape, mean_pitch),
                    pitch_rate=rate,
                    yaw=self.yaw,
                    induced=(held.induced_normal, held.induced_tangential),
                )
        mapping = load_map(
            flow.sections,
            self.rotor.blade.chord,
            self.rotor.cone,
            flow.phi,
            0.5 * self.air_density * flow.square,
            radial_moment=self.radial_moment,
        )
        base = flow.phi - self.rotor.blade.twist
        if mean_pitch is not None:
            # torque must fall with drag and rise with lift for the fit to keep it concave
            wrong = (mapping.lift[0] < 0.0) | (mapping.drag[0] > 0.0)
            bad = wrong.reshape(-1, wrong.shape[-1]).any(axis=0)
            fits = tuple(None if bad[e] else fit for e, fit in enumerate(fits))
        return FixedInflow.build(base, mapping, fits, self._polars, mean_pitch)

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
            loads = self._raw_loads(self._flow(psi, beta, rate, reference), beta)
        else:
            mean = self._mean(mean_pitch) if self.induction == "frozen" else None
            loads = self._fixed(psi, mean, rate if np.any(rate) else None).loads(beta)
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
            model = self._fixed(psi, mean)
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
            low, high = self._balanced_limits(psi, self._mean(mean_pitch))
        low, high = self._clip(psi, low, high)
        beta = sample_points(low, high, mean_pitch, self.samples)
        reference = np.full((psi.size, 1), 0.0 if mean_pitch is None else mean_pitch)
        loads = np.empty((4, *beta.shape))
        for rows in self._chunks(psi.size, beta.shape[1]):
            flow = self._flow(psi[rows, None], beta[rows], np.zeros(()), reference[rows])
            loads[:, rows] = self._raw_loads(flow, beta[rows])
        return beta, loads

    def _chunks(self, stations: int, pitches: int) -> list[slice]:
        """Runs of stations short enough to bound memory whatever the number of stations."""
        step = max(1, _CHUNK // (pitches * self.rotor.blade.span.size))
        return [slice(k, k + step) for k in range(0, stations, step)]

    def _balanced_limits(self, psi: FloatArray, mean: float) -> tuple[FloatArray, FloatArray]:
        """Pitch interval (N,) around `mean` in which no outboard section stalls."""
        grid = np.clip(mean + np.linspace(-_REACH, _REACH, 41), *self.pitch_range)
        grid = np.unique(np.append(grid, mean))
        alpha = np.empty((psi.size, grid.size, self.rotor.blade.span.size))
        for rows in self._chunks(psi.size, grid.size):
            beta = np.broadcast_to(grid, (psi[rows].size, grid.size))
            reference = np.full((psi[rows].size, 1), mean)
            flow = self._flow(psi[rows, None], beta, np.zeros(()), reference)
            alpha[rows] = flow.phi - self.rotor.blade.twist - beta[..., None]
        at = int(np.searchsorted(grid, mean))
        return attached_intervals(grid, alpha, at, self._stall_limits())

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
        limits = self._stall_limits()

        def attached(pitch: FloatArray) -> NDArray[np.bool_]:
            beta = np.broadcast_to(pitch, (psi.size, pitch.size))
            flow = self._flow(psi[:, None], beta, np.zeros(()), beta)
            alpha = (flow.phi - self.rotor.blade.twist - beta[..., None])[..., limits.sections]
            inside = (alpha <= limits.above) & (alpha >= limits.below)
            return np.asarray(inside.all(axis=(0, 2)))

        return longest_interval(attached, *self.pitch_range)

    def _stall_limits(self) -> StallLimits:
        restricting = self._restricting() & ~self._blocked
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
            return self._clip(psi, *self._balanced_limits(psi, self._mean(mean_pitch)))
        mean = self._mean(mean_pitch) if self.induction == "frozen" else None
        return self._clip(psi, *self._fixed(psi, mean).limits(self._restricting()))

    def frozen_errors(
        self, positions: int, mean_pitch: float, window: float = float(np.deg2rad(3.0))
    ) -> FrozenErrors:
        """Errors that frozen curves make at mean pitch -/+ `window` [rad]."""
        psi = self._stations(positions)
        mean = self._mean(mean_pitch)
        model = self._fixed(psi, mean)
        zero = np.zeros(())
        held = self._flow(psi, np.full(psi.size, mean), zero, np.asarray(mean))
        induced = (held.induced_normal, held.induced_tangential)
        picked = [0, 1, 3]
        scale = np.abs(model.loads(np.full(psi.size, mean))[picked]).mean(axis=1)
        fit, projection = np.zeros(3), np.zeros(3)
        for sign in (-1.0, 1.0):
            pitch = np.full(psi.size, mean + sign * window)
            turned = free_flow(
                self.rotor, self.wind, self.rotor_speed, psi, pitch, yaw=self.yaw, induced=induced
            )
            table = self._raw_loads(held, pitch)[picked]
            ours = model.loads(pitch)[picked]
            moved = self._raw_loads(turned, pitch)[picked]
            fit = np.maximum(fit, np.abs(ours - table).max(axis=1) / scale)
            projection = np.maximum(projection, np.abs(moved - table).max(axis=1) / scale)
        return FrozenErrors(fit=fit, projection=projection)
