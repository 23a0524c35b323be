"""Blocks of a convex subproblem: what belongs to a profile, and what belongs to a set of curves.

A subproblem is one or several profiles, each with its box, rate limits, restriction to
harmonics and price of travel, and one or several sets of curves that stand on one of them, each
with its torque, its RMS values and its limits:

    value = a sum_n t_n / m + (rate terms) - sum_l lambda_l s_l - kappa sum_n u_n - rho . slack
    t_n <= value_nj + slope_nj (beta_n - beta0_n)             the segments in reach of the box
    s_l >= || load_l(beta0) + G_l (beta - beta0) - mean_l 1 ||_2 / sqrt(m)

The free variable mean_l is at its best the mean, which keeps the rows sparse.  Pitch is scaled
by the box, loads by what the box can change them by.  :mod:`pitchopt.design.direct` puts one of
each together, :mod:`pitchopt.design.joint_subproblem` several.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from pitchopt.design.cones import ConeProgram
from pitchopt.design.linear import LinearModel, torque_lines
from pitchopt.design.multipliers import Multipliers
from pitchopt.design.problem import DesignProblem, Objective

__all__ = ["CurveBlock", "ProfileBlock", "bend"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]


class ProfileBlock:
    """Variables and rows of one profile; pitch moves in units of the box."""

    def __init__(
        self,
        program: ConeProgram,
        problem: DesignProblem,
        point: FloatArray,
        low: FloatArray,
        high: FloatArray,
        radius: float,
    ) -> None:
        self.problem, self.radius = problem, radius
        self.point, self.low, self.high = point, low, high
        self.index = np.arange(point.size)
        self.following = np.roll(self.index, -1)
        self.pitch = program.variables("pitch", point.size).start
        self.travel: int | None = None
        self._mean: slice | None = None
        self._basis: slice | None = None
        self._rate: list[tuple[slice, IntArray, float]] = []

    def add_travel(self, program: ConeProgram) -> None:
        """Variables u_n >= |beta_{n+1} - beta_n|."""
        self.travel = program.variables("u", self.point.size).start

    def constrain(self, program: ConeProgram) -> None:
        """Rows of mean pitch, harmonics, box, rate limits and travel."""
        problem, point, radius = self.problem, self.point, self.radius
        idx, at = self.index, self.pitch + self.index
        after = self.pitch + self.following
        if problem.curves.mean_pitch is not None:
            gap = (problem.curves.mean_pitch - float(point.mean())) * point.size / radius
            self._mean = program.zero(np.array([gap]), (0, at, 1.0))
        if problem.basis is not None:
            basis = problem.basis
            f = program.variables("fourier", basis.shape[1]).start
            column = np.tile(f + np.arange(basis.shape[1]), point.size)
            self._basis = program.zero(
                -point / radius,
                (idx, at, 1.0),
                (np.repeat(idx, basis.shape[1]), column, -basis.ravel()),
            )
        program.nonneg((self.high - point) / radius, (idx, at, 1.0))
        program.nonneg((point - self.low) / radius, (idx, at, -1.0))
        change = (point[self.following] - point) / radius
        for sign in (1.0, -1.0):
            room = problem.step / radius - sign * change
            near = np.flatnonzero(room < 2.0)
            k = np.arange(near.size)
            rows = program.nonneg(room[near], (k, after[near], sign), (k, at[near], -sign))
            self._rate.append((rows, near, sign))
        if self.travel is not None:
            u = self.travel + idx
            for sign in (1.0, -1.0):
                rows = program.nonneg(
                    -sign * change, (idx, after, sign), (idx, at, -sign), (idx, u, -1.0)
                )
                self._rate.append((rows, idx, sign))

    def profile(self, x: FloatArray) -> FloatArray:
        """The profile of a solution [rad]."""
        return np.asarray(self.point + self.radius * x[self.pitch : self.pitch + self.point.size])

    def rate(self, z: FloatArray) -> FloatArray:
        """w_n of the change from station n to n + 1 [N m/rad]."""
        w = np.zeros(self.point.size)
        for rows, near, sign in self._rate:
            w[near] += sign * z[rows] / self.radius
        return w

    def mean(self, z: FloatArray) -> float:
        """Multiplier of the mean-pitch condition [N m/rad]."""
        if self._mean is None:
            return 0.0
        return float(z[self._mean][0]) * self.point.size / self.radius

    def basis(self, z: FloatArray) -> FloatArray | float:
        """Multipliers of the restriction to harmonics [N m/rad]."""
        return 0.0 if self._basis is None else np.asarray(z[self._basis] / self.radius)


class CurveBlock:
    """Variables, rows and value of one set of curves on the pitch of a profile."""

    def __init__(
        self,
        program: ConeProgram,
        profile: ProfileBlock,
        model: LinearModel,
        objective: Objective,
        *,
        tight: bool,
        curved: bool = False,
    ) -> None:
        """Add the variables.

        Parameters
        ----------
        tight : bool
            Scale by the loads' own size.
        curved : bool
            Torque by its slope, for a model whose curvature stands in the program's quadratic
            (:func:`bend`), instead of by its segments: far fewer rows.
        """
        self.profile, self.model, self.objective = profile, model, objective
        curves, lam = model.curves, objective.lambdas
        capped = np.isfinite(objective.blade_cap)
        self.loads = [q for q in range(5) if lam[q] > 0 or (q == 4 and capped)]
        self.units = {q: model.unit(q, tight) for q in self.loads}
        self.torque_unit = model.torque_unit
        with_torque = bool(objective.torque > 0 or np.isfinite(objective.torque_min))
        self.in_segments = with_torque and not (model.affine or curved)
        self._at = profile.pitch + profile.index
        self._costs: list[tuple[IntArray, FloatArray]] = []
        self._single: dict[str, slice] = {}
        self._load: dict[int, slice] = {}
        # t_n in units of the torque that the box changes, from the point's values
        gradient = model.torque_rate if self.in_segments else model.torque_gradient
        self._add_cost(self._at, -objective.torque * gradient * model.radius)
        n = curves.stations
        self._t = program.variables("t", n).start if self.in_segments else -1
        if self.in_segments:
            share = -objective.torque * self.torque_unit / curves.positions
            self._add_cost(self._t + profile.index, np.full(n, share))
        self._s: dict[int, int] = {}
        for q in self.loads:
            self._s[q] = program.variables(f"s{q}", 1).start
            program.variables(f"mean{q}", 1)  # the column after that of s
            self._add_cost(np.array([self._s[q]]), np.array([lam[q] * self.units[q]]))

    def _add_cost(self, columns: IntArray, values: FloatArray) -> None:
        self._costs.append((columns, values))

    @property
    def constant(self) -> float:
        """a T at the point: the value where no variable moves [N m]."""
        return self.objective.torque * self.model.torque

    @property
    def costs(self) -> list[tuple[IntArray, FloatArray]]:
        """Columns and coefficients by which the value falls below :attr:`constant`.

        The slacks of broken limits are not among them: they have a price of their own.
        """
        if self.objective.travel > 0 and self.profile.travel is not None:
            price = np.full(self.profile.index.size, self.objective.travel * self.profile.radius)
            return [*self._costs, (self.profile.travel + self.profile.index, price)]
        return self._costs

    @property
    def unit(self) -> float:
        """Size of what the box can change of the value [N m]."""
        terms = [self.objective.rms[q] * self.units[q] for q in self.loads]
        return max([self.objective.torque * self.torque_unit, *terms]) or 1.0

    # ---- rows ------------------------------------------------------------------------------

    def constrain(self, program: ConeProgram, penalty: tuple[float, float]) -> None:
        """Rows of torque, its limits, the blade cap and the RMS values.

        Parameters
        ----------
        penalty : (float, float)
            Exact-penalty weights of the torque limits and of the blade cap [-].
        """
        model = self.model
        if self.in_segments:
            station, value, slope = torque_lines(
                model.curves, model.point, model.segment, model.low, model.high
            )
            k = np.arange(station.size)
            program.nonneg(
                (value - model.blade_static[0, station]) / self.torque_unit,
                (k, self._t + station, 1.0),
                (k, self._at[station], -slope * (model.radius / self.torque_unit)),
            )
        self._torque_limits(program, penalty)
        for q in self.loads:
            self._load[q] = self._load_cone(program, q)

    def _torque_limits(self, program: ConeProgram, penalty: tuple[float, float]) -> None:
        """Limits of mean torque and of the blade's RMS, each with a priced slack."""
        model, objective, idx = self.model, self.objective, self.profile.index
        m, unit = model.curves.positions, self.torque_unit
        gradient = model.torque_gradient * (model.radius / unit)
        if np.isfinite(objective.torque_min):
            slack = program.variables("slack_min", 1, cost=penalty[0] * unit).start
            if not self.in_segments:
                entries: list[tuple[Any, Any, Any]] = [(0, self._at, -gradient)]
            else:
                entries = [
                    (0, self._t + idx, -1.0 / m),
                    (0, self._at, -model.torque_rate * (model.radius / unit)),
                ]
            self._single["min"] = program.nonneg(
                np.array([(model.torque - objective.torque_min) / unit]),
                *entries,
                (0, slack, -1.0),
            )
            program.nonneg(np.zeros(1), (0, slack, -1.0))
        if np.isfinite(objective.torque_max):
            slack = program.variables("slack_max", 1, cost=penalty[0] * unit).start
            self._single["max"] = program.nonneg(
                np.array([(objective.torque_max - model.torque) / unit]),
                (0, self._at, gradient),
                (0, slack, -1.0),
            )
            program.nonneg(np.zeros(1), (0, slack, -1.0))
        if np.isfinite(objective.blade_cap):
            slack = program.variables("slack_cap", 1, cost=penalty[1] * self.units[4]).start
            self._single["cap"] = program.nonneg(
                np.array([objective.blade_cap / self.units[4]]),
                (0, self._s[4], 1.0),
                (0, slack, -1.0),
            )
            program.nonneg(np.zeros(1), (0, slack, -1.0))

    def _load_cone(self, program: ConeProgram, load: int) -> slice:
        model, profile, unit = self.model, self.profile, self.units[load]
        idx = profile.index
        at = idx if load == 4 else idx % model.curves.positions
        residual = model.residual(load)
        weight = 1.0 / (np.sqrt(residual.size) * unit)
        entries: list[tuple[Any, Any, Any]] = [
            (0, self._s[load], -1.0),
            (1 + at, self._at, -model.slopes[load] * (model.radius * weight)),
            (1 + np.arange(residual.size), self._s[load] + 1, 1.0 / np.sqrt(residual.size)),
        ]
        if np.any(model.curves.rates):
            share = model.curves.rates[load] * (model.half * model.radius * weight)
            before = profile.pitch + np.roll(idx, 1)
            after = profile.pitch + profile.following
            entries += [(1 + at, after, -share), (1 + at, before, share)]
        return program.second_order(np.concatenate([[0.0], residual * weight]), *entries)

    # ---- answer ----------------------------------------------------------------------------

    def multipliers(self, z: FloatArray) -> Multipliers:
        """Multipliers of this block's loads and limits; those of its profile are the profile's."""
        n, m = self.model.curves.stations, self.model.curves.positions
        y_loads, y_blade = np.zeros((4, m)), np.zeros(n)
        for q, rows in self._load.items():
            y = -z[rows][1:] / (np.sqrt(n if q == 4 else m) * self.units[q])
            if q == 4:
                y_blade = y - y.mean()
            else:
                y_loads[q] = y - y.mean()
        single = {
            name: float(z[rows][0]) / (self.units[4] if name == "cap" else self.torque_unit)
            for name, rows in self._single.items()
        }
        return Multipliers(
            loads=y_loads,
            blade=y_blade,
            rate=np.zeros(n),
            torque_min=single.get("min", 0.0),
            torque_max=single.get("max", 0.0),
            cap=single.get("cap", 0.0),
        )


def bend(model: LinearModel, mult: Multipliers, torque: float = 0.0) -> FloatArray:
    """Convex part of the curvature of loads and torque, weighted by multipliers, shape (N,).

    ``torque`` is the price of mean torque, for blocks that do not model torque by segments.
    """
    assert model.curvature is not None
    y = np.concatenate([np.tile(mult.loads, (1, model.curves.blades)), mult.blade[None]])
    y[0] -= torque / model.curves.positions
    return np.asarray(np.maximum(np.sum(y * model.curvature, axis=0), 0.0))
