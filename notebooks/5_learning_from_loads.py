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
# # 5. Learning from loads
#
# The designs of notebooks 3 and 4 need a model of turbine and wind. A rotor also repeats itself
# three times a turn, and what repeats can be learned: apply a profile, measure torque, tilt, yaw
# and thrust, correct the profile, go on. This notebook derives when such a loop converges, checks
# it on a plant of our own, and then lets two learners work on a rotor that they know nothing about.

# %% [markdown]
# ## What you will learn
#
# - the lifted linear model of one blade passage: a matrix with a structure that makes learning
#   cheap,
# - the learner with a fixed gain, the factor by which it converges in a passage, and errors that
#   make it diverge,
# - why a fixed gain never averages noise away, and what a quick learner pays,
# - what an adaptive learner does otherwise, in steady wind, under noise and after a step of the
#   wind,
# - what no learner can know.

# %%
import numpy as np
from ipywidgets import FloatSlider, interact
from matplotlib import pyplot as plt

from ilc import LOADS, ActuatorLimits, AdaptiveLearner, FixedLearner, Layout, Sensors, run
from pitchopt import load_case
from pitchopt.plotting import plot_contraction, plot_learning, plot_torque
from pitchopt.studies.learning import (
    ConstantWind,
    LearningSettings,
    StaticPlant,
    WindStep,
    WindTasks,
    learn,
)

# %% [markdown]
# ## 1. One passage as a matrix
#
# A passage is a turn by $2\pi/B$. In it the four loads are measured at $m$ rotor positions, and the
# pitch profile $\beta$ has $N = Bm$ stations. Stack all loads of a passage into one vector $y$ of
# length $4m$ and linearise about a profile $\beta_0$:
#
# $$ y = y_0 + D\,(\beta - \beta_0), \qquad D \in \mathbb R^{4m\times N}. $$
#
# This is called the *lifted* model: time has gone, a passage is one algebraic map. On the static
# rotor the loads at position $k$ depend on the pitch of the $B$ blades that stand there and on
# nothing else, so each block of four rows has $B$ columns that are not zero. We measure $D$ by
# moving one station at a time, which no real turbine would like, and look at it. The rotor is the
# built-in case `biegel2011` at 15 m/s with 8 positions a passage.

# %%
coarse = load_case("biegel2011").with_values({"limits.positions": 8})
rotor = StaticPlant(tasks=WindTasks(case=coarse), wind=ConstantWind(speed=coarse.wind.speed))
layout = Layout(blades=rotor.blades, positions=rotor.positions)
level = np.full(layout.stations, np.deg2rad(4.0))
move = 1e-6  # [rad], small enough to stay on one linear piece of the polars
lifted = np.array(
    [
        (rotor.passage(level + move * unit, 0) - rotor.passage(level - move * unit, 0)).T.ravel()
        for unit in np.eye(layout.stations)
    ]
).T / (2 * move)

blocks = lifted.reshape(layout.positions, 4, layout.stations)
touched = np.abs(blocks).max(axis=1) > 1e-6 * np.abs(blocks).max()
assert lifted.shape == (4 * layout.positions, layout.stations)
for k in range(layout.positions):  # position k answers the stations k, k + m, k + 2m alone
    assert set(np.flatnonzero(touched[k])) == set(layout.index[k])
print(f"{touched.mean():.0%} of the blocks are not zero, 1/m = {1 / layout.positions:.0%}")

# %%
figure, ax = plt.subplots(figsize=(6.5, 5.2), layout="constrained")
scaled = lifted / np.tile(np.abs(blocks).max(axis=(0, 2)), layout.positions)[:, None]
image = ax.imshow(scaled, cmap="RdBu_r", vmin=-1, vmax=1, aspect="auto", interpolation="nearest")
figure.colorbar(image, ax=ax, label="load per pitch over the load's largest [-]")
ax.set_yticks(np.arange(4 * layout.positions)[::4], np.arange(layout.positions))
ax.set_xlabel("station of the profile")
ax.set_ylabel("rotor position, four rows each: " + ", ".join(LOADS))
ax.set_title("the lifted model of one passage")
plt.show()

