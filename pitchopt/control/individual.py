"""Individual pitch control: an integrator for tilt and one for yaw at each harmonic.

The out-of-plane moments of the blade roots pass the multiblade transform at n times the rotor
speed; tilt and yaw part are integrated with one gain, and the inverse transform, turned by an
azimuth offset, makes of them an addition to each blade's pitch:

    d(tilt part)/dt = gain tilt_n,    d(yaw part)/dt = gain yaw_n.

Moments are positive downwind and pitch towards feather takes load off, so a positive gain reduces
the load.  On a rigid rotor whose moments follow the pitch at once, M = M_0 - k beta, and an
actuator of first order, the fixed-frame loop from pitch command to load is a gain and a turn
by the actuator's phase at n times the rotor speed omega: the offset

    offset_n = atan(n omega tau) / n

takes the turn out and tilt and yaw are decoupled.

The length of (tilt part, yaw part) keeps within a limit, and does not grow while the range or
rate of a blade cuts its command (anti-windup).  The limit can fade in with the collective pitch
and with the time since the start; nothing winds up meanwhile.

Source: S. Mulders, A. Pamososuryo, J.-W. van Wingerden, "Efficient tuning of Individual Pitch
Control", 2020, section 2.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pitchopt.checks import FloatArray, finite_array, finite_number
from pitchopt.control.multiblade import harmonic
from pitchopt.control.parameters import IndividualParameters, table
from pitchopt.errors import InputError

__all__ = ["IndividualPitch", "decoupling_offset"]

_LIMIT = math.radians(5.0)


def decoupling_offset(order: int, rotor_speed: float, time_constant: float) -> float:
    """Azimuth offset atan(n omega tau) / n [rad] of a rigid rotor with actuators of first order.

    Parameters
    ----------
    order : int
        n.
    rotor_speed : float
        omega [rad/s].
    time_constant : float
        tau [s].
    """
    n = harmonic(order)
    omega = finite_number("rotor_speed", rotor_speed, at_least=0.0)
    tau = finite_number("time_constant", time_constant, at_least=0.0)
    return math.atan(n * omega * tau) / n


@dataclass(frozen=True, kw_only=True, eq=False)
class IndividualPitch:
    """Integral individual pitch control at some harmonics.

    Parameters
    ----------
    gain : array_like (H,)
        Integral gains [rad/(N m s)]; positive reduces the load.
    offset : array_like (H,), optional
        Azimuth offsets [rad]; zero without.
    order : array_like (H,), optional
        Harmonics n, different, no multiples of three; 1, 2, ... without.
    limit : array_like (H,) or float, optional
        Largest amplitude of each harmonic's pitch [rad]; 5 degrees without.
    fade_from, fade_to : float, optional
        Collective pitch between which the limit grows from nothing to its full size [rad]; equal
        for no fade.
    fade_time : float, optional
        Time since the start over which it grows [s].

    Raises
    ------
    InputError
        If a number or a harmonic is out of range.
    """

    gain: FloatArray
    offset: ArrayLike | None = None
    order: ArrayLike | None = None
    limit: ArrayLike = _LIMIT
    fade_from: float = 0.0
    fade_to: float = 0.0
    fade_time: float = 0.0

    def __post_init__(self) -> None:
        gain = finite_array("gain", self.gain)
        count = gain.size
        orders = np.arange(1, count + 1) if self.order is None else np.asarray(self.order)
        if orders.shape != (count,):
            raise InputError(f"order: got shape {orders.shape}, expected {(count,)} as the gains")
        order = finite_array("order", [harmonic(n) for n in orders.tolist()])
        if np.unique(order).size != count:
            raise InputError(f"order: got {order.tolist()}, expected different harmonics")
        offset = np.zeros(count) if self.offset is None else self.offset
        limit = np.full(count, self.limit) if np.ndim(self.limit) == 0 else self.limit
        object.__setattr__(self, "gain", gain)
        object.__setattr__(self, "order", order)
        object.__setattr__(self, "offset", finite_array("offset", offset, shape=(count,)))
        limits = finite_array("limit", limit, shape=(count,))
        if np.any(limits <= 0.0):
            raise InputError(f"limit: got {limits.tolist()} rad, expected positive amplitudes")
        object.__setattr__(self, "limit", limits)
        finite_number("fade_from", self.fade_from)
        finite_number("fade_to", self.fade_to, at_least=self.fade_from)
        finite_number("fade_time", self.fade_time, at_least=0.0)

    def parameters(self) -> IndividualParameters:
        """Numbers for the compiled loops."""
        lead = np.asarray(self.order) * np.asarray(self.offset)
        return IndividualParameters(
            on=1,
            order=table(np.asarray(self.order)),
            gain=table(self.gain),
            lead_cos=table(np.cos(lead)),
            lead_sin=table(np.sin(lead)),
            limit=table(np.asarray(self.limit)),
            fade_from=float(self.fade_from),
            fade_to=float(self.fade_to),
            fade_time=float(self.fade_time),
        )
