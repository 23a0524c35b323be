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
# # Solutions to 1. Wind over a rotor

# %%
import matplotlib.pyplot as plt
import numpy as np
from scipy.signal import welch

from pitchopt import load_case
from windfield import (
    LogLaw,
    PowerLaw,
    StaticField,
    TowerShadow,
    TurbulentField,
    kaimal_box,
)

# %%
case = load_case("nrel-5mw").with_values({"wind.speed": 10.0, "wind.shear_exponent": 0.2})
turbine = case.turbine_data
R, H, clearance = turbine.rotor.radius, turbine.rotor.hub_height, turbine.rotor.overhang
N = 360
psi = 2 * np.pi * np.arange(N) / N


def harmonics(signal):
    """Amplitudes of 0P, 1P, 2P, ... of a signal sampled over one turn."""
    amplitude = np.abs(np.fft.rfft(signal)) / signal.size
    amplitude[1:] *= 2
    return amplitude


# %% [markdown]
# ## Exercise 1
#
# The slopes agree for $\xi = 1/\ln(H/z_0)$, hence $z_0 = H e^{-1/\xi}$.

# %%
z0 = H * np.exp(-1 / 0.2)
print(f"roughness length {z0:.3f} m: scattered trees or suburbs, not grass")
for name, law in (("power", PowerLaw(exponent=0.2)), ("log", LogLaw(roughness_length=z0))):
    low, high = 10 * law.factor(np.array([H - R, H + R]), H)
    print(f"{name:>5} law: {low:.2f} m/s at {H - R:.0f} m, {high:.2f} m/s at {H + R:.0f} m")

# %% [markdown]
# They agree to 0.3 m/s at the bottom, where the logarithm falls faster, and to less than 0.1 m/s at the top.
#
# ## Exercise 2
#
# In front of the axis $\Delta u/W = -r_t^2/d_t^2$, so 3 % needs $d_t = r_t/\sqrt{0.03} = 5.8\,r_t$.

# %%
tower = TowerShadow(radius=turbine.tower.radius, height=turbine.tower.height, top=turbine.tower.top)
lowest = H - R
r_t = float(tower.radius_at(lowest))
d_t = r_t / np.sqrt(0.03)
du, _ = tower.disturbance(-d_t, 0.0, lowest, 1.0)
assert np.isclose(du, -0.03)
at_rotor, _ = tower.disturbance(-clearance, 0.0, lowest, 1.0)
print(f"tower radius {r_t:.2f} m at {lowest:.0f} m, needed distance {d_t:.1f} m")
print(f"an upright rotor, {clearance:.2f} m in front, meets a dip of {-at_rotor:.0%}")

# %% [markdown]
# No turbine has that clearance: the shadow is a fact of upwind rotors. Tilt, cone and prebend, which move the tip
# upwind, help (the turbine has 5 degrees of tilt and 2.5 of cone, which add some 8 m at the tip).
#
# ## Exercise 3
#
# With $z - H = r\cos\psi$ and $y = -r\sin\psi$,
#
# $$ u = v\,[1 + k_z r\cos\psi - k_h r\sin\psi] = v\,[1 + r\sqrt{k_z^2+k_h^2}\,\cos(\psi-\psi_m)],
#    \qquad \psi_m = \operatorname{atan2}(-k_h, k_z) . $$
#
# One cosine: 1P and nothing else. A wind that grows to the left has its largest value where the blade points up and
# left, at $\psi_m$ a little before 360°.


# %%
class LinearShear:
    """v(z) / v(H) = 1 + k_z (z - H)."""

    def __init__(self, slope):
        self.slope = slope

    def factor(self, height, hub_height):
        return 1 + self.slope * (np.asarray(height) - hub_height)