# %% [markdown]
# The rows of a block show the multiblade geometry: torque and thrust answer all three blades alike,
# tilt with the cosine and yaw with the sine of each blade's azimuth. The problem splits into $m$
# small ones, one for each position: four loads, three pitches. From here on $D$ stands for one such
# $4\times B$ block.
#
# ## 2. A fixed gain, and when it converges
#
# With weights $W$ and errors $e = W(y - \bar y)$ against the means that are to be held, one
# Gauss-Newton step for $\min \lVert e \rVert^2$, shortened by a learning rate $\kappa$, is
#
# $$ \beta \leftarrow \beta - \kappa H e, \qquad H = (D^T W^2 D + \nu I)^{-1} D^T W . $$
#
# Let $d$ be the distance of the pitch from the fixed point of this iteration, on a plant whose
# slopes are $D + E$ while the learner believes in $D$:
#
# $$ d \leftarrow \bigl(I - \kappa H W (D + E)\bigr)\, d . $$
#
# It converges if and only if the spectral radius of this matrix is below one. With $E = 0$ and
# $\nu = 0$, $HWD = I$ and the distance shrinks by $1 - \kappa$ in *every* passage, whatever the
# plant.
#
# A learner of the package `ilc` needs no turbine: anything with `blades`, `positions` and
# `passage(profile, number)` is a plant. Here is one in a dozen lines, affine, whose slopes change
# by a given share once the experiment is over.

# %%
LAYOUT = Layout(blades=3, positions=12)
SCALE = np.array([1.4e6, 3e5, 3e5, 8e4])  # torque, tilt, yaw [N m], thrust [N]


class AffinePlant:
    """Loads y_0 + D beta at every position, and y_0 + (D + E) beta after the experiment."""

    blades, positions = LAYOUT.blades, LAYOUT.positions

    def __init__(self, error=0.0, after=9):
        random = np.random.default_rng(1)
        psi = LAYOUT.azimuth[LAYOUT.index]
        slopes = np.stack(
            [-0.5 + 0 * psi, -2 * np.cos(psi), -2 * np.sin(psi), -1 + 0 * psi], axis=1
        )
        slopes *= 1 + 0.1 * random.normal(size=slopes.shape)
        self.offset = SCALE * (1 + 0.02 * random.normal(size=(LAYOUT.positions, 4)))
        self.jacobian = SCALE[:, None] * slopes
        self.later = self.jacobian * (1 + error * random.normal(size=slopes.shape))
        self.after = after

    def passage(self, profile, number):
        jacobian = self.jacobian if number < self.after else self.later
        return (self.offset + np.einsum("klb,kb->kl", jacobian, profile[LAYOUT.index])).T


def new_learner(rate, damping=0.0):
    return FixedLearner(
        layout=LAYOUT,
        limits=ActuatorLimits(lower=-0.5, upper=0.5, step=0.5),
        start=0.0,
        setpoint=float(SCALE[0]),
        weights=SCALE[0] / SCALE,
        learning_rate=rate,
        damping=damping,
        smoothing=1e-9,  # hold the means, as the theory does
        patience=10**6,  # no guard: it takes a run of unlucky noise for growth and slows down
    )


def profiles_of(plant, learner, passages):
    """Profiles (passages + 1, N) from the end of the experiment on."""
    while not learner.learning:
        learner.tell(plant.passage(learner.profile, learner.passages))
    found = [learner.profile]
    for _ in range(passages):
        learner.tell(plant.passage(learner.profile, learner.passages))
        found.append(learner.profile)
    return np.array(found)


def factors(plant, learner):
    """Spectral radius of I - kappa H W (D + E) at every position."""
    weighted = learner.weights[:, None] * plant.later
    matrices = np.eye(3) - learner.learning_rate * learner.gain @ weighted
    return np.abs(np.linalg.eigvals(matrices)).max(axis=1)


# %% [markdown]
# First the closed form. The experiment (nine passages in which the profile is moved on purpose)
# gives the learner its slopes; on an affine plant they are exact. Successive *changes* of the
# profile shrink by the same factor as the distance.

