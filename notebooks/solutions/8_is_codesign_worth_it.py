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
# # Solutions to 8. Is co-design worth it?

# %%
import dataclasses

import cvxpy as cp
import numpy as np
from matplotlib import pyplot as plt

from pitchopt import load_turbine
from pitchopt.sensitivity import PostOptimum
from pitchopt.studies.sensitivity import active_set_program, estimated_curve, linearity_programs
from pitchopt.studies.tower import LoadSets, LoadSettings, TowerLimits, Towers, size_tower

# %% [markdown]
# ## Exercise 1
#
# $-5c^2 + 6c + 1 = 2$ has the roots $c = 0.2$ and $c = 1$: the limit that stays takes over at 0.2,
# and the moving one comes back just at the end.

# %%
dc = np.round(np.linspace(0, 1, 51), 12)
curve = estimated_curve(active_set_program(), dc)
roots = np.sort(np.roots([-5, 6, -1]))
assert np.allclose(roots, [0.2, 1.0])
at_limit = dc[np.abs(curve.designs[:, 0] - 2) < 1e-5]
print(f"x1 = 2 from c = {at_limit[0]:g} to {at_limit[-1]:g}; roots {roots}")
assert np.isclose(at_limit[0], 0.2)
assert np.isclose(at_limit[-1], 1.0)
print("the report says", curve.broken)

# %% [markdown]
# ## Exercise 2
#
# Without the limit $x_1 = 10/(2b) = 0.25$. The limit $-4c^2 + 3c + 1$ comes down to 0.25 at
# $c = (3 + \sqrt{9 + 12})/8$.

# %%
curve = estimated_curve(linearity_programs([20.0])[0], dc)
meets = (3 + np.sqrt(9 + 16 * 0.75)) / 8
name, first = curve.broken[0]
print(f"the limit meets the minimiser at c = {meets:.4f}; {name} said to be broken from {first:g}")
assert dc[np.searchsorted(dc, meets)] == first
assert np.all(curve.truth[dc < meets] < 1e-6) and curve.truth[-1] > 1

# %% [markdown]
# The first point of the grid beyond the meeting. The verdict comes from evaluating the limit at the
# old optimum, with no problem solved.
#
# ## Exercise 3
#
# Let $\min a^Tx$ with $Gx \ge r$, $x \ge 0$ have the multipliers $\lambda$ at $r_0$. These are
# feasible for the dual whatever $r$ is, since the dual's constraints do not contain it. By weak
# duality the optimum at any $r$ is at least $\lambda^Tr$, and at $r_0$ it is $\lambda^Tr_0$: the
# change is at least $\lambda^T(r - r_0)$, which is the high-order estimate. A change of the active
# set only makes the truth larger.

# %%
random = np.random.default_rng(3)
G, a = random.uniform(0, 1, (8, 5)), random.uniform(1, 2, 5)
r0, r1, r2 = random.uniform(1, 2, 8), random.normal(size=8), random.normal(size=8)
x, r = cp.Variable(5, name="x"), cp.Parameter(8, name="r", value=r0)
problem = cp.Problem(cp.Minimize(a @ x), [G @ x >= r, x >= 0])
start = problem.solve(solver=cp.CLARABEL)
optimum = PostOptimum.from_cvxpy(problem, r, names=["demand", "sign"])
steps = np.linspace(0, 1.5, 31)
change = [c * r1 + c**2 * r2 for c in steps]
estimate = np.array([optimum.estimate(one).high_order for one in change])
true = []
for one in change:
    r.value = r0 + one
    true.append(problem.solve(solver=cp.CLARABEL) - start)
true = np.array(true)
assert np.all(estimate <= true + 1e-6)
assert np.max(true - estimate) > 0.1
print(f"the truth is above the estimate by up to {np.max(true - estimate):.3f}, never below")

# %%
figure, ax = plt.subplots(figsize=(6.5, 3.8), layout="constrained")
ax.plot(steps, true, "k", label="solved again")
ax.plot(steps, estimate, "--", color="C0", label="high-order")
ax.set_xlabel("c [-]")
ax.set_ylabel("change of the optimum [-]")
ax.legend(frameon=False)
plt.show()

