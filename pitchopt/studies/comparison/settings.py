"""ComparisonSettings: winds, methods and effort of a comparison."""

from __future__ import annotations

import difflib
import math
from dataclasses import asdict, dataclass
from typing import Any

from pitchopt.checks import finite_number, whole_number
from pitchopt.errors import InputError
from pitchopt.studies.simulation.winds import CLASSES, turbulence_level
from windfield.iec import iec_sigma

__all__ = ["METHODS", "STEADY", "ComparisonSettings", "intensity"]

STEADY = 10.0
"""Start-up in the steady wind over that in turbulence."""

METHODS = (
    "collective",
    "feed-forward",
    "learned",
    "ipc-handbook",
    "ipc-grid",
    "ipc-zoo",
    "ipc-bayes",
    "feed-forward+ipc",
)
"""Names of the methods, in the order of tables; the first is what the others are judged by."""


def intensity(turbulence: str, wind_speed: float) -> float:
    """Standard deviation over the mean of the wind at the hub [-]; 0 for ``none``."""
    if turbulence == "none":
        return 0.0
    return float(iec_sigma(turbulence_level(turbulence), wind_speed) / wind_speed)


@dataclass(frozen=True, kw_only=True)
class ComparisonSettings:
    """What is compared, in which winds, with how much effort.

    Parameters
    ----------
    turbulence : tuple of str
        Winds: ``none`` for the steady one, classes of IEC 61400-1, intensities such as ``0.05``.
        Every method is prepared and judged in each; kept in the order of their intensity.
    methods : tuple of str
        Of `METHODS`; ``collective`` is always among them.
    seeds : int
        Turbulence boxes that methods are judged in, none of which any of them has met.
    tuning_seeds : int
        Boxes that tuners have, the same for all of them.
    evaluations : int
        Of each tuner, at most; all begin with the handbook's design, and a grid of three levels of
        the four numbers has 81 more.
    rotations : int
        That the learner learns for, after its experiment.
    averaged : int
        In turbulence: rotations over which the learner averages the loads of a profile.
    duration, skip : float
        Of a simulation: that counts, and start-up before it [s].  In the steady wind the start-up
        is `STEADY` times as long, as nothing there covers what rings on.
    pitch_lag : float
        Time constant of the pitch actuators [s].
    pitch_below : float
        How far they reach below the turbine's own range [rad], for all methods alike.
    seed : int
        Of tuners and design.

    Raises
    ------
    InputError
        If a value is out of range, or there is no such method or wind.
    """

    turbulence: tuple[str, ...] = ("none", "C", "B")
    methods: tuple[str, ...] = METHODS
    seeds: int = 12
    tuning_seeds: int = 3
    evaluations: int = 82
    rotations: int = 20
    averaged: int = 20
    duration: float = 600.0
    skip: float = 60.0
    pitch_lag: float = 0.4
    pitch_below: float = math.radians(10.0)
    seed: int = 0

    def __post_init__(self) -> None:
        for name in ("seeds", "tuning_seeds", "evaluations", "rotations", "averaged"):
            whole_number(name, getattr(self, name), at_least=1)
        if self.seeds > 1000 or self.tuning_seeds > 1000:
            raise InputError("seeds, tuning_seeds: expected at most 1000 each")
        whole_number("seed", self.seed, at_least=0)
        finite_number("duration", self.duration, at_least=10.0)
        finite_number("skip", self.skip, at_least=0.0)
        finite_number("pitch_lag", self.pitch_lag, at_least=0.0, at_most=10.0)
        finite_number("pitch_below", self.pitch_below, at_least=0.0, at_most=math.radians(45.0))
        for method in self.methods:
            if method not in METHODS:
                near = difflib.get_close_matches(method, METHODS, n=1, cutoff=0.4)
                hint = f"; did you mean {near[0]!r}?" if near else ""
                raise InputError(
                    f"methods: got {method!r}, expected some of {', '.join(METHODS)}{hint}"
                )
        for wind in self.turbulence:
            level = turbulence_level(wind)
            if isinstance(level, str) and level not in ("none", *CLASSES):
                raise InputError(
                    f"turbulence: got {wind!r}, expected some of none, {', '.join(CLASSES)}, or "
                    "intensities such as 0.05"
                )
        if not self.turbulence:
            raise InputError("turbulence: got none at all, expected at least one wind")
        winds = {turbulence_level(wind): wind for wind in reversed(self.turbulence)}
        chosen = {"collective", *self.methods}
        object.__setattr__(self, "turbulence", tuple(reversed(winds.values())))
        object.__setattr__(self, "methods", tuple(m for m in METHODS if m in chosen))

    def winds(self, wind_speed: float) -> tuple[str, ...]:
        """The winds in the order of their intensity at a mean speed [m/s]."""
        return tuple(sorted(self.turbulence, key=lambda wind: intensity(wind, wind_speed)))

    def plain(self) -> dict[str, Any]:
        """As plain data, angles in degrees."""
        values = asdict(self)
        values["pitch_below_deg"] = math.degrees(values.pop("pitch_below"))
        return {key: list(v) if isinstance(v, tuple) else v for key, v in values.items()}
