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
from windfield.iec import iec_sigma
from windfield.kaimal import kaimal_box, kaimal_polar_box
from windfield.sampling import DiscSample, disc_points, sample_disc
from windfield.shear import CubicShear, LogLaw, PowerLaw, VerticalShear
from windfield.tower import TowerShadow
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
    "TowerShadow",
    "TransientField",
    "TurbulenceBox",
    "TurbulentField",
    "VerticalShear",
    "WindField",
    "WindFieldError",
    "disc_points",
    "iec_sigma",
    "kaimal_box",
    "kaimal_polar_box",
    "sample_disc",
]