# %%
print("kappa   1 - kappa   spectral radius   measured")
for rate in (0.1, 0.3, 0.6, 0.9):
    plant, learner = AffinePlant(), new_learner(rate)
    changes = np.abs(np.diff(profiles_of(plant, learner, 5), axis=0)).max(axis=1)
    assert np.allclose(learner.jacobian, plant.jacobian, rtol=1e-6)
    measured = changes[1] / changes[0]
    predicted = factors(plant, learner).max()
    print(f"{rate:5.1f} {1 - rate:11.3f} {predicted:17.3f} {measured:10.3f}")
    assert np.isclose(predicted, 1 - rate, atol=1e-5)
    assert np.isclose(measured, 1 - rate, atol=1e-5)

# %% [markdown]
# Now the slopes are wrong by a random share. A sufficient condition says how wrong they may be: the
# distance surely shrinks if
# $\kappa\,\lVert H\rVert\,\lVert WE\rVert < 1 - \lVert I - \kappa HWD\rVert$. Without damping this
# is $\lVert WE\rVert/\lVert WD\rVert < 1/\operatorname{cond}(WD)$, whatever $\kappa$. It is not
# necessary. The spectral radius is the judge: it predicts the slope of each line below, and beyond
# a certain error it passes one.


# %%
def draw_convergence(kappa=0.3, error=0.3):
    _, ax = plt.subplots(figsize=(7.0, 4.0), layout="constrained")
    for share, colour in ((0.0, "C0"), (error, "C1")):
        plant, learner = AffinePlant(error=share), new_learner(kappa)
        changes = np.abs(np.diff(profiles_of(plant, learner, 45), axis=0)).max(axis=1)
        predicted = factors(plant, learner).max()
        shown = changes > 1e-13
        at = np.arange(1, 46)
        ax.semilogy(
            at[shown],
            changes[shown],
            "o",
            ms=3,
            color=colour,
            label=f"slopes off by {share:.0%}: factor {predicted:.3f}",
        )
        tail = min(15, np.count_nonzero(shown) - 1)
        line = changes[tail] * predicted ** (at - at[tail])
        ax.semilogy(at[line > 1e-13], line[line > 1e-13], ":", color=colour)
    ax.set_xlabel("passage after the experiment")
    ax.set_ylabel("largest change of pitch [rad]")
    ax.set_title("dots: measured, dotted: spectral radius")
    ax.legend(frameon=False)
    plt.show()


draw_convergence()

# %%
_ = interact(
    draw_convergence,
    kappa=FloatSlider(value=0.3, min=0.05, max=1.0, step=0.05, continuous_update=False),
    error=FloatSlider(value=0.3, min=0.0, max=1.0, step=0.05, continuous_update=False),
)
# %%
plant, learner = AffinePlant(error=0.4), new_learner(0.3)
changes = np.abs(np.diff(profiles_of(plant, learner, 40), axis=0)).max(axis=1)
late = (changes[30] / changes[20]) ** 0.1
predicted = factors(plant, learner).max()
print(f"slopes off by 40 %: predicted {predicted:.4f}, measured {late:.4f}")
assert abs(late - predicted) < 0.01

weighted = learner.weights[:, None] * plant.jacobian
wrong = learner.weights[:, None] * (plant.later - plant.jacobian)
sizes = np.linalg.norm(wrong, 2, axis=(1, 2)) / np.linalg.norm(weighted, 2, axis=(1, 2))
margins = 1 / np.linalg.cond(weighted)
print(
    f"size of the error up to {sizes.max():.2f}, margin from {margins.min():.2f} on: "
    "outside, and yet it converges"
)
assert sizes.max() > margins.min()
assert predicted < 1

