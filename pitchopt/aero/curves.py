"""BladeCurves: what one blade contributes at each azimuth, as a function of its own pitch.

With the inflow of every blade element fixed, the loads that a blade contributes at one
azimuth depend on that blade's own pitch there and on nothing else, and with piecewise-linear
polars they are exactly piecewise linear in it.  A table of breakpoints per azimuth station is
therefore the whole aerodynamic model that pitch design needs:

    load_l(k) = sum over the B blades of f_ln(beta_n) + c_ln dbeta/dpsi_n,    n = k, k+m, ...

Station n of N = B m stands at azimuth[0] + 2 pi n / N; the rotor at position k has its blades
at the stations k, k + m, k + 2 m, ...  Frames and signs: blade up at psi = 0, clockwise seen
from upwind; moments about the rotor centre, ``bending`` positive when the tip is pushed
downwind, ``radial`` about the blade's own axis from root to tip;

    tilt = sum(bending cos psi - radial sin psi),   yaw = sum(bending sin psi + radial cos psi).
"""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pitchopt.aero.tables import CURVES, RATES, pad_row, read_table, write_table
from pitchopt.checks import FloatArray, finite_array, finite_number, whole_number
from pitchopt.errors import InputError

__all__ = ["LOADS", "BladeCurves", "RotorLoads"]

LOADS = ("torque", "tilt", "yaw", "thrust")
"""Order of the four rotor loads wherever they share an axis."""

_MIN_SPACING = 1e-10  # [rad]; closer breakpoints make slopes of rounding errors


class RotorLoads(NamedTuple):
    """Loads of a pitch profile over one blade passage.

    Attributes
    ----------
    rotor : ndarray (4, m)
        Torque, tilt, yaw [N m] and thrust [N] of the whole rotor at the m positions.
    bending : ndarray (N,)
        Bending moment of one blade about the rotor centre over the full turn [N m].
    """

    rotor: FloatArray
    bending: FloatArray

    @property
    def mean(self) -> FloatArray:
        """Means of torque, tilt, yaw, thrust over the positions, shape (4,)."""
        return np.asarray(self.rotor.mean(axis=1))

    @property
    def rms(self) -> FloatArray:
        """J: root mean square of the deviations from the mean, shape (4,)."""
        return np.asarray(self.rotor.std(axis=1))

    @property
    def blade_rms(self) -> float:
        """J_blade: root mean square deviation of one blade's bending over the turn [N m]."""
        return float(self.bending.std())


