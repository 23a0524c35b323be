"""Space that a tuner searches: bounded, scaled, periodic and polar parameters.

A tuner sees unit coordinates u in [0, 1]^d, on the scale of each parameter (linear or
logarithmic).  A surrogate sees features f(u): a plain parameter as it is; a periodic one as
(cos, sin) / 2 of its phase; a gain with its offset, which is a point in a plane, as
(gain cos phase, gain sin phase) / 2 over the largest gain.  So two descriptions of one controller
are one point, and at gain zero all offsets are.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from pitchopt.checks import FloatArray, finite_array, finite_number
from pitchopt.errors import InputError

__all__ = ["Parameter", "Polar", "Space"]

_SLACK = 1e-9  # of a range: rounding that counts as inside


@dataclass(frozen=True, kw_only=True)
class Parameter:
    """One parameter.

    Parameters
    ----------
    name : str
        Of the column in tables.
    low, high : float
        Bounds; of a periodic parameter the ends of one period, which are the same point.
    scale : {"linear", "log"}
        What a tuner's steps are even in.
    periodic : bool
        Whether `high` is `low` again.

    Raises
    ------
    InputError
        If the bounds have no width or do not go with the scale.
    """

    name: str
    low: float
    high: float
    scale: Literal["linear", "log"] = "linear"
    periodic: bool = False

    def __post_init__(self) -> None:
        if not self.name:
            raise InputError(f"name: got {self.name!r}, expected the name of a parameter")
        low = finite_number(f"low bound of {self.name}", self.low)
        high = finite_number(f"high bound of {self.name}", self.high)
        object.__setattr__(self, "low", low)
        object.__setattr__(self, "high", high)
        if not low < high:
            raise InputError(
                f"bounds of {self.name}: got {low:g} to {high:g}, expected a low bound below the "
                "high one; a parameter that is not to be tuned stays out of the space"
            )
        if self.scale not in ("linear", "log"):
            raise InputError(f"scale of {self.name}: got {self.scale!r}, expected linear or log")
        if self.scale == "log" and (low <= 0.0 or self.periodic):
            raise InputError(
                f"scale of {self.name}: got log, expected linear for a periodic parameter and for "
                f"a low bound of {low:g}"
            )

    @property
    def width(self) -> float:
        """High less low bound."""
        return self.high - self.low


@dataclass(frozen=True, kw_only=True)
class Polar:
    """A gain and the phase that belongs to it: radius and angle in a plane.

    Parameters
    ----------
    radius : str
        Name of a parameter on a linear scale; a negative one is a positive one half a period on.
    angle : str
        Name of a periodic parameter.
    """

    radius: str
    angle: str


class Space:
    """Parameters that are tuned together.

    Parameters
    ----------
    parameters : sequence of Parameter
    polar : sequence of Polar
        Pairs that a surrogate sees as points in a plane.

    Attributes
    ----------
    names : tuple of str
    lower, upper : (d,) ndarray
        Bounds.
    groups : (f,) ndarray of int
        Length scale that each feature has: features of one group share theirs.

    Raises
    ------
    InputError
        If a name stands twice or a pair does not fit.
    """

    def __init__(self, parameters: Iterable[Parameter], polar: Sequence[Polar] = ()) -> None:
        self.parameters = tuple(parameters)
        self.polar = tuple(polar)
        if not self.parameters:
            raise InputError("parameters: got none, expected at least one")
        self.names = tuple(parameter.name for parameter in self.parameters)
        for name in self.names:
            if self.names.count(name) > 1:
                raise InputError(f"parameters: got {name!r} twice, expected each name once")
        self.lower = finite_array("lower", [p.low for p in self.parameters])
        self.upper = finite_array("upper", [p.high for p in self.parameters])
        self.periodic = np.array([p.periodic for p in self.parameters])
        self._log = np.array([p.scale == "log" for p in self.parameters])
        self._pairs = [self._pair(pair) for pair in self.polar]
        used = [place for pair in self._pairs for place in pair]
        if len(set(used)) < len(used):
            raise InputError("polar: got a parameter in two pairs, expected each in one")
        self._single = [place for place in range(len(self.names)) if place not in used]
        groups = [
            place
            for place in self._single
            for _ in range(2 if self.parameters[place].periodic else 1)
        ]
        groups += [radius for radius, _ in self._pairs for _ in range(2)]
        order = {place: group for group, place in enumerate(dict.fromkeys(groups))}
        self.groups = np.array([order[place] for place in groups])

    def _pair(self, pair: Polar) -> tuple[int, int]:
        for name in (pair.radius, pair.angle):
            if name not in self.names:
                raise InputError(f"polar: got {name!r}, expected one of {', '.join(self.names)}")
        radius, angle = self.names.index(pair.radius), self.names.index(pair.angle)
        if not self.parameters[angle].periodic:
            raise InputError(f"polar: got angle {pair.angle!r}, expected a periodic parameter")
        plain = self.parameters[radius]
        if plain.periodic or plain.scale != "linear":
            raise InputError(f"polar: got radius {pair.radius!r}, expected a linear parameter")
        return radius, angle

    def __len__(self) -> int:
        return len(self.parameters)

    def bounded(self, bounds: Mapping[str, tuple[float, float]]) -> Space:
        """The same parameters with other bounds of some of them.

        Raises
        ------
        InputError
            If there is no such parameter, or bounds do not fit it.
        """
        for name in bounds:
            if name not in self.names:
                raise InputError(f"bounds: got {name!r}, expected one of {', '.join(self.names)}")
        changed = [
            dataclasses.replace(p, low=bounds[p.name][0], high=bounds[p.name][1])
            if p.name in bounds
            else p
            for p in self.parameters
        ]
        return Space(changed, self.polar)

    def point(self, x: ArrayLike) -> FloatArray:
        """Read-only copy of a point, inside the bounds: periodic parameters come back by turns.

        Raises
        ------
        InputError
            If the point has another length, is not finite or lies outside.
        """
        given = finite_array("x", x, shape=(len(self),))
        point = self.project(given)
        slack = _SLACK * (self.upper - self.lower)
        outside = (np.abs(point - given) > slack) & ~self.periodic
        if np.any(outside):
            place = int(np.argmax(outside))
            raise InputError(
                f"x: got {self.names[place]} = {given[place]:g}, expected between "
                f"{self.lower[place]:g} and {self.upper[place]:g}"
            )
        point.setflags(write=False)
        return point

    def project(self, x: ArrayLike) -> FloatArray:
        """Nearest point inside; periodic parameters come back by whole turns."""
        x = np.asarray(x, dtype=np.float64)
        turned = self.lower + np.mod(x - self.lower, self.upper - self.lower)
        turned = np.where(turned < self.upper, turned, self.lower)  # both are one point
        return np.where(self.periodic, turned, np.clip(x, self.lower, self.upper))

    def to_unit(self, x: ArrayLike) -> FloatArray:
        """Unit coordinates (..., d) of points (..., d)."""
        x = np.asarray(x, dtype=np.float64)
        safe = np.where(self._log, np.maximum(x, np.finfo(float).tiny), 1.0)
        ends = np.where(self._log, self.lower, 1.0), np.where(self._log, self.upper, math.e)
        log = np.log(safe / ends[0]) / np.log(ends[1] / ends[0])
        return np.where(self._log, log, (x - self.lower) / (self.upper - self.lower))

    def from_unit(self, u: ArrayLike) -> FloatArray:
        """Points (..., d) of unit coordinates (..., d), which may lie outside by rounding."""
        given = np.asarray(u, dtype=np.float64)
        u = np.where(self.periodic, np.mod(given, 1.0), np.clip(given, 0.0, 1.0))
        ratio = np.where(self._log, self.upper / np.where(self._log, self.lower, 1.0), 1.0)
        log = np.where(self._log, self.lower, 1.0) * ratio**u
        x = np.where(self._log, log, self.lower + u * (self.upper - self.lower))
        return np.clip(x, self.lower, self.upper)

    def features(self, u: ArrayLike) -> FloatArray:
        """What a surrogate sees of unit coordinates: (..., f) of (..., d)."""
        u = np.asarray(u, dtype=np.float64)
        columns = []
        for place in self._single:
            if self.parameters[place].periodic:
                phase = 2.0 * np.pi * u[..., place]
                columns += [0.5 * np.cos(phase), 0.5 * np.sin(phase)]
            else:
                columns.append(u[..., place])
        for radius, angle in self._pairs:
            half, phase = self._half_radius(radius, u), 2.0 * np.pi * u[..., angle]
            columns += [half * np.cos(phase), half * np.sin(phase)]
        return np.stack(columns, axis=-1)

    def jacobian(self, u: ArrayLike) -> FloatArray:
        """Derivatives of the features: (..., f, d) of unit coordinates (..., d)."""
        u = np.asarray(u, dtype=np.float64)
        jacobian = np.zeros((*u.shape[:-1], self.groups.size, len(self)))
        row = 0
        for place in self._single:
            if self.parameters[place].periodic:
                phase = 2.0 * np.pi * u[..., place]
                jacobian[..., row, place] = -np.pi * np.sin(phase)
                jacobian[..., row + 1, place] = np.pi * np.cos(phase)
                row += 2
            else:
                jacobian[..., row, place] = 1.0
                row += 1
        for radius, angle in self._pairs:
            half, phase = self._half_radius(radius, u), 2.0 * np.pi * u[..., angle]
            slope = 0.5 * self.parameters[radius].width / self._largest(radius)
            jacobian[..., row, radius] = slope * np.cos(phase)
            jacobian[..., row + 1, radius] = slope * np.sin(phase)
            jacobian[..., row, angle] = -2.0 * np.pi * half * np.sin(phase)
            jacobian[..., row + 1, angle] = 2.0 * np.pi * half * np.cos(phase)
            row += 2
        return jacobian

    def _largest(self, radius: int) -> float:
        parameter = self.parameters[radius]
        return max(abs(parameter.low), abs(parameter.high))

    def _half_radius(self, radius: int, u: FloatArray) -> FloatArray:
        parameter = self.parameters[radius]
        gain = parameter.low + u[..., radius] * parameter.width
        return np.asarray(0.5 * gain / self._largest(radius))

    def document(self) -> dict[str, object]:
        """Plain data that names the space, for journals and JSON."""
        return {
            "parameters": [
                {
                    "name": p.name,
                    "low": p.low,
                    "high": p.high,
                    "scale": p.scale,
                    "periodic": p.periodic,
                }
                for p in self.parameters
            ],
            "polar": [[pair.radius, pair.angle] for pair in self.polar],
        }
