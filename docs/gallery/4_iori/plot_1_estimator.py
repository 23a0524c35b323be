"""
Figure 1: the estimator on one variable and one constraint
==========================================================

One design variable x, one parameter c that was frozen at 0, one limit on x that moves with c.  The
estimate holds the design where it was and takes the change of the Lagrangian.  Left the objective
couples x and c weakly, right strongly: there the best design leaves the limit, and the estimate
misses.  Computed while the site is built with the library's own estimator.
"""

import numpy as np
from matplotlib.figure import Figure

from pitchopt.sensitivity import PostOptimum

LIMIT, DC = 1.0, 1.0


def optimum(coupling, c):
    """Least 0.1 (x - 8)^2 + coupling c x under x <= 1 + c / 2, and where."""
    x = min(8.0 - 5.0 * coupling * c, LIMIT + 0.5 * c)
    return x, 0.1 * (x - 8.0) ** 2 + coupling * c * x


figure = Figure(figsize=(10.0, 4.2), layout="constrained")
for ax, coupling, title in zip(
    figure.subplots(1, 2, sharey=True),
    (0.1, 2.5),
    ("weak coupling", "strong coupling"),
    strict=True,
):
    x_old, z_old = optimum(coupling, 0.0)
    po = PostOptimum.from_functions(
        lambda x, c, k=coupling: 0.1 * (x[0] - 8.0) ** 2 + k * c * x[0],
        lambda x, c: np.array([x[0] - LIMIT - 0.5 * c]),
        x=[x_old],
        c=0.0,
        multipliers=[0.2 * (8.0 - x_old)],
    )
    estimate = po.estimate(DC)
    x_new, z_new = optimum(coupling, DC)
    x = np.linspace(-8.0, 4.0, 201)
    for c, style in ((0.0, "-"), (DC, "--")):
        ax.plot(
            x, 0.1 * (x - 8.0) ** 2 + coupling * c * x, "k", linestyle=style, label=f"c = {c:g}"
        )
        ax.axvline(LIMIT + 0.5 * c, color="tab:orange", linestyle=style)
    ax.plot(x_old, z_old, "o", color="tab:blue", label="optimum at c = 0")
    ax.plot(x_new, z_new, "k^", markersize=9, label="optimum at c = 1")
    ax.plot(
        LIMIT + 0.5 * DC, z_old + estimate.high_order, "o", mfc="w", mec="tab:red", label="estimate"
    )
    ax.set(xlabel="x", title=f"{title}: {z_new - z_old:+.2f}, estimated {estimate.high_order:+.2f}")
    print(f"{title}: broken {[part.name for part in estimate.broken] or 'nothing'}")
figure.axes[0].set_ylabel("objective")
figure.axes[0].legend(fontsize="small")
