"""
Figure 3: wind and forces at a blade section
============================================

The paper sketches how the incoming wind and the blade's own motion make up the relative wind, and
how lift and drag turn into an axial and a tangential force.  Here both are drawn to scale for the
outer element of ``biegel2011`` at its best constant pitch, blade up, from wind and polars of the
case. Computed while the site is built.  Seen along the blade from its tip; the section moves to
the right and the wind blows upwards.
"""

import numpy as np
from matplotlib.figure import Figure

from pitchopt.cases import load_case
from pitchopt.design import constant

task = load_case("biegel2011").task()
model = task.model
blade = model.rotor.blade
pitch = float(constant(task).profile[0])

r = float(model.rotor.hub_radius + blade.span[-1])
top = model.rotor.apex() + np.array([0.0, 0.0, r])
axial = float(model.wind.velocity(*top)[0])  # w_n: along the shaft
motion = model.rotor_speed * r  # w_t: against the motion
speed, inflow = np.hypot(axial, motion), np.arctan2(axial, motion)
alpha = inflow - blade.twist[-1] - pitch
lift, drag = (float(c) for c in blade.polars[-1].coefficients(alpha)[:2])
normal = lift * np.cos(inflow) + drag * np.sin(inflow)
tangential = lift * np.sin(inflow) - drag * np.cos(inflow)
print(f"w_n {axial:.1f} m/s, w_t {motion:.1f} m/s, phi {np.degrees(inflow):.1f} deg")
print(f"alpha {np.degrees(alpha):.1f} deg: Cl {lift:.2f}, Cd {drag:.3f}")
print(f"Cn {normal:.2f}, Ct {tangential:.3f}")

figure = Figure(figsize=(11.0, 4.6), layout="constrained")
left, right = figure.subplots(1, 2)


def arrow(ax, start, step, colour, label):
    """One vector with its name at the end."""
    ax.annotate(
        "", np.add(start, step), start, arrowprops={"arrowstyle": "-|>", "color": colour, "lw": 1.8}
    )
    ax.plot([], [], color=colour, label=label)


def section(ax, size):
    """The chord line, leading edge to the right, turned by twist and pitch."""
    angle = blade.twist[-1] + pitch
    ends = size * np.array([[-0.7, 0.3], [0.7 * np.tan(angle), -0.3 * np.tan(angle)]])
    ax.plot(*ends, color="0.6", linewidth=5, solid_capstyle="round", zorder=0, label="chord")


section(left, 40.0)
arrow(left, (motion, -axial), (-motion, 0.0), "tab:green", "w_t, from the motion")
arrow(left, (0.0, -axial), (0.0, axial), "tab:blue", "w_n, from the wind")
arrow(left, (motion, -axial), (-motion, axial), "black", "W, relative wind")
left.set(title="wind at the section [m/s]", xlim=(-35, motion + 10), ylim=(-axial - 15, 20))
section(right, 0.5)
arrow(right, (0.0, 0.0), (lift * np.sin(inflow), lift * np.cos(inflow)), "tab:red", "lift")
arrow(right, (0.0, 0.0), (-drag * np.cos(inflow), drag * np.sin(inflow)), "tab:orange", "drag")
arrow(right, (0.0, 0.0), (0.0, normal), "tab:blue", "axial force")
arrow(right, (0.0, 0.0), (tangential, 0.0), "tab:green", "tangential force")
right.set(title="coefficients [-]", xlim=(-0.5, 0.7), ylim=(-0.15, 1.05 * max(lift, normal)))
for ax in (left, right):
    ax.set_aspect("equal")
    ax.legend(fontsize="small", loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
