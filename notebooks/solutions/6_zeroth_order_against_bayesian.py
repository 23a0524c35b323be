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
# # Solutions to 6. Zeroth-order against Bayesian

# %%
import numpy as np
from matplotlib import pyplot as plt

from pitchopt.tuning import Bayesian, Parameter, Space, ZerothOrder, run_study

# %% [markdown]
# ## Exercise 1
#
# $\mu^* \propto \sigma^{1/3}$: ten times less noise shrinks the radius by $10^{1/3} = 2.15$. The
# least squared error is $\frac34\,\sigma^2/\mu^{*2} \propto \sigma^{4/3}$, so that the RMS error
# falls by $10^{2/3} = 4.64$.

# %%


def forrester(x):
    return (6 * x - 2) ** 2 * np.sin(12 * x - 4)


z, h = 0.9, 2e-3
slope = (forrester(z + 1e-5) - forrester(z - 1e-5)) / 2e-5
third = (
    forrester(z + 2 * h) - 2 * forrester(z + h) + 2 * forrester(z - h) - forrester(z - 2 * h)
) / (2 * h**3)
rng = np.random.default_rng(0)
least = {}
for sigma in (0.5, 0.05):
    balanced = (3 * sigma / abs(third)) ** (1 / 3)
    noise = sigma * rng.normal(size=(2, 100000))
    found = (forrester(z + balanced) + noise[0] - forrester(z - balanced) - noise[1]) / (
        2 * balanced
    )
    least[sigma] = balanced, np.sqrt(np.mean((found - slope) ** 2))
    print(f"noise {sigma}: radius {balanced:.4f}, RMS error {least[sigma][1]:.3f}")
assert np.isclose(least[0.5][0] / least[0.05][0], 10 ** (1 / 3))
assert np.isclose(least[0.5][1] / least[0.05][1], 10 ** (2 / 3), rtol=0.06)

# %% [markdown]
# The ratio of the errors misses 4.64 by a few per cent: at the larger radius the fifth derivative
# counts as well. Even with a tenth of the noise the gradient is only 4.6 times as good, which is
# why more runs for each sample buy so little.
#
# ## Exercise 2

# %%
plane = Space([Parameter(name="x1", low=-5.0, high=10.0), Parameter(name="x2", low=0.0, high=15.0)])
BUDGET, REPEATS, NOISE = 30, 10, 2.0


def branin(x):
    bend = x[1] - 5.1 / (4 * np.pi**2) * x[0] ** 2 + 5 / np.pi * x[0] - 6
    return bend**2 + 10 * (1 - 1 / (8 * np.pi)) * np.cos(x[0]) + 10


observed, true = [], []
for repeat in range(200):
    noise = NOISE * np.random.default_rng([7, repeat]).normal(size=BUDGET)
    points = np.random.default_rng([9, repeat]).uniform(plane.lower, plane.upper, (BUDGET, 2))
    costs = np.array([branin(p) for p in points])
    chosen = np.argmin(costs + noise)
    observed.append((costs + noise)[chosen])
    true.append(costs[chosen])
flattery = np.subtract(true, observed)
error = flattery.std(ddof=1) / np.sqrt(flattery.size)
print(f"observed {np.mean(observed):.2f}, true {np.mean(true):.2f} on average over 200 repeats")
print(f"the observed value is {flattery.mean():.2f} +- {error:.2f} too low")
assert flattery.mean() > 5 * error

# %% [markdown]
# The lowest of many noisy values is low because of its point *and* because of its noise. A method
# that tries more distinct points near the minimum flatters itself more, so that comparing observed
# values would favour it.
#
# ## Exercise 3

# %%
square = Space([Parameter(name=name, low=0.0, high=1.0) for name in ("x1", "x2")])
hessian, linear = np.array([[3.0, 1.0], [1.0, 2.0]]), np.array([-2.0, -1.0])
start, radius = np.array([0.4, 0.6]), 0.05
expected = radius / 4 * np.hypot((hessian[0, 0] - hessian[1, 1]) / 2, hessian[0, 1])
errors = []
for seed in range(12):
    tuner = ZerothOrder(square, start=start, radius=radius, samples=3, stages=1, seed=seed)
    run_study(
        lambda x: 0.5 * x @ hessian @ x + linear @ x, tuner, evaluations=tuner.most_evaluations
    )
    errors.append(tuner.records[0].gradient - (hessian @ start + linear) / 2)
lengths = np.linalg.norm(errors, axis=1)
print(f"lengths of the errors {lengths.min():.6f} to {lengths.max():.6f}, formula {expected:.6f}")
assert np.allclose(lengths, expected, rtol=1e-9)

# %%
figure, ax = plt.subplots(figsize=(4.6, 4.2), layout="constrained")
circle = np.linspace(0, 2 * np.pi, 200)
ax.plot(expected * np.cos(circle), expected * np.sin(circle), "k--", label="formula")
ax.plot(*np.transpose(errors), "o", label="twelve first angles")
ax.set_aspect("equal")
ax.set_xlabel("error of the first component [-]")
ax.set_ylabel("error of the second component [-]")
ax.legend(frameon=False, loc="center")
plt.show()

