"""Azimuth offset that decouples tilt from yaw: measured on the dynamic turbine, and in closed form.

In steady uniform wind each blade b pitches by

    theta_t cos(n (psi_b + offset)) + theta_y sin(n (psi_b + offset))

beside its collective pitch, and the tilt and yaw parts of the root moments out of plane
(`pitchopt.control.multiblade`) change by G(offset) (theta_t, theta_y) once all has settled.  The
offset turns the pair before it acts, G(offset) = G(0) T(n offset) with

    T(angle) = [[cos, sin], [-sin, cos]],

so what stands off the diagonal, as a share of the whole,

    coupling^2 = (G_12^2 + G_21^2) / sum G_ij^2,

varies as the cosine of 2 n offset, and the minimum at which a positive gain takes load off (both
entries on the diagonal negative) is the decoupling offset.

Closed form: a rigid rotor whose moments follow the pitch at once answers with M = M_0 - k beta,
and only the actuators turn the pair.  Actuators of first order with time constant tau lag by
atan(n omega tau) at n per turn, so

    offset_n = atan(n omega tau) / n.

A controller that is called every h seconds acts on an azimuth that is up to h old.  Actuators of
first order then pass (1 - a)/(z - a), a = exp(-h/tau), z = exp(i n omega h), and without dynamics
1/z; the phase of that is the offset of the sampled loop, which tends to the closed form with h.

On a real blade the aerodynamic centre stands e ahead of the pitch axis and feels the pitch rate,
which at radius r leads by e/r at every harmonic: 0.5 degrees on the NREL 5 MW.  A flexible blade
lags the more the nearer n times the rotor speed comes to its flapwise frequency.

Source: S. Mulders, A. Pamososuryo, G. Disario, J.-W. van Wingerden, "Analysis and optimal
individual pitch control decoupling by inclusion of an azimuth offset in the multiblade coordinate
transformation", Wind Energy 22, 2019.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pitchopt.checks import FloatArray, finite_array, finite_number
from pitchopt.control import Controller, from_fixed_frame, to_fixed_frame
from pitchopt.control.multiblade import harmonic
from pitchopt.control.signals import AZIMUTH, COMMANDS, PITCH, PITCH_COMMAND, TORQUE
from pitchopt.errors import ComputationError
from pitchopt.sim import DynamicTurbine, Operation, simulate
from windfield import StaticField

__all__ = [
    "Decoupling",
    "FixedFrameResponse",
    "fixed_frame_response",
    "measure_decoupling",
    "sampled_offset",
]

_AMPLITUDE = math.radians(0.5)
_SETTLING = 60.0  # before the moments are taken [s]
_TURNS = 8  # over which they are taken


@dataclass(frozen=True, kw_only=True, eq=False)
class FixedFrameResponse:
    """Steady answer of the moments' tilt and yaw parts to those of the pitch.

    Attributes
    ----------
    order : int
        Harmonic n.
    offset : float
        With which the pitch was played [rad].
    matrix : ndarray (2, 2)
        [N m/rad]; rows are moments, columns pitch, tilt before yaw.
    """

    order: int
    offset: float
    matrix: FloatArray

    @property
    def coupling(self) -> float:
        """Share off the diagonal [-], 0 to 1."""
        g = self.matrix
        return float(math.hypot(g[0, 1], g[1, 0]) / np.linalg.norm(g))

    @property
    def relative_gain(self) -> float:
        """Relative gain G_11 G_22 / det G of tilt with tilt [-]; 1 where nothing is coupled."""
        g = self.matrix
        return float(g[0, 0] * g[1, 1] / np.linalg.det(g))

    @property
    def decoupling_offset(self) -> float:
        """Offset that leaves least off the diagonal [rad], within half a period of zero."""
        g, n = self.matrix, self.order
        own = g[0, 0] ** 2 + g[1, 1] ** 2 - g[0, 1] ** 2 - g[1, 0] ** 2
        mixed = g[0, 0] * g[0, 1] - g[1, 1] * g[1, 0]
        angle = 0.5 * math.atan2(-2.0 * mixed, own)
        if np.trace(g @ _turn(angle)) > 0.0:  # there a positive gain would add load
            angle += math.pi
        return math.remainder(n * self.offset + angle, 2.0 * math.pi) / n


@dataclass(frozen=True, kw_only=True, eq=False)
class Decoupling:
    """Responses over the offset.

    Attributes
    ----------
    order : int
    wind_speed, rotor_speed : float
        [m/s], [rad/s].
    responses : tuple of FixedFrameResponse
        One simulated for each offset.
    """

    order: int
    wind_speed: float
    rotor_speed: float
    responses: tuple[FixedFrameResponse, ...]

    @property
    def offset(self) -> FloatArray:
        """(O,) [rad]."""
        return np.array([response.offset for response in self.responses])

    @property
    def coupling(self) -> FloatArray:
        """(O,) [-]."""
        return np.array([response.coupling for response in self.responses])

    @property
    def decoupling_offset(self) -> float:
        """From the response that is coupled least [rad]."""
        return min(self.responses, key=lambda response: response.coupling).decoupling_offset


class _Played:
    """A tilt and a yaw part beside the commands of another controller, or beside held ones."""

    def __init__(
        self, inner: Controller | None, parts: Sequence[float], order: int, offset: float
    ) -> None:
        self.inner, self.parts, self.order, self.offset = inner, parts, order, offset
        self._held = np.zeros(COMMANDS)

    def start(self, step: float, measured: FloatArray) -> None:
        from pitchopt.control.signals import GENERATOR_TORQUE

        self._held[TORQUE] = measured[GENERATOR_TORQUE]
        self._held[PITCH_COMMAND:] = measured[PITCH : PITCH + 3]
        if self.inner is not None:
            self.inner.start(step, measured)

    def command(self, measured: FloatArray) -> FloatArray:
        given = self._held if self.inner is None else self.inner.command(measured)
        found = np.array(given, dtype=np.float64)
        found[PITCH_COMMAND:] += from_fixed_frame(
            self.parts, measured[AZIMUTH], self.order, self.offset
        )
        return found


def _turn(angle: float) -> FloatArray:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, s], [-s, c]])


def sampled_offset(order: int, rotor_speed: float, time_constant: float, step: float) -> float:
    """Decoupling offset [rad] of a rigid rotor under a controller that is called every `step` [s].

    Parameters
    ----------
    order : int
        n.
    rotor_speed : float
        [rad/s].
    time_constant : float
        Of actuators of first order [s]; 0 for actuators without dynamics.
    step : float
        [s].
    """
    n = harmonic(order)
    omega = finite_number("rotor_speed", rotor_speed, at_least=0.0)
    tau = finite_number("time_constant", time_constant, at_least=0.0)
    step = finite_number("step", step, above=0.0)
    keep = math.exp(-step / tau) if tau > 0.0 else 0.0
    return cmath.phase(cmath.exp(1j * n * omega * step) - keep) / n


def fixed_frame_response(
    dynamic: DynamicTurbine,
    wind_speed: float,
    *,
    order: int = 1,
    offset: float = 0.0,
    settling: float = _SETTLING,
    operation: Operation | None = None,
) -> FixedFrameResponse:
    """Play tilt and yaw pitch in steady uniform wind and measure what the moments do.

    Parameters
    ----------
    dynamic : DynamicTurbine
        With a rotor that speeds up and down its own controller holds it; a locked one keeps
        torque and collective pitch.
    wind_speed : float
        [m/s].
    order : int
        n.
    offset : float
        [rad].
    settling : float
        Before the moments are taken [s].
    operation : Operation, optional
        Of the same turbine, where it is there already.

    Raises
    ------
    ComputationError
        If a run diverges.
    """
    n = harmonic(order)
    operation = Operation(dynamic) if operation is None else operation
    start = operation.start(wind_speed)
    inner = operation.controller() if "rotor-speed" in dynamic.freedoms else None
    wind = StaticField(
        speed=finite_number("wind_speed", wind_speed, above=0.0),
        hub_height=dynamic.turbine.rotor.hub_height,
    )
    last = _TURNS * 2.0 * math.pi / start.rotor_speed
    duration = finite_number("settling", settling, at_least=0.0) + last

    def parts(tilt: float, yaw: float) -> FloatArray:
        played = _Played(inner, (tilt, yaw), n, offset)
        run = simulate(
            dynamic, wind, played, duration, start=start, interval=dynamic.step, any_wind=True
        )
        if run.status != "finished":
            raise ComputationError(f"response at {wind_speed:g} m/s: {run.message}")
        rows = run.after(duration - last)
        moments = rows[:, [run.place(f"RootMyc{k}") for k in (1, 2, 3)]]
        found = to_fixed_frame(moments, rows[:, run.place("Azimuth")], n)
        # a window that ends in nothing takes out what repeats with the turn
        return np.asarray(np.average(found, axis=0, weights=np.hanning(len(found))))

    matrix = np.empty((2, 2))
    for column, side in enumerate(np.eye(2) * _AMPLITUDE):
        matrix[:, column] = (parts(*side) - parts(*-side)) / (2.0 * _AMPLITUDE)
    return FixedFrameResponse(
        order=n, offset=float(offset), matrix=finite_array("matrix", matrix, shape=(2, 2))
    )


def measure_decoupling(
    dynamic: DynamicTurbine,
    wind_speed: float,
    offset: Sequence[float] | FloatArray,
    *,
    order: int = 1,
    settling: float = _SETTLING,
    operation: Operation | None = None,
) -> Decoupling:
    """Responses with each of several offsets (O,) [rad]; see `fixed_frame_response`."""
    operation = Operation(dynamic) if operation is None else operation
    return Decoupling(
        order=harmonic(order),
        wind_speed=float(wind_speed),
        rotor_speed=operation.start(wind_speed).rotor_speed,
        responses=tuple(
            fixed_frame_response(
                dynamic,
                wind_speed,
                order=order,
                offset=float(at),
                settling=settling,
                operation=operation,
            )
            for at in finite_array("offset", offset)
        ),
    )
