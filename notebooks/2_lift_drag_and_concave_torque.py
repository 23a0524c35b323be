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
# # 2. Lift, drag and why torque is concave in pitch
#
# The designs of this library are convex programs. That is not an accident of a solver but of aerodynamics: below stall lift
# bends downwards over the angle of attack and drag bends upwards. This notebook builds the torque of a blade
# from its sections, shows why it is a concave function of pitch, how a table of breakpoints represents it
# without any error, and where all this ends.

# %% [markdown]
# ## What you will learn
#
# - the inflow triangle, and how pitch enters the forces on a section;
# - best concave and convex fits of lift and drag, and what they cost;
# - why torque is concave in pitch, and bending and thrust are not;
# - `BladeCurves`: an exact table of one blade's loads over its own pitch;
# - where it breaks: deep stall, and a wake that answers to pitch.

# %%
import matplotlib.pyplot as plt
import numpy as np
from ipywidgets import FloatSlider, interact

from pitchopt import fit_polar, load_case
from pitchopt.plotting import plot_polar_fit

# %% [markdown]
# The case is `biegel2011`: a rotor of 40 m radius, three blades with two equal elements each, in sheared wind
# of 15 m/s, without induction. Small enough to see everything.

# %%
case = load_case("biegel2011")
model = case.model()
rotor = model.rotor
blade = rotor.blade
r = rotor.hub_radius + blade.span  # distance of the sections from the rotor centre
dr = np.diff(blade.edges)
omega, rho = model.rotor_speed, model.air_density
print(f"sections at r = {r} m, twist = {np.rad2deg(blade.twist).round(2)} deg, {omega:.3f} rad/s")

# %% [markdown]
# ## 1. The inflow triangle
#
# A section at radius $r$ meets the wind along the shaft, $w_n$, and its own speed, $w_t = \omega r$:
#
# $$ W = \sqrt{w_n^2+w_t^2}, \qquad \varphi = \operatorname{atan2}(w_n, w_t), \qquad
#    \alpha = \varphi - (\text{twist} + \beta). $$
#
# Lift stands across the relative wind, drag along it. Their components in the direction of motion drive the rotor:
#
# $$ C_t = C_l\sin\varphi - C_d\cos\varphi, \qquad C_n = C_l\cos\varphi + C_d\sin\varphi . $$
#
# Pitch $\beta$ turns the section towards feather, which **lowers** the angle of attack, and does nothing else: $W$ and
# $\varphi$ do not depend on it.

# %%
polar = blade.polars[-1]


def triangle(psi, e):
    """Relative wind and inflow angle of section e at azimuth psi."""
    at = (-rotor.overhang, -r[e] * np.sin(psi), rotor.hub_height + r[e] * np.cos(psi))
    w_n = model.wind.velocity(*at)[..., 0]
    w_t = omega * r[e]
    return np.hypot(w_n, w_t), np.arctan2(w_n, w_t)


def draw_triangle(pitch_deg=0.0, azimuth_deg=0.0):
    W, phi = triangle(np.deg2rad(azimuth_deg), 0)
    section = blade.twist[0] + np.deg2rad(pitch_deg)
    alpha = float(phi - section)
    cl, cd, _ = (float(c) for c in polar.coefficients(alpha))
    _, ax = plt.subplots(figsize=(8.4, 4.2), layout="constrained")
    # the inner section; direction of motion to the right, downwind up
    chord = np.array([np.cos(section), -np.sin(section)])
    ax.plot(*np.outer(chord, [-0.75, 0.25]), color="0.8", linewidth=8, zorder=1)
    lift = cl * np.array([np.sin(phi), np.cos(phi)])
    drag = 10 * cd * np.array([-np.cos(phi), np.sin(phi)])
    wind = np.array([-np.cos(phi), np.sin(phi)])
    for vector, colour, label, start in (
        (wind, "C2", f"relative wind, {W:.1f} m/s", -wind),
        (lift, "C0", f"lift coefficient {cl:.2f}", np.zeros(2)),
        (drag, "C3", f"drag coefficient {cd:.4f}, drawn ten times longer", np.zeros(2)),
        (np.array([lift[0] + drag[0] / 10, 0]), "C1", "what drives the rotor", np.zeros(2)),
    ):
        arrow = {"angles": "xy", "scale_units": "xy", "scale": 1, "width": 0.008, "zorder": 3}
        ax.quiver(*start, *vector, color=colour, label=label, **arrow)
    ax.axhline(0, color="0.8", linewidth=0.8, zorder=0)
    ax.set(xlim=(-1.2, 1.2), ylim=(-0.6, 1.5), aspect="equal")
    ax.set_xlabel("direction of motion")
    ax.set_ylabel("downwind")
    ax.set_title(
        f"inflow angle {np.rad2deg(phi):.1f}°, angle of attack {np.rad2deg(alpha):.1f}°",
        fontsize="medium",
    )
    ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize="small", frameon=False)
    plt.show()


