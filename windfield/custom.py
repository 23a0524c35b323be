"""Wind field from any function of the position on the rotor disc.

    v(x, y, z) = f(y, z - H) (cos gamma, sin gamma, 0)  +  disturbance of the tower

The function f sees hub-centred coordinates: y left looking downwind, z up from the hub [m].
Everything else is as in `windfield.field`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from windfield._checks import FloatArray, ValueSemantics
from windfield.errors import WindFieldError
from windfield.field import check_common, compose, resolve_points
from windfield.tower import TowerShadow

__all__ = ["CallableField"]

PROBE_Y = (0.0, 1.0, -2.0)
PROBE_Z = (0.0, 2.0, 1.0)


@dataclass(frozen=True, kw_only=True, eq=False)
class CallableField(ValueSemantics):
    """Wind whose speed over the disc is told by a function.

    At construction the function is tried at three points within 2.3 m of the hub, one by one
    and as an array; if the array does not give the same, it is called point by point from
    then on (slower, same result). Pickling works where the function itself can be pickled.

    Parameters
    ----------
    speed : callable
        speed(y, z) [m/s] of hub-centred y, z [m]: either of two 1-D arrays, returning an array
        of their shape, or of two floats, returning one.
    hub_height : float
        [m], positive.
    direction : float
        Flow direction gamma [rad].
    tower : TowerShadow or None

    Raises
    ------
    WindFieldError
        If `speed` cannot be called, fails near the hub, or another value is out of range.
    """

    speed: Callable[[Any, Any], Any]
    hub_height: float
    direction: float = 0.0
    tower: TowerShadow | None = None
    vectorised: bool = field(init=False, repr=False)

    def __post_init__(self) -> None:
        hub, direction = check_common(self.hub_height, self.direction, self.tower)
        object.__setattr__(self, "hub_height", hub)
        object.__setattr__(self, "direction", direction)
        if not callable(self.speed):
            raise WindFieldError(
                f"speed: got {type(self.speed).__name__}; must be a function of (y, z)"
            )
        object.__setattr__(self, "vectorised", self._takes_arrays())

    def undisturbed_speed(self, y: ArrayLike, z: ArrayLike) -> FloatArray:
        """Wind speed [m/s] without the tower at y, z [m], z above ground."""
        points = resolve_points(0.0, y, z, 0.0, self.hub_height)
        return self._speed(points.y, points.z)

    def velocity(self, x: ArrayLike, y: ArrayLike, z: ArrayLike, t: ArrayLike = 0.0) -> FloatArray:
        """Wind velocity (..., 3) [m/s]; the same at all times. See `WindField.velocity`.

        Raises
        ------
        WindFieldError
            For bad coordinates, and if the function fails or returns another shape or values
            that are not finite.
        """
        points = resolve_points(x, y, z, t, self.hub_height)
        return compose(self._speed(points.y, points.z), self.direction, self.tower, points)

    def _speed(self, y: FloatArray, z: FloatArray) -> FloatArray:
        shape = np.broadcast_shapes(y.shape, z.shape)
        across = np.broadcast_to(y, shape).flatten()
        above = np.broadcast_to(z - self.hub_height, shape).flatten()
        if self.vectorised:
            values = self._on_arrays(across.copy(), above.copy())
            if values.shape != across.shape:
                raise WindFieldError(
                    f"speed: function returned shape {values.shape} for {across.size} points; "
                    f"must be {across.shape}"
                )
        else:
            pairs = zip(across.tolist(), above.tolist(), strict=True)
            values = np.array([self._at_point(a, b) for a, b in pairs], dtype=np.float64)
        finite = np.isfinite(values)
        if not finite.all():
            k = int(np.argmin(finite))
            raise WindFieldError(
                f"speed: function returned {values[k]} at hub-centred (y, z) = "
                f"({across[k]:g}, {above[k]:g}) m; must be finite"
            )
        return values.reshape(shape)

    def _on_arrays(self, y: FloatArray, z: FloatArray) -> FloatArray:
        try:
            with np.errstate(all="ignore"):
                raw = np.asarray(self.speed(y, z))
        except Exception as error:
            raise WindFieldError(
                f"speed: function failed on {y.size} points with {type(error).__name__}: {error}"
            ) from error
        if raw.dtype.kind not in "fiub":
            raise WindFieldError(
                f"speed: function returned data of type {raw.dtype}; must be real numbers"
            )
        return raw.astype(np.float64)

    def _at_point(self, y: float, z: float) -> float:
        try:
            with np.errstate(all="ignore"):
                value = self.speed(y, z)
                return float(value)
        except Exception as error:
            raise WindFieldError(
                f"speed: function failed at hub-centred (y, z) = ({y:g}, {z:g}) m with "
                f"{type(error).__name__}: {error}; must return one number"
            ) from error

    def _takes_arrays(self) -> bool:
        try:
            together = self._on_arrays(np.array(PROBE_Y), np.array(PROBE_Z))
        except WindFieldError:
            together = np.empty(0)
        fits = together.shape == (len(PROBE_Y),)
        try:
            single = [self._at_point(y, z) for y, z in zip(PROBE_Y, PROBE_Z, strict=True)]
        except WindFieldError:
            if fits:
                return True
            raise
        return fits and bool(np.allclose(together, single, rtol=1e-9, atol=0.0, equal_nan=True))