# %% [markdown]
# What does destroy convergence is a slope of the wrong *sign*: then the learner pushes away from
# the target, and no learning rate helps, since $1 - \kappa\lambda$ lies outside the unit circle for
# every $\kappa > 0$ once an eigenvalue $\lambda$ of $HWD$ is negative. Section 4 shows where this
# happens on a rotor.
#
# ## 3. Noise
#
# Measurement noise $v$ of covariance $S$ enters as $d \leftarrow (1-\kappa) d - \kappa H W v$. In
# the steady state
#
# $$ X = (1-\kappa)^2 X + \kappa^2 H W S W H^T
# \quad\Rightarrow\quad X = \frac{\kappa}{2-\kappa}\,H W S W H^T . $$
#
# If all weighted loads have the same noise $\sigma$, then $WD H$ is a projector on the three load
# directions that three blades can make, and the exact loads keep the variance
# $3\,\frac{\kappa}{2-\kappa}\,\sigma^2$ in all, however long one waits: a fixed gain never averages
# for longer than $1/\kappa$ passages. We check it with 1500 passages.

# %%
SIGMA = 1e-3 * SCALE[0]  # of each weighted load


def noise_left(rate, passages=1500, seed=0):
    """Variance that noise leaves in the exact weighted loads, over sigma^2."""
    plant, learner, random = AffinePlant(), new_learner(rate), np.random.default_rng(seed)
    profiles_of(plant, learner, 200)  # settle without noise
    quiet, total = plant.passage(learner.profile, learner.passages), 0.0
    for _ in range(passages):
        loads = plant.passage(learner.profile, learner.passages)
        off = learner.weights[:, None] * (loads - quiet)
        total += (off**2).sum(axis=0).mean() / passages
        noise = SIGMA / learner.weights[:, None] * random.normal(size=loads.shape)
        learner.tell(loads + noise)
    return total / SIGMA**2


rates = np.array([0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 0.9])
left = np.array([noise_left(rate) for rate in rates])
expected = 3 * rates / (2 - rates)
assert np.all(np.abs(left / expected - 1) < 0.05)

# %%
figure, ax = plt.subplots(figsize=(6.5, 4.0), layout="constrained")
fine = np.linspace(0.01, 1.0, 100)
ax.plot(fine, np.sqrt(fine / (2 - fine)), "k--", label=r"$\sqrt{\kappa/(2-\kappa)}$")
ax.plot(rates, np.sqrt(left / 3), "o", label="measured over 1500 passages")
ax.set_xlabel(r"learning rate $\kappa$ [-]")
ax.set_ylabel("share of the sensors' noise that stays in a load [-]")
ax.legend(frameon=False)
plt.show()

# %% [markdown]
# A trade that no fixed gain escapes: $\kappa = 0.3$ takes 13 passages to shrink a distance to 1 %
# and keeps 42 % of the noise's deviation; $\kappa = 0.05$ keeps 16 % and takes 90.
#
# ## 4. On a rotor
#
# Now the static rotor of `biegel2011` at 15 m/s, 24 positions a passage. The learner is told the
# loads of each passage, the mean torque to hold (7 % below the largest possible), and the range and
# rate of the actuators. The figures are the sum of the RMS variations of the four loads, judged on
# the exact loads of the last passage of each rotation, beside the profile that was *designed* with
# the model for the same torque. After 12 rotations the wind rises by 2 m/s; the set-point follows.

# %%
case = load_case("biegel2011")
step = WindStep(speed=case.wind.speed, change=2.0, rotation=12)
results = {
    name: learn(case, LearningSettings(learner=name, rotations=20, wind=step))
    for name in ("paper", "adaptive")
}
print("sum of RMS over the design's after rotation     2      6     12     14     20")
for name, result in results.items():
    row = " ".join(f"{result.ratio(k):6.2f}" for k in (2, 6, 12, 14, 20))
    print(f"{name:44s}{row}")
fixed, adaptive = results["paper"], results["adaptive"]
assert adaptive.ratio(12) < 1.05 < fixed.ratio(12)
assert adaptive.ratio(14) < 1.3

# %%
figure, axes = plt.subplots(2, 2, figsize=(11.0, 7.0), layout="constrained", sharex=True)
for column, (name, result) in zip(axes.T, results.items(), strict=True):
    plot_learning(result, ax=column[0])
    plot_torque(result, ax=column[1])
    column[0].set_xlabel("")
    column[1].set_xlabel({"paper": "rotation, fixed gain", "adaptive": "rotation, adaptive"}[name])
plt.show()