draw_triangle()

# %%
_ = interact(
    draw_triangle,
    pitch_deg=FloatSlider(min=-6, max=16, step=0.5, value=0.0, continuous_update=False),
    azimuth_deg=FloatSlider(min=0, max=360, step=10, value=0.0, continuous_update=False),
)

# %% [markdown]
# ## 2. Lift and drag, and their fits
#
# Between two angles of attack lift is replaced by the best **concave** piecewise-linear function and drag by the best **convex** one,
# best in the largest error. Both stay within a small band around the table, they do not lie above it or below it throughout.
# Each fit is itself a linear program: the values at the knots are the variables, and concavity is a
# sign of their second differences.

# %%
low, high = np.deg2rad(-5.0), polar.stall_angle()
fit = fit_polar(polar, (low, high), segments=40)
assert np.all(np.diff(fit.cl, 2) <= 1e-12)  # concave
assert np.all(np.diff(fit.cd, 2) >= -1e-12)  # convex

# the reported error is the largest anywhere: no sample beats it
alpha = np.linspace(low, high, 20_001)
cl_error = np.abs(fit.coefficients(alpha)[0] - polar.coefficients(alpha)[0]).max()
assert cl_error <= fit.cl_error * (1 + 1e-9)
print(f"lift: largest error {fit.cl_error:.5f} of {fit.cl.max():.2f}; drag {fit.cd_error:.5f}")

# %%
figure, ax = plt.subplots(figsize=(6.8, 5.0), layout="constrained")
plot_polar_fit(polar, fit, ax=ax)
plt.show()

# %% [markdown]
# ## 3. Why torque is concave in pitch
#
# The torque of one section is
#
# $$ \tau(\beta) = \tfrac12\rho W^2 b\,r\,dr\,\bigl[\sin\varphi\; C_l(\alpha) - \cos\varphi\; C_d(\alpha)\bigr],
#    \qquad \alpha = \varphi - \text{twist} - \beta . $$
#
# 1. For $0\le\varphi\le 90°$ both $\sin\varphi$ and $\cos\varphi$ are $\ge 0$: a concave function times a number $\ge0$ is
#    concave, and minus a convex one is concave.
# 2. $\alpha$ is affine in $\beta$, and composition with an affine map keeps concavity.
# 3. A sum of concave functions is concave: over sections, over azimuth, over blades.
#
# Nothing was assumed about the rotor but that $W$ and $\varphi$ do not answer to pitch. We write it down, and compare it with
# the library.


# %%
def own_torque(psi, beta):
    """Torque of one blade from the fits, section by section [N m]."""
    total = 0.0
    for e in range(r.size):
        W, phi = triangle(psi, e)
        cl, cd, _ = fit.coefficients(phi - blade.twist[e] - beta)
        drive = cl * np.sin(phi) - cd * np.cos(phi)
        total += 0.5 * rho * W**2 * blade.chord[e] * r[e] * dr[e] * drive
    return total


beta = np.deg2rad(np.linspace(-4, 12, 400))
psi_down = np.full(beta.size, np.pi)
assert np.allclose(own_torque(psi_down, beta), model.blade_loads(psi_down, beta).torque, rtol=1e-9)

