"""Output channels: OpenFAST's names, their units there, and their places in the time loop.

The time loop fills a vector in SI units; `Channel.factor` turns an entry into OpenFAST's unit.
Blade channels stand once per blade, tower-section channels once per interior station.  Signs and
frames are OpenFAST's (suffix c: coned frame that does not pitch, b: pitches with the blade,
p: tower top, t: tower base, s: shaft, not turning).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

__all__ = ["Channel", "channel_list"]

_RPM = 30.0 / math.pi
_DEG = 180.0 / math.pi
_KILO = 1e-3

_SCALARS = (
    ("Time", "s", 1.0, "time"),
    ("Wind1VelX", "m/s", 1.0, "wind at the hub, undisturbed, downwind"),
    ("Wind1VelY", "m/s", 1.0, "to the left"),
    ("Wind1VelZ", "m/s", 1.0, "up"),
    ("RtVAvgxh", "m/s", 1.0, "relative wind along the shaft, mean over all blade stations"),
    ("RotSpeed", "rpm", _RPM, "rotor speed"),
    ("GenSpeed", "rpm", _RPM, "generator speed, high-speed side"),
    ("Azimuth", "deg", _DEG, "of blade 1, 0 is up"),
    ("GenTq", "kN-m", _KILO, "generator torque, high-speed side"),
    ("GenPwr", "kW", _KILO, "electrical power"),
    ("RotTorq", "kN-m", _KILO, "shaft torque at the hub"),
    ("RotThrust", "kN", _KILO, "shaft force at the hub, rotor weight included"),
    ("RtAeroFxh", "N", 1.0, "aerodynamic thrust along the shaft"),
    ("RtAeroMxh", "N-m", 1.0, "aerodynamic torque"),
    ("LSSTipMys", "kN-m", _KILO, "tilt moment at the hub, not turning"),
    ("LSSTipMzs", "kN-m", _KILO, "yaw moment at the hub, not turning"),
    ("LSShftTwst", "deg", _DEG, "twist of the shaft, generator ahead of rotor"),
    ("TTDspFA", "m", 1.0, "tower-top displacement downwind"),
    ("TTDspSS", "m", 1.0, "to the left"),
    ("YawBrTAxp", "m/s^2", 1.0, "tower-top acceleration downwind"),
    ("YawBrTAyp", "m/s^2", 1.0, "to the left"),
    ("YawBrFxp", "kN", _KILO, "force on the tower top downwind"),
    ("YawBrFyp", "kN", _KILO, "to the left"),
    ("YawBrFzp", "kN", _KILO, "up"),
    ("YawBrMxp", "kN-m", _KILO, "moment on the tower top, roll"),
    ("YawBrMyp", "kN-m", _KILO, "tilt"),
    ("YawBrMzp", "kN-m", _KILO, "yaw"),
    ("TwrBsFxt", "kN", _KILO, "force at the tower base downwind"),
    ("TwrBsFyt", "kN", _KILO, "to the left"),
    ("TwrBsFzt", "kN", _KILO, "up"),
    ("TwrBsMxt", "kN-m", _KILO, "side-side moment at the tower base, pushed to the right"),
    ("TwrBsMyt", "kN-m", _KILO, "fore-aft moment at the tower base, pushed downwind"),
    ("TwrBsMzt", "kN-m", _KILO, "torsion at the tower base"),
)
_PER_BLADE = (
    ("BldPitch{}", "deg", _DEG, "pitch of blade {}"),
    ("RootFxc{}", "kN", _KILO, "root force of blade {} downwind"),
    ("RootFyc{}", "kN", _KILO, "against the rotation"),
    ("RootFzc{}", "kN", _KILO, "along the blade"),
    ("RootMxc{}", "kN-m", _KILO, "in-plane root moment of blade {}"),
    ("RootMyc{}", "kN-m", _KILO, "out-of-plane root moment of blade {}"),
    ("RootMzc{}", "kN-m", _KILO, "pitching moment of blade {}"),
    ("RootMxb{}", "kN-m", _KILO, "edgewise root moment of blade {}"),
    ("RootMyb{}", "kN-m", _KILO, "flapwise root moment of blade {}"),
    ("OoPDefl{}", "m", 1.0, "tip deflection of blade {} out of plane"),
    ("IPDefl{}", "m", 1.0, "in plane, against the rotation"),
)
SCALARS = len(_SCALARS)
PER_BLADE = len(_PER_BLADE)


@dataclass(frozen=True)
class Channel:
    """One output channel.

    Attributes
    ----------
    name, unit : str
        As in OpenFAST.
    factor : float
        From SI to that unit.
    meaning : str
    """

    name: str
    unit: str
    factor: float
    meaning: str


def channel_list(blades: int, sections: int) -> tuple[Channel, ...]:
    """All channels in the order of the time loop's vector.

    Parameters
    ----------
    blades : int
    sections : int
        Interior stations of the tower.
    """
    channels = [Channel(*entry) for entry in _SCALARS]
    for name, unit, factor, meaning in _PER_BLADE:
        channels += [
            Channel(name.format(k + 1), unit, factor, meaning.format(k + 1)) for k in range(blades)
        ]
    for s in range(sections):
        for axis, meaning in (("x", "side-side"), ("y", "fore-aft")):
            channels.append(
                Channel(
                    f"TwHt{s + 1}ML{axis}t",
                    "kN-m",
                    _KILO,
                    f"{meaning} moment at tower station {s + 1} above the base",
                )
            )
    return tuple(channels)
