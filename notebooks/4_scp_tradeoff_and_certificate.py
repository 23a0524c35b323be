# ---
# jupyter:
#   jupytext:
#     formats: build//ipynb,py:percent
#     text_representation:
#       extension: .py
#       format_name: percent
#   kernelspec:
#     display_name: Python 3
#     language: python
#     name: python3
# ---

# %% [markdown]
# # 4. SCP, the trade-off and its certificate
#
# Largest torque is a convex program. Little load variation is not: loads are curved in pitch, and the best profile for both
# is found by a sequence of convex programs that may end in a local optimum. How good is that optimum? This notebook writes
# the sequence by hand, draws the trade-off curve, and proves bounds for its points, first by a relaxation, then by branch and bound.
# At the end it shows how a designer can be fooled by a measure of load variation.

# %% [markdown]
# ## What you will learn
#
# - the load variation $J$ and why it makes the problem non-convex;
# - sequential convex programming with a trust region, in some forty lines;
# - the trade-off curve: what a price does, what a knee is, what must hold between its points;
# - the hull relaxation, its bound from multipliers, and why the gap grows with the price;
# - branch and bound: why smaller boxes close the gap, and a proof that anyone can check;
# - the loophole of $J$: loads that it does not see.

# %%
import cvxpy as cp
import matplotlib.pyplot as plt
import numpy as np
from ipywidgets import IntSlider, interact
from scipy.spatial import ConvexHull

from pitchopt import load_case, tradeoff
from pitchopt.design import (
    Objective,
    ProofSettings,
    check_proof,
    compared,
    constant,
    prove,
    relax,
    solve_local,
)
from pitchopt.plotting import plot_tradeoff

# %% [markdown]
# ## 1. The objective
#
# For each rotor load $X_k$ at the positions $k = 0..m-1$ of one blade passage, the variation is the root mean square about the mean,
#
# $$ J_X = \Bigl(\frac1m\sum_k (X_k - \bar X)^2\Bigr)^{1/2}, \qquad X \in \{\text{torque, tilt, yaw, thrust}\}, $$
#
# and the trade-off is $\max\ \Phi = T - \mu\sum_X \lambda_X J_X$. The case `biegel2011` has unit weights $\lambda$: a newton of thrust counts like a
# newton metre. We take 12 positions, hence 36 stations.

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


loads = curves.evaluate(start.profile).rotor
assert np.isclose(start.rms_sum, np.sqrt(((loads.T - loads.mean(axis=1)) ** 2).mean(axis=0)).sum())
assert np.isclose(phi(start.profile), problem.value(start.profile, objective))

figure, axes = plt.subplots(1, 4, figsize=(13, 2.8), layout="constrained")
names, units = ("torque", "tilt", "yaw", "thrust"), ("kN m", "kN m", "kN m", "kN")
for ax, name, unit, load in zip(axes, names, units, loads, strict=True):
    ax.plot(np.rad2deg(curves.azimuth[:m]), load / 1e3, ".-")
    ax.set_title(f"{name}, J = {load.std() / 1e3:.1f} {unit}", fontsize="medium")
    ax.set_xlabel("azimuth of blade 1 [deg]")
    ax.set_ylabel(f"[{unit}]")
plt.show()

# %% [markdown]
# ## 2. Why it is not convex
#
# $J$ is a norm, convex in the loads. If loads were affine in pitch, $\Phi$ would be concave. They are bent, so that two flat profiles do not mix to a
# flat one. The picture walks on the straight line between two local optima.

# %%
one = solve_local(problem, objective, start.profile)
two = solve_local(problem, objective, start.profile + 0.03)
line = np.linspace(-0.3, 1.3, 161)
along = []
for s in line:
    mixed = (1 - s) * one.profile + s * two.profile
    along.append(curves.evaluate(problem.repaired(mixed)))
value = np.array([found.mean[0] - mu * found.rms.sum() for found in along])
middle = phi(0.5 * (one.profile + two.profile))
print(f"{one.value / 1e3:.2f} and {two.value / 1e3:.2f}, halfway {middle / 1e3:.2f} kN m")
assert middle < min(one.value, two.value)  # a concave function would be above the lower end

figure, (left, right) = plt.subplots(1, 2, figsize=(10, 3.4), layout="constrained")
left.plot(line, value / 1e3)
left.plot([0, 1], [one.value / 1e3, two.value / 1e3], "ko")
left.set_xlabel("share of the second optimum [-]")
left.set_ylabel("objective [kN m]")
for k, name in enumerate(names):
    right.plot(line, [found.rms[k] / 1e3 for found in along], label=name)
