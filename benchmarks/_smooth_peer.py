"""The peer of scp_vs_ipopt: the trade-off problem on smooth curves, for CasADi and IPOPT.

Each load of each station is a cubic B-spline (twice differentiable) on a uniform grid over the
station's pitch interval, through the values of the piecewise-linear curve there.

    maximise   T - mu sum_l w_l J_l,   J_l = sqrt(mean_k (L_l(k) - mean_l)^2 + eps^2)
    subject to pitch bounds per station, |beta_{n+1} - beta_n| <= D as linear rows.

Three formulations, all sparse and with CasADi's exact Hessian:

    direct    variables beta, mean_l; J_l inside the objective (its Hessian is dense)
    epigraph  J_l variables, J_l^2 >= mean_k (L_l(k) - mean_l)^2 + eps^2
    lifted    L_l(k) variables too, tied to beta by equalities (Hessian diagonal in beta)
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
from scipy.interpolate import make_interp_spline

__all__ = ["FORMULATIONS", "PeerRun", "SmoothPeer"]

FORMULATIONS = ("direct", "epigraph", "lifted")
_SPLINE_LOADS = ("torque", "bending", "thrust")  # the case has no moment about the blade's axis


@dataclass(frozen=True, kw_only=True)
class PeerRun:
    """One IPOPT run: profile [rad], its objective on the smooth curves [N m], and its cost."""

    profile: np.ndarray
    objective: float
    seconds: float
    iterations: int
    status: str


class SmoothPeer:
    """The problem of one case; mu is a parameter, so that it is built once for all prices."""

    def __init__(
        self,
        problem: Any,
        weights: np.ndarray,
        *,
        formulation: str,
        grid: int = 96,
        epsilon: float = 1.0,
        max_cpu_time: float = 120.0,
    ) -> None:
        began = time.perf_counter()
        curves = problem.curves
        if np.any(curves.radial) or np.any(curves.rates):
            raise ValueError("curves: got radial moments or pitch-rate terms, expected none")
        self.problem, self.formulation = problem, formulation
        n, m, blades = curves.stations, curves.positions, curves.blades
        self._loads = self._splines(grid)
        start = curves.evaluate(np.full(n, float(np.clip(0.0, *problem.constant_range))))
        self.torque_unit = abs(float(start.mean[0]))
        self.unit = np.maximum(start.rms, 1.0)

        beta, mu = ca.MX.sym("beta", n), ca.MX.sym("mu")
        outputs = [f(beta[i]) for i, f in enumerate(self._loads)]
        blade = ca.horzcat(*outputs)  # (3, N)
        c, s = ca.DM(np.cos(curves.azimuth)).T, ca.DM(np.sin(curves.azimuth)).T
        five = [blade[0, :], blade[1, :] * c, blade[1, :] * s, blade[2, :]]
        rotor = [sum(row[:, b * m : (b + 1) * m] for b in range(blades)).T for row in five]
        mean = ca.MX.sym("mean", 4)
        step = ca.vertcat(beta[1:], beta[:1]) - beta
        rows, low, high = [step], [-problem.step] * n, [problem.step] * n
        variables = [beta, mean]
        self._lower, self._upper = (
            [*curves.lower, *([-np.inf] * 4)],
            [*curves.upper, *([np.inf] * 4)],
        )
        # loads in their units; torque's mean enters the objective in torque's own unit
        scaled = [rotor[q] / self.unit[q] for q in range(4)]
        self.evaluate = ca.Function("loads", [beta], [ca.horzcat(*scaled)])
        if formulation == "lifted":
            free = [ca.MX.sym(f"load{q}", m) for q in range(4)]
            for q in range(4):
                rows.append(free[q] - scaled[q])
                low += [0.0] * m
                high += [0.0] * m
            variables += free
            self._lower += [-np.inf] * (4 * m)
            self._upper += [np.inf] * (4 * m)
            scaled = free
        square = [
            ca.sumsqr(scaled[q] - mean[q]) / m + (epsilon / self.unit[q]) ** 2 for q in range(4)
        ]
        price = [mu * float(weights[q] * self.unit[q]) / self.torque_unit for q in range(4)]
        if formulation == "direct":
            cost = sum(price[q] * ca.sqrt(square[q]) for q in range(4))
        else:
            rms = ca.MX.sym("rms", 4)
            for q in range(4):
                rows.append(square[q] - rms[q] ** 2)
                low.append(-np.inf)
                high.append(0.0)
            variables.append(rms)
            self._lower += [0.0] * 4
            self._upper += [np.inf] * 4
            cost = sum(price[q] * rms[q] for q in range(4))
        cost = cost - ca.sum1(scaled[0]) / m * float(self.unit[0] / self.torque_unit)
        self._row_low, self._row_high = low, high
        self._epsilon = epsilon
        self._solver = ca.nlpsol(
            "peer",
            "ipopt",
            {"x": ca.vertcat(*variables), "p": mu, "f": cost, "g": ca.vertcat(*rows)},
            {
                "print_time": False,
                "ipopt.print_level": 0,
                "ipopt.sb": "yes",
                "ipopt.tol": 1e-6,
                "ipopt.linear_solver": "mumps",
                "ipopt.max_cpu_time": max_cpu_time,
            },
        )
        self.build_seconds = time.perf_counter() - began

    def _splines(self, grid: int) -> list[Any]:
        curves = self.problem.curves
        functions = []
        for i in range(curves.stations):
            x = np.linspace(curves.lower[i], curves.upper[i], grid)
            values = np.stack(
                [np.interp(x, curves.beta[i], getattr(curves, q)[i]) for q in _SPLINE_LOADS]
            )
            spline = make_interp_spline(x, values.T, k=3)
            functions.append(
                ca.Function.bspline(
                    f"station{i}",
                    [list(spline.t)],
                    list(np.asarray(spline.c).ravel()),
                    [3],
                    len(_SPLINE_LOADS),
                )
            )
        return functions

    def solve(self, mu: float, start: np.ndarray) -> PeerRun:
        """One run from a profile (N,) [rad]."""
        began = time.perf_counter()
        loads = np.asarray(self.evaluate(start))  # (m, 4) in units
        mean, spread = loads.mean(axis=0), loads.std(axis=0)
        first = [start, mean]
        if self.formulation == "lifted":
            first.append(loads.T.ravel())
        if self.formulation != "direct":
            first.append(np.hypot(spread, self._epsilon / self.unit))
        out = self._solver(
            x0=np.concatenate(first),
            p=mu,
            lbx=self._lower,
            ubx=self._upper,
            lbg=self._row_low,
            ubg=self._row_high,
        )
        stats = self._solver.stats()
        return PeerRun(
            profile=np.asarray(out["x"]).ravel()[: self.problem.curves.stations],
            objective=-float(out["f"]) * self.torque_unit,
            seconds=time.perf_counter() - began,
            iterations=int(stats["iter_count"]),
            status=str(stats["return_status"]),
        )
