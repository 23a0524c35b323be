"""A pitch design as a solved problem for the estimators of `pitchopt.sensitivity`.

In the variables d (moves of the pitch from the design) and L (the blade's five loads at every
station) the last convex subproblem at the design reads

    maximise   a mean(L_torque) - sum_l lambda_l J_l(L) - (price of travel)
    subject to L_ln = line_ln(c) + slope_ln(c) d_n + rate_ln(c) d beta / d psi     g / m, -y_ln
               deviations of the flat loads = 0                                    y_l
               J_blade(L) <= cap,   torque_min(c) <= mean(L_torque) <= torque_max(c)
               +/-(beta_{n+1} + d_{n+1} - beta_n - d_n) <= D(c)
               low_n(c) <= beta_n + d_n <= high_n(c)
               mean(beta + d) as frozen, beta + d within the harmonics

with d = 0 its optimum and the multipliers of :mod:`..stationary`.  RMS values are cones
s_l >= || L_l || / sqrt(m), whose multiplier y_l is a vector: where a design holds a load flat, its
RMS has no gradient, yet y_l is there.  The lines are those that the profile stands on, followed
into another wind (:mod:`..design_lines`).  What a
parameter c changes of it is in :mod:`..design_states`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from pitchopt.checks import FloatArray
from pitchopt.sensitivity import Estimate, PostOptimum, Thresholds
from pitchopt.studies.sensitivity.design_states import States

if TYPE_CHECKING:
    from pitchopt.studies.sensitivity.design_point import DesignPoint

__all__ = ["DesignRows", "Group"]

_SMALL = 2.0**-8  # of a step, for the derivative
_LARGEST = 400  # stations up to which assumptions are judged, which takes dense algebra
_LOADS = ("mean torque", "RMS of tilt", "RMS of yaw", "RMS of thrust", "RMS of a blade")
_ROUND = 1e-4  # share by which the price of a load that is not flat may miss its limit
_SIZE = float(np.pi / 180.0)  # [rad], the size of a move


@dataclass(frozen=True, kw_only=True, eq=False)
class Group:
    """Rows of one kind: what they add to an estimate.

    Attributes
    ----------
    name : str
    first, high : float
        Of the change of the optimal value [N m].
    multiplier : float
        Sum of the multipliers' sizes, in N m per unit of the row (rad, or N m).
    share : ndarray (N,) or None
        What each station adds to ``high``; None where stations have no part.
    """

    name: str
    first: float
    high: float
    multiplier: float
    share: FloatArray | None


class DesignRows:
    """The problem around a design, as a function of one parameter.

    Parameters
    ----------
    point : DesignPoint
    name : str
        Of the parameter.
    step : float
        Change that is looked at; derivatives are taken on its side.
    judged : bool
        Whether assumptions are judged, which takes gradients.
    """

    def __init__(self, point: DesignPoint, name: str, step: float, *, judged: bool) -> None:
        self.point, self.name, self.step = point, name, step
        self.reference = point.value(name)
        kkt, problem = point.stationary, point.problem
        curves, objective = problem.curves, point.objective
        self.kkt, self.curves = kkt, curves
        self.profile = point.design.profile
        n = self.count = curves.stations
        m = curves.positions
        self.y = kkt.prices
        self.loads = [0, *(k for k in range(1, 5) if np.any(self.y[k]))]
        self.judged = judged and n <= _LARGEST
        self.states = States(point, name, all_ends=self.judged)
        self.start = self.states.start
        loads = self.start.lines.value + self.start.lines.rates * curves.profile_rate(self.profile)
        self.at = np.concatenate([np.zeros(n), *loads[self.loads]])
        self.lambdas = objective.lambdas
        self.flat = [k for k in self.loads if k < 4 and self._is_flat(k)]
        self.cap = max(objective.blade_cap, point.design.loads.blade_rms)
        self.capped = kkt.multipliers.cap > 0.0
        self.constant = kkt.value - self._gain(self.at)
        # multipliers and names, in the order of the rows
        mult = kkt.multipliers
        self.floors = [
            (text, sign, limit, price)
            for text, sign, limit, price in (
                ("mean torque kept", 1.0, "torque_min", mult.torque_min),
                ("mean torque limited", -1.0, "torque_max", mult.torque_max),
            )
            if np.isfinite(getattr(objective, limit))
        ]
        self.inequalities = np.concatenate(
            [
                [price for *_, price in self.floors],
                [mult.cap] * self.capped,
                kkt.rate_up,
                kkt.rate_down,
                kkt.lower,
                kkt.upper,
            ]
        )
        prices = [(kkt.torque_price / m if k == 0 else 0.0) - self.y[k] for k in self.loads]
        ties = [mult.loads[k] for k in self.flat]
        if curves.mean_pitch is not None:
            ties.append(np.array([mult.mean / n]))
        if problem.basis is not None:
            ties.append(np.broadcast_to(mult.basis, (n,)))
        self.equalities = np.concatenate([*prices, *ties])

    # ---- the estimate ------------------------------------------------------------------------

    @cached_property
    def post(self) -> PostOptimum:
        """The solved problem, ready for estimates."""
        sizes = [np.full(self.count, _SIZE)]
        slopes = np.abs(self.start.lines.slope[self.loads]).mean(axis=1) * _SIZE
        sizes += [np.full(self.count, max(float(size), 1.0)) for size in slopes]
        return PostOptimum.from_functions(
            self._objective,
            self._inequalities,
            self._equalities,
            x=self.at,
            c=self.reference,
            multipliers=self.inequalities,
            equality_multipliers=self.equalities,
            sense="max",
            names=self._names,
            equality_names=self._equality_names,
            c_gradients=self._slopes,
            x_gradients=self._gradients if self.judged else "none",
            x_scale=np.concatenate(sizes),
            thresholds=Thresholds(wrong=np.inf),
        )

    def estimate(self, step: float | None = None) -> Estimate:
        """First-order and high-order estimate of what the step, or one to its side, does."""
        return self.post.estimate(self.step if step is None else step, check_feasible=False)

    def groups(self, estimate: Estimate) -> tuple[Group, ...]:
        """Kinds of rows that carry an estimate, largest first."""
        n, after = self.count, len(self.floors) + self.capped
        found: list[Group] = []
        first, high = estimate.row_first_order, estimate.row_high_order
        sizes = np.abs(estimate.row_multipliers)

        def add(name: str, rows: list[slice]) -> None:
            share = np.sum([high[r] for r in rows], axis=0)
            one = share.size == n
            found.append(
                Group(
                    name=name,
                    first=float(sum(first[r].sum() for r in rows)),
                    high=float(share.sum()),
                    multiplier=float(sum(sizes[r].sum() for r in rows)),
                    share=share if one else None,
                )
            )

        if estimate.objective_first_order or estimate.objective_high_order:
            found.append(
                Group(
                    name="price of the RMS",
                    first=estimate.objective_first_order,
                    high=estimate.objective_high_order,
                    multiplier=self.point.task.weights.weighted(self.point.design.loads),
                    share=None,
                )
            )
        for i, (text, *_) in enumerate(self.floors):
            add(text, [slice(i, i + 1)])
        blocks = [slice(after + k * n, after + (k + 1) * n) for k in range(4)]
        add("pitch rate", blocks[:2])
        what = "stall limit" if self.name == "shear" else "end of pitch"
        add(f"lower {what}", [blocks[2]])
        add(f"upper {what}", [blocks[3]])
        begin = self.inequalities.size
        for k, load in enumerate(self.loads):
            rows = slice(begin + k * n, begin + (k + 1) * n)
            add(_LOADS[load], [rows])
        if np.any(self.y[0]):
            self._split_torque(found, estimate)
        return tuple(
            sorted(
                (g for g in found if max(abs(g.first), abs(g.high)) > 0.0),
                key=lambda g: -max(abs(g.first), abs(g.high)),
            )
        )

    def _split_torque(self, found: list[Group], estimate: Estimate) -> None:
        """Mean torque and its RMS have one row a station together."""
        begin = self.inequalities.size
        rows = slice(begin, begin + self.count)
        price = self.equalities[: self.count]
        mean = self.kkt.torque_price / self.curves.positions
        with np.errstate(divide="ignore", invalid="ignore"):
            part = np.where(price != 0.0, mean / price, 0.0)
        whole = next(g for g in found if g.name == _LOADS[0])
        first, high = estimate.row_first_order[rows], estimate.row_high_order[rows]
        found.remove(whole)
        for name, share, size in (
            ("mean torque", part, np.full(self.count, abs(mean))),
            ("RMS of torque", 1.0 - part, np.abs(self.y[0])),
        ):
            found.append(
                Group(
                    name=name,
                    first=float(share @ first),
                    high=float(share @ high),
                    multiplier=float(size.sum()),
                    share=share * high,
                )
            )

    # ---- the functions -----------------------------------------------------------------------

    def _is_flat(self, k: int) -> bool:
        """Whether the design holds a load flat, so that its RMS has no gradient."""
        limit = self.lambdas[k] / np.sqrt(self.curves.positions)
        return bool(np.linalg.norm(self.kkt.multipliers.loads[k]) < (1.0 - _ROUND) * limit)

    def _rms(self, k: int, load: FloatArray) -> float:
        rotor = load if k == 4 else load.reshape(-1, self.curves.positions).sum(axis=0)
        return float(rotor.std())

    def _gain(self, x: FloatArray) -> float:
        loads = x.reshape(-1, self.count)[1:]
        d = x[: self.count]
        value = self.point.objective.torque * float(loads[0].sum()) / self.curves.positions
        for i, k in enumerate(self.loads):
            if k not in self.flat and self.lambdas[k] > 0.0:
                value -= float(self.lambdas[k]) * self._rms(k, loads[i])
        return value - float(self.kkt.travel @ (np.roll(d, -1) - d))

    def _objective(self, x: FloatArray, c: float) -> float:
        return self.constant + self._gain(x) + self.states.at(c).extra

    def _inequalities(self, x: FloatArray, c: float) -> FloatArray:
        state, beta = self.states.at(c), self.profile + x[: self.count]
        mean = float(x[self.count : 2 * self.count].sum()) / self.curves.positions
        change = np.roll(beta, -1) - beta
        floors = [sign * (getattr(state, limit) - mean) for _, sign, limit, _ in self.floors]
        cap = []
        if self.capped:
            blade = x.reshape(-1, self.count)[1 + self.loads.index(4)]
            cap = [self._rms(4, blade) - self.cap]
        return np.concatenate(
            [
                floors,
                cap,
                change - state.step,
                -change - state.step,
                state.low - beta,
                beta - state.high,
            ]
        )

    def _line_values(self, x: FloatArray, c: float) -> FloatArray:
        lines, d = self.states.lines(c), x[: self.count]
        rate = self.curves.profile_rate(self.profile + d)
        model = lines.value + lines.slope * d + lines.rates * rate
        return np.asarray(x[self.count :] - model[self.loads].ravel())

    def _equalities(self, x: FloatArray, c: float) -> FloatArray:
        d, loads = x[: self.count], x.reshape(-1, self.count)[1:]
        ties = []
        for k in self.flat:
            rotor = loads[self.loads.index(k)].reshape(-1, self.curves.positions).sum(axis=0)
            ties.append(rotor - rotor.mean())
        if self.curves.mean_pitch is not None:
            ties.append(np.array([d.sum()]))
        if self._projector is not None:
            ties.append(self._projector @ d)
        return np.concatenate([self._line_values(x, c), *ties])

    @cached_property
    def _projector(self) -> FloatArray | None:
        """What takes harmonics out of a move, (N, N)."""
        basis = self.point.problem.basis
        if basis is None:
            return None
        q = np.linalg.qr(basis)[0]
        return np.asarray(np.eye(self.count) - q @ q.T)

    def _gradients(self, x: FloatArray, c: float) -> tuple[Any, Any, Any]:  # noqa: ARG002
        n, width = self.count, (1 + len(self.loads)) * self.count
        lines, eye = self.states.at(c).lines, np.eye(n)
        after = np.roll(eye, 1, axis=1)  # picks station n + 1
        f = np.zeros(width)
        f[:n] = self.kkt.travel - np.roll(self.kkt.travel, 1)
        f[n : 2 * n] = self.point.objective.torque / self.curves.positions
        own = self.kkt.multipliers.cap / (self.lambdas[4] + self.kkt.multipliers.cap or 1.0)
        for i, k in enumerate(self.loads):
            if k not in self.flat:
                f[(1 + i) * n : (2 + i) * n] -= self.y[k] * ((1.0 - own) if k == 4 else 1.0)
        g = np.zeros((self.inequalities.size, width))
        begin = len(self.floors) + self.capped
        for i, (_, sign, _, _) in enumerate(self.floors):
            g[i, n : 2 * n] = -sign / self.curves.positions
        if self.capped:
            i = 1 + self.loads.index(4)
            price = self.lambdas[4] + self.kkt.multipliers.cap
            g[begin - 1, i * n : (i + 1) * n] = self.y[4] / price
        moves = (after - eye, eye - after, -eye, eye)
        for k, move in enumerate(moves):
            g[begin + k * n : begin + (k + 1) * n, :n] = move
        h = np.zeros((self.equalities.size, width))
        central = (after - after.T) / (2 * self.curves.spacing)
        for i, k in enumerate(self.loads):
            rows = slice(i * n, (i + 1) * n)
            h[rows, :n] = -np.diag(lines.slope[k]) - lines.rates[k][:, None] * central
            h[rows, (1 + i) * n : (2 + i) * n] = eye
        at, m = len(self.loads) * n, self.curves.positions
        flatten = np.tile(np.eye(m), (1, self.curves.blades)) - 1.0 / m
        for k in self.flat:
            i = 1 + self.loads.index(k)
            h[at : at + m, i * n : (i + 1) * n] = flatten
            at += m
        if self.curves.mean_pitch is not None:
            h[at, :n] = 1.0
            at += 1
        if self._projector is not None:
            h[at:, :n] = self._projector
        return f, g, h

    def _slopes(self, x: FloatArray, c: float) -> tuple[Any, Any, Any]:
        """Derivatives in the parameter, on the side of the step; of lines from both sides."""
        small = _SMALL * self.step
        ahead = c + small
        near = self._rows(x, ahead) - self._rows(x, c)
        if self.name == "shear":  # of lines from both sides, they are smooth
            lines = self._line_values(x, ahead) - self._line_values(x, c - small)
            near[1 + self.inequalities.size :][: lines.size] = lines / 2
        near = near / small
        count = self.inequalities.size
        return near[:1], near[1 : 1 + count, None], near[1 + count :, None]

    def _rows(self, x: FloatArray, c: float) -> FloatArray:
        return np.concatenate(
            [[self._objective(x, c)], self._inequalities(x, c), self._equalities(x, c)]
        )

    # ---- names -------------------------------------------------------------------------------

    def _degrees(self) -> list[str]:
        return [f"{angle:.0f} deg" for angle in np.degrees(self.curves.azimuth)]

    @property
    def _names(self) -> list[str]:
        at = self._degrees()
        kinds = ("rate up after", "rate down after", "lower end at", "upper end at")
        single = [text for text, *_ in self.floors] + ["blade cap"] * self.capped
        return single + [f"{kind} {a}" for kind in kinds for a in at]

    @property
    def _equality_names(self) -> list[str]:
        at = self._degrees()
        texts = ("torque", "tilt", "yaw", "thrust", "bending")
        names = [f"{texts[k]} at {a}" for k in self.loads for a in at]
        positions = self.curves.positions
        names += [f"flat {texts[k]} at {a}" for k in self.flat for a in at[:positions]]
        if self.curves.mean_pitch is not None:
            names.append("mean pitch")
        if self._projector is not None:
            names += [f"harmonics at {a}" for a in at]
        return names