right.set_xlabel("share of the second optimum [-]")
right.set_ylabel("J [kN m], thrust [kN]")
right.legend(fontsize="small")
plt.show()

# %% [markdown]
# ## 3. Sequential convex programming by hand
#
# At a profile $\beta^{(i)}$ replace each load by its tangent, the segment on which $\beta^{(i)}_n$ stands. Then $J$ is the norm of an affine function, a
# second-order cone; torque in the objective stays the concave function that it is; and $|\beta_n - \beta_n^{(i)}|\le\Delta$ keeps the step
# where the tangents are good. Solve, look at the **true** $\Phi$, and compare what was gained with what was promised:
#
# - more than 10 %: take the step; more than 75 %: double $\Delta$ as well;
# - less: stay, and shrink $\Delta$.
#
# Everything that changes is a `Parameter`, so that CVXPY compiles the program once. The unknown is the step over $\Delta$, angles are in
# degrees and loads in 10 kN m, as solvers like numbers near one.

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


path, log = scp(start.profile)
print(" step  delta [deg]  promised  gained [N m]")
for i, (delta, hoped, gained, taken) in enumerate(log):
    print(f"{i:5d}  {delta:11.3f}  {hoped:8.0f}  {gained:8.0f}  {'taken' if taken else ''}")
values = [phi(profile) for profile in path]
assert np.all(np.diff(values) > 0)  # the true objective never falls
print(f"own sequence ends at {values[-1] / 1e3:.3f}, the library at {one.value / 1e3:.3f} kN m")
assert one.value >= values[-1] > values[0] + 0.99 * (one.value - values[0])

# %%
figure, (left, right) = plt.subplots(1, 2, figsize=(11, 3.6), layout="constrained")
psi = np.rad2deg(curves.azimuth)
for i, profile in enumerate(path):
    left.plot(psi, np.rad2deg(profile), color=plt.cm.viridis(i / (len(path) - 1)))
left.plot(psi, np.rad2deg(one.profile), "k:", label="library")
left.set_xlabel("azimuth [deg]")
left.set_ylabel("pitch [deg]")
left.set_title("from the first (dark) to the last (bright)", fontsize="medium")
left.legend(fontsize="small")
right.semilogy(np.maximum(one.value - np.array(values), 1.0), "o-")
right.set_xlabel("accepted steps")
right.set_ylabel("below the library's optimum [N m]")
plt.show()

# %% [markdown]
# The last tenth of a per cent is where the simple method gets stuck: the loads are piecewise linear, at a kink no single tangent
# describes both sides, and the trust region shrinks without need. The library ends otherwise: it
# confines each station to its segment, where everything is exact, solves that, and walks to a neighbouring segment when the multipliers say so.
#
# ## 4. The trade-off curve
#
# One $\mu$ gives one point. `tradeoff` draws the curve: several starts at some prices, then neighbours as starts of each other. With
# $T_i$, $J_i$ the torque and the weighted RMS at price $\mu_i$,
#
# $$ T_i - \mu_i J_i \ \ge\ T_j - \mu_i J_j \quad\text{for all } i, j $$
#
# must hold: each point is the best of all known profiles at its own price. It follows that the curve is monotone.

# %%
prices = np.geomspace(0.3, 150.0, 9)
result = tradeoff(task, mu=prices, losses=(), starts=3, anchors=3)
T = np.array([p.mean_torque for p in result.points])
J = np.array([p.rms_weighted for p in result.points])
own = np.array([p.mu for p in result.points])
for i in range(T.size):
    assert np.all(T[i] - own[i] * J[i] >= T - own[i] * J - 1e-6 * T[0])

print("    mu   torque lost   RMS cut   gap of the bound")
for i, p in enumerate(result.points):
    mark = "  <- knee" if i == result.knee else ""
    print(f"{p.mu:6.1f}  {result.loss(p):10.2%}  {result.cut(p):9.1%}  {p.gap:10.2%}{mark}")

figure, ax = plt.subplots(figsize=(7, 4.4), layout="constrained")
plot_tradeoff(result, weights_name="unit", ax=ax)
plt.show()

# %% [markdown]
# The knee is the point farthest from the chord between the ends of the curve, both axes scaled to one. It is a way of speaking, not a property of the
# turbine: end the curve elsewhere and the knee moves.


