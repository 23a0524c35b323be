# ---
# jupyter:
#   jupytext:
#     formats: build/solutions//ipynb,solutions//py:percent
#     text_representation:
#       extension: .py
#       format_name: percent
#   kernelspec:
#     display_name: Python 3
#     language: python
#     name: python3
# ---

# %% [markdown]
# # Solutions to 4. SCP, the trade-off and its certificate

# %%
from dataclasses import replace

import cvxpy as cp
import matplotlib.pyplot as plt
import numpy as np

from pitchopt import load_case, tradeoff
from pitchopt.design import Objective, compared, constant, relax, solve_local

# %%
case = load_case("biegel2011").with_values({"limits.positions": 12})
task = case.task()
problem = task.problem()
curves = problem.curves
N, m = curves.stations, curves.positions
mu = 10.0
objective = Objective.tradeoff(mu, task.weights)
start = constant(task)


def phi(profile):
    loads = curves.evaluate(profile)
    return loads.mean[0] - mu * loads.rms.sum()


# %% [markdown]
# ## Exercise 1

# %%
prices = np.geomspace(0.3, 150.0, 9)
result = tradeoff(task, mu=prices, losses=(), starts=3, anchors=3)
print("   mu   cost of a unit of RMS   next mu")
for here, there in zip(result.points[:-1], result.points[1:], strict=True):
    saved = here.rms_weighted - there.rms_weighted
    if saved < 1e-3:
        continue  # the same profile at both prices
    cost = (here.mean_torque - there.mean_torque) / saved
    print(f"{here.mu:6.1f}  {cost:18.2f}  {there.mu:8.1f}")
    assert here.mu * (1 - 1e-6) <= cost <= there.mu * (1 + 1e-6)

# %% [markdown]
# It is the inequality of section 4, written for $(i, i+1)$ and for $(i+1, i)$: $T_i - \mu_iJ_i \ge T_{i+1} - \mu_iJ_{i+1}$ gives
# $T_i - T_{i+1} \ge \mu_i (J_i - J_{i+1})$, the other one $\le \mu_{i+1}(J_i - J_{i+1})$. A price is the exchange rate at the margin.
#
# ## Exercise 2

# %%
found = {}
for name in ("unit", "tower-base"):
    weighted = case.with_values({"objective.weights": name})
    found[name] = compared(weighted.task(), mu=mu, starts=3, certify=False)
print("J in N m and N       torque     tilt      yaw   thrust   mean torque")
for name, both in {"constant": None, **found}.items():
    design = start if both is None else both.design
    values = "".join(f"{value:9.1f}" for value in design.rms.values())
    print(f"{name:<16} {values}   {design.mean_torque / 1e3:9.1f} kN m")
unit, tower = found["unit"].design.rms, found["tower-base"].design.rms
assert tower["thrust"] < unit["thrust"]
assert tower["torque"] > unit["torque"]

# %% [markdown]
# With unit weights thrust is nearly free and absorbs what is left; torque, tilt and yaw are flat. Counted at hub height, a newton of thrust costs 80
# times as much: now thrust is flat and torque carries the rest. Three pitch angles at each position can flatten three loads, not four, and the weights
# choose which.
#
# ## Exercise 3
#
# The sequence of the notebook, and a finish by `solve_local` from where it ended.

# %%
UNIT = 1e4
ACCURACY = {"tol_gap_rel": 1e-7, "tol_gap_abs": 1e-5, "tol_feas": 1e-7}  # steps need no more
x, t = cp.Variable((N, 1)), cp.Variable((N, 1))
point, radius = cp.Parameter((N, 1)), cp.Parameter(nonneg=True)
slope, here = cp.Parameter((4, N)), cp.Parameter((4, m))
pitch = point + radius * x
turn = cp.vstack([pitch[1:], pitch[:1]]) - pitch
blades = np.kron(np.ones((1, curves.blades)), np.eye(m))  # sums the stations of each position
rms = 0
for k in range(4):
    load = here[k] + blades @ cp.multiply(slope[k], x[:, 0])
    rms += cp.norm(load - cp.sum(load) / m) / np.sqrt(m)