k_z, k_h, r, v = 0.003, 0.002, 0.8 * R, 10.0
field = StaticField(speed=v, hub_height=H, vertical=LinearShear(k_z), horizontal_shear=k_h)
met = field.velocity(0.0, -r * np.sin(psi), H + r * np.cos(psi))[..., 0]
amplitude = harmonics(met)
assert np.isclose(amplitude[1], v * r * np.hypot(k_z, k_h))
assert amplitude[2:].max() < 1e-12 * v
largest = np.arctan2(-k_h, k_z) % (2 * np.pi)
assert abs(psi[np.argmax(met)] - largest) < 2 * np.pi / N
print(f"1P of {amplitude[1]:.3f} m/s, largest at {np.degrees(largest):.1f} deg")

# %% [markdown]
# ## Exercise 4
#
# With $B = 2$ the sum over the blades keeps the even harmonics, so thrust has 0P, 2P, 4P, ... Tilt weighs with $\cos\psi$, so
# harmonic $n$ of a blade arrives at $n-1$ and $n+1$, of which the even ones stay. The blade's 1P
# bending $a\cos\psi$ gives
#
# $$ \text{tilt} = 2 a\cos^2\psi = a + a\cos 2\psi : $$
#
# a constant moment **and** 2P of the same size. With three blades only the constant is left, $\tfrac32 a$.

# %%
blade = case.model().blade_loads(psi, np.zeros(N))


def over_blades(load, blades):
    return sum(np.roll(load, -b * load.size // blades) for b in range(blades))


for blades in (2, 3):
    thrust = harmonics(over_blades(blade.thrust, blades))
    tilt = harmonics(over_blades(blade.bending * np.cos(psi) - blade.radial * np.sin(psi), blades))
    for amplitude in (thrust, tilt):
        others = [n for n in range(1, 60) if n % blades]
        assert amplitude[others].max() < 1e-9 * amplitude.max()
    show = ", ".join(f"{n}P {tilt[n] / 1e3:.0f}" for n in (0, 1, 2, 3, 4, 6))
    print(f"{blades} blades, tilt in kN m: {show}")

# %% [markdown]
# This is why rotors with two blades have a teetering hub: it does not carry that 2P moment.
#
# ## Exercise 5
#
# A point is a spoke and a radius. We average over eight spokes, and the turning blade starts from each of them.

# %%
U, interval, duration = 10.0, 0.2, 600.0
box = kaimal_box(
    U, duration, interval, hub_height=H, width=2 * R, points=(11, 11), turbulence="B", seed=1
)
gusts = TurbulentField(mean=StaticField(speed=U, hub_height=H), box=box)
omega = case.rotor_speed
t = np.arange(0.0, duration, interval)
spokes = 2 * np.pi * np.arange(8) / 8


def share_above(r, speed):
    """Share of the variance above half the rotor's frequency, and the variance."""
    angle = spokes[:, None] + speed * t
    wind = gusts.velocity(0.0, -r * np.sin(angle), H + r * np.cos(angle), t)[..., 0]
    frequency, density = welch(wind, fs=1 / interval, nperseg=1024, axis=-1)
    high = frequency > 0.5 * omega / (2 * np.pi)
    return density[:, high].sum() / density.sum(), wind.var(axis=1).mean()


radii = np.linspace(0.1, 0.95, 8) * R
standing = np.array([share_above(r, 0.0) for r in radii])
turning = np.array([share_above(r, omega) for r in radii])
assert np.all(np.diff(turning[:, 0]) > 0)
assert abs(standing[:, 1].mean() / turning[:, 1].mean() - 1) < 0.1  # the variance itself stays

figure, ax = plt.subplots(figsize=(6, 3.8), layout="constrained")
ax.plot(radii / R, standing[:, 0], label="standing points")
ax.plot(radii / R, turning[:, 0], label="turning blade")
ax.set_xlabel("r / R [-]")
ax.set_ylabel("share of the variance above 0.5P [-]")
ax.set_ylim(0, 1)
ax.legend()
plt.show()

# %% [markdown]
# Turning does not change the variance, it moves it. What is moved is the part of the wind that differs between the points of the
# circle: a gust larger than the circle covers all of it and stays slow, a smaller one is met once a turn. The larger the circle
# against the length scale of turbulence (some 340 m along the wind, but coherence across it falls within a fraction of that), the more
# is left to differ. Large rotors therefore see more 1P from turbulence, and gain more from individual pitch.
