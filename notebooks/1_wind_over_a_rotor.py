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
# # 1. Wind over a rotor
#
# A turbine in steady wind still feels a load that changes all the time, because each blade turns
# through wind that differs from place to place. This notebook follows one blade element on its way
# round, splits what it meets into harmonics of the rotor speed, and shows which of them are left when
# the loads of three blades are added up.

# %% [markdown]
# ## What you will learn
#
# - how wind grows with height, and how the power law and the logarithmic law are related;
# - how far in front of the tower its shadow reaches, from potential flow;
# - what one blade meets over azimuth, in harmonics of the rotor speed (1P, 2P, ...);
# - why a rotor with three blades passes on 3P, 6P, ..., and where 1P goes;
# - what turbulence adds: a turning blade sees gusts as peaks at 1P, 2P, ...

# %%
import matplotlib.pyplot as plt
import numpy as np
from ipywidgets import Checkbox, FloatSlider, interact
from scipy.signal import welch

from pitchopt import load_case
from pitchopt.plotting import plot_wind_field
from windfield import (
    CubicShear,
    LogLaw,
    PowerLaw,
    StaticField,
    TowerShadow,
    TurbulentField,
    iec_sigma,
    kaimal_box,
    sample_disc,
)

# %% [markdown]
# We take the NREL 5 MW reference turbine. Axes as everywhere in the library: $x$ downwind, $z$ up, $y$ to
# the left when looking downwind. Azimuth $\psi = 0$ is a blade that points up, and $\psi$ grows clockwise
# seen from upwind. A point of the blade at radius $r$ thus stands at
#
# $$ y = -r\sin\psi, \qquad z = H + r\cos\psi . $$

# %%
turbine = load_case("nrel-5mw").turbine_data
R, H = turbine.rotor.radius, turbine.rotor.hub_height
clearance = turbine.rotor.overhang  # from the tower axis to the rotor centre
print(f"radius {R:.1f} m, hub height {H:.1f} m, {turbine.rotor.blades} blades")

# %% [markdown]
# ## 1. Speed over height
#
# Two laws describe the mean wind over flat ground. The **power law** is a convenient fit, the
# **logarithmic law** follows from turbulent flow over a surface of roughness length $z_0$:
#
# $$ \frac{v(z)}{v(H)} = \Bigl(\frac zH\Bigr)^{\xi}, \qquad
#    \frac{v(z)}{v(H)} = \frac{\ln(z/z_0)}{\ln(H/z_0)} . $$
#
# They have the same slope at the hub if $\xi = 1/\ln(H/z_0)$: take $d\ln v/d\ln z$ of both. So over grass
# ($z_0 = 0.03$ m) the exponent that fits is near 1/8. The third law is the Taylor series
# of the power law to third order, which stays finite at the ground.

# %%
z0 = 0.03
xi = 1 / np.log(H / z0)
laws = {
    f"power law, exponent {xi:.3f}": PowerLaw(exponent=xi),
    f"log law, roughness length {z0} m": LogLaw(roughness_length=z0),
    "cubic series of the power law": CubicShear(exponent=xi),
}

# the slopes agree at the hub, by a central difference
step = 1e-3 * H
slopes = [
    (law.factor(H + step, H) - law.factor(H - step, H)) / (2 * step) * H for law in laws.values()
]
assert np.allclose(slopes, xi, rtol=1e-5)

height = np.linspace(1.0, H + R, 300)
figure, ax = plt.subplots(figsize=(6, 4.2))
for (name, law), style in zip(laws.items(), ["-", "--", ":"], strict=True):
    ax.plot(law.factor(height, H), height, style, label=name)
ax.axhspan(H - R, H + R, color="0.92", label="heights of the rotor")
ax.set_xlabel("v(z) / v(H) [-]")
ax.set_ylabel("height z [m]")
ax.legend(loc="upper left", fontsize="small")
plt.show()