# concave: every chord lies below the curve, at random pairs and shares
rng = np.random.default_rng(1)
one, two = rng.uniform(beta[0], beta[-1], (2, 2000))
share = rng.uniform(0, 1, 2000)
psi_any = rng.uniform(0, 2 * np.pi, 2000)
between = own_torque(psi_any, share * one + (1 - share) * two)
chord = share * own_torque(psi_any, one) + (1 - share) * own_torque(psi_any, two)
assert np.all(between >= chord - 1e-6)

# %%
figure, axes = plt.subplots(1, 3, figsize=(12, 3.6), layout="constrained")
for azimuth in (0, 90, 180):
    loads = model.blade_loads(np.full(beta.size, np.deg2rad(azimuth)), beta)
    for ax, name in zip(axes, ("torque", "bending", "thrust"), strict=True):
        ax.plot(np.rad2deg(beta), getattr(loads, name) / 1e3, label=f"azimuth {azimuth}°")
for ax, name, unit in zip(
    axes, ("torque", "bending", "thrust"), ("kN m", "kN m", "kN"), strict=True
):
    ax.set_title(f"{name} of one blade")
    ax.set_xlabel("pitch [deg]")
    ax.set_ylabel(f"[{unit}]")
axes[0].legend(fontsize="small")
plt.show()

# %% [markdown]
# Bending and thrust carry $C_l\cos\varphi + C_d\sin\varphi$, a concave plus a convex function. They look concave here, because lift
# dominates, but a load variation asks for more: it is a sum of squares of differences of such functions, and
# that is neither concave nor convex unless they are straight. Notebook 4 is about that.
#
# ## 4. BladeCurves: the table is the model
#
# With piecewise-linear polars each section's torque is piecewise linear in $\beta$, with a kink where $\alpha$ passes a knot,
# and the sum over sections has all their kinks. A table with just these breakpoints is not a sample of the model but the model
# itself.

# %%
curves = model.curves(positions=24)
print(f"{curves.stations} stations over the turn, {curves.beta.shape[1]} breakpoints each")
print("torque concave at every station:", curves.concave)

worst = 0.0
for _ in range(50):
    profile = curves.lower + (curves.upper - curves.lower) * rng.random(curves.stations)
    table = curves.contributions(profile)  # torque, tilt, yaw, thrust, bending of the blade
    direct = model.blade_loads(curves.azimuth, profile)
    worst = max(
        worst, np.abs(table[0] - direct.torque).max(), np.abs(table[3] - direct.thrust).max()
    )
print(f"largest difference to the model in 50 random profiles: {worst:.1e} N m or N")
assert worst < 1e-6

# %%
n = 36  # the blade points down
slope = curves.slopes[0, n]
figure, (left, right) = plt.subplots(1, 2, figsize=(10, 3.6), layout="constrained")
left.plot(np.rad2deg(curves.beta[n]), curves.torque[n] / 1e3, ".-", markersize=4)
left.set_ylabel("torque of one blade [kN m]")
right.step(np.rad2deg(curves.beta[n, :-1]), slope / 1e3, where="post")
right.set_ylabel("slope of torque [kN m/rad]")
for ax in (left, right):
    ax.set_xlabel("pitch [deg]")
figure.suptitle("azimuth 180°: concave means that the slope only falls")
plt.show()
assert np.all(np.diff(slope) <= 1e-6 * np.abs(slope).max())

# %% [markdown]
# The ends of each row are limits of pitch at that station: the actuator's range, cut where a section would leave its fit. At low
# pitch that is stall, $\beta \ge \varphi - \text{twist} - \alpha_\text{max}$ for the section that stalls first.
# Stall is an aerodynamic limit that has become a bound on a variable.

# %%
stall_limit = []
for psi_n in curves.azimuth:
    limit = [triangle(psi_n, e)[1] - blade.twist[e] - high for e in range(r.size)]
    stall_limit.append(max(*limit, model.pitch_range[0]))
assert np.allclose(curves.lower, stall_limit, atol=1e-9)

