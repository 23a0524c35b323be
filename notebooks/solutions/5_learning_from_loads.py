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
# # Solutions to 5. Learning from loads

# %%
import numpy as np
from matplotlib import pyplot as plt

from ilc import ActuatorLimits, AdaptiveLearner, FixedLearner, Layout, Sensors, run
from pitchopt import load_case
from pitchopt.studies.learning import ConstantWind, StaticPlant, WindTasks, reference

# %% [markdown]
# The plant and the helpers of the notebook.

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


# %% [markdown]
# ## Exercise 1
#
# $\kappa/(2-\kappa) \le 1/4$ gives $\kappa \le 2/5$. The distance after $j$ passages is $0.6^j$,
# below 1 % from $j = \ln 0.01/\ln 0.6 = 9.02$ on: ten passages.

# %%
kept = noise_left(0.4) / 3
profiles = profiles_of(AffinePlant(), new_learner(0.4), 60)
distance = np.abs(profiles - profiles[-1]).max(axis=1)
passages = int(np.argmax(distance <= 0.01 * distance[0]))
print(f"share of the variance that stays: {kept:.3f}; passages to 1 %: {passages}")
assert abs(kept - 0.25) < 0.01
assert passages == 10

# %% [markdown]
# Noise and speed hang on the one number $\kappa$.
#
# ## Exercise 2
#
# `damping` is $\nu$ over the mean eigenvalue of $D^TW^2D$. The eigenvectors of $HWD$ are the right
# singular vectors of $WD$, so the changes of the pitch shrink along each of them by its own factor.

# %%
plant, learner = AffinePlant(), new_learner(0.3, damping=0.5)
profiles = profiles_of(plant, learner, 200)
weighted = learner.weights[:, None] * plant.jacobian
position = 0
_, sigma, directions = np.linalg.svd(weighted[position])
nu = 0.5 * np.mean(sigma**2)
predicted = 1 - 0.3 * sigma**2 / (sigma**2 + nu)
along = (profiles - profiles[-1])[:, LAYOUT.index[position]] @ directions.T
measured = (np.abs(along[12]) / np.abs(along[2])) ** 0.1
for one in range(3):
    print(
        f"singular value {sigma[one] / 1e6:5.2f}e6, direction {np.round(directions[one], 2)}: "
        f"predicted {predicted[one]:.4f}, measured {measured[one]:.4f}"
    )
assert np.allclose(measured, predicted, atol=2e-3)

# %% [markdown]
# The direction with the smallest singular value learns most slowly: the collective one, all blades
# alike, which moves torque and thrust. The damping that spares the actuators makes the mean torque
# arrive last.
#
# ## Exercise 3

# %%
case = load_case("biegel2011")
tasks = WindTasks(case=case)
rotor = StaticPlant(tasks=tasks, wind=ConstantWind(speed=case.wind.speed))
goal = reference(tasks, max_power_loss=0.07)
stations = 3 * case.positions
limits = ActuatorLimits.from_rate(
    lower=case.pitch_limits.lower,
    upper=case.pitch_limits.upper,
    pitch_rate=case.pitch_limits.pitch_rate,
    rotor_speed=case.rotor_speed,
    stations=stations,
)
loads = {}
for told in (0, 3):
    learner = AdaptiveLearner(
        layout=Layout(blades=3, positions=case.positions),
        limits=limits,
        start=goal.start_pitch,
        setpoint=goal.setpoint,
        delay=told,
    )
    record = run(rotor, learner, rotations=15, sensors=Sensors(delay=3))
    loads[told] = record.learning.ac_load
    print(f"told {told}: sum of RMS after 15 rotations {record.learning.ac_load[-1]:.4g} N m")
start = rotor.passage(np.full(stations, goal.start_pitch), 0).std(axis=1).sum()
assert loads[3][-1] < 0.02 * start
assert loads[0].min() > 5 * loads[3].min()

# %%
figure, ax = plt.subplots(figsize=(6.5, 3.8), layout="constrained")
for told, values in loads.items():
    ax.semilogy(np.arange(1, 16), 1e-3 * values, "o-", ms=3, label=f"told a delay of {told}")
ax.axhline(1e-3 * start, color="k", ls="--", label="constant pitch at the start")
ax.set_xlabel("rotation")
ax.set_ylabel("sum of RMS [kN m and kN]")
ax.legend(frameon=False)
plt.show()

# %% [markdown]
# Three samples are 15 degrees of azimuth. A learner that is told them loses next to nothing; one
# that is not pairs loads with the wrong pitches and gains little.
#
# ## Exercise 4
#
# The distance obeys $d \leftarrow (I - \alpha D^TW^2D)\,d$, with eigenvalues $1 - \alpha\sigma^2$:
# it converges for $\alpha < 2/\sigma_1^2$, and fastest for $\alpha = 2/(\sigma_1^2 + \sigma_3^2)$
# with the factor $(c^2-1)/(c^2+1)$, $c$ the condition number of $WD$. One $\alpha$ serves all
# positions here, so the extremes over all of them count.

