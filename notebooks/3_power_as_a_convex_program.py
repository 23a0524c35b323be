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
# # 3. Power as a convex program, duals explained
#
# Torque is concave in pitch (notebook 2) and the limits of an actuator are linear, so the profile of largest mean torque is the
# solution of a convex program, here even of a linear one. You write it in CVXPY, compare it with the library's own solve, and
# then read its dual: what is another degree per second of pitch rate worth?

# %% [markdown]
# ## What you will learn
#
# - the largest mean torque as a linear program, in twelve lines of CVXPY;
# - multipliers as prices, checked by solving again with changed limits;
# - complementary slackness and stationarity, seen station by station;
# - weak and strong duality: any multipliers give an upper bound, the right ones a proof;
# - the largest torque as a function of a limit is concave, and the price is its slope.

# %%
import cvxpy as cp
import matplotlib.pyplot as plt
import numpy as np
from ipywidgets import FloatSlider, interact

from pitchopt import load_case, power_max
from pitchopt.design import Multipliers, Objective, constant, lagrangian_bound
from pitchopt.sensitivity import PostOptimum

# %% [markdown]
# ## 1. The program
#
# One profile $\beta_n$ for all blades, $n = 0..N-1$ over the full turn, periodic. The rotor has $m = N/B$ positions in one blade
# passage, and its mean torque is the sum of the stations' torques over $m$:
#
# $$ \max_\beta\ \frac1m\sum_n f_n(\beta_n) \quad\text{s.t.}\quad \underline\beta_n \le \beta_n \le \min(\overline\beta_n, U), \qquad
#    |\beta_{n+1}-\beta_n| \le D, \quad \beta_N = \beta_0 . $$
#
# $D = \dot\beta_\text{max}\,2\pi/(N\omega)$ is how far the actuator gets from one station to the next. Each $f_n$ is concave and
# piecewise linear, hence the least of the lines through its segments, and with an epigraph variable $t_n$ below all of them
# the program is linear.
#
# We take slow actuators, 1 deg/s, and an upper end of the range, $U = 1.2°$, so that both limits bind.

# %%
rate, largest_pitch = np.deg2rad(1.0), np.deg2rad(1.2)
case = load_case("biegel2011").with_values({"limits.pitch_rate": rate})
curves = case.task().problem().curves  # on the pitches that range, stall and rate leave
N, m = curves.stations, curves.positions

beta, t = cp.Variable((N, 1)), cp.Variable((N, 1))
D = cp.Parameter(nonneg=True, value=case.pitch_limits.step(N))
U = cp.Parameter(value=largest_pitch)
change = cp.vstack([beta[1:], beta[:1]]) - beta

below = t <= curves.torque[:, :-1] + cp.multiply(curves.slopes[0], beta - curves.beta[:, :-1])
lower, upper = beta >= curves.lower[:, None], beta <= curves.upper[:, None]
top = beta <= U
rising, falling = change <= D, -change <= D
program = cp.Problem(cp.Maximize(cp.sum(t) / m), [below, lower, upper, top, rising, falling])

largest = program.solve(solver=cp.CLARABEL)
print(f"{N} stations, {below.size} segments; largest mean torque {largest / 1e3:.3f} kN m")
assert program.is_dcp(dpp=True)  # changed limits need no new compilation

# %% [markdown]
# The library solves the same problem with a solver of its own around Clarabel. The two must agree.

# %%
limited = case.with_values({"limits.pitch_max": largest_pitch})
task = limited.task()
library = power_max(task)
best_constant = constant(task)
print(f"library: {library.mean_torque / 1e3:.3f} kN m, status {library.status}")
print(f"best constant pitch: {best_constant.mean_torque / 1e3:.3f} kN m")
assert abs(largest / library.mean_torque - 1) < 1e-7

# %%
psi = np.rad2deg(curves.azimuth)
free = curves.beta[np.arange(N), curves.torque.argmax(axis=1)]
profile = beta.value.ravel()
figure, ax = plt.subplots(figsize=(8, 3.6), layout="constrained")
ax.plot(psi, np.rad2deg(free), "k.", markersize=4, label="best at each station alone")
ax.plot(psi, np.rad2deg(profile), label="optimum, own program")
ax.plot(psi, np.rad2deg(library.profile), "--", label="optimum, library")
ax.axhline(np.rad2deg(largest_pitch), color="0.6", linewidth=0.8)
ax.set_xlabel("azimuth [deg]")
ax.set_ylabel("pitch [deg]")
ax.legend(fontsize="small")
plt.show()

