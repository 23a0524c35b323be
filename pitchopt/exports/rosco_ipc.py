r"""Individual pitch control as parameters of ROSCO, and back.

ROSCO's law for three blades at 1P, in the order of its source, with psi_b = psi + 2 pi (b-1)/3:

    m_b     = moving band pass of the root moment M_b about the rotor speed,
    t, y    = 2/3 sum_b m_b cos psi_b,    2/3 sum_b m_b sin psi_b,
    T, Y   += step KI t,  step KI y,      each within +- IntSat,
    beta_b += T cos(psi_b + aziOffset) + Y sin(psi_b + aziOffset).

Azimuth (0 up, clockwise seen from upwind), the moment's sign (positive downwind), the factor 2/3,
the pitch's sign (towards feather), the step (integral first, output from the new integral) and
the offset, which stands within n (psi + offset) and is in radians, are those of
`pitchopt.control.individual`.  So IPC_aziOffset is our offset, and IPC_KI is in rad/(N m s), but
for one factor.

**The band pass halves the moments.**  It is meant as the bilinear form of

    G(s) = omega s / (d s^2 + omega s + d omega^2),   d = 0.7,

which is 1 at s = i omega.  Its numerator must be 2 omega step (u_k - u_{k-2}); ROSCO 2.10.6 (and
the 2.9 line) takes u_{k-1} for u_{k-2}.  What comes out is G/(1 + exp(-i omega step)): half the
moment, half a step early.  IPC_KI therefore is our gain divided by `FILTER_GAIN` = 0.5; for a
version without that slip the factor is 1.  In the fixed frame the band pass acts about like a
first-order lag of 2 d/omega (1.1 s at 12 rpm), which ours does not have.

**2P.**  IPC_ControlMode 2 is not written.  In ROSCO 2.10.6 the yaw part of 2P is integrated from a
variable (axisYawF_2P) that nothing sets: only the tilt part acts.  What does act has passed the
band pass of 1P, which leaves 0.34 of a 2P moment (0.69 without the slip) and turns it by 46
degrees; and both harmonics share one IPC_IntSat.

What else ROSCO has not: the limit of the vector (T, Y) (its box reaches sqrt 2 further at the
corners), the stop of the integral while a blade is cut, a fade over collective pitch or time.
IPC_Vramp fades the gains over the estimated wind speed instead, and what is integrated stays.

Source: ``rosco/controller/src`` of ROSCO 2.10.6: ``Controllers.f90`` (IPC, PIController),
``Functions.f90`` (ColemanTransform and its inverse, sigma), ``Filters.f90`` (NotchFilterSlopes,
PreFilterMeasuredSignals), ``ReadSetParameters.f90`` (avrSWAP 30 to 32 and 60, CheckInputs).
"""

from __future__ import annotations

import math
import os
from dataclasses import dataclass

import numpy as np

from pitchopt.checks import finite_array, finite_number
from pitchopt.control import IndividualPitch
from pitchopt.errors import InputError
from pitchopt.exports.discon import DisconLine, discon_numbers, discon_text, read_discon

__all__ = ["FILTER_GAIN", "IPCSection", "discon_ipc", "read_discon_ipc"]

FILTER_GAIN = 0.5
"""Share of a 1P moment that the band pass of ROSCO 2.9 and 2.10.6 lets through."""

_ALWAYS = (0.0, 1.0)  # [m/s]; full gains above 1 m/s


@dataclass(frozen=True, kw_only=True)
class IPCSection:
    """Individual pitch control of ROSCO.

    Parameters
    ----------
    lines : tuple of DisconLine
    notes : tuple of str
        What the parameters mean and need.
    lacks : tuple of str
        What the controller has that ROSCO has not, and what of it was left out.
    """

    lines: tuple[DisconLine, ...]
    notes: tuple[str, ...] = ()
    lacks: tuple[str, ...] = ()

    def text(self) -> str:
        """Lines to paste into a ``DISCON.IN``, with notes and what is lacking as comments."""
        return discon_text("INDIVIDUAL PITCH CONTROL", (*self.notes, *self.lacks), self.lines)


_NEEDED = (
    ("PC_ControlMode", (1.0,), "the pitch controller on"),
    ("Y_ControlMode", (0.0, 1.0), "no yaw by individual pitch"),
    ("Flp_Mode", (0.0,), "flaps off"),
    ("AWC_Mode", (0.0,), "active wake control off"),
)