# %%
plant = AffinePlant()


def gradient_distances(weights, alpha, passages=400):
    """Largest distance from the fixed point over the first."""
    weighted = weights[:, None] * plant.jacobian
    means = np.append(SCALE[0], plant.offset.mean(axis=0)[1:])
    errors = weights * (plant.offset - means)
    fixed = -np.einsum("kbl,kl->kb", np.linalg.pinv(weighted), errors)
    beta, found = np.zeros_like(fixed), []
    for _ in range(passages):
        found.append(np.linalg.norm(beta - fixed))
        e = errors + np.einsum("klb,kb->kl", weighted, beta)
        beta = beta - alpha * np.einsum("klb,kl->kb", weighted, e)
    return np.array(found) / found[0]


for label, weights in (("weights of the notebook", SCALE[0] / SCALE), ("unit weights", np.ones(4))):
    sigma = np.linalg.svd(weights[:, None] * plant.jacobian, compute_uv=False)
    largest, least = sigma.max() ** 2, sigma.min() ** 2
    best, factor = 2 / (largest + least), (largest - least) / (largest + least)
    found = gradient_distances(weights, best)
    needed = int(np.argmax(found <= 0.01))
    print(f"{label}: alpha below {2 / largest:.3g}, best {best:.3g}")
    print(f"  worst factor {factor:.3f} a passage, {needed} passages to 1 %")
    assert np.all(found[1:50] <= factor * found[:49] * (1 + 1e-9) + 1e-12)
    assert gradient_distances(weights, 1.01 * 2 / largest)[-1] > 1
    assert gradient_distances(weights, 0.99 * 2 / largest)[-1] < 1

# %% [markdown]
# The gradient needs no inverse and is robust (any $D$ with an acute angle to the true one
# descends), but the spread of the singular values sets its pace. With weights that bring all loads
# to one size the spread is small and it does well; with unit weights it takes twice as long.
# The pseudo-inverse removes the spread, and pays with the margin $1/\operatorname{cond}(WD)$ for
# errors of the slopes.
#
# ## Exercise 5


# %%
def averaging_run(passages=400, change_at=200, fixed_rate=None, seed=0):
    """Weighted squared distance of the exact loads from the quiet ones, over sigma^2."""
    plant, learner, random = AffinePlant(), new_learner(1.0), np.random.default_rng(seed)
    profiles_of(plant, learner, 60)
    gain, beta = learner.gain, learner.profile[LAYOUT.index]
    quiet = plant.offset + np.einsum("klb,kb->kl", plant.jacobian, beta)
    shift, found = np.zeros_like(quiet), []
    for j in range(1, passages + 1):
        if j == change_at:  # the wind changes: other loads at the same pitch
            shift = np.einsum("klb,b->kl", plant.jacobian, [0.02, -0.01, 0.01])
        exact = plant.offset + shift + np.einsum("klb,kb->kl", plant.jacobian, beta)
        off = learner.weights * (exact - quiet)
        found.append((off**2).sum(axis=1).mean() / SIGMA**2)
        told = off + SIGMA * random.normal(size=off.shape)
        rate = 1 / (j + 1) if fixed_rate is None else fixed_rate
        beta = beta - rate * np.einsum("kbl,kl->kb", gain, told)
    return np.array(found)


runs = {
    name: np.mean([averaging_run(fixed_rate=rate, seed=s) for s in range(20)], axis=0)
    for name, rate in (("1/(j+1)", None), ("0.3", 0.3))
}
j = np.arange(1, 401)
before = slice(20, 190)
theory = 3 * (j - 1) / j**2
assert np.abs(runs["1/(j+1)"][before] / theory[before] - 1).mean() < 0.05
assert abs(runs["0.3"][before].mean() / (3 * 0.3 / 1.7) - 1) < 0.05
print(f"100 passages after the change: {runs['1/(j+1)'][299]:.3g} and {runs['0.3'][299]:.3g}")

# %%
figure, ax = plt.subplots(figsize=(7.0, 4.0), layout="constrained")
for name, values in runs.items():
    ax.loglog(j, values, label=rf"$\kappa$ = {name}")
ax.loglog(j[1:198], theory[1:198], "k:", label=r"$3(j-1)/j^2$")
ax.set_xlabel("passage j, with a change of the loads in passage 200")
ax.set_ylabel(r"weighted variance of the loads over $\sigma^2$ [-]")
ax.legend(frameon=False)
plt.show()

# %% [markdown]
# Starting from the fixed point, gains $1/(j+1)$ average the noise of all passages: in passage $j$ the pitch is $1/j$ times the sum of $j - 1$ noise terms, which leaves the variance $3(j-1)/j^2$ in the loads. After the change in passage 200 that same gain is 0.005 and the loads take hundreds of passages to come back, while the fixed gain is there within ten. The adaptive learner of `ilc` does both, because its gain follows from a covariance that grows again when it is surprised.
