"""Blade: chord, twist, aerodynamic-centre offsets and polars along the span.

Loads per unit length are known at the stations.  With quadrature ``nodes`` they vary linearly
between stations (as AeroDyn takes them), with ``elements`` they are constant over elements
whose centres are the stations, the first element starting at the blade root.

Offsets turn with pitch: `prebend` is the distance of the aerodynamic centre from the pitch axis
downwind, `sweep` along y_b = e_r x x (towards the trailing edge, against the rotation), both at
zero pitch.  `twist` has the sign of pitch: positive towards feather.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from pitchopt.aero.polars import Polar, blend
from pitchopt.checks import FloatArray, finite_array
from pitchopt.errors import InputError

__all__ = ["Blade"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Blade:
    """Aerodynamic blade.

    Parameters
    ----------
    span : array (E,)
        Distance of the stations from the blade root [m], strictly increasing, from 0.
    chord : array (E,)
        Chord [m].
    twist : array (E,)
        Twist [rad].
    polars : sequence of Polar, length E
        One polar per station, already blended.
    prebend, sweep : array (E,), optional
        Offsets of the aerodynamic centre from the pitch axis [m]; zero if absent.
    quadrature : {"nodes", "elements"}
        How loads are summed along the span, see the module.

    Raises
    ------
    InputError
        If shapes differ, values are not finite, chord is not positive or span does not increase.
    """

    span: FloatArray
    chord: FloatArray
    twist: FloatArray
    polars: tuple[Polar, ...]
    prebend: FloatArray | None = None
    sweep: FloatArray | None = None
    quadrature: Literal["nodes", "elements"] = "nodes"

    def __post_init__(self) -> None:
        span = finite_array("blade.span", self.span)
        if span[0] < 0.0 or np.any(np.diff(span) <= 0.0):
            raise InputError(
                "blade.span: expected strictly increasing distances from the root >= 0"
            )
        if self.quadrature not in ("nodes", "elements"):
            raise InputError(
                f"blade.quadrature: got {self.quadrature!r}, expected 'nodes' or 'elements'"
            )
        if self.quadrature == "nodes" and span.size < 2:
            raise InputError("blade.span: quadrature 'nodes' needs at least 2 stations")
        object.__setattr__(self, "span", span)
        for key in ("chord", "twist", "prebend", "sweep"):
            value = getattr(self, key)
            if value is None:
                value = np.zeros(span.size)
            array = finite_array(f"blade.{key}", value, shape=span.shape)
            object.__setattr__(self, key, array)
        if np.any(self.chord <= 0.0):
            raise InputError(f"blade.chord: got {self.chord.min()} m, every chord must be positive")
        polars = tuple(self.polars)
        if len(polars) != span.size or not all(isinstance(p, Polar) for p in polars):
            raise InputError(
                f"blade.polars: got {len(polars)} entries, expected {span.size} Polar objects"
            )
        object.__setattr__(self, "polars", polars)
        if self.quadrature == "elements" and np.any(np.diff(self.edges) <= 0.0):
            raise InputError(
                "blade.span: with quadrature 'elements' the stations are element centres, the "
                "first element starting at the root; these centres give no positive widths"
            )

    @cached_property
    def edges(self) -> FloatArray:
        """Element boundaries (E + 1,) for quadrature ``elements`` [m]."""
        edges = np.zeros(self.span.size + 1)
        for i, centre in enumerate(self.span):
            edges[i + 1] = 2.0 * centre - edges[i]
        return edges

    @property
    def length(self) -> float:
        """Distance from the root to the tip [m]."""
        return float(self.span[-1] if self.quadrature == "nodes" else self.edges[-1])

    @property
    def offsets(self) -> tuple[FloatArray, FloatArray]:
        """Prebend and sweep (E,), zeros where none were given [m]."""
        assert self.prebend is not None and self.sweep is not None  # set in __post_init__
        return self.prebend, self.sweep

    @property
    def straight(self) -> bool:
        """Whether the aerodynamic centres lie on the pitch axis."""
        prebend, sweep = self.offsets
        return not (np.any(prebend) or np.any(sweep))

    def at(self, span: ArrayLike, *, quadrature: Literal["nodes", "elements"]) -> Blade:
        """Blade resampled linearly at other stations (S,) [m], polars blended."""
        where = finite_array("span", span)
        known = self.span
        index = np.clip(np.searchsorted(known, where, side="right") - 1, 0, max(known.size - 2, 0))
        polars = []
        for x, i in zip(where, index, strict=True):
            j = min(int(i) + 1, known.size - 1)
            gap = known[j] - known[i]
            weight = float(np.clip((x - known[i]) / gap, 0.0, 1.0)) if gap > 0.0 else 0.0
            polars.append(blend(self.polars[int(i)], self.polars[j], weight))
        prebend, sweep = self.offsets
        return Blade(
            span=where,
            chord=np.interp(where, known, self.chord),
            twist=np.interp(where, known, self.twist),
            prebend=np.interp(where, known, prebend),
            sweep=np.interp(where, known, sweep),
            polars=tuple(polars),
            quadrature=quadrature,
        )

    def elements(self, count: int) -> Blade:
        """Blade of `count` equal elements, properties taken at their centres."""
        if isinstance(count, bool) or int(count) != count or count < 1:
            raise InputError(f"elements: got {count!r}, expected a whole number of at least 1")
        centres = (np.arange(count) + 0.5) * (self.length / count)
        return self.at(centres, quadrature="elements")

    def integration(self, x: FloatArray, y: FloatArray) -> tuple[FloatArray, ...]:
        """Weights that integrate loads per length and their moments along the blade.

        Parameters
        ----------
        x, y : ndarray (..., E)
            Offsets of the aerodynamic centres from the pitch axis [m], in the frame in which
            the moments are wanted.

        Returns
        -------
        width, lever_x, lever_y, lever_z : ndarray (..., E)
            Sum of ``width * f`` is the integral of f, sum of ``lever * f`` the integral of
            position times f, with positions from the blade root [m], [m^2].  With ``nodes``
            both position and f are linear between stations, which makes the moments exact.
        """
        z = np.broadcast_to(self.span, x.shape)
        if self.quadrature == "elements":
            width = np.broadcast_to(np.diff(self.edges), x.shape)
            return width, width * x, width * y, width * z
        length = np.sqrt(np.diff(x) ** 2 + np.diff(y) ** 2 + np.diff(z) ** 2)
        result = [_two_sided(length / 2, length / 2)]
        for position in (x, y, z):
            near, far = position[..., :-1], position[..., 1:]
            result.append(_two_sided(length * (near / 3 + far / 6), length * (far / 3 + near / 6)))
        return tuple(result)


def _two_sided(left: FloatArray, right: FloatArray) -> FloatArray:
    """Sum what each interval gives to its left and to its right station."""
    total = np.zeros((*left.shape[:-1], left.shape[-1] + 1))
    total[..., :-1] += left
    total[..., 1:] += right
    return total
