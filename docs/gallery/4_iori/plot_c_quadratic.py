"""
Figures C1 to C5: quadratic programs on which assumptions break
===============================================================

Planes of the designs and both estimates beside the true optimum, for three families of programs.
Solved in full while the site is built (``examples/27_sensitivity_quadratic.py``).
"""

import numpy as np
from matplotlib.figure import Figure

from pitchopt.plotting import estimates_figure, plot_design_plane, plot_estimates
from pitchopt.studies.sensitivity import (
    active_set_program,
    coupling_programs,
    estimated_curve,
    linearity_programs,
)

dc = np.round(np.linspace(0.0, 1.0, 51), 12)


def planes(curves, at):
    """Designs in their plane, one panel a program."""
    page = Figure(figsize=(1.0 + 4.2 * len(curves), 4.2), layout="constrained")
    for ax, curve in zip(page.subplots(1, len(curves)), curves, strict=True):
        plot_design_plane(curve, at=at, ax=ax).set_title(curve.name)
    return page


# %%
# C1 and C2: an objective that curves in x.

linearity = [estimated_curve(program, dc) for program in linearity_programs()]
figure_c1 = planes(linearity, (0.0, 0.5, 1.0))
figure_c2 = estimates_figure(linearity)

# %%
# As printed, b = 20 and b = 5 do not differ: their first constraint binds with a multiplier of
# zero or not at all (:doc:`/papers`).  With one half before P they do, as the paper's text says:

halved = [estimated_curve(program.halved(), dc) for program in linearity_programs()]
figure_c2_halved = estimates_figure(halved)

# %%
# C3 and C4: an objective that couples x2 and c.

coupling = [estimated_curve(program, dc) for program in coupling_programs()]
figure_c3 = planes(coupling, (0.0, 0.1, 0.2))
figure_c4 = estimates_figure(coupling)

# %%
# C5: a second constraint becomes active on the way.

active = estimated_curve(active_set_program(), dc)
figure_c5 = Figure(figsize=(10.0, 4.2), layout="constrained")
left, right = figure_c5.subplots(1, 2)
plot_design_plane(active, ax=left)
plot_estimates(active, ax=right).set_title("")
