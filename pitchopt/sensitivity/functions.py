"""Functions f(x, c), g(x, c) <= 0 and h(x, c) = 0 with their optimum as a model."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import sparse

from pitchopt.checks import FloatArray, finite_array, finite_number
from pitchopt.errors import ComputationError, InputError
from pitchopt.sensitivity.differences import settled_derivative
from pitchopt.sensitivity.elastic import unmet_linear
from pitchopt.sensitivity.model import Counts, Gradients, Slope, Unmet, Values, sizes, solid
from pitchopt.sensitivity.rows import Block, Layout

__all__ = ["FunctionModel", "Parts", "parameter_array", "plain_blocks", "sense_sign"]

Function = Callable[[Any, Any], Any]
GradientsOf = Callable[[Any, Any], Sequence[Any]]
X_STEP = 1e-3


def sense_sign(sense: str) -> float:
    """1 for min, -1 for max."""
    if sense not in ("min", "max"):
        raise InputError(f"sense: got {sense!r}, expected min or max")
    return 1.0 if sense == "min" else -1.0


def parameter_array(name: str, value: ArrayLike) -> NDArray[np.float64]:
    """Finite float copy of a number or an array of any shape."""
    try:
        array = np.array(value)
        if array.dtype.kind not in "iuf":
            raise TypeError
        array = array.astype(np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"{name}: got {value!r}, expected a number or numbers") from error
    if array.size == 0 or not np.isfinite(array).all():
        raise InputError(f"{name}: got {value!r}, expected finite numbers")
    return array


def plain_blocks(
    kind: Literal["inequality", "equality"], rows: int, names: str | Sequence[str] | None
) -> Block:
    """Block of rows under one name or with a name each."""
    default = "g" if kind == "inequality" else "h"
    if names is None or isinstance(names, str):
        return Block(name=names or default, kind=kind, rows=rows, shape=(rows,))
    if len(names) != rows:
        raise InputError(f"names of {default}: got {len(names)}, expected {rows}, one for each row")
    return Block(name=default, kind=kind, rows=rows, names=tuple(str(n) for n in names))


class Parts:
    """Multipliers of g and h, checked, and the layout of their rows."""

    def __init__(
        self,
        inequality: FloatArray | None,
        equality: FloatArray | None,
        names: str | Sequence[str] | None,
        equality_names: str | Sequence[str] | None,
    ) -> None:
        blocks = []
        if inequality is not None:
            largest = float(np.max(np.abs(inequality), initial=0.0))
            low = int(np.argmin(inequality)) if inequality.size else 0
            if inequality.size and inequality[low] < -1e-6 * largest:
                raise InputError(
                    f"multipliers: number {low} is {inequality[low]:.3g}, expected none below zero "
                    "for g <= 0, minimising f or maximising it; a constraint g >= 0 is -g <= 0"
                )
            blocks.append(plain_blocks("inequality", inequality.size, names))
        if equality is not None:
            blocks.append(plain_blocks("equality", equality.size, equality_names))
        self.layout = Layout(tuple(blocks))
        given = [v for v in (inequality, equality) if v is not None]
        self.multipliers = np.concatenate([np.zeros(0), *given])


class FunctionModel:
    """See `PostOptimum.from_functions` for the parameters."""

    keeps_slopes = True

    def __init__(
        self,
        f: Function,
        g: Function | None,
        h: Function | None,
        *,
        x: ArrayLike,
        c: ArrayLike,
        sense: str,
        multipliers: ArrayLike | None,
        equality_multipliers: ArrayLike | None,
        names: str | Sequence[str] | None,
        equality_names: str | Sequence[str] | None,
        c_gradients: GradientsOf | None,
        x_gradients: GradientsOf | Literal["differences", "none"],
        step: float | None,
        x_scale: ArrayLike | None,
    ) -> None:
        self.sense = sense_sign(sense)
        self.reference = parameter_array("c", c)
        self._x = finite_array("x", x)
        for name, function, lam in (
            ("g", g, multipliers),
            ("h", h, equality_multipliers),
        ):
            if (function is None) != (lam is None):
                raise InputError(f"{name}: expected the function and its multipliers, or neither")
        for name, function in (("f", f), ("g", g), ("h", h)):
            if function is not None and not callable(function):
                raise InputError(f"{name}: got {type(function).__name__}, expected a callable")
        if isinstance(x_gradients, str) and x_gradients not in ("differences", "none"):
            raise InputError(
                f"x_gradients: got {x_gradients!r}, expected differences, none or a callable"
            )
        parts = Parts(
            None if multipliers is None else finite_array("multipliers", multipliers),
            None
            if equality_multipliers is None
            else finite_array("equality_multipliers", equality_multipliers),
            names,
            equality_names,
        )
        self.layout, self.multipliers = parts.layout, parts.multipliers
        self._functions = [("f", f), ("g", g), ("h", h)]
        self._c_gradients, self._x_gradients = c_gradients, x_gradients
        self._step = None if step is None else finite_number("step", step, above=0.0)
        self._scale = (
            sizes(self._x)
            if x_scale is None
            else finite_array("x_scale", x_scale, shape=self._x.shape)
        )
        if (self._scale <= 0.0).any():
            raise InputError("x_scale: expected positive sizes of the variables")
        self.counts = Counts()
        self._known: dict[bytes, Values] = {}
        self._known_gradients: dict[bytes, Gradients] = {}
        self._slopes: dict[bytes, tuple[float, Slope]] = {}

    @property
    def scale(self) -> FloatArray:
        """Sizes of the variables (n,)."""
        return self._scale

    def values(self, c: NDArray[np.float64], move: FloatArray | None = None) -> Values:
        """F and r at (x* + move, c), once for each point."""
        key = c.tobytes() + (b"" if move is None else move.tobytes())
        if key not in self._known:
            if move is None:
                self.counts.frozen += 1
            else:
                self.counts.moved += 1
            self._known[key] = self._evaluate(self._x if move is None else self._x + move, c)
        return self._known[key]

    def gradients(self, c: NDArray[np.float64]) -> Gradients | None:
        """In x at (x*, c), the user's or by central differences of two steps."""
        if self._x_gradients == "none":
            return None
        key = c.tobytes()
        if key not in self._known_gradients:
            self._known_gradients[key] = (
                self._differences(c)
                if isinstance(self._x_gradients, str)
                else self._given(self._x_gradients, c)
            )
        return self._known_gradients[key]

    def tangent(self, vectors: FloatArray) -> FloatArray:
        """All steps are possible."""
        return vectors

    def slope(self, dc: NDArray[np.float64]) -> Slope:
        """Along dc: the user's gradients, a prescribed step, or a checked one."""
        if self._c_gradients is not None:
            return self._given_slope(self._c_gradients, dc)
        length = float(np.linalg.norm(dc))
        if length == 0.0:
            return Slope(0.0, np.zeros(self.layout.size))
        direction = dc / length
        key = np.round(direction, 12).tobytes()
        known = self._slopes.get(key)
        if known is None or known[0] > length * (1.0 + 1e-12):
            known = (
                self._settled(direction, length)
                if self._step is None
                else self._stepped(direction, self._step)
            )
            self._slopes[key] = known
        _, unit = known
        error = None if unit.error is None else float(unit.error * length)
        return Slope(unit.objective * length, unit.entries * length, error, unit.step)

    def unmet(self, c: NDArray[np.float64], tolerance: float) -> Unmet | None:
        """To first order, if there are gradients in x."""
        gradients = self.gradients(c)
        if gradients is None:
            return None
        return unmet_linear(
            self.layout, self.values(c).entries, gradients.entries, self._scale, tolerance
        )

    # -- inside ---------------------------------------------------------------------------------

    def _evaluate(self, x: FloatArray, c: NDArray[np.float64]) -> Values:
        found: list[FloatArray] = []
        for name, function in self._functions:
            if function is None:
                continue
            raw = function(x.copy(), float(c) if c.ndim == 0 else c.copy())
            try:
                value = np.atleast_1d(np.asarray(raw, dtype=np.float64)).ravel()
            except (TypeError, ValueError) as error:
                raise InputError(
                    f"{name}: returned {type(raw).__name__}, expected numbers"
                ) from error
            if not np.isfinite(value).all():
                raise InputError(
                    f"dc: with {(c - self.reference).tolist()} {name} returned NaN or infinite "
                    f"values at {'x*' if x is self._x else 'an x near x*'}; expected a dc within "
                    "the domain of the functions"
                )
            found.append(value)
        if found[0].size != 1:
            raise InputError(f"f: returned {found[0].size} numbers, expected one")
        entries = np.concatenate([np.zeros(0), *found[1:]])
        if entries.size != self.layout.size:
            raise InputError(
                f"g and h: returned {entries.size} numbers, expected {self.layout.size}, one for "
                "each multiplier"
            )
        return Values(self.sense * float(found[0][0]), entries)

    def _given(self, gradients: GradientsOf, c: NDArray[np.float64]) -> Gradients:
        self.counts.gradients += 1
        f, rows = self._parts(gradients, c, self._x.size, "x_gradients")
        return Gradients(f, sparse.csr_array(rows))

    def _given_slope(self, gradients: GradientsOf, dc: NDArray[np.float64]) -> Slope:
        f, rows = self._parts(gradients, self.reference, dc.size, "c_gradients")
        return Slope(float(f @ dc.ravel()), np.asarray(rows @ dc.ravel()))

    def _parts(
        self, gradients: GradientsOf, c: NDArray[np.float64], columns: int, name: str
    ) -> tuple[FloatArray, FloatArray]:
        given = gradients(self._x.copy(), float(c) if c.ndim == 0 else c.copy())
        expected = [k for k, function in self._functions if function is not None]
        if not isinstance(given, (tuple, list)) or len(given) != len(expected):
            raise InputError(f"{name}: expected gradients of {', '.join(expected)} in that order")
        found = []
        for part, key in zip(given, expected, strict=True):
            try:
                array = solid(part).reshape(-1, columns)
            except (TypeError, ValueError) as error:
                raise InputError(
                    f"{name}: that of {key} does not have {columns} columns"
                ) from error
            found.append(array)
        rows = np.concatenate([np.zeros((0, columns)), *found[1:]])
        if found[0].shape[0] != 1 or rows.shape[0] != self.layout.size:
            raise InputError(
                f"{name}: got {found[0].shape[0]} and {rows.shape[0]} rows, expected 1 for f and "
                f"{self.layout.size} for the constraints"
            )
        if not (np.isfinite(found[0]).all() and np.isfinite(rows).all()):
            raise InputError(f"{name}: got NaN or infinite values")
        return self.sense * found[0][0], rows

    def _differences(self, c: NDArray[np.float64]) -> Gradients:
        n = self._x.size
        start = self.values(c).vector
        both: list[FloatArray] = []
        size = 1e-12 * np.abs(start) / X_STEP + 1e-300
        for step in (X_STEP, 0.5 * X_STEP):
            columns = []
            for i in range(n):
                move = np.zeros(n)
                move[i] = step * self._scale[i]
                up, down = self.values(c, move), self.values(c, -move)
                columns.append((up.vector - down.vector) / (2.0 * move[i]))
                size = np.maximum(size, np.abs(up.vector - start) / step)
            both.append(np.array(columns).T)
        coarse, fine = both
        value = (4.0 * fine - coarse) / 3.0
        off = np.linalg.norm((value - fine) * self._scale, axis=1)
        error = float(np.max(off / size))
        if error > 0.1:
            raise ComputationError(
                f"gradients in x: differences of two steps disagree by {100 * error:.0f} %; give "
                "x_gradients, another x_scale, or x_gradients='none' to leave assumptions unjudged"
            )
        return Gradients(value[0], sparse.csr_array(value[1:]), error)

    def _stepped(self, direction: NDArray[np.float64], step: float) -> tuple[float, Slope]:
        start = self.values(self.reference).vector
        value = (self.values(self.reference + step * direction).vector - start) / step
        return 0.0, Slope(float(value[0]), value[1:], None, step)

    def _settled(self, direction: NDArray[np.float64], length: float) -> tuple[float, Slope]:
        def terms(t: float) -> FloatArray:
            return self.values(self.reference + t * length * direction).vector

        weights = np.concatenate([[1.0], self.multipliers])
        name = f"dc = {(length * direction).tolist()}"
        found = settled_derivative(terms, weights, name=name)
        value, step = found.value / length, found.step * length
        return step, Slope(float(value[0]), value[1:], found.error / length, step)
