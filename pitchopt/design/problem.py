"""The design problem in one normal form, and the load weights that enter it.

    maximise   a T(beta) - sum_l lambda_l J_l(beta) - lambda_b J_blade(beta) - kappa V(beta)
    subject to torque_min <= T <= torque_max,  J_blade <= blade_cap,
               range, stall and rate limits,  mean(beta) = beta_mean (frozen wake),
               beta a Fourier sum up to harmonic nP (if asked for).

T is mean torque, J_l the RMS about their means of torque, tilt, yaw and thrust over the rotor
positions, J_blade the RMS of one blade's bending over the turn, V = sum_n |beta_{n+1} - beta_n|
the pitch travel of a revolution.  The trade-off has a = 1, lambda = mu w (paper 003, eq. (6));
designs for a given loss or a given torque have a = 0 and lambda = w.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pitchopt.aero.curves import BladeCurves, RotorLoads
from pitchopt.checks import finite_number, whole_number
from pitchopt.design.coarse import stride
from pitchopt.design.limits import PitchLimits
from pitchopt.design.smoothing import smoothed
from pitchopt.errors import InputError

__all__ = ["DesignProblem", "LoadWeights", "Objective"]

FloatArray = NDArray[np.float64]

_COARSEST = 24  # positions at which local solves from different starts end alike
_LARGEST_PRICE = 1e12  # beyond this torque is lost in rounding


@dataclass(frozen=True, kw_only=True)
class LoadWeights:
    """Weights of the AC loads in the objective, relative to mean torque.

    Parameters
    ----------
    torque, tilt, yaw : float
        Weights of the moments [-].
    thrust : float
        Weight of the thrust [m]: an arm that makes a force comparable with a moment.
    blade : float
        Weight of one blade's bending [-].
    name : str
        What the set is called in tables.
    """

    torque: float = 1.0
    tilt: float = 1.0
    yaw: float = 1.0
    thrust: float = 1.0
    blade: float = 0.0
    name: str = "custom"

    def __post_init__(self) -> None:
        for field_name in ("torque", "tilt", "yaw", "thrust", "blade"):
            value = finite_number(f"weights.{field_name}", getattr(self, field_name), at_least=0)
            object.__setattr__(self, field_name, value)

    @classmethod
    def unit(cls) -> LoadWeights:
        """The paper's weights (1, 1, 1, 1): a newton of thrust counts like a newton metre."""
        return cls(name="unit")

    @classmethod
    def tower_base(cls, hub_height: float) -> LoadWeights:
        """Thrust counted as the moment that it exerts at the tower base."""
        return cls(thrust=finite_number("hub_height", hub_height, above=0), name="tower-base")

    @property
    def array(self) -> FloatArray:
        """Weights of torque, tilt, yaw, thrust and blade, shape (5,)."""
        return np.array([self.torque, self.tilt, self.yaw, self.thrust, self.blade])

    def weighted(self, loads: RotorLoads) -> float:
        """Weighted sum of the RMS values [N m]."""
        return float(self.array[:4] @ loads.rms + self.blade * loads.blade_rms)


@dataclass(frozen=True, kw_only=True)
class Objective:
    """Numbers of the normal form; ``rms`` holds lambda for the five loads, shape (5,)."""

    torque: float
    rms: tuple[float, float, float, float, float]
    travel: float = 0.0
    torque_min: float = -np.inf
    torque_max: float = np.inf
    blade_cap: float = np.inf

    def __post_init__(self) -> None:
        if np.shape(self.rms) != (5,) or any(not np.isfinite(v) or v < 0 for v in self.rms):
            raise InputError(f"rms weights: got {self.rms}, expected five numbers of 0 or more")
        finite_number("torque gain", self.torque, at_least=0)
        finite_number("travel penalty", self.travel, at_least=0)
        if np.isnan(self.torque_min) or np.isnan(self.torque_max):
            raise InputError("mean torque: got NaN, expected a number")
        if self.torque_min > self.torque_max:
            raise InputError(
                f"mean torque: lower limit {self.torque_min:g} N m above the upper limit "
                f"{self.torque_max:g} N m"
            )
        if not self.blade_cap > 0:
            raise InputError(f"blade cap: got {self.blade_cap} N m, expected more than 0")

    @classmethod
    def tradeoff(cls, mu: float, weights: LoadWeights, **limits: float) -> Objective:
        """Mean torque minus ``mu`` times the weighted RMS."""
        mu = finite_number("mu", mu, at_least=0, at_most=_LARGEST_PRICE)
        return cls(torque=1.0, rms=_five(mu * weights.array), **limits)

    @classmethod
    def least_rms(cls, weights: LoadWeights, **limits: float) -> Objective:
        """Least weighted RMS, under limits on mean torque."""
        return cls(torque=0.0, rms=_five(weights.array), **limits)

    @property
    def lambdas(self) -> FloatArray:
        """Weights of the five RMS values, shape (5,)."""
        return np.array(self.rms)


def _five(values: FloatArray) -> tuple[float, float, float, float, float]:
    a, b, c, d, e = (float(v) for v in values)
    return a, b, c, d, e


