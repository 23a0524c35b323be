"""What a tower of a given height has to keep, beside the fatigue of its welds.

With the middle diameter d, the wall t, the outer diameter D = d + t and nodes and elements counted
from the base,

    D <= D_max,                    D_top >= D_bearing,
    c_d d_e <= d_{e+1} <= d_e,     1 / c_t <= t_{e+1} / t_e <= c_t,
    t_min <= t <= t_max,           D / t <= r,
    f_k >= f_1P / (1 - delta),     k = 1, 2, standard configuration alone,

and a lifetime damage of at most one.  The first frequencies of fore-aft and of side-side bending
count, whichever is lower, and so do the second.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pitchopt.checks import finite_number
from pitchopt.errors import InputError
from pitchopt.turbines import Turbine

__all__ = ["TowerLimits"]


@dataclass(frozen=True, kw_only=True)
class TowerLimits:
    """Limits of the sizing of a tower.

    Parameters
    ----------
    frequency_margin : float or None
        delta: natural frequencies lie above 1P / (1 - delta) [-], 1P that of the rated rotor
        speed; 0.15 keeps 18 % of it between.  None for a soft-soft tower: its controller would
        have to keep the rotor out of resonance.  That of the study does not, and its rotor of three
        equal blades shakes the tower at 3P and hardly at 1P, so that resonance does no damage in
        the simulations.
    largest_damage : float
        Of the lifetime [-].
    largest_diameter : float
        D_max, outer [m].  6.0 is that of the tower of the IEA 3.4 MW turbine, to a centimetre.
    top_diameter : float
        D_bearing, least outer diameter at the top [m].  3.0 is that of the same tower: the yaw
        bearing stays.
    taper : float
        c_d, least ratio of the diameters at an element's upper and lower end [-].  0.8 over
        10.8 m and from 6 m is a half-angle of 3.2 degrees; the tower named has 0.83.
    wall_step : float
        c_t, largest ratio of the walls of neighbours [-], either way; the tower named has 1.20.
    slenderness : float
        r, largest outer diameter over wall [-].  With 200, E / f_y = 210 / 0.355 and fabrication
        class B, a medium-long cylinder in meridional compression keeps a characteristic
        buckling stress of 0.76 f_y by EN 1993-1-6, annex D.1.2.  The tower named goes to 242
        half-way up.
    least_wall, largest_wall : float
        t_min and t_max [m]: what is handled and welded.

    Raises
    ------
    InputError
        If a number is out of range or two contradict each other.
    """

    frequency_margin: float | None = 0.15
    largest_damage: float = 1.0
    largest_diameter: float = 6.0
    top_diameter: float = 3.0
    taper: float = 0.8
    wall_step: float = 1.25
    slenderness: float = 200.0
    least_wall: float = 0.010
    largest_wall: float = 0.100

    def __post_init__(self) -> None:
        def put(name: str, *, above: float, at_most: float | None = None) -> float:
            value = finite_number(name, getattr(self, name), above=above, at_most=at_most)
            object.__setattr__(self, name, value)
            return value

        if self.frequency_margin is not None:
            margin = finite_number(
                "frequency_margin", self.frequency_margin, at_least=0.0, at_most=0.9
            )
            object.__setattr__(self, "frequency_margin", margin)
        put("largest_damage", above=0.0)
        largest = put("largest_diameter", above=0.0)
        top = put("top_diameter", above=0.0)
        put("taper", above=0.0, at_most=0.999)
        put("wall_step", above=1.0)
        put("slenderness", above=4.0)
        least = put("least_wall", above=0.0)
        wall = put("largest_wall", above=0.0)
        if top >= largest:
            raise InputError(
                f"top_diameter: got {top:g} m, expected less than largest_diameter = {largest:g} m"
            )
        if least >= wall:
            raise InputError(
                f"least_wall: got {least:g} m, expected less than largest_wall = {wall:g} m"
            )

    @property
    def configuration(self) -> str:
        """``standard`` or ``soft-soft``."""
        return "soft-soft" if self.frequency_margin is None else "standard"

    def least_frequency(self, turbine: Turbine) -> float | None:
        """f_1P / (1 - delta) [Hz] at the turbine's rated rotor speed; None for soft-soft."""
        if self.frequency_margin is None:
            return None
        speed = turbine.rated_rotor_speed
        return speed / (2.0 * np.pi) / (1.0 - self.frequency_margin)
