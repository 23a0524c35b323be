"""
Figures 6 and 7: pitch profiles and the loads that follow
=========================================================

Power maximum, the design that loses 3 % of torque, and the best constant pitch over the paper's
rotor position.  Computed while the site is built (``examples/04_profiles_and_loads.py``).
"""

from pitchopt.cases import load_case
from pitchopt.design import constant, design, power_max
from pitchopt.plotting import loads_figure, profiles_figure

task = load_case("biegel2011").task()
best = constant(task)
shown = {
    "power maximum": power_max(task, reference=best),
    "3 % torque lost": design(task, max_power_loss=0.03, certify=False),
}
profiles = profiles_figure(shown, title="figure 6")

# %%
# The dip of one blade is its passage of the tower.

loads = loads_figure({**shown, "constant": best}, title="figure 7")
for label, found in {**shown, "constant": best}.items():
    print(f"{label:<16} {found.mean_torque:.4g} N m, sum of RMS {found.rms_sum:.4g}")