@dataclass(frozen=True, kw_only=True, eq=False)
class DesignProblem:
    """Curves, limits and structural restrictions of the profile.

    Parameters
    ----------
    curves : BladeCurves
        Loads of a blade over pitch; narrowed to the limits at construction.
    limits : PitchLimits
        Range and rate of the actuators.
    harmonics : int, optional
        Restrict the profile to a mean and harmonics 1P .. nP.

    Raises
    ------
    InputError
        If the limits leave no constant pitch, the frozen mean pitch lies outside them or
        ``harmonics`` is negative.
    """

    curves: BladeCurves
    limits: PitchLimits
    harmonics: int | None = None

    def __post_init__(self) -> None:
        if self.harmonics is not None:
            whole_number("harmonics", self.harmonics, at_least=0)
        curves = self.limits.applied(self.curves)
        object.__setattr__(self, "curves", curves)
        mean = curves.mean_pitch
        if mean is not None and not curves.lower.max() <= mean <= curves.upper.min():
            raise InputError(
                f"mean_pitch: frozen at {np.degrees(mean):.3f} deg, outside the constant pitches "
                f"{np.degrees(curves.lower.max()):.3f} to {np.degrees(curves.upper.min()):.3f} "
                "deg that the limits leave"
            )

    @property
    def constant_range(self) -> tuple[float, float]:
        """Lowest and highest constant pitch that every station admits [rad]."""
        mean = self.curves.mean_pitch
        if mean is not None:
            return mean, mean
        return float(self.curves.lower.max()), float(self.curves.upper.min())

    @cached_property
    def step(self) -> float:
        """Largest change of pitch between neighbouring stations [rad]."""
        return self.limits.step(self.curves.stations)

    @cached_property
    def torque_scale(self) -> float:
        """Mean over the stations of the largest torque of all blades [N m]."""
        return float(self.largest_loads[0].mean()) * self.curves.blades or 1.0

    @cached_property
    def largest_loads(self) -> FloatArray:
        """Largest size of the five loads over pitch at each station, shape (5, N)."""
        loads = self.curves.loads
        return np.asarray(np.maximum(loads.max(axis=2), -loads.min(axis=2)))

    @cached_property
    def coarse(self) -> DesignProblem | None:
        """The problem at every s-th rotor position, None where the positions are few."""
        return self._thinned(stride(self.curves.positions))

    @cached_property
    def coarsest(self) -> DesignProblem | None:
        """The problem at about two dozen rotor positions, None where there are no more."""
        return self._thinned(stride(self.curves.positions, _COARSEST))

    def _thinned(self, step: int) -> DesignProblem | None:
        if step == 1:
            return None
        return self.with_curves(self.curves.thinned(self.curves.positions // step))

    @cached_property
    def softened(self) -> DesignProblem:
        """The problem on smoothed curves, to tell starts apart by."""
        return self.with_curves(smoothed(self.curves))

    @cached_property
    def constant_only(self) -> bool:
        """True when rate or harmonics leave constant pitch only."""
        span = float(np.max(self.curves.upper - self.curves.lower))
        return self.step <= 1e-9 * max(span, 1e-12) or self.harmonics == 0

    @cached_property
    def basis(self) -> FloatArray | None:
        """Fourier basis (N, 1 + 2 nP) of the restricted profile, or None."""
        if self.harmonics is None:
            return None
        psi = self.curves.azimuth
        top = min(self.harmonics, (self.curves.stations - 1) // 2)
        columns = [np.ones_like(psi)]
        for order in range(1, top + 1):
            columns += [np.cos(order * psi), np.sin(order * psi)]
        return np.stack(columns, axis=1)

    def repaired(self, profile: FloatArray) -> FloatArray:
        """A profile that keeps range and rate exactly, and mean and harmonics to rounding.

        Solver output is off by its tolerance; the repair shrinks the profile towards a
        constant one (or clips, when nothing ties the stations together).
        """
        curves, limits = self.curves, self.limits
        if self.basis is None and curves.mean_pitch is None:
            return limits.repaired(curves, profile)
        beta = np.array(profile, dtype=np.float64)
        if self.basis is not None:
            beta = self.basis @ np.linalg.lstsq(self.basis, beta, rcond=None)[0]
        low, high = self.constant_range
        if curves.mean_pitch is not None:
            beta += curves.mean_pitch - beta.mean()
        centre = float(np.clip(beta.mean(), low, high))
        offset = beta - centre
        change = np.abs(np.roll(beta, -1) - beta).max()
        share = 1.0 if change <= self.step else self.step / change
        with np.errstate(divide="ignore", invalid="ignore"):
            room = np.where(
                offset > 0,
                (curves.upper - centre) / offset,
                np.where(offset < 0, (curves.lower - centre) / offset, np.inf),
            )
        return np.asarray(centre + min(share, float(room.min())) * offset)

    def travel(self, profile: FloatArray) -> float:
        """Pitch travel of one revolution, sum ``|beta_{n+1} - beta_n|`` [rad]."""
        return float(np.abs(np.roll(profile, -1) - profile).sum())

    def value(self, profile: FloatArray, objective: Objective) -> float:
        """Objective of the normal form, constraints not counted [N m]."""
        return self.value_of(self.curves.evaluate(profile), self.travel(profile), objective)

    @staticmethod
    def value_of(loads: RotorLoads, travel: float, objective: Objective) -> float:
        """Objective from loads that are already known [N m]."""
        lam = objective.lambdas
        rms = float(lam[:4] @ loads.rms + lam[4] * loads.blade_rms)
        return objective.torque * float(loads.mean[0]) - rms - objective.travel * travel

    @staticmethod
    def excess(loads: RotorLoads, objective: Objective) -> tuple[float, float]:
        """Violation of the mean-torque limits and of the blade cap [N m], zero if kept."""
        torque = float(loads.mean[0])
        return (
            max(objective.torque_min - torque, torque - objective.torque_max, 0.0),
            max(loads.blade_rms - objective.blade_cap, 0.0),
        )

    def with_curves(self, curves: BladeCurves) -> DesignProblem:
        """The same limits and restrictions on other curves."""
        return replace(self, curves=curves)