# %% [markdown]
# Both learn. The fixed gain ends near 1.5 times the design. That is not lack of patience but what
# it minimises: at its fixed point $D^T W e = 0$, so that it removes the three load combinations
# that three blades can make and leaves the fourth where it happens to be, while the design trades
# all four and moves the means of tilt and yaw, which are free.
#
# Its slopes date from the experiment, while the rotor's change with the pitch. The factor of
# section 2 can be computed with both:

# %%
figure, ax = plt.subplots(figsize=(7.0, 3.8), layout="constrained")
plot_contraction(fixed.loop, ax=ax)
plt.show()
assert np.allclose(fixed.loop.estimated, 0.7, atol=1e-6)  # 1 - kappa
print(f"with the rotor's own slopes at the last profile: up to {fixed.loop.true.max():.2f}")

# %% [markdown]
# And here is the wrong sign. Torque over pitch has a maximum, where its slope is zero; to either
# side the slope has opposite signs. A learner that starts *on* the best constant pitch and is asked
# for less torque cannot know from its experiment which way to go. The loads grow, a guard sees them
# grow for three rotations, takes the best profile back and slows the learner down, and the game
# begins anew: the sawtooth on the right.

# %%
best = float(fixed.reference.best.profile[0])
start = fixed.reference.start_pitch
unlucky = learn(case, LearningSettings(learner="paper", rotations=20, start_pitch=best))
lucky = learn(case, LearningSettings(learner="paper", rotations=20))
plant = StaticPlant(tasks=WindTasks(case=case), wind=ConstantWind(speed=case.wind.speed))
pitches = np.deg2rad(np.linspace(np.rad2deg(best) - 5, np.rad2deg(best) + 5, 81))
stations = 3 * case.positions
torque = np.array([plant.passage(np.full(stations, beta), 0)[0].mean() for beta in pitches])
assert unlucky.rms.sum(axis=1).min() > 0.9 * unlucky.start.rms_sum  # nothing is gained
assert unlucky.rms.sum(axis=1).max() > 1.4 * unlucky.start.rms_sum
assert lucky.rms[-1].sum() < 0.05 * lucky.start.rms_sum

# %%
figure, (left_ax, right_ax) = plt.subplots(1, 2, figsize=(11.0, 4.0), layout="constrained")
left_ax.plot(np.rad2deg(pitches), 1e-6 * torque, "k")
left_ax.axhline(1e-6 * fixed.reference.setpoint, color="0.5", ls="--", label="set-point")
left_ax.axvline(np.rad2deg(best), color="C3", label="best constant pitch")
left_ax.axvline(np.rad2deg(start), color="C0", label="start with the set-point's torque")
left_ax.set_xlabel("constant pitch [deg]")
left_ax.set_ylabel("mean torque [MN m]")
left_ax.legend(frameon=False)
rotations = np.arange(1, 21)
for result, colour, label in (
    (unlucky, "C3", "from the best pitch"),
    (lucky, "C0", "from the set-point"),
):
    right_ax.semilogy(
        rotations, 1e-3 * result.rms.sum(axis=1), "o-", ms=3, color=colour, label=label
    )
    right_ax.axhline(1e-3 * result.start.rms_sum, color=colour, ls=":", lw=1)
right_ax.set_xlabel("rotation")
right_ax.set_ylabel("sum of RMS [kN m and kN]")
right_ax.set_title("fixed gain; dotted: where each began")
right_ax.legend(frameon=False)
plt.show()

# %% [markdown]
# ## 5. What the adaptive learner does otherwise
#
# It keeps a small model of each load at each position,
# $y \approx c + g^T d + \tfrac12 \sum_b h_b d_b^2$, tracks $c$ and $g$ with a Kalman filter, and
# minimises the *expected* RMS with the uncertainty of the slopes in it, under the limits of the
# actuators (`docs/learning.md`, section 6). Noise is averaged for as long as nothing surprises it;
# when innovations grow, as after a step of the wind, the covariance is raised and it moves again.
# Here are both with sensors whose noise is 2 % of each load's RMS at the start, three seeds each.
# The study of the documentation takes twenty.

