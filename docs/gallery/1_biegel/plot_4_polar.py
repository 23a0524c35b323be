"""
Figure 4: lift and drag, and the fits that make torque concave
==============================================================

The airfoil of ``biegel2011`` with its best concave lift and convex drag between two angles of
attack. Computed while the site is built (``examples/02_polar_fit.py``).  The paper does not name
its airfoil; the NACA 64-618 of the NREL 5 MW stands in.
"""

import numpy as np
from matplotlib.figure import Figure

from pitchopt.aero import fit_polar
from pitchopt.cases import load_case
from pitchopt.plotting import plot_polar_fit

polar = load_case("biegel2011").rotor().blade.polars[-1]
fit = fit_polar(polar, (np.deg2rad(-5.0), polar.stall_angle()), segments=40)
figure = Figure(figsize=(6.8, 5.0), layout="constrained")
plot_polar_fit(polar, fit, ax=figure.add_subplot())
print(f"largest error in lift {fit.cl_error:.4f}, in drag {fit.cd_error:.4f}")