# %%
def draw_point(index=result.knee):
    found = result.points[index]
    _, (left, middle, right) = plt.subplots(1, 3, figsize=(13, 3.4), layout="constrained")
    left.plot(J / 1e3, T / 1e3, ".-", color="0.6")
    left.plot(J[index] / 1e3, T[index] / 1e3, "C1o")
    left.set_xlabel("weighted RMS [kN m]")
    left.set_ylabel("mean torque [kN m]")
    middle.plot(psi, np.rad2deg(found.profile), "C1", label=f"mu = {found.mu:.1f}")
    middle.plot(psi, np.rad2deg(start.profile), color="0.6", label="constant")
    middle.set_xlabel("azimuth [deg]")
    middle.set_ylabel("pitch [deg]")
    middle.legend(fontsize="small")
    for k, name in enumerate(names):
        load = found.loads.rotor[k]
        right.plot(psi[:m], (load - load.mean()) / 1e3, label=name)
        before = loads[k]
        right.plot(psi[:m], (before - before.mean()) / 1e3, ":", color=f"C{k}")
    right.set_xlabel("azimuth of blade 1 [deg]")
    right.set_ylabel("deviation [kN m], thrust [kN]")
    right.set_title("dotted: constant pitch", fontsize="medium")
    right.legend(fontsize="small")
    plt.show()


draw_point()

# %%
_ = interact(
    draw_point,
    index=IntSlider(min=0, max=len(result.points) - 1, value=result.knee, continuous_update=False),
)

# %% [markdown]
# ## 5. A bound: the hull relaxation
#
# At one station, pitch moves the loads along a curve in the space of torque, bending and thrust. Replace this curve by its **convex hull**:
# let the blade be at a mixture of several pitches at once. Every profile is such a mixture, so the relaxed optimum is at least as good as any
# profile, and it is a convex program.

# %%
n = 0
corners = np.column_stack([curves.torque[n], curves.bending[n]]) / 1e3
hull = ConvexHull(corners)
figure, ax = plt.subplots(figsize=(5.6, 3.8), layout="constrained")
ax.fill(*corners[hull.vertices].T, alpha=0.2, label="convex hull")
ax.plot(*corners.T, ".-", markersize=3, label="one blade, pitch along the curve")
ax.set_xlabel("torque [kN m]")
ax.set_ylabel("bending moment [kN m]")
ax.set_title("azimuth 0°", fontsize="medium")
ax.legend(fontsize="small")
plt.show()

# %% [markdown]
# Its dual needs no solver to be believed. Write $\mu\lambda J_X$ as the largest $\sum_k y_k X_k$ over all $y$ of zero sum with $\|y\|\le\mu\lambda/\sqrt m$; take
# any such $y$, and any multipliers $w_n$ of the rate limit as in notebook 3. Then
#
# $$ \Phi(\beta) \le D\sum_n|w_n| + \sum_n\max_{\beta_n}\Bigl[\tfrac1m t_n - \sum_X y_{X,k(n)} f_{X,n} + (w_n-w_{n-1})\beta_n\Bigr]. $$
#
# `relax` finds good multipliers; we compute the bound from them by hand.

# %%
relaxed = relax(problem, objective, profile=one.profile)
y, w = relaxed.multipliers.loads, relaxed.multipliers.rate


def bound(curves, y, w):
    bracket = curves.torque / m + (w - np.roll(w, 1))[:, None] * curves.beta
    bracket -= np.einsum("ln,lnk->nk", np.tile(y, curves.blades), curves.loads[:4])
    return problem.step * np.abs(w).sum() + bracket.max(axis=1).sum()


assert np.abs(y.sum(axis=1)).max() < 1e-9
assert np.all(np.linalg.norm(y, axis=1) <= mu / np.sqrt(m) * (1 + 1e-9))
assert np.isclose(bound(curves, y, w), relaxed.upper_bound, rtol=1e-9)
largest = result.power_max.mean_torque
print(f"bound {relaxed.upper_bound / 1e3:.2f}, best known {one.value / 1e3:.2f} kN m, ", end="")
print(f"gap {(relaxed.upper_bound - one.value) / largest:.2%} of the largest torque")
assert relaxed.upper_bound >= max(one.value, two.value)

figure, ax = plt.subplots(figsize=(6.5, 3.6), layout="constrained")
ax.semilogx(own, [p.upper_bound / 1e3 for p in result.points], "o-", label="bound")
ax.semilogx(own, [p.objective / 1e3 for p in result.points], "s-", label="best profile found")
ax.set_xlabel("price mu [-]")
ax.set_ylabel("objective [kN m]")
ax.legend()
plt.show()

# %% [markdown]
# At low prices the two agree: the optimum is proven. At high prices the bound stops falling. A mixture of pitches can hold all four loads flat at once and
# loses little torque for it; a single pitch per blade cannot. No better multipliers help: the relaxation itself is loose.
#
# ## 6. Branch and bound
#
# The hull is large because pitch may be anywhere in its range. Confine each station to $\pm\Delta$ about the best profile, and the hull of a short piece of
# curve is thin. We write the relaxation as a program over the weights of the breakpoints and let $\Delta$ shrink.