# %% [markdown]
# Over the rotor the three are hard to tell apart; below it they are not. An exponent of 0.2, which we use
# from here on, stands for rougher ground or a stable night.
#
# ## 2. The tower's shadow
#
# An upwind rotor passes through air that the tower pushes aside. Outside a thin layer this is potential
# flow past a cylinder of radius $r_t$: a dipole that cancels the flow through the wall. With $x$, $y$ from the
# tower axis and a wind $W$ along $x$
#
# $$ \Delta u = -W r_t^2\frac{x^2-y^2}{(x^2+y^2)^2}, \qquad \Delta v = -W r_t^2\frac{2xy}{(x^2+y^2)^2}. $$
#
# We check two things: no air goes through the wall, and straight in front at $x = -d_t$ the wind is slower by
# $W r_t^2/d_t^2$.

# %%
W, r_t = 10.0, 2.5
tower = TowerShadow(radius=r_t, top=200.0)  # tall: all of what follows is below its top

angle = np.linspace(0, 2 * np.pi, 73)
x, y = r_t * np.cos(angle), r_t * np.sin(angle)
du, dv = tower.disturbance(x, y, 50.0, W)
through_wall = (W + du) * np.cos(angle) + dv * np.sin(angle)
assert np.abs(through_wall).max() < 1e-12 * W

d_t = 5.0
du, _ = tower.disturbance(-d_t, 0.0, 50.0, W)
assert np.isclose(du, -W * r_t**2 / d_t**2)
print(f"{d_t} m in front of the tower axis the wind is slower by {-du / W:.0%}")

# %%
y = np.linspace(-25, 25, 401)
figure, (left, right) = plt.subplots(1, 2, figsize=(10, 3.8), layout="constrained")
for d in (4.0, 5.0, 7.0, 10.0):
    du, _ = tower.disturbance(-d, y, 50.0, W)
    left.plot(y, 1 + du / W, label=f"{d:g} m upwind")
left.set_xlabel("y across the wind [m]")
left.set_ylabel("u / W [-]")
left.legend(fontsize="small")

X, Y = np.meshgrid(np.linspace(-12, 12, 121), np.linspace(-12, 12, 121))
du, dv = tower.disturbance(X, Y, 50.0, W)
inside = X**2 + Y**2 < r_t**2
u, v = np.where(inside, np.nan, W + du), np.where(inside, np.nan, dv)
right.streamplot(X, Y, u, v, color="0.5", linewidth=0.8, density=1.1, arrowsize=0.7)
right.add_patch(plt.Circle((0, 0), r_t, color="0.3"))
right.axvline(-d_t, color="C1", label=f"rotor plane, {d_t:g} m upwind")
right.set_aspect("equal")
right.set_xlabel("x downwind [m]")
right.set_ylabel("y [m]")
right.legend(loc="upper right", fontsize="small")
plt.show()

# %% [markdown]
# The dip is as wide as the distance: beyond $|y| = d_t$ the wind is faster than without the tower, since the
# air has to pass somewhere. Over the whole line the changes cancel,
# $\int \Delta u\,dy = 0$.
#
# ## 3. What a blade element meets
#
# Now both together, on the disc of the rotor. `StaticField` answers `velocity(x, y, z)` for any points.

# %%
speed, exponent = 10.0, 0.2


def field_of(exponent=0.2, shadow=True, horizontal_shear=0.0):
    tower = TowerShadow(
        radius=turbine.tower.radius, height=turbine.tower.height, top=turbine.tower.top
    )
    return StaticField(
        speed=speed,
        hub_height=H,
        vertical=PowerLaw(exponent=exponent),
        horizontal_shear=horizontal_shear,
        tower=tower if shadow else None,
    )


field = field_of()
figure, ax = plt.subplots(figsize=(6, 4.8), layout="constrained")
plot_wind_field(sample_disc(field, R, x=-clearance, rings=60, azimuths=240, closed=True), ax=ax)
plt.show()