def check_discon_modes(text: str) -> None:
    """Refuse a ``DISCON.IN`` with which ROSCO does not take individual pitch.

    Raises
    ------
    InputError
        Naming the parameter.
    """
    for name, allowed, why in _NEEDED:
        held = discon_numbers(text, name, 1)
        if held is not None and held[0] not in allowed:
            expected = " or ".join(f"{value:g}" for value in allowed)
            raise InputError(
                f"{name}: the DISCON file has {held[0]:g}, expected {expected} beside individual "
                f"pitch: {why}"
            )


def discon_ipc(
    individual: IndividualPitch,
    *,
    wind_ramp: tuple[float, float] | None = None,
    only_1p: bool = False,
    filter_gain: float = FILTER_GAIN,
) -> IPCSection:
    """Parameters of ROSCO for an individual pitch controller, see the module.

    Parameters
    ----------
    individual : IndividualPitch
    wind_ramp : (float, float), optional
        Estimated wind speeds between which the gains grow from nothing to their full size [m/s];
        without, they have it from 1 m/s on.
    only_1p : bool, optional
        Write the part at 1P of a controller with other harmonics, which the notes name.
    filter_gain : float, optional
        Share of a 1P moment that ROSCO's band pass lets through.

    Raises
    ------
    InputError
        If there is no 1P or its gain is zero, if there are other harmonics without `only_1p`, or
        if the controller fades with the collective pitch and no ramp of wind speeds takes its
        place.
    """
    share = finite_number("filter_gain", filter_gain, above=0.0)
    order, gains = np.asarray(individual.order), np.asarray(individual.gain)
    shown = ", ".join(f"{n:g}P" for n in order)
    if 1.0 not in order:
        raise InputError(f"harmonics: got {shown}, expected 1P, which is all that ROSCO does")
    place = int(np.flatnonzero(order == 1.0)[0])
    if gains[place] == 0.0:
        raise InputError("gain: got 0 at 1P, expected individual pitch that does something")
    others = [k for k in range(order.size) if k != place and gains[k] != 0.0]
    if others and not only_1p:
        raise InputError(
            f"harmonics: got {shown}, expected 1P alone: ROSCO 2.10.6 regulates at 2P the tilt "
            "part but not the yaw part, and nothing beyond; only_1p (--only-1p) writes the 1P part"
        )
    ramp = _ALWAYS
    if wind_ramp is not None:
        low, high = finite_array("wind_ramp", wind_ramp, shape=(2,)).tolist()
        if not 0.0 <= low < high:
            raise InputError(f"wind_ramp: got {low:g} to {high:g} m/s, expected ascending speeds")
        ramp = (low, high)
    elif individual.fade_to > individual.fade_from:
        raise InputError(
            "wind_ramp: got none, but the controller fades from "
            f"{math.degrees(individual.fade_from):g} to {math.degrees(individual.fade_to):g} deg "
            "of collective pitch, which ROSCO cannot; expected two wind speeds (--wind-ramp "
            "LOW,HIGH) that take its place"
        )
    gain, offset = float(gains[place]), float(np.asarray(individual.offset)[place])
    limit = float(np.asarray(individual.limit)[place])
    notes = [
        (
            f"1P gain {gain:.6g} rad/(N m s), offset {math.degrees(offset):.6g} deg, amplitude at "
            f"most {math.degrees(limit):.6g} deg"
        ),
        (
            f"for ROSCO 2.9 and 2.10, whose band pass lets {share:g} of a 1P moment through: "
            f"integral gain = {abs(gain):.6g} / {share:g}"
        ),
        "ServoDyn needs Ptch_Cntrl 1; the range (PC_MinPit) must have room below the collective",
        "the pitch controller must be on (PC_ControlMode 1), yaw by IPC, flaps and AWC off",
    ]
    lacks = [
        (
            "other than ours: tilt and yaw part each keep within the saturation, so an amplitude "
            "may reach 1.41 times it"
        ),
        "other than ours: the integrals go on while range or rate of a blade cuts its command",
    ]
    if gain < 0.0:
        gain, offset = -gain, offset + math.pi
        notes.append("a negative gain is written as a positive one and 180 deg more offset")
    offset = math.remainder(offset, 2.0 * math.pi)
    lacks += [
        f"left out: {order[k]:g}P, gain {gains[k]:.6g} rad/(N m s), offset "
        f"{math.degrees(np.asarray(individual.offset)[k]):.6g} deg"
        for k in others
    ]
    if individual.fade_to > individual.fade_from:
        lacks.append(
            f"left out: fade from {math.degrees(individual.fade_from):g} to "
            f"{math.degrees(individual.fade_to):g} deg of collective pitch; the gains fade with "
            f"the wind from {ramp[0]:g} to {ramp[1]:g} m/s in its place"
        )
    if individual.fade_time > 0.0:
        lacks.append(f"left out: fade over the first {individual.fade_time:g} s")
    lines = (
        DisconLine(name="IPC_ControlMode", value="1", comment="1P"),
        DisconLine(name="IPC_Vramp", value=f"{ramp[0]:.6g} {ramp[1]:.6g}",
                   comment="estimated wind speeds of no and of full gains [m/s]"),
        DisconLine(name="IPC_SatMode", value="0", comment="by range and rate alone"),
        DisconLine(name="IPC_IntSat", value=f"{limit:.10g}", comment="[rad]"),
        DisconLine(name="IPC_KP", value="0.0 0.0", comment="of 1P and 2P [rad/(N m)]"),
        DisconLine(name="IPC_KI", value=f"{gain / share:.12e} 0.0",
                   comment="of 1P and 2P [rad/(N m s)]"),
        DisconLine(name="IPC_aziOffset", value=f"{offset:.12g} 0.0",
                   comment="of 1P and 2P, within n (azimuth + offset) [rad]"),
        DisconLine(name="IPC_CornerFreqAct", value="0.0", comment="no further lag"),
    )  # fmt: skip
    return IPCSection(lines=lines, notes=tuple(notes), lacks=tuple(lacks))