# %%
LARGE = 1e5  # [N m]


def hull_bound(delta_deg):
    """Relaxed optimum for profiles within delta of the best one, less its objective [N m]."""
    ref = one.profile
    piece = curves.with_limits(ref - np.deg2rad(delta_deg), ref + np.deg2rad(delta_deg))
    base = curves.contributions(ref)[:4]
    share = cp.Variable(piece.beta.shape, nonneg=True)
    move = cp.sum(cp.multiply(share, np.rad2deg(piece.beta - ref[:, None])), axis=1)
    change = cp.hstack([move[1:], move[:1]]) - move + np.rad2deg(np.roll(ref, -1) - ref)
    load = []
    for k in range(4):
        extra = cp.multiply(share, (piece.loads[k] - base[k][:, None]) / LARGE)
        load.append(blades @ (cp.sum(extra, axis=1) + base[k] / LARGE))
    rms = sum(cp.norm(X - cp.sum(X) / m) for X in load) / np.sqrt(m)
    program = cp.Problem(
        cp.Maximize(cp.sum(load[0]) / m - mu * rms),
        [cp.sum(share, axis=1) == 1, cp.abs(change) <= np.rad2deg(problem.step)],
    )
    return program.solve(solver=cp.CLARABEL, **ACCURACY) * LARGE - one.value


whole = hull_bound(30.0)
assert abs(whole - (relaxed.upper_bound - one.value)) < 1e-4 * largest  # own program, library's
widths = np.array([1.0, 0.5, 0.25, 0.125])
left_open = np.array([hull_bound(d) for d in widths])
assert np.all(left_open > 0)
assert np.all(left_open[:-1] / left_open[1:] > 3)  # near four for half the width

figure, ax = plt.subplots(figsize=(6, 3.6), layout="constrained")
ax.loglog(widths, left_open, "o-", label="confined to a width about the best profile")
ax.loglog(widths, left_open[0] * widths**2, ":", color="0.5", label="power 2")
ax.axhline(whole, color="C1", linestyle="--", label="whole range of pitch")
ax.set_xlabel("half width of the pitch intervals [deg]")
ax.set_ylabel("bound less objective [N m]")
ax.set_xticks(widths, labels=[f"{d:g}" for d in widths])
ax.minorticks_off()
ax.legend()
plt.show()

# %% [markdown]
# The gap falls with the square of the width. Branch and bound makes use of it everywhere, not only near the profile that we believe in: split the space of designs into
# regions, bound each, throw away those whose bound is below the best profile known, split the others again. The library
# tries the mean of each load and a few pitch intervals, and takes the split whose two parts leave the least. With the means of torque, tilt and yaw confined, three blades
# have few pitches left at each position.

# %%
proven = prove(
    problem,
    objective,
    one.profile,
    scale=largest,
    multipliers=relaxed.multipliers,
    settings=ProofSettings(gap=5e-3, seconds=60.0),
)
print(f"{proven.ended}: gap {proven.gap:.2%} after {proven.regions} regions")
assert proven.value >= one.value
assert proven.upper_bound <= relaxed.upper_bound

figure, ax = plt.subplots(figsize=(6, 3.4), layout="constrained")
ax.step([h[1] for h in proven.history], [100 * h[2] for h in proven.history], where="post")
ax.set_xlabel("regions")
ax.set_ylabel("gap [% of the largest torque]")
ax.set_ylim(0, None)
plt.show()

# %% [markdown]
# The gap shown is that of the worst region that is still open, so it falls late: most of the work is done when it begins to move.
#
# The tree is a proof: its splits, and for each region the multipliers that bound it. `check_proof` carries the steps out again on the curves and calls no
# solver. This is what `certificates.npz` of the command line holds.

# %%
checked = check_proof(proven.proof, problem, objective)
print(f"checked bound {checked / 1e3:.3f} kN m, of the search {proven.upper_bound / 1e3:.3f} kN m")
assert np.isclose(checked, proven.upper_bound, rtol=1e-9)

# %% [markdown]
# ## 7. What J does not see
#
# Pitch that moves once a turn, $a\cos\psi$, changes each blade's bending at 1P. The sum over three blades turns that into a **constant** tilting moment
# (notebook 1), and $J$ is about deviations from the mean. In uniform wind a constant pitch has no load variation at all; watch what 1P
# pitch does there.

