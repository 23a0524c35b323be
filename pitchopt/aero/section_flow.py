"""Flow and loads of a rotor's blade sections, with or without an answer of the wake to pitch.

What `pitchopt.aero.static_rotor.StaticRotor` is made of: the flow of every section at azimuths
and pitches, in momentum balance (`SectionFlow.balanced`) or held (`SectionFlow.held`, see
`pitchopt.aero.fixed_inflow`), and the loads that the tables of the polars give in it.

Signs and frames: see `rotor` and `loads`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pitchopt.aero.fits import PolarFit, fit_polar
from pitchopt.aero.fixed_inflow import FixedInflow
from pitchopt.aero.flow import Flow, balanced_flow, free_flow, loss_constants
from pitchopt.aero.induction import Momentum, SectionPolars
from pitchopt.aero.loads import LoadMap, load_map
from pitchopt.aero.rotor import Inflow, Rotor
from pitchopt.aero.section_limits import section_limits
from pitchopt.aero.stall import check_coverage
from pitchopt.checks import FloatArray

__all__ = ["SectionFlow"]

_CHUNK = 40_000  # sections solved at a time


@dataclass(frozen=True, kw_only=True, eq=False)
class SectionFlow:
    """Sections of a rotor that turns steadily; the fields are those of `StaticRotor`.

    Parameters
    ----------
    rotor : Rotor
    wind : Inflow
    rotor_speed, air_density, yaw : float
        [rad/s], [kg/m^3], [rad].
    alpha_limits : (float or None, float or None)
        Angle-of-attack limits of fitted sections [rad].
    segments : int
        Linear pieces of each polar fit.
    radial_moment, skew : bool
    momentum : Momentum or None
    """

    rotor: Rotor
    wind: Inflow
    rotor_speed: float
    air_density: float
    yaw: float
    alpha_limits: tuple[float | None, float | None]
    segments: int
    radial_moment: bool
    skew: bool
    momentum: Momentum | None

    @cached_property
    def polars(self) -> SectionPolars:
        """Tables of all sections."""
        return SectionPolars(self.rotor.blade.polars)

    @cached_property
    def blocked(self) -> NDArray[np.bool_]:
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
        limits = section_limits(polars, self.alpha_limits, alpha, self.blocked)
        return tuple(
            None if pair is None else fit_polar(polar, pair, self.segments)
            for polar, pair in zip(polars, limits, strict=True)
        )

    def _load_map(self, flow: Flow) -> LoadMap:
        return load_map(
            flow.sections,
            self.rotor.blade.chord,
            self.rotor.cone,
            flow.phi,
            0.5 * self.air_density * flow.square,
            radial_moment=self.radial_moment,
        )

    def balanced(
        self, psi: FloatArray, pitch: FloatArray, rate: FloatArray, mean_pitch: FloatArray
    ) -> Flow:
        """Flow in momentum balance at azimuths, pitches [rad] and pitch rates [rad/s] (...).

        The mean wind over the rotor, for the skew, is taken at `mean_pitch` [rad].
        """
        return balanced_flow(
            self.rotor,
            self.wind,
            self.rotor_speed,
            psi,
            pitch,
            polars=self.polars,
            pitch_rate=rate,
            yaw=self.yaw,
            skew=self.skew,
            skew_pitch=mean_pitch,
            momentum=self.momentum,
        )

    def table_loads(self, flow: Flow, pitch: FloatArray) -> FloatArray:
        """Loads (4, ...) of a flow with the tables of the polars."""
        mapping, blade = self._load_map(flow), self.rotor.blade
        alpha = flow.phi - blade.twist - pitch[..., None]
        check_coverage(blade.polars, alpha)
        return mapping.apply(*self.polars.coefficients(alpha))

    def held(
        self, psi: FloatArray, mean_pitch: float | None, rate: FloatArray | None = None
    ) -> FixedInflow:
        """Sections in held flow at azimuths (...) [rad].

        With `mean_pitch` [rad] the induced velocity is that of the momentum balance there, without
        it there is none.  A pitch rate (...) [rad/s] moves the sections in that flow.
        """
        zero = np.zeros(())
        if mean_pitch is None:
            flow = free_flow(
                self.rotor, self.wind, self.rotor_speed, psi, zero, pitch_rate=rate, yaw=self.yaw
            )
            fits = self._fits(None)
        else:
            mean = np.asarray(mean_pitch)
            balanced = self.balanced(psi, np.full(psi.shape, mean_pitch), zero, mean)
            fits = self._fits(balanced.phi - self.rotor.blade.twist - mean_pitch)
            flow = balanced
            if rate is not None:
                flow = free_flow(
                    self.rotor,
                    self.wind,
                    self.rotor_speed,
                    psi,
                    np.full(psi.shape, mean_pitch),
                    pitch_rate=rate,
                    yaw=self.yaw,
                    induced=(balanced.induced_normal, balanced.induced_tangential),
                )
        mapping = self._load_map(flow)
        base = flow.phi - self.rotor.blade.twist
        if mean_pitch is not None:
            # torque must fall with drag and rise with lift for the fit to keep it concave
            wrong = (mapping.lift[0] < 0.0) | (mapping.drag[0] > 0.0)
            bad = wrong.reshape(-1, wrong.shape[-1]).any(axis=0)
            fits = tuple(None if bad[e] else fit for e, fit in enumerate(fits))
        return FixedInflow.build(base, mapping, fits, self.polars, mean_pitch)

    def chunks(self, stations: int, pitches: int) -> list[slice]:
        """Runs of stations short enough to bound memory whatever the number of stations."""
        step = max(1, _CHUNK // (pitches * self.rotor.blade.span.size))
        return [slice(k, k + step) for k in range(0, stations, step)]