figure, ax = plt.subplots(figsize=(7, 3.4), layout="constrained")
degrees = np.rad2deg(curves.azimuth)
ax.fill_between(degrees, np.rad2deg(curves.lower), np.rad2deg(curves.upper), alpha=0.2)
ax.plot(degrees, np.rad2deg(curves.lower), label="lower limit (stall)")
best = curves.beta[np.arange(curves.stations), curves.torque.argmax(axis=1)]
ax.plot(degrees, np.rad2deg(best), "k.", markersize=4, label="largest torque at this station")
ax.set_xlabel("azimuth [deg]")
ax.set_ylabel("pitch [deg]")
ax.legend(fontsize="small")
plt.show()

# %% [markdown]
# ## 5. Where it breaks
#
# Widen the window of angles of attack and watch the error of the fits. Stall itself, at 16°, is not the end of concavity: lift turns over
# smoothly there, and a concave function may fall. What ends it is deep stall, where lift levels off and bends upwards. The
# limit is set at stall for another reason: beyond it a section in changing flow does not follow its
# steady polar, so that the numbers would be exact for the wrong model.


# %%
def draw_window(alpha_min_deg=-5.0, alpha_max_deg=30.0):
    wide = fit_polar(polar, (np.deg2rad(alpha_min_deg), np.deg2rad(alpha_max_deg)), segments=40)
    _, ax = plt.subplots(figsize=(6.8, 4.6), layout="constrained")
    plot_polar_fit(polar, wide, ax=ax)
    plt.show()


draw_window()

# %%
_ = interact(
    draw_window,
    alpha_min_deg=FloatSlider(min=-20, max=0, step=1, value=-5.0, continuous_update=False),
    alpha_max_deg=FloatSlider(min=5, max=40, step=1, value=30.0, continuous_update=False),
)

# %%
for top in (16, 20, 25, 30, 40):
    wide = fit_polar(polar, (low, np.deg2rad(top)), segments=80)
    print(
        f"-5 to {top} deg: largest error of lift {wide.cl_error:.4f}, of drag {wide.cd_error:.4f}"
    )

# %% [markdown]
# The second assumption was a flow that does not answer to pitch. With a wake in momentum balance at every azimuth and pitch
# (`induction="equilibrium"`) more lift slows the air, and $\varphi$ changes with $\beta$. The argument above then says nothing; torque
# may be concave or not. A wake that is frozen at a mean pitch keeps the argument whole. The library tells which it is, for any table of curves.

# %%
for induction in ("frozen", "equilibrium"):
    real = load_case("nrel-5mw").with_values({"aero.induction": induction, "wind.speed": 9.0})
    real_curves = real.model().curves(12, mean_pitch=0.05)
    print(
        f"nrel-5mw, {induction:<11}: concave {real_curves.concave!s:<5}, "
        f"largest rise of slope {real_curves.concavity_error:.1e} of the largest slope"
    )
    assert real_curves.concave == (induction == "frozen")

# %% [markdown]
# Only the frozen curves use the fits; those in equilibrium are computed from the tables of the polars. Which of the two, wake or tables,
# spoils concavity is the last exercise.

# %% [markdown]
# ## Exercises
#
# **Exercise 1 (quick).** At which pitch has the section at $r = 32$ m, blade up, its best ratio of lift to drag? Is this the pitch of largest torque?
# Why not?
#
# **Exercise 2 (quick).** A fit has 40 segments, thus 41 knots. How many breakpoints should a station have with two sections, and how many does
# it have? Explain the difference.
#
# **Exercise 3 (medium).** Step 1 needs $\sin\varphi\ge0$. Take a section with $\varphi = -10°$ (air that comes from behind) and show
# by second differences on the table of breakpoints that its torque is no longer concave. What is it?
#
# **Exercise 4 (medium).** How does the error of the fit fall with the number of segments $d$, from 2 to 80? Explain the slope of the curve
# in a double logarithmic plot, and why it ends. What does it mean for the largest torque of the rotor?
#
# **Exercise 5 (hard).** With equilibrium induction torque is not concave. Two things could do that: the tables of the polars, which
# bend the wrong way here and there, and the wake. Separate them: replace the rows of each `Polar` within its `concave_range()` by the knots of
# `fit_polar`, compute the curves in equilibrium again, and compare the largest rise of slope within a few degrees of the best pitch,
# and over the whole range.