# %%
calm = case.with_values(
    {"wind.shear": "none", "wind.tower_shadow": False, "wind.horizontal_shear": 0.0}
)
calm_task = calm.task()
calm_curves = calm_task.problem().curves
steady = constant(calm_task).profile
amplitude = np.array([0.25, 0.5, 1.0, 2.0])
found = [
    calm_curves.evaluate(steady + np.deg2rad(a) * np.cos(calm_curves.azimuth)) for a in amplitude
]
hub = np.array([f.rms.sum() for f in found])
blade = np.array([f.blade_rms for f in found])
tilt = np.array([f.mean[1] for f in found])
figure, ax = plt.subplots(figsize=(6, 3.6), layout="constrained")
ax.loglog(amplitude, blade / 1e3, "o-", label="RMS of one blade's bending")
ax.loglog(amplitude, np.abs(tilt) / 1e3, "s-", label="constant tilt")
ax.loglog(amplitude, hub / 1e3, "d-", label="sum of the four J")
ax.set_xticks(amplitude, labels=[f"{a:g}" for a in amplitude])
ax.minorticks_off()
ax.set_xlabel("amplitude of 1P pitch [deg]")
ax.set_ylabel("[kN m]")
ax.legend()
plt.show()
order = [np.polyfit(np.log(amplitude), np.log(np.abs(v)), 1)[0] for v in (blade, tilt, hub)]
print("grows with the amplitude to the power", [f"{o:.1f}" for o in order])
assert abs(order[0] - 1) < 0.1
assert abs(order[1] - 1) < 0.1
assert order[2] > 1.5  # to first order J sees nothing

# %% [markdown]
# An optimiser finds this and uses it. The NREL 5 MW at 15 m/s and rated torque, unit weights, with and without a cap on the RMS of one blade's bending at its
# value under constant pitch:

# %%
real = load_case("nrel-5mw").with_values(
    {"wind.speed": 15.0, "limits.positions": 12, "objective.weights": "unit"}
)
rated = real.turbine_data.rated_torque
print("                sum of J   blade RMS   constant tilt   pitch travel   status")
for name, cap in (("no cap", None), ("blade cap", 1.0)):
    both = compared(
        real.with_values({"objective.blade_cap": cap}).task(),
        mean_torque=rated,
        starts=2,
        certify=False,
    )
    if cap is None:
        loads = both.constant.loads
        print(
            f"constant     {loads.rms.sum() / 1e3:8.1f} kN m {loads.blade_rms / 1e3:6.0f} kN m "
            f"{loads.mean[1] / 1e6:8.2f} MN m {0:10.1f} deg"
        )
    loads, travel = both.design.loads, np.rad2deg(both.design.pitch_travel)
    print(
        f"{name:<12} {loads.rms.sum() / 1e3:8.1f} kN m {loads.blade_rms / 1e3:6.0f} kN m "
        f"{loads.mean[1] / 1e6:8.2f} MN m {travel:10.1f} deg   {both.design.status}"
    )
    if cap is None:
        assert loads.blade_rms > 2 * both.constant.loads.blade_rms
    else:
        assert loads.blade_rms <= both.constant.loads.blade_rms * (1 + 1e-6)

# %% [markdown]
# Without the cap the hub's loads are flat, and each blade pays for it with more than twice its own variation. With the cap hardly anything is lost at the hub. What an
# objective does not contain is free, and an optimiser will spend it: look at everything that you care about, not only at what you minimised.

# %% [markdown]
# ## Exercises
#
# **Exercise 1 (quick).** For neighbouring points $i$, $i+1$ of the curve compute $(T_i - T_{i+1})/(J_i - J_{i+1})$, what a unit of RMS really cost between them, and
# show that it lies between $\mu_i$ and $\mu_{i+1}$. Which law of section 4 says so?
#
# **Exercise 2 (quick).** The same turbine with thrust counted at hub height (`"objective.weights": "tower-base"`), at $\mu = 10$: which of the four $J$ fall, which rise,
# against unit weights?
#
# **Exercise 3 (medium).** Run `scp` from constant pitches between -1° and 5°. How many different optima do you find, and how far apart are they?
# What would you do with this in a program that others rely on?
#
# **Exercise 4 (medium).** In the uniform wind of section 7 the four $J$ are not zero, they grow nearly with the square of the amplitude. Take tilt. Find the harmonic of one blade's
# load that they come from, and show that it is the curvature of the loads over pitch: with straight loads it would vanish.
#
# **Exercise 5 (hard).** Find the multipliers of section 5 without a solver: start at $y = 0$, leave $w = 0$ (the rate hardly binds here), and go downhill on the bound by subgradients, with $y$ brought back
# to zero sum and to its ball after each step. How close to `relax` do 2000 steps come? Why is every step's result worth something?