knots, torque = np.rad2deg(curves.beta), curves.torque / UNIT
segments = np.diff(torque) / np.diff(knots)
convex = cp.Problem(
    cp.Maximize(cp.sum(t) / m - mu * rms),
    [
        t <= torque[:, :-1] + cp.multiply(segments, pitch - knots[:, :-1]),
        pitch >= knots[:, :1],
        pitch <= knots[:, -1:],
        cp.abs(turn) <= np.rad2deg(problem.step),
        cp.abs(x) <= 1,
    ],
)
assert convex.is_dcp(dpp=True)


def subproblem(profile, delta):
    """Candidate and promised objective within delta degrees of a profile."""
    point.value, radius.value = np.rad2deg(profile)[:, None], delta
    tangent = curves.slopes[:4, np.arange(N), curves.segment(profile)]
    slope.value = tangent * np.deg2rad(delta) / UNIT
    here.value = curves.evaluate(profile).rotor / UNIT
    promised = convex.solve(solver=cp.CLARABEL, **ACCURACY) * UNIT
    return problem.repaired(np.deg2rad(pitch.value.ravel())), promised


def scp(profile, delta=3.0, least=0.02):
    """Accepted profiles and a log of all steps."""
    value, path, log = phi(profile), [profile], []
    while delta > least:
        candidate, promised = subproblem(profile, delta)
        gained, hoped = phi(candidate) - value, promised - value
        share = gained / hoped if hoped > 1e-7 * abs(value) else 0.0
        log.append((delta, hoped, gained, share > 0.1))
        if share > 0.1:
            profile, value = candidate, value + gained
            path.append(profile)
            delta *= 2 if share > 0.75 else 1
        else:
            delta /= 2.5
    return path, log


first = np.deg2rad(np.linspace(-1, 5, 7))
ends, finished = [], []
for pitch_0 in first:
    low, high = problem.constant_range
    path, _ = scp(np.full(N, np.clip(pitch_0, low, high)))
    ends.append(phi(path[-1]))
    finished.append(solve_local(problem, objective, path[-1]).value)
    print(
        f"from {np.rad2deg(pitch_0):4.1f} deg: {ends[-1] / 1e3:9.3f} kN m, "
        f"finished {finished[-1] / 1e3:9.3f} kN m"
    )
different = np.unique(np.round(finished, -1))
print(f"{different.size} optima, {np.ptp(finished):.0f} N m apart")
assert np.all(np.array(finished) >= np.array(ends) - 1e-6 * abs(ends[0]))

# %% [markdown]
# The ends of the simple sequence depend on the start; finished, they fall into few, and what differs are local optima, here within a thousandth of the objective. A program that
# others rely on starts from several profiles, keeps the best, and says by a bound how much better an unknown one could be.
#
# ## Exercise 4
#
# Let bending be $M_0 + M_1\delta + \tfrac12 M_2\delta^2$ with $\delta = a\cos\psi$. Since $\cos^2\psi = (1+\cos2\psi)/2$, curvature makes 2P of
# amplitude $\tfrac14 M_2a^2$. Tilt weighs it with $\cos\psi$: $\cos2\psi\cos\psi = (\cos\psi + \cos3\psi)/2$. Over three blades the first part vanishes and the second adds up, which gives
# 3P of $\tfrac32$ times the amplitude of 2P, hence $J_\text{tilt} = \tfrac{3}{2\sqrt2}\,|2P|$ (4P of the blade contributes likewise).

# %%
calm = case.with_values(
    {"wind.shear": "none", "wind.tower_shadow": False, "wind.horizontal_shear": 0.0}
).task()
calm_curves = calm.problem().curves
steady = constant(calm).profile
a = np.deg2rad(2.0)
loads = calm_curves.evaluate(steady + a * np.cos(calm_curves.azimuth))
spectrum = np.fft.rfft(loads.bending) * 2 / N
predicted = 1.5 / np.sqrt(2) * abs(spectrum[2] + spectrum[4])
print(f"blade: 1P {abs(spectrum[1]):.0f}, 2P {abs(spectrum[2]):.0f}, 4P {abs(spectrum[4]):.0f} N m")
print(f"J of tilt {loads.rms[1]:.1f} N m, from 2P and 4P of the blade {predicted:.1f} N m")
assert np.isclose(loads.rms[1], predicted, rtol=0.02)

