"""Tuners by their names."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Mapping
from difflib import get_close_matches
from importlib import import_module

from numpy.typing import ArrayLike

from pitchopt.checks import whole_number
from pitchopt.errors import InputError
from pitchopt.tuning.space import Space
from pitchopt.tuning.tuner import Tuner

__all__ = ["METHODS", "make_tuner", "method_options"]

_CLASSES = {
    "zoo": ("zeroth_order", "ZerothOrder"),
    "bayes": ("bayesian", "Bayesian"),
    "grid": ("grid", "Grid"),
    "random": ("sampling", "RandomSearch"),
    "lhs": ("sampling", "LatinHypercube"),
    "sobol": ("sampling", "Sobol"),
    "spsa": ("spsa", "Spsa"),
    "nelder-mead": ("scipy_methods", "NelderMead"),
    "cobyla": ("scipy_methods", "Cobyla"),
    "cma-es": ("cma_es", "CmaEs"),
}
METHODS = tuple(_CLASSES)
"""Names of the tuners."""


def make_tuner(
    name: str,
    space: Space,
    *,
    start: ArrayLike | None = None,
    evaluations: int,
    seed: int = 0,
    options: Mapping[str, object] | None = None,
) -> Tuner:
    """Tuner of a name, laid out for a number of evaluations.

    Parameters
    ----------
    name : str
        One of `METHODS`.
    space : Space
    start : (d,) array_like, optional
        Point to begin from, in the units of the space.
    evaluations : int
        That will be asked for: what of stages, iterations, samples and points is not among the
        options is chosen so that they are used up and no more are needed than by a tuner's nature.
    seed : int
    options : mapping, optional
        Arguments of the tuner's class by name, other than these.

    Raises
    ------
    InputError
        If there is no such tuner or option, or a value does not fit.
    """
    count = whole_number("evaluations", evaluations, at_least=1)
    if start is not None and name in ("grid", "lhs"):
        count = max(1, count - 1)  # theirs come after the start
    given = dict(options or {})
    allowed = method_options(name)
    for option in given:
        if option not in allowed:
            raise InputError(
                f"option of {name}: got {option!r}, "
                + (f"expected one of {', '.join(allowed)}" if allowed else "it has none")
                + _hint(option, allowed)
            )
    if (layout := _LAYOUTS.get(name)) is not None:
        given = layout(len(space), count, given) | given
    return _class(name)(space, start=start, seed=seed, **given)


def method_options(name: str) -> tuple[str, ...]:
    """Names of the options of a tuner.

    Raises
    ------
    InputError
        If there is no tuner of this name.
    """
    parameters = inspect.signature(_class(name)).parameters
    return tuple(option for option in parameters if option not in ("space", "start", "seed"))


def _zoo_layout(size: int, evaluations: int, options: Mapping[str, object]) -> dict[str, object]:
    samples = whole_number("samples", options.get("samples") or size + 1, at_least=1)
    return {"stages": max(1, math.ceil((evaluations - 1) / (samples + 1)))}


def _grid_layout(size: int, evaluations: int, options: Mapping[str, object]) -> dict[str, object]:
    if "points" in options:
        return {}
    points = max(2, int(evaluations ** (1.0 / size) + 1e-9))
    left = max(0, evaluations - points**size)
    return {"points": points, "rounds": math.ceil(left / (points**size - 1))}


def _lhs_layout(size: int, evaluations: int, options: Mapping[str, object]) -> dict[str, object]:  # noqa: ARG001
    return {"samples": evaluations}


def _spsa_layout(size: int, evaluations: int, options: Mapping[str, object]) -> dict[str, object]:  # noqa: ARG001
    calibration = whole_number("calibration", options.get("calibration", 3), at_least=1)
    return {"iterations": max(0, (evaluations - 2) // 2 - calibration)}


_LAYOUTS = {
    "zoo": _zoo_layout,
    "grid": _grid_layout,
    "lhs": _lhs_layout,
    "spsa": _spsa_layout,
}


def _class(name: str) -> Callable[..., Tuner]:
    if name not in _CLASSES:
        raise InputError(
            f"method: got {name!r}, expected one of {', '.join(METHODS)}" + _hint(name, METHODS)
        )
    module, attribute = _CLASSES[name]
    found: Callable[..., Tuner] = getattr(import_module(f"pitchopt.tuning.{module}"), attribute)
    return found


def _hint(word: object, words: tuple[str, ...]) -> str:
    close = get_close_matches(str(word).lower(), words, n=1)
    return f"; did you mean {close[0]}?" if close else ""