# %% [markdown]
# One degree per second is too slow nearly everywhere: the straight lines are the actuator at full rate. The dip at 180°, where the blade passes the tower, is out
# of its reach.
#
# ## 2. Multipliers are prices
#
# Every constraint has a multiplier $\ge 0$. It says by how much the optimum grows per unit of room in that constraint. Several
# constraints share one limit here: $D$ stands in $2N$ of them, so its price is the sum of their multipliers, and with
# $dD = d\dot\beta_\text{max}\,2\pi/(N\omega)$
#
# $$ \frac{\partial T_\text{max}}{\partial D} = \sum_n (w^+_n + w^-_n), \qquad
#    \frac{\partial T_\text{max}}{\partial U} = \sum_n u_n . $$

# %%
w_up, w_down = rising.dual_value.ravel(), falling.dual_value.ravel()
u = top.dual_value.ravel()
price_D, price_U = float((w_up + w_down).sum()), float(u.sum())


def solved_again(parameter, step):
    """Central difference of the optimum over a limit."""
    value, found = parameter.value, []
    for sign in (1, -1):
        parameter.value = value + sign * step
        found.append(program.solve(solver=cp.CLARABEL))
    parameter.value = value
    program.solve(solver=cp.CLARABEL)
    return (found[0] - found[1]) / (2 * step)


for name, parameter, price in (("D", D, price_D), ("U", U, price_U)):
    difference = solved_again(parameter, 1e-3 * parameter.value)
    print(f"price of {name}: {price:10.1f} from the dual, {difference:10.1f} from solving again")
    assert abs(price / difference - 1) < 0.02

omega = limited.rotor_speed
per_rate = price_D * 2 * np.pi / (N * omega) * np.deg2rad(1.0)
print(f"one more deg/s: {omega * per_rate / 1e3:.2f} kW at the most")
print(f"one more degree of range: {omega * price_U * np.deg2rad(1.0) / 1e3:.2f} kW at the most")

# %% [markdown]
# "At the most", because the price is a slope, and the optimum over a limit is concave: the second degree per second is worth less than
# the first. Section 5 draws that.
#
# ## 3. Complementary slackness
#
# A constraint that does not bind has no price: multiplier times slack is zero, for each of them. Left, each constraint is a
# point; all lie on the two axes. Right, where on the turn the prices are paid.

# %%
slack_up = D.value - (np.roll(profile, -1) - profile)
slack_down = D.value + (np.roll(profile, -1) - profile)
slack_top = U.value - profile
for slack, price in ((slack_up, w_up), (slack_down, w_down), (slack_top, u)):
    assert np.abs(slack * price).max() < 1e-5 * largest * D.value

figure, (left, right) = plt.subplots(1, 2, figsize=(11, 3.8), layout="constrained")
for slack, price, label in (
    (slack_up, w_up, "rising"),
    (slack_down, w_down, "falling"),
    (slack_top, u, "range"),
):
    left.plot(np.rad2deg(slack), price / 1e3, "o", alpha=0.6, label=label)
left.set_xlabel("slack [deg]")
left.set_ylabel("multiplier [kN m/rad]")
left.legend()
right.bar(psi, w_up / 1e3, width=5, label="rising")
right.bar(psi, -w_down / 1e3, width=5, label="falling, drawn downwards")
right.bar(psi, u / 1e3, width=5, label="range", alpha=0.6)
right.set_xlabel("azimuth [deg]")
right.set_ylabel("multiplier [kN m/rad]")
right.legend(fontsize="small")
plt.show()

# %% [markdown]
# ## 4. Stationarity
#
# With $w_n = w^+_n - w^-_n$ the Lagrangian's part that holds $\beta_n$ is $f_n(\beta_n)/m + (w_n - w_{n-1} - u_n)\,\beta_n$, and $\beta_n$ maximises it:
# the slope of torque there equals $m\,(w_{n-1} - w_n + u_n)$. Where nothing binds, the slope is zero, and each station has
# its own best pitch. Where the rate binds, slope is handed on from station to station: the price $w_n$ adds up what the stations before
# gave up, and is largest in the middle of a run at full rate.
#
# At a kink "the slope" is an interval, from the segment on the left to the one on the right.