# curvature from the curve itself, over the range that the pitch uses
n = 0
x = steady[n] + a * np.linspace(-1, 1, 41)
M = np.polynomial.Polynomial.fit(
    x - steady[n], np.interp(x, calm_curves.beta[n], calm_curves.bending[n]), 2
).convert()
print(f"2P from the curvature of the curve: {abs(2 * M.coef[2]) * a**2 / 4:.0f} N m")

# with a straight line in place of the curve nothing is left
ends_ = calm_curves.bending[:, [0, -1]]
share = (calm_curves.beta - calm_curves.beta[:, :1]) / np.ptp(calm_curves.beta, axis=1)[:, None]
straight = replace(calm_curves, bending=ends_[:, :1] + share * (ends_[:, 1:] - ends_[:, :1]))
left = straight.evaluate(steady + a * np.cos(calm_curves.azimuth)).rms[1]
print(f"J of tilt with straight bending: {left:.1e} N m")
assert left < 1e-6 * loads.rms[1]

# %% [markdown]
# ## Exercise 5
#
# The bound is a maximum of affine functions of $y$. With $j^*_n$ the breakpoints that attain the maxima, a subgradient is
# $-\sum_{n: k(n)=k} f_{X,n}(j^*_n)$ for $y_{X,k}$: the loads at these pitches with a minus. The four loads are of different size, so each row has a step of its own, which shrinks with the
# gradients that it has seen.

# %%
rows = np.arange(N)


def bound_and_slope(y):
    bracket = curves.torque / m - np.einsum(
        "ln,lnk->nk", np.tile(y, curves.blades), curves.loads[:4]
    )
    j = bracket.argmax(axis=1)
    at = curves.loads[:4, rows, j].reshape(4, curves.blades, m).sum(axis=1)
    return bracket.max(axis=1).sum(), -(at - at.mean(axis=1, keepdims=True))


def projected(y):
    y = y - y.mean(axis=1, keepdims=True)
    norm = np.linalg.norm(y, axis=1, keepdims=True)
    return y * np.minimum(1.0, mu / np.sqrt(m) / np.maximum(norm, 1e-300))


one = solve_local(problem, objective, start.profile)
target = relax(problem, objective, profile=one.profile).upper_bound
y, seen, best = np.zeros((4, m)), np.full((4, 1), 1e-9), []
for _ in range(2000):
    value, slope_y = bound_and_slope(y)
    best.append(min(value, best[-1]) if best else value)
    seen += (slope_y**2).mean(axis=1, keepdims=True)
    y = projected(y - 0.03 * slope_y / np.sqrt(seen))
    assert value >= one.value
print(
    f"first {best[0] / 1e3:.2f}, after 2000 steps {best[-1] / 1e3:.2f}, relax {target / 1e3:.2f} kN m"
)
reached = (best[0] - best[-1]) / (best[0] - target)
print(f"{reached:.0%} of the way")
assert reached > 0.6

figure, ax = plt.subplots(figsize=(6, 3.4), layout="constrained")
ax.semilogx(np.arange(1, len(best) + 1), np.array(best) / 1e3)
ax.axhline(target / 1e3, color="C1", linestyle="--", label="relax")
ax.axhline(one.value / 1e3, color="C2", linestyle=":", label="best profile known")
ax.set_xlabel("steps")
ax.set_ylabel("least bound so far [kN m]")
ax.legend()
plt.show()

# %% [markdown]
# Slow at the end, as subgradients are, which is why the library solves a cone program for the multipliers and then throws the solver's
# value away. But every single step gave a valid bound on all profiles, and the best of them can be stored and checked. Multipliers may come from anywhere.
