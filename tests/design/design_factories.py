"""Small curves, problems and models that the design tests share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pitchopt.aero.curves import BladeCurves
from pitchopt.design.limits import PitchLimits
from pitchopt.design.problem import DesignProblem, Objective

FloatArray = NDArray[np.float64]
Rng = np.random.Generator

OMEGA = 2.0


def wide_limits(pitch_rate: float = np.radians(10.0)) -> PitchLimits:
    return PitchLimits(rotor_speed=OMEGA, pitch_rate=pitch_rate)


def analytic(psi: FloatArray, beta: FloatArray, size: float = 1.0) -> dict[str, FloatArray]:
    """Loads of a made-up blade in sheared wind with a dip where the tower stands."""
    wind = 1.0 + 0.15 * np.cos(psi) - 0.06 * np.exp(-((np.mod(psi, 2 * np.pi) - np.pi) ** 2) / 0.1)
    return {
        "torque": size * (wind**2 * (4.0 + 2.0 * beta) - 40.0 * beta**2),
        "bending": size * (wind * 9.0 - 30.0 * beta + 12.0 * beta**2),
        "thrust": size * (wind * 0.5 - 1.2 * beta + 0.3 * beta**2),
        "radial": size * 0.05 * wind * np.ones_like(beta),
    }


def rotor_curves(
    *,
    blades: int = 3,
    positions: int = 8,
    knots: int = 17,
    size: float = 1e5,
    rates: float = 0.0,
    lower: float = -0.1,
    upper: float = 0.25,
    **extra: Any,
) -> BladeCurves:
    """Concave, smooth curves that look like a rotor's."""
    n = blades * positions
    psi = 2 * np.pi * np.arange(n) / n
    beta = np.tile(np.linspace(lower, upper, knots), (n, 1))
    loads = analytic(psi[:, None], beta, size)
    rate = {
        "torque_rate": 0.2 * rates * size * (1 + 0.1 * np.cos(psi)),
        "bending_rate": rates * size * (1 + 0.1 * np.cos(psi)),
        "thrust_rate": 0.05 * rates * size * np.ones(n),
        "radial_rate": 0.3 * rates * size * np.ones(n),
    }
    return BladeCurves(blades=blades, azimuth=psi, beta=beta, **loads, **rate, **extra)


def random_curves(
    rng: Rng,
    *,
    blades: int = 3,
    positions: int = 4,
    knots: int = 5,
    concave: bool = True,
    rates: bool = False,
    size: float = 1.0,
    span: float = 0.4,
    frozen: bool = False,
) -> BladeCurves:
    """Rough random curves; every row has breakpoints of its own."""
    n = blades * positions
    start = rng.uniform(0, 2 * np.pi)
    psi = start + 2 * np.pi * np.arange(n) / n
    gaps = rng.uniform(0.05, 1.0, (n, knots - 1))
    beta = np.concatenate([np.zeros((n, 1)), np.cumsum(gaps, axis=1)], axis=1)
    beta = span * (beta / beta[:, -1:] - 0.3)
    if concave:
        slopes = -np.sort(-rng.normal(0.0, 1.0, (n, knots - 1)), axis=1)
    else:
        slopes = rng.normal(0.0, 1.0, (n, knots - 1))
    rises = slopes * np.diff(beta, axis=1) / span
    torque = rng.normal(2.0, 0.3, (n, 1)) + np.concatenate(
        [np.zeros((n, 1)), np.cumsum(rises, axis=1)], axis=1
    )
    others = {
        name: size * (rng.normal(0.0, 0.5, (n, 1)) + np.cumsum(rng.normal(0, 0.4, (n, knots)), 1))
        for name in ("bending", "thrust", "radial")
    }
    extra: dict[str, Any] = {}
    if rates:
        for name in ("torque_rate", "bending_rate", "thrust_rate", "radial_rate"):
            extra[name] = size * rng.normal(0.0, 0.1, n)
    if frozen:
        low, high = float(beta[:, 0].max()), float(beta[:, -1].min())
        extra["mean_pitch"] = low + rng.uniform(0.2, 0.8) * (high - low)
    return BladeCurves(
        blades=blades, azimuth=psi, beta=beta, torque=size * torque, **others, **extra
    )


