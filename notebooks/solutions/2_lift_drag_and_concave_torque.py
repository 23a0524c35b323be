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
# # Solutions to 2. Lift, drag and why torque is concave in pitch

# %%
from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np

from pitchopt import Polar, fit_polar, load_case
from pitchopt.design import constant

# %%
case = load_case("biegel2011")
model = case.model()
rotor, blade = model.rotor, model.rotor.blade
polar = blade.polars[-1]
low, high = np.deg2rad(-5.0), polar.stall_angle()
fit = fit_polar(polar, (low, high), segments=40)
r = rotor.hub_radius + blade.span


def inflow_angle(psi, e):
    at = (-rotor.overhang, -r[e] * np.sin(psi), rotor.hub_height + r[e] * np.cos(psi))
    return np.arctan2(model.wind.velocity(*at)[..., 0], model.rotor_speed * r[e])


# %% [markdown]
# ## Exercise 1

# %%
alpha = np.linspace(low, high, 4001)
cl, cd, _ = polar.coefficients(alpha)
phi = inflow_angle(0.0, 1)
drive = cl * np.sin(phi) - cd * np.cos(phi)
best_ratio, best_torque = alpha[np.argmax(cl / cd)], alpha[np.argmax(drive)]
for name, a in (("lift over drag", best_ratio), ("torque", best_torque)):
    print(
        f"largest {name}: alpha {np.rad2deg(a):.2f} deg, "
        f"pitch {np.rad2deg(phi - blade.twist[1] - a):.2f} deg"
    )
# the largest torque stands on a row of the table, where dCd/dCl jumps across tan(phi)
row = np.argmin(np.abs(polar.alpha - best_torque))
before, after = (np.diff(polar.cd) / np.diff(polar.cl))[[row - 1, row]]
print(f"dCd/dCl before {before:.3f}, after {after:.3f}; tan(phi) {np.tan(phi):.3f}")
assert before < np.tan(phi) < after

# %% [markdown]
# The best ratio of lift to drag is the best trade of two forces along and across the wind. Torque asks another price: a unit of drag
# costs $\cos\varphi$, a unit of lift earns $\sin\varphi$, so lift is increased until $dC_d/dC_l = \tan\varphi$. That is far beyond the best
# ratio, because without induction nothing else stands against more lift. A turbine with a wake is another matter: there the optimum lies near the best
# ratio.
#
# ## Exercise 2
#
# Two sections with 41 knots each make 82. A row starts where the first section would pass stall and ends where the first one would pass -5°,
# so one knot of the other section falls outside at either end: 80. The twist was chosen so that both work at nearly the same angle of attack;
# if it had not been, more would fall outside.

# %%
curves = model.curves(positions=24)
knots = np.array(
    [
        [inflow_angle(psi, e) - blade.twist[e] - fit.alpha for e in range(2)]
        for psi in curves.azimuth
    ]
)
start, end = knots.min(axis=2).max(axis=1), knots.max(axis=2).min(axis=1)
inside = (knots >= start[:, None, None] - 1e-12) & (knots <= end[:, None, None] + 1e-12)
expected = inside.sum(axis=(1, 2))
found = np.array([np.sum(np.diff(row) > 1e-8) + 1 for row in curves.beta])
print("expected from", expected.min(), "to", expected.max(), "breakpoints at a station;")
print(
    "rows of the table:", curves.beta.shape[1], "(shorter ones are filled up by splitting segments)"
)
assert expected.max() == curves.beta.shape[1]
assert np.all(found >= expected)

# %% [markdown]
# ## Exercise 3

# %%
phi = np.deg2rad(-10.0)
drive = fit.cl * np.sin(phi) - fit.cd * np.cos(phi)  # at the knots, alpha growing as pitch falls
bend = np.diff(drive, 2)
print(f"of {bend.size} kinks {np.sum(bend > 1e-9)} bend upwards, {np.sum(bend < -1e-9)} downwards")
assert bend.max() > 1e-4
assert bend.min() < -1e-4

# %% [markdown]
# $\sin\varphi < 0$ makes the lift term convex, the drag term stays concave: the sum is neither. It bends upwards where lift bends most and drag
# is flat, and downwards where drag rises. Such a section brakes the rotor, whatever its pitch.
#
# ## Exercise 4