# %%
N = 360
psi = 2 * np.pi * np.arange(N) / N


def met(field, r):
    """Wind along x [m/s] that the element at radius r meets, over azimuth."""
    return field.velocity(-clearance, -r * np.sin(psi), H + r * np.cos(psi))[..., 0]


def harmonics(signal):
    """Amplitudes of 0P, 1P, 2P, ... of a signal sampled over one turn."""
    amplitude = np.abs(np.fft.rfft(signal)) / signal.size
    amplitude[1:] *= 2
    return amplitude


def draw_element(exponent=0.2, radius_share=0.8, shadow=True):
    wind = met(field_of(exponent, shadow), radius_share * R)
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 3.4), layout="constrained")
    left.plot(np.rad2deg(psi), wind)
    left.set_xlabel("azimuth [deg], 180: blade down")
    left.set_ylabel("wind that the element meets [m/s]")
    left.set_xticks(range(0, 361, 60))
    right.bar(range(1, 10), harmonics(wind)[1:10])
    right.set_xlabel("multiple of the rotor speed [P]")
    right.set_ylabel("amplitude [m/s]")
    right.set_xticks(range(1, 10))
    plt.show()


draw_element()

# %%
_ = interact(
    draw_element,
    exponent=FloatSlider(min=0.0, max=0.4, step=0.02, value=0.2, continuous_update=False),
    radius_share=FloatSlider(min=0.1, max=1.0, step=0.05, value=0.8, continuous_update=False),
    shadow=Checkbox(value=True, description="tower shadow"),
)
# %% [markdown]
# Shear is slow over azimuth, so it makes 1P and little else. The tower is a short dip once a turn, and a short dip
# holds all harmonics at nearly the same amplitude. Near the root the dip is wide in azimuth: the same width in
# metres is a larger angle there.
#
# ## 4. Harmonics of shear
#
# With $s = r/H$ the element meets $v(1+s\cos\psi)^\xi$. The binomial series gives the amplitudes:
#
# $$ 1P:\ v\,\Bigl[\xi s + \tfrac{3}{4}\cdot\tfrac{\xi(\xi-1)(\xi-2)}{6}s^3 + \dots\Bigr], \qquad
#    2P:\ v\,\Bigl|\tfrac{1}{2}\cdot\tfrac{\xi(\xi-1)}{2}s^2 + \dots\Bigr| , $$
#
# from $\cos^2\psi = (1+\cos2\psi)/2$ and $\cos^3\psi = (3\cos\psi+\cos3\psi)/4$. In steps: 1P is of the order of $\xi s$,
# 2P of $\xi s^2$, and so on.

# %%
r = 0.5 * R
s = r / H
found = harmonics(met(field_of(exponent, shadow=False), r))
first = speed * (exponent * s + 0.75 * exponent * (exponent - 1) * (exponent - 2) / 6 * s**3)
second = speed * abs(exponent * (exponent - 1) / 4) * s**2
print(f"1P: {found[1]:.4f} m/s, series {first:.4f};  2P: {found[2]:.4f} m/s, series {second:.4f}")
assert abs(found[1] - first) < 0.01 * first  # what is left out is of order s**5 and s**4
assert abs(found[2] - second) < 0.1 * second

# %% [markdown]
# ## 5. From one blade to the rotor
#
# Let a blade's load be $f(\psi) = \sum_n c_n e^{in\psi}$. Blade $b$ of $B$ is $2\pi b/B$ ahead, so the sum over the blades
# is
#
# $$ \sum_{b=0}^{B-1} f\Bigl(\psi + \frac{2\pi b}{B}\Bigr) = \sum_n c_n e^{in\psi} \sum_{b=0}^{B-1} e^{2\pi i n b/B},
#    \qquad \sum_b e^{2\pi inb/B} = \begin{cases} B & n \text{ a multiple of } B\\ 0 & \text{else.}\end{cases} $$
#
# With three blades torque and thrust hold 0P, 3P, 6P, ... and nothing else: 1P of one blade cancels against the other
# two. Tilt and yaw weigh each blade with $\cos\psi$ or $\sin\psi$, which moves every harmonic by one:
# 1P turns into a **constant** moment, and 2P and 4P into 3P.
#
# We check it with real loads: the library's blade-element model of the turbine in this wind.