def read_discon_ipc(
    path: str | os.PathLike[str], *, filter_gain: float = FILTER_GAIN, drop_ramp: bool = False
) -> IndividualPitch:
    """Individual pitch controller that the parameters of a ``DISCON.IN`` make.

    Parameters
    ----------
    path : path
        A whole file, or the lines of :meth:`IPCSection.text`.
    filter_gain : float, optional
        As in :func:`discon_ipc`.
    drop_ramp : bool, optional
        Take the full gains of a file whose gains fade in over the wind speed.

    Raises
    ------
    InputError
        If the file is something else, or has what our controller has not: a proportional gain, a
        lag of its own, gains that fade over the wind speed; or individual pitch off or with 2P.
    """
    text, shown = read_discon(path), os.fspath(path)
    share = finite_number("filter_gain", filter_gain, above=0.0)
    held = {}
    for name, count in (
        ("IPC_ControlMode", 1),
        ("IPC_Vramp", 2),
        ("IPC_IntSat", 1),
        ("IPC_KP", 2),
        ("IPC_KI", 2),
        ("IPC_aziOffset", 2),
        ("IPC_CornerFreqAct", 1),
    ):
        found = discon_numbers(text, name, count)
        if found is None:
            raise InputError(f"DISCON file: {shown!r} has no {name}, expected a file of ROSCO")
        held[name] = found
    if held["IPC_ControlMode"][0] != 1:
        raise InputError(
            f"IPC_ControlMode: {shown!r} has {held['IPC_ControlMode'][0]:g}, expected 1 (1P)"
        )
    for name, value in (
        ("IPC_KP", np.abs(held["IPC_KP"][0])),
        ("IPC_CornerFreqAct", held["IPC_CornerFreqAct"][0]),
    ):
        if value != 0.0:
            raise InputError(f"{name}: {shown!r} has {value:g}, expected 0: ours is integral alone")
    low, high = held["IPC_Vramp"].tolist()
    if high > _ALWAYS[1] and not drop_ramp:
        raise InputError(
            f"IPC_Vramp: {shown!r} has {low:g} to {high:g} m/s, over which ours cannot fade; "
            "expected at most 1 m/s, or drop_ramp for the full gains"
        )
    return IndividualPitch(
        gain=np.array([share * held["IPC_KI"][0]]),
        offset=[held["IPC_aziOffset"][0]],
        order=[1],
        limit=float(held["IPC_IntSat"][0]),
    )