@dataclass(frozen=True, kw_only=True, eq=False)
class BladeCurves:
    """Piecewise-linear loads of one blade over its pitch, at N azimuth stations.

    Parameters
    ----------
    blades : int
        Number of blades B, evenly spaced.
    azimuth : array (N,)
        Azimuth of the stations [rad], evenly spaced over one turn, N = B m.
    beta : array (N, K)
        Breakpoints in pitch [rad], each row strictly increasing.  The first and the last of a
        row are the limits of pitch at that azimuth.
    torque, bending, thrust : array (N, K)
        Contributions of one blade at the breakpoints [N m], [N m], [N].
    radial : array (N, K), optional
        Moment about the blade's own axis [N m]; zero for a rotor without cone, prebend and
        section moments.
    torque_rate, bending_rate, thrust_rate, radial_rate : array (N,), optional
        Load per dbeta/dpsi [N m/(rad/rad)], [N/(rad/rad)]: pitch rate moves the sections.
    mean_pitch : float, optional
        The mean pitch [rad] at which the wake was frozen; profiles keep this mean.

    Raises
    ------
    InputError
        If shapes differ, values are not finite, stations are not evenly spaced or
        breakpoints do not increase.
    """

    blades: int
    azimuth: FloatArray
    beta: FloatArray
    torque: FloatArray
    bending: FloatArray
    thrust: FloatArray
    radial: FloatArray | None = None
    torque_rate: FloatArray | None = None
    bending_rate: FloatArray | None = None
    thrust_rate: FloatArray | None = None
    radial_rate: FloatArray | None = None
    mean_pitch: float | None = None

    def __post_init__(self) -> None:
        blades = whole_number("blades", self.blades, at_least=1)
        azimuth = finite_array("azimuth", self.azimuth)
        if azimuth.size % blades:
            raise InputError(
                f"azimuth: got shape {azimuth.shape}, expected (N,) with N a multiple of the "
                f"{blades} blades"
            )
        stations = azimuth.size
        expected = azimuth[0] + 2 * np.pi * np.arange(stations) / stations
        if not np.allclose(azimuth, expected, rtol=0.0, atol=1e-6):
            raise InputError("azimuth: stations must be evenly spaced over one full turn")
        beta = finite_array("beta", self.beta, shape=np.shape(self.beta))
        if beta.ndim != 2 or beta.shape[0] != stations or beta.shape[1] < 2:
            raise InputError(f"beta: got shape {beta.shape}, expected ({stations}, K), K >= 2")
        spacing = np.diff(beta, axis=1)
        if np.any(spacing < _MIN_SPACING):
            row = int(np.argmin(spacing.min(axis=1)))
            raise InputError(
                f"beta: breakpoints must increase by at least {_MIN_SPACING:g} rad along each "
                f"row; row {row} has a step of {spacing[row].min():.3g} rad"
            )
        set_ = object.__setattr__
        set_(self, "blades", blades)
        set_(self, "azimuth", azimuth)
        set_(self, "beta", beta)
        for name in CURVES:
            value = getattr(self, name)
            value = np.zeros(beta.shape) if value is None else value
            set_(self, name, finite_array(name, value, shape=beta.shape))
        for name in RATES:
            value = getattr(self, name)
            value = np.zeros(stations) if value is None else value
            set_(self, name, finite_array(name, value, shape=(stations,)))
        if self.mean_pitch is not None:
            set_(self, "mean_pitch", finite_number("mean_pitch", self.mean_pitch))

    # ---- sizes -------------------------------------------------------------------------

    @property
    def stations(self) -> int:
        """N, the number of azimuth stations over the full turn."""
        return int(self.azimuth.size)

    @property
    def positions(self) -> int:
        """m = N / B, the number of rotor positions in one blade passage."""
        return self.stations // self.blades

    @property
    def spacing(self) -> float:
        """Azimuth between neighbouring stations [rad]."""
        return 2 * np.pi / self.stations

    @property
    def lower(self) -> FloatArray:
        """Lowest pitch at each station [rad], shape (N,)."""
        return np.asarray(self.beta[:, 0])

    @property
    def upper(self) -> FloatArray:
        """Highest pitch at each station [rad], shape (N,)."""
        return np.asarray(self.beta[:, -1])

    # ---- the loads that design works on --------------------------------------------------

    @cached_property
    def loads(self) -> FloatArray:
        """Contributions to torque, tilt, yaw, thrust and the blade's bending, (5, N, K)."""
        assert self.radial is not None  # set in __post_init__
        c, s = np.cos(self.azimuth)[:, None], np.sin(self.azimuth)[:, None]
        out = np.stack(
            [
                self.torque,
                self.bending * c - self.radial * s,
                self.bending * s + self.radial * c,
                self.thrust,
                self.bending,
            ]
        )
        out.setflags(write=False)
        return out

    @cached_property
    def rates(self) -> FloatArray:
        """The same five loads per dbeta/dpsi, shape (5, N)."""
        assert self.bending_rate is not None and self.radial_rate is not None
        c, s = np.cos(self.azimuth), np.sin(self.azimuth)
        out = np.stack(
            [
                np.asarray(self.torque_rate),
                self.bending_rate * c - self.radial_rate * s,
                self.bending_rate * s + self.radial_rate * c,
                np.asarray(self.thrust_rate),
                self.bending_rate,
            ]
        )
        out.setflags(write=False)
        return out

    @cached_property
    def slopes(self) -> FloatArray:
        """Slopes of the five loads on the K - 1 segments, shape (5, N, K - 1)."""
        out = np.diff(self.loads, axis=2) / np.diff(self.beta, axis=1)
        out.setflags(write=False)
        return np.asarray(out)

    @cached_property
    def _keys(self) -> FloatArray:
        """Rows of ``beta`` laid end to end, for one sorted search over all stations."""
        base = self.beta[:, :1]
        span = float(np.max(self.beta[:, -1:] - base)) + 1.0
        return np.asarray((self.beta - base + span * np.arange(self.stations)[:, None]).ravel())

    def segment(self, profile: ArrayLike) -> NDArray[np.intp]:
        """Segment that holds each station's pitch; ends count as inside.

        Parameters
        ----------
        profile : array (N,) or (N, P)
            One pitch per station, or several.
        """
        beta = np.asarray(profile, dtype=np.float64)
        n, k = self.beta.shape
        column = (n,) + (1,) * (beta.ndim - 1)
        low = self.lower.reshape(column)
        row = np.arange(n).reshape(column)
        span = float(np.max(self.beta[:, -1] - self.beta[:, 0])) + 1.0
        shifted = np.clip(beta - low, 0.0, (self.upper - self.lower).reshape(column))
        flat = np.searchsorted(self._keys, shifted + span * row, side="right") - 1
        return np.asarray(np.clip(flat - k * row, 0, k - 2))

    def contributions(self, profile: ArrayLike) -> FloatArray:
        """Five loads of the blade at each station, without the rate terms, shape (5, N).

        Outside the breakpoints the first or last segment is continued.
        """
        beta = np.asarray(profile, dtype=np.float64)
        rows = np.arange(self.stations)
        j = self.segment(beta)
        return np.asarray(
            self.loads[:, rows, j] + self.slopes[:, rows, j] * (beta - self.beta[rows, j])
        )

    def profile_rate(self, profile: FloatArray) -> FloatArray:
        """Central difference dbeta/dpsi at the stations, shape (N,)."""
        if self.stations < 2:
            return np.zeros(self.stations)
        return np.asarray((np.roll(profile, -1) - np.roll(profile, 1)) / (2 * self.spacing))

    def evaluate(self, profile: ArrayLike) -> RotorLoads:
        """Loads of the rotor under one pitch profile for all blades.

        Parameters
        ----------
        profile : array (N,)
            Pitch at the stations [rad].
        """
        beta = np.asarray(profile, dtype=np.float64)
        if beta.shape != (self.stations,):
            raise InputError(f"profile: got shape {beta.shape}, expected ({self.stations},)")
        blade = self.contributions(beta) + self.rates * self.profile_rate(beta)
        rotor = blade[:4].reshape(4, self.blades, self.positions).sum(axis=1)
        return RotorLoads(rotor=np.asarray(rotor), bending=np.asarray(blade[4]))

    def evaluate_constant(self, pitch: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Loads of constant pitches: rotor (P, 4, m) and bending (P, N) for P angles [rad]."""
        angles = np.atleast_1d(np.asarray(pitch, dtype=np.float64))
        results = [self.evaluate(np.full(self.stations, angle)) for angle in angles]
        return np.stack([r.rotor for r in results]), np.stack([r.bending for r in results])

    @cached_property
    def concavity_error(self) -> float:
        """Largest rise of torque slope between neighbouring segments, over the largest slope.

        Zero when torque is concave in pitch at every station.
        """
        slopes = self.slopes[0]
        if slopes.shape[1] < 2:
            return 0.0
        scale = float(np.max(np.abs(slopes)))
        rise = float(np.max(np.diff(slopes, axis=1)))
        return max(rise, 0.0) / scale if scale > 0 else 0.0

    @property
    def concave(self) -> bool:
        """True when torque is concave in pitch at every station, to rounding (1e-6)."""
        return self.concavity_error <= 1e-6

    def with_limits(self, lower: ArrayLike, upper: ArrayLike) -> BladeCurves:
        """The same curves on narrower pitch intervals, with both ends as breakpoints.

        Parameters
        ----------
        lower, upper : float or array (N,)
            New limits [rad]; what lies outside the present ones is ignored.

        Raises
        ------
        InputError
            If an interval is empty.
        """
        low, high = np.asarray(lower, dtype=float), np.asarray(upper, dtype=float)
        for name, limit in (("lower", low), ("upper", high)):
            if limit.shape not in {(), (self.stations,)}:
                raise InputError(f"{name}: got shape {limit.shape}, expected ({self.stations},)")
        low, high = np.maximum(self.lower, low), np.minimum(self.upper, high)
        if np.any(high - low < _MIN_SPACING):
            row = int(np.argmin(high - low))
            raise InputError(
                f"pitch limits: no pitch is left at azimuth {np.degrees(self.azimuth[row]):.1f} "
                f"deg (from {np.degrees(low[row]):.3f} to {np.degrees(high[row]):.3f} deg)"
            )
        if np.all(low <= self.lower) and np.all(high >= self.upper):
            return self
        margin = 10 * _MIN_SPACING
        rows = [
            np.concatenate(([low[n]], b[(b > low[n] + margin) & (b < high[n] - margin)], [high[n]]))
            for n, b in enumerate(self.beta)
        ]
        width = max(row.size for row in rows)
        beta = np.stack([pad_row(row, width) for row in rows])
        torque, bending, thrust, radial = (
            np.stack(
                [
                    np.interp(beta[n], self.beta[n], getattr(self, name)[n])
                    for n in range(self.stations)
                ]
            )
            for name in CURVES
        )
        return replace(
            self, beta=beta, torque=torque, bending=bending, thrust=thrust, radial=radial
        )

    def thinned(self, positions: int) -> BladeCurves:
        """Curves at another, smaller number of rotor positions, each that of the nearest station.

        An approximation, for first looks at large problems.

        Raises
        ------
        InputError
            If ``positions`` is not from 1 to the present number.
        """
        count = whole_number("positions", positions, at_least=1)
        if count > self.positions:
            raise InputError(f"positions: got {count}, the curves have {self.positions}")
        turn = np.arange(self.blades * count) / (self.blades * count)
        rows = np.rint(turn * self.stations).astype(int)
        few = {name: getattr(self, name)[rows] for name in ("beta", *CURVES, *RATES)}
        return replace(self, azimuth=self.azimuth[0] + 2 * np.pi * turn, **few)

    # ---- files ---------------------------------------------------------------------------

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the curves to one ``.npz`` or ``.csv`` table, whole or not at all.

        See :mod:`pitchopt.aero.tables` for what stands in them.
        """
        columns = {name: np.asarray(getattr(self, name)) for name in CURVES + RATES}
        return write_table(
            Path(path), self.blades, self.mean_pitch, self.azimuth, self.beta, columns
        )

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> BladeCurves:
        """Read curves that :meth:`save` or any other aerodynamic code wrote.

        Rows of a station may differ in number: shorter ones are padded by splitting segments,
        which changes no curve.

        Raises
        ------
        InputError
            If the file is missing, empty, huge, not a table, or its numbers are no curves.
        """
        return cls(**read_table(Path(path)))