# %%
wanted = m * (np.roll(w_up - w_down, 1) - (w_up - w_down) + u)
at = np.clip(profile, curves.lower + 1e-7, curves.upper - 1e-7)
tolerance = 1e-6  # [rad] to either side: the solver does not stand on the kink exactly
rows = np.arange(N)
slope_left = curves.slopes[0, rows, curves.segment(at - tolerance)]
slope_right = curves.slopes[0, rows, curves.segment(at + tolerance)]
assert np.all(wanted <= slope_left + 1e-3 * np.abs(slope_left).max())
assert np.all(wanted >= slope_right - 1e-3 * np.abs(slope_left).max())

figure, ax = plt.subplots(figsize=(8, 3.4), layout="constrained")
ax.vlines(
    psi, slope_right / 1e3, slope_left / 1e3, color="0.7", linewidth=4, label="slopes at the kink"
)
ax.plot(psi, wanted / 1e3, "C1.", label="from the multipliers")
ax.set_xlabel("azimuth [deg]")
ax.set_ylabel("slope of torque [kN m/rad]")
ax.legend(fontsize="small")
plt.show()
active = {
    "on a breakpoint": np.abs(curves.beta - profile[:, None]).min(axis=1) < tolerance,
    "rising at full rate": slack_up < tolerance,
    "falling at full rate": slack_down < tolerance,
    "at the end of the range": slack_top < tolerance,
}
print(", ".join(f"{mask.sum()} {name}" for name, mask in active.items()))
assert sum(mask.sum() for mask in active.values()) >= N

# %% [markdown]
# The counts add up to the number of stations: a linear program ends at a corner, and a corner in $N$ unknown
# pitches needs $N$ conditions.
#
# ## 5. How the optimum grows with a limit
#
# Move the rate. The optimum is a concave function of it, since the best of two limits' profiles can be mixed; the price at a point is the slope there,
# and the tangent lies above the curve. An estimate from a price is never too low.


# %%
def optimum_at(rate_deg):
    D.value = case.with_values({"limits.pitch_rate": np.deg2rad(rate_deg)}).pitch_limits.step(N)
    value = program.solve(solver=cp.CLARABEL)
    w = rising.dual_value.ravel() - falling.dual_value.ravel()
    price = float(np.abs(w).sum()) * 2 * np.pi / (N * omega)
    return value, price, beta.value.ravel().copy(), w


rates = np.linspace(0.05, 4, 24)
curve = np.array([optimum_at(x)[:2] for x in rates])
for a in range(rates.size):  # every tangent lies above every point
    tangent = curve[a, 0] + curve[a, 1] * np.deg2rad(rates - rates[a])
    assert np.all(tangent >= curve[:, 0] - 1e-6 * largest)


def draw_rate(rate_deg=1.0):
    value, price, profile, w = optimum_at(rate_deg)
    _, (left, middle, right) = plt.subplots(1, 3, figsize=(13, 3.4), layout="constrained")
    left.plot(rates, curve[:, 0] / 1e3)
    left.plot(rates, (value + price * np.deg2rad(rates - rate_deg)) / 1e3, "C1--")
    left.plot(rate_deg, value / 1e3, "C1o")
    left.set_ylim(curve[0, 0] / 1e3 - 0.5, curve[-1, 0] / 1e3 + 1.5)
    left.set_xlabel("pitch rate [deg/s]")
    left.set_ylabel("largest mean torque [kN m]")
    middle.plot(psi, np.rad2deg(free), "k.", markersize=3)
    middle.plot(psi, np.rad2deg(profile), "C1")
    middle.set_xlabel("azimuth [deg]")
    middle.set_ylabel("pitch [deg]")
    right.plot(psi, w / 1e3, "C1")
    right.set_xlabel("azimuth [deg]")
    right.set_ylabel("price of the rate [kN m/rad]")
    plt.show()


draw_rate()

# %%
_ = interact(
    draw_rate,
    rate_deg=FloatSlider(min=0.1, max=4.0, step=0.1, value=1.0, continuous_update=False),
)