# %%
loads_at_start = plant.rotation(np.full(stations, start), 0)
limits = ActuatorLimits.from_rate(
    lower=case.pitch_limits.lower,
    upper=case.pitch_limits.upper,
    pitch_rate=case.pitch_limits.pitch_rate,
    rotor_speed=case.rotor_speed,
    stations=stations,
)
curves = {}
for name, kind in (("fixed gain", FixedLearner), ("adaptive", AdaptiveLearner)):
    curves[name] = []
    for seed in (1, 2, 3):
        sensors = Sensors.with_share(0.02, loads_at_start.std(axis=1), seed=seed)
        learner = kind(
            layout=Layout(blades=3, positions=case.positions),
            limits=limits,
            start=start,
            setpoint=fixed.reference.setpoint,
        )
        record = run(plant, learner, rotations=20, sensors=sensors)
        curves[name].append(record.learning.ac_load / fixed.design.rms_weighted)
medians = {name: np.median(values, axis=0) for name, values in curves.items()}
print("median ratio to the design in rotations 11 to 20:")
for name, median in medians.items():
    print(f"  {name}: {median[10:].mean():.2f}")
assert medians["adaptive"][10:].mean() < medians["fixed gain"][10:].mean()

# %%
figure, ax = plt.subplots(figsize=(7.0, 4.0), layout="constrained")
for (name, values), colour in zip(curves.items(), ("C1", "C0"), strict=True):
    ax.semilogy(rotations, np.transpose(values), color=colour, lw=0.8, alpha=0.5)
    ax.semilogy(rotations, medians[name], "o-", ms=3, color=colour, label=f"{name}, median of 3")
ax.axhline(1.0, color="k", ls="--", label="designed with the model")
ax.set_xlabel("rotation")
ax.set_ylabel("sum of RMS over the design's [-]")
ax.legend(frameon=False)
plt.show()

# %% [markdown]
# ## 6. What no learner can know
#
# - A change of the wind that repeats with the rotor looks like the answer to the learner's own
#   steps.
# - A delay that it is not told of pairs each load with the wrong pitch (exercise 3). On a flexible
#   turbine the blade itself is such a delay: at 9 m/s the flapping blades of the NREL 5 MW answer 3
#   samples of 24 late. Told so, the adaptive learner leaves 13 % of the constant pitch's load
#   variation after 20 rotations, and 12 or 13 % in winds close by; with one sample less it leaves
#   20 to 31 % (`docs/learning.md`, section 9; not computed here).
# - Which valley it is in: the least RMS at a given torque has several local optima, and a learner
#   ends in one near its start.
# - Turbulence is not periodic. No profile that is held removes it: the same section finds 98 to 99
#   % of the total RMS left in turbulence of class B, where 20 to 33 % of the periodic part is left.

# %% [markdown]
# ## Exercises
#
# **Exercise 1 (quick).** Which $\kappa$ leaves at most a quarter of the noise's variance in a
# controllable load, and how many passages does it take to shrink the distance to 1 %? Check both
# with `noise_left` and `profiles_of`.
#
# **Exercise 2 (medium).** With damping $\nu > 0$ the factor becomes
# $1 - \kappa\,\sigma^2/(\sigma^2 + \nu)$ with the singular values $\sigma$ of $WD$. Show it
# numerically for `damping=0.5` (a share of the mean eigenvalue of $D^TW^2D$), and say which
# direction of the pitch learns most slowly.
#
# **Exercise 3 (medium).** Let the measurements lag by 3 of the 24 samples on the rotor of section
# 4. Compare an adaptive learner that is told (`delay=3`) with one that is not.
#
# **Exercise 4 (medium).** A gradient learner uses $\beta \leftarrow \beta - \alpha D^T W e$ in
# place of the pseudo-inverse. What is the largest $\alpha$ that converges, and how many passages
# does the best $\alpha$ need for 1 %, with the weights of the notebook and with unit weights?
#
# **Exercise 5 (hard).** A gain that shrinks as $1/j$ in passage $j$ averages over everything seen
# so far. Write such a learner for the affine plant, show that its noise dies away as $1/j$, and
# show what it does after the plant changes in passage 200.
