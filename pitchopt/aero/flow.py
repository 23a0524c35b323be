"""Flow at the sections of a turning rotor, with or without induction.

Adds to the geometry of `rotor` what the momentum balance of `induction` needs from the whole
rotor: loss constants from the length along the blade, and the skew of the wake from the mean
wind over all stations of all blades at the same instant.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pitchopt.aero.induction import (
    Momentum,
    SectionPolars,
    skew_redistribution,
    solve_induction,
)
from pitchopt.aero.rotor import Inflow, Rotor, Sections, hub_axes
from pitchopt.checks import FloatArray

__all__ = ["Flow", "balanced_flow", "free_flow", "loss_constants", "wake_skew"]


class Flow(NamedTuple):
    """Flow at the sections, (..., E).

    Attributes
    ----------
    sections : geometry of the sections.
    normal, tangential : wind relative to the section, induction included [m/s].
    induced_normal, induced_tangential : the induced part of it [m/s].
    phi : inflow angle [rad].
    square : squared speed [m^2/s^2].
    """

    sections: Sections
    normal: FloatArray
    tangential: FloatArray
    induced_normal: FloatArray
    induced_tangential: FloatArray
    phi: FloatArray
    square: FloatArray

    @classmethod
    def of(
        cls,
        sections: Sections,
        normal: FloatArray,
        tangential: FloatArray,
        induced: tuple[FloatArray, FloatArray] | None = None,
    ) -> Flow:
        """Flow with given relative wind and induced velocities (zero if absent)."""
        zero = np.zeros(np.broadcast_shapes(normal.shape, tangential.shape))
        induced_n, induced_t = induced or (zero, zero)
        n, t = normal + induced_n, tangential + induced_t
        return cls(
            sections=sections,
            normal=n,
            tangential=t,
            induced_normal=induced_n,
            induced_tangential=induced_t,
            phi=np.asarray(np.arctan2(n, t)),
            square=n * n + t * t,
        )


def loss_constants(rotor: Rotor) -> tuple[FloatArray, FloatArray]:
    """Constants B (R - r) / (2 r) and B (r - R_h) / (2 R_h) of the tip and hub loss, (E,).

    r is the hub radius plus the length along the curved blade; with quadrature ``elements`` R is
    the end of the last element.  Without a hub radius the hub loss vanishes (F = 1).
    """
    blade = rotor.blade
    prebend, sweep = blade.offsets
    points = np.stack([prebend, sweep, blade.span], axis=1)
    steps = np.linalg.norm(np.diff(points, axis=0, prepend=np.zeros((1, 3))), axis=1)
    along = rotor.hub_radius + np.cumsum(steps)
    tip = along[-1] + (blade.length - blade.span[-1])
    outer = rotor.blades * (tip - along) / (2 * along)
    if rotor.hub_radius > 0.0:
        inner = rotor.blades * (along - rotor.hub_radius) / (2 * rotor.hub_radius)
    else:
        inner = np.full(along.size, 1e9)
    return outer, inner


def wake_skew(
    rotor: Rotor, inflow: Inflow, azimuth: FloatArray, pitch: FloatArray, yaw: float
) -> tuple[FloatArray, FloatArray]:
    """Skew angle chi_0 [rad] and sin psi_s of the blade at `azimuth` (...).

    chi_0 lies between the shaft and the wind averaged over all stations of all blades;
    sin psi_s is the component of e_r along that wind's direction in the rotor plane.
    """
    total = np.zeros((*np.broadcast_shapes(azimuth.shape, pitch.shape), 3))
    for k in range(rotor.blades):
        psi = azimuth + 2 * np.pi * k / rotor.blades
        place = rotor.sections(psi, pitch, yaw).position
        velocity = inflow.velocity(place[..., 0], place[..., 1], place[..., 2])
        total = total + np.asarray(velocity).mean(axis=-2)
    hub = hub_axes(rotor.tilt, yaw)
    along, lateral, upward = total @ hub[0], total @ hub[1], total @ hub[2]
    across = np.hypot(lateral, upward)
    unit = np.where(across > 0.0, across, 1.0)
    sin_psi = (upward * np.cos(azimuth) - lateral * np.sin(azimuth)) / unit
    return np.asarray(np.arctan2(across, along)), np.asarray(sin_psi)


def _relative(
    rotor: Rotor,
    inflow: Inflow,
    rotor_speed: float,
    azimuth: FloatArray,
    pitch: FloatArray,
    pitch_rate: FloatArray,
    yaw: float,
) -> tuple[Sections, FloatArray, FloatArray]:
    sections = rotor.sections(azimuth, pitch, yaw)
    wind = rotor.wind(inflow, sections, azimuth, rotor_speed, yaw)
    rate = pitch_rate[..., None]
    return sections, wind.normal - rate * sections.y, wind.tangential + rate * sections.x


def free_flow(
    rotor: Rotor,
    inflow: Inflow,
    rotor_speed: float,
    azimuth: FloatArray,
    pitch: FloatArray,
    *,
    pitch_rate: FloatArray | None = None,
    yaw: float = 0.0,
    induced: tuple[FloatArray, FloatArray] | None = None,
) -> Flow:
    """Flow without a momentum balance: no induction, or given induced velocities (..., E)."""
    rate = np.zeros(()) if pitch_rate is None else pitch_rate
    sections, normal, tangential = _relative(rotor, inflow, rotor_speed, azimuth, pitch, rate, yaw)
    return Flow.of(sections, normal, tangential, induced)


def balanced_flow(
    rotor: Rotor,
    inflow: Inflow,
    rotor_speed: float,
    azimuth: FloatArray,
    pitch: FloatArray,
    *,
    polars: SectionPolars,
    pitch_rate: FloatArray | None = None,
    yaw: float = 0.0,
    skew: bool = True,
    skew_pitch: FloatArray | None = None,
    momentum: Momentum | None = None,
) -> Flow:
    """Flow in momentum balance at every azimuth and pitch (broadcast to (...)).

    `skew_pitch` is the pitch at which the mean wind over the rotor is taken (default: `pitch`);
    it only shifts stations off the pitch axis by centimetres.
    """
    rate = np.zeros(()) if pitch_rate is None else pitch_rate
    sections, normal, tangential = _relative(rotor, inflow, rotor_speed, azimuth, pitch, rate, yaw)
    tip, hub = loss_constants(rotor)
    solidity = rotor.blades * rotor.blade.chord / (2 * np.pi * sections.radius)
    result = solve_induction(
        polars,
        normal,
        tangential,
        rotor.blade.twist + pitch[..., None],
        solidity,
        tip,
        hub,
        momentum,
    )
    axial = result.axial
    if skew:
        angle, sin_psi = wake_skew(
            rotor, inflow, azimuth, pitch if skew_pitch is None else skew_pitch, yaw
        )
        share = sections.radius / sections.radius[..., -1:]
        skewed = skew_redistribution(axial, angle[..., None], share, sin_psi[..., None])
        axial = np.where(result.solved, skewed, axial)
    return Flow.of(sections, normal, tangential, (-axial * normal, result.tangential * tangential))
