"""
Figure 5: mean torque against load variation
============================================

The paper draws one curve for each constant pitch from which its search starts.  Both are computed
while the site is built: first the curve of this library, which is one for all starts and carries a
bound (``examples/03_tradeoff_curve.py``); then what single starts give.
"""

import numpy as np
from matplotlib.figure import Figure

from pitchopt.cases import load_case
from pitchopt.design import LoadWeights, Objective, solve_local, tradeoff
from pitchopt.plotting import tradeoff_figure

case = load_case("biegel2011")
task = case.task()
result = tradeoff(task)
figure = tradeoff_figure(result, weights_name="unit", title=case.name)
for point in result.points:
    if point.kind == "max_power_loss":
        print(f"{100 * result.loss(point):.1f} % lost: RMS cut {100 * result.cut(point):.1f} %")

# %%
# Single starts from constant pitches, as in the paper's figure: each line is one start, followed
# along the price of load variation without a look at the others.  What is printed is how much of
# the largest mean torque the best of them lies above the curve's own points, in the objective and
# at their prices.

weights = LoadWeights()
problem = task.problem()
curves = problem.curves
starts = np.linspace(curves.lower.max(), curves.upper.min(), 7)[:-1]
points = [point for point in result.points if point.kind == "mu"][::2]
lead = []
single = Figure(figsize=(7.0, 4.6), layout="constrained")
ax = single.add_subplot()
for start in starts:
    torque, rms = [], []
    for point in points:
        objective = Objective.tradeoff(point.mu, weights)
        found = solve_local(problem, objective, np.full(curves.stations, start))
        loads = curves.evaluate(found.profile)
        torque.append(loads.mean[0])
        rms.append(loads.rms.sum())
        lead.append(torque[-1] - point.mu * rms[-1] - point.objective)
    ax.plot(np.array(rms) / 1e3, np.array(torque) / 1e6, ".-", label=f"{np.degrees(start):.1f} deg")
print(f"{100 * max(lead) / result.power_max.mean_torque:.4f} %")
ax.plot(
    [p.loads.rms.sum() / 1e3 for p in result.points],
    [p.mean_torque / 1e6 for p in result.points],
    "k+",
    markersize=8,
    label="curve of this library",
)
ax.set(xlabel="sum of RMS load variations [kN m]", ylabel="mean torque [MN m]")
ax.legend(title="constant pitch to start from", fontsize="small")
ax.grid(alpha=0.3)