# %% [markdown]
# The error has one length and every direction, so over random first angles it averages out. One
# sample more, $J = 4$, removes it.
#
# ## Exercise 4


# %%
def valley(x):
    return (x[0] - 0.3) ** 2 + 5 * (x[1] - 0.6) ** 2


def anytime(tuner, noise, function):
    handed = []
    for k in range(BUDGET):
        asked = tuner.ask()
        if asked:
            tuner.tell(asked[0], function(asked[0].x) + noise[k])
        handed.append(function(tuner.best().x))
    return np.array(handed)


ends = {"zeroth-order": [], "Bayesian": []}
for repeat in range(REPEATS):
    start = np.random.default_rng([8, repeat]).uniform(size=2)
    noise = 0.02 * np.random.default_rng([7, repeat]).normal(size=BUDGET)
    zeroth = ZerothOrder(square, start=start, samples=3, stages=20, seed=repeat)
    ends["zeroth-order"].append(anytime(zeroth, noise, valley)[-1])
    bayes = Bayesian(square, start=start, seed=repeat)
    ends["Bayesian"].append(anytime(bayes, noise, valley)[-1])
for name, values in ends.items():
    print(
        f"{name:13s} quartiles after {BUDGET}: {np.round(np.percentile(values, [25, 50, 75]), 4)}"
    )
wins = int(np.sum(np.less(ends["Bayesian"], ends["zeroth-order"])))
print(f"the Bayesian tuner ends lower in {wins} of {REPEATS}")
assert max(np.median(v) for v in ends.values()) < 0.05

# %% [markdown]
# On a quadratic the zeroth-order tuner has no wrong valley to end in, and both come within about
# the noise of the minimum. The model still helps, since a smooth process averages the noise over
# all samples while a gradient sees four of them.
#
# ## Exercise 5
#
# Simultaneous perturbation (SPSA): in step $k$ one random direction $\Delta$ of signs, two samples,
# $g = \frac{C(x+c_k\Delta) - C(x-c_k\Delta)}{2c_k}\Delta$, and $x \leftarrow x - a_k g$ with
# $a_k = a/(k+1+A)^{0.602}$, $c_k = c/(k+1)^{0.101}$. Steps are cut at 0.2 of the range; $a$ makes
# the first one 0.15 of it.


# %%
def spsa(start, repeat):
    noise = iter(NOISE * np.random.default_rng([7, repeat]).normal(size=BUDGET))
    random = np.random.default_rng([10, repeat])
    u = plane.to_unit(plane.point(start))
    handed, size, lowest = [], None, None

    def sample(v):
        nonlocal lowest
        point = plane.from_unit(v)
        seen = branin(point) + next(noise)
        if lowest is None or seen < lowest[0]:
            lowest = seen, branin(point)
        handed.append(lowest[1])
        return seen

    for k in range(BUDGET // 2):
        c = 0.05 / (k + 1) ** 0.101
        delta = random.choice([-1.0, 1.0], size=2)
        high, low = np.clip(u + c * delta, 0, 1), np.clip(u - c * delta, 0, 1)
        slope = (sample(high) - sample(low)) / (2 * c)
        if size is None:
            size = 0.15 / max(abs(slope), 1e-9) * 4**0.602
        step = np.clip(size / (k + 4) ** 0.602 * slope * delta, -0.2, 0.2)
        u = np.clip(u - step, 0, 1)
    return np.array(handed)


curves = {"zeroth-order": [], "SPSA": []}
for repeat in range(REPEATS):
    start = np.random.default_rng([8, repeat]).uniform(plane.lower, plane.upper)
    noise = NOISE * np.random.default_rng([7, repeat]).normal(size=BUDGET)
    zeroth = ZerothOrder(plane, start=start, samples=3, stages=20, seed=repeat)
    curves["zeroth-order"].append(anytime(zeroth, noise, branin))
    curves["SPSA"].append(spsa(start, repeat))
assert all(np.shape(values) == (REPEATS, BUDGET) for values in curves.values())
for name, values in curves.items():
    quartiles = np.percentile(np.array(values)[:, -1] - 0.397887, [25, 50, 75])
    print(f"{name:13s} above the minimum after {BUDGET}: quartiles {np.round(quartiles, 2)}")

# %%
figure, ax = plt.subplots(figsize=(7.0, 4.2), layout="constrained")
count = np.arange(1, BUDGET + 1)
for (name, values), colour in zip(curves.items(), ("C1", "C4"), strict=True):
    low, middle, high = np.percentile(np.array(values) - 0.397887, [25, 50, 75], axis=0)
    ax.fill_between(count, low, high, color=colour, alpha=0.2, lw=0)
    ax.semilogy(count, middle, color=colour, label=name)
ax.set_xlabel("evaluations")
ax.set_ylabel("true cost above the minimum [-]")
ax.legend(frameon=False)
plt.show()

# %% [markdown]
# Two evaluations a step in any number of dimensions make SPSA cheap; in two dimensions that is no
# advantage over three or four. Your own gains $a$, $c$ may do better: try them on other repeats
# than those you judge by.