# %%
segments = np.array([2, 3, 4, 6, 8, 10, 14, 20, 28, 40, 56, 80])
fits = [fit_polar(polar, (low, high), int(d)) for d in segments]
cl_error = np.array([f.cl_error for f in fits])
cd_error = np.array([f.cd_error for f in fits])
torque = {}
for d in (2, 5, 10, 20, 40, 80):
    torque[d] = constant(case.with_values({"aero.segments": d}).task()).mean_torque
for d, value in torque.items():
    print(
        f"{d:3d} segments: best constant pitch {value / 1e3:.2f} kN m ({value / torque[80] - 1:+.2%})"
    )
slope = np.polyfit(np.log(segments[:8]), np.log(cl_error[:8]), 1)[0]
print(f"lift error falls like d to the power {slope:.2f}")
assert -2.3 < slope < -1.2

# %%
figure, ax = plt.subplots(figsize=(6, 3.8), layout="constrained")
ax.loglog(segments, cl_error, "o-", label="lift")
ax.loglog(segments, cd_error, "s-", label="drag")
ax.loglog(segments, cl_error[0] * (segments / 2.0) ** -2, ":", color="0.5", label="power -2")
ax.set_xticks([2, 5, 10, 20, 40, 80], labels=["2", "5", "10", "20", "40", "80"])
ax.minorticks_off()
ax.set_xlabel("segments d")
ax.set_ylabel("largest error [-]")
ax.legend()
plt.show()

# %% [markdown]
# A straight piece of length $h$ misses a smooth curve by $h^2/16\,|C''|$ at best, hence about power -2. The decay ends when the pieces are as short as the
# rows of the table (a degree or half of one), and earlier for drag, whose table is not convex: 0.0006 remains however many segments are spent.
# The torque errs by far less than the fit's largest error suggests, since fits go to both sides of the table and the rotor takes a mean over
# many angles of attack. From twenty segments on it is good to a tenth of a per cent.
#
# ## Exercise 5

# %%
real = load_case("nrel-5mw").with_values({"aero.induction": "equilibrium", "wind.speed": 9.0})
tables = real.model()


def fitted(polar):
    """The polar with its concave and convex fits in place of the rows that they cover."""
    if not polar.lifting:
        return polar
    limits = polar.concave_range()
    fit = fit_polar(polar, limits)
    below, above = polar.alpha < limits[0] - 1e-9, polar.alpha > limits[1] + 1e-9

    def joined(table, middle):
        return np.concatenate([table[below], middle, table[above]])

    return Polar(
        name=polar.name,
        alpha=joined(polar.alpha, fit.alpha),
        cl=joined(polar.cl, fit.cl),
        cd=joined(polar.cd, fit.cd),
        cm=joined(polar.moment, fit.cm),
    )


polars = tuple(fitted(p) for p in tables.rotor.blade.polars)
smooth = replace(
    tables, rotor=replace(tables.rotor, blade=replace(tables.rotor.blade, polars=polars))
)

mean_pitch = 0.05
rise = {}
figure, ax = plt.subplots(figsize=(7, 3.6), layout="constrained")
for name, rotor_model in (("tables", tables), ("fits", smooth)):
    curves = rotor_model.curves(12, mean_pitch=mean_pitch)
    slope = curves.slopes[0]
    change = np.diff(slope, axis=1) / np.abs(slope).max()
    pitch = np.rad2deg(curves.beta[:, 1:-1])
    near = np.abs(pitch - np.rad2deg(mean_pitch)) < 4
    rise[name] = change[near].max(), change.max()
    ax.plot(pitch[0], change[0], ".-", label=name)
    print(
        f"{name:<6}: largest rise near the mean pitch {rise[name][0]:+.4f}, anywhere {rise[name][1]:+.4f}"
    )
ax.axhline(0, color="0.3", linewidth=0.8)
ax.set_xlabel("pitch [deg]")
ax.set_ylabel("change of slope over largest slope [-]")
ax.legend()
plt.show()
assert rise["fits"][0] < 0 < rise["tables"][0]
assert min(rise["fits"][1], rise["tables"][1]) > 0.1

# %% [markdown]
# Around the operating pitch it is the tables: with the fits in their place torque is strictly concave, although the wake answers. Momentum
# balance works in favour of concavity here: more lift slows the air, which takes back part of the gain. Far towards feather both curves break in the
# same way. There the sections have left the range of the fits downwards, and again it is the polars. What is true here need not be true for
# another rotor and wind, which is why the library measures concavity instead of assuming it.