def random_profile(rng: Rng, problem: DesignProblem) -> FloatArray:
    """A feasible profile: noise of some smoothness and reach, repaired."""
    curves = problem.curves
    n = curves.stations
    psi = 2 * np.pi * np.arange(n) / n
    low, high = problem.constant_range
    width = float(np.max(curves.upper - curves.lower))
    kind = rng.integers(4)
    if kind == 0:
        raw = rng.uniform(curves.lower, curves.upper)
    elif kind == 1:
        raw = rng.uniform(low, high) + rng.normal(0, width / 4) * np.cos(psi - rng.uniform(0, 6.3))
    elif kind == 2:
        raw = np.full(n, rng.uniform(low, high)) if high > low else np.full(n, low)
    else:
        raw = curves.beta[np.arange(n), rng.integers(curves.beta.shape[1], size=n)]
    return problem.repaired(np.asarray(raw))


def slow_loads(curves: BladeCurves, profile: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Rotor loads (4, m) and bending (N,), written as loops over stations with plain sums."""
    beta = np.asarray(profile, dtype=float)
    n, b = beta.size, curves.blades
    m = n // b
    spacing = 2 * np.pi / n
    rotor = np.zeros((4, m))
    bending = np.zeros(n)
    for i in range(n):
        rate = (beta[(i + 1) % n] - beta[(i - 1) % n]) / (2 * spacing)

        def at(name: str, i: int = i, rate: float = rate) -> float:
            table = np.interp(beta[i], curves.beta[i], getattr(curves, name)[i])
            return float(table + rate * getattr(curves, f"{name}_rate")[i])

        c, s = np.cos(curves.azimuth[i]), np.sin(curves.azimuth[i])
        k = i % m
        rotor[0, k] += at("torque")
        rotor[1, k] += at("bending") * c - at("radial") * s
        rotor[2, k] += at("bending") * s + at("radial") * c
        rotor[3, k] += at("thrust")
        bending[i] = at("bending")
    return rotor, bending


def slow_value(curves: BladeCurves, profile: FloatArray, objective: Objective) -> float:
    """The objective of the normal form from :func:`slow_loads`."""
    rotor, bending = slow_loads(curves, profile)
    rms = [np.sqrt(np.mean((row - row.mean()) ** 2)) for row in (*rotor, bending)]
    travel = sum(abs(profile[(i + 1) % profile.size] - profile[i]) for i in range(profile.size))
    return float(
        objective.torque * rotor[0].mean()
        - sum(lam * j for lam, j in zip(objective.rms, rms, strict=True))
        - objective.travel * travel
    )


@dataclass(frozen=True)
class Blade:
    """Loads of one blade, as a model returns them."""

    torque: FloatArray
    bending: FloatArray
    thrust: FloatArray
    radial: FloatArray


@dataclass(frozen=True)
class SmoothModel:
    """A rotor without induction whose curves are chords of :func:`analytic`."""

    blades: int = 3
    knots: int = 33
    induction: str = "none"

    def curves(self, positions: int, mean_pitch: float | None = None) -> BladeCurves:
        del mean_pitch  # no wake to freeze
        return rotor_curves(blades=self.blades, positions=positions, knots=self.knots)

    def blade_loads(
        self,
        azimuth: ArrayLike,
        pitch: ArrayLike,
        pitch_rate: float = 0.0,
        mean_pitch: float | None = None,
    ) -> Blade:
        del pitch_rate, mean_pitch
        psi, beta = np.broadcast_arrays(
            np.asarray(azimuth, dtype=float), np.asarray(pitch, dtype=float)
        )
        return Blade(**analytic(psi, beta, 1e5))


@dataclass(frozen=True, kw_only=True)
class Case:
    """A problem, an objective that a known profile satisfies, and that profile."""

    problem: DesignProblem
    objective: Objective
    profile: FloatArray
    size: float
    name: str


def drawn_case(
    seed: int,
    *,
    concave: bool | None = None,
    constrained: bool = True,
    degenerate: bool = False,
    harmonics: bool = True,
    smooth: bool | None = None,
    largest: tuple[int, int, int] = (3, 6, 7),
) -> Case:
    """A random case of every kind that the normal form knows; the same for the same seed."""
    rng = np.random.default_rng(seed)
    blades = int(rng.integers(1, largest[0] + 1))
    positions = int(rng.integers(1, largest[1] + 1))
    knots = int(rng.integers(2, largest[2] + 1))
    size = float(10.0 ** rng.choice([-3, 0, 5, 9])) if degenerate else 1.0
    span = float(rng.choice([1e-4, 1e-2, 0.4])) if degenerate else 0.4
    shaped = bool(rng.random() < 0.5) if concave is None else concave
    frozen, rates = bool(rng.random() < 0.3), bool(rng.random() < 0.4)
    if bool(rng.random() < 0.5) if smooth is None else smooth:
        size, span = 1e5, 0.35
        extra = {"mean_pitch": float(rng.uniform(0.0, 0.1))} if frozen else {}
        curves = rotor_curves(
            blades=blades,
            positions=positions,
            knots=5 * knots,
            rates=0.01 if rates else 0.0,
            **extra,
        )
    else:
        curves = random_curves(
            rng,
            blades=blades,
            positions=positions,
            knots=knots,
            concave=shaped,
            rates=rates,
            size=size,
            span=span,
            frozen=frozen,
        )
    rate = span * 10.0 ** rng.uniform(-1.5, 1.0)
    order = int(rng.integers(1, 3)) if harmonics and rng.random() < 0.2 else None
    problem = DesignProblem(
        curves=curves,
        limits=PitchLimits(rotor_speed=OMEGA, pitch_rate=rate),
        harmonics=order,
    )
    profile = random_profile(rng, problem)
    loads = problem.curves.evaluate(profile)
    torque = float(loads.mean[0])
    numbers = 10.0 ** rng.uniform(-2, 2, 5) * (rng.random(5) < 0.6)
    a, b, c, d, e = (float(v) for v in numbers)
    limits: dict[str, float] = {}
    kind = rng.random()
    if constrained and kind < 0.2:
        limits["blade_cap"] = float(loads.blade_rms * rng.uniform(1.0, 1.3) + 1e-6 * size)
    elif constrained and kind < 0.4:
        limits["torque_min"] = torque - abs(rng.normal()) * 0.1 * size
    elif constrained and kind < 0.5:
        limits["torque_max"] = torque + abs(rng.normal()) * 0.1 * size
    objective = Objective(
        torque=float(rng.random() < 0.7),
        rms=(a, b, c, d, e),
        travel=0.0 if rng.random() < 0.6 else size * float(rng.uniform(0, 1)) / span,
        **limits,
    )
    words = [f"{blades} blades", f"m={positions}", f"K={curves.beta.shape[1]}"]
    words += [word for word, yes in (("frozen", frozen), ("rates", rates)) if yes]
    words += [f"{order}P"] if order else []
    words += list(limits) + (["travel"] if objective.travel else [])
    return Case(
        problem=problem,
        objective=objective,
        profile=profile,
        size=size,
        name=f"{seed}: {', '.join(words)}",
    )


def best_nudge(
    problem: DesignProblem,
    objective: Objective,
    profile: FloatArray,
    rng: Rng,
    *,
    tries: int = 60,
    largest: float = 1e-3,
) -> float:
    """Largest gain over ``profile`` of small feasible moves, one station at a time included.

    Moves stay inside the segments next to the profile, so that a gain disproves a local optimum.
    """
    curves = problem.curves
    n = curves.stations
    rows, j = np.arange(n), curves.segment(profile)
    room = np.minimum(profile - curves.beta[rows, j], curves.beta[rows, j + 1] - profile)
    free = room[room > 1e-5]
    width = float(np.diff(curves.beta, axis=1).min())
    largest = min(largest, 0.3 * width, 0.9 * float(free.min()) if free.size else largest)
    value = slow_value(curves, profile, objective)
    excess = np.array(problem.excess(curves.evaluate(profile), objective))
    allowed = np.maximum(excess, 1e-9 * np.abs(curves.torque).max())
    gain = -np.inf
    directions = [*np.eye(n), *-np.eye(n)]
    directions += [rng.normal(size=n) for _ in range(tries // 2)]
    directions += [rng.choice([-1.0, 0.0, 1.0], n, p=[0.3, 0.4, 0.3]) for _ in range(tries // 2)]
    for direction in directions:
        step = min(largest, 10.0 ** rng.uniform(-5, -3))
        moved = problem.repaired(profile + step * direction / max(np.abs(direction).max(), 1e-9))
        if np.any(np.array(problem.excess(curves.evaluate(moved), objective)) > allowed):
            continue
        gain = max(gain, slow_value(curves, moved, objective) - value)
    return gain
