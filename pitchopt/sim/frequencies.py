"""Natural frequencies of the turning turbine in still air (Campbell diagram).

The equations of motion q'' = f(q, q') are linearised about the undeflected turbine by central
differences at several azimuths.  Blade coordinates are turned into collective, cosine and sine
ones, q = T(psi) z (multiblade transform), so that with q'' = A q + B q'

    z'' = T^-1 (A T + Omega B T' - Omega^2 T'') z + T^-1 (B T - 2 Omega T') z',

which is constant but for gravity on the blades; its mean over the azimuth is taken.  A mode that
the blades whirl in stands at its frequency in the frame that does not turn.

Source: R. Bielawa, Rotary Wing Structural Dynamics; M. H. Hansen, Wind Energy 6, 2003, 179-195.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from pitchopt.checks import FloatArray, finite_number
from pitchopt.sim.run import TurbineRun
from pitchopt.sim.turbine import DynamicTurbine
from windfield import StaticField

__all__ = ["Mode", "natural_modes"]

_AZIMUTHS = 6
_THIN = 1e-9  # density of the still air [kg/m^3]
_STILL = 1e-3  # wind speed of the still air [m/s]
_STEP = 1e-4  # of the differences [m, rad, and per second]


@dataclass(frozen=True)
class Mode:
    """One mode.

    Attributes
    ----------
    frequency : float
        Damped, in the frame that does not turn [rad/s].
    damping : float
        Fraction of critical.
    label : str
        Coordinate that moves most, e.g. ``tower fore-aft`` or ``flap sine``.
    """

    frequency: float
    damping: float
    label: str


def natural_modes(
    dynamic: DynamicTurbine, rotor_speed: float, *, pitch: float = 0.0
) -> tuple[Mode, ...]:
    """Modes of a turbine in still air, by ascending frequency.

    Parameters
    ----------
    dynamic : DynamicTurbine
    rotor_speed : float
        [rad/s].
    pitch : float
        Of all blades [rad].

    Raises
    ------
    InputError
        If the speed is negative.
    """
    speed = finite_number("rotor_speed", rotor_speed, at_least=0.0)
    thin = dataclasses.replace(
        dynamic, turbine=dataclasses.replace(dynamic.turbine, air_density=_THIN)
    )
    still = StaticField(speed=_STILL, hub_height=dynamic.turbine.rotor.hub_height)
    run = TurbineRun(thin, still, rotor_speed=speed, pitch=pitch)
    size = run.state.q.size
    used = np.flatnonzero(run.model.body.active)
    stiffness, damping = np.zeros((2, size, size))
    for k in range(_AZIMUTHS):
        psi = 2.0 * math.pi * (k + 0.5) / (3 * _AZIMUTHS)
        a, b = _linear(run, psi, speed)
        t, t1, t2 = _transform(psi, size)
        back = np.linalg.inv(t)
        stiffness += back @ (a @ t + speed * b @ t1 - speed**2 * t2) / _AZIMUTHS
        damping += back @ (b @ t - 2.0 * speed * t1) / _AZIMUTHS
    keep = np.ix_(used, used)
    system = np.block(
        [
            [np.zeros((used.size, used.size)), np.eye(used.size)],
            [stiffness[keep], damping[keep]],
        ]
    )
    values, vectors = np.linalg.eig(system)
    labels = _labels(size)
    modes = []
    for value, vector in zip(values, vectors.T, strict=True):
        if value.imag > 1e-3:
            largest = used[int(np.argmax(np.abs(vector[: used.size])))]
            modes.append(
                Mode(
                    frequency=float(value.imag),
                    damping=float(-value.real / abs(value)),
                    label=labels[int(largest)],
                )
            )
    return tuple(sorted(modes, key=lambda mode: mode.frequency))


def _linear(run: TurbineRun, psi: float, speed: float) -> tuple[FloatArray, FloatArray]:
    """A and B of q'' = A q + B q' about the undeflected turbine at one azimuth."""
    from pitchopt.sim.kernels_body import AZIMUTH
    from pitchopt.sim.kernels_march import begin

    state = run.state
    size = state.q.size
    out = np.zeros((2, size, size))
    for which in range(2):
        for j in range(size):
            sides = []
            for sign in (1.0, -1.0):
                state.q[:], state.v[:] = 0.0, 0.0
                state.q[AZIMUTH], state.v[AZIMUTH] = psi, speed
                (state.q, state.v)[which][j] += sign * _STEP
                begin(run.model, state, run.work)
                sides.append(state.a.copy())
            out[which][:, j] = (sides[0] - sides[1]) / (2.0 * _STEP)
    return out[0], out[1]


def _transform(psi: float, size: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """T(psi) and its first two derivatives by psi."""
    out = np.zeros((3, size, size))
    out[0, :4, :4] = np.eye(4)
    for k in range(3):
        angle = psi + 2.0 * math.pi * k / 3.0
        c, s = math.cos(angle), math.sin(angle)
        for j in range(2):
            row = 4 + 2 * k + j
            columns = [4 + j, 6 + j, 8 + j]
            out[0][row, columns] = 1.0, c, s
            out[1][row, columns] = 0.0, -s, c
            out[2][row, columns] = 0.0, -c, -s
    return out[0], out[1], out[2]


def _labels(size: int) -> list[str]:
    names = ["tower fore-aft", "tower side-side", "rotor", "shaft"]
    for part in ("collective", "cosine", "sine"):
        names += [f"flap {part}", f"edge {part}"]
    return names[:size]