# %%
case = load_case("nrel-5mw").with_values({"wind.speed": speed, "wind.shear_exponent": exponent})
rotor = case.model()
pitch = np.zeros(N)
blade = rotor.blade_loads(psi, pitch)


def over_blades(load, blades=3):
    """Sum over evenly spaced blades, as a function of the azimuth of the first."""
    return sum(np.roll(load, -b * load.size // blades) for b in range(blades))


def of_rotor(blade):
    """Torque, thrust, tilt and yaw of the rotor from the loads of one blade."""
    return {
        "torque": over_blades(blade.torque),
        "thrust": over_blades(blade.thrust),
        "tilt": over_blades(blade.bending * np.cos(psi) - blade.radial * np.sin(psi)),
        "yaw": over_blades(blade.bending * np.sin(psi) + blade.radial * np.cos(psi)),
    }


rotor_loads = of_rotor(blade)
for name, load in rotor_loads.items():
    amplitude = harmonics(load)
    others = [n for n in range(1, 60) if n % 3]
    assert amplitude[others].max() < 1e-9 * amplitude.max(), name

# %%
figure, (left, right) = plt.subplots(1, 2, figsize=(10, 3.6), layout="constrained")
orders = np.arange(1, 10)
left.bar(orders, harmonics(blade.bending)[1:10] / 1e3)
left.set_title("bending moment of one blade")
left.set_ylabel("amplitude [kN m]")
for k, name in enumerate(["tilt", "yaw"]):
    right.bar(orders + 0.3 * (k - 0.5), harmonics(rotor_loads[name])[1:10] / 1e3, 0.3, label=name)
right.set_title(
    f"rotor; mean tilt {rotor_loads['tilt'].mean() / 1e3:.0f}, "
    f"mean yaw {rotor_loads['yaw'].mean() / 1e3:.0f} kN m"
)
right.legend()
for ax in (left, right):
    ax.set_xlabel("multiple of the rotor speed [P]")
    ax.set_xticks(orders)
plt.show()

# %% [markdown]
# The blade is shaken at 1P. The hub sees that as a constant tilting moment, and what shakes the hub comes
# at 3P. Is that the tower or the shear? A run without the tower tells.


# %%
no_tower = of_rotor(case.with_values({"wind.tower_shadow": False}).model().blade_loads(psi, pitch))
print("share of the amplitude that is left without the tower")
for name, load in rotor_loads.items():
    left = harmonics(no_tower[name])[[3, 6]] / harmonics(load)[[3, 6]]
    print(f"{name:>7}: 3P {left[0]:4.0%}, 6P {left[1]:4.0%}")
    assert left[1] < 0.1  # 6P is the tower's

# %% [markdown]
# In torque and thrust 3P is the tower's dip for the most part. In tilt and yaw more than half of it is shear: bending has 2P
# in smooth shear already, and tilt and yaw turn 2P into 3P. A slow change of wind over the disc is not felt slowly.
#
# The design of the later notebooks looks at one blade passage only:
# a third of a turn is the period of everything the rotor passes on.
#
# ## 6. Turbulence
#
# The standard IEC 61400-1 sorts sites into classes of turbulence: A+, A, B and C have an expected intensity
# $I_\text{ref}$ of 18, 16, 14 and 12 % at 15 m/s, and the standard deviation along the wind is
#
# $$ \sigma_1 = I_\text{ref}\,(0.75\,U + 5.6\ \text{m/s}) . $$
#
# `kaimal_box` makes a box of air with the standard's spectrum and coherence, which the mean wind carries through the rotor.

# %%
U = 10.0
for letter, intensity in {"A+": 0.18, "A": 0.16, "B": 0.14, "C": 0.12}.items():
    assert np.isclose(iec_sigma(letter, U), intensity * (0.75 * U + 5.6))
    print(f"class {letter:<2}: sigma = {iec_sigma(letter, U):.2f} m/s at {U:g} m/s")

interval, duration = 0.2, 600.0
box = kaimal_box(
    U,
    duration,
    interval,
    hub_height=H,
    width=2 * R,
    points=(11, 11),
    turbulence="B",
    seed=1,
    scaling="box",
)
u = box.velocity[..., 0]
assert np.isclose(np.sqrt(np.mean(u**2)), iec_sigma("B", U), rtol=1e-3)

# %%
gusts = TurbulentField(mean=StaticField(speed=U, hub_height=H), box=box)
rotor_speed = case.rotor_speed
t = np.arange(0.0, duration, interval)
r = 0.75 * R
turn = rotor_speed * t
standing = gusts.velocity(0.0, 0.0, H + r, t)[..., 0]
turning = gusts.velocity(0.0, -r * np.sin(turn), H + r * np.cos(turn), t)[..., 0]

figure, (left, right) = plt.subplots(1, 2, figsize=(10, 3.6), layout="constrained")
shown = t < 120
left.plot(t[shown], standing[shown], label="standing point")
left.plot(t[shown], turning[shown], label="turning blade", linewidth=1)
left.set_xlabel("time [s]")
left.set_ylabel("wind [m/s]")
left.legend(fontsize="small")
for signal, label in ((standing, "standing point"), (turning, "turning blade")):
    frequency, density = welch(signal, fs=1 / interval, nperseg=1024)
    right.loglog(frequency[1:] / (rotor_speed / (2 * np.pi)), density[1:], label=label)
right.set_xlabel("frequency over the rotor's [P]")
right.set_ylabel("spectrum [m²/s² per Hz]")
right.axvline(1, color="0.6", linewidth=0.8)
right.axvline(2, color="0.6", linewidth=0.8)
right.set_ylim(1e-2, None)
right.legend(fontsize="small")
plt.show()

# %% [markdown]
# Both points see air of the same variance. The turning blade cuts through each gust once a turn for as long as the gust
# stays, and that moves the energy of slow gusts to 1P, 2P, ... Steady shear and slow turbulence look alike to a
# blade. A pitch profile that repeats each turn helps against the first; a controller that adapts it from turn to turn (notebooks 5
# and 7) also helps against the second; neither helps against what is new in each turn.

# %% [markdown]
# ## Exercises
#
# **Exercise 1 (quick).** Which roughness length gives the same slope at the hub as the power law with exponent 0.2?
# What wind do the two laws give at the lowest and at the highest point of the rotor, for 10 m/s at the hub?
#
# **Exercise 2 (quick).** How far in front of the tower axis must a blade pass for the wind there to be at most 3 %
# slower? Give the formula, then the distance at the height of the lowest tip of the NREL 5 MW. Check it with `TowerShadow`.
#
# **Exercise 3 (medium).** Add a linear horizontal shear, `horizontal_shear=0.002` 1/m, to a linear vertical one,
# $v(1 + k_z (z-H))$. Show that an element at radius $r$ meets 1P alone, and give its amplitude and the azimuth of its largest wind.
# Check it against `StaticField` with a vertical law of your own: any object with a method
# `factor(height, hub_height)` will do.
#
# **Exercise 4 (medium).** Which harmonics would a rotor with two blades have in thrust and in tilt? Derive it, then
# compute it with `over_blades(..., blades=2)`. Where does 1P of a blade go now?
#
# **Exercise 5 (hard).** In turbulence, compute the share of the variance at more than half the rotor's frequency for
# elements at $r = 0.1 R$ to $0.95 R$, for a standing point and for the turning blade. Average over points of the same radius.
# Why does it grow with the radius?