# %% [markdown]
# ## Exercise 4

# %%
turbine = load_turbine("iea-3.4-130")
HEIGHT = turbine.rotor.hub_height
SPEEDS = (5.0, 7.0, 9.0, 11.0, 13.0, 15.0, 17.0, 19.0, 21.0)
sets = LoadSets(turbine, LoadSettings(wind_speeds=SPEEDS, seeds=(1,), axes=4, box_points=7))
standard = Towers(sets, TowerLimits(), threshold=0.005).at(HEIGHT, 0.0)
costs = {}
for diameter in (6.0, 5.5, 5.0, 4.5):
    limits = TowerLimits(largest_diameter=diameter)
    sizing = size_tower(HEIGHT, standard.load_set.loads, limits, turbine, start=standard.design)
    assert sizing.converged
    prices = sizing.relative_multipliers()
    costs[diameter] = prices.frequency.sum()
    print(
        f"at most {diameter:.1f} m: {sizing.mass / 1e3:.1f} t, frequency {costs[diameter]:.2f}, "
        f"fatigue {prices.fatigue.sum():.2f}, slenderness {prices.slenderness.sum():.2f}, "
        f"diameter {prices.largest_diameter.sum():.2f}"
    )
assert costs[4.5] > costs[5.0] > costs[6.0]

# %% [markdown]
# A tower that grows in diameter has a price near 0.9 ($m \propto D^2$ and $f \propto D^2$ at
# constant $D/t$). From 6 to 5.5 m it hardly moves, since fatigue takes a share; then more and more
# of the frequency has to come from walls, and at 4.5 m the price comes near the two of walls alone.
# The price of a limit is a property of what else may move.
#
# ## Exercise 5

# %%
limits = TowerLimits(frequency_margin=None)
soft = Towers(sets, limits, threshold=0.005).at(HEIGHT, 0.0)
second = LoadSets(turbine, LoadSettings(wind_speeds=SPEEDS, seeds=(2,), axes=4, box_points=7))
points, slopes = {}, {}
for seed, some, factors in (
    (1, sets, (0.96, 0.98, 1.0, 1.02, 1.04)),
    (2, second, (0.96, 1.0, 1.04)),
):
    rows = []
    for factor in factors:
        design = dataclasses.replace(soft.design, thickness=factor * soft.design.thickness)
        found = some.run(design, 0.0)
        sized = size_tower(HEIGHT, found.loads, limits, turbine, start=soft.design)
        rows.append((design.mass / soft.mass, sized.mass / soft.mass))
    points[seed] = np.array(rows)
    slope, _ = np.polyfit(*points[seed].T, 1)
    slopes[seed] = slope
    apart = points[seed][:, 1] - np.polyval(np.polyfit(*points[seed].T, 1), points[seed][:, 0])
    print(
        f"seed {seed}: rho = {slope:+.2f}, sized masses off the line by up to {np.abs(apart).max():.2%}"
    )
assert all(abs(slope) < 1 for slope in slopes.values())  # else the rounds would not contract

# %%
figure, ax = plt.subplots(figsize=(6.5, 4.0), layout="constrained")
for seed, rows in points.items():
    ax.plot(100 * rows[:, 0] - 100, 100 * rows[:, 1] - 100, "o-", label=f"seed {seed}")
ax.set_xlabel("simulated mass from that of the tower [%]")
ax.set_ylabel("sized mass from that of the tower [%]")
ax.legend(frameon=False)
plt.show()

# %% [markdown]
# One seed says that a heavier tower asks for a little less mass, the other for a little more: with
# one seed $\rho$ is not known, not even its sign, and an estimate mended with it would be mended by
# chance. The rounds of the full study (72 simulations a set) gave 0.34, which turned 1.78 into 2.70
# % where 2.39 % is true (`docs/sensitivity.md`). Mending an estimate takes winds, like everything
# else about fatigue.