# %% [markdown]
# `PostOptimum` of the library reads such prices from any solved CVXPY problem and says when not to trust them.

# %%
optimum_at(1.0)
estimate = PostOptimum.from_cvxpy(program, D).estimate(0.2 * D.value)
truth = optimum_at(1.2)[0]
print(f"20 % more rate: estimated {estimate.first_order:+.1f}, true {truth - largest:+.1f} N m")
assert estimate.first_order >= truth - largest > 0

# %% [markdown]
# ## 6. Duality: a bound from any multipliers
#
# Take **any** numbers $w_n$, of either sign. For a profile that keeps the rate $D\sum|w_n| + \sum(w_n-w_{n-1})\beta_n \ge 0$ (sum by parts), so adding it
# can only raise the objective, and
#
# $$ T(\beta) \le D\sum_n|w_n| + \sum_n \max_{\beta_n}\Bigl[\tfrac1m f_n(\beta_n) + (w_n - w_{n-1})\beta_n\Bigr]. $$
#
# On the right each station is on its own: a maximum over breakpoints, nothing to solve. This is **weak duality**, and it holds for wrong multipliers
# as well. With the optimal ones both sides are equal: **strong duality**, and the multipliers are a proof that no profile is better.
# We compute it by hand and with the library's `lagrangian_bound`.

# %%
tight = task.problem()  # with the upper end of the range in its curves
tight_curves = tight.curves
step = tight.step


def bound(w):
    bracket = tight_curves.torque / m + (w - np.roll(w, 1))[:, None] * tight_curves.beta
    return step * np.abs(w).sum() + bracket.max(axis=1).sum()


w_best = w_up - w_down
objective = Objective(torque=1.0, rms=(0.0, 0.0, 0.0, 0.0, 0.0))
stored = Multipliers(loads=np.zeros((4, m)), blade=np.zeros(N), rate=w_best)
assert np.isclose(bound(w_best), lagrangian_bound(tight, objective, stored)[0], rtol=1e-10)
assert abs(bound(w_best) / largest - 1) < 1e-6  # strong duality

rng = np.random.default_rng(2)
for scale in 10.0 ** rng.uniform(0, 5, 200):  # weak duality
    assert bound(scale * rng.standard_normal(N)) >= largest * (1 - 1e-9)

share = np.linspace(0, 2, 81)
figure, ax = plt.subplots(figsize=(6.5, 3.6), layout="constrained")
ax.plot(share, [bound(s * w_best) / 1e3 for s in share])
ax.axhline(largest / 1e3, color="C1", linestyle="--", label="largest mean torque")
ax.set_xlabel("share of the optimal multipliers [-]")
ax.set_ylabel("upper bound [kN m]")
ax.legend()
plt.show()

# %% [markdown]
# At share 0 the bound is the optimum without any rate limit. It falls to the true optimum at share 1 and rises beyond: the dual is the
# minimum of these bounds. Every certificate of this library is of this kind: stored multipliers, from which anyone can compute the bound again without
# a solver.

# %% [markdown]
# ## Exercises
#
# **Exercise 1 (quick).** How much energy a year would 0.1 deg/s more pitch rate bring, if the turbine ran in this wind all the time? Judge whether a
# faster pitch drive pays for itself by power alone.
#
# **Exercise 2 (quick).** Set the rate back to 10 deg/s and $U$ to 5°. Which multipliers are left? Explain each.
#
# **Exercise 3 (medium).** Let the actuator be faster towards feather than towards stall: limits $D^+$ upwards and $D^-$ downwards. The turn is
# periodic, so what rises must fall. Compute both prices at 1 deg/s and check them by solving again. Which one
# would you rather have more of?
#
# **Exercise 4 (medium).** Take the rate limit and $U$ away, and charge for pitch travel instead: subtract $\kappa\sum_n|\beta_{n+1}-\beta_n|$. From which $\kappa$ on is constant pitch
# optimal? Find it from the multipliers of the problem with $D = 0$ and check on both sides of it.
#
# **Exercise 5 (hard).** Minimise the bound of section 6 over $w$ with CVXPY (a convex program: a sum of maxima). Compare the value with the optimum, and
# recover the optimal pitch as the multipliers of *your* program.
