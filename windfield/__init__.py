"""Wind fields over the disc of a horizontal-axis rotor.

Every field answers ``velocity(x, y, z, t=0.0) -> (..., 3)`` in the global frame: origin on the
tower axis at ground level, x downwind, y left looking downwind, z up. The package stands alone.
"""

from __future__ import annotations

from windfield.boxes import PolarBox, TurbulenceBox
from windfield.cache import BoxCache
from windfield.custom import CallableField
from windfield.disc import DiscField
from windfield.errors import WindFieldError
from windfield.field import StaticField, WindField
from windfield.hawc2 import read_hawc2
from windfield.iec import iec_sigma
from windfield.kaimal import kaimal_box, kaimal_polar_box
from windfield.sampling import DiscSample, disc_points, sample_disc
from windfield.shear import CubicShear, LogLaw, PowerLaw, TableShear, VerticalShear
from windfield.tower import TowerShadow
from windfield.turbsim import TurbSimWind, read_bts, write_bts
from windfield.turbulent import TransientField, TurbulentField

__all__ = [
    "BoxCache",
    "CallableField",
    "CubicShear",
    "DiscField",
    "DiscSample",
    "LogLaw",
    "PolarBox",
    "PowerLaw",
    "StaticField",
    "TableShear",
    "TowerShadow",
    "TransientField",
    "TurbSimWind",
    "TurbulenceBox",
    "TurbulentField",
    "VerticalShear",
    "WindField",
    "WindFieldError",
    "disc_points",
    "iec_sigma",
    "kaimal_box",
    "kaimal_polar_box",
    "read_bts",
    "read_hawc2",
    "sample_disc",
    "write_bts",
]
