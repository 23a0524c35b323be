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
# # Solutions to 3. Power as a convex program, duals explained

# %%
import cvxpy as cp
import matplotlib.pyplot as plt
import numpy as np

from pitchopt import load_case

# %%
case = load_case("biegel2011").with_values({"limits.pitch_rate": np.deg2rad(1.0)})
curves = case.task().problem().curves
N, m, omega = curves.stations, curves.positions, case.rotor_speed
psi = np.rad2deg(curves.azimuth)
step = case.pitch_limits.step(N)  # D at 1 deg/s
per_degree = 2 * np.pi / (N * omega) * np.deg2rad(1.0)  # D for 1 deg/s

beta, t = cp.Variable((N, 1)), cp.Variable((N, 1))
up, down = cp.Parameter(nonneg=True, value=step), cp.Parameter(nonneg=True, value=step)
U = cp.Parameter(value=np.deg2rad(1.2))
change = cp.vstack([beta[1:], beta[:1]]) - beta
below = t <= curves.torque[:, :-1] + cp.multiply(curves.slopes[0], beta - curves.beta[:, :-1])
box = [beta >= curves.lower[:, None], beta <= curves.upper[:, None]]
top = beta <= U
rising, falling = change <= up, -change <= down
program = cp.Problem(cp.Maximize(cp.sum(t) / m), [below, *box, top, rising, falling])


def solve():
    return program.solve(solver=cp.CLARABEL)


largest = solve()

# %% [markdown]
# ## Exercise 1

# %%
price = float((rising.dual_value + falling.dual_value).sum())
power = omega * price * 0.1 * per_degree
energy = power * 8760 / 1e6
print(f"0.1 deg/s more: at most {power / 1e3:.2f} kW, {energy:.1f} MWh a year")

# %% [markdown]
# A few megawatt hours of some 25 GWh in a year of this wind. No pitch drive pays for itself that way; what individual pitch is good for is loads.
#
# ## Exercise 2

# %%
up.value = down.value = 10 * step
U.value = np.deg2rad(5.0)
solve()
left = max(float(np.abs(c.dual_value).max()) for c in (rising, falling, top, *box))
print(f"largest multiplier of any limit: {left:.1e} N m/rad")
assert left < 1.0

# %% [markdown]
# None: each station has its own best pitch within reach, no limit binds, and nothing would be paid for more of any of them. The multipliers of the
# segments remain. At each station they add up to $1/m$, and mix the slopes of two segments to zero.

# %%
shares = below.dual_value * m
assert np.allclose(shares.sum(axis=1), 1, atol=1e-5)
assert np.abs((shares * curves.slopes[0]).sum(axis=1)).max() < 1e-4 * np.abs(curves.slopes[0]).max()

# %% [markdown]
# ## Exercise 3

# %%
up.value = down.value = step
U.value = np.deg2rad(1.2)
solve()
prices = {"up": float(rising.dual_value.sum()), "down": float(falling.dual_value.sum())}
for name, parameter in (("up", up), ("down", down)):
    found = []
    for sign in (1, -1):
        parameter.value = step * (1 + 1e-3 * sign)
        found.append(solve())
    parameter.value = step
    difference = (found[0] - found[1]) / (2e-3 * step)
    print(
        f"{name:>4}: {prices[name] * per_degree:7.1f} N m for one deg/s from the dual, "
        f"{difference * per_degree:7.1f} from solving again"
    )
    assert abs(prices[name] / difference - 1) < 0.02

# %% [markdown]
# The way down, into the wind that gets slower and to the tower, is worth more than the way up: the fall is where the profile is
# further from what each station would like. The two prices are not equal although rise and fall are: a faster fall
# leaves more of the turn to rise slowly.
#
# ## Exercise 4
#
# Constant pitch $\beta_c$ is optimal for the charged problem if some $w$ with $|w_n|\le\kappa$ fulfils $f_n'(\beta_c)/m + w_n - w_{n-1} = 0$: the charge acts as a
# rate limit of zero whose multiplier is capped. These equations fix $w$ but for a constant, since the slopes add up to zero at the best constant
# pitch. The constant is best chosen so that the largest and the smallest $w$ are opposite, hence $\kappa^* = (\max w - \min w)/2$.

# %%
up.value = down.value = 0.0
U.value = np.deg2rad(5.0)
constant = solve()
w = (rising.dual_value - falling.dual_value).ravel()
kappa = 0.5 * (w.max() - w.min())
print(f"best constant pitch {constant / 1e3:.3f} kN m, kappa* = {kappa / 1e3:.1f} kN m/rad")

charge = cp.Parameter(nonneg=True)
mega = 1e-6  # in MN m: solvers like numbers near one
charged = cp.Problem(
    cp.Maximize(mega * cp.sum(t) / m - charge * cp.sum(cp.abs(change))), [below, *box, top]
)
travel = []
shares = np.array([0.1, 0.25, 0.5, 0.75, 0.9, 0.99, 1.01, 1.2])
for share in shares:
    charge.value = mega * share * kappa
    charged.solve(solver=cp.CLARABEL)
    travel.append(float(np.abs(change.value).sum()))
figure, ax = plt.subplots(figsize=(6, 3.4), layout="constrained")
ax.plot(shares, np.rad2deg(travel), "o-")
ax.axvline(1, color="0.6", linewidth=0.8)
ax.set_xlabel("charge over kappa* [-]")
ax.set_ylabel("pitch travel in a turn [deg]")
plt.show()
assert travel[-3] > 5e-4 > 1e-5 > max(travel[-2:])

# %% [markdown]
# ## Exercise 5
#
# $\min_w\ D\sum|w_n| + \sum_n s_n$ with $s_n \ge \frac1m f_{nj} + (w_n - w_{n-1})\beta_{nj}$ for every breakpoint $j$. The multiplier $\theta_{nj}$ of these constraints
# says which breakpoint is the maximum: $\theta\ge0$, $\sum_j\theta_{nj}=1$, and $\beta_n = \sum_j\theta_{nj}\beta_{nj}$. The dual of the dual is the
# program that we started from.

# %%
limited = case.with_values({"limits.pitch_max": np.deg2rad(1.2)}).task().problem()
short = limited.curves
w, s = cp.Variable((N, 1)), cp.Variable((N, 1))
handed_on = w - cp.vstack([w[-1:], w[:-1]])
scaled = mega * short.torque / m
columns = [
    s >= scaled[:, [j]] + cp.multiply(handed_on, short.beta[:, [j]])
    for j in range(short.beta.shape[1])
]
dual = cp.Problem(cp.Minimize(limited.step * cp.sum(cp.abs(w)) + cp.sum(s)), columns)
value = dual.solve(solver=cp.CLARABEL) / mega
print(f"least bound {value / 1e3:.6f} kN m, optimum {largest / 1e3:.6f} kN m")
assert abs(value / largest - 1) < 1e-6

theta = np.hstack([column.dual_value for column in columns])
recovered = (theta * short.beta).sum(axis=1)
assert np.allclose(theta.sum(axis=1), 1, atol=1e-5)
up.value = down.value = step
U.value = np.deg2rad(1.2)
solve()
print(
    f"largest difference in pitch {np.rad2deg(np.abs(recovered - beta.value.ravel()).max()):.1e} deg"
)
assert np.allclose(recovered, beta.value.ravel(), atol=np.deg2rad(0.01))
