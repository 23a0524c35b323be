"""
Figure A2: power over pitch, for the gain schedule
==================================================

How power answers pitch at full load, with the wake held, and the straight lines from which the
regulators take their gain schedule: for all turbines of the catalogue that have structural data.
Computed while the site is built; the paper has rotors of its own project, which are not public.
"""

import numpy as np
from matplotlib.figure import Figure

from pitchopt.control import fit_sensitivity
from pitchopt.errors import InputError
from pitchopt.sim import DynamicTurbine, Operation
from pitchopt.turbines import load_turbine, names

figure = Figure(figsize=(7.0, 4.6), layout="constrained")
ax = figure.add_subplot()
for name in names():
    try:
        operation = Operation(DynamicTurbine(turbine=load_turbine(name)))
    except InputError:
        continue  # the paper's rotor of `biegel2011` has neither masses nor stiffnesses
    turbine, full = operation.dynamic.turbine, operation.full_load
    curve = operation.curve
    slope = turbine.rotor.blades * curve.rotor_speed * operation.frozen_slopes.torque
    pitch, values = curve.pitch[full], slope[full] / turbine.rated_power
    (line,) = ax.plot(np.degrees(pitch), np.radians(values), ".", label=name)
    at_zero, linear, _ = fit_sensitivity(pitch, values)
    ax.plot(np.degrees(pitch), np.radians(at_zero * (1.0 + linear * pitch)), color=line.get_color())
ax.set(xlabel="pitch [deg]", ylabel="dP/dbeta over rated power [1/deg]")
ax.legend(fontsize="small")
ax.grid(alpha=0.3)
