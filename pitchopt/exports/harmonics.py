r"""A pitch profile as a Fourier series over azimuth, and the table of its harmonics.

For N evenly spaced stations the series through all of them is, with M = floor(N / 2),

    beta(psi) = sum_{n=0}^{M} a_n cos(n psi) + b_n sin(n psi)
              = a_0 + sum_n A_n cos(n psi - phase_n),

A_n = hypot(a_n, b_n), phase_n = atan2(b_n, a_n): the azimuth n psi at which the harmonic is
largest.  For even N the last harmonic is the one with alternating signs at the stations; it has
one coefficient, and its phase is tied to the first station.  Harmonic n is called nP: n per
revolution.  Pitch is positive towards feather; azimuth 0 is the blade up.
"""

from __future__ import annotations

import csv
import io
import os
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pitchopt.checks import FloatArray, finite_array
from pitchopt.errors import InputError
from pitchopt.exports.files import read_text

__all__ = ["Harmonics", "even_turn", "harmonics", "harmonics_csv", "read_harmonics_csv"]


_COLUMNS = ("harmonic", "cos_deg", "sin_deg", "amplitude_deg", "phase_deg")


@dataclass(frozen=True, kw_only=True, eq=False)
class Harmonics:
    """Fourier series of a profile.

    Parameters
    ----------
    cosine, sine : array (M + 1,)
        a_n and b_n [rad], n = 0 .. M; a_0 is the mean.
    """

    cosine: FloatArray
    sine: FloatArray

    def __post_init__(self) -> None:
        for name in ("cosine", "sine"):
            value = np.array(getattr(self, name), dtype=np.float64)
            if value.ndim != 1 or value.size == 0 or not np.all(np.isfinite(value)):
                raise InputError(f"{name}: expected a vector of finite numbers")
            value.setflags(write=False)
            object.__setattr__(self, name, value)
        if self.cosine.shape != self.sine.shape:
            raise InputError(
                f"cosine, sine: got shapes {self.cosine.shape} and {self.sine.shape}, expected "
                "equal ones"
            )

    @property
    def mean(self) -> float:
        """Mean pitch [rad]."""
        return float(self.cosine[0])

    @property
    def amplitude(self) -> FloatArray:
        """A_n [rad], shape (M + 1,); the first entry is the mean's absolute value."""
        return np.hypot(self.cosine, self.sine)

    @property
    def phase(self) -> FloatArray:
        """phase_n [rad], shape (M + 1,)."""
        return np.arctan2(self.sine, self.cosine)

    def __call__(self, azimuth: ArrayLike, derivative: int = 0) -> FloatArray:
        """Pitch, or its derivative with respect to azimuth, at angles of any shape.

        Parameters
        ----------
        azimuth : array_like
            [rad].
        derivative : int
            0: pitch [rad]; 1: d beta / d psi [-]; 2: the second derivative [1/rad].
        """
        psi = np.asarray(azimuth, dtype=np.float64)[..., None]
        order = np.arange(self.cosine.size)
        turned = order * psi + 0.5 * np.pi * derivative
        terms = self.cosine * np.cos(turned) + self.sine * np.sin(turned)
        return np.asarray((terms * order.astype(np.float64) ** derivative).sum(axis=-1))


def even_turn(azimuth: ArrayLike, profile: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Stations and pitch of a profile (N,), checked: evenly spaced over one turn, ascending.

    Raises
    ------
    InputError
        If a shape differs, a number is none, or the azimuth [rad] is in degrees, uneven, or covers
        another part of the turn.
    """
    psi = finite_array("azimuth", azimuth)
    beta = finite_array("profile", profile)
    if beta.shape != psi.shape:
        raise InputError(f"profile: got shape {beta.shape}, expected {psi.shape} as azimuth has")
    station = 2.0 * np.pi / psi.size
    if psi.size > 1 and np.abs(np.diff(psi) - station).max() > 1e-3 * station:
        raise InputError(
            f"azimuth: got {psi[0]:.4g} to {psi[-1]:.4g} rad at {psi.size} stations, expected "
            f"stations {station:.6g} rad apart, evenly over one turn"
        )
    return psi, beta


def harmonics(azimuth: ArrayLike, profile: ArrayLike) -> Harmonics:
    """Fourier series through all stations of a profile.

    Parameters
    ----------
    azimuth : array (N,)
        Evenly spaced over one turn [rad].
    profile : array (N,)
        Pitch [rad].
    """
    psi, beta = even_turn(azimuth, profile)
    spectrum = np.fft.rfft(beta) / beta.size
    order = np.arange(spectrum.size)
    spectrum = spectrum * np.exp(-1j * order * psi[0])
    double = np.full(order.size, 2.0)
    double[0] = 1.0
    if beta.size % 2 == 0 and order.size > 1:
        double[-1] = 1.0
    return Harmonics(cosine=double * spectrum.real, sine=-double * spectrum.imag)


def harmonics_csv(series: Harmonics) -> str:
    """Table of a series: one row per harmonic nP, angles in degrees; row 0 is the mean."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(_COLUMNS)
    columns = (series.cosine, series.sine, series.amplitude, series.phase)
    for n, row in enumerate(zip(*map(np.rad2deg, columns), strict=True)):
        writer.writerow((n, *(repr(float(value)) for value in row)))
    return text.getvalue()


def read_harmonics_csv(path: str | os.PathLike[str]) -> Harmonics:
    """Read the table that :func:`harmonics_csv` makes; amplitude and phase are not needed."""
    rows = list(csv.DictReader(io.StringIO(read_text(path, "harmonics file"))))
    try:
        order = [int(row["harmonic"]) for row in rows]
        cosine = [float(row["cos_deg"]) for row in rows]
        sine = [float(row["sin_deg"]) for row in rows]
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(
            f"harmonics file: {path} needs the columns harmonic, cos_deg and sin_deg with numbers"
        ) from error
    if not order or order != list(range(len(order))):
        raise InputError(f"harmonics file: {path} must list the harmonics 0, 1, 2, ... in order")
    return Harmonics(cosine=np.deg2rad(cosine), sine=np.deg2rad(sine))
